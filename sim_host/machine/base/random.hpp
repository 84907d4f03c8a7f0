// SPDX-License-Identifier: Apache-2.0
// Seeded random streams of the simulated machine.
//
// Every noise source owns a stream; a stream is the run's seed and the source's name, mixed by splitmix64 (Steele,
// Lea, Flood: Fast splittable pseudorandom number generators, 2014). Streams are therefore independent of each other,
// and adding, removing or drawing from one never shifts another. Normal deviates come from Boost.Random (ziggurat),
// which unlike std::normal_distribution gives the same numbers with every standard library.
//
// Use: `RandomStream wind(seed, "wind.gust", axis); torque = rms * wind.normal();`
#ifndef TRACKSERVO_SIM_BASE_RANDOM_HPP
#define TRACKSERVO_SIM_BASE_RANDOM_HPP

#include <boost/random/normal_distribution.hpp>
#include <cstdint>
#include <limits>
#include <string_view>

namespace trackservo::sim {

// splitmix64 as a uniform random bit generator: period 2^64, passes BigCrush, eight bytes of state.
class SplitMix64 {
 public:
  using result_type = std::uint64_t;

  explicit SplitMix64(std::uint64_t state) : state_(state) {}

  static constexpr result_type min() { return 0; }
  static constexpr result_type max() { return std::numeric_limits<result_type>::max(); }

  result_type operator()() {
    state_ += 0x9E3779B97F4A7C15ULL;
    return mix(state_);
  }

  // Draws a uniform deviate in [0, 1).
  double uniform() { return static_cast<double>((*this)() >> 11) * 0x1.0p-53; }

  // Applies the output function: a bijection of 64-bit words whose every output bit depends on every input bit.
  static constexpr std::uint64_t mix(std::uint64_t word) {
    word = (word ^ (word >> 30)) * 0xBF58476D1CE4E5B9ULL;
    word = (word ^ (word >> 27)) * 0x94D049BB133111EBULL;
    return word ^ (word >> 31);
  }

 private:
  std::uint64_t state_;
};

// One noise source's own sequence. Copyable: a copy repeats the sequence from the point of copying.
class RandomStream {
 public:
  // Starts the sequence of a source: `name` ("gyro.noise"); `index` distinguishes instances (the axis).
  RandomStream(std::uint64_t seed, std::string_view name, int index = 0)
      : engine_(start_state(seed, name, static_cast<std::uint64_t>(index))) {}

  // Draws a standard normal deviate: mean 0, standard deviation 1. Takes about 5 ns.
  double normal() { return distribution_(engine_); }

  // Draws noise of about a converter's step, which rounds it anyway, at half the cost: the sum of the eight bytes of
  // one word. Mean and standard deviation as of normal(), kurtosis 2.85; beyond three deviations 0.6 times as often,
  // none beyond 4.9; in steps of 1/209.
  double nearly_normal() {
    constexpr std::uint64_t kEvenBytes = 0x00FF00FF00FF00FFULL;
    constexpr std::uint64_t kSumOfLanes =
        0x0001000100010001ULL;  // a factor that adds the 16-bit lanes into the top one
    constexpr double kMean = 8 * 127.5;
    constexpr double kDeviation_1 = 1.0 / 209.02153;  // sqrt(8 (256^2 - 1) / 12)
    const std::uint64_t word = engine_();
    const std::uint64_t pairs = (word & kEvenBytes) + ((word >> 8) & kEvenBytes);
    const auto sum = static_cast<std::int32_t>((pairs * kSumOfLanes) >> 48);
    return (sum - kMean) * kDeviation_1;
  }

  // Draws a uniform deviate in [0, 1).
  double uniform() { return engine_.uniform(); }

 private:
  static constexpr std::uint64_t start_state(std::uint64_t seed, std::string_view name, std::uint64_t index) {
    std::uint64_t word = SplitMix64::mix(seed + 0x9E3779B97F4A7C15ULL);
    for (const char letter : name) {
      word = SplitMix64::mix(word ^ (static_cast<std::uint64_t>(static_cast<unsigned char>(letter)) + 0x100ULL));
    }
    return SplitMix64::mix(word ^ (index + 0x10000ULL));
  }

  SplitMix64 engine_;
  boost::random::normal_distribution<double> distribution_{};
};

}  // namespace trackservo::sim

#endif
