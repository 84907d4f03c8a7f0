// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "device_description.hpp"

namespace trackservo::dictionary {
namespace {

const char *standard_type_name(const od_entry& entry) {
  switch (static_cast<od_type>(entry.type)) {
    case OD_BOOLEAN:
      return "BOOLEAN";
    case OD_INTEGER8:
      return "INTEGER8";
    case OD_INTEGER16:
      return "INTEGER16";
    case OD_INTEGER32:
      return "INTEGER32";
    case OD_UNSIGNED8:
      return "UNSIGNED8";
    case OD_UNSIGNED16:
      return "UNSIGNED16";
    case OD_UNSIGNED32:
      return "UNSIGNED32";
    case OD_UNSIGNED64:
      return "UNSIGNED64";
    case OD_REAL32:
      return "REAL32";
    case OD_VISIBLE_STRING:
      return "VISIBLE_STRING";
    case OD_DOMAIN:
      break;
  }
  return "DOMAIN";
}

nlohmann::ordered_json describe(const od_object& object) {
  const od_entry& entry = *object.entry;
  nlohmann::ordered_json row{{"index", od_index(&object)},
                             {"sub", entry.sub},
                             {"name", full_name(object)},
                             {"type", standard_type_name(entry)},
                             {"access", access_name(entry)}};
  const auto text = [&](const char *name, const std::string& value) {
    if (!value.empty()) {
      row[name] = value;
    }
  };
  text("unit", entry.unit);
  if (entry.type == OD_VISIBLE_STRING) {
    // Not of a fixed text, which may be the commit: like the schema hash, the file is the same for every commit.
    if (entry.access != OD_CONST) {
      row["capacity"] = entry.bytes;
      row["default"] = entry.preset.text == nullptr ? "" : entry.preset.text;
    }
  } else if (entry.type != OD_DOMAIN) {
    row["low"] = json_number(entry, entry.low);
    row["high"] = json_number(entry, entry.high);
    row["default"] = json_number(entry, od_default(&object));
  }
  const auto flag = [&](const char *name, int bit) {
    if ((entry.flags & bit) != 0) {
      row[name] = true;
    }
  };
  flag("plus_node_id", OD_NODE_ID);
  flag("rpdo", OD_RPDO);
  flag("tpdo", OD_TPDO);
  flag("stored", OD_STORED);
  flag("guarded", OD_GUARDED);
  text("help", entry.help);
  return row;
}

}  // namespace

nlohmann::ordered_json json_number(const od_entry& entry, od_number value) {
  if (entry.type == OD_REAL32) {
    return std::stod(fmt::format("{}", value.f));  // the shortest decimal that is this float
  }
  if (entry.type == OD_UNSIGNED64) {
    return static_cast<std::uint64_t>(value.i);
  }
  return value.i;
}

nlohmann::ordered_json describe_parameters(const object_dictionary& dictionary, const DeviceInfo& info) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const auto& [key, object] : sorted_objects(dictionary)) {
    rows.push_back(describe(object));
  }
  return {{"product", info.product}, {"vendor", info.vendor}, {"objects", rows}};
}

std::string print_by_rows(const nlohmann::ordered_json& document) {
  std::string text = "{";
  const char *before_key = "\n";
  for (const auto& [key, value] : document.items()) {
    text += before_key + nlohmann::ordered_json(key).dump() + ": ";
    before_key = ",\n";
    if (!value.is_array()) {
      text += value.dump();
      continue;
    }
    const char *before_row = "[\n";
    for (const auto& row : value) {
      text += before_row + row.dump();
      before_row = ",\n";
    }
    text += value.empty() ? "[]" : "\n]";
  }
  return text + "\n}\n";
}

}  // namespace trackservo::dictionary
