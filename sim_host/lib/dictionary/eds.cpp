// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "device_description.hpp"

extern "C" {
#include "canopen/bus_settings.h"
}

namespace trackservo::dictionary {
namespace {

constexpr int kVar = 7;
constexpr int kArray = 8;
constexpr int kRecord = 9;
constexpr int kDomain = 2;

const char *access_of(const od_entry& entry) {
  const bool received = (entry.flags & OD_RPDO) != 0;
  const bool transmitted = (entry.flags & OD_TPDO) != 0;
  switch (static_cast<od_access>(entry.access)) {
    case OD_CONST:
      return "const";
    case OD_RO:
      return "ro";
    case OD_WO:
      return "wo";
    case OD_RW:
      break;
  }
  // rww and rwr give the direction of PDO in which the object may be mapped.
  return received && !transmitted ? "rww" : transmitted && !received ? "rwr" : "rw";
}

bool is_integer(const od_entry& entry) {
  return entry.type != OD_REAL32 && entry.type != OD_VISIBLE_STRING && entry.type != OD_DOMAIN;
}

// The number of a default or limit: decimal with a sign where it has one, otherwise hexadecimal.
std::string number_of(const od_entry& entry, od_number number) {
  if (is_signed(entry)) {
    return fmt::format("{}", number.i);
  }
  return fmt::format("0x{:X}", static_cast<std::uint64_t>(number.i));
}

std::string eds_default_of(const od_object& object) {
  const od_entry& entry = *object.entry;
  if (entry.type == OD_VISIBLE_STRING) {
    return entry.preset.text == nullptr ? "" : entry.preset.text;
  }
  if (!is_integer(entry)) {
    return "";
  }
  const std::string number = number_of(entry, od_default(&object));
  return (entry.flags & OD_NODE_ID) != 0 ? "$NODEID+" + number : number;
}

bool has_limits(const od_entry& entry) {
  return is_integer(entry) && entry.type != OD_UNSIGNED64 && entry.type != OD_BOOLEAN && entry.access != OD_CONST &&
         (entry.flags & (OD_NODE_ID | OD_RECORD)) == 0;
}

std::string print_variable(const std::string& section, const std::string& name, const od_object& object) {
  const od_entry& entry = *object.entry;
  const bool mappable = (entry.flags & (OD_RPDO | OD_TPDO)) != 0;
  std::string text =
      fmt::format("[{}]\nParameterName={}\nObjectType=0x{:X}\nDataType=0x{:04X}\nAccessType={}\n", section, name,
                  entry.type == OD_DOMAIN ? kDomain : kVar, static_cast<unsigned>(entry.type), access_of(entry));
  const std::string preset = eds_default_of(object);
  if (!preset.empty()) {
    text += fmt::format("DefaultValue={}\n", preset);
  }
  if (has_limits(entry)) {
    text += fmt::format("LowLimit={}\nHighLimit={}\n", number_of(entry, entry.low), number_of(entry, entry.high));
  }
  return text + fmt::format("PDOMapping={}\n\n", mappable ? 1 : 0);
}

// One index: a variable, or the head of an ARRAY or RECORD and its sub-indices.
std::string print_object(const std::vector<od_object>& rows) {
  const od_object& head = rows.front();
  const std::string section = fmt::format("{:04X}", od_index(&head));
  if ((head.entry->flags & OD_RECORD) == 0) {
    return print_variable(section, full_name(head), head);
  }
  const int kind = (head.entry->flags & OD_ARRAY) != 0 ? kArray : kRecord;
  std::string text = fmt::format("[{}]\nParameterName={}\nObjectType=0x{:X}\nSubNumber={}\n\n", section,
                                 full_name(head), kind, rows.size());
  for (const od_object& row : rows) {
    const std::string name = row.entry->sub == 0 ? "Highest sub-index supported" : full_name(row);
    text += print_variable(fmt::format("{}sub{:X}", section, row.entry->sub), name, row);
  }
  return text;
}

// Those that LSS can set.
std::string bit_rates() {
  std::string text;
  for (const int kbit_s : {10, 20, 50, 125, 250, 500, 800, 1000}) {
    const std::uint8_t index = bus_index_of_kbit_s(static_cast<std::uint16_t>(kbit_s));
    text += fmt::format("BaudRate_{}={}\n", kbit_s, bus_kbit_s_of_index(index) == kbit_s ? 1 : 0);
  }
  return text;
}

std::string print_head(const DeviceInfo& info, const SortedObjects& objects) {
  const auto constant = [&](std::uint8_t sub) {
    const auto found = objects.find({0x1018, sub});
    return found == objects.end() ? 0 : found->second.entry->preset.i;
  };
  const auto count = [&](std::uint16_t first) {
    return std::count_if(objects.begin(), objects.end(), [first](const auto& object) {
      return object.first.second == 0 && object.first.first >= first && object.first.first < first + 0x200;
    });
  };
  std::string text = fmt::format(
      "[FileInfo]\nFileName={0}\nFileVersion=1\nFileRevision=1\nEDSVersion=4.0\nDescription={1}\nCreationTime={2}\n"
      "CreationDate={3}\nCreatedBy={4}\nModificationTime={2}\nModificationDate={3}\nModifiedBy={4}\n\n",
      info.file_name, info.description, info.time, info.date, info.vendor);
  text += fmt::format(
      "[DeviceInfo]\nVendorName={}\nVendorNumber=0x{:X}\nProductName={}\nProductNumber=0x{:X}\nRevisionNumber=0x{:X}\n"
      "OrderCode={}\n{}SimpleBootUpMaster=0\nSimpleBootUpSlave=1\nGranularity=8\n"
      "DynamicChannelsSupported=0\nGroupMessaging=0\nNrOfRXPDO={}\nNrOfTXPDO={}\nLSS_Supported=1\n\n",
      info.vendor, constant(1), info.product, constant(2), constant(3), info.product, bit_rates(), count(0x1400),
      count(0x1800));
  text += "[DummyUsage]\nDummy0001=0\n";
  for (int i = 2; i <= 7; ++i) {
    text += fmt::format("Dummy{:04d}=1\n", i);
  }
  return text +
         "\n[Comments]\nLines=2\nLine1=Generated from the object dictionary table; do not edit.\nLine2=Default inhibit "
         "times (1800 to 1807, sub-index 3) are those at 1000 kbit/s; at lower bit rates they grow as 1000 / "
         "(kbit/s).\n\n";
}

std::string print_list(const char *section, const std::vector<std::uint16_t>& indices) {
  std::string text = fmt::format("[{}]\nSupportedObjects={}\n", section, indices.size());
  for (std::size_t i = 0; i < indices.size(); ++i) {
    text += fmt::format("{}=0x{:04X}\n", i + 1, indices[i]);
  }
  return text + "\n";
}

}  // namespace

std::string print_eds(const object_dictionary& dictionary, const DeviceInfo& info) {
  const SortedObjects objects = sorted_objects(dictionary);
  std::map<std::uint16_t, std::vector<od_object>> by_index;
  for (const auto& [key, object] : objects) {
    by_index[key.first].push_back(object);
  }
  std::vector<std::uint16_t> mandatory;
  std::vector<std::uint16_t> optional;
  std::vector<std::uint16_t> manufacturer;
  std::string text;
  for (const auto& [index, rows] : by_index) {
    const bool must = index == 0x1000 || index == 0x1001 || index == 0x1018;
    (must ? mandatory : index >= 0x2000 && index < 0x6000 ? manufacturer : optional).push_back(index);
    text += print_object(rows);
  }
  return print_head(info, objects) + print_list("MandatoryObjects", mandatory) +
         print_list("OptionalObjects", optional) + print_list("ManufacturerObjects", manufacturer) + text;
}

}  // namespace trackservo::dictionary
