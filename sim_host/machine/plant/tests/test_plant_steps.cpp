// SPDX-License-Identifier: Apache-2.0
// Fewer steps of the joints per tick ([mechanics] in a plant file) against one step per PWM period.
#include <cmath>
#include <vector>

#include "machine/plant/tracker.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

constexpr int kTicks = 4000;
constexpr double kSine_hz = 0.5;
constexpr double kDuty = 0.3;  // moves both axes against their seals, which hold them when it reverses

struct Record {
  std::vector<double> rate_rad_s;
  std::vector<double> gyro_rad_s;
  std::vector<double> encoder_turn32;
  std::vector<double> current_a;
};

Record drive(int periods_per_step, int axis) {
  PlantConfig plant = shipped_plant("tracker");
  plant.mechanics.pwm_periods_per_step = periods_per_step;
  Tracker tracker(plant, 1);
  tracker.place({0.0, 0.4});
  Record record;
  for (int tick = 0; tick < kTicks; ++tick) {
    const double duty = kDuty * std::sin(2.0 * kPi * kSine_hz * tick * kTick_s);
    for (int period = 0; period < kPwmPerTick; ++period) {
      tracker.step_pwm({duty, duty});
    }
    const TickSamples samples = tracker.sample_tick();
    const auto i = static_cast<std::size_t>(axis);
    record.rate_rad_s.push_back(tracker.truth().joint_rate_rad_s[i]);
    record.current_a.push_back(tracker.truth().current_a[i]);
    record.gyro_rad_s.push_back(static_cast<double>(samples.axis[i].gyro_rad_s));
    record.encoder_turn32.push_back(static_cast<std::int32_t>(samples.axis[i].joint_angle_turn32));
  }
  return record;
}

double rms(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) {
    sum += value * value;
  }
  return std::sqrt(sum / static_cast<double>(values.size()));
}

// Of the difference, as a share of the signal.
double difference(const std::vector<double>& exact, const std::vector<double>& coarse) {
  std::vector<double> apart;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    apart.push_back(exact[i] - coarse[i]);
  }
  return rms(apart) / rms(exact);
}

void test_two_and_four_periods_per_step_move_the_axes_nearly_as_one() {
  for (const int axis : {kAzimuth, kPitch}) {
    const Record exact = drive(1, axis);
    TEST_ASSERT_TRUE(rms(exact.rate_rad_s) > 0.05);
    for (const int periods : {2, 4}) {
      const Record coarse = drive(periods, axis);
      CHECK_NEAR("joint rate, share", 0.0, difference(exact.rate_rad_s, coarse.rate_rad_s), 1e-3);
      CHECK_NEAR("gyro, share", 0.0, difference(exact.gyro_rad_s, coarse.gyro_rad_s), 1e-3);
      CHECK_NEAR("encoder, share", 0.0, difference(exact.encoder_turn32, coarse.encoder_turn32), 1e-3);
      CHECK_NEAR("current, share", 0.0, difference(exact.current_a, coarse.current_a), 1e-3);
    }
  }
}

// Readings in each PWM period: their age must not depend on the length of the steps.
void test_readings_within_a_step_are_as_old_as_with_one_period_per_step() {
  PlantConfig plant = bare_plant();
  plant.axis[kAzimuth].encoder.reads_per_tick = 4;
  std::array<double, 2> read_rad{};
  for (const std::size_t coarse : {0U, 1U}) {
    plant.mechanics.pwm_periods_per_step = coarse == 1 ? 4 : 1;
    Tracker tracker(plant, 1);
    tracker.place({0.0, 0.0});
    for (int period = 0; period < 500 * kPwmPerTick; ++period) {
      tracker.step_pwm({0.2, 0.0});
    }
    const double angle_rad = tracker.truth().joint_angle_rad[kAzimuth];
    const double shown_rad = tracker.sample_tick().axis[kAzimuth].joint_angle_turn32 * 2.0 * kPi * 0x1.0p-32;
    read_rad[coarse] = std::remainder(shown_rad - angle_rad, 2.0 * kPi);
    TEST_ASSERT_TRUE(tracker.truth().joint_rate_rad_s[kAzimuth] > 0.5);
  }
  CHECK_NEAR("age of the reading, as an angle in rad", read_rad[0], read_rad[1], 2e-7);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_two_and_four_periods_per_step_move_the_axes_nearly_as_one);
  RUN_TEST(test_readings_within_a_step_are_as_old_as_with_one_period_per_step);
  return UNITY_END();
}
