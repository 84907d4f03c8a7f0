// SPDX-License-Identifier: Apache-2.0
// The motor's deviation from Kt times current: ripple, in proportion to the torque, and cogging, both periodic in the
// angle.
//
//   torque = u (1 + sum r_h cos(h angle + ...)) + sum c_h cos(h angle + ...)
//
// Quick reversals at one place repeat the same phase of the ripple, so 1.5 % of it can shift sigma2 by several percent.
// The harmonics of the motor need not be given: those that the residuals show beyond doubt are used.
#ifndef TRACKSERVO_IDENTIFICATION_MOTOR_HARMONICS_HPP
#define TRACKSERVO_IDENTIFICATION_MOTOR_HARMONICS_HPP

#include <Eigen/Core>
#include <vector>

#include "identification/recording.hpp"

namespace trackservo::identification {

struct MotorHarmonic {
  int per_turn = 0;
  bool ripple = false;  // else cogging
};

// Candidate harmonics. Once and twice per turn belong to the friction map and the load.
constexpr int kLowestHarmonic = 3;
constexpr int kHighestHarmonic = 48;

// Returns cosine and sine column of a harmonic under the triangle, at the given ticks.
Eigen::MatrixX2d harmonic_columns(const Recording& recording, const std::vector<std::size_t>& ticks,
                                  const MotorHarmonic& harmonic);

}  // namespace trackservo::identification

#endif
