// SPDX-License-Identifier: Apache-2.0
// The paper's own identification, section II: steady speeds for the Stribeck curve, eqs (4)-(7); the slope in
// pre-sliding for sigma0, eq. (16); an assumed damping ratio for sigma1, eq. (15).
//
// It needs no optimiser and no model of the wind. Here it gives the start of the joint fit. It is also reported beside
// the result, to show the cost of the paper's assumptions.
#ifndef TRACKSERVO_IDENTIFICATION_PAPER_METHOD_HPP
#define TRACKSERVO_IDENTIFICATION_PAPER_METHOD_HPP

#include <string>
#include <vector>

#include "identification/lugre.hpp"
#include "identification/recording.hpp"
#include "identification/stribeck_fit.hpp"

namespace trackservo::identification {

// The paper's "optimal" ratio, 1/sqrt(2).
extern const double kPaperDampingRatio;

// Returns sigma1 by eq. (15): sigma1 = 2 zeta sqrt(J sigma0) - sigma2. J, sigma0 > 0.
double paper_damping_nm_s_rad(double inertia_kg_m2, double stiffness_nm_rad, double viscous_nm_s_rad,
                              double damping_ratio);

// Returns the inverse: the damping ratio of pre-sliding, eq. (14).
double presliding_damping_ratio(double inertia_kg_m2, double stiffness_nm_rad, double damping_nm_s_rad,
                                double viscous_nm_s_rad);

// Torque while the axis slides at the reference of a speed sweep, alternating between both directions of a speed.
struct SteadySpeeds {
  std::vector<SteadyPoint> positive;  // against the motion
  std::vector<SteadyPoint> negative;
  double load_nm = 0;  // half the sum of both directions: the part that does not change sign with the motion
};

SteadySpeeds steady_speeds(const Recording& recording);

struct PaperEstimate {
  Friction friction;
  double inertia_kg_m2 = 0;
  double load_nm = 0;
  std::vector<std::string> missing;  // values that these runs do not give, and that are only guessed
};

PaperEstimate paper_estimate(const Recording& recording);

}  // namespace trackservo::identification

#endif
