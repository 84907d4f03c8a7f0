// SPDX-License-Identifier: Apache-2.0
#include "identification/noise_model.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace trackservo::identification {

NoiseModel NoiseModel::slow_drift() {
  constexpr double kPole = 0.98;
  NoiseModel model;
  model.coefficients_ = Eigen::Vector2d(-2.0 * kPole, kPole * kPole);
  return model;
}

NoiseModel NoiseModel::fit(const Eigen::VectorXd& residual_nm, const Eigen::VectorXd& weights,
                           const std::vector<Span>& spans, int most) {
  // Products of (r_k, r_(k-1), ..., r_(k-most)): every order's normal equations are a corner of them.
  Eigen::MatrixXd moments = Eigen::MatrixXd::Zero(most + 1, most + 1);
  double count = 0;
  for (const Span& span : spans) {
    for (Eigen::Index k = span.first + most; k < span.last; ++k) {
      const Eigen::VectorXd past = residual_nm.segment(k - most, most + 1).reverse();
      moments.noalias() += weights[k] * past * past.transpose();
      count += weights[k];
    }
  }
  NoiseModel best;
  double best_bic = INFINITY;
  for (int order = 1; order <= most; order += order < 4 ? 1 : 2) {
    const Eigen::MatrixXd past = moments.block(1, 1, order, order);
    const Eigen::VectorXd cross = moments.block(1, 0, order, 1);
    const Eigen::VectorXd solution = past.ldlt().solve(cross);
    const double variance = (moments(0, 0) - solution.dot(cross)) / count;
    const double bic = count * std::log(variance) + order * std::log(count);
    if (variance > 0 && bic < best_bic) {
      best_bic = bic;
      best.coefficients_ = -solution;
      best.innovation_nm_ = std::sqrt(variance);
    }
  }
  return best;
}

Eigen::VectorXd autocorrelation(const Eigen::VectorXd& whitened, const std::vector<Span>& spans, int lags) {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(lags + 1);
  for (const Span& span : spans) {
    for (Eigen::Index k = span.first + lags; k < span.last; ++k) {
      for (int lag = 0; lag <= lags; ++lag) {
        sums[lag] += whitened[k] * whitened[k - lag];
      }
    }
  }
  return sums.tail(lags) / sums[0];
}

}  // namespace trackservo::identification
