// SPDX-License-Identifier: Apache-2.0
// What the senders of measured values on the bus share: their words in a frame, and the mapping that takes them.
#ifndef TRACKSERVO_SIM_SENSORS_SENDER_MAPPING_HPP
#define TRACKSERVO_SIM_SENSORS_SENDER_MAPPING_HPP

#include <cstddef>
#include <cstdint>
#include <vector>

extern "C" {
#include "base/can_frame.h"
}

namespace trackservo::sim {

// Returns a value as an INTEGER16 of so much per count; clipped at +-32767.
std::uint16_t counts_of(double value, double per_count);

void put_word(can_frame& frame, std::size_t at, std::uint16_t value);

struct ObjectWrite {
  std::uint16_t index;
  std::uint8_t sub;
  std::uint32_t value;
};

// Returns what a master writes so that RPDO `number` (1 to 4) takes the frames with this identifier into the
// sub-indices 1, 2 .. of an object; `bits` are their lengths.
std::vector<ObjectWrite> sender_mapping(int number, std::uint32_t cob_id, std::uint16_t object,
                                        const std::vector<std::uint32_t>& bits);

}  // namespace trackservo::sim

#endif
