// SPDX-License-Identifier: Apache-2.0
#include "judge/attack/writable_objects.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace trackservo::sim {
namespace {

constexpr std::uint16_t kAccessLock = 0x3040;
constexpr std::uint16_t kMaxBytes = 4;

// As azimuth's, for the objects that exist once for each axis.
std::uint16_t without_axis(std::uint16_t index) {
  const bool of_pitch = (index >= 0x2800 && index < 0x3000) || (index >= 0x6800 && index < 0x7000);
  return static_cast<std::uint16_t>(of_pitch ? index - AXIS_INDEX_SHIFT : index);
}

ObjectGroup group_of(const od_entry& entry, std::uint16_t bus_index) {
  const std::uint16_t index = without_axis(bus_index);
  if ((entry.flags & OD_GUARDED) != 0) {
    return ObjectGroup::kGuarded;
  }
  if (index < 0x2000) {
    return index == 0x1010 || index == 0x1011 ? ObjectGroup::kStorage : ObjectGroup::kCommunication;
  }
  if (index == 0x2011 || (index >= 0x3070 && index < 0x3080)) {
    return ObjectGroup::kTracking;
  }
  if (index < 0x6000) {
    return index < 0x2060    ? ObjectGroup::kGains
           : index == 0x2070 ? ObjectGroup::kGainCommand
           : index == 0x2100 ? ObjectGroup::kExperiments
                             : ObjectGroup::kOthers;
  }
  switch (index) {
    case 0x6040:
    case 0x6060:
      return ObjectGroup::kStates;
    case 0x6071:
    case 0x607A:
    case 0x60B1:
    case 0x60B2:
    case 0x60FF:
      return ObjectGroup::kSetPoints;
    default:
      return ObjectGroup::kProfiles;
  }
}

double pick(SplitMix64& random, double low, double high, double preset) {
  const double span = std::max(std::abs(low), std::abs(high));
  const double kind = random.uniform();
  const auto decades = [&random](double from, double to) {
    return std::pow(10.0, from + (to - from) * random.uniform());
  };
  if (kind < 0.2) {
    return low;
  }
  if (kind < 0.35) {
    return high;
  }
  if (kind < 0.45) {
    return low + (high - low) * random.uniform();
  }
  if (kind < 0.55) {
    return low <= 0.0 && high >= 0.0 ? 0.0 : low;
  }
  if (kind < 0.75 && preset != 0.0) {
    return preset * decades(-2.0, 2.0);
  }
  const double sign = low < 0.0 && random.uniform() < 0.5 ? -1.0 : 1.0;
  return sign * span * decades(-9.0, 0.0);
}

}  // namespace

WritableObjects::WritableObjects(const object_dictionary& dictionary) {
  for (std::uint32_t p = 0; p < dictionary.count; ++p) {
    const od_part& part = dictionary.parts[p];
    for (std::uint32_t e = 0; e < part.table.count; ++e) {
      const od_entry& entry = part.table.entries[e];
      const auto index = static_cast<std::uint16_t>(entry.index + part.shift);
      const bool is_number = entry.bytes > 0 && entry.bytes <= kMaxBytes && entry.type != OD_VISIBLE_STRING;
      if (is_number && (entry.flags & OD_RPDO) != 0) {
        mappable_.push_back(static_cast<std::uint32_t>(index) << 16 | static_cast<std::uint32_t>(entry.sub) << 8 |
                            8U * entry.bytes);
      }
      const bool writable = entry.access == OD_RW || entry.access == OD_WO;
      if (is_number && writable && index != kAccessLock) {
        groups_[static_cast<std::size_t>(group_of(entry, index))].push_back({index, entry.sub, &entry});
      }
    }
  }
}

std::size_t WritableObjects::count() const {
  return std::accumulate(groups_.begin(), groups_.end(), std::size_t{0},
                         [](std::size_t sum, const auto& group) { return sum + group.size(); });
}

std::uint32_t random_value(const od_entry& entry, SplitMix64& random) {
  std::uint32_t bits = 0;
  if (entry.type == OD_REAL32) {
    const double value = pick(random, static_cast<double>(entry.low.f), static_cast<double>(entry.high.f),
                              static_cast<double>(entry.preset.f));
    const float real = std::clamp(static_cast<float>(value), entry.low.f, entry.high.f);
    std::memcpy(&bits, &real, sizeof bits);
    return bits;
  }
  const double value = pick(random, static_cast<double>(entry.low.i), static_cast<double>(entry.high.i),
                            static_cast<double>(entry.preset.i));
  const std::int64_t whole = std::clamp(static_cast<std::int64_t>(std::llround(value)), entry.low.i, entry.high.i);
  return static_cast<std::uint32_t>(whole);
}

}  // namespace trackservo::sim
