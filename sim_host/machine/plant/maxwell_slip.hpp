// SPDX-License-Identifier: Apache-2.0
// Generalised Maxwell-slip friction, the plant's second friction model (Lampaert, Al-Bender, Swevers 2003).
//
// N spring-slider elements in parallel, friction is the sum of their forces plus the viscous part:
//   sticking:  dF_i/dt = k_i v                      until |F_i| reaches a_i g(v), g of eq. (3)
//   slipping:  dF_i/dt = sign(v) C (a_i - |F_i|/g(v))   until v changes sign;      sum a_i = 1, C = attraction * Ts
// Steady sliding gives exactly the LuGre curve, eq. (5); pre-sliding gives rate-independent hysteresis with nonlocal
// memory, which LuGre does not have. The stiffnesses are equal, sum k_i = s0, and the yield deflections evenly spread,
// so the virgin curve is Ts (x - x^2/4) with x = s0 * deflection / Ts up to x = 2. Level and viscosity drift with load
// and temperature (load.hpp gives the factors).
#ifndef TRACKSERVO_SIM_PLANT_MAXWELL_SLIP_HPP
#define TRACKSERVO_SIM_PLANT_MAXWELL_SLIP_HPP

#include <array>
#include <cstddef>

#include "machine/config/plant_config.hpp"
#include "machine/plant/lugre_friction.hpp"
#include "machine/plant/stribeck.hpp"

namespace trackservo::sim {

class MaxwellSlip {
 public:
  static constexpr int kMaxElements = 16;

  // Prepares the elements. dt_s: the step length [s], the only one that it accepts.
  MaxwellSlip(const FrictionConfig& friction, const MaxwellSlipConfig& model, double dt_s);

  void relax();

  // Does the same as LugreFriction::linearise; `viscosity` scales s2. The step's start decides which element sticks.
  AffineFriction<double> linearise(double rate_rad_s, double level, double viscosity);

  // Completes the step with the solved rate at its middle.
  void commit(double rate_rad_s);

  double element_torque_nm(int index) const { return element_.at(static_cast<std::size_t>(index)).torque_nm; }
  bool element_slips(int index) const { return element_.at(static_cast<std::size_t>(index)).slip_sign != 0.0; }

 private:
  struct Element {
    double torque_nm = 0;
    double share = 0;      // a_i
    double slip_sign = 0;  // direction of slip, 0: sticking
  };

  struct Slip {
    double limit_nm;        // g(v)
    double attraction_1_s;  // C / g(v)
  };

  Slip slip_at(double rate_rad_s, double level);

  Stribeck<double> positive_;
  Stribeck<double> negative_;
  std::size_t elements_;
  double element_stiffness_nm_rad_;
  double sticking_damping_nm_s_rad_;  // of one element
  double attraction_1_s_;
  double dt_s_;
  std::array<Element, kMaxElements> element_{};
  double level_ = 1;  // of the current step
};

}  // namespace trackservo::sim

#endif
