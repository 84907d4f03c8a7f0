// From a recording to parameters with intervals, or to the reason why there are none.
//
// Steps: the paper's method for a first idea; a search for the neighbourhood of the best fit; one fit of all runs
// together; a verdict on each parameter. A parameter is given only if its 95 % interval is narrow AND the motions that
// can tell it occurred; otherwise it is refused, and the message names the run to be added.
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

// Nothing can be said at all.
class IdentificationError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Interval {
  double low = 0;
  double high = 0;
};

struct Parameter {
  std::string name;  // "coulomb_positive"
  std::string unit;
  double value = 0;
  Interval interval;    // 95 %
  double paper = 0;     // what the paper's method alone says
  double start = 0;     // where the joint fit began
  std::string refused;  // empty, or why the value must not be used and which run is missing
};

// What of the recorded motion can tell friction.
struct Evidence {
  int speeds[2] = {0, 0};         // octaves of speed with steady sliding; backward, forward
  bool slow[2] = {false, false};  // below the Stribeck speed among them
  int turns = 0;                  // turning round after sliding, sliding again after it
  double inertial_share = 0;      // rms of J dw/dt beside the Coulomb friction
};

struct Identification {
  explicit Identification(const Recording& recording) : position_terms(recording) {}

  std::vector<Parameter> parameters;
  Parameter coulomb_mean;  // of both directions: known even where the load cannot be told from their difference
  RoughMachine rough;
  Evidence evidence;
  PaperEstimate paper;
  Motion motion;
  double motion_cutoff_hz = 0;
  JointFit fit;
  PositionTerms position_terms;
  std::vector<MotorHarmonic> harmonics;
  std::vector<std::size_t> node_ticks;
  double damping_ratio = 0;          // of pre-sliding by the fitted sigma1: what the paper assumes to be 0.707
  double eq15_damping_nm_s_rad = 0;  // sigma1 by that assumption, from the fitted J, sigma0 and sigma2
  double residual_rms_nm = 0;
  double largest_correlation = 0;  // of the whitened residuals at 1..40 nodes
  bool complete() const;           // nothing was refused
  const Parameter& parameter(const std::string& name) const;
};

// What a machine has that the model has not, and what sampling does: as a standard deviation of every logarithm, added
// to what the residuals say. Chosen, not derived: ripple of a motor that cannot be told from a few places is 1 % of J.
constexpr double kModelAllowance = 0.01;

// Wind that moves the axis to and fro through the Stribeck region leaves an error of Ts and of the Stribeck speed, in
// proportion to wind beside friction: their deviation grows by this share of residual rms / Tc (decision 0012).
constexpr double kWindAllowance = 0.02;

// The same of sigma2 alone: in wind it comes out 1 to 4 % too high (decision 0012).
constexpr double kViscousAllowance = 0.02;

// Throws IdentificationError.
Identification identify(const Recording& recording);

}  // namespace trackservo::identification

#endif
