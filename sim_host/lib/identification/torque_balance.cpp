// SPDX-License-Identifier: Apache-2.0
#include "identification/torque_balance.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "identification/window.hpp"

namespace trackservo::identification {

namespace {

// Ticks at both ends of a stretch whose windows or delays would reach beyond it.
constexpr std::size_t kMargin = 2 * kHalfWindow;
constexpr double kLongestDelay_s = static_cast<double>(kHalfWindow - 2) * kTick_s;
constexpr double kForgotten = 7.0;       // e^-7: a thousandth of the first bristle force
constexpr double kMinLevel = 0.05;       // the map never removes all friction
constexpr std::size_t kFilterEnds = 50;  // ticks in which the low-passes extend beyond the stretch

// Cubic through the values around `at` ticks before tick i, with its slope and curvature by `at`.
struct Delayed {
  double value;
  double slope;
  double curve;
};

Delayed delayed(const std::vector<double>& values, std::size_t i, double at) {
  const double back = std::floor(at);
  const double u = at - back;  // between the ticks `back` and `back + 1` before
  const auto index = static_cast<std::ptrdiff_t>(i) - static_cast<std::ptrdiff_t>(back);
  const double a = values[static_cast<std::size_t>(index + 1)];
  const double b = values[static_cast<std::size_t>(index)];
  const double c = values[static_cast<std::size_t>(index - 1)];
  const double d = values[static_cast<std::size_t>(index - 2)];
  const double linear = -a / 3.0 - b / 2.0 + c - d / 6.0;
  const double square = (a + c) / 2.0 - b;
  const double cube = (d - a) / 6.0 + (b - c) / 2.0;
  return {b + u * (linear + u * (square + u * cube)), linear + u * (2.0 * square + 3.0 * u * cube),
          2.0 * square + 6.0 * u * cube};
}

DirectionFriction direction_of(const Eigen::VectorXd& p, int coulomb, int viscous) {
  return {std::exp(p[coulomb]), std::exp(p[coulomb + 1]), std::exp(p[coulomb + 2]), std::exp(p[viscous])};
}

}  // namespace

Friction friction_of(const Eigen::VectorXd& p) {
  return {std::exp(p[kStiffness]), std::exp(p[kDamping]), direction_of(p, kCoulombPositive, kViscousPositive),
          direction_of(p, kCoulombNegative, kViscousNegative)};
}

TorqueBalance::TorqueBalance(const Recording& recording, const Motion& motion, const std::vector<Stretch>& stretches)
    : recording_(recording), motion_(motion), stretches_(stretches), map_(recording), torque_(recording.ticks(), 0.0) {
  for (const Stretch& stretch : stretches) {
    Part part{stretch, nodes(), 0};
    for (std::size_t i = stretch.first + kWindowReach; i + kWindowReach < stretch.last; ++i) {
      torque_[i] = triangle_mean(recording.torque_nm, i);
    }
    for (std::size_t i = stretch.first + kMargin; i + kMargin < stretch.last; i += kHalfWindow) {
      tick_.push_back(i);
      acceleration_.push_back(triangle_second_derivative(motion.joint_angle_rad, i) +
                              triangle_derivative(motion.base_rate_rad_s, i));
    }
    part.nodes = nodes() - part.first_node;
    parts_.push_back(part);
  }
  harmonic_columns_.resize(nodes(), 0);
  terms_.reserve(recording.ticks());
  for (const double angle_rad : recording.joint_angle_rad) {
    terms_.push_back(map_.at(angle_rad));
  }
}

TorqueBalance TorqueBalance::excerpt(double max_s) const {
  return {recording_, motion_, identification::excerpt(stretches_, max_s)};
}

void TorqueBalance::add_harmonic(const MotorHarmonic& harmonic) {
  harmonics_.push_back(harmonic);
  harmonic_columns_.conservativeResize(Eigen::NoChange, harmonic_columns_.cols() + 2);
  harmonic_columns_.rightCols(2) = identification::harmonic_columns(recording_, tick_, harmonic);
}

double TorqueBalance::level_at(const Eigen::VectorXd& parameters, std::size_t tick) const {
  double level = 1.0;
  for (int term = 0; term < map_.count(); ++term) {
    level += parameters[first_map() + term] * terms_[tick][static_cast<std::size_t>(term)];
  }
  return std::max(level, kMinLevel);
}

void TorqueBalance::add_linear_parts(Eigen::Index node, const Eigen::VectorXd& parameters, Eigen::VectorXd& residual_nm,
                                     Jacobian *jacobian) const {
  const auto n = static_cast<std::size_t>(node);
  const double delay_s = std::clamp(parameters[kDelay], -kLongestDelay_s, kLongestDelay_s);
  const Delayed torque = delayed(torque_, tick_[n], delay_s / kTick_s);
  const double inertial_nm = std::exp(parameters[kInertia]) * acceleration_[n];
  double load_nm = parameters[first_load()];
  for (int term = 0; term < map_.count(); ++term) {
    load_nm += parameters[first_load() + 1 + term] * terms_[tick_[n]][static_cast<std::size_t>(term)];
  }
  const double spread_nm_s2 = torque.curve / (kTick_s * kTick_s);
  residual_nm[node] += torque.value + parameters[kSpread] * spread_nm_s2 - inertial_nm - load_nm;
  if (jacobian != nullptr) {
    auto row = jacobian->row(node);
    row[kDelay] = torque.slope / kTick_s;  // the spread adds some thousandths to it
    row[kSpread] = spread_nm_s2;
    row[kInertia] = -inertial_nm;
    row[first_load()] = -1.0;
    for (int term = 0; term < map_.count(); ++term) {
      row[first_load() + 1 + term] = -terms_[tick_[n]][static_cast<std::size_t>(term)];
    }
  }
}

// Of a tick's friction torque, in the order of the parameters.
TorqueBalance::FrictionRow TorqueBalance::friction_row(const Lugre::Step& step, const Scale& scale, bool forward,
                                                       double viscous_nm) const {
  FrictionRow row{};
  const auto by = [&](std::size_t p) { return step.bristle_by[p] + scale.back() * step.damping_by[p]; };
  for (std::size_t p = 0; p <= kStiffness; ++p) {
    row.by[p] = scale[p] * by(p);  // cppcheck-suppress containerOutOfBounds; it has a row for each parameter
  }
  row.by[forward ? kViscousPositive : kViscousNegative] = viscous_nm;
  row.by[kDamping] = scale.back() * step.damping_rad_s;
  for (std::size_t term = 0; term < row.by_map.size(); ++term) {
    row.by_map[term] = by(kLevel + term);
  }
  return row;
}

template <bool derivatives>
void TorqueBalance::evaluate_part(const Part& part, const Eigen::VectorXd& parameters, Eigen::VectorXd& residual_nm,
                                  Jacobian *jacobian) const {
  const Friction friction = friction_of(parameters);
  Lugre lugre(friction, map_.count());
  Scale scale{};
  for (int i = 0; i <= kStiffness; ++i) {
    scale[static_cast<std::size_t>(i)] = std::exp(parameters[i]);
  }
  scale.back() = friction.damping_nm_s_rad;
  const auto half = static_cast<std::ptrdiff_t>(kHalfWindow);
  const auto first_begin = static_cast<std::ptrdiff_t>(kMargin - kHalfWindow);
  constexpr auto kTicks = static_cast<std::ptrdiff_t>(kTriangle.size());
  for (std::size_t i = part.ticks.first; i < part.ticks.last; ++i) {
    const double rate = motion_.joint_rate_rad_s[i];
    const Lugre::Step& step = lugre.advance<derivatives>(rate, kTick_s, level_at(parameters, i), terms_[i].data());
    const bool forward = rate >= 0.0;
    const double viscous_nm =
        (forward ? friction.positive.viscous_nm_s_rad : friction.negative.viscous_nm_s_rad) * rate;
    const double torque_nm = step.bristle_nm + friction.damping_nm_s_rad * step.damping_rad_s + viscous_nm;
    FrictionRow tick_row;
    if constexpr (derivatives) {
      tick_row = friction_row(step, scale, forward, viscous_nm);
    }
    // A tick lies under up to three triangles, half a window apart. Ticks are counted from the start of the first one.
    const std::ptrdiff_t tick = static_cast<std::ptrdiff_t>(i - part.ticks.first) - first_begin;
    for (std::ptrdiff_t node = tick / half; tick >= 0 && node >= 0 && tick - node * half < kTicks; --node) {
      if (node >= part.nodes) {
        continue;
      }
      const double weight = kTriangle[static_cast<std::size_t>(tick - node * half)];
      residual_nm[part.first_node + node] -= weight * torque_nm;
      if constexpr (derivatives) {
        auto row = jacobian->row(part.first_node + node);
        row.head<kInertia>() -= weight * Eigen::Map<const Eigen::RowVectorXd>(tick_row.by.data(), kInertia);
        row.segment(first_map(), map_.count()) -=
            weight * Eigen::Map<const Eigen::RowVectorXd>(tick_row.by_map.data(), map_.count());
      }
    }
  }
}

void TorqueBalance::evaluate(const Eigen::VectorXd& parameters, Eigen::VectorXd& residual_nm,
                             Jacobian *jacobian) const {
  residual_nm.setZero(nodes());
  if (jacobian != nullptr) {
    jacobian->setZero(nodes(), this->parameters());
  }
  for (const Part& part : parts_) {
    if (jacobian != nullptr) {
      evaluate_part<true>(part, parameters, residual_nm, jacobian);
    } else {
      evaluate_part<false>(part, parameters, residual_nm, nullptr);
    }
  }
  for (Eigen::Index node = 0; node < nodes(); ++node) {
    add_linear_parts(node, parameters, residual_nm, jacobian);
  }
  const Eigen::Index harmonic = harmonic_columns_.cols();
  residual_nm += harmonic_columns_ * parameters.tail(harmonic);
  if (jacobian != nullptr) {
    jacobian->rightCols(harmonic) = harmonic_columns_;
  }
}

std::vector<Span> TorqueBalance::known(const Eigen::VectorXd& parameters) const {
  const Friction friction = friction_of(parameters);
  std::vector<Span> spans;
  for (const Part& part : parts_) {
    double forgotten = 0;
    std::size_t i = part.ticks.first;
    for (; i < part.ticks.last && forgotten < kForgotten; ++i) {
      const double rate = motion_.joint_rate_rad_s[i];
      const DirectionFriction& direction = rate >= 0.0 ? friction.positive : friction.negative;
      forgotten += friction.stiffness_nm_rad * std::abs(rate) * kTick_s / direction.level_nm(std::abs(rate));
    }
    Span span{part.first_node, part.first_node + part.nodes};
    const std::size_t begin = std::max(i + kHalfWindow, part.ticks.first + kFilterEnds);
    while (span.first < span.last && tick_of(span.first) < begin) {
      ++span.first;
    }
    while (span.last > span.first && tick_of(span.last - 1) + kFilterEnds >= part.ticks.last) {
      --span.last;
    }
    if (span.last > span.first) {
      spans.push_back(span);
    }
  }
  return spans;
}

}  // namespace trackservo::identification
