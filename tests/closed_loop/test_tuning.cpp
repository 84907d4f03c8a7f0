// SPDX-License-Identifier: Apache-2.0
// Gains are changed while the axis turns: the torque must not jump in the tick of the change, and the speed must stay
// in its band. Two machines of one seed run side by side, equal bit for bit until one of them is retuned.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench.hpp"
#include "device/node_setup.hpp"
#include "machine/run/machine.hpp"
#include "support/test_size.h"
#include "unity.h"

extern "C" {
#include "parameters/axis_tuning.h"
}

namespace sim = trackservo::sim;
using bench::kRadPerDeg;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr double kRated_nm = 40.0;
constexpr double kLargestJump_nm = 0.01 * kRated_nm;
constexpr double kRate_deg_s = 1.0;
constexpr int kSettleTicks = 2000;
constexpr int kChangeTicks = 157;  // time between two of them; no multiple of any period of the machine

using Change = std::function<void(axis_parameters&)>;

// A machine with the node's parameters, and the tuning object of azimuth.
class Bench {
 public:
  explicit Bench(const sim::PlantConfig& plant) : machine_(plant, 9, {0.0, 0.3}) {
    servo_params params;
    for (int axis = 0; axis < sim::kAxes; ++axis) {
      const axis_parameters parameters = sim::node_parameters(plant, axis);
      TEST_ASSERT_EQUAL(CONTROL_OK, axis_tuning_start(&tuning_[axis], &parameters, &params.axis[axis]));
    }
    TEST_ASSERT_EQUAL(CONTROL_OK, servo_board_start(&board_, machine_.hal_pointer(), &params));
    machine_.run_firmware(board_, [this] { servo_board_tick(&board_); });
    for (servo_axis_command& command : machine_.command().axis) {
      command.mode = SERVO_SPEED;
    }
    machine_.command().axis[sim::kAzimuth].speed.rate_rad_s = static_cast<float>(kRate_deg_s * kRadPerDeg);
  }

  void run(int ticks) {
    for (int tick = 0; tick < ticks; ++tick) {
      machine_.advance_tick();
    }
  }

  void change(const Change& write) {
    axis_tuning& tuning = tuning_[sim::kAzimuth];
    write(tuning.staged);
    TEST_ASSERT_EQUAL(CONTROL_OK, axis_tuning_apply(&tuning, &board_.app.axis[sim::kAzimuth],
                                                    &board_.app.params.axis[sim::kAzimuth], SERVO_TICK_S));
  }

  void undo() {
    TEST_ASSERT_EQUAL(CONTROL_OK, axis_tuning_undo(&tuning_[sim::kAzimuth], &board_.app.axis[sim::kAzimuth],
                                                   &board_.app.params.axis[sim::kAzimuth], SERVO_TICK_S));
  }

  double torque_nm() const { return static_cast<double>(machine_.firmware(sim::kAzimuth).commanded_nm); }
  double rate_deg_s() const { return machine_.truth().inertial_rate_rad_s[sim::kAzimuth] / kRadPerDeg; }

 private:
  sim::Machine machine_;
  servo_board board_{};
  axis_tuning tuning_[sim::kAxes]{};
};

sim::PlantConfig noisy_plant() { return sim::load_plant("sim_host/plants/tracker.toml"); }

// The same machine with noise-free sensors. New gains weight the noise of their first sample differently, which is no
// jump; without noise the whole difference is one.
sim::PlantConfig quiet_plant() {
  sim::PlantConfig plant = noisy_plant();
  plant.adc.current_noise_rms_a = 0.0;
  for (sim::AxisConfig& axis : plant.axis) {
    axis.encoder.jitter_rms_rad = 0.0;
    axis.gyro.noise_density_rad_s_rthz = 0.0;
  }
  return plant;
}

struct Worst {
  double jump_nm = 0.0;        // between the machines, in the tick of the change
  double step_nm = 0.0;        // from the previous tick, on the machine that is changed
  double usual_step_nm = 0.0;  // the largest tick-to-tick change of the unchanged machine, in the next 0.2 s
  double speed_error_deg_s = 0.0;
};

// The first tick with the new gains, and the speed in the next second.
void compare_one_change(const sim::PlantConfig& plant, int ticks_before, const Change& write, bool back, Worst& worst) {
  Bench changed(plant);
  Bench left_alone(plant);
  if (back) {
    changed.change(write);
    left_alone.change(write);
  }
  changed.run(ticks_before);
  left_alone.run(ticks_before);
  TEST_ASSERT_EQUAL_DOUBLE(left_alone.torque_nm(), changed.torque_nm());
  double before_nm = changed.torque_nm();
  if (back) {
    changed.undo();
  } else {
    changed.change(write);
  }
  changed.run(1);
  left_alone.run(1);
  worst.jump_nm = std::max(worst.jump_nm, std::abs(changed.torque_nm() - left_alone.torque_nm()));
  worst.step_nm = std::max(worst.step_nm, std::abs(changed.torque_nm() - before_nm));
  for (int tick = 0; tick < 200; ++tick) {
    worst.usual_step_nm = std::max(worst.usual_step_nm, std::abs(left_alone.torque_nm() - before_nm));
    before_nm = left_alone.torque_nm();
    left_alone.run(1);
  }
  for (int tick = 0; tick < 1000; ++tick) {
    changed.run(1);
    worst.speed_error_deg_s = std::max(worst.speed_error_deg_s, std::abs(changed.rate_deg_s() - kRate_deg_s));
  }
}

// Changes of each parameter at several places of the turn, forward and back.
Worst worst_of(const sim::PlantConfig& plant, const Change& write) {
  Worst worst;
  for (int i = 0; i < by_size(2, 12, 100); ++i) {
    compare_one_change(plant, kSettleTicks + i * kChangeTicks, write, i % 2 == 1, worst);
  }
  return worst;
}

void expect_bumpless(const char *name, double speed_band_deg_s, const Change& write) {
  const Worst quiet = worst_of(quiet_plant(), write);
  const Worst noisy = worst_of(noisy_plant(), write);
  char text[200];
  (void)std::snprintf(text, sizeof text,
                      "%s: jump %.4f Nm (with noise %.4f; its step %.3f, usual steps %.3f), speed error %.4f deg/s",
                      name, quiet.jump_nm, noisy.jump_nm, noisy.step_nm, noisy.usual_step_nm, noisy.speed_error_deg_s);
  TEST_MESSAGE(text);
  TEST_ASSERT_TRUE_MESSAGE(quiet.jump_nm <= kLargestJump_nm, name);
  TEST_ASSERT_TRUE_MESSAGE(noisy.step_nm <= noisy.usual_step_nm + kLargestJump_nm, name);
  TEST_ASSERT_TRUE_MESSAGE(noisy.speed_error_deg_s <= speed_band_deg_s, name);
}

// With the designed gains the speed stays within this of 1 deg/s, gusts included.
constexpr double kBand_deg_s = 0.02;

// While the observer is off, PI alone acts against the gusts.
constexpr double kPiBand_deg_s = 0.1;

void test_nothing_changes_when_the_same_gains_are_applied() {
  const Worst worst = worst_of(noisy_plant(), [](axis_parameters&) {});
  TEST_ASSERT_EQUAL_DOUBLE(0.0, worst.jump_nm);
  TEST_ASSERT_TRUE(worst.speed_error_deg_s <= kBand_deg_s);
}

void test_proportional_gain_is_changed_without_a_jump() {
  for (const float factor : {0.7F, 1.3F}) {
    expect_bumpless(factor < 1.0F ? "Kp -30 %" : "Kp +30 %", kBand_deg_s,
                    [factor](axis_parameters& p) { p.speed_loop.proportional_nm_s_rad *= factor; });
  }
}

void test_integral_gain_and_setpoint_weight_are_changed_without_a_jump() {
  for (const float factor : {0.5F, 2.0F}) {
    expect_bumpless(factor < 1.0F ? "Ki halved" : "Ki doubled", kBand_deg_s,
                    [factor](axis_parameters& p) { p.speed_loop.integral_nm_rad *= factor; });
  }
  expect_bumpless("set-point weight 1", kBand_deg_s, [](axis_parameters& p) { p.speed_loop.setpoint_weight = 1.0F; });
}

void test_observer_is_changed_without_a_jump() {
  for (const float factor : {0.5F, 1.3F}) {
    expect_bumpless(factor < 1.0F ? "observer bandwidth halved" : "observer bandwidth +30 %", kBand_deg_s,
                    [factor](axis_parameters& p) { p.observer.bandwidth_rad_s *= factor; });
  }
  expect_bumpless("observer inertia +20 %", kBand_deg_s, [](axis_parameters& p) { p.observer.inertia_kg_m2 *= 1.2F; });
}

void test_observer_is_switched_off_and_on_without_a_jump() {
  expect_bumpless("observer off and on", kPiBand_deg_s, [](axis_parameters& p) { p.observer.on = 0; });
}

void test_friction_feedforward_is_changed_without_a_jump() {
  expect_bumpless("friction gain 0.5", kBand_deg_s, [](axis_parameters& p) { p.friction.gain = 0.5F; });
  expect_bumpless("friction model off", kBand_deg_s, [](axis_parameters& p) { p.friction.model = FRICTION_NONE; });
  expect_bumpless("friction model Coulomb", kBand_deg_s,
                  [](axis_parameters& p) { p.friction.model = FRICTION_COULOMB; });
  expect_bumpless("friction torques -30 %", kBand_deg_s, [](axis_parameters& p) {
    for (lugre_direction *direction : {&p.friction.positive, &p.friction.negative}) {
      direction->coulomb_nm *= 0.7F;
      direction->breakaway_nm *= 0.7F;
      direction->viscous_nm_s_rad *= 1.3F;
    }
  });
  expect_bumpless("bristle stiffness doubled", kBand_deg_s,
                  [](axis_parameters& p) { p.friction.stiffness_nm_rad *= 2.0F; });
}

void test_filters_are_put_in_and_taken_out_without_a_jump() {
  expect_bumpless("notch 120 Hz", kBand_deg_s, [](axis_parameters& p) {
    p.filters.notch_hz = 120.0F;
    p.filters.notch_width_hz = 20.0F;
  });
  expect_bumpless("low-pass 300 Hz", kBand_deg_s, [](axis_parameters& p) { p.filters.lowpass_hz = 300.0F; });
}

void test_rate_sensors_are_changed_without_a_jump() {
  expect_bumpless("fusion crossover halved", kBand_deg_s,
                  [](axis_parameters& p) { p.sensors.crossover_rad_s *= 0.5F; });
}

void test_everything_at_once_is_changed_without_a_jump() {
  expect_bumpless("all at once", kBand_deg_s, [](axis_parameters& p) {
    p.speed_loop.proportional_nm_s_rad *= 0.8F;
    p.speed_loop.integral_nm_rad *= 0.7F;
    p.observer.bandwidth_rad_s *= 0.7F;
    p.friction.gain = 0.8F;
    p.filters.lowpass_hz = 300.0F;
  });
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_nothing_changes_when_the_same_gains_are_applied);
  RUN_TEST(test_proportional_gain_is_changed_without_a_jump);
  RUN_TEST(test_integral_gain_and_setpoint_weight_are_changed_without_a_jump);
  RUN_TEST(test_observer_is_changed_without_a_jump);
  RUN_TEST(test_observer_is_switched_off_and_on_without_a_jump);
  RUN_TEST(test_friction_feedforward_is_changed_without_a_jump);
  RUN_TEST(test_filters_are_put_in_and_taken_out_without_a_jump);
  RUN_TEST(test_rate_sensors_are_changed_without_a_jump);
  RUN_TEST(test_everything_at_once_is_changed_without_a_jump);
  return UNITY_END();
}
