// SPDX-License-Identifier: Apache-2.0
#include "gain_design/device_parameters.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include "dictionary/device_description.hpp"

extern "C" {
#include "parameters/axis_dictionary.h"
#include "parameters/axis_tuning.h"
}

namespace trackservo::gain_design {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint16_t kLastParameter = 0x205F;
constexpr std::uint16_t kLastDesigned = 0x204F;
constexpr std::uint16_t kSensors = 0x2050;  // its crossover may be designed, too
constexpr std::uint16_t kPlant = 0x2056;
constexpr std::uint16_t kFirstOptional = kPlant;  // files of versions before it exist
constexpr auto kMaxFloat = static_cast<double>(std::numeric_limits<float>::max());

// The dictionary's part over one set of parameters.
class ParameterPart {
 public:
  explicit ParameterPart(const axis_parameters& parameters)
      : part_{axis_parameters_table, 0, false, false, "", &tuning_, nullptr, nullptr, nullptr} {
    tuning_.staged = parameters;
  }
  ParameterPart(const ParameterPart&) = delete;
  ParameterPart& operator=(const ParameterPart&) = delete;

  const axis_parameters& parameters() const { return tuning_.staged; }
  od_object object(const od_entry& entry) const { return {&part_, &entry}; }

  Json value(const od_entry& entry) const {
    const od_object found = object(entry);
    return dictionary::json_number(entry, od_get(&found));
  }

 private:
  axis_tuning tuning_{};
  od_part part_;
};

std::vector<const od_entry *> rows_up_to(std::uint16_t last_index) {
  std::vector<const od_entry *> rows;
  for (std::uint32_t i = 0; i < axis_parameters_table.count; ++i) {
    const od_entry& entry = axis_parameters_table.entries[i];
    if (entry.index <= last_index && entry.access == OD_RW) {
      rows.push_back(&entry);
    }
  }
  return rows;
}

std::string key_of(const od_entry& entry) { return fmt::format("0x{:04X}:{}", entry.index, entry.sub); }

Json head_of(const od_entry& entry) {
  return {
      {"index", fmt::format("0x{:04X}", entry.index)}, {"sub", entry.sub}, {"name", entry.name}, {"unit", entry.unit}};
}

// In bus order, as od_write takes it.
bool bytes_of(const nlohmann::json& json, const od_entry& entry, std::uint8_t (&bytes)[4]) {
  std::uint32_t raw = 0;
  if (entry.type == OD_REAL32 && json.is_number() && std::abs(json.get<double>()) <= kMaxFloat) {
    const float value = json.get<float>();
    std::memcpy(&raw, &value, sizeof raw);
  } else if (entry.type == OD_UNSIGNED32 && json.is_number_integer() && json.get<std::int64_t>() >= 0 &&
             json.get<std::int64_t>() <= UINT32_MAX) {
    raw = json.get<std::uint32_t>();
  } else {
    return false;
  }
  for (int i = 0; i < 4; ++i) {
    bytes[i] = static_cast<std::uint8_t>(raw >> (8 * i));
  }
  return true;
}

void read_row(const InputFile& file, const ParameterPart& part, const od_entry& entry) {
  const std::string key = key_of(entry);
  const auto found = file.json.find(key);
  if (found == file.json.end()) {
    throw file.error(
        fmt::format("\"{}\" ({}) is missing; read 0x2000 to 0x205F of the axis from the device", key, entry.name));
  }
  std::uint8_t bytes[4];
  const od_object object = part.object(entry);
  if (!bytes_of(*found, entry, bytes) || od_write(&object, bytes, sizeof bytes) != OD_OK) {
    throw file.error(fmt::format("\"{}\" ({}) is {}; give a number from {} to {}", key, entry.name, found->dump(),
                                 dictionary::json_number(entry, entry.low).dump(),
                                 dictionary::json_number(entry, entry.high).dump()));
  }
}

void refuse_unknown_keys(const InputFile& file, const std::vector<const od_entry *>& rows) {
  std::set<std::string> known;
  for (const od_entry *entry : rows) {
    known.insert(key_of(*entry));
    known.insert(fmt::format("0x{:04X}:0", entry->index));
  }
  for (const auto& [key, value] : file.json.items()) {
    if (known.count(key) == 0) {
      throw file.error(
          fmt::format("\"{}\" is not a parameter of an axis; give an index from \"0x2000:1\" to \"0x2055:6\", that of "
                      "azimuth also for pitch",
                      key));
    }
  }
}

}  // namespace

axis_parameters read_device_parameters(const InputFile& file) {
  const std::vector<const od_entry *> rows = rows_up_to(kLastParameter);
  refuse_unknown_keys(file, rows);
  const ParameterPart part{dictionary::listed_defaults()};
  for (const od_entry *entry : rows) {
    if (entry->index < kFirstOptional || file.json.contains(key_of(*entry))) {
      read_row(file, part, *entry);
    }
  }
  return part.parameters();
}

Json parameter_rows(const axis_parameters& before, const axis_parameters& after) {
  const ParameterPart old(before);
  const ParameterPart designed(after);
  Json rows = Json::array();
  for (const od_entry *entry : rows_up_to(kLastParameter)) {
    const bool crossover = entry->index == kSensors && old.value(*entry) != designed.value(*entry);
    if (entry->index <= kLastDesigned || crossover || entry->index == kPlant) {
      Json row = head_of(*entry);
      row["before"] = old.value(*entry);
      row["value"] = designed.value(*entry);
      rows.push_back(row);
    }
  }
  return rows;
}

Json plant_rows(const IdentifiedPlant& plant) {
  axis_parameters parameters = dictionary::listed_defaults();
  set_plant(parameters, plant);
  const ParameterPart part(parameters);
  Json rows = Json::array();
  for (const od_entry *entry : rows_up_to(kPlant)) {
    if (entry->index == kPlant) {
      Json row = head_of(*entry);
      row["value"] = part.value(*entry);
      rows.push_back(row);
    }
  }
  return rows;
}

}  // namespace trackservo::gain_design
