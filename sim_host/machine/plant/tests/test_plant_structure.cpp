// SPDX-License-Identifier: Apache-2.0
// A part of the inertia behind a spring: the resonance of the plant file, and the momentum of a rigid axis.
#include "machine/plant/structure.hpp"

#include <cmath>

#include "identification/structural_mode.hpp"
#include "machine/plant/joint.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

constexpr double kInertia_kg_m2 = 6.0;

// A joint without friction and its structure.
class TwoMasses {
 public:
  explicit TwoMasses(const StructureConfig& config)
      : joint_(bare_plant().axis[kAzimuth], FrictionModel::kNone, {}, kPwmPeriod_s),
        structure_(config, kInertia_kg_m2, kPwmPeriod_s) {
    joint_.place(0.0);
  }

  double step(double torque_nm, double payload_load_nm = 0.0) {
    const Structure::Reaction reaction = structure_.reaction(kInertia_kg_m2, 0.0, payload_load_nm);
    joint_.step((1.0 - structure_.share()) * kInertia_kg_m2, torque_nm + reaction.push_nm, reaction.drag_nm_s_rad);
    structure_.commit(joint_.mean_rate_rad_s());
    return joint_.rate_rad_s();
  }

  double payload_rate_rad_s() const { return structure_.rate_rad_s(); }
  double twist_rad() const { return structure_.twist_rad(); }

 private:
  Joint joint_;
  Structure structure_;
};

// After an impulse p the joint turns with p/J (1 + c e^(-zwt) (cos vt - z/sqrt(1 - z^2) sin vt)), v = w sqrt(1 - z^2).
void test_an_impulse_rings_at_the_frequency_and_with_the_damping_of_the_file() {
  for (const StructureConfig& config : {StructureConfig{90.0, 0.02, 0.3}, StructureConfig{20.0, 0.2, 0.05}}) {
    TwoMasses axis(config);
    const double impulse_nm_s = 1.0;
    const double w = 2.0 * kPi * config.frequency_hz;
    const double z = config.damping;
    const double v = w * std::sqrt(1.0 - z * z);
    const double share = config.inertia_share / (1.0 - config.inertia_share);
    double rate_rad_s = axis.step(impulse_nm_s / kPwmPeriod_s);
    for (int step = 1; step <= 2000; ++step) {
      const double t = (step - 0.5) * kPwmPeriod_s;  // the impulse came in the middle of the first step
      const double ringing = std::exp(-z * w * t) * (std::cos(v * t) - z / std::sqrt(1.0 - z * z) * std::sin(v * t));
      CHECK_NEAR("rate beside p/J", 1.0 + share * ringing, rate_rad_s * kInertia_kg_m2 / impulse_nm_s, 0.01 * share);
      rate_rad_s = axis.step(0.0);
    }
  }
}

void test_a_constant_torque_turns_the_whole_inertia() {
  TwoMasses axis({90.0, 0.05, 0.3});
  double rate_rad_s = 0.0;
  for (int step = 0; step < 20000; ++step) {
    rate_rad_s = axis.step(3.0);
  }
  CHECK_RELATIVE("rate after 1 s", 3.0 / kInertia_kg_m2, rate_rad_s, 1e-3);
}

void test_a_stiff_spring_without_damping_stays_stable() {
  TwoMasses axis({400.0, 0.001, 0.9});
  double max_rad_s = 0.0;
  double rate_rad_s = axis.step(1.0 / kPwmPeriod_s);
  for (int step = 0; step < 200000; ++step) {
    max_rad_s = std::max(max_rad_s, std::abs(rate_rad_s));
    rate_rad_s = axis.step(0.0);
  }
  CHECK_AT_MOST("peak rate", 1.0 / kInertia_kg_m2 * (1.0 + 9.0), max_rad_s);
}

// A torque of one frequency, after the ringing of its start has decayed: payload rate over joint rate, as the loop's
// model has it.
void test_the_payload_follows_the_joint_as_the_model_says() {
  const StructureConfig config{40.0, 0.05, 0.3};
  const trackservo::gain_design::StructuralMode mode{2.0 * kPi * config.frequency_hz, config.damping,
                                                     config.inertia_share / (1.0 - config.inertia_share)};
  for (const double frequency_hz : {5.0, 25.0, 33.0, 50.0}) {
    TwoMasses axis(config);
    const std::complex<double> s(0.0, 2.0 * kPi * frequency_hz);
    std::complex<double> joint;
    std::complex<double> payload;
    constexpr int kSettle = 20000;
    constexpr int kSteps = 20000;  // whole periods of each frequency
    for (int step = 0; step < kSettle + kSteps; ++step) {
      const double time_s = step * kPwmPeriod_s;
      const double joint_rad_s = axis.step(std::cos(s.imag() * time_s));
      if (step >= kSettle) {
        joint += joint_rad_s * std::exp(-s * time_s);
        payload += axis.payload_rate_rad_s() * std::exp(-s * time_s);
      }
    }
    const std::complex<double> expected = payload_factor(mode, s);
    CHECK_NEAR("payload over joint", 0.0, std::abs(payload / joint - expected), 0.02 * std::abs(expected));
  }
}

void test_a_load_on_the_payload_turns_the_whole_inertia_and_twists_the_spring() {
  const StructureConfig config{40.0, 0.5, 0.3};
  TwoMasses axis(config);
  double rate_rad_s = 0.0;
  for (int step = 0; step < 20000; ++step) {
    rate_rad_s = axis.step(0.0, -3.0);
  }
  CHECK_RELATIVE("rate after 1 s", 3.0 / kInertia_kg_m2, rate_rad_s, 1e-2);
  // The spring carries what accelerates the part before it: k = w^2 s (1 - s) J.
  const double stiffness_nm_rad = std::pow(2.0 * kPi * 40.0, 2) * 0.3 * 0.7 * kInertia_kg_m2;
  CHECK_RELATIVE("twist", 0.7 * 3.0 / stiffness_nm_rad, axis.twist_rad(), 1e-2);
}

// The joint is pushed, stops for a while, and is pushed on: within the play the payload keeps its rate.
void test_within_the_play_no_torque_is_carried() {
  StructureConfig config{90.0, 0.05, 0.3};
  config.backlash_rad = 100e-6;
  TwoMasses axis(config);
  axis.step(1.0 / kPwmPeriod_s);  // an impulse of 1 Nms on the joint alone, whose inertia is 4.2 kg m2
  double travelled_rad = 0.0;
  while (axis.payload_rate_rad_s() == 0.0) {
    travelled_rad += kPwmPeriod_s * axis.step(0.0);
    TEST_ASSERT_TRUE(travelled_rad < 1e-3);
  }
  CHECK_NEAR("travel until the flanks touch, rad", 50e-6, -axis.twist_rad(), 30e-6);
  double sum_rad_s = 0.0;
  constexpr int kSteps = 40000;
  double largest_rad = 0.0;
  for (int step = 0; step < kSteps; ++step) {
    sum_rad_s += 0.7 * axis.step(0.0) + 0.3 * axis.payload_rate_rad_s();
    largest_rad = std::max(largest_rad, std::abs(axis.twist_rad()));
  }
  CHECK_RELATIVE("momentum, Nms", 1.0, kInertia_kg_m2 * sum_rad_s / kSteps, 1e-6);
  CHECK_AT_LEAST("twist beyond half the play", 50e-6, largest_rad);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_an_impulse_rings_at_the_frequency_and_with_the_damping_of_the_file);
  RUN_TEST(test_a_constant_torque_turns_the_whole_inertia);
  RUN_TEST(test_the_payload_follows_the_joint_as_the_model_says);
  RUN_TEST(test_a_load_on_the_payload_turns_the_whole_inertia_and_twists_the_spring);
  RUN_TEST(test_within_the_play_no_torque_is_carried);
  RUN_TEST(test_a_stiff_spring_without_damping_stays_stable);
  return UNITY_END();
}
