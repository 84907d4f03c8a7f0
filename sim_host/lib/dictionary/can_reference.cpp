// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <initializer_list>
#include <vector>

#include "device_description.hpp"
#include "markdown.hpp"

namespace trackservo::dictionary {
namespace {

// A table of the page.
struct Group {
  std::string title;
  std::vector<od_object> rows;
};

// The default PDO that carries an object: "TPDO3".
using DefaultPdos = std::map<std::pair<std::uint16_t, std::uint8_t>, std::string>;

bool is_one_of(std::uint16_t index, std::initializer_list<std::uint16_t> list) {
  return std::find(list.begin(), list.end(), index) != list.end();
}

std::string drive_group(std::uint16_t index) {
  if (index <= 0x6061 || index == 0x6502) {
    return "State and modes";
  }
  if (is_one_of(index, {0x607D, 0x6081, 0x6083, 0x6084, 0x6085, 0x60A4, 0x60C2})) {
    return "Profiles, limits and interpolation";
  }
  if (is_one_of(index, {0x607C, 0x6098, 0x6099, 0x609A})) {
    return "Homing";
  }
  if (is_one_of(index, {0x60A8, 0x60A9})) {
    return "Units";
  }
  if (is_one_of(index, {0x607A, 0x60F4}) || (index >= 0x6062 && index <= 0x6068)) {
    return "Position";
  }
  if (is_one_of(index, {0x607F, 0x60B1, 0x60FF}) || (index >= 0x6069 && index <= 0x6070)) {
    return "Velocity";
  }
  return "Torque";
}

std::string communication_group(std::uint16_t index) {
  constexpr const char *kPdoGroups[] = {"RPDO communication", "RPDO mapping", "TPDO communication", "TPDO mapping"};
  if (index < 0x1400) {
    return "Communication";
  }
  return index < 0x1800 ? kPdoGroups[index >= 0x1600 ? 1 : 0] : kPdoGroups[index >= 0x1A00 ? 3 : 2];
}

std::string type_name(const od_entry& entry) {
  switch (static_cast<od_type>(entry.type)) {
    case OD_BOOLEAN:
      return "BOOL";
    case OD_INTEGER8:
      return "I8";
    case OD_INTEGER16:
      return "I16";
    case OD_INTEGER32:
      return "I32";
    case OD_UNSIGNED8:
      return "U8";
    case OD_UNSIGNED16:
      return "U16";
    case OD_UNSIGNED32:
      return "U32";
    case OD_UNSIGNED64:
      return "U64";
    case OD_REAL32:
      return "REAL32";
    case OD_VISIBLE_STRING:
      return "STRING";
    case OD_DOMAIN:
      break;
  }
  return "DOMAIN";
}

// Identifiers, mappings and bit fields are written in hexadecimal.
bool is_hexadecimal(const od_entry& entry) {
  return entry.unit[0] == '\0' && (entry.type == OD_UNSIGNED16 || entry.type == OD_UNSIGNED32) &&
         (entry.high.i == 0xFFFF || entry.high.i >= 0x7FFFFF || entry.access == OD_CONST);
}

std::string number(const od_entry& entry, od_number value) {
  if (entry.type == OD_REAL32) {
    return fmt::format("{:g}", value.f);
  }
  if (entry.type == OD_UNSIGNED64) {
    return fmt::format("0x{:X}", static_cast<std::uint64_t>(value.i));
  }
  return is_hexadecimal(entry) ? fmt::format("0x{:X}", value.i) : fmt::format("{}", value.i);
}

std::string range_of(const od_entry& entry) {
  const bool has_limits = entry.type != OD_VISIBLE_STRING && entry.type != OD_DOMAIN && entry.type != OD_UNSIGNED64;
  if (entry.access != OD_RW || !has_limits) {
    return "";
  }
  const int bits = 8 * entry.bytes;
  const bool whole_type = entry.type != OD_REAL32 && entry.high.i - entry.low.i + 1 == std::int64_t{1} << bits;
  return whole_type ? "any" : number(entry, entry.low) + " … " + number(entry, entry.high);
}

// The page is committed, so it cannot contain the commit that was built; 1009 is that of the device.
bool is_of_device(const od_entry& entry) { return (entry.index == 0x3030 && entry.sub == 3) || entry.index == 0x1009; }

std::string default_of(const od_object& object) {
  const od_entry& entry = *object.entry;
  const bool plus_id = (entry.flags & OD_NODE_ID) != 0;
  if (is_of_device(entry)) {
    return "";
  }
  if (entry.type == OD_VISIBLE_STRING) {
    return entry.preset.text == nullptr ? "" : fmt::format("\"{}\"", entry.preset.text);
  }
  if (entry.type == OD_DOMAIN || (entry.access == OD_RO && !plus_id)) {
    return "";
  }
  return number(entry, od_default(&object)) + (plus_id ? " + id" : "");
}

// "azimuth; pitch" where the axes differ.
std::string defaults_of(const od_object& object, const SortedObjects& objects) {
  std::string own = default_of(object);
  const auto pitch =
      objects.find({static_cast<std::uint16_t>(od_index(&object) + AXIS_INDEX_SHIFT), object.entry->sub});
  if (pitch == objects.end() || pitch->second.entry != object.entry) {
    return own;
  }
  const std::string other = default_of(pitch->second);
  return other == own ? own : own + "; " + other;
}

std::string pdo_of(const od_object& object, const DefaultPdos& pdos) {
  const auto found = pdos.find({od_index(&object), object.entry->sub});
  if (found != pdos.end()) {
    return found->second;
  }
  std::string text = (object.entry->flags & OD_RPDO) != 0 ? "R" : "";
  return text + ((object.entry->flags & OD_TPDO) != 0 ? "T" : "");
}

DefaultPdos default_pdos(const SortedObjects& objects) {
  DefaultPdos pdos;
  for (const auto& [key, object] : objects) {
    const std::uint16_t kind = key.first & 0xFFFC;
    if ((kind == 0x1600 || kind == 0x1A00) && key.second != 0 && object.entry->preset.i != 0) {
      const auto entry = static_cast<std::uint32_t>(object.entry->preset.i);
      pdos[{static_cast<std::uint16_t>(entry >> 16), static_cast<std::uint8_t>(entry >> 8)}] =
          fmt::format("{}PDO{}", kind == 0x1600 ? "R" : "T", (key.first & 3) + 1);
    }
  }
  return pdos;
}

// The group that an object belongs to; a RECORD without a group in the standard is its own group.
std::string group_of(const od_object& object, const std::string& record) {
  const std::uint16_t index = object.entry->index;
  if (index < 0x2000) {
    return communication_group(index);
  }
  return index >= 0x6000 ? drive_group(index) : fmt::format("{:04X} {}", index, record);
}

// In the order of their first rows. The second axis repeats the table of the first.
std::vector<Group> groups_of(const SortedObjects& objects) {
  std::vector<Group> groups;
  std::string record;
  for (const auto& [key, object] : objects) {
    if (object.part->shift != 0) {
      continue;
    }
    record = key.second == 0 ? object.entry->name : record;
    const std::string title = group_of(object, record);
    auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.title == title; });
    if (group == groups.end()) {
      group = groups.insert(groups.end(), Group{title, {}});
    }
    group->rows.push_back(object);
  }
  return groups;
}

// A bar would end the cell.
std::string cell(const char *text) {
  std::string result;
  for (; *text != '\0'; ++text) {
    result += *text == '|' ? std::string("\\|") : std::string(1, *text);
  }
  return result;
}

std::string print_row(const od_object& object, const SortedObjects& objects, const DefaultPdos& pdos) {
  const od_entry& entry = *object.entry;
  const bool record = (entry.flags & OD_RECORD) != 0;
  const char *mark = record ? "**" : "";
  const std::string stored = (entry.flags & OD_STORED) != 0 ? ", stored" : "";
  const std::string guarded = (entry.flags & OD_GUARDED) != 0 ? ", guarded" : "";
  return fmt::format("| {:04X} | {} | {}{}{} | {} | {}{}{} | {} | {} | {} | {} | {} |\n", od_index(&object),
                     static_cast<unsigned>(entry.sub), mark, entry.name, mark, type_name(entry), access_name(entry),
                     stored, guarded, entry.unit, range_of(entry), defaults_of(object, objects), pdo_of(object, pdos),
                     cell(entry.help));
}

std::string print_group(const Group& group, const SortedObjects& objects, const DefaultPdos& pdos) {
  std::string text = fmt::format(
      "## {}\n\n| index | sub | name | type | access | unit | range | default | PDO | meaning |\n"
      "|---|---|---|---|---|---|---|---|---|---|\n",
      group.title);
  for (const od_object& object : group.rows) {
    text += print_row(object, objects, pdos);
  }
  return text + "\n";
}

}  // namespace

std::string print_can_reference(const object_dictionary& dictionary, const DeviceInfo& info) {
  const SortedObjects objects = sorted_objects(dictionary);
  const DefaultPdos pdos = default_pdos(objects);
  std::string text = fmt::format(
      "# CAN objects\n\n"
      "{}: every object of the node. The build prints this page from the object dictionary.\n"
      "Do not edit it: run `tools/update-docs dictionary`. How to use the objects: [can.md](can.md).\n\n"
      "- Objects 2000 to 2FFF and from 6000 on belong to azimuth. Pitch has the same objects 0x800 higher:\n"
      "  Kp is 2000:1 and 2800:1, the controlword 6040 and 6840. Objects 1xxx and 3xxx exist once.\n"
      "- Access `stored`: 0x1010 saves the value, 0x1011 restores its default. `guarded`: can be written only\n"
      "  while 0x3040 is open. `+ id`: the node id is added.\n"
      "- PDO: the default PDO that carries the object. R or T: the object can be mapped into an RPDO or TPDO.\n"
      "- Unit: the unit of one count: 606C = 17453 with unit 1e-6 rad/s is 1 deg/s.\n"
      "- Default: the value with which the device starts while nothing is stored; `765; 319`: of azimuth and of\n"
      "  pitch. `sim_host serve` starts with the values of its plant file: those of another plant, and the times of\n"
      "  its holding brakes (2060:24, 2060:25).\n\n",
      info.description);
  const std::vector<Group> groups = groups_of(objects);
  std::vector<std::string> titles;
  titles.reserve(groups.size());
  for (const Group& group : groups) {
    titles.push_back(group.title);
  }
  text += contents_of(titles) + "\n";
  for (const Group& group : groups) {
    text += print_group(group, objects, pdos);
  }
  text.pop_back();
  return text;
}

}  // namespace trackservo::dictionary
