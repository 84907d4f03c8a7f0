// The paper's own identification, section II: steady speeds for the Stribeck curve, eqs (4)-(7); the slope in
// pre-sliding for sigma0, eq. (16); an assumed damping ratio for sigma1, eq. (15).
//
// It needs no optimiser and no model of the wind. Here it gives the start of the joint fit, and it is reported beside
// the result so that one sees what the paper's assumptions cost.
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

// Eq. (15): sigma1 = 2 zeta sqrt(J sigma0) - sigma2. J, sigma0 > 0.
double paper_damping_nm_s_rad(double inertia_kg_m2, double stiffness_nm_rad, double viscous_nm_s_rad,
                              double damping_ratio);

// The other way round: the damping ratio of pre-sliding, eq. (14).
double presliding_damping_ratio(double inertia_kg_m2, double stiffness_nm_rad, double damping_nm_s_rad,
                                double viscous_nm_s_rad);

// Torque while the axis slides at the reference of a speed sweep, both directions of a speed in turns.
struct SteadySpeeds {
  std::vector<SteadyPoint> positive;  // against the motion
  std::vector<SteadyPoint> negative;
  double load_nm = 0;  // half the sum of both directions: what does not turn round with the motion
};

SteadySpeeds steady_speeds(const Recording& recording);

struct PaperEstimate {
  Friction friction;
  double inertia_kg_m2 = 0;
  double load_nm = 0;
  std::vector<std::string> missing;  // what could not be had from these runs, and is only guessed
};

PaperEstimate paper_estimate(const Recording& recording);

}  // namespace trackservo::identification

#endif
