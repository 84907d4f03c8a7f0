// SPDX-License-Identifier: Apache-2.0
#include "identification/stribeck_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

namespace trackservo::identification {

namespace {

// With the Stribeck speed given, eq. (5) is linear: Tc, Ts - Tc and sigma2, none below zero. Returns the remaining
// weighted sum of squares.
double fit_linear_part(const std::vector<SteadyPoint>& points, double stribeck_speed_rad_s,
                       DirectionFriction& direction) {
  const auto rows = static_cast<Eigen::Index>(points.size());
  double best = std::numeric_limits<double>::infinity();
  // A negative excess or viscosity is left out: try all four combinations and keep the best without one.
  for (int without = 0; without < 4; ++without) {
    Eigen::MatrixXd shapes(rows, 3);
    Eigen::VectorXd torque(rows);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const SteadyPoint& point = points[static_cast<std::size_t>(i)];
      const double ratio = point.speed_rad_s / stribeck_speed_rad_s;
      const double root = std::sqrt(point.weight);
      shapes.row(i) << root, (without & 1) != 0 ? 0.0 : root * std::exp(-ratio * ratio),
          (without & 2) != 0 ? 0.0 : root * point.speed_rad_s;
      torque[i] = root * point.friction_nm;
    }
    const Eigen::Vector3d solution = shapes.completeOrthogonalDecomposition().solve(torque);
    const double left = (torque - shapes * solution).squaredNorm();
    if (solution[0] > 0 && solution[1] >= 0 && solution[2] >= 0 && left < best) {
      best = left;
      direction = {solution[0], solution[0] + solution[1], stribeck_speed_rad_s, solution[2]};
    }
  }
  return best;
}

}  // namespace

std::optional<DirectionFriction> fit_stribeck(const std::vector<SteadyPoint>& points) {
  if (points.size() < 4) {
    return std::nullopt;
  }
  const auto [slowest, fastest] =
      std::minmax_element(points.begin(), points.end(),
                          [](const SteadyPoint& a, const SteadyPoint& b) { return a.speed_rad_s < b.speed_rad_s; });
  if (!(slowest->speed_rad_s > 0)) {
    return std::nullopt;
  }
  // One nonlinear parameter is left, between the slowest and the fastest speed: a fine scan is certain to find the
  // best.
  constexpr int kSteps = 400;
  const double span = std::log(fastest->speed_rad_s / slowest->speed_rad_s);
  double best = std::numeric_limits<double>::infinity();
  std::optional<DirectionFriction> found;
  for (int step = 0; step <= kSteps; ++step) {
    DirectionFriction direction;
    const double left = fit_linear_part(points, slowest->speed_rad_s * std::exp(span * step / kSteps), direction);
    if (left < best) {
      best = left;
      found = direction;
    }
  }
  return found;
}

}  // namespace trackservo::identification
