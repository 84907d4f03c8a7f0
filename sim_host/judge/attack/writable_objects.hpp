// SPDX-License-Identifier: Apache-2.0
// The objects of the node that a master may write without unlocking anything, and random values of them.
#ifndef TRACKSERVO_SIM_ATTACK_WRITABLE_OBJECTS_HPP
#define TRACKSERVO_SIM_ATTACK_WRITABLE_OBJECTS_HPP

#include <array>
#include <cstdint>
#include <vector>

#include "judge/attack/frame_master.hpp"
#include "machine/base/random.hpp"

extern "C" {
#include "parameters/axis_dictionary.h"
}

namespace trackservo::sim {

// What a random master chooses from; the groups follow from the index, so that a new object belongs to one.
enum class ObjectGroup {
  kSetPoints,      // targets and offsets
  kStates,         // controlword and mode
  kProfiles,       // other objects of CiA 402: ramps, limits, option codes
  kGains,          // 2000 to 205F, without 2011
  kGainCommand,    // 2070
  kCommunication,  // 1xxx
  kStorage,        // 1010, 1011
  kExperiments,    // 2100
  kTracking,       // 2011, 3070 to 3075
  kOthers,         // other 3xxx, scope and fault log
  kGuarded         // refused while the access lock is closed
};

constexpr std::size_t kObjectGroups = 11;

struct WritableObject {
  std::uint16_t index;  // as the bus sees it
  std::uint8_t sub;
  const od_entry *entry;
};

// Returns the index of an object of azimuth, or of the object that pitch has in its place.
constexpr std::uint16_t index_of_axis(std::uint16_t index, int axis) {
  return static_cast<std::uint16_t>(index + (axis == kPitch ? AXIS_INDEX_SHIFT : 0));
}

class WritableObjects {
 public:
  // Collects everything in the dictionary that one expedited SDO download can write, except the access lock (3040).
  explicit WritableObjects(const object_dictionary& dictionary);

  const std::vector<WritableObject>& group(ObjectGroup group) const { return groups_[static_cast<std::size_t>(group)]; }
  std::size_t count() const;

  // Returns the objects for a PDO mapping: index << 16 | sub << 8 | bits.
  const std::vector<std::uint32_t>& mappable() const { return mappable_; }

 private:
  std::array<std::vector<WritableObject>, kObjectGroups> groups_;
  std::vector<std::uint32_t> mappable_;
};

// Returns a value within the object's range as a bus sees it, mostly at or near one of its limits, its default or zero.
std::uint32_t random_value(const od_entry& entry, SplitMix64& random);

}  // namespace trackservo::sim

#endif
