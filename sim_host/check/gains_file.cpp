// SPDX-License-Identifier: Apache-2.0
#include "check/gains_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <stdexcept>

#include "device/driven_node.hpp"
#include "dictionary/parameter_names.hpp"
#include "dictionary/refusal_text.hpp"
#include "machine/config/toml_reader.hpp"

extern "C" {
#include "parameters/axis_dictionary.h"
#include "protection/access_lock.h"
}

namespace trackservo::sim {
namespace {

using dictionary::tunable_parameters;
using Tunable = std::map<std::string, od_object>;

constexpr const char *kDeviceTable = "device";
constexpr std::uint16_t kAccessLock = 0x3040;
constexpr std::uint32_t kOpen = ACCESS_LOCK_WORD;
constexpr std::uint16_t kTuning = 0x2070;
constexpr std::uint32_t kApply = 1;
constexpr std::uint8_t kRefusedObject = 6;  // 2070:6 to 9

std::string range_text(const od_entry& entry) {
  const std::string unit = *entry.unit == '\0' ? "" : fmt::format(" {}", entry.unit);
  if (entry.type == OD_BOOLEAN) {
    return "true or false";
  }
  return entry.type == OD_REAL32 ? fmt::format("{} to {}{}", entry.low.f, entry.high.f, unit)
                                 : fmt::format("a whole number from {} to {}{}", entry.low.i, entry.high.i, unit);
}

// Levenshtein would be more tolerant; the last word of a name is the one that people get wrong least.
std::string hint(const Tunable& tunable, const std::string& name) {
  const std::string last = name.substr(name.rfind('.') + 1);
  std::vector<std::string> similar;
  for (const auto& [known, object] : tunable) {
    if (known.size() > last.size() && known.compare(known.size() - last.size(), last.size(), last) == 0) {
      similar.push_back(known);
    }
  }
  return similar.empty() ? "give a name as written by `servoctl save`"
                         : fmt::format("did you mean {}?", similar.front());
}

class GainsReader {
 public:
  GainsReader(const std::filesystem::path& file, const PlantConfig& plant)
      : reader_(file),
        setup_(product_setup(plant)),
        node_(setup_, 1, {0.0, 0.0}),
        tunable_(tunable_parameters(*servo_node_dictionary(&node_.node()))) {
    gains_.file = file;
    gains_.lines = reader_.lines();
  }

  Gains read() {
    for (const auto& [key, node] : *reader_.root().table) {
      const std::string name(key.str());
      if (name != kDeviceTable) {
        take(node, name);
      }
    }
    if (gains_.values.empty()) {
      throw gains_.lines.error("file", "contains no gains",
                               "give a file written by `servoctl save` or `sim_host gains`");
    }
    return gains_;
  }

 private:
  // As deep as the tables of the file, which toml++ has bounded.
  // NOLINTNEXTLINE(misc-no-recursion)
  void take(const toml::node& node, const std::string& name) {
    if (const toml::table *table = node.as_table()) {
      for (const auto& [key, child] : *table) {
        take(child, name + "." + std::string(key.str()));
      }
      return;
    }
    const auto found = tunable_.find(name);
    if (found == tunable_.end()) {
      throw gains_.lines.error(name, "is not a gain of this firmware", hint(tunable_, name));
    }
    const od_object& object = found->second;
    Gain gain{name, od_index(&object), object.entry->sub, object.entry->bytes, bits_of(node, *object.entry, name)};
    gains_.values.push_back(gain);
  }

  // 2.0 is one, too, as for servoctl.
  static std::optional<std::int64_t> whole_number(const toml::node& node) {
    constexpr double kExact = 9007199254740992.0;  // below it a double has every whole number
    if (node.is_integer()) {
      return node.value<std::int64_t>();
    }
    const double value = node.value<double>().value_or(0.5);
    return node.is_number() && value == std::floor(value) && std::abs(value) < kExact
               ? std::optional(static_cast<std::int64_t>(value))
               : std::nullopt;
  }

  std::uint32_t bits_of(const toml::node& node, const od_entry& entry, const std::string& name) const {
    const auto refuse = [&](const std::string& reason) {
      return gains_.lines.error(name, reason, "give " + range_text(entry));
    };
    if (entry.type == OD_BOOLEAN) {
      if (!node.is_boolean()) {
        throw refuse("is not true or false");
      }
      return *node.value<bool>() ? 1U : 0U;
    }
    if (entry.type == OD_REAL32) {
      if (!node.is_number()) {
        throw refuse("is not a number");
      }
      const auto value = static_cast<float>(*node.value<double>());
      if (!std::isfinite(value) || value < entry.low.f || value > entry.high.f) {
        throw refuse(fmt::format("{} is out of range", value));
      }
      std::uint32_t bits = 0;
      std::memcpy(&bits, &value, sizeof bits);
      return bits;
    }
    const std::optional<std::int64_t> value = whole_number(node);
    if (!value) {
      throw refuse("is not a whole number");
    }
    if (*value < entry.low.i || *value > entry.high.i) {
      throw refuse(fmt::format("{} is out of range", *value));
    }
    return static_cast<std::uint32_t>(*value);
  }

  TomlReader reader_;
  NodeSetup setup_;
  DrivenNode node_;  // only for its dictionary; it does not run
  Tunable tunable_;
  Gains gains_;
};

// Rows that depend on a later value are tried again, until a pass changes nothing.
void write_all(CheckedDevice& device, const Gains& gains) {
  std::vector<Gain> waiting = gains.values;
  while (!waiting.empty()) {
    std::vector<Gain> refused;
    std::uint32_t abort_code = 0;
    for (const Gain& gain : waiting) {
      const std::uint32_t answer = device.write(gain.index, gain.sub, gain.bits, gain.bytes);
      if (answer != 0) {
        abort_code = refused.empty() ? answer : abort_code;
        refused.push_back(gain);
      }
    }
    if (!refused.empty() && refused.size() == waiting.size()) {
      throw gains.lines.error(refused.front().name,
                              fmt::format("is refused by the firmware, abort code {:08X}h", abort_code),
                              "give values that fit together");
    }
    waiting = refused;
  }
}

std::string value_text(const od_object& object) {
  std::uint8_t bytes[8] = {};
  std::uint16_t length = 0;
  if (od_read(&object, bytes, sizeof bytes, &length) != OD_OK) {
    throw std::runtime_error(fmt::format("object {:04X}h:{} cannot be read", od_index(&object), object.entry->sub));
  }
  const od_number value = od_get(&object);
  if (object.entry->type == OD_BOOLEAN) {
    return value.i != 0 ? "true" : "false";
  }
  if (object.entry->type != OD_REAL32) {
    return fmt::format("{}", value.i);
  }
  const std::string text = fmt::format("{}", value.f);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string gains_text(const Tunable& tunable, const PlantConfig& plant) {
  std::map<std::string, std::vector<std::pair<std::string, od_object>>> tables;
  for (const auto& [name, object] : tunable) {
    const std::size_t dot = name.rfind('.');
    tables[name.substr(0, dot)].emplace_back(name.substr(dot + 1), object);
  }
  std::string text = fmt::format(
      "# Gains and limits designed for the plant \"{}\", written by sim_host gains. The unit follows each value.\n# "
      "'servoctl restore FILE' writes them to a device, 'sim_host check --gains FILE' runs scenarios with them.\n",
      plant.name);
  for (const auto& [table, values] : tables) {
    text += fmt::format("\n[{}]\n", table);
    for (const auto& [key, object] : values) {
      const od_entry& entry = *object.entry;
      text += fmt::format("{} = {}{}\n", key, value_text(object),
                          *entry.unit == '\0' ? "" : fmt::format("  # {}", entry.unit));
    }
  }
  return text;
}

float real_of(std::uint32_t bits) {
  float value = 0.0F;
  std::memcpy(&value, &bits, sizeof value);
  return value;
}

axis_parameters staged_on(CheckedDevice& device, std::uint16_t axis_shift) {
  axis_parameters staged{};
  for (std::uint32_t i = 0; i < axis_parameters_table.count; ++i) {
    const od_entry& entry = axis_parameters_table.entries[i];
    if ((entry.flags & OD_STORED) != 0) {
      const std::uint32_t bits =
          device.read(static_cast<std::uint16_t>(entry.index + axis_shift), entry.sub).value_or(0);
      std::memcpy(reinterpret_cast<char *>(&staged) + entry.offset, &bits, sizeof bits);
    }
  }
  return staged;
}

// At the line of the value that 2070:6 to 9 name, or of the axis when the file does not hold it.
ConfigError refused_set(CheckedDevice& device, const Gains& gains, int axis, std::uint32_t abort_code) {
  const std::uint16_t tuning = static_cast<std::uint16_t>(kTuning + AXIS_INDEX_SHIFT * axis);
  const std::uint32_t shift = PARAMETER_OBJECT(AXIS_INDEX_SHIFT * axis, 0);
  const std::optional<std::uint32_t> object = device.read(tuning, kRefusedObject);
  const std::optional<std::uint32_t> low = device.read(tuning, kRefusedObject + 1);
  const std::optional<std::uint32_t> high = device.read(tuning, kRefusedObject + 2);
  const std::optional<std::uint32_t> bound_by = device.read(tuning, kRefusedObject + 3);
  if (!object || *object == 0 || !low || !high || !bound_by) {  // an image from before 2070:6
    return gains.lines.error(
        axis_name(axis), fmt::format("has gains that the firmware refuses together, abort code {:08X}h", abort_code),
        "give gains that fit each other, as `servoctl set --apply` would take them");
  }
  const parameter_refusal refusal = {CONTROL_INCONSISTENT, *object - shift, *bound_by == 0 ? 0 : *bound_by - shift,
                                     real_of(*low), real_of(*high)};
  const axis_parameters staged = staged_on(device, static_cast<std::uint16_t>(AXIS_INDEX_SHIFT * axis));
  const auto named = std::find_if(gains.values.begin(), gains.values.end(),
                                  [&](const Gain& gain) { return PARAMETER_OBJECT(gain.index, gain.sub) == *object; });
  return gains.lines.error(named == gains.values.end() ? axis_name(axis) : named->name, "is refused by the firmware",
                           dictionary::refusal_text(refusal, staged, AXIS_INDEX_SHIFT * static_cast<unsigned>(axis)));
}

}  // namespace

Gains read_gains(const std::filesystem::path& file, const PlantConfig& plant) {
  return GainsReader(file, plant).read();
}

void apply_gains(CheckedDevice& device, const Gains& gains) {
  if (gains.values.empty()) {
    return;
  }
  (void)device.write(kAccessLock, 1, kOpen,
                     4);  // of dangerous limits; a device that needs it and does not have it is refused below
  write_all(device, gains);
  for (std::uint16_t axis = 0; axis < kAxes; ++axis) {
    const std::uint32_t answer =
        device.write(static_cast<std::uint16_t>(kTuning + AXIS_INDEX_SHIFT * axis), 1, kApply, 1);
    if (answer != 0) {
      throw refused_set(device, gains, axis, answer);
    }
  }
}

void write_designed_gains(const PlantConfig& plant, const std::filesystem::path& file) {
  const NodeSetup setup(plant);
  DrivenNode device(setup, 1, {0.0, 0.0});
  std::ofstream stream(file);
  stream << gains_text(tunable_parameters(*servo_node_dictionary(&device.node())), plant);
  if (!stream.flush()) {
    throw std::runtime_error(fmt::format("{}: cannot be written; is the folder writable?", file.string()));
  }
}

}  // namespace trackservo::sim
