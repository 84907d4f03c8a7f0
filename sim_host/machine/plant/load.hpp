// SPDX-License-Identifier: Apache-2.0
// Torques on one axis from outside: wind, cable and broad-band noise.
//
//   load = wind_mean + gust(t) + cable_stiffness (angle - neutral) + noise(t)
//
// Gust: white noise through the corner of Dryden turbulence (MIL-F-8785C) and the aerodynamic admittance of the cabin,
// which is larger than the eddies above its own corner. Sampled exactly at 1 kHz, linear in between. Positive against
// forward motion.
#ifndef TRACKSERVO_SIM_PLANT_LOAD_HPP
#define TRACKSERVO_SIM_PLANT_LOAD_HPP

#include <cstdint>

#include "machine/config/plant_config.hpp"
#include "machine/plant/shaped_noise.hpp"

namespace trackservo::sim {

// Of one tick, linear over it.
template <class Real>
struct LoadOfTick {
  Real wind_nm{};  // at its start
  Real wind_change_nm{};
  Real cable_nm{};  // at joint angle 0
  Real cable_stiffness_nm_rad{};

  // Returns the torque of the wind, broad-band noise included [Nm], at a fraction 0..1 of the tick.
  Real wind_torque_nm(double tick_fraction) const { return wind_nm + wind_change_nm * tick_fraction; }

  // Returns the torque of the cable [Nm] at a joint angle [rad].
  Real cable_torque_nm(Real joint_angle_rad) const { return cable_nm + cable_stiffness_nm_rad * joint_angle_rad; }
};

class ExternalLoad {
 public:
  ExternalLoad(const LoadConfig& config, std::uint64_t seed, int axis);

  // Draws the gust at the end of the coming tick and its broad-band noise.
  LoadOfTick<double> begin_tick();

 private:
  LoadConfig config_;
  ShapedNoise gust_;
  RandomStream broadband_;
  double gust_nm_;
};

// Friction factors of the Maxwell-slip plant: level (1 + a |load|) e^(b T), viscosity e^(c T), where the temperature T
// goes exponentially from its start to its end value.
class FrictionDrift {
 public:
  struct Factors {
    double level = 1;
    double viscosity = 1;
  };

  explicit FrictionDrift(const MaxwellSlipConfig& config) : config_(config) {}

  Factors at(double time_s, double load_nm) const;

 private:
  MaxwellSlipConfig config_;
};

}  // namespace trackservo::sim

#endif
