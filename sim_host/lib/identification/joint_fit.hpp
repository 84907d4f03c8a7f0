// SPDX-License-Identifier: Apache-2.0
// All parameters from all runs together: generalised least squares on the torque balance.
//
// Repeated until nothing changes: model the noise of the residuals (noise_model.hpp), whiten, reduce the weight of
// outliers (Huber), minimise by Levenberg-Marquardt. The covariance is cluster-robust (a sandwich estimator with
// clusters of 2 s), so that residual correlation and heteroscedasticity widen the intervals.
#ifndef TRACKSERVO_IDENTIFICATION_JOINT_FIT_HPP
#define TRACKSERVO_IDENTIFICATION_JOINT_FIT_HPP

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "identification/noise_model.hpp"
#include "identification/paper_method.hpp"
#include "identification/torque_balance.hpp"

namespace trackservo::identification {

struct JointFit {
  Eigen::VectorXd start;  // as in TorqueBalance: logarithms first
  Eigen::VectorXd parameters;
  Eigen::MatrixXd covariance;
  NoiseModel noise;
  std::vector<Span> spans;  // of the used nodes
  Eigen::VectorXd residual_nm;
  Eigen::VectorXd whitened;  // standard deviation about 1
  Eigen::VectorXd weights;   // Huber's, 0..1
  bool converged = false;
  int rounds = 0;
  double widening = 1;  // largest ratio of the clusters' standard deviation to that of white residuals

  double deviation(Eigen::Index parameter) const;
};

// Returns the parameter vector that the paper's method gives.
Eigen::VectorXd start_parameters(const TorqueBalance& balance, const PaperEstimate& estimate);

// Fits from the best of several starts (they differ in the parameters that have local minima). Harmonics of the motor
// that the residuals show are added to the balance in between.
JointFit fit_jointly(TorqueBalance& balance, const std::vector<Eigen::VectorXd>& starts);

// Starts around one: other Stribeck speeds, over all speeds in the recording.
std::vector<Eigen::VectorXd> starts_around(const Motion& motion, const Eigen::VectorXd& start);

}  // namespace trackservo::identification

#endif
