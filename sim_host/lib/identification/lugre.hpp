// SPDX-License-Identifier: Apache-2.0
// LuGre friction, eqs (1)-(3), driven by a measured motion, with its derivatives by every parameter.
//
//   Tf = f + s1 dz/dt + s2 v,   f = s0 z,   df/dt = s0 (v - |v| f / g(v)),   g = level (Tc + (Ts - Tc) exp(-(v/vs)^2))
//
// With v held over a step, f approaches +-g exponentially: exact for every step length. The bristle force f, not z, is
// the state, so that everything is in Nm. Damping and viscous torque are linear in s1 and s2: a step returns their
// shapes. `level` is the seal's eccentricity at the present angle, relative to its mean.
#ifndef TRACKSERVO_IDENTIFICATION_LUGRE_HPP
#define TRACKSERVO_IDENTIFICATION_LUGRE_HPP

#include <array>
#include <cstddef>

namespace trackservo::identification {

// Steady friction of one direction, eq. (5).
struct DirectionFriction {
  double coulomb_nm = 0;            // Tc
  double breakaway_nm = 0;          // Ts
  double stribeck_speed_rad_s = 0;  // the paper's theta_s'
  double viscous_nm_s_rad = 0;      // sigma2

  // Returns g(v), eq. (3), and the torque in steady sliding, eq. (5), of a speed |v| [rad/s].
  double level_nm(double speed_rad_s) const;
  double steady_nm(double speed_rad_s) const { return level_nm(speed_rad_s) + viscous_nm_s_rad * speed_rad_s; }
};

struct Friction {
  double stiffness_nm_rad = 0;  // sigma0
  double damping_nm_s_rad = 0;  // sigma1
  DirectionFriction positive;   // for v >= 0
  DirectionFriction negative;
};

// The parameters that affect the bristle force, in the order of its derivatives.
enum BristleParameter {
  kCoulombPositive,
  kBreakawayPositive,
  kStribeckSpeedPositive,
  kCoulombNegative,
  kBreakawayNegative,
  kStribeckSpeedNegative,
  kStiffness,
  kLevel,  // the coefficients of the friction map follow
};

class Lugre {
 public:
  // Maximum number of values that a coefficient of the friction map scales.
  static constexpr int kMaxLevelTerms = 4;
  static constexpr int kDerivatives = kLevel + kMaxLevelTerms;
  using Derivatives = std::array<double, kDerivatives>;  // by the parameters up to kStiffness, then by the level terms

  // Means over a step.
  struct Step {
    double bristle_nm = 0;     // s0 z
    double damping_rad_s = 0;  // dz/dt, to be multiplied by s1
    Derivatives bristle_by{};  // derivatives of the two by the parameters
    Derivatives damping_by{};
  };

  // Starts with the bristles relaxed. Neither s1 nor s2 is used here.
  Lugre(const Friction& friction, int level_terms) : friction_(friction), level_terms_(level_terms) {}

  // Advances by one step at a constant joint rate; `level_terms` are the values of the map's terms at the present
  // angle. Without derivatives a step takes half the time; all later derivatives are then invalid.
  template <bool derivatives = true>
  const Step& advance(double rate_rad_s, double dt_s, double level, const double *level_terms);

  double bristle_nm() const { return force_nm_; }

 private:
  Friction friction_;
  int level_terms_;
  double force_nm_ = 0;
  Derivatives force_by_{};
  Step step_;
};

}  // namespace trackservo::identification

#endif
