// SPDX-License-Identifier: Apache-2.0
// The fit's own LuGre against the continuous model solved by Boost.Odeint, and its derivatives against differences.
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "identification/lugre.hpp"
#include "support/check.h"
#include "support/lugre_ode.hpp"

namespace identification = trackservo::identification;
using identification::Friction;
using identification::Lugre;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr double kTick = 1e-3;

Friction friction_of(const lugre_params& seal) {
  const auto direction = [](const lugre_direction& d) {
    return identification::DirectionFriction{static_cast<double>(d.coulomb_nm), static_cast<double>(d.breakaway_nm),
                                             static_cast<double>(d.stribeck_speed_rad_s),
                                             static_cast<double>(d.viscous_nm_s_rad)};
  };
  return {static_cast<double>(seal.stiffness_nm_rad), static_cast<double>(seal.damping_nm_s_rad),
          direction(seal.positive), direction(seal.negative)};
}

double torque_nm(const Friction& friction, const Lugre::Step& step, double rate) {
  return step.bristle_nm + friction.damping_nm_s_rad * step.damping_rad_s +
         (rate >= 0 ? friction.positive : friction.negative).viscous_nm_s_rad * rate;
}

// Slow loops, a fast reversal and steady sliding.
double rate_at(double t) {
  const double pi = 3.14159265358979323846;
  return t < 1.0 ? 1e-3 * std::cos(2 * pi * 3.0 * t) : 0.2 * std::sin(2 * pi * 1.3 * (t - 1.0));
}

void test_torque_agrees_with_the_continuous_model() {
  for (const lugre_params& seal : {stiff_seal(), seal_of_the_paper()}) {
    const Friction friction = friction_of(seal);
    Lugre lugre(friction, 0);
    lugre_ode::Driven reference{lugre_ode::Friction(seal, lugre_ode::Damping::kOriginal)};
    double worst = 0.0;
    for (int tick = 0; tick < 2000; ++tick) {
      const double rate = rate_at((tick + 0.5) * kTick);
      const double expected = reference.advance([rate](double) { return rate; }, 0.0, kTick);
      worst = std::max(worst, std::abs(torque_nm(friction, lugre.advance(rate, kTick, 1.0, nullptr), rate) - expected));
    }
    LOG_VALUE("largest torque error in Nm", worst);
    CHECK_AT_MOST("torque error", 1e-6, worst);
    CHECK_NEAR("bristle force", reference.force(), lugre.bristle_nm(), 1e-6);
  }
}

constexpr std::array<double, 2> kTerms{0.7, -0.3};

struct Means {
  double bristle_nm;
  double damping_rad_s;
};

Means last_of(const Friction& friction, const std::array<double, 2>& map, int ticks) {
  Lugre lugre(friction, 0);
  Means means{};
  for (int tick = 0; tick < ticks; ++tick) {
    const double level = 1.0 + map[0] * kTerms[0] + map[1] * kTerms[1];
    const Lugre::Step& step = lugre.advance(rate_at((tick + 0.5) * kTick), kTick, level, nullptr);
    means = {step.bristle_nm, step.damping_rad_s};
  }
  return means;
}

void test_derivatives_agree_with_differences() {
  const Friction friction = friction_of(stiff_seal());
  const std::array<double, 2> map{0.05, 0.02};
  const std::array<std::function<double&(Friction&)>, identification::kStiffness + 1> parameters{
      [](Friction& f) -> double& { return f.positive.coulomb_nm; },
      [](Friction& f) -> double& { return f.positive.breakaway_nm; },
      [](Friction& f) -> double& { return f.positive.stribeck_speed_rad_s; },
      [](Friction& f) -> double& { return f.negative.coulomb_nm; },
      [](Friction& f) -> double& { return f.negative.breakaway_nm; },
      [](Friction& f) -> double& { return f.negative.stribeck_speed_rad_s; },
      [](Friction& f) -> double& { return f.stiffness_nm_rad; }};
  for (const int ticks : {40, 180, 400, 1390, 1800}) {
    Lugre lugre(friction, 2);
    Lugre::Step step;
    for (int tick = 0; tick < ticks; ++tick) {
      const double level = 1.0 + map[0] * kTerms[0] + map[1] * kTerms[1];
      step = lugre.advance(rate_at((tick + 0.5) * kTick), kTick, level, kTerms.data());
    }
    for (std::size_t p = 0; p < identification::kLevel + 2; ++p) {
      Friction more = friction;
      Friction less = friction;
      std::array<double, 2> more_map = map;
      std::array<double, 2> less_map = map;
      double step_size = 1e-6;
      if (p < parameters.size()) {
        step_size *= parameters[p](more);
        parameters[p](more) += step_size;
        parameters[p](less) -= step_size;
      } else {
        more_map[p - identification::kLevel] += step_size;
        less_map[p - identification::kLevel] -= step_size;
      }
      const Means high = last_of(more, more_map, ticks);
      const Means low = last_of(less, less_map, ticks);
      const double bristle = (high.bristle_nm - low.bristle_nm) / (2 * step_size);
      const double damping = (high.damping_rad_s - low.damping_rad_s) / (2 * step_size);
      CHECK_NEAR("of the bristle force", bristle, step.bristle_by[p],
                 1e-6 * std::abs(bristle) + 1e-8 / step_size * 1e-3);
      CHECK_NEAR("of dz/dt", damping, step.damping_by[p], 1e-5 * std::abs(damping) + 1e-11 / step_size * 1e-3);
    }
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_torque_agrees_with_the_continuous_model);
  RUN_TEST(test_derivatives_agree_with_differences);
  return UNITY_END();
}
