// SPDX-License-Identifier: Apache-2.0
// From a recording to parameters with intervals, or to the reason why there are none.
//
// Steps: the paper's method for a first idea; a search for the neighbourhood of the best fit; one fit of all runs
// together; a verdict on each parameter. A parameter is given only if its 95 % interval is narrow AND the motions that
// determine it occurred; otherwise it is refused, and the message names the run to add.
#ifndef TRACKSERVO_IDENTIFICATION_IDENTIFICATION_HPP
#define TRACKSERVO_IDENTIFICATION_IDENTIFICATION_HPP

#include <stdexcept>
#include <string>
#include <vector>

#include "identification/joint_fit.hpp"
#include "identification/motion.hpp"
#include "identification/paper_method.hpp"
#include "identification/recording.hpp"
#include "identification/rough_machine.hpp"
#include "identification/torque_balance.hpp"

namespace trackservo::identification {

// No result is possible at all.
class IdentificationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Half the width of a 95 % interval, in standard deviations.
constexpr double kInterval_deviations = 1.96;

struct Interval {
  double low = 0;
  double high = 0;
};

struct Parameter {
  std::string name;  // "coulomb_positive"
  std::string unit;
  double value = 0;
  Interval interval;    // 95 %
  double paper = 0;     // result of the paper's method alone
  double start = 0;     // start of the joint fit
  std::string refused;  // empty, or why the value must not be used and which run is missing
};

// The parts of the recorded motion that determine friction.
struct Evidence {
  int speeds[2] = {0, 0};         // octaves of speed with steady sliding; backward, forward
  bool slow[2] = {false, false};  // below the Stribeck speed among them
  int turns = 0;                  // reversals after sliding, with sliding after them
  double inertial_share = 0;      // rms of J dw/dt relative to the Coulomb friction
};

struct Identification {
  explicit Identification(const Recording& recording) : position_terms(recording) {}

  std::vector<Parameter> parameters;
  Parameter coulomb_mean;  // of both directions: known even when the load cannot be separated from their difference
  RoughMachine rough;
  Evidence evidence;
  PaperEstimate paper;
  Motion motion;
  double motion_cutoff_hz = 0;
  JointFit fit;
  PositionTerms position_terms;
  std::vector<MotorHarmonic> harmonics;
  std::vector<std::size_t> node_ticks;
  double damping_ratio = 0;          // of pre-sliding with the fitted sigma1; the paper assumes 0.707
  double eq15_damping_nm_s_rad = 0;  // sigma1 by that assumption, from the fitted J, sigma0 and sigma2
  double residual_rms_nm = 0;
  double largest_correlation = 0;  // of the whitened residuals at 1..40 nodes
  bool complete() const;           // nothing was refused
  const Parameter& parameter(const std::string& name) const;
};

// Effects of the machine that the model does not have, and of sampling: as a standard deviation of every logarithm,
// added to that of the residuals. Chosen, not derived: motor ripple that a few places cannot resolve is 1 % of J.
constexpr double kModelAllowance = 0.01;

// Wind that moves the axis back and forth through the Stribeck region leaves an error of Ts and of the Stribeck speed,
// in proportion to wind relative to friction: their deviation grows by this share of residual rms / Tc (decision 0012).
constexpr double kWindAllowance = 0.02;

// The same for sigma2 alone: in wind the result is 1 to 4 % too high (decision 0012).
constexpr double kViscousAllowance = 0.02;

// Throws IdentificationError.
Identification identify(const Recording& recording);

}  // namespace trackservo::identification

#endif
