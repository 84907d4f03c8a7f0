// SPDX-License-Identifier: Apache-2.0
// The balance of torques on the axis, eq. (6), along a recording, and its derivatives by all parameters.
//
//   residual = torque(t - delay) + spread d2torque/dt2 - J dw/dt - Tf(joint rate) - load(angle)
//
// Every term is a mean under the same triangle (window.hpp), one value each 5 ms: a node. With the true parameters the
// residual is only wind and sensor noise. `delay` is the time by which the motion is measured later than the torque
// acts. `spread` is how much more the motion is smeared over time than the torque, as half a variance: from the rise of
// the current within a tick and the averaging of the encoder. Parameters that cannot be negative enter as logarithms: a
// relative error is then an absolute one.
#ifndef TRACKSERVO_IDENTIFICATION_TORQUE_BALANCE_HPP
#define TRACKSERVO_IDENTIFICATION_TORQUE_BALANCE_HPP

#include <Eigen/Core>
#include <array>
#include <vector>

#include "identification/lugre.hpp"
#include "identification/motion.hpp"
#include "identification/motor_harmonics.hpp"
#include "identification/position_terms.hpp"
#include "identification/recording.hpp"

namespace trackservo::identification {

// Places in the parameter vector. The first are those of BristleParameter; up to kLogarithms they are logarithms.
enum BalanceParameter {
  kViscousPositive = kStiffness + 1,
  kViscousNegative,
  kDamping,
  kInertia,
  kLogarithms,
  kDelay = kLogarithms,  // s
  kSpread,               // s^2
  kFixedParameters       // the map's coefficients follow, then the load's, then the motor's harmonics
};

// Consecutive nodes [first, last) without a gap.
struct Span {
  Eigen::Index first = 0;
  Eigen::Index last = 0;
};

class TorqueBalance {
 public:
  using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  // Takes the given stretches of the motion. Keeps references to recording and motion, which must exist longer than it.
  TorqueBalance(const Recording& recording, const Motion& motion, const std::vector<Stretch>& stretches);

  // Returns the same along parts of it, `max_s` together at most.
  TorqueBalance excerpt(double max_s) const;

  Eigen::Index nodes() const { return static_cast<Eigen::Index>(tick_.size()); }
  Eigen::Index parameters() const { return first_harmonic() + harmonic_columns_.cols(); }
  Eigen::Index first_map() const { return kFixedParameters; }
  Eigen::Index first_load() const { return kFixedParameters + map_.count(); }
  Eigen::Index first_harmonic() const { return first_load() + 1 + map_.count(); }
  const std::vector<MotorHarmonic>& harmonics() const { return harmonics_; }
  const PositionTerms& position_terms() const { return map_; }
  const std::vector<std::size_t>& ticks() const { return tick_; }  // of the nodes
  const Recording& recording() const { return recording_; }
  std::size_t tick_of(Eigen::Index node) const { return tick_[static_cast<std::size_t>(node)]; }

  // Adds a harmonic of the motor: two more parameters, at the end.
  void add_harmonic(const MotorHarmonic& harmonic);

  // Computes the residuals [Nm] by node and, on request, their derivatives.
  void evaluate(const Eigen::VectorXd& parameters, Eigen::VectorXd& residual_nm, Jacobian *jacobian) const;

  // Returns where the unknown start of the bristles has decayed: there the residual is meaningful.
  std::vector<Span> known(const Eigen::VectorXd& parameters) const;

 private:
  struct Part {  // one stretch
    Stretch ticks;
    Eigen::Index first_node;
    Eigen::Index nodes;
  };

  // From derivatives by the bristles' parameters to those by their logarithms; sigma1 at the end.
  using Scale = std::array<double, kStiffness + 2>;

  struct FrictionRow {
    std::array<double, kInertia> by;  // the terms before kInertia
    std::array<double, PositionTerms::kMax> by_map;
  };

  FrictionRow friction_row(const Lugre::Step& step, const Scale& scale, bool forward, double viscous_nm) const;
  template <bool derivatives>
  void evaluate_part(const Part& part, const Eigen::VectorXd& parameters, Eigen::VectorXd& residual_nm,
                     Jacobian *jacobian) const;
  void add_linear_parts(Eigen::Index node, const Eigen::VectorXd& parameters, Eigen::VectorXd& residual_nm,
                        Jacobian *jacobian) const;
  double level_at(const Eigen::VectorXd& parameters, std::size_t tick) const;

  const Recording& recording_;
  const Motion& motion_;
  std::vector<Stretch> stretches_;
  PositionTerms map_;
  std::vector<Part> parts_;
  std::vector<MotorHarmonic> harmonics_;
  Eigen::MatrixXd harmonic_columns_;                            // by node, cosine and sine of each
  std::vector<std::size_t> tick_;                               // by node
  std::vector<double> acceleration_;                            // inertial, by node
  std::vector<double> torque_;                                  // under the triangle, by tick: for the lookup of delays
  std::vector<std::array<double, PositionTerms::kMax>> terms_;  // by tick
};

// Returns the friction for a parameter vector.
Friction friction_of(const Eigen::VectorXd& parameters);

}  // namespace trackservo::identification

#endif
