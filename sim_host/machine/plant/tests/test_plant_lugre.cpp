// SPDX-License-Identifier: Apache-2.0
// The plant's LuGre joint (rate and bristles solved together) against Boost.Odeint's rosenbrock4 at 1e-10.
//
// Both get the same torque over time; the joint rates are compared after every 50 us.
#include <algorithm>
#include <cmath>

#include "machine/plant/joint.hpp"
#include "support/bench.hpp"
#include "support/check.h"
#include "support/lugre_ode.hpp"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;
using lugre_ode::Vector;

struct Bench {
  AxisConfig axis;
  double inertia_kg_m2;
};

// The tracker's azimuth at its horizon: stiff contact, s0/J = 5000 1/s2, directions 5 % apart.
Bench stiff_bench() { return {bare_plant().axis[kAzimuth], 6.0}; }

Bench paper_bench() { return {shipped_plant("paper_simulation").axis[kAzimuth], 23.5}; }

// Slope of (rate, bristle torque s0 z) by eqs (1)-(3), written a second time.
struct Continuous {
  FrictionConfig seal;
  double inertia_kg_m2;

  const StribeckConfig& direction(double rate) const { return rate >= 0.0 ? seal.positive : seal.negative; }

  double force_slope(double rate, double force) const {
    const StribeckConfig& d = direction(rate);
    const double g =
        d.coulomb_nm + (d.breakaway_nm - d.coulomb_nm) * std::exp(-std::pow(rate / d.stribeck_speed_rad_s, 2.0));
    return seal.stiffness_nm_rad * (rate - std::abs(rate) * force / g);
  }

  double torque(double rate, double force) const {
    return force + seal.damping_nm_s_rad / seal.stiffness_nm_rad * force_slope(rate, force) +
           direction(rate).viscous_nm_s_rad * rate;
  }
};

struct Comparison {
  double rate_rad_s = 0;          // largest difference
  double largest_rate_rad_s = 0;  // largest rate, as a reference
  double end_rate_rad_s = 0;
  double end_angle_rad = 0;
};

// Drives both from rest with torque(time, angle) for a time. The plant takes the torque in the middle of its step.
template <class Torque>
Comparison compare(const Bench& bench, Torque torque, double duration_s) {
  Joint joint(bench.axis, FrictionModel::kLugre, MaxwellSlipConfig{}, kPwmPeriod_s);
  const Continuous model{bench.axis.friction, bench.inertia_kg_m2};
  const auto rhs = [&model, &torque](const Vector& x, Vector& slope, double time) {
    slope(0) = (torque(time, x(2)) - model.torque(x(0), x(1))) / model.inertia_kg_m2;
    slope(1) = model.force_slope(x(0), x(1));
    slope(2) = x(0);
  };
  Vector state(3, 0.0);
  Comparison seen;
  const int steps = static_cast<int>(std::lround(duration_s / kPwmPeriod_s));
  for (int step = 0; step < steps; ++step) {
    const double start = step * kPwmPeriod_s;
    const double middle_angle = joint.angle_rad() + 0.5 * kPwmPeriod_s * joint.rate_rad_s();
    joint.step(bench.inertia_kg_m2, torque(start + 0.5 * kPwmPeriod_s, middle_angle), 0.0);
    // Restarted every 50 us: longer stretches would show the solver's own error, from the kink at standstill.
    lugre_ode::solve(rhs, state, start, start + kPwmPeriod_s, 0.2 * kPwmPeriod_s, 1e-10);
    seen.rate_rad_s = std::max(seen.rate_rad_s, std::abs(joint.rate_rad_s() - state(0)));
    seen.largest_rate_rad_s = std::max(seen.largest_rate_rad_s, std::abs(state(0)));
  }
  seen.end_rate_rad_s = joint.rate_rad_s();
  seen.end_angle_rad = joint.angle_rad();
  return seen;
}

void test_breakaway_on_a_torque_ramp_agrees() {
  const Comparison seen = compare(
      stiff_bench(), [](double t, double) { return 10.0 * t; }, 1.2);
  LOG_VALUE("break-away on a 10 Nm/s ramp, largest rate error in deg/s", seen.rate_rad_s / kRadPerDeg);
  LOG_VALUE("rate at the end in deg/s", seen.largest_rate_rad_s / kRadPerDeg);
  CHECK_AT_LEAST("the joint broke away", 5.0 * kRadPerDeg, seen.largest_rate_rad_s);
  CHECK_AT_MOST("rate error in deg/s", 1e-3, seen.rate_rad_s / kRadPerDeg);
}

void test_reversals_agree() {
  const auto sine = [](double t, double) { return 14.0 * std::sin(2.0 * kPi * 2.0 * t); };
  const Comparison stiff = compare(stiff_bench(), sine, 2.0);
  const Comparison paper = compare(paper_bench(), sine, 2.0);
  LOG_VALUE("reversals, tracker, largest rate error in deg/s", stiff.rate_rad_s / kRadPerDeg);
  LOG_VALUE("of", stiff.largest_rate_rad_s / kRadPerDeg);
  LOG_VALUE("reversals, paper, largest rate error in deg/s", paper.rate_rad_s / kRadPerDeg);
  CHECK_AT_MOST("rate error, tracker, of the largest rate", 2e-5, stiff.rate_rad_s / stiff.largest_rate_rad_s);
  CHECK_AT_MOST("rate error, paper, of the largest rate", 2e-5, paper.rate_rad_s / paper.largest_rate_rad_s);
}

void test_presliding_hysteresis_agrees() {
  // 4 Nm of 9 Nm break-away, with a smaller loop added to it.
  const auto loops = [](double t, double) {
    return 4.0 * std::sin(2.0 * kPi * t) + 1.5 * std::sin(2.0 * kPi * 5.0 * t);
  };
  const Comparison seen = compare(stiff_bench(), loops, 3.0);
  LOG_VALUE("pre-sliding, largest rate error in deg/s", seen.rate_rad_s / kRadPerDeg);
  LOG_VALUE("of", seen.largest_rate_rad_s / kRadPerDeg);
  CHECK_AT_MOST("stays in pre-sliding, deg/s", 0.3, seen.largest_rate_rad_s / kRadPerDeg);
  CHECK_AT_MOST("rate error of the largest rate", 1e-4, seen.rate_rad_s / seen.largest_rate_rad_s);
}

void test_stick_slip_of_a_joint_pulled_by_a_spring_agrees() {
  // A 60 Nm/rad spring pulled at 2 deg/s; both slip at the same times with the same speed.
  const auto spring = [](double t, double angle) { return 60.0 * (2.0 * kRadPerDeg * t - angle); };
  const Comparison seen = compare(stiff_bench(), spring, 7.0);
  LOG_VALUE("stick-slip, largest rate error in deg/s", seen.rate_rad_s / kRadPerDeg);
  LOG_VALUE("of", seen.largest_rate_rad_s / kRadPerDeg);
  CHECK_AT_LEAST("it slips faster than it is pulled, deg/s", 3.0, seen.largest_rate_rad_s / kRadPerDeg);
  CHECK_AT_MOST("rate error of the largest rate", 2e-3, seen.rate_rad_s / seen.largest_rate_rad_s);
}

void test_every_speed_from_0_01_to_200_deg_per_s_agrees() {
  // The torque that holds the speed, as a step from rest: the settling is compared too.
  const Bench bench = stiff_bench();
  for (const double speed : {0.01, 0.1, 1.0, 10.0, 50.0, 200.0}) {
    const double rate = speed * kRadPerDeg;
    const double hold = steady_friction_nm(bench.axis.friction, rate);
    const auto servo = [rate, hold](double t, double angle) {
      const double ramp = std::min(t / 0.2, 1.0);  // reach the speed smoothly, hold it by a stiff spring
      const double position = rate * (t < 0.2 ? 0.5 * t * ramp : t - 0.1);
      return hold * ramp + 6.0 * rate * (t < 0.2 ? 5.0 : 0.0) + 3000.0 * (position - angle);
    };
    const Comparison seen = compare(bench, servo, 0.6);
    LOG_VALUE("speed in deg/s", speed);
    LOG_VALUE("  largest rate error in deg/s", seen.rate_rad_s / kRadPerDeg);
    CHECK_AT_MOST("rate error of the speed", 1e-4, seen.rate_rad_s / seen.largest_rate_rad_s);
  }
}

void test_halving_the_step_quarters_the_error() {
  const Bench bench = stiff_bench();
  const auto torque = [](double t) { return 14.0 * std::sin(2.0 * kPi * 2.0 * t + 0.3); };
  const auto end_rate = [&](double dt_s) {
    Joint joint(bench.axis, FrictionModel::kLugre, MaxwellSlipConfig{}, dt_s);
    const int steps = static_cast<int>(std::lround(0.3 / dt_s));
    for (int step = 0; step < steps; ++step) {
      joint.step(bench.inertia_kg_m2, torque((step + 0.5) * dt_s), 0.0);
    }
    return joint.rate_rad_s();
  };
  const double exact = end_rate(1.5625e-6);
  const double ratio = (end_rate(200e-6) - exact) / (end_rate(100e-6) - exact);
  LOG_VALUE("error at 200 us over error at 100 us", ratio);
  CHECK_NEAR("second order", 4.0, ratio, 1.2);
}

void test_extreme_seals_stay_bounded() {
  // Stiffness, damping and speed far outside a seal's: the theta step must not oscillate or diverge.
  for (const double stiffness : {1e-2, 1e3, 1e6, 1e9}) {
    for (const double damping : {0.0, 10.0, 1e6}) {
      for (const double stribeck : {1e-5, 1e-2, 10.0}) {
        Bench bench = stiff_bench();
        bench.axis.friction.stiffness_nm_rad = std::max(stiffness, 10.0);
        bench.axis.friction.damping_nm_s_rad = damping;
        bench.axis.friction.positive.stribeck_speed_rad_s = stribeck;
        bench.axis.friction.negative.stribeck_speed_rad_s = stribeck;
        Joint joint(bench.axis, FrictionModel::kLugre, MaxwellSlipConfig{}, kPwmPeriod_s);
        for (int step = 0; step < 40000; ++step) {
          const double drive = step < 20000 ? 200.0 * std::sin(0.002 * step) : 0.0;
          joint.step(0.5, drive, 0.0);
          TEST_ASSERT_TRUE(std::isfinite(joint.rate_rad_s()));
          CHECK_AT_MOST("rate in rad/s", 1e3, std::abs(joint.rate_rad_s()));
        }
      }
    }
  }
}

void test_a_joint_loaded_below_breakaway_follows_the_bristle_curve_and_springs_back() {
  // Slowly, eq. (2) integrates to x = Ts/s0 ln(Ts/(Ts - T)) on loading and Ts/s0 ln((Ts + T)/Ts) on unloading.
  const Bench bench = stiff_bench();
  Joint joint(bench.axis, FrictionModel::kLugre, MaxwellSlipConfig{}, kPwmPeriod_s);
  const int steps = 60000;
  for (int step = 0; step < steps; ++step) {
    joint.step(bench.inertia_kg_m2, 3.0 * step / steps, 0.0);
  }
  const double bent = joint.angle_rad();
  for (int step = 0; step < steps; ++step) {
    joint.step(bench.inertia_kg_m2, 3.0 - 3.0 * step / steps, 0.0);
  }
  const FrictionConfig& seal = bench.axis.friction;
  const double forward = seal.positive.breakaway_nm;
  const double back = seal.negative.breakaway_nm;
  const double expected_bent = forward / seal.stiffness_nm_rad * std::log(forward / (forward - 3.0));
  const double expected_back = back / seal.stiffness_nm_rad * std::log((back + 3.0) / back);
  LOG_VALUE("bent by 3 Nm, urad", bent * 1e6);
  LOG_VALUE("left after release, urad", joint.angle_rad() * 1e6);
  CHECK_RELATIVE("deflection at 3 Nm in rad", expected_bent, bent, 0.02);
  CHECK_RELATIVE("sprung back in rad", expected_back, bent - joint.angle_rad(), 0.02);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_breakaway_on_a_torque_ramp_agrees);
  RUN_TEST(test_reversals_agree);
  RUN_TEST(test_presliding_hysteresis_agrees);
  RUN_TEST(test_stick_slip_of_a_joint_pulled_by_a_spring_agrees);
  RUN_TEST(test_every_speed_from_0_01_to_200_deg_per_s_agrees);
  RUN_TEST(test_halving_the_step_quarters_the_error);
  RUN_TEST(test_extreme_seals_stay_bounded);
  RUN_TEST(test_a_joint_loaded_below_breakaway_follows_the_bristle_curve_and_springs_back);
  return UNITY_END();
}
