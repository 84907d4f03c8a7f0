// The Stribeck curve, eq. (3): g(v) = Tc + (Ts - Tc) exp(-(v/vs)^2), and its slope.
//
// Both friction models of the plant take their level from here, so that they agree in steady sliding.
#ifndef TRACKSERVO_SIM_PLANT_STRIBECK_HPP
#define TRACKSERVO_SIM_PLANT_STRIBECK_HPP

#include <cmath>

#include "config/plant_config.hpp"

namespace trackservo::sim {

struct StribeckPoint {
  double level_nm;            // g(v) > 0
  double relative_slope_v;    // v g'(v) / g(v), dimensionless, <= 0
};

// g and its slope at a joint rate [rad/s] of either sign; one exponential. `level` scales Tc and Ts, > 0.
inline StribeckPoint stribeck(const StribeckConfig& direction, double level, double joint_rate_rad_s) {
  const double ratio = joint_rate_rad_s / direction.stribeck_speed_rad_s;
  const double square = ratio * ratio;
  const double excess = (direction.breakaway_nm - direction.coulomb_nm) * std::exp(-square);
  const double unscaled = direction.coulomb_nm + excess;
  return {level * unscaled, -2.0 * square * excess / unscaled};
}

}  // namespace trackservo::sim

#endif
