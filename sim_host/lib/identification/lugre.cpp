// SPDX-License-Identifier: Apache-2.0
#include "identification/lugre.hpp"

#include <cmath>

namespace trackservo::identification {

double DirectionFriction::level_nm(double speed_rad_s) const {
  const double ratio = speed_rad_s / stribeck_speed_rad_s;
  return coulomb_nm + (breakaway_nm - coulomb_nm) * std::exp(-ratio * ratio);
}

// (1 - e^-x)/x and its derivative: the mean over a step of a quantity that decays by e^-x.
struct MeanDecay {
  double end;    // e^-x
  double mean;   // (1 - e^-x)/x
  double slope;  // d mean / dx
};

// g of a direction at a speed, and its derivatives by Tc, Ts and vs.
struct Level {
  double value_nm;
  std::array<double, 3> by;
};

namespace {

MeanDecay mean_decay(double x) {
  if (x < 1e-3) {
    return {1.0 - x * (1.0 - x * (0.5 - x / 6.0)), 1.0 - x * (0.5 - x * (1.0 / 6.0 - x / 24.0)),
            -0.5 + x * (1.0 / 3.0 - x / 8.0)};
  }
  const double end = std::exp(-x);
  const double mean = (1.0 - end) / x;
  return {end, mean, (end - mean) / x};
}

Level level_of(const DirectionFriction& direction, double speed_rad_s, double level) {
  const double ratio = speed_rad_s / direction.stribeck_speed_rad_s;
  const double square = ratio * ratio;
  const double share = square < 40.0 ? std::exp(-square) : 0.0;
  const double excess_nm = (direction.breakaway_nm - direction.coulomb_nm) * share;
  return {level * (direction.coulomb_nm + excess_nm),
          {level * (1.0 - share), level * share, level * excess_nm * 2.0 * square / direction.stribeck_speed_rad_s}};
}

}  // namespace

template <bool derivatives>
const Lugre::Step& Lugre::advance(double rate_rad_s, double dt_s, double level, const double *level_terms) {
  const double speed = std::abs(rate_rad_s);
  const double sign = rate_rad_s >= 0.0 ? 1.0 : -1.0;
  const int first = rate_rad_s >= 0.0 ? kCoulombPositive : kCoulombNegative;
  const Level g = level_of(rate_rad_s >= 0.0 ? friction_.positive : friction_.negative, speed, level);
  const double stretch = speed * dt_s / g.value_nm;  // x = s0 |v| dt / g, per s0
  const double x = friction_.stiffness_nm_rad * stretch;
  const MeanDecay decay = mean_decay(x);
  const double away_nm = force_nm_ - sign * g.value_nm;  // from the asymptote of the force

  const double to_rate = 1.0 / (friction_.stiffness_nm_rad * dt_s);  // of a change of force to dz/dt

  const double end_nm = sign * g.value_nm + away_nm * decay.end;
  step_.bristle_nm = sign * g.value_nm + away_nm * decay.mean;
  step_.damping_rad_s = (end_nm - force_nm_) * to_rate;

  if constexpr (derivatives) {
    // Of end and mean force by g and by s0, the start force held.
    const double end_by_x = -away_nm * decay.end;
    const double mean_by_x = away_nm * decay.slope;
    const double x_by_g = -x / g.value_nm;
    const double end_by_g = sign * (1.0 - decay.end) + end_by_x * x_by_g;
    const double mean_by_g = sign * (1.0 - decay.mean) + mean_by_x * x_by_g;
    const auto chain = [&](int parameter, double g_by, double x_by) {
      const auto p = static_cast<std::size_t>(parameter);
      const double end = force_by_[p] * decay.end + end_by_g * g_by + end_by_x * x_by;
      step_.bristle_by[p] = force_by_[p] * decay.mean + mean_by_g * g_by + mean_by_x * x_by;
      step_.damping_by[p] = (end - force_by_[p]) * to_rate;
      force_by_[p] = end;
    };
    for (int i = 0; i < 3; ++i) {
      chain(first + i, g.by[static_cast<std::size_t>(i)], 0.0);
      chain(3 - first + i, 0.0, 0.0);
    }
    chain(kStiffness, 0.0, stretch);
    for (int i = 0; i < level_terms_; ++i) {
      chain(kLevel + i, level_terms[i] * g.value_nm / level, 0.0);
    }
    step_.damping_by[kStiffness] -= step_.damping_rad_s / friction_.stiffness_nm_rad;
  }
  force_nm_ = end_nm;
  return step_;
}

template const Lugre::Step& Lugre::advance<true>(double, double, double, const double *);
template const Lugre::Step& Lugre::advance<false>(double, double, double, const double *);

}  // namespace trackservo::identification
