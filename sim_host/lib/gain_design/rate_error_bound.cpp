// SPDX-License-Identifier: Apache-2.0
#include "gain_design/rate_error_bound.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "units.hpp"

namespace trackservo::gain_design {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kFunctions = 24;

// Laguerre functions with the pole exp(-w T), at one frequency: an orthonormal base of what a stable filter can be.
std::vector<Complex> laguerre_functions(double pole_rad_s, double frequency_hz) {
  const double pole = std::exp(-pole_rad_s * kTick_s);
  const Complex z_inverse = std::polar(1.0, -2.0 * kPi * frequency_hz * kTick_s);
  const Complex all_pass = (z_inverse - pole) / (1.0 - pole * z_inverse);
  std::vector<Complex> functions{std::sqrt(1.0 - pole * pole) / (1.0 - pole * z_inverse)};
  while (functions.size() < kFunctions) {
    functions.push_back(functions.back() * all_pass);
  }
  return functions;
}

// Least |error + error_by x|^2 where no pair (real and imaginary part) of sensitivity + sensitivity_by x is longer than
// `longest`.
struct Problem {
  MatrixXd error_by;
  VectorXd error;
  MatrixXd sensitivity_by;
  VectorXd sensitivity;
  double longest = 0.0;

  VectorXd sensitivity_at(const VectorXd& x) const { return sensitivity + sensitivity_by * x; }
};

void set_row_pair(MatrixXd& matrix, VectorXd& vector, Index row, Complex constant, const std::vector<Complex>& by) {
  vector(row) = constant.real();
  vector(row + 1) = constant.imag();
  for (Index i = 0; i < kFunctions; ++i) {
    matrix(row, i) = by[static_cast<std::size_t>(i)].real();
    matrix(row + 1, i) = by[static_cast<std::size_t>(i)].imag();
  }
}

std::vector<Complex> scaled(std::vector<Complex> functions, Complex factor) {
  for (Complex& function : functions) {
    function *= factor;
  }
  return functions;
}

// The same with coordinates for which the columns of error_by are orthonormal.
Problem conditioned(Problem problem) {
  const Eigen::HouseholderQR<MatrixXd> factors(problem.error_by);
  const MatrixXd triangle = factors.matrixQR().topRows(kFunctions);
  problem.error_by = factors.householderQ() * MatrixXd::Identity(problem.error.size(), kFunctions);
  problem.sensitivity_by =
      triangle.triangularView<Eigen::Upper>().transpose().solve(problem.sensitivity_by.transpose()).transpose();
  return problem;
}

Problem problem_of(const std::vector<RateErrorLine>& spectrum, double pole_rad_s, double most_sensitivity) {
  const auto lines = static_cast<Index>(spectrum.size());
  Problem problem{MatrixXd(4 * lines, kFunctions), VectorXd(4 * lines), MatrixXd(2 * lines, kFunctions),
                  VectorXd(2 * lines), most_sensitivity};
  for (Index i = 0; i < lines; ++i) {
    const RateErrorLine& line = spectrum[static_cast<std::size_t>(i)];
    const std::vector<Complex> functions = laguerre_functions(pole_rad_s, line.frequency_hz);
    const Complex sensitivity = 1.0 / (1.0 + line.loop_gain);
    const std::vector<Complex> sensitivity_by = scaled(functions, sensitivity - 1.0);
    const double by_sensitivity = line.error.disturbance_rad_s / std::abs(sensitivity);
    const double by_noise = std::hypot(line.error.encoder_rad_s, line.error.gyro_rad_s);
    set_row_pair(problem.sensitivity_by, problem.sensitivity, 2 * i, sensitivity, sensitivity_by);
    set_row_pair(problem.error_by, problem.error, 4 * i, by_sensitivity * sensitivity,
                 scaled(sensitivity_by, by_sensitivity));
    set_row_pair(problem.error_by, problem.error, 4 * i + 2, by_noise, scaled(functions, by_noise));
  }
  return conditioned(std::move(problem));
}

// Shortens the pairs that are too long.
VectorXd within(VectorXd pairs, double longest) {
  for (Index i = 0; i < pairs.size(); i += 2) {
    const double length = std::hypot(pairs(i), pairs(i + 1));
    pairs.segment<2>(i) *= std::min(1.0, longest / length);
  }
  return pairs;
}

double longest_pair(const VectorXd& pairs) {
  double longest = 0.0;
  for (Index i = 0; i < pairs.size(); i += 2) {
    longest = std::max(longest, std::hypot(pairs(i), pairs(i + 1)));
  }
  return longest;
}

// The alternating direction method of multipliers: x for given sensitivities, sensitivities within the limit for given
// x, and the multipliers that bring the two together.
VectorXd solved(const Problem& problem) {
  constexpr int kMost = 4000;
  constexpr int kBetweenWeights = 50;
  constexpr double kGood = 1e-5;
  const MatrixXd error_squares = MatrixXd::Identity(kFunctions, kFunctions);
  const MatrixXd sensitivity_squares = problem.sensitivity_by.transpose() * problem.sensitivity_by;
  const VectorXd pull = problem.error_by.transpose() * problem.error;
  double weight = error_squares.trace() / sensitivity_squares.trace();
  Eigen::LDLT<MatrixXd> inverse(error_squares + weight * sensitivity_squares);
  VectorXd sensitivity = problem.sensitivity;
  VectorXd multiplier = VectorXd::Zero(sensitivity.size());
  VectorXd x = VectorXd::Zero(kFunctions);
  for (int step = 1; step <= kMost; ++step) {
    x = inverse.solve(weight * (problem.sensitivity_by.transpose() * (sensitivity - multiplier - problem.sensitivity)) -
                      pull);
    const VectorXd reached = problem.sensitivity_at(x);
    const VectorXd before = sensitivity;
    sensitivity = within(reached + multiplier, problem.longest);
    multiplier += reached - sensitivity;
    const double apart = (reached - sensitivity).norm();
    const double moved = (sensitivity - before).norm();
    if (std::max(apart, moved) < kGood) {
      break;
    }
    if (step % kBetweenWeights == 0 && (apart > 5.0 * moved || moved > 5.0 * apart)) {
      const double factor = apart > moved ? 2.0 : 0.5;
      weight *= factor;
      multiplier /= factor;
      inverse.compute(error_squares + weight * sensitivity_squares);
    }
  }
  return x;
}

RateError error_at(const std::vector<RateErrorLine>& spectrum, const Problem& problem, const VectorXd& x) {
  const VectorXd error = problem.error + problem.error_by * x;
  RateError sum;
  for (Index i = 0; i < static_cast<Index>(spectrum.size()); ++i) {
    const RateErrorLine& line = spectrum[static_cast<std::size_t>(i)];
    const double noise = std::hypot(problem.error(4 * i + 2), problem.error(4 * i + 3));
    const double factor = noise > 0.0 ? std::hypot(error(4 * i + 2), error(4 * i + 3)) / noise : 0.0;
    sum.disturbance_rad_s = std::hypot(sum.disturbance_rad_s, error.segment<2>(4 * i).norm());
    sum.encoder_rad_s = std::hypot(sum.encoder_rad_s, factor * line.error.encoder_rad_s);
    sum.gyro_rad_s = std::hypot(sum.gyro_rad_s, factor * line.error.gyro_rad_s);
  }
  return sum;
}

}  // namespace

RateErrorBound rate_error_bound(const LinearMachine& machine, const speed_loop_params& loop,
                                const Disturbance& disturbance, const SensorNoise& noise,
                                std::optional<double> most_sensitivity) {
  const std::vector<RateErrorLine> spectrum = rate_error_spectrum(machine, loop, disturbance, noise);
  RateErrorBound best{rate_error(machine, loop, disturbance, noise), 0.0};
  for (const RateErrorLine& line : spectrum) {
    best.sensitivity = std::max(best.sensitivity, 1.0 / std::abs(1.0 + line.loop_gain));
  }
  const double limit = most_sensitivity.value_or(best.sensitivity);
  bool found = best.sensitivity <= limit;
  for (const double pole_rad_s : {50.0, 150.0, 450.0, 1350.0}) {
    const Problem problem = problem_of(spectrum, pole_rad_s, limit);
    const VectorXd x = solved(problem);
    const RateErrorBound reached{error_at(spectrum, problem, x), longest_pair(problem.sensitivity_at(x))};
    constexpr double kRounding = 1e-3;
    if (std::isfinite(reached.error.rad_s()) && reached.sensitivity < limit + kRounding &&
        (!found || reached.error.rad_s() < best.error.rad_s())) {
      best = reached;
      found = true;
    }
  }
  return best;
}

}  // namespace trackservo::gain_design
