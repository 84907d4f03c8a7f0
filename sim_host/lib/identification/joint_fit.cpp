// SPDX-License-Identifier: Apache-2.0
#include "identification/joint_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "identification/least_squares.hpp"

namespace trackservo::identification {

namespace {

constexpr double kTrial_s = 80;  // of the recording, for each start
constexpr int kTrialRounds = 2;
constexpr int kTrialEvaluations = 12;
constexpr int kMaxRounds = 10;
constexpr int kMaxHarmonics = 6;
constexpr double kTypicalBreakaway = 1.4;     // Ts/Tc
constexpr int kMaxEvaluations = 25;           // of Levenberg-Marquardt in one round
constexpr double kSettled_deviations = 0.05;  // between two rounds, in standard deviations
constexpr double kHuber_deviations = 2.0;
constexpr int kFirstOrder = 4;  // of the noise, while the model still causes the residuals
constexpr int kLargestOrder = 24;
constexpr Eigen::Index kCluster_nodes = 400;  // 2 s
// Priors only keep the equations solvable where the data give no information: a factor of e^3 = 20 in a logarithm, half
// of the friction level in the map, a few ticks of delay, 3 % of ripple. A value that depends on a prior is refused
// later.
constexpr double kLogarithmPrior = 3.0;
constexpr double kMapPrior = 0.5;
constexpr double kDelayPrior_s = 2e-3;
constexpr double kSpreadPrior_s2 = 3e-8;
constexpr double kRipplePrior = 0.03;

double prior_deviation(const TorqueBalance& balance, Eigen::Index parameter) {
  if (parameter < kLogarithms) {
    return kLogarithmPrior;
  }
  if (parameter == kDelay) {
    return kDelayPrior_s;
  }
  if (parameter == kSpread) {
    return kSpreadPrior_s2;
  }
  if (parameter < balance.first_load()) {
    return kMapPrior;
  }
  const Eigen::Index harmonic = parameter - balance.first_harmonic();
  const bool ripple = harmonic >= 0 && balance.harmonics()[static_cast<std::size_t>(harmonic / 2)].ripple;
  return ripple ? kRipplePrior : std::numeric_limits<double>::infinity();
}

// The weighted, whitened problem of one round: the nodes, then the priors.
class RoundProblem {
 public:
  RoundProblem(const TorqueBalance& balance, const JointFit& fit)
      : balance_(balance),
        fit_(fit),
        root_weights_(fit.weights.cwiseSqrt()),
        first_inertia_(fit.parameters[kInertia]) {}

  Eigen::Index residuals() const { return balance_.nodes() + balance_.parameters(); }

  bool evaluate(const Eigen::VectorXd& parameters, Eigen::VectorXd& values) const {
    Eigen::VectorXd residual;
    balance_.evaluate(parameters, residual, nullptr);
    fit_.noise.whiten(fit_.spans, residual);
    values.head(balance_.nodes()) = residual.cwiseProduct(root_weights_) * relative(parameters);
    for (Eigen::Index i = 0; i < balance_.parameters(); ++i) {
      values[balance_.nodes() + i] = (parameters[i] - fit_.start[i]) / prior_deviation(balance_, i);
    }
    return values.allFinite();
  }

  void differentiate(const Eigen::VectorXd& parameters, Eigen::MatrixXd& jacobian) const {
    Eigen::VectorXd residual;
    TorqueBalance::Jacobian rows;
    balance_.evaluate(parameters, residual, &rows);
    fit_.noise.whiten(fit_.spans, rows);
    jacobian.setZero(residuals(), balance_.parameters());
    fit_.noise.whiten(fit_.spans, residual);
    rows.col(kInertia) -= residual;
    jacobian.topRows(balance_.nodes()) = (relative(parameters) * root_weights_).asDiagonal() * rows;
    for (Eigen::Index i = 0; i < balance_.parameters(); ++i) {
      jacobian(balance_.nodes() + i, i) = 1.0 / prior_deviation(balance_, i);
    }
  }

 private:
  // Noise of the encoder is in the acceleration, and wind moves the axis within the window: the error is in the motion,
  // by residual / J. Least squares of torques would favour a light machine, the more the coarser the encoder.
  double relative(const Eigen::VectorXd& parameters) const { return std::exp(first_inertia_ - parameters[kInertia]); }

  const TorqueBalance& balance_;
  const JointFit& fit_;
  Eigen::VectorXd root_weights_;
  double first_inertia_;  // its logarithm
};

void update_noise(const TorqueBalance& balance, int order, JointFit& fit) {
  fit.spans = balance.known(fit.parameters);
  balance.evaluate(fit.parameters, fit.residual_nm, nullptr);
  fit.noise = NoiseModel::fit(fit.residual_nm, fit.weights, fit.spans, order);
  fit.whitened = fit.residual_nm;
  fit.noise.whiten(fit.spans, fit.whitened);
}

// Huber's weights relative to the median, which outliers do not move.
void update_weights(JointFit& fit) {
  std::vector<double> sizes;
  for (const double value : fit.whitened) {
    if (value != 0.0) {
      sizes.push_back(std::abs(value));
    }
  }
  if (sizes.empty()) {
    return;
  }
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  const double limit = kHuber_deviations * std::max(*middle / 0.6745, 1e-12);
  for (Eigen::Index i = 0; i < fit.whitened.size(); ++i) {
    fit.weights[i] = std::min(1.0, limit / std::max(std::abs(fit.whitened[i]), 1e-300));
  }
}

void update_covariance(const TorqueBalance& balance, JointFit& fit) {
  Eigen::VectorXd residual;
  TorqueBalance::Jacobian jacobian;
  balance.evaluate(fit.parameters, residual, &jacobian);
  fit.noise.whiten(fit.spans, jacobian);
  const Eigen::Index p = balance.parameters();
  const TorqueBalance::Jacobian weighted = fit.weights.asDiagonal() * jacobian;
  Eigen::MatrixXd information = weighted.transpose() * jacobian;
  Eigen::MatrixXd prior = Eigen::MatrixXd::Zero(p, p);
  for (Eigen::Index i = 0; i < p; ++i) {
    prior(i, i) = std::pow(prior_deviation(balance, i), -2.0);
  }
  information += prior;
  Eigen::MatrixXd scatter = prior;  // of the clusters' gradients
  double clusters = 0;
  for (Eigen::Index first = 0; first < balance.nodes(); first += kCluster_nodes) {
    const Eigen::Index count = std::min(kCluster_nodes, balance.nodes() - first);
    const Eigen::VectorXd gradient = weighted.middleRows(first, count).transpose() * fit.whitened.segment(first, count);
    scatter += gradient * gradient.transpose();
    clusters += 1;
  }
  // Scaled to a unit diagonal: load and logarithms differ by orders of magnitude.
  const Eigen::VectorXd scale = information.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information * scale.asDiagonal();
  const Eigen::MatrixXd inverse =
      scale.asDiagonal() * scaled.ldlt().solve(Eigen::MatrixXd::Identity(p, p)) * scale.asDiagonal();
  const double few = clusters > static_cast<double>(p) + 1 ? clusters / (clusters - static_cast<double>(p)) : 2.0;
  const double white = fit.weights.dot(fit.whitened.cwiseAbs2()) / std::max(fit.weights.sum(), 1.0);
  const Eigen::MatrixXd ordinary = white * inverse;
  const Eigen::MatrixXd sandwich = few * inverse * scatter * inverse;
  // Neither may be too small: each parameter keeps the larger of its two deviations.
  Eigen::VectorXd stretch(p);
  for (Eigen::Index i = 0; i < p; ++i) {
    stretch[i] = std::sqrt(std::max(1.0, ordinary(i, i) / sandwich(i, i)));
  }
  fit.covariance = stretch.asDiagonal() * sandwich * stretch.asDiagonal();
  fit.widening = (fit.covariance.diagonal().cwiseQuotient(ordinary.diagonal())).cwiseSqrt().maxCoeff();
}

// One round: minimise with noise and weights held, then update these.
void run_round(const TorqueBalance& balance, int evaluations, int noise_order, JointFit& fit) {
  const RoundProblem round(balance, fit);
  const LeastSquares problem = {round.residuals(), balance.parameters(),
                                [&round](const Eigen::VectorXd& parameters, Eigen::VectorXd& values) {
                                  return round.evaluate(parameters, values);
                                },
                                [&round](const Eigen::VectorXd& parameters, Eigen::MatrixXd& jacobian) {
                                  round.differentiate(parameters, jacobian);
                                }};
  LeastSquaresEnd end;
  end.max_evaluations = evaluations;
  end.residual_tolerance = 1e-10;
  end.parameter_tolerance = 1e-8;
  minimize(problem, end, fit.parameters);
  update_noise(balance, noise_order, fit);
  update_weights(fit);
}

JointFit begin(const TorqueBalance& balance, const Eigen::VectorXd& start) {
  JointFit fit;
  fit.start = start;
  fit.parameters = start;
  fit.weights = Eigen::VectorXd::Ones(balance.nodes());
  update_noise(balance, kFirstOrder, fit);
  return fit;
}

// Decrease of the squares of the whitened residuals when a harmonic is added and everything else is fitted again.
class HarmonicSearch {
 public:
  HarmonicSearch(const TorqueBalance& balance, const JointFit& fit) : balance_(balance), fit_(fit) {
    Eigen::VectorXd residual;
    balance.evaluate(fit.parameters, residual, &jacobian_);
    fit.noise.whiten(fit.spans, jacobian_);
    jacobian_ = fit.weights.cwiseSqrt().asDiagonal() * jacobian_;
    residual_ = fit.weights.cwiseSqrt().cwiseProduct(fit.whitened);
    Eigen::MatrixXd normal = jacobian_.transpose() * jacobian_;
    normal.diagonal() *= 1.0 + 1e-9;
    normal.diagonal().array() += 1e-12;
    normal_.compute(normal);
  }

  double gain(const MotorHarmonic& harmonic) const {
    Eigen::MatrixX2d columns = harmonic_columns(balance_.recording(), balance_.ticks(), harmonic);
    fit_.noise.whiten(fit_.spans, columns);
    columns = (fit_.weights.cwiseSqrt().asDiagonal() * columns).eval();
    const Eigen::MatrixX2d cross = jacobian_.transpose() * columns;
    const Eigen::Matrix2d own = columns.transpose() * columns - cross.transpose() * normal_.solve(cross);
    const Eigen::Vector2d right =
        columns.transpose() * residual_ - cross.transpose() * normal_.solve(jacobian_.transpose() * residual_);
    return own.determinant() > 0 ? right.dot(own.inverse() * right) : 0.0;
  }

  // Two periods must fit into the travel: fewer look like a factor on all torques.
  int lowest_harmonic() const {
    const PositionTerms& travel = balance_.position_terms();
    const double turns = (travel.highest_rad() - travel.lowest_rad()) / 6.283185307179586;
    return std::max(kLowestHarmonic, static_cast<int>(std::ceil(2.0 / std::max(turns, 1e-3))));
  }

  // The one with the largest gain, if that is beyond doubt.
  std::optional<MotorHarmonic> best() const {
    double most = kCertainGain;
    std::optional<MotorHarmonic> found;
    for (const bool ripple : {true, false}) {
      for (int per_turn = lowest_harmonic(); per_turn <= kHighestHarmonic; ++per_turn) {
        const double gained = gain({per_turn, ripple});
        if (gained > most) {
          most = gained;
          found = {per_turn, ripple};
        }
      }
    }
    return found;
  }

 private:
  // By chance two columns gain 2 and the largest of all candidates about 14. Wind that is correlated beyond the noise
  // model and few places of the travel make it many times more.
  static constexpr double kCertainGain = 300.0;

  const TorqueBalance& balance_;
  const JointFit& fit_;
  TorqueBalance::Jacobian jacobian_;
  Eigen::VectorXd residual_;
  Eigen::LDLT<Eigen::MatrixXd> normal_;
};

void add_harmonics(TorqueBalance& balance, JointFit& fit) {
  for (int count = 0; count < kMaxHarmonics; ++count) {
    const std::optional<MotorHarmonic> harmonic = HarmonicSearch(balance, fit).best();
    if (!harmonic) {
      return;
    }
    balance.add_harmonic(*harmonic);
    fit.parameters.conservativeResizeLike(Eigen::VectorXd::Zero(balance.parameters()));
    fit.start.conservativeResizeLike(Eigen::VectorXd::Zero(balance.parameters()));
    run_round(balance, kMaxEvaluations, kLargestOrder, fit);
  }
}

}  // namespace

double JointFit::deviation(Eigen::Index parameter) const { return std::sqrt(covariance(parameter, parameter)); }

Eigen::VectorXd start_parameters(const TorqueBalance& balance, const PaperEstimate& estimate) {
  const auto logarithm = [](double value) { return std::log(std::max(value, 1e-9)); };
  Eigen::VectorXd start = Eigen::VectorXd::Zero(balance.parameters());
  const Friction& friction = estimate.friction;
  for (const auto& [direction, first, viscous] :
       {std::tuple(&friction.positive, +kCoulombPositive, +kViscousPositive),
        std::tuple(&friction.negative, +kCoulombNegative, +kViscousNegative)}) {
    start[first] = logarithm(direction->coulomb_nm);
    start[first + 1] = logarithm(direction->breakaway_nm);
    start[first + 2] = logarithm(direction->stribeck_speed_rad_s);
    // None was detected: a tenth of the Coulomb friction at ten times the Stribeck speed, so that it can still be
    // found.
    start[viscous] = logarithm(
        std::max(direction->viscous_nm_s_rad, 0.01 * direction->coulomb_nm / direction->stribeck_speed_rad_s));
  }
  start[kStiffness] = logarithm(friction.stiffness_nm_rad);
  start[kDamping] = logarithm(friction.damping_nm_s_rad);
  start[kInertia] = logarithm(estimate.inertia_kg_m2);
  start[balance.first_load()] = estimate.load_nm;
  return start;
}

std::vector<Eigen::VectorXd> starts_around(const Motion& motion, const Eigen::VectorXd& start) {
  std::vector<double> speeds;
  for (const double rate : motion.joint_rate_rad_s) {
    speeds.push_back(std::abs(rate));
  }
  std::sort(speeds.begin(), speeds.end());
  const auto quantile = [&](double share) {
    return std::max(speeds[static_cast<std::size_t>(share * static_cast<double>(speeds.size() - 1))], 1e-9);
  };
  std::vector<Eigen::VectorXd> starts{start};
  for (const double share : {0.2, 0.45, 0.7}) {
    Eigen::VectorXd other = start;
    for (const int first : {+kCoulombPositive, +kCoulombNegative}) {
      other[first + 1] = start[first] + std::log(kTypicalBreakaway);
      other[first + 2] = std::log(quantile(share));
    }
    starts.push_back(other);
  }
  return starts;
}

JointFit fit_jointly(TorqueBalance& balance, const std::vector<Eigen::VectorXd>& starts) {
  const TorqueBalance trial_balance = balance.excerpt(kTrial_s);
  JointFit best;
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::VectorXd& start : starts) {
    JointFit trial = begin(trial_balance, start);
    for (int round = 0; round < kTrialRounds; ++round) {
      run_round(trial_balance, kTrialEvaluations, kFirstOrder, trial);
    }
    const double surprise_rad_s2 = trial.noise.innovation_nm() / std::exp(trial.parameters[kInertia]);
    if (surprise_rad_s2 < least) {
      least = surprise_rad_s2;
      best = std::move(trial);
    }
  }
  JointFit fit = begin(balance, best.parameters);
  fit.start = best.start;
  run_round(balance, kMaxEvaluations, kFirstOrder, fit);
  run_round(balance, kMaxEvaluations, kLargestOrder, fit);
  add_harmonics(balance, fit);
  for (fit.rounds = 1; fit.rounds <= kMaxRounds && !fit.converged; ++fit.rounds) {
    const Eigen::VectorXd before = fit.parameters;
    run_round(balance, kMaxEvaluations, kLargestOrder, fit);
    update_covariance(balance, fit);
    const Eigen::VectorXd moved =
        (fit.parameters - before).cwiseQuotient(fit.covariance.diagonal().cwiseSqrt()).cwiseAbs();
    fit.converged = moved.maxCoeff() < kSettled_deviations;
  }
  --fit.rounds;
  return fit;
}

}  // namespace trackservo::identification
