// SPDX-License-Identifier: Apache-2.0
// Nonlinear least squares by Levenberg and Marquardt: Eigen's port of MINPACK, compiled once for every fit.
#ifndef TRACKSERVO_IDENTIFICATION_LEAST_SQUARES_HPP
#define TRACKSERVO_IDENTIFICATION_LEAST_SQUARES_HPP

#include <Eigen/Core>
#include <functional>

namespace trackservo::identification {

struct LeastSquares {
  Eigen::Index residuals;   // at least as many as parameters
  Eigen::Index parameters;  // at least 1
  // Fills in `residuals` values; false ends the fit where it is.
  std::function<bool(const Eigen::VectorXd& parameters, Eigen::VectorXd& residuals)> evaluate;
  // Derivative of each residual (row) by each parameter (column); none: forward differences.
  std::function<void(const Eigen::VectorXd& parameters, Eigen::MatrixXd& jacobian)> differentiate;
};

struct LeastSquaresEnd {
  // MINPACK's defaults; the tolerances are the root of the smallest relative difference of two doubles.
  int max_evaluations = 400;
  double residual_tolerance = 0x1p-26;   // relative decrease of the sum of squares
  double parameter_tolerance = 0x1p-26;  // relative change of the parameters
};

// Searches from `parameters` for the nearest minimum of the sum of squares, which replaces them. Returns the root of
// that sum.
double minimize(const LeastSquares& problem, const LeastSquaresEnd& end, Eigen::VectorXd& parameters);

}  // namespace trackservo::identification

#endif
