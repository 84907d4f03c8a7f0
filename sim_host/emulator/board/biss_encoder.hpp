// SPDX-License-Identifier: Apache-2.0
// An absolute encoder with BiSS-C (protocol description C5), limited to the position data of one slave.
//
// The first falling clock edge after a pause latches the reading. The data line: high until the second rising edge, low
// while the encoder works (acknowledge), a high start bit, a low one (CDS), then 26 bits of position, error and warning
// (both low active), and six of CRC (polynomial 0x43, inverted) over the 28 before; low until the clock has paused.
//
// A bit comes one round trip after the rising edge that requested it: a hundred nanoseconds of cable, transceivers and
// encoder. A master that samples it at the next rising edge has 88 ns to spare at 5.3 MHz; half a period earlier it
// would sample during the change.
#ifndef TRACKSERVO_SIM_EMULATOR_BOARD_BISS_ENCODER_HPP
#define TRACKSERVO_SIM_EMULATOR_BOARD_BISS_ENCODER_HPP

#include <cstdint>
#include <functional>

#include "chip/spi.hpp"
#include "core/violations.hpp"

namespace trackservo::target {

class BissEncoder : public SpiDevice {
 public:
  // Takes the present position from `reading`, in 2^-32 turns.
  BissEncoder(Violations& violations, std::function<std::uint32_t()> reading)
      : violations_(violations), reading_(std::move(reading)) {}

  std::uint32_t clock(unsigned bits, Instant at, Instant period, bool on_leading_edge) override {
    if (changes_when_taken(period, on_leading_edge)) {
      violations_.add("an encoder's data line is sampled while it changes");
      return 0;
    }
    if (period < kShortestPeriod || period > kLongestPeriod) {
      violations_.add("an encoder's clock is outside 250 kHz to 10 MHz");
      return (1U << bits) - 1U;
    }
    if (at > pause_begins_ + kPause) {
      load();
    }
    pause_begins_ = at + bits * period;
    const auto line = static_cast<std::uint32_t>(stream_ >> (64 - bits));
    stream_ <<= bits;
    return is_connected ? line : (1U << bits) - 1U;
  }

  int frames() const { return frames_; }

  bool is_connected = true;
  bool has_error = false;
  bool has_warning = false;
  bool sends_garbage = false;  // another position each time, with the right CRC
  bool sends_noise = false;    // random bits: the CRC is right by chance
  bool is_dead = false;        // the position at which it died, with noise
  unsigned flipped_bits = 0;   // of the position as sent, after the CRC was made
  unsigned acknowledge_bits = 6;

 private:
  static constexpr Instant kPause = 12 * kUnitsPerMicrosecond;
  static constexpr Instant kShortestPeriod = kUnitsPerMicrosecond / 10;
  static constexpr Instant kLongestPeriod = 4 * kUnitsPerMicrosecond;
  static constexpr Instant kRoundTrip = kUnitsPerMicrosecond / 10;
  static constexpr Instant kSettling = kUnitsPerMicrosecond / 50;  // during a change: neither the old bit nor the new
  static constexpr unsigned kPositionBits = 26;
  static constexpr std::uint32_t kDeadNoise = 80;  // 2^-32 turns: 0.1 urad

  // Returns whether the data line changes when it is sampled. The leading edge of a clock that idles high is the
  // falling one, half a period after the rising one.
  static bool changes_when_taken(Instant period, bool on_leading_edge) {
    const Instant taken = on_leading_edge ? period / 2 : period;
    const Instant since_change = (taken + period - kRoundTrip % period) % period;
    return since_change < kSettling || period - since_change < kSettling;
  }

  static std::uint32_t crc(std::uint32_t bits28) {
    std::uint32_t remainder = 0;
    for (int bit = 27; bit >= 0; --bit) {
      const std::uint32_t top = (remainder >> 5 ^ bits28 >> bit) & 1U;
      remainder = (remainder << 1 & 0x3FU) ^ (top != 0 ? 0x03U : 0U);
    }
    return ~remainder & 0x3FU;
  }

  // Returns random bits by Xorshift (Marsaglia).
  std::uint32_t random_bits() {
    random_ ^= random_ << 13;
    random_ ^= random_ >> 17;
    random_ ^= random_ << 5;
    return random_;
  }

  void load() {
    alive_at_ = is_dead ? alive_at_ : reading_();
    const std::uint32_t shown = is_dead ? alive_at_ + random_bits() % kDeadNoise : alive_at_;
    const std::uint32_t position = (sends_garbage ? random_bits() : shown) >> (32 - kPositionBits);
    const std::uint32_t checked = position << 2 | (has_error ? 0U : 2U) | (has_warning ? 0U : 1U);
    const std::uint64_t noise = static_cast<std::uint64_t>(random_bits()) << 2 | random_bits() >> 30;
    const std::uint64_t sent = static_cast<std::uint64_t>(checked ^ flipped_bits << 2) << 6 | crc(checked);
    const std::uint64_t data = sends_noise ? noise : sent;
    const unsigned before = 2 + acknowledge_bits + 2;  // idle, acknowledge, start, CDS
    stream_ = 3ULL << 62 | 1ULL << (64 - before + 1) | data << (64 - before - 34);
    ++frames_;
  }

  Violations& violations_;
  std::uint32_t alive_at_ = 0;
  std::function<std::uint32_t()> reading_;
  std::uint64_t stream_ = 0;
  Instant pause_begins_ = 0;
  int frames_ = 0;
  std::uint32_t random_ = 0x2545F491;
};

}  // namespace trackservo::target

#endif
