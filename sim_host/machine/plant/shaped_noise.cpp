// SPDX-License-Identifier: Apache-2.0
#include "machine/plant/shaped_noise.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "machine/base/axis.hpp"

namespace trackservo::sim {

namespace {

// Stationary covariance P of dx/dt = A x + b w with unit white noise: A P + P A^T + b b^T = 0.
Eigen::Matrix2d stationary_covariance(const Eigen::Matrix2d& a, const Eigen::Vector2d& b) {
  Eigen::Matrix3d equations;                       // unknowns P00, P01, P11
  equations << 2.0 * a(0, 0), 2.0 * a(0, 1), 0.0,  //
      a(1, 0), a(0, 0) + a(1, 1), a(0, 1),         //
      0.0, 2.0 * a(1, 0), 2.0 * a(1, 1);
  const Eigen::Vector3d right(-b[0] * b[0], -b[0] * b[1], -b[1] * b[1]);
  const Eigen::Vector3d p = equations.fullPivLu().solve(right);
  Eigen::Matrix2d covariance;
  covariance << p[0], p[1], p[1], p[2];
  return covariance;
}

// Lower triangular S with S S^T = covariance, also for a singular one.
Eigen::Matrix2d square_root(const Eigen::Matrix2d& covariance) {
  Eigen::Matrix2d root = Eigen::Matrix2d::Zero();
  root(0, 0) = std::sqrt(std::max(covariance(0, 0), 0.0));
  root(1, 0) = root(0, 0) > 0.0 ? covariance(1, 0) / root(0, 0) : 0.0;
  root(1, 1) = std::sqrt(std::max(covariance(1, 1) - root(1, 0) * root(1, 0), 0.0));
  return root;
}

}  // namespace

ShapedNoise::ShapedNoise(const Eigen::Matrix2d& dynamics, const Eigen::Vector2d& input, double rms, double dt_s,
                         RandomStream stream)
    : stream_(stream) {
  const Eigen::Vector2d b = input * (rms / std::sqrt(stationary_covariance(dynamics, input)(0, 0)));
  Eigen::Matrix4d van_loan = Eigen::Matrix4d::Zero();
  van_loan.topLeftCorner<2, 2>() = -dynamics * dt_s;
  van_loan.topRightCorner<2, 2>() = b * b.transpose() * dt_s;
  van_loan.bottomRightCorner<2, 2>() = dynamics.transpose() * dt_s;
  const Eigen::Matrix4d exponential = van_loan.exp();
  transition_ = exponential.bottomRightCorner<2, 2>().transpose();
  spread_ = square_root(transition_ * exponential.topRightCorner<2, 2>());
  const double first = stream_.normal();
  const double second = stream_.normal();
  state_ = square_root(stationary_covariance(dynamics, b)) * Eigen::Vector2d(first, second);
}

ShapedNoise ShapedNoise::two_poles(double first_hz, double second_hz, double rms, double dt_s, RandomStream stream) {
  const double first = 2.0 * kPi * first_hz;
  const double second = 2.0 * kPi * second_hz;
  Eigen::Matrix2d dynamics;
  dynamics << -second, second, 0.0, -first;
  return ShapedNoise(dynamics, Eigen::Vector2d(0.0, first), rms, dt_s, stream);
}

ShapedNoise ShapedNoise::resonance(double frequency_hz, double damping, double rms, double dt_s, RandomStream stream) {
  const double natural = 2.0 * kPi * frequency_hz;
  Eigen::Matrix2d dynamics;
  dynamics << 0.0, 1.0, -natural * natural, -2.0 * damping * natural;
  return ShapedNoise(dynamics, Eigen::Vector2d(0.0, natural * natural), rms, dt_s, stream);
}

const Eigen::Vector2d& ShapedNoise::next() {
  const double first = stream_.normal();
  const double second = stream_.normal();
  state_ = transition_ * state_ + spread_ * Eigen::Vector2d(first, second);
  return state_;
}

}  // namespace trackservo::sim
