#include "plant/maxwell_slip.hpp"

#include <algorithm>
#include <cmath>

#include "plant/stribeck.hpp"

namespace trackservo::sim {

namespace {

// Trapezoidal step of dF/dt = C (sign a - F/g) towards its fixed point; C/g dt is small (attraction 1e4/s at most).
double attracted(double torque_nm, double target_nm, double rate_1_s, double dt_s) {
  const double half = 0.5 * rate_1_s * dt_s;
  return (torque_nm * (1.0 - half) + 2.0 * half * target_nm) / (1.0 + half);
}

}  // namespace

MaxwellSlip::MaxwellSlip(const FrictionConfig& friction, const MaxwellSlipConfig& model)
    : config_(friction),
      elements_(std::clamp(model.elements, 1, kMostElements)),
      element_stiffness_nm_rad_(friction.stiffness_nm_rad / elements_),
      sticking_damping_nm_s_rad_(model.sticking_damping_fraction * friction.damping_nm_s_rad / elements_),
      attraction_1_s_(model.attraction_1_s) {
  // Yield deflections 1, 2, .. N times a unit chosen so that the shares add up to one.
  const double sum = 0.5 * elements_ * (elements_ + 1);
  for (int i = 0; i < elements_; ++i) {
    element_[static_cast<std::size_t>(i)].share = (i + 1) / sum;
  }
}

AffineFriction MaxwellSlip::linearise(double rate_rad_s, double level, double viscosity, double dt_s) {
  dt_s_ = dt_s;
  level_ = level;
  const StribeckConfig& direction = rate_rad_s >= 0.0 ? config_.positive : config_.negative;
  const double limit_nm = stribeck(direction, level, rate_rad_s).level_nm;
  const double attraction = attraction_1_s_ * level * direction.breakaway_nm / limit_nm;
  affine_ = {0.0, viscosity * direction.viscous_nm_s_rad, 0.5};
  for (int i = 0; i < elements_; ++i) {
    Element& element = element_[static_cast<std::size_t>(i)];
    if (element.slip_sign * rate_rad_s < 0.0) {
      element.slip_sign = 0.0;  // the motion has turned: every element sticks again
    }
    if (element.slip_sign == 0.0) {
      affine_.constant_nm += element.torque_nm;
      affine_.slope_nm_s_rad += 0.5 * element_stiffness_nm_rad_ * dt_s + sticking_damping_nm_s_rad_;
    } else {
      const double end = attracted(element.torque_nm, element.slip_sign * element.share * limit_nm, attraction, dt_s);
      affine_.constant_nm += 0.5 * (element.torque_nm + end);
    }
  }
  return affine_;
}

double MaxwellSlip::commit(double rate_rad_s) {
  const StribeckConfig& direction = rate_rad_s >= 0.0 ? config_.positive : config_.negative;
  const double limit_nm = stribeck(direction, level_, rate_rad_s).level_nm;
  const double attraction = attraction_1_s_ * level_ * direction.breakaway_nm / limit_nm;
  for (int i = 0; i < elements_; ++i) {
    Element& element = element_[static_cast<std::size_t>(i)];
    const double yield_nm = element.share * limit_nm;
    if (element.slip_sign != 0.0) {
      element.torque_nm = attracted(element.torque_nm, element.slip_sign * yield_nm, attraction, dt_s_);
      continue;
    }
    const double before = element.torque_nm;
    element.torque_nm += element_stiffness_nm_rad_ * rate_rad_s * dt_s_;
    // An element slips only outwards; one whose yield has sunk below its force by the Stribeck effect keeps the force
    // it had and is attracted to the new level.
    const double magnitude = std::abs(element.torque_nm);
    if (magnitude > yield_nm && element.torque_nm * rate_rad_s > 0.0) {
      element.slip_sign = std::copysign(1.0, rate_rad_s);
      element.torque_nm = std::copysign(std::min(magnitude, std::max(yield_nm, std::abs(before))), element.torque_nm);
    }
  }
  return affine_.constant_nm + affine_.slope_nm_s_rad * rate_rad_s;
}

}  // namespace trackservo::sim
