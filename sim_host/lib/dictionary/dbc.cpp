// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <stdexcept>
#include <vector>

#include "device_description.hpp"

namespace trackservo::dictionary {
namespace {

constexpr int kPdos = 4;
constexpr int kEntries = 8;
constexpr std::size_t kLongestSymbol = 32;  // of the DBC format
constexpr std::uint32_t kIdMask = 0x7FF;
constexpr std::uint32_t kDisabled = 0x80000000;
constexpr std::uint16_t kRatedTorque = 0x6076;  // mN m

// A unit of the table, "1e-7 rad", as factor and SI unit.
struct Scale {
  double factor = 1.0;
  std::string unit;
};

struct Signal {
  std::string name;
  od_object object;
  int start_bit;
  int bits;
  Scale scale;
};

struct Message {
  std::string name;
  std::uint32_t id;
  bool from_node;
  std::int64_t cycle_ms;
  int bytes;
  std::vector<Signal> signals;
};

std::optional<od_object> find(const SortedObjects& objects, unsigned index, unsigned sub) {
  const auto found = objects.find({static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(sub)});
  return found == objects.end() ? std::nullopt : std::optional(found->second);
}

std::int64_t preset(const SortedObjects& objects, unsigned index, unsigned sub) {
  const std::optional<od_object> object = find(objects, index, sub);
  return object ? od_default(&*object).i : 0;
}

// "Azimuth Velocity actual value" becomes AzimuthVelocityActualValue.
std::string symbol(const std::string& name) {
  std::string result;
  bool word_starts = true;
  for (const char c : name) {
    const bool letter = std::isalnum(static_cast<unsigned char>(c)) != 0;
    if (letter) {
      result += word_starts ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
    }
    word_starts = !letter;
  }
  if (result.size() > kLongestSymbol) {
    throw std::runtime_error(
        fmt::format("\"{}\": a DBC symbol has at most {} characters; shorten the object's name", name, kLongestSymbol));
  }
  return result;
}

Scale scale_of(const SortedObjects& objects, const od_object& object) {
  const std::string unit = object.entry->unit;
  if (unit == "0.1 % of rated") {
    return {1e-6 * static_cast<double>(preset(objects, kRatedTorque + object.part->shift, 0)), "N m"};
  }
  if (unit == "ms") {
    return {1e-3, "s"};
  }
  std::size_t number_length = 0;
  try {
    const double factor = std::stod(unit, &number_length);
    return {factor, unit.substr(std::min(number_length + 1, unit.size()))};
  } catch (const std::invalid_argument&) {
    return {1.0, unit};
  }
}

std::vector<Signal> signals_of(const SortedObjects& objects, unsigned mapping) {
  std::vector<Signal> signals;
  int start_bit = 0;
  const std::int64_t count = preset(objects, mapping, 0);
  for (int sub = 1; sub <= count && sub <= kEntries; ++sub) {
    const auto entry = static_cast<std::uint32_t>(preset(objects, mapping, static_cast<unsigned>(sub)));
    const int bits = static_cast<int>(entry & 0xFF);
    const std::optional<od_object> object = find(objects, entry >> 16, entry >> 8 & 0xFF);
    if (!object) {
      throw std::runtime_error(fmt::format("{:04X}:{} maps {:08X}, which does not exist", mapping, sub, entry));
    }
    signals.push_back({symbol(full_name(*object)), *object, start_bit, bits, scale_of(objects, *object)});
    start_bit += bits;
  }
  return signals;
}

std::optional<Message> message_of(const SortedObjects& objects, int n, bool from_node, std::uint8_t node_id) {
  const unsigned communication = (from_node ? 0x1800U : 0x1400U) + static_cast<unsigned>(n);
  const auto cob_id = static_cast<std::uint32_t>(preset(objects, communication, 1));
  std::vector<Signal> signals = signals_of(objects, communication + 0x200);
  if (signals.empty() || (cob_id & kDisabled) != 0) {
    return std::nullopt;
  }
  const int bits = signals.back().start_bit + signals.back().bits;
  return Message{fmt::format("{}{}", from_node ? "TPDO" : "RPDO", n + 1),
                 (cob_id & kIdMask) + node_id,
                 from_node,
                 preset(objects, communication, 5),
                 (bits + 7) / 8,
                 std::move(signals)};
}

std::vector<Message> messages_of(const SortedObjects& objects, std::uint8_t node_id) {
  std::vector<Message> messages;
  for (const bool from_node : {false, true}) {
    for (int n = 0; n < kPdos; ++n) {
      if (std::optional<Message> message = message_of(objects, n, from_node, node_id)) {
        messages.push_back(std::move(*message));
      }
    }
  }
  return messages;
}

std::string print_signal(const Signal& signal, const char *receiver) {
  const od_entry& entry = *signal.object.entry;
  const double factor = signal.scale.factor;
  return fmt::format(" SG_ {} : {}|{}@1{} ({:.10g},0) [{:.10g}|{:.10g}] \"{}\" {}\n", signal.name, signal.start_bit,
                     signal.bits, is_signed(entry) ? '-' : '+', factor, factor * static_cast<double>(entry.low.i),
                     factor * static_cast<double>(entry.high.i), signal.scale.unit, receiver);
}

std::string print_message(const Message& message, const std::string& node) {
  std::string text =
      fmt::format("BO_ {} {}: {} {}\n", message.id, message.name, message.bytes, message.from_node ? node : "Master");
  for (const Signal& signal : message.signals) {
    text += print_signal(signal, message.from_node ? "Master" : node.c_str());
  }
  return text + "\n";
}

std::string print_comments(const Message& message) {
  std::string text;
  for (const Signal& signal : message.signals) {
    const unsigned index = od_index(&signal.object);
    const bool torque = std::string(signal.object.entry->unit) == "0.1 % of rated";
    text += fmt::format("CM_ SG_ {} {} \"{:04X}:{:02X}. {}{}\";\n", message.id, signal.name, index,
                        signal.object.entry->sub, signal.object.entry->help,
                        torque ? fmt::format("; scaled with the default of {:04X}, the rated torque",
                                             kRatedTorque + signal.object.part->shift)
                               : "");
  }
  return text;
}

// Names of the modes, for 6060 and 6061.
std::string print_values(const Message& message) {
  std::string text;
  for (const Signal& signal : message.signals) {
    const std::uint16_t index = signal.object.entry->index;
    if (index == 0x6060 || index == 0x6061) {
      text += fmt::format("VAL_ {} {} 0 \"none\" 1 \"pp\" 3 \"pv\" 8 \"csp\" 9 \"csv\" 10 \"cst\" ;\n", message.id,
                          signal.name);
    }
  }
  return text;
}

}  // namespace

std::string print_dbc(const object_dictionary& dictionary, const DeviceInfo& info, std::uint8_t node_id) {
  const SortedObjects objects = sorted_objects(dictionary);
  const std::vector<Message> messages = messages_of(objects, node_id);
  const std::string node = symbol(info.product);
  std::string text = fmt::format("VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: {} Master\n\n", node);
  std::string comments = fmt::format("CM_ \"{}: default PDOs of node {}. Generated from the object dictionary.\";\n",
                                     info.description, node_id);
  std::string cycles;
  std::string values;
  for (const Message& message : messages) {
    text += print_message(message, node);
    comments += print_comments(message);
    values += print_values(message);
    if (message.cycle_ms != 0) {
      cycles += fmt::format("BA_ \"GenMsgCycleTime\" BO_ {} {};\n", message.id, message.cycle_ms);
    }
  }
  return text + comments + "BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\nBA_DEF_DEF_ \"GenMsgCycleTime\" 0;\n" +
         cycles + values;
}

}  // namespace trackservo::dictionary
