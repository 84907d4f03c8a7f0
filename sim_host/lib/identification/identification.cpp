// SPDX-License-Identifier: Apache-2.0
#include "identification/identification.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>

#include "identification/start_search.hpp"
#include "identification/window.hpp"

namespace trackservo::identification {

namespace {

constexpr double kWidestFactor = 2.0;  // ratio of the ends of an interval that is still useful
constexpr Eigen::Index kFewestNodes = 400;
constexpr int kLags = 40;

// An encoder this noisy (22 bits and less) is worse than a gyro in fast motion: 0.02 rad/s^2 under the window.
constexpr double kCoarse_rad = 2e-7;

constexpr double kHighestCutoff_hz = 250;
constexpr double kLowestTrusted_hz =
    150;  // below it slip after a stick is blurred, and sigma2 absorbs the missing part
constexpr double kLowestCutoff_hz = 20;
constexpr double kRelaxation_1_s = 0.2;  // of the bristles at rest, by the encoder's noise: at most this

// White noise of the angle through a low-pass gives a rate of rms noise * sqrt(2 dt (2 pi)^2 fc^3 / 3).
double motion_cutoff_hz(double angle_noise_rad, double bristle_rad) {
  const double allowed_rad_s = kRelaxation_1_s * bristle_rad;
  const double ratio = allowed_rad_s / std::max(angle_noise_rad, 1e-12);
  constexpr double kPerCube = 2.0 * kTick_s * 39.478 / 3.0;
  return std::clamp(std::cbrt(ratio * ratio / kPerCube), kLowestCutoff_hz, kHighestCutoff_hz);
}

struct ParameterText {
  int index;
  const char *name;
  const char *unit;
};

constexpr ParameterText kTexts[] = {
    {kCoulombPositive, "coulomb_positive", "Nm"},
    {kBreakawayPositive, "breakaway_positive", "Nm"},
    {kStribeckSpeedPositive, "stribeck_speed_positive", "rad/s"},
    {kViscousPositive, "viscous_positive", "Nm s/rad"},
    {kCoulombNegative, "coulomb_negative", "Nm"},
    {kBreakawayNegative, "breakaway_negative", "Nm"},
    {kStribeckSpeedNegative, "stribeck_speed_negative", "rad/s"},
    {kViscousNegative, "viscous_negative", "Nm s/rad"},
    {kStiffness, "stiffness", "Nm/rad"},
    {kDamping, "damping", "Nm s/rad"},
    {kInertia, "inertia", "kg m2"},
};

// --- evidence ---

// Steady sliding: duration per octave of speed, and the reversals.
class EvidenceFinder {
 public:
  EvidenceFinder(const Friction& friction, const Motion& motion) : friction_(friction), motion_(motion) {}

  Evidence find() {
    for (const Stretch& stretch : motion_.stretches) {
      slid_rad_ = 0;
      before_rad_ = 0;
      for (std::size_t i = stretch.first; i < stretch.last; ++i) {
        look(motion_.joint_rate_rad_s[i]);
      }
    }
    for (const auto& [key, ticks] : ticks_) {
      const auto& [side, octave] = key;
      if (static_cast<double>(ticks) * kTick_s >= kShortest_s) {
        evidence_.speeds[side] += 1;
        const DirectionFriction& direction = side == 1 ? friction_.positive : friction_.negative;
        evidence_.slow[side] |= std::exp2(octave) < direction.stribeck_speed_rad_s;
      }
    }
    return evidence_;
  }

 private:
  static constexpr double kShortest_s = 0.2;
  static constexpr double kSteady = 2.0;  // bristle lengths in one direction

  void look(double rate_rad_s) {
    const int side = rate_rad_s >= 0 ? 1 : 0;
    if (side != side_) {
      before_rad_ = slid_rad_;
      slid_rad_ = 0;
      side_ = side;
      counted_ = false;
    }
    slid_rad_ += std::abs(rate_rad_s) * kTick_s;
    const DirectionFriction& direction = side == 1 ? friction_.positive : friction_.negative;
    const double steady_rad = kSteady * direction.coulomb_nm / friction_.stiffness_nm_rad;
    if (slid_rad_ < steady_rad) {
      return;
    }
    ++ticks_[{side, static_cast<int>(std::floor(std::log2(std::abs(rate_rad_s) + 1e-12)))}];
    if (!counted_ && before_rad_ >= steady_rad) {
      ++evidence_.turns;
    }
    counted_ = true;
  }

  const Friction& friction_;
  const Motion& motion_;
  Evidence evidence_;
  std::map<std::pair<int, int>, int> ticks_;
  double slid_rad_ = 0;    // since the last reversal
  double before_rad_ = 0;  // in the other direction, before it
  int side_ = 1;
  bool counted_ = false;
};

double inertial_share(const Motion& motion, const std::vector<std::size_t>& ticks, double inertia_kg_m2,
                      double coulomb_nm) {
  double squares = 0;
  for (const std::size_t i : ticks) {
    squares += std::pow(inertia_kg_m2 * triangle_second_derivative(motion.joint_angle_rad, i), 2.0);
  }
  return std::sqrt(squares / static_cast<double>(std::max<std::size_t>(ticks.size(), 1))) / coulomb_nm;
}

// --- verdict ---

constexpr int kFewestSpeeds = 4;
constexpr int kFewestTurns = 10;
constexpr double kMinInertialShare = 0.05;

std::string sweep_wanted(const Evidence& evidence, int side) {
  if (evidence.speeds[side] >= kFewestSpeeds) {
    return "";
  }
  return fmt::format(
      "the axis slides steadily in only {} octaves of speed {}; add a {} with more speeds in both "
      "directions",
      evidence.speeds[side], side == 1 ? "forward" : "backward", run_kind_name(RunKind::kSpeedSweep));
}

// The missing motion for a parameter; empty if none.
std::string missing_run(int parameter, const Evidence& evidence) {
  const int side = parameter == kCoulombPositive || parameter == kBreakawayPositive ||
                           parameter == kStribeckSpeedPositive || parameter == kViscousPositive
                       ? 1
                       : 0;
  switch (parameter) {
    case kStiffness:
    case kDamping:
      return evidence.turns >= kFewestTurns
                 ? ""
                 : fmt::format("the axis reverses {} times with sliding before and after; add {}", evidence.turns,
                               run_kind_name(RunKind::kHysteresis));
    case kInertia:
      return evidence.inertial_share >= kMinInertialShare
                 ? ""
                 : fmt::format("no run accelerates the axis; add a {}", run_kind_name(RunKind::kTorqueExcitation));
    case kBreakawayPositive:
    case kBreakawayNegative:
    case kStribeckSpeedPositive:
    case kStribeckSpeedNegative:
      if (evidence.speeds[side] >= kFewestSpeeds && !evidence.slow[side]) {
        return fmt::format("no run slides below the Stribeck speed; add a {} with slower speeds",
                           run_kind_name(RunKind::kSpeedSweep));
      }
      return sweep_wanted(evidence, side);
    default:
      return sweep_wanted(evidence, side);
  }
}

// The run that makes an interval narrower.
const char *helpful_run(int parameter) {
  switch (parameter) {
    case kStiffness:
    case kDamping:
      return "more hysteresis loops (kind 3) and torque chirps (kind 4) that reverse the axis";
    case kInertia:
      return "a torque multisine or chirp (kind 4)";
    case kViscousPositive:
    case kViscousNegative:
      return "a speed sweep (kind 1) with quick reversals at higher speeds";
    case kCoulombPositive:
    case kCoulombNegative:
      return "hysteresis loops (kind 3), which separate a load from a difference of the directions, and quick "
             "reversals";
    default:
      return "a speed sweep (kind 1) with more and slower speeds around the Stribeck speed";
  }
}

Parameter logarithmic(const std::string& name, const std::string& unit, double logarithm, double deviation,
                      double allowance = kModelAllowance) {
  const double reach = kInterval_deviations * std::hypot(deviation, allowance);
  Parameter parameter;
  parameter.name = name;
  parameter.unit = unit;
  parameter.value = std::exp(logarithm);
  parameter.interval = {std::exp(logarithm - reach), std::exp(logarithm + reach)};
  return parameter;
}

// No Stribeck effect within the uncertainty: its speed is meaningless.
bool stribeck_effect_is_seen(const JointFit& fit, int coulomb) {
  const double difference = fit.parameters[coulomb + 1] - fit.parameters[coulomb];
  const double variance = fit.covariance(coulomb, coulomb) + fit.covariance(coulomb + 1, coulomb + 1) -
                          2.0 * fit.covariance(coulomb, coulomb + 1);
  return std::abs(difference) > kInterval_deviations * std::sqrt(std::max(variance, 0.0));
}

std::string reason_to_refuse(const ParameterText& text, const Parameter& parameter, const Identification& result) {
  std::string missing = missing_run(text.index, result.evidence);
  if (!missing.empty()) {
    return missing;
  }
  const bool viscous = text.index == kViscousPositive || text.index == kViscousNegative;
  if (viscous && result.motion.fused && result.motion_cutoff_hz < kLowestTrusted_hz) {
    return fmt::format("encoder and gyro resolve motion only below {:.0f} Hz, which blurs it; use a finer encoder",
                       result.motion_cutoff_hz);
  }
  const bool stribeck_speed = text.index == kStribeckSpeedPositive || text.index == kStribeckSpeedNegative;
  const bool breakaway = text.index == kBreakawayPositive || text.index == kBreakawayNegative;
  if ((stribeck_speed || breakaway) && !stribeck_effect_is_seen(result.fit, text.index - (breakaway ? 1 : 2))) {
    return "break-away and Coulomb torque do not differ by more than wind and noise: no Stribeck effect can be "
           "identified";
  }
  const double factor = parameter.interval.high / parameter.interval.low;
  if (!(factor <= kWidestFactor)) {
    return fmt::format("its 95 % interval spans a factor of {:.3g}; add {}", factor, helpful_run(text.index));
  }
  return "";
}

// The mean of both directions, by the law of error propagation in logarithms.
Parameter coulomb_mean(const JointFit& fit) {
  const double positive = std::exp(fit.parameters[kCoulombPositive]);
  const double negative = std::exp(fit.parameters[kCoulombNegative]);
  const double share = positive / (positive + negative);
  const double variance = share * share * fit.covariance(kCoulombPositive, kCoulombPositive) +
                          (1 - share) * (1 - share) * fit.covariance(kCoulombNegative, kCoulombNegative) +
                          2 * share * (1 - share) * fit.covariance(kCoulombPositive, kCoulombNegative);
  return logarithmic("coulomb_mean", "Nm", std::log(0.5 * (positive + negative)), std::sqrt(std::max(variance, 0.0)));
}

double allowance_for(int parameter, const Identification& result) {
  switch (parameter) {
    case kBreakawayPositive:
    case kStribeckSpeedPositive:
    case kBreakawayNegative:
    case kStribeckSpeedNegative:
      return kModelAllowance +
             kWindAllowance * result.residual_rms_nm / std::exp(result.fit.parameters[kCoulombPositive]);
    case kViscousPositive:
    case kViscousNegative:
      return kViscousAllowance;
    default:
      return kModelAllowance;
  }
}

double residual_rms_nm(const JointFit& fit) {
  double squares = 0;
  Eigen::Index nodes = 0;
  for (const Span& span : fit.spans) {
    squares += fit.residual_nm.segment(span.first, span.last - span.first).squaredNorm();
    nodes += span.last - span.first;
  }
  return std::sqrt(squares / static_cast<double>(std::max<Eigen::Index>(nodes, 1)));
}

void judge(const Eigen::VectorXd& paper, Identification& result) {
  for (const ParameterText& text : kTexts) {
    Parameter parameter = logarithmic(text.name, text.unit, result.fit.parameters[text.index],
                                      result.fit.deviation(text.index), allowance_for(text.index, result));
    parameter.paper = std::exp(paper[text.index]);
    parameter.start = std::exp(result.fit.start[text.index]);
    const std::string reason = reason_to_refuse(text, parameter, result);
    parameter.refused = reason.empty() ? "" : fmt::format("{}: {}.", text.name, reason);
    result.parameters.push_back(parameter);
  }
  result.coulomb_mean = coulomb_mean(result.fit);
  result.coulomb_mean.paper = 0.5 * (std::exp(paper[kCoulombPositive]) + std::exp(paper[kCoulombNegative]));
}

void check_damping_ratio(Identification& result) {
  const Friction friction = friction_of(result.fit.parameters);
  const double inertia = std::exp(result.fit.parameters[kInertia]);
  const double viscous = 0.5 * (friction.positive.viscous_nm_s_rad + friction.negative.viscous_nm_s_rad);
  result.damping_ratio =
      presliding_damping_ratio(inertia, friction.stiffness_nm_rad, friction.damping_nm_s_rad, viscous);
  result.eq15_damping_nm_s_rad =
      paper_damping_nm_s_rad(inertia, friction.stiffness_nm_rad, viscous, kPaperDampingRatio);
}

// --- sizes of the next test plan ---

constexpr double kRough_deviations = 1.0;  // of a logarithm; the search alone is no more precise than that

RoughMachine rough_machine(const Friction& friction, double inertia_kg_m2) {
  RoughMachine machine;
  machine.coulomb_nm = 0.5 * (friction.positive.coulomb_nm + friction.negative.coulomb_nm);
  machine.bristle_rad = machine.coulomb_nm / friction.stiffness_nm_rad;
  machine.stribeck_rad_s = std::sqrt(friction.positive.stribeck_speed_rad_s * friction.negative.stribeck_speed_rad_s);
  machine.inertia_kg_m2 = inertia_kg_m2;
  return machine;
}

// The joint fit's values. Where one is not determined at all, the start search's, which tried all possible values and
// cannot diverge.
RoughMachine rough_machine(const JointFit& fit, const PaperEstimate& start) {
  RoughMachine machine = rough_machine(friction_of(fit.parameters), std::exp(fit.parameters[kInertia]));
  const RoughMachine begun = rough_machine(start.friction, start.inertia_kg_m2);
  const auto keep_if_certain = [&fit](double& value, double otherwise, std::initializer_list<Eigen::Index> parameters) {
    const bool certain = std::all_of(parameters.begin(), parameters.end(), [&fit](Eigen::Index parameter) {
      return fit.deviation(parameter) <= kRough_deviations;
    });
    value = certain && std::isfinite(value) ? value : otherwise;
  };
  keep_if_certain(machine.coulomb_nm, begun.coulomb_nm, {kCoulombPositive, kCoulombNegative});
  keep_if_certain(machine.bristle_rad, begun.bristle_rad, {kCoulombPositive, kCoulombNegative, kStiffness});
  keep_if_certain(machine.stribeck_rad_s, begun.stribeck_rad_s, {kStribeckSpeedPositive, kStribeckSpeedNegative});
  keep_if_certain(machine.inertia_kg_m2, begun.inertia_kg_m2, {kInertia});
  return machine;
}

// Friction takes energy out of the motor, whatever loads and wind do.
void check_sign_of_torque(const Recording& recording) {
  constexpr double kPlainly = -0.3;
  double energy = 0;
  double turnover = 0;
  for (std::size_t i = 1; i < recording.ticks(); ++i) {
    if (recording.run[i] == recording.run[i - 1]) {
      const double work = recording.torque_nm[i] * (recording.joint_angle_rad[i] - recording.joint_angle_rad[i - 1]);
      energy += work;
      turnover += std::abs(work);
    }
  }
  if (energy < kPlainly * turnover) {
    throw IdentificationError(
        "the torque acts against the motion all the time, which friction cannot do: its sign is opposite to that of "
        "the joint angle; reverse one of the two");
  }
}

void check_gyro(const Motion& motion) {
  constexpr double kMaxScaleError = 0.2;
  if (motion.gyro.fitted && std::abs(motion.gyro.scale_error) > kMaxScaleError) {
    throw IdentificationError(
        fmt::format("the gyro shows {:.3g} times the joint rate: its sign or scale is wrong; correct it, or leave its "
                    "column empty to fit without it",
                    1.0 + motion.gyro.scale_error));
  }
}

Eigen::Index usable_nodes(const std::vector<Span>& spans) {
  Eigen::Index nodes = 0;
  for (const Span& span : spans) {
    nodes += span.last - span.first;
  }
  return nodes;
}

}  // namespace

bool Identification::complete() const {
  return std::all_of(parameters.begin(), parameters.end(),
                     [](const Parameter& parameter) { return parameter.refused.empty(); });
}

const Parameter& Identification::parameter(const std::string& name) const {
  const auto found = std::find_if(parameters.begin(), parameters.end(),
                                  [&name](const Parameter& parameter) { return parameter.name == name; });
  if (found == parameters.end()) {
    throw std::out_of_range(fmt::format("there is no parameter '{}'", name));
  }
  return *found;
}

Identification identify(const Recording& recording) {
  Identification result(recording);
  check_sign_of_torque(recording);
  result.paper = paper_estimate(recording);
  Motion first_look = analyse_motion(recording);
  if (recording.has_gyro() && first_look.angle_noise_rad > kCoarse_rad) {
    first_look = analyse_motion(recording, kMotionCutoff_hz, true);
  }
  const PaperEstimate found = search_start(recording, first_look, result.paper);
  const double bristle_rad = found.friction.positive.coulomb_nm / found.friction.stiffness_nm_rad;
  result.motion_cutoff_hz = motion_cutoff_hz(first_look.angle_noise_rad, bristle_rad);
  result.motion = analyse_motion(recording, result.motion_cutoff_hz, first_look.fused);

  TorqueBalance balance(recording, result.motion, result.motion.stretches);
  const Eigen::VectorXd start = start_parameters(balance, found);
  if (usable_nodes(balance.known(start)) < kFewestNodes) {
    throw IdentificationError(fmt::format("the axis hardly slides in this recording of {:.1f} s: record a {} and {}.",
                                          static_cast<double>(recording.ticks()) * kTick_s,
                                          run_kind_name(RunKind::kSpeedSweep), run_kind_name(RunKind::kHysteresis)));
  }
  check_gyro(first_look);
  const Eigen::VectorXd paper = start_parameters(balance, result.paper);
  result.fit = fit_jointly(balance, starts_around(result.motion, start));
  result.harmonics = balance.harmonics();
  result.node_ticks = balance.ticks();
  result.evidence = EvidenceFinder(friction_of(result.fit.parameters), result.motion).find();
  result.evidence.inertial_share =
      inertial_share(result.motion, result.node_ticks, std::exp(result.fit.parameters[kInertia]),
                     std::exp(result.fit.parameters[kCoulombPositive]));
  result.largest_correlation = autocorrelation(result.fit.whitened, result.fit.spans, kLags).cwiseAbs().maxCoeff();
  result.residual_rms_nm = residual_rms_nm(result.fit);
  check_damping_ratio(result);
  judge(paper, result);
  result.rough = rough_machine(result.fit, found);
  return result;
}

}  // namespace trackservo::identification
