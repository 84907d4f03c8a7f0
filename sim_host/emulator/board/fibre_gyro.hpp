// SPDX-License-Identifier: Apache-2.0
// A fibre-optic gyro of the KVH 1750 family (1750 IMU technical manual, 54-0857): sends a message of format A with the
// rate as its x channel, 1000 times a second by its own clock, at 921,600 bits/s.
//
//     FE 81 FF 55, three rates and three accelerations (float32), status, sequence, temperature (int16), CRC-32
//
// Big endian; CRC polynomial 04C11DB7, start FFFFFFFF, no reflection, over everything before it.
#ifndef TRACKSERVO_SIM_EMULATOR_BOARD_FIBRE_GYRO_HPP
#define TRACKSERVO_SIM_EMULATOR_BOARD_FIBRE_GYRO_HPP

#include <array>
#include <cstdint>
#include <cstring>

#include "chip/usart.hpp"
#include "machine/base/random.hpp"

namespace trackservo::target {

class FibreGyro {
 public:
  static constexpr std::size_t kBytes = 36;
  static constexpr double kBitsPerSecond = 921'600;

  FibreGyro(Timeline& timeline, Usart& line)
      : timeline_(timeline), line_(line), next_byte_(timeline.add([this] { send_byte(); })) {}

  // Sends a message with this rate from now on; it takes 0.39 ms.
  void send(double rate_rad_s, bool valid) {
    if (!is_connected) {
      return;
    }
    make(static_cast<float>(is_dead ? noise_rad_s() : rate_rad_s), valid);
    sent_ = 0;
    timeline_.set(next_byte_, timeline_.instant() + byte_time());
  }

  bool is_connected = true;
  bool breaks_crc = false;
  bool is_dead = false;  // noise about zero, whatever the rate

 private:
  static constexpr double kDeadNoise_rad_s = 4e-4;  // from end to end

  double noise_rad_s() { return kDeadNoise_rad_s * (noise_.uniform() - 0.5); }
  static constexpr Instant byte_time() { return duration_of(10.0 / kBitsPerSecond); }

  void put(std::size_t at, std::uint32_t word) {
    for (std::size_t i = 0; i < 4; ++i) {
      message_[at + i] = static_cast<std::uint8_t>(word >> (24 - 8 * i));
    }
  }

  void make(float rate_rad_s, bool valid) {
    message_.fill(0);
    put(0, 0xFE81FF55);
    std::uint32_t rate = 0;
    std::memcpy(&rate, &rate_rad_s, 4);
    put(4, rate);
    put(24, 0x3F800000);  // 1 g along z
    message_[28] = static_cast<std::uint8_t>(0x76 | (valid ? 1 : 0));
    message_[29] = sequence_;
    sequence_ = static_cast<std::uint8_t>((sequence_ + 1) & 0x7F);
    message_[31] = 31;  // degree Celsius
    std::uint32_t crc = 0xFFFFFFFF;
    for (std::size_t i = 0; i < 32; ++i) {
      crc ^= static_cast<std::uint32_t>(message_[i]) << 24;
      for (int bit = 0; bit < 8; ++bit) {
        crc = (crc & 1U << 31) != 0 ? crc << 1 ^ 0x04C11DB7U : crc << 1;
      }
    }
    put(32, breaks_crc ? ~crc : crc);
  }

  void send_byte() {
    line_.receive(message_[sent_], kBitsPerSecond);
    if (++sent_ < kBytes) {
      timeline_.set(next_byte_, timeline_.instant() + byte_time());
    }
  }

  Timeline& timeline_;
  Usart& line_;
  Timeline::Alarm next_byte_;
  std::array<std::uint8_t, kBytes> message_{};
  std::size_t sent_ = 0;
  std::uint8_t sequence_ = 0;
  sim::SplitMix64 noise_{1};
};

}  // namespace trackservo::target

#endif
