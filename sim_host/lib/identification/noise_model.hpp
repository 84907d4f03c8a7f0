// SPDX-License-Identifier: Apache-2.0
// The noise of the residuals as an autoregressive process, and the filter that makes it white.
//
//   e_k = r_k + a_1 r_(k-1) + ... + a_p r_(k-p)
//
// Wind is slow and strong, sensor noise is fast and weak. Ordinary least squares would weight both equally, and would
// assume far more independent values than there are. After whitening least squares is the best estimate, and its
// covariance the true one.
#ifndef TRACKSERVO_IDENTIFICATION_NOISE_MODEL_HPP
#define TRACKSERVO_IDENTIFICATION_NOISE_MODEL_HPP

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "identification/torque_balance.hpp"

namespace trackservo::identification {

class NoiseModel {
 public:
  // Makes white noise of standard deviation 1.
  NoiseModel() = default;

  // Returns wind before any fit: two poles far below the nodes' rate.
  static NoiseModel slow_drift();

  // Fits the noise to residuals, the order chosen by BIC up to `most`; `weights` (0..1) are the weights of the nodes.
  static NoiseModel fit(const Eigen::VectorXd& residual_nm, const Eigen::VectorXd& weights,
                        const std::vector<Span>& spans, int most);

  int order() const { return static_cast<int>(coefficients_.size()); }
  const Eigen::VectorXd& coefficients() const { return coefficients_; }
  double innovation_nm() const { return innovation_nm_; }

  // Whitens the values to standard deviation 1, column by column; 0 outside of the spans and in their first `order`
  // nodes.
  template <class Rows>
  void whiten(const std::vector<Span>& spans, Rows& values) const;

 private:
  Eigen::VectorXd coefficients_;
  double innovation_nm_ = 1;
};

// Returns the correlation of whitened residuals at lags 1..`lags`.
Eigen::VectorXd autocorrelation(const Eigen::VectorXd& whitened, const std::vector<Span>& spans, int lags);

// Goes from the end, so that values that are still needed are not overwritten.
template <class Rows>
void NoiseModel::whiten(const std::vector<Span>& spans, Rows& values) const {
  const Eigen::Index order = coefficients_.size();
  Eigen::Index done = values.rows();  // rows from here on are finished
  for (auto span = spans.rbegin(); span != spans.rend(); ++span) {
    values.middleRows(span->last, done - span->last).setZero();
    for (Eigen::Index row = span->last - 1; row >= span->first + order; --row) {
      for (Eigen::Index lag = 1; lag <= order; ++lag) {
        values.row(row) += coefficients_[lag - 1] * values.row(row - lag);
      }
      values.row(row) *= 1.0 / innovation_nm_;
    }
    const Eigen::Index lost = std::min(order, span->last - span->first);
    values.middleRows(span->first, lost).setZero();
    done = span->first;
  }
  values.topRows(done).setZero();
}

}  // namespace trackservo::identification

#endif
