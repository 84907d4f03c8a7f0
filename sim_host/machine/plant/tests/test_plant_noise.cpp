// SPDX-License-Identifier: Apache-2.0
// Random parts of the machine: independent seeded streams, exact spectra, reproducible runs.
#include <algorithm>
#include <cmath>
#include <vector>

#include "machine/plant/shaped_noise.hpp"
#include "machine/plant/tracker.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

double correlation(RandomStream a, RandomStream b) {
  double sum = 0.0;
  const int draws = 100000;
  for (int i = 0; i < draws; ++i) {
    sum += a.normal() * b.normal();
  }
  return sum / draws;
}

void test_streams_of_other_names_indices_and_seeds_are_uncorrelated() {
  const RandomStream gust(1, "load.gust", 0);
  CHECK_NEAR("other index", 0.0, correlation(gust, RandomStream(1, "load.gust", 1)), 0.015);
  CHECK_NEAR("other name", 0.0, correlation(gust, RandomStream(1, "gyro.noise", 0)), 0.015);
  CHECK_NEAR("next seed", 0.0, correlation(gust, RandomStream(2, "load.gust", 0)), 0.015);
  CHECK_NEAR("itself", 1.0, correlation(gust, RandomStream(1, "load.gust", 0)), 0.02);
}

void test_normal_deviates_have_unit_variance_and_normal_tails() {
  RandomStream stream(7, "test");
  double square = 0.0;
  double fourth = 0.0;
  const int draws = 1000000;
  for (int i = 0; i < draws; ++i) {
    const double x = stream.normal();
    square += x * x;
    fourth += x * x * x * x;
  }
  CHECK_NEAR("variance", 1.0, square / draws, 0.006);
  CHECK_NEAR("kurtosis", 3.0, fourth / draws, 0.05);
}

// The exact law of the sum of eight fair bytes, by convolution; index: the sum.
std::vector<double> law_of_eight_bytes() {
  std::vector<double> law{1.0};
  for (int byte = 0; byte < 8; ++byte) {
    std::vector<double> sum(law.size() + 255, 0.0);
    for (std::size_t i = 0; i < law.size(); ++i) {
      for (std::size_t value = 0; value < 256; ++value) {
        sum[i + value] += law[i] / 256.0;
      }
    }
    law = sum;
  }
  return law;
}

// Share of the law beyond `bound` deviations, both sides.
double tail_of_eight_bytes(double bound) {
  const double deviation = std::sqrt(8.0 * (256.0 * 256.0 - 1.0) / 12.0);
  const std::vector<double> law = law_of_eight_bytes();
  double tail = 0.0;
  for (std::size_t sum = 0; sum < law.size(); ++sum) {
    tail += std::abs((static_cast<double>(sum) - 1020.0) / deviation) > bound ? law[sum] : 0.0;
  }
  return tail;
}

// Drawn values against the exact law of eight bytes, and that law against the normal one.
void test_nearly_normal_deviates_are_what_they_say() {
  RandomStream stream(7, "test");
  const int draws = 2000000;
  double sum = 0.0;
  double square = 0.0;
  double fourth = 0.0;
  double largest = 0.0;
  const std::vector<double> bounds{0.5, 1.0, 2.0, 3.0, 4.0};
  std::vector<double> beyond(bounds.size(), 0.0);
  for (int i = 0; i < draws; ++i) {
    const double x = stream.nearly_normal();
    sum += x;
    square += x * x;
    fourth += x * x * x * x;
    largest = std::max(largest, std::abs(x));
    for (std::size_t b = 0; b < bounds.size(); ++b) {
      beyond[b] += std::abs(x) > bounds[b] ? 1.0 / draws : 0.0;
    }
  }
  const double error = 4.0 / std::sqrt(static_cast<double>(draws));  // four standard errors of a unit variance
  CHECK_NEAR("mean", 0.0, sum / draws, error);
  CHECK_NEAR("variance", 1.0, square / draws, 1.4 * error);
  CHECK_NEAR("kurtosis", 2.85, fourth / draws, 10.0 * error);
  CHECK_AT_MOST("largest", 4.9, largest);
  for (std::size_t b = 0; b < bounds.size(); ++b) {
    const double exact = tail_of_eight_bytes(bounds[b]);
    const double normal = std::erfc(bounds[b] / std::sqrt(2.0));
    LOG_VALUE("share beyond, against the normal law's", exact / normal);
    CHECK_NEAR("share beyond, drawn", exact, beyond[b], error * std::sqrt(exact));
    CHECK_NEAR("share beyond, against the normal law", normal, exact, 0.008);
  }
  CHECK_NEAR("beyond three deviations, of the normal law's share", 0.6,
             tail_of_eight_bytes(3.0) / std::erfc(3.0 / std::sqrt(2.0)), 0.02);
}

// One draw is independent of the next.
void test_nearly_normal_deviates_follow_each_other_freely() {
  RandomStream stream(11, "test");
  const int draws = 1000000;
  double product = 0.0;
  double last = stream.nearly_normal();
  for (int i = 0; i < draws; ++i) {
    const double next = stream.nearly_normal();
    product += last * next / draws;
    last = next;
  }
  CHECK_NEAR("correlation with the next", 0.0, product, 4e-3);
}

// Mean over many seeds of x(t)^2 and x(t) x(t + lag).
struct Moments {
  double variance = 0;
  double lagged = 0;
};

template <class Make>
Moments moments(Make make, int lag) {
  Moments mean;
  const int runs = 20000;
  for (int seed = 0; seed < runs; ++seed) {
    ShapedNoise noise = make(RandomStream(static_cast<std::uint64_t>(seed), "test"));
    const double start = noise.state()[0];
    for (int step = 0; step < lag; ++step) {
      noise.next();
    }
    mean.variance += noise.state()[0] * noise.state()[0] / runs;
    mean.lagged += start * noise.state()[0] / runs;
  }
  return mean;
}

void test_gusts_have_their_rms_and_correlation_from_the_first_moment() {
  // Two equal poles w: correlation (1 + w t) e^(-w t).
  const auto gust = [](RandomStream stream) { return ShapedNoise::two_poles(0.7, 0.7, 3.0, 0.01, stream); };
  const double wt = 2.0 * kPi * 0.7 * 0.2;
  const Moments seen = moments(gust, 20);
  CHECK_RELATIVE("variance", 9.0, seen.variance, 0.03);
  CHECK_RELATIVE("correlation over 0.2 s", 9.0 * (1.0 + wt) * std::exp(-wt), seen.lagged, 0.05);
}

void test_sway_rings_at_its_resonance() {
  const auto sway = [](RandomStream stream) { return ShapedNoise::resonance(1.5, 0.1, 2.0, 0.001, stream); };
  const double w = 2.0 * kPi * 1.5;
  const double damped = w * std::sqrt(1.0 - 0.01);
  const double t = 0.333;  // half a period: correlation near its minimum
  const double expected =
      std::exp(-0.1 * w * t) * (std::cos(damped * t) + 0.1 / std::sqrt(1.0 - 0.01) * std::sin(damped * t));
  const Moments seen = moments(sway, 333);
  CHECK_RELATIVE("variance", 4.0, seen.variance, 0.03);
  CHECK_NEAR("correlation over half a period", 4.0 * expected, seen.lagged, 0.12);
}

struct Log {
  std::vector<double> gyro, wind, current;
  std::vector<std::uint32_t> encoder;
};

Log logged(const PlantConfig& plant, std::uint64_t seed) {
  Tracker tracker(plant, seed);
  Log log;
  for (int tick = 0; tick < 200; ++tick) {
    const TickSamples samples = tracker.sample_tick();
    log.gyro.push_back(samples.axis[kAzimuth].gyro_rad_s);
    log.encoder.push_back(samples.axis[kPitch].joint_angle_turn32);
    for (int step = 0; step < kPwmPerTick; ++step) {
      log.current.push_back(tracker.sample_pwm(kPitch).current_a);
      tracker.step_pwm({0.2, -0.1});
    }
    log.wind.push_back(tracker.truth().load_torque_nm[kAzimuth]);
  }
  return log;
}

void test_equal_seeds_give_equal_runs_bit_by_bit() {
  for (const FrictionModel model : {FrictionModel::kLugre, FrictionModel::kMaxwellSlip}) {
    PlantConfig plant = shipped_plant("tracker");
    plant.friction_model = model;
    const Log first = logged(plant, 11);
    const Log again = logged(plant, 11);
    const Log other = logged(plant, 12);
    TEST_ASSERT_TRUE(first.gyro == again.gyro && first.encoder == again.encoder && first.current == again.current &&
                     first.wind == again.wind);
    TEST_ASSERT_FALSE(first.gyro == other.gyro);
    TEST_ASSERT_FALSE(first.wind == other.wind);
  }
}

void test_switching_one_noise_off_leaves_the_others_as_they_were() {
  PlantConfig plant = bare_plant();
  plant.axis[kAzimuth].inertia_kg_m2 = 1e6;  // nothing moves, so that only the noises differ
  plant.axis[kPitch].inertia_kg_m2 = 1e6;
  plant.axis[kAzimuth].load.wind_gust_rms_nm = 3.0;
  plant.axis[kAzimuth].gyro.noise_density_rad_s_rthz = 1e-6;
  plant.axis[kPitch].encoder.jitter_rms_rad = 1e-7;
  plant.adc.current_noise_rms_a = 0.01;
  const Log all = logged(plant, 4);
  PlantConfig calm = plant;
  calm.axis[kAzimuth].load.wind_gust_rms_nm = 0.0;
  calm.adc.current_noise_rms_a = 0.0;
  const Log rest = logged(calm, 4);
  for (std::size_t i = 0; i < all.gyro.size(); ++i) {
    CHECK_NEAR("gyro in rad/s", all.gyro[i], rest.gyro[i], 2e-6);
  }
  TEST_ASSERT_TRUE(all.encoder == rest.encoder);
  TEST_ASSERT_FALSE(all.wind == rest.wind);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_streams_of_other_names_indices_and_seeds_are_uncorrelated);
  RUN_TEST(test_normal_deviates_have_unit_variance_and_normal_tails);
  RUN_TEST(test_nearly_normal_deviates_are_what_they_say);
  RUN_TEST(test_nearly_normal_deviates_follow_each_other_freely);
  RUN_TEST(test_gusts_have_their_rms_and_correlation_from_the_first_moment);
  RUN_TEST(test_sway_rings_at_its_resonance);
  RUN_TEST(test_equal_seeds_give_equal_runs_bit_by_bit);
  RUN_TEST(test_switching_one_noise_off_leaves_the_others_as_they_were);
  return UNITY_END();
}
