// SPDX-License-Identifier: Apache-2.0
#include "device/bus/can_bit_time.hpp"

#include <cstdint>

namespace trackservo::sim {
namespace {

// Runs the bits of a frame through the CRC and the stuffing.
class BitCounter {
 public:
  void add(std::uint32_t value, int width) {
    for (int i = width - 1; i >= 0; --i) {
      const bool bit = (value >> i & 1U) != 0;
      const bool feedback = bit != ((crc_ >> 14 & 1U) != 0);
      crc_ = (crc_ << 1 & 0x7FFFU) ^ (feedback ? 0x4599U : 0U);
      put(bit);
    }
  }

  int finish() {
    const std::uint32_t crc = crc_;
    for (int i = 14; i >= 0; --i) {
      put((crc >> i & 1U) != 0);
    }
    constexpr int kUnstuffed = 13;  // CRC delimiter, acknowledge slot and delimiter, end of frame, intermission
    return bits_ + kUnstuffed;
  }

 private:
  void put(bool bit) {
    run_ = bits_ > 0 && bit == last_ ? run_ + 1 : 1;
    last_ = bit;
    ++bits_;
    if (run_ == 5) {  // a stuffed bit of the opposite value begins the next run
      ++bits_;
      last_ = !bit;
      run_ = 1;
    }
  }

  std::uint32_t crc_ = 0;
  int bits_ = 0;
  int run_ = 0;
  bool last_ = false;
};

}  // namespace

int can_frame_bits(const can_frame& frame) {
  const bool remote = (frame.flags & CAN_FRAME_REMOTE) != 0;
  const std::uint32_t rtr = remote ? 1 : 0;
  BitCounter counter;
  counter.add(0, 1);  // start of frame
  if ((frame.flags & CAN_FRAME_EXTENDED) != 0) {
    counter.add(frame.id >> 18, 11);
    counter.add(3, 2);  // SRR, IDE
    counter.add(frame.id & 0x3FFFF, 18);
    counter.add(rtr, 1);
    counter.add(0, 2);  // r1, r0
  } else {
    counter.add(frame.id, 11);
    counter.add(rtr, 1);
    counter.add(0, 2);  // IDE, r0
  }
  counter.add(frame.length, 4);
  for (int i = 0; i < frame.length && !remote; ++i) {
    counter.add(frame.data[i], 8);
  }
  return counter.finish();
}

}  // namespace trackservo::sim
