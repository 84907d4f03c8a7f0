// SPDX-License-Identifier: Apache-2.0
#include "machine/sensors/sender_mapping.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {

std::uint16_t counts_of(double value, double per_count) {
  return static_cast<std::uint16_t>(
      static_cast<std::int16_t>(std::clamp(std::lround(value / per_count), -32767L, 32767L)));
}

void put_word(can_frame& frame, std::size_t at, std::uint16_t value) {
  frame.data[at] = static_cast<std::uint8_t>(value);
  frame.data[at + 1] = static_cast<std::uint8_t>(value >> 8);
}

std::vector<ObjectWrite> sender_mapping(int number, std::uint32_t cob_id, std::uint16_t object,
                                        const std::vector<std::uint32_t>& bits) {
  constexpr std::uint32_t kNotValid = 0x80000000;
  const auto parameters = static_cast<std::uint16_t>(0x1400 + number - 1);
  const auto mapping = static_cast<std::uint16_t>(0x1600 + number - 1);
  std::vector<ObjectWrite> writes{{parameters, 1, kNotValid | cob_id}, {mapping, 0, 0}};
  std::uint8_t sub = 0;
  for (const std::uint32_t length : bits) {
    ++sub;
    writes.push_back({mapping, sub, std::uint32_t{object} << 16 | std::uint32_t{sub} << 8 | length});
  }
  writes.push_back({mapping, 0, sub});
  writes.push_back({parameters, 1, cob_id});
  return writes;
}

}  // namespace trackservo::sim
