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

constexpr int kLengths = 9;  // from a tenth to ten times the paper's
constexpr double kLengthRange = 10.0;
constexpr int kSpeeds = 24;
constexpr int kNoiseOrder = 6;

using Columns = Eigen::Matrix<double, Eigen::Dynamic, kColumns, Eigen::RowMajor>;

struct Candidate {
  double length_rad = 0;
  double stribeck_rad_s = 0;
  double squares = INFINITY;
  Eigen::Matrix<double, kColumns, 1> solution = Eigen::Matrix<double, kColumns, 1>::Zero();
};

class Search {
 public:
  Search(const Recording& recording, const Motion& motion) : recording_(recording), motion_(motion) {
    for (const Stretch& stretch : motion.stretches) {
      Span span{static_cast<Eigen::Index>(node_tick_.size()), 0};
      for (std::size_t i = stretch.first + kHalfWindow; i + kHalfWindow < stretch.last; i += kHalfWindow) {
        node_tick_.push_back(i);
      }
      span.last = static_cast<Eigen::Index>(node_tick_.size());
      spans_.push_back(span);
    }
    torque_.resize(static_cast<Eigen::Index>(node_tick_.size()));
    for (Eigen::Index node = 0; node < torque_.size(); ++node) {
      torque_[node] = triangle_mean(recording.torque_nm, tick(node));
    }
  }

  // Twice: noise that is only known after the first time makes the second one sharper.
  Candidate best(double length_rad) {
    Candidate best = scan(length_rad, kLengthRange);
    Eigen::VectorXd residual = torque_ - columns(bend(best.length_rad), best.stribeck_rad_s) * best.solution;
    noise_ = NoiseModel::fit(residual, Eigen::VectorXd::Ones(residual.size()), spans_, kNoiseOrder);
    return scan(best.length_rad, std::sqrt(kLengthRange));
  }

 private:
  std::size_t tick(Eigen::Index node) const { return node_tick_[static_cast<std::size_t>(node)]; }

  // The bristles' bend, -1..1: at the end of each tick.
  std::vector<double> bend(double length_rad) const {
    std::vector<double> bend(recording_.ticks(), 0.0);
    for (const Stretch& stretch : motion_.stretches) {
      double h = 0;
      for (std::size_t i = stretch.first; i < stretch.last; ++i) {
        const double way = motion_.joint_rate_rad_s[i] * kTick_s / length_rad;
        const double side = way >= 0 ? 1.0 : -1.0;
        h = side + (h - side) * std::exp(-std::abs(way));
        bend[i] = h;
      }
    }
    return bend;
  }

  Columns columns(const std::vector<double>& bend, double stribeck_rad_s) const {
    Columns columns = Columns::Zero(torque_.size(), kColumns);
    for (Eigen::Index node = 0; node < columns.rows(); ++node) {
      const std::size_t middle = tick(node);
      auto row = columns.row(node);
      for (std::size_t j = 0; j < kTriangle.size(); ++j) {
        const std::size_t i = middle + 1 + j - kHalfWindow;
        const double rate = motion_.joint_rate_rad_s[i];
        const double ratio = rate / stribeck_rad_s;
        const double share = std::exp(-ratio * ratio);
        const double weight = kTriangle[j];
        const bool forward = rate >= 0;
        row[forward ? kTcPlus : kTcMinus] += weight * bend[i] * (1.0 - share);
        row[forward ? kTsPlus : kTsMinus] += weight * bend[i] * share;
        row[forward ? kS2Plus : kS2Minus] += weight * rate;
        row[kBend] += weight * (bend[i] - bend[i - 1]) / kTick_s;
      }
      row[kAcceleration] = triangle_second_derivative(recording_.joint_angle_rad, middle);
      row[kLoad] = 1.0;
    }
    return columns;
  }

  Candidate scan(double middle_rad, double range) {
    Eigen::VectorXd white_torque = torque_;
    noise_.whiten(spans_, white_torque);
    const double highest = std::max(1e-9, highest_rate());
    Candidate best;
    for (int l = 0; l < kLengths; ++l) {
      const double length_rad = middle_rad * std::pow(range, 2.0 * l / (kLengths - 1) - 1.0);
      const std::vector<double> bend = this->bend(length_rad);
      for (int s = 0; s < kSpeeds; ++s) {
        const double stribeck = highest * std::pow(10.0, -3.5 * s / (kSpeeds - 1));
        Columns white = columns(bend, stribeck);
        noise_.whiten(spans_, white);
        Eigen::Matrix<double, kColumns, kColumns> normal = white.transpose() * white;
        normal.diagonal() *= 1.0 + 1e-9;
        const Eigen::Matrix<double, kColumns, 1> solution = normal.ldlt().solve(white.transpose() * white_torque);
        const double squares = (white_torque - white * solution).squaredNorm();
        const bool friction =
            solution[kTcPlus] > 0 && solution[kTcMinus] > 0 && solution[kTsPlus] > 0 && solution[kTsMinus] > 0;
        if (friction && squares < best.squares) {
          best = {length_rad, stribeck, squares, solution};
        }
      }
    }
    return best;
  }

  double highest_rate() const {
    double highest = 0;
    for (const double rate : motion_.joint_rate_rad_s) {
      highest = std::max(highest, std::abs(rate));
    }
    return highest;
  }

  const Recording& recording_;
  const Motion& motion_;
  std::vector<std::size_t> node_tick_;
  std::vector<Span> spans_;
  Eigen::VectorXd torque_;
  NoiseModel noise_ = NoiseModel::slow_drift();
};

}  // namespace

PaperEstimate search_start(const Recording& recording, const Motion& motion, const PaperEstimate& paper) {
  PaperEstimate found = paper;
  const double level_nm =
      std::max(0.5 * (paper.friction.positive.coulomb_nm + paper.friction.negative.coulomb_nm), 1e-9);
  const Candidate best = Search(recording, motion).best(level_nm / paper.friction.stiffness_nm_rad);
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
