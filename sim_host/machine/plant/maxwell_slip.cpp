// SPDX-License-Identifier: Apache-2.0
#include "machine/plant/maxwell_slip.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {

namespace {

// Trapezoidal step of dF/dt = C (sign a - F/g) towards its fixed point; C/g dt is small (attraction 1e4/s at most).
double attracted(double torque_nm, double target_nm, double rate_1_s, double dt_s) {
  const double half = 0.5 * rate_1_s * dt_s;
  return (torque_nm * (1.0 - half) + 2.0 * half * target_nm) / (1.0 + half);
}

}  // namespace

MaxwellSlip::MaxwellSlip(const FrictionConfig& friction, const MaxwellSlipConfig& model, double dt_s)
    : elements_(static_cast<std::size_t>(std::clamp(model.elements, 1, kMaxElements))),
      element_stiffness_nm_rad_(friction.stiffness_nm_rad / static_cast<double>(elements_)),
      sticking_damping_nm_s_rad_(model.sticking_damping_fraction * friction.damping_nm_s_rad /
                                 static_cast<double>(elements_)),
      attraction_1_s_(model.attraction_1_s),
      dt_s_(dt_s) {
  positive_.set(0, friction.positive);
  negative_.set(0, friction.negative);
  // Yield deflections 1, 2, .. N times a unit, chosen so that the shares add up to one.
  const double sum = 0.5 * static_cast<double>(elements_ * (elements_ + 1));
  for (std::size_t i = 0; i < elements_; ++i) {
    element_[i].share = static_cast<double>(i + 1) / sum;
  }
}

void MaxwellSlip::relax() {
  for (Element& element : element_) {
    element.torque_nm = 0.0;
    element.slip_sign = 0.0;
  }
}

MaxwellSlip::Slip MaxwellSlip::slip_at(double rate_rad_s, double level) {
  Stribeck<double>& direction = rate_rad_s >= 0.0 ? positive_ : negative_;
  const StribeckPoint<double> point = direction.at(rate_rad_s, level, true);
  return {point.level_nm, attraction_1_s_ * level * direction.breakaway_nm() * point.inverse_1_nm};
}

AffineFriction<double> MaxwellSlip::linearise(double rate_rad_s, double level, double viscosity) {
  level_ = level;
  const Slip slip = slip_at(rate_rad_s, level);
  const Stribeck<double>& direction = rate_rad_s >= 0.0 ? positive_ : negative_;
  AffineFriction<double> affine;
  affine.slope_nm_s_rad = viscosity * direction.viscous_nm_s_rad();
  for (std::size_t i = 0; i < elements_; ++i) {
    Element& element = element_[i];
    if (element.slip_sign * rate_rad_s < 0.0) {
      element.slip_sign = 0.0;  // the motion has reversed: the element sticks again
    }
    if (element.slip_sign == 0.0) {
      affine.constant_nm += element.torque_nm;
      affine.slope_nm_s_rad += 0.5 * element_stiffness_nm_rad_ * dt_s_ + sticking_damping_nm_s_rad_;
    } else {
      const double target_nm = element.slip_sign * element.share * slip.limit_nm;
      const double end_nm = attracted(element.torque_nm, target_nm, slip.attraction_1_s, dt_s_);
      affine.constant_nm += 0.5 * (element.torque_nm + end_nm);
    }
  }
  return affine;
}

void MaxwellSlip::commit(double rate_rad_s) {
  const Slip slip = slip_at(rate_rad_s, level_);
  for (std::size_t i = 0; i < elements_; ++i) {
    Element& element = element_[i];
    const double yield_nm = element.share * slip.limit_nm;
    if (element.slip_sign != 0.0) {
      element.torque_nm = attracted(element.torque_nm, element.slip_sign * yield_nm, slip.attraction_1_s, dt_s_);
      continue;
    }
    const double before_nm = element.torque_nm;
    element.torque_nm += element_stiffness_nm_rad_ * rate_rad_s * dt_s_;
    // An element slips only outwards. If the Stribeck effect lowers its yield below its force, it keeps its force and
    // is attracted to the new level.
    const double magnitude_nm = std::abs(element.torque_nm);
    if (magnitude_nm > yield_nm && element.torque_nm * rate_rad_s > 0.0) {
      element.slip_sign = std::copysign(1.0, rate_rad_s);
      element.torque_nm = std::copysign(std::min(magnitude_nm, std::max(yield_nm, std::abs(before_nm))), rate_rad_s);
    }
  }
}

}  // namespace trackservo::sim
