// SPDX-License-Identifier: Apache-2.0
// Both axes side by side give bit for bit what each gives alone: sliding, sticking, braked, held, and at an end stop.
#include "machine/plant/lanes.hpp"

#include <cmath>
#include <cstring>
#include <limits>

#include "machine/base/random.hpp"
#include "machine/plant/joint.hpp"
#include "machine/plant/motor.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

// Two axes that differ, with end stops close enough to be hit.
std::array<AxisConfig, 2> two_axes() {
  std::array<AxisConfig, 2> axes{bare_plant().axis[kAzimuth], bare_plant().axis[kPitch]};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const double size = i == 0 ? 1.0 : 0.5;
    axes[i].friction.stiffness_nm_rad = 30000.0 * size;
    axes[i].friction.damping_nm_s_rad = 300.0 * size;
    axes[i].friction.positive = {6.0 * size, 9.0 * size, 0.005, 8.0};
    axes[i].friction.negative = {6.3 * size, 9.45 * size, 0.006, 8.4};
    axes[i].end_stops = EndStopConfig{-0.02, 0.03 * size, 1e5, 0.3};
  }
  return axes;
}

int differing_steps(FrictionModel model) {
  const std::array<AxisConfig, 2> axes = two_axes();
  JointPair both_joints(axes, model, MaxwellSlipConfig{}, kPwmPeriod_s);
  std::array<Joint, 2> alone{Joint(axes[0], model, MaxwellSlipConfig{}, kPwmPeriod_s),
                             Joint(axes[1], model, MaxwellSlipConfig{}, kPwmPeriod_s)};
  RandomStream random(1, "lanes");
  std::array<double, 2> drive_nm{};
  int differing = 0;
  for (int step = 0; step < 40000; ++step) {
    for (std::size_t i = 0; i < 2; ++i) {
      if (random.uniform() < 0.002) {
        drive_nm[i] = 40.0 * (random.uniform() - 0.5);
        const double brake_nm = random.uniform() < 0.3 ? 20.0 * random.uniform() : 0.0;
        const bool held = random.uniform() < 0.1;
        both_joints.brake(brake_nm, i);
        both_joints.hold(held, i);
        alone[i].brake(brake_nm);
        alone[i].hold(held);
      }
      alone[i].step(2.0 + static_cast<double>(i), drive_nm[i], 0.1);
    }
    both_joints.step(Pair{2.0, 3.0}, Pair{drive_nm[0], drive_nm[1]}, Pair{0.1, 0.1});
    for (std::size_t i = 0; i < 2; ++i) {
      const bool same = same_bits(both_joints.angle_rad()[i], alone[i].angle_rad()) &&
                        same_bits(both_joints.rate_rad_s()[i], alone[i].rate_rad_s()) &&
                        same_bits(both_joints.friction_torque_nm()[i], alone[i].friction_torque_nm()) &&
                        same_bits(both_joints.stop_torque_nm()[i], alone[i].stop_torque_nm());
      differing += same ? 0 : 1;
    }
  }
  LOG_VALUE("angle at the end, urad", alone[0].angle_rad() * 1e6);
  return differing;
}

void test_two_joints_side_by_side_move_as_each_alone() {
  for (const FrictionModel model : {FrictionModel::kLugre, FrictionModel::kMaxwellSlip, FrictionModel::kNone}) {
    TEST_ASSERT_EQUAL_INT(0, differing_steps(model));
  }
}

void test_two_motors_side_by_side_give_the_torque_of_each_alone() {
  std::array<MotorConfig, 2> configs{bare_plant().axis[kAzimuth].motor, bare_plant().axis[kPitch].motor};
  configs[0].dead_time_s = 0.5e-6;  // the other one has none
  MotorPair both_motors(configs, kPwmPeriod_s);
  std::array<DcMotor, 2> alone{DcMotor(configs[0], kPwmPeriod_s), DcMotor(configs[1], kPwmPeriod_s)};
  RandomStream random(2, "lanes");
  int differing = 0;
  for (int step = 0; step < 20000; ++step) {
    const Pair voltage_v{40.0 * (random.uniform() - 0.5), 40.0 * (random.uniform() - 0.5)};
    for (std::size_t i = 0; i < 2; ++i) {
      const bool open = random.uniform() < 0.3;
      both_motors.open_terminals(open, i);
      alone[i].open_terminals(open);
    }
    const Pair torque_nm = both_motors.step(voltage_v, Pair{0.5, -0.5}, Pair{0.1, 0.2}, 48.0);
    for (std::size_t i = 0; i < 2; ++i) {
      const double one_nm = alone[i].step(voltage_v[i], i == 0 ? 0.5 : -0.5, i == 0 ? 0.1 : 0.2, 48.0);
      differing += same_bits(one_nm, torque_nm[i]) ? 0 : 1;
    }
  }
  TEST_ASSERT_EQUAL_INT(0, differing);
}

void test_signs_and_magnitudes_keep_negative_zero_and_infinity() {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double value : {0.0, -0.0, 1.5, -1.5, kInfinity, -kInfinity}) {
    for (const double sign : {0.0, -0.0, 2.0, -2.0}) {
      const Pair result = with_sign(Pair{value, 1.0}, Pair{sign, -sign});
      TEST_ASSERT_TRUE(same_bits(std::copysign(value, sign), result[0]));
      TEST_ASSERT_TRUE(same_bits(std::copysign(1.0, -sign), result[1]));
    }
    TEST_ASSERT_TRUE(same_bits(std::abs(value), magnitude(Pair{1.0, value})[1]));
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_two_joints_side_by_side_move_as_each_alone);
  RUN_TEST(test_two_motors_side_by_side_give_the_torque_of_each_alone);
  RUN_TEST(test_signs_and_magnitudes_keep_negative_zero_and_infinity);
  return UNITY_END();
}
