// SPDX-License-Identifier: Apache-2.0
// A part of the inertia behind a spring: the resonance of the plant file, and the momentum of a rigid axis.
#include "machine/plant/structure.hpp"

#include <cmath>

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

  double step(double torque_nm) {
    const Structure::Reaction reaction = structure_.reaction(kInertia_kg_m2, 0.0);
    joint_.step((1.0 - structure_.share()) * kInertia_kg_m2, torque_nm + reaction.push_nm, reaction.drag_nm_s_rad);
    structure_.commit(joint_.mean_rate_rad_s());
    return joint_.rate_rad_s();
  }

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

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_an_impulse_rings_at_the_frequency_and_with_the_damping_of_the_file);
  RUN_TEST(test_a_constant_torque_turns_the_whole_inertia);
  RUN_TEST(test_a_stiff_spring_without_damping_stays_stable);
  return UNITY_END();
}
