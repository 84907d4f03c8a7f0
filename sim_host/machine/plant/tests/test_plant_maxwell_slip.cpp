// SPDX-License-Identifier: Apache-2.0
// The Maxwell-slip plant friction: the same steady curve as LuGre, another memory.
#include <algorithm>
#include <cmath>
#include <vector>

#include "machine/plant/load.hpp"
#include "machine/plant/maxwell_slip.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

constexpr double kDt_s = kPwmPeriod_s;

const FrictionConfig& seal() {
  static const FrictionConfig tracker_seal = bare_plant().axis[kAzimuth].friction;
  return tracker_seal;
}

// Friction moved at a given speed; returns the torque of the step [Nm].
double moved(MaxwellSlip& friction, double rate_rad_s) {
  const AffineFriction affine = friction.linearise(rate_rad_s, 1.0, 1.0);
  friction.commit(rate_rad_s);
  return affine.constant_nm + affine.slope_nm_s_rad * rate_rad_s;
}

void test_steady_sliding_is_the_stribeck_curve_in_both_directions() {
  for (const double speed : {0.02, 0.1, 0.3, 1.0, 5.0, 50.0, -0.02, -0.1, -0.3, -1.0, -5.0, -50.0}) {
    MaxwellSlip friction(seal(), MaxwellSlipConfig{}, kDt_s);
    const double rate = speed * kRadPerDeg;
    double torque = 0.0;
    for (int step = 0; step < 200000; ++step) {
      torque = moved(friction, rate);
    }
    CHECK_RELATIVE("steady torque", steady_friction_nm(seal(), rate), torque, 1e-6);
  }
}

void test_the_virgin_curve_is_the_parabola_of_evenly_spread_yields() {
  MaxwellSlipConfig model;
  model.elements = 16;
  MaxwellSlip friction(seal(), model, kDt_s);
  const double rate = 1e-4;  // rad/s: the level is Ts
  double worst = 0.0;
  double deflection = 0.0;
  for (int step = 0; step < 120000; ++step) {
    const double torque = moved(friction, rate) - seal().positive.viscous_nm_s_rad * rate;
    deflection += rate * kDt_s;
    const double x = std::min(seal().stiffness_nm_rad * deflection / seal().positive.breakaway_nm, 2.0);
    worst = std::max(worst, std::abs(torque - seal().positive.breakaway_nm * (x - 0.25 * x * x)));
  }
  LOG_VALUE("largest distance from Ts (x - x^2/4) in Nm", worst);
  CHECK_AT_MOST("distance with 16 elements of 9 Nm", 0.3, worst);
}

// The torque after each of 400 equal pieces of a loop of the given amplitude, passed at a given speed.
std::vector<double> loop_at(double rate_rad_s, double amplitude_rad) {
  FrictionConfig dry = seal();
  dry.positive.viscous_nm_s_rad = 0.0;
  dry.negative = dry.positive;
  MaxwellSlip friction(dry, MaxwellSlipConfig{}, kDt_s);
  std::vector<double> torques;
  const int steps_per_piece = static_cast<int>(std::lround(amplitude_rad / 100.0 / (rate_rad_s * kDt_s)));
  for (int piece = 0; piece < 500; ++piece) {
    const bool forward = piece < 100 || piece >= 300;  // up, down, up
    for (int step = 0; step < steps_per_piece; ++step) {
      const double torque = moved(friction, forward ? rate_rad_s : -rate_rad_s);
      if (step == steps_per_piece - 1) {
        torques.push_back(torque);
      }
    }
  }
  return torques;
}

void test_presliding_hysteresis_does_not_depend_on_the_rate() {
  const double amplitude = 2e-4;  // rad; Ts / s0 is 3e-4
  const std::vector<double> slow = loop_at(2e-4, amplitude);
  const std::vector<double> fast = loop_at(4e-4, amplitude);
  TEST_ASSERT_EQUAL(slow.size(), fast.size());
  double worst = 0.0;
  double area = 0.0;
  for (std::size_t i = 0; i < slow.size(); ++i) {
    worst = std::max(worst, std::abs(slow[i] - fast[i]));
    area += (i < 100 || i >= 300 ? slow[i] : -slow[i]) * amplitude / 100.0;
  }
  LOG_VALUE("torque between slow and fast loop in Nm", worst);
  LOG_VALUE("work of the loops in J", area);
  CHECK_AT_MOST("difference in Nm of 9", 0.05, worst);
  CHECK_AT_LEAST("the loop eats energy", 1e-5, area);
}

void test_an_inner_loop_closes_and_is_forgotten() {
  // Nonlocal memory: after a small loop the torque continues on the outer curve as without the loop.
  FrictionConfig dry = seal();
  dry.positive.viscous_nm_s_rad = 0.0;
  dry.negative = dry.positive;
  const double rate = 1e-4;
  const auto run = [&](bool inner) {
    MaxwellSlip friction(dry, MaxwellSlipConfig{}, kDt_s);
    double torque = 0.0;
    const auto go = [&](double direction, int steps) {
      for (int step = 0; step < steps; ++step) {
        torque = moved(friction, direction * rate);
      }
    };
    go(1.0, 30000);
    if (inner) {
      go(-1.0, 6000);
      go(1.0, 6000);
    }
    go(1.0, 4000);
    return torque;
  };
  CHECK_NEAR("torque with and without the inner loop", run(false), run(true), 1e-3);
}

void test_level_drifts_with_load_and_temperature() {
  MaxwellSlipConfig drift;
  drift.level_per_load_1_nm = 0.02;
  drift.temperature_start_k = 0.0;
  drift.temperature_end_k = 20.0;
  drift.temperature_time_constant_s = 10.0;
  drift.level_per_k = -0.01;
  drift.viscosity_per_k = -0.02;
  const FrictionDrift seal_drift(drift);
  CHECK_NEAR("cold, unloaded", 1.0, seal_drift.at(0.0, 0.0).level, 1e-12);
  CHECK_NEAR("cold, 5 Nm either way", 1.1, seal_drift.at(0.0, -5.0).level, 1e-12);
  CHECK_NEAR("warm", std::exp(-0.2), seal_drift.at(1e3, 0.0).level, 1e-9);
  CHECK_NEAR("warm, viscosity", std::exp(-0.4), seal_drift.at(1e3, 0.0).viscosity, 1e-9);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_steady_sliding_is_the_stribeck_curve_in_both_directions);
  RUN_TEST(test_the_virgin_curve_is_the_parabola_of_evenly_spread_yields);
  RUN_TEST(test_presliding_hysteresis_does_not_depend_on_the_rate);
  RUN_TEST(test_an_inner_loop_closes_and_is_forgotten);
  RUN_TEST(test_level_drifts_with_load_and_temperature);
  return UNITY_END();
}
