// SPDX-License-Identifier: Apache-2.0
#include "identification/start_search.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "identification/noise_model.hpp"
#include "identification/window.hpp"

namespace trackservo::identification {

namespace {

enum Column { kTcPlus, kTsPlus, kTcMinus, kTsMinus, kS2Plus, kS2Minus, kBend, kAcceleration, kLoad, kColumns };

// Of the recording; the search finds the neighbourhood, not the last percent.
constexpr double kMax_s = 80;
// Bristle lengths that are tried at first, then around the best of them.
constexpr double kShortest_rad = 2e-6;
constexpr double kLongest_rad = 0.1;
constexpr int kLengths = 16;
constexpr int kFineLengths = 9;
constexpr double kFineRange = 2.5;
constexpr int kSpeeds = 18;
constexpr double kSpeedRange = 3000;  // from the fastest speed
constexpr int kNoiseOrder = 6;

using Columns = Eigen::Matrix<double, Eigen::Dynamic, kColumns, Eigen::RowMajor>;

struct Candidate {
  double length_rad = 0;
  double stribeck_rad_s = 0;
  double squares = INFINITY;
  Eigen::Matrix<double, kColumns, 1> solution = Eigen::Matrix<double, kColumns, 1>::Zero();
};

std::vector<double> geometric(double first, double last, int count) {
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    values.push_back(first * std::pow(last / first, static_cast<double>(i) / (count - 1)));
  }
  return values;
}

class Search {
 public:
  Search(const Recording& recording, const Motion& motion) : recording_(recording), motion_(motion) {
    for (const Stretch& stretch : excerpt(motion.stretches, kMax_s)) {
      Span span{static_cast<Eigen::Index>(node_tick_.size()), 0};
      for (std::size_t i = stretch.first + kWindowReach; i + kWindowReach < stretch.last; i += kHalfWindow) {
        node_tick_.push_back(i);
      }
      span.last = static_cast<Eigen::Index>(node_tick_.size());
      spans_.push_back(span);
      stretches_.push_back(stretch);
      for (std::size_t i = stretch.first; i < stretch.last; ++i) {
        highest_rad_s_ = std::max(highest_rad_s_, std::abs(motion.joint_rate_rad_s[i]));
      }
    }
    torque_.resize(static_cast<Eigen::Index>(node_tick_.size()));
    for (Eigen::Index node = 0; node < torque_.size(); ++node) {
      torque_[node] = triangle_mean(recording.torque_nm, tick(node));
    }
  }

  // The noise is not known before friction is, nor friction before the noise: once for calm air, once for wind, each
  // time with better noise. The result with the smallest remainder is right.
  Candidate best() {
    Candidate best;
    double min_nm = INFINITY;
    for (const NoiseModel& first : {NoiseModel(), NoiseModel::slow_drift()}) {
      noise_ = first;
      std::vector<double> lengths_rad = geometric(kShortest_rad, kLongest_rad, kLengths);
      renew_noise(scan(lengths_rad).any);
      Found found = scan(lengths_rad);
      renew_noise(found.any);
      const double middle_rad = found.plausible.length_rad;
      if (!(middle_rad > 0)) {
        continue;
      }
      found = scan(geometric(middle_rad / kFineRange, middle_rad * kFineRange, kFineLengths));
      renew_noise(found.plausible);
      if (found.plausible.length_rad > 0 && noise_.innovation_nm() < min_nm) {
        min_nm = noise_.innovation_nm();
        best = found.plausible;
      }
    }
    return best;
  }

 private:
  using Series = std::vector<float>;  // by tick; a thousandth is precise enough

  std::size_t tick(Eigen::Index node) const { return node_tick_[static_cast<std::size_t>(node)]; }

  // The bristles' bend, -1..1: at the end of each tick.
  Series bend(double length_rad) const {
    Series bend(recording_.ticks(), 0.0F);
    for (const Stretch& stretch : stretches_) {
      double h = 0;
      for (std::size_t i = stretch.first; i < stretch.last; ++i) {
        const double lengths = motion_.joint_rate_rad_s[i] * kTick_s / length_rad;
        const double side = lengths >= 0 ? 1.0 : -1.0;
        h = side + (h - side) * std::exp(-std::abs(lengths));
        bend[i] = static_cast<float>(h);
      }
    }
    return bend;
  }

  // Share of Ts - Tc at each tick's speed, 0..1.
  Series shares(double stribeck_rad_s) const {
    Series shares(recording_.ticks(), 0.0F);
    for (const Stretch& stretch : stretches_) {
      for (std::size_t i = stretch.first; i < stretch.last; ++i) {
        const double ratio = motion_.joint_rate_rad_s[i] / stribeck_rad_s;
        shares[i] = std::exp(static_cast<float>(-ratio * ratio));
      }
    }
    return shares;
  }

  Columns columns(const Series& bend, const Series& shares) const {
    Columns columns = Columns::Zero(torque_.size(), kColumns);
    for (Eigen::Index node = 0; node < columns.rows(); ++node) {
      const std::size_t middle = tick(node);
      auto row = columns.row(node);
      for (std::size_t j = 0; j < kTriangle.size(); ++j) {
        const std::size_t i = middle + j - kHalfWindow;
        const double rate = motion_.joint_rate_rad_s[i];
        const auto bent = static_cast<double>(bend[i]);
        const auto share = static_cast<double>(shares[i]);
        const double weight = kTriangle[j];
        const bool forward = rate >= 0;
        row[forward ? kTcPlus : kTcMinus] += weight * bent * (1.0 - share);
        row[forward ? kTsPlus : kTsMinus] += weight * bent * share;
        row[forward ? kS2Plus : kS2Minus] += weight * rate;
        row[kBend] += weight * (bent - static_cast<double>(bend[i - 1])) / kTick_s;
      }
      row[kAcceleration] = triangle_second_derivative(motion_.joint_angle_rad, middle);
      row[kLoad] = 1.0;
    }
    return columns;
  }

  void renew_noise(const Candidate& candidate) {
    if (candidate.length_rad > 0) {
      const Eigen::VectorXd residual =
          torque_ - columns(bend(candidate.length_rad), shares(candidate.stribeck_rad_s)) * candidate.solution;
      noise_ = NoiseModel::fit(residual, Eigen::VectorXd::Ones(residual.size()), spans_, kNoiseOrder);
    }
  }

  // The best of all, and the best with friction that resists in both directions.
  struct Found {
    Candidate any;
    Candidate plausible;
  };

  Found scan(const std::vector<double>& lengths_rad) const {
    Eigen::VectorXd white_torque = torque_;
    noise_.whiten(spans_, white_torque);
    std::vector<Series> bends;
    bends.reserve(lengths_rad.size());
    for (const double length_rad : lengths_rad) {
      bends.push_back(bend(length_rad));
    }
    const double highest = std::max(1e-9, highest_rad_s_);
    Found best;
    for (const double stribeck_rad_s : geometric(highest, highest / kSpeedRange, kSpeeds)) {
      const Series shares = this->shares(stribeck_rad_s);
      for (std::size_t l = 0; l < lengths_rad.size(); ++l) {
        Columns white = columns(bends[l], shares);
        noise_.whiten(spans_, white);
        Eigen::Matrix<double, kColumns, kColumns> normal = white.transpose() * white;
        normal.diagonal() *= 1.0 + 1e-9;
        const Eigen::Matrix<double, kColumns, 1> solution = normal.ldlt().solve(white.transpose() * white_torque);
        const double squares = (white_torque - white * solution).squaredNorm();
        const bool friction =
            solution[kTcPlus] > 0 && solution[kTcMinus] > 0 && solution[kTsPlus] > 0 && solution[kTsMinus] > 0;
        if (squares < best.any.squares) {
          best.any = {lengths_rad[l], stribeck_rad_s, squares, solution};
        }
        if (friction && squares < best.plausible.squares) {
          best.plausible = {lengths_rad[l], stribeck_rad_s, squares, solution};
        }
      }
    }
    return best;
  }

  const Recording& recording_;
  const Motion& motion_;
  std::vector<Stretch> stretches_;
  std::vector<std::size_t> node_tick_;
  std::vector<Span> spans_;
  Eigen::VectorXd torque_;
  double highest_rad_s_ = 0;
  NoiseModel noise_ = NoiseModel::slow_drift();
};

}  // namespace

PaperEstimate search_start(const Recording& recording, const Motion& motion, const PaperEstimate& paper) {
  PaperEstimate found = paper;
  const Candidate best = Search(recording, motion).best();
  if (!(best.length_rad > 0)) {
    return found;
  }
  const auto& s = best.solution;
  const double viscous_floor = 0.01 * s[kTcPlus] / best.stribeck_rad_s;
  found.friction.positive = {s[kTcPlus], s[kTsPlus], best.stribeck_rad_s, std::max(s[kS2Plus], viscous_floor)};
  found.friction.negative = {s[kTcMinus], s[kTsMinus], best.stribeck_rad_s, std::max(s[kS2Minus], viscous_floor)};
  found.friction.stiffness_nm_rad = 0.5 * (s[kTsPlus] + s[kTsMinus]) / best.length_rad;
  if (s[kBend] > 0) {
    found.friction.damping_nm_s_rad = s[kBend] / best.length_rad;
  }
  if (s[kAcceleration] > 0) {
    found.inertia_kg_m2 = s[kAcceleration];
  }
  found.load_nm = s[kLoad];
  return found;
}

}  // namespace trackservo::identification
