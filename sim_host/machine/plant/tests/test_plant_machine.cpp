// SPDX-License-Identifier: Apache-2.0
// The simulated machine as a whole: motor, coupling, gravity, end stops, base motion.
#include <algorithm>
#include <cmath>

#include "machine/plant/motor.hpp"
#include "machine/plant/tracker.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

void run(Tracker& tracker, double seconds, double azimuth_duty = 0.0, double pitch_duty = 0.0) {
  const int steps = static_cast<int>(std::lround(seconds / kPwmPeriod_s));
  for (int step = 0; step < steps; ++step) {
    tracker.step_pwm({azimuth_duty, pitch_duty});
  }
}

void test_current_rises_as_the_exact_exponential() {
  MotorConfig config = bare_plant().axis[kAzimuth].motor;
  DcMotor motor(config, kPwmPeriod_s);
  motor.renew_shape(0.0);
  double charge = 0.0;
  for (int step = 1; step <= 200; ++step) {
    charge += motor.step(12.0, 0.0, 0.0, 48.0) / config.torque_constant_nm_a * kPwmPeriod_s;
    const double t = step * kPwmPeriod_s;
    const double tau = config.inductance_h / config.resistance_ohm;
    const double final_a = 12.0 / config.resistance_ohm;
    CHECK_NEAR("current in A", final_a * (1.0 - std::exp(-t / tau)), motor.current_a(), 1e-12);
    CHECK_NEAR("charge in As", final_a * (t - tau * (1.0 - std::exp(-t / tau))), charge, 1e-12);
  }
}

void test_ripple_follows_current_and_cogging_does_not() {
  MotorConfig config = bare_plant().axis[kAzimuth].motor;
  config.ripple = {RippleConfig{8, 0.015, 0.4}};
  config.cogging = {CoggingConfig{24, 0.05, 0.2}};
  for (const double angle : {0.0, 0.3, 1.7, -4.0}) {
    DcMotor motor(config, kPwmPeriod_s);
    motor.renew_shape(angle - 1e-4);  // used a little later, as at the end of a tick
    const double idle = motor.step(0.0, 0.0, angle, 48.0);
    CHECK_NEAR("cogging in Nm", 0.05 * std::sin(24.0 * angle + 0.2), idle, 5e-7);
    double loaded = 0.0;
    for (int step = 0; step < 2000; ++step) {
      loaded = motor.step(6.0, 0.0, angle, 48.0);
    }
    const double shape = 1.0 + 0.015 * std::cos(8.0 * angle + 0.4);
    CHECK_NEAR("torque of 5 A in Nm", 2.5 * 5.0 * shape + idle, loaded, 2e-6);
  }
}

void test_dead_time_eats_voltage_against_the_current() {
  MotorConfig config = bare_plant().axis[kAzimuth].motor;
  config.dead_time_s = 0.5e-6;  // 2 % of the period for both edges: 0.96 V of 48 V
  DcMotor motor(config, kPwmPeriod_s);
  for (int step = 0; step < 2000; ++step) {
    motor.step(-6.0, 0.0, 0.0, 48.0);
  }
  CHECK_NEAR("current in A", -(6.0 - 0.96) / 1.2, motor.current_a(), 1e-9);
}

void test_free_motor_reaches_its_no_load_speed_and_duty_is_clipped() {
  PlantConfig plant = bare_plant();
  plant.axis[kPitch].inertia_kg_m2 = 0.05;
  Tracker tracker(plant, 1);
  run(tracker, 3.0, 0.0, 7.5);
  CHECK_RELATIVE("rate in rad/s", 48.0 / 1.5, tracker.truth().joint_rate_rad_s[kPitch], 1e-3);
  run(tracker, 3.0, 0.0, std::nan(""));
  CHECK_NEAR("NaN shorts the motor", 0.0, tracker.truth().joint_rate_rad_s[kPitch], 0.05);
}

void test_duty_is_quantised_to_timer_counts() {
  PlantConfig plant = bare_plant();
  plant.supply.pwm_counts = 100;
  plant.axis[kAzimuth].inertia_kg_m2 = 1e6;  // stands still
  Tracker tracker(plant, 1);
  run(tracker, 0.1, 0.004);
  CHECK_NEAR("current below half a count, A", 0.0, tracker.truth().current_a[kAzimuth], 1e-12);
  run(tracker, 0.1, 0.013);
  CHECK_NEAR("current of one count, A", 0.01 * 48.0 / 1.2, tracker.truth().current_a[kAzimuth], 1e-4);
}

// Energy of the two bodies, written out from their masses.
double energy_j(const PlantConfig& plant, const TruthState& state) {
  const double cosine = std::cos(state.joint_angle_rad[kPitch]);
  const double azimuth_inertia =
      plant.axis[kAzimuth].inertia_kg_m2 + plant.axis[kAzimuth].inertia_swing_kg_m2 * cosine * cosine;
  const double kinetic = 0.5 * azimuth_inertia * std::pow(state.inertial_rate_rad_s[kAzimuth], 2.0) +
                         0.5 * plant.axis[kPitch].inertia_kg_m2 * std::pow(state.inertial_rate_rad_s[kPitch], 2.0);
  // Height of both off-centre masses above the tilted base.
  const LoadConfig& pitch = plant.axis[kPitch].load;
  const LoadConfig& azimuth = plant.axis[kAzimuth].load;
  const double p = state.joint_angle_rad[kPitch] + pitch.imbalance_phase_rad;
  const double a = state.joint_angle_rad[kAzimuth] - plant.base_tilt.direction_rad;
  const double tilt = plant.base_tilt.tilt_rad;
  return kinetic + pitch.imbalance_nm * (std::sin(p) * std::cos(tilt) + std::cos(p) * std::sin(tilt) * std::cos(a)) +
         azimuth.imbalance_nm * std::sin(tilt) * std::cos(a - azimuth.imbalance_phase_rad);
}

void test_energy_stays_constant_through_coupling_and_gravity() {
  PlantConfig plant = bare_plant();
  plant.base_tilt = {10.0 * kRadPerDeg, 30.0 * kRadPerDeg};
  plant.axis[kPitch].load.imbalance_nm = 6.0;
  plant.axis[kPitch].load.imbalance_phase_rad = 0.3;
  plant.axis[kAzimuth].load.imbalance_nm = 4.0;
  plant.axis[kAzimuth].load.imbalance_phase_rad = 0.7;
  for (AxisConfig& axis : plant.axis) {
    axis.motor.back_emf_constant_v_s_rad = 0.0;  // an idle motor must not brake
  }
  Tracker tracker(plant, 1);
  tracker.place({0.2, 0.5});
  run(tracker, 0.3, 0.35, 0.1);  // spin up, then let the currents die away
  run(tracker, 0.2);
  const double before = energy_j(plant, tracker.truth());
  double worst = 0.0;
  double min_azimuth = 1e9;
  double max_azimuth = -1e9;
  for (int step = 0; step < 200000; ++step) {
    tracker.step_pwm({0.0, 0.0});
    worst = std::max(worst, std::abs(energy_j(plant, tracker.truth()) - before));
    min_azimuth = std::min(min_azimuth, tracker.truth().joint_rate_rad_s[kAzimuth]);
    max_azimuth = std::max(max_azimuth, tracker.truth().joint_rate_rad_s[kAzimuth]);
  }
  LOG_VALUE("energy in J", before);
  LOG_VALUE("largest change in 10 s, J", worst);
  CHECK_AT_LEAST("azimuth's rate changes with pitch", 0.2, max_azimuth - min_azimuth);
  CHECK_AT_MOST("energy change relative to the energy", 2e-6, worst / before);
}

void test_angular_momentum_of_azimuth_survives_pitch() {
  PlantConfig plant = bare_plant();
  plant.axis[kAzimuth].motor.back_emf_constant_v_s_rad = 0.0;
  Tracker tracker(plant, 1);
  run(tracker, 0.2, 0.3, 0.0);
  run(tracker, 0.2);
  const auto momentum = [&] {
    return axis_inertia_kg_m2(plant, kAzimuth, tracker.truth().joint_angle_rad[kPitch]) *
           tracker.truth().inertial_rate_rad_s[kAzimuth];
  };
  const double before = momentum();
  run(tracker, 0.4, 0.0, 0.5);
  CHECK_AT_LEAST("pitch has moved, rad", 0.3, std::abs(tracker.truth().joint_angle_rad[kPitch]));
  CHECK_RELATIVE("momentum", before, momentum(), 1e-5);
}

void test_torques_of_the_truth_add_up_to_the_acceleration() {
  Tracker tracker(shipped_plant("tracker"), 3);
  tracker.place({0.1, 0.4});
  const PlantConfig plant = shipped_plant("tracker");
  double rate = tracker.truth().inertial_rate_rad_s[kPitch];
  for (int step = 0; step < 4000; ++step) {
    tracker.step_pwm({0.3, 0.25 * std::sin(0.01 * step)});
    const TruthState& now = tracker.truth();
    const double expected = now.motor_torque_nm[kPitch] - now.friction_torque_nm[kPitch] - now.load_torque_nm[kPitch];
    const double measured = plant.axis[kPitch].inertia_kg_m2 * (now.inertial_rate_rad_s[kPitch] - rate) / kPwmPeriod_s;
    rate = now.inertial_rate_rad_s[kPitch];
    CHECK_NEAR("J dw/dt in Nm", expected, measured, 1e-8);
  }
}

void test_end_stop_holds_and_returns_its_share_of_the_speed() {
  PlantConfig plant = bare_plant();
  plant.axis[kPitch].end_stops = EndStopConfig{-20.0 * kRadPerDeg, 95.0 * kRadPerDeg, 5e4, 0.3};
  plant.axis[kPitch].motor.back_emf_constant_v_s_rad = 0.0;
  Tracker tracker(plant, 1);
  tracker.place({0.0, 85.0 * kRadPerDeg});
  run(tracker, 0.2, 0.0, 0.02);
  run(tracker, 0.05);
  const double before = tracker.truth().joint_rate_rad_s[kPitch];
  double deepest = 0.0;
  double after = 0.0;
  for (int step = 0; step < 40000; ++step) {
    tracker.step_pwm({0.0, 0.0});
    deepest = std::max(deepest, tracker.truth().joint_angle_rad[kPitch] - 95.0 * kRadPerDeg);
    after = tracker.truth().joint_rate_rad_s[kPitch];
  }
  LOG_VALUE("impact in deg/s", before / kRadPerDeg);
  LOG_VALUE("overrun in deg", deepest / kRadPerDeg);
  CHECK_AT_LEAST("it hits", 1e-6, deepest);
  CHECK_AT_MOST("overrun in deg", 1.0, deepest / kRadPerDeg);
  CHECK_NEAR("speed returned", -0.3, after / before, 0.03);
  run(tracker, 4.0, 0.0, 0.5);  // full push: 48 V / 2 / 1.2 ohm * 1.5 Nm/A = 30 Nm
  CHECK_NEAR("held within the stiffness, deg", 30.0 / 5e4 / kRadPerDeg,
             tracker.truth().joint_angle_rad[kPitch] / kRadPerDeg - 95.0, 1e-3);
}

void test_without_end_stops_the_joint_turns_on() {
  Tracker tracker(bare_plant(), 1);
  run(tracker, 3.0, 0.5, 0.0);
  CHECK_AT_LEAST("azimuth in turns", 2.0, tracker.truth().joint_angle_rad[kAzimuth] / (2.0 * kPi));
}

// Pitch alone, without anything else that could hold it; the brake's coil has no current.
Tracker braked_tracker(double push_nm) {
  PlantConfig plant = bare_plant();
  plant.axis[kPitch].motor.back_emf_constant_v_s_rad = 0.0;
  plant.axis[kPitch].holding_brake = HoldingBrakeConfig{15.0, 0.03, 0.02};
  Tracker tracker(plant, 1);
  tracker.fit_holding_brakes();
  tracker.push(kPitch, push_nm);
  return tracker;
}

void test_a_holding_brake_holds_up_to_its_torque_and_slips_beyond() {
  for (const double push_nm : {14.9, -14.9}) {
    Tracker held = braked_tracker(push_nm);
    run(held, 1.0);
    CHECK_SAME("joint angle in rad", 0.0, held.truth().joint_angle_rad[kPitch]);
    Tracker slipping = braked_tracker(1.2 * push_nm);
    run(slipping, 1.0);
    const double beyond_nm = 1.2 * push_nm - std::copysign(15.0, push_nm);
    CHECK_RELATIVE("speed in rad/s", beyond_nm / 2.5, slipping.truth().joint_rate_rad_s[kPitch], 1e-3);
  }
}

void test_a_holding_brake_opens_and_closes_in_its_times_and_stops_a_turning_joint() {
  Tracker tracker = braked_tracker(10.0);
  tracker.power_brake(kPitch, true);
  run(tracker, 0.0199);
  CHECK_SAME("still closed, rad/s", 0.0, tracker.truth().joint_rate_rad_s[kPitch]);
  run(tracker, 0.5);
  const double free_s = 0.5 - 0.0001;
  CHECK_RELATIVE("free, rad/s", 10.0 * free_s / 2.5, tracker.truth().joint_rate_rad_s[kPitch], 1e-3);
  tracker.power_brake(kPitch, false);
  run(tracker, 0.03);
  CHECK_RELATIVE("still open, rad/s", 10.0 * (free_s + 0.03) / 2.5, tracker.truth().joint_rate_rad_s[kPitch], 1e-3);
  run(tracker, 0.5);  // 5 Nm are left to brake with
  CHECK_RELATIVE("slowed, rad/s", 10.0 * (free_s + 0.03) / 2.5 - 5.0 * 0.5 / 2.5,
                 tracker.truth().joint_rate_rad_s[kPitch], 1e-3);
  run(tracker, 1.0);
  const double stopped_rad = tracker.truth().joint_angle_rad[kPitch];
  run(tracker, 1.0);
  CHECK_SAME("stands, rad", stopped_rad, tracker.truth().joint_angle_rad[kPitch]);
}

void test_a_brake_that_is_not_fitted_does_nothing() {
  PlantConfig plant = bare_plant();
  plant.axis[kPitch].motor.back_emf_constant_v_s_rad = 0.0;
  Tracker tracker(plant, 1);
  tracker.push(kPitch, 1.0);
  tracker.power_brake(kPitch, false);
  run(tracker, 1.0);
  CHECK_RELATIVE("rad/s", 1.0 / 2.5, tracker.truth().joint_rate_rad_s[kPitch], 1e-3);
}

void test_a_free_axis_keeps_its_line_of_sight_while_the_base_sways() {
  PlantConfig plant = bare_plant();
  plant.axis[kPitch].motor.back_emf_constant_v_s_rad = 0.0;
  plant.axis[kPitch].base_sway = {1e-3, 1.5, 0.1};
  Tracker tracker(plant, 5);
  const double rate = tracker.truth().inertial_rate_rad_s[kPitch];  // at rest on the moving base
  const double angle = tracker.truth().inertial_angle_rad[kPitch];
  double least = 0.0;
  double most = 0.0;
  for (int step = 0; step < 100000; ++step) {
    tracker.step_pwm({0.0, 0.0});
    CHECK_NEAR("inertial rate in rad/s", rate, tracker.truth().inertial_rate_rad_s[kPitch], 1e-12);
    const double base = tracker.truth().inertial_angle_rad[kPitch] - tracker.truth().joint_angle_rad[kPitch];
    least = std::min(least, base);
    most = std::max(most, base);
  }
  CHECK_NEAR("line of sight moves straight, rad", angle + 5.0 * rate, tracker.truth().inertial_angle_rad[kPitch], 1e-7);
  CHECK_AT_LEAST("the base swayed, rad", 1e-3, most - least);
}

void test_seal_eccentricity_shows_once_per_turn_of_the_joint() {
  PlantConfig plant = bare_plant();
  plant.friction_model = FrictionModel::kLugre;
  plant.axis[kAzimuth].friction.eccentricity_once = 0.2;
  plant.axis[kAzimuth].friction.eccentricity_once_phase_rad = 0.5;
  Tracker tracker(plant, 1);
  double least = 1e9;
  double most = 0.0;
  double angle_of_max = 0.0;
  for (int step = 0; step < 400000; ++step) {
    tracker.step_pwm({0.22, 0.0});  // about 1 rad/s
    const double rate = tracker.truth().joint_rate_rad_s[kAzimuth];
    if (rate < 0.5) {
      continue;
    }
    const double dry =
        tracker.truth().friction_torque_nm[kAzimuth] - plant.axis[kAzimuth].friction.positive.viscous_nm_s_rad * rate;
    least = std::min(least, dry);
    if (dry > most) {
      most = dry;
      angle_of_max = tracker.truth().joint_angle_rad[kAzimuth];
    }
  }
  CHECK_RELATIVE("least level in Nm", 6.0 * 0.8, least, 0.01);
  CHECK_RELATIVE("highest level in Nm", 6.0 * 1.2, most, 0.01);
  CHECK_NEAR("angle of the highest level", 0.5, std::remainder(angle_of_max, 2.0 * kPi), 0.1);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_current_rises_as_the_exact_exponential);
  RUN_TEST(test_ripple_follows_current_and_cogging_does_not);
  RUN_TEST(test_dead_time_eats_voltage_against_the_current);
  RUN_TEST(test_free_motor_reaches_its_no_load_speed_and_duty_is_clipped);
  RUN_TEST(test_duty_is_quantised_to_timer_counts);
  RUN_TEST(test_energy_stays_constant_through_coupling_and_gravity);
  RUN_TEST(test_angular_momentum_of_azimuth_survives_pitch);
  RUN_TEST(test_torques_of_the_truth_add_up_to_the_acceleration);
  RUN_TEST(test_end_stop_holds_and_returns_its_share_of_the_speed);
  RUN_TEST(test_without_end_stops_the_joint_turns_on);
  RUN_TEST(test_a_holding_brake_holds_up_to_its_torque_and_slips_beyond);
  RUN_TEST(test_a_holding_brake_opens_and_closes_in_its_times_and_stops_a_turning_joint);
  RUN_TEST(test_a_brake_that_is_not_fitted_does_nothing);
  RUN_TEST(test_a_free_axis_keeps_its_line_of_sight_while_the_base_sways);
  RUN_TEST(test_seal_eccentricity_shows_once_per_turn_of_the_joint);
  return UNITY_END();
}
