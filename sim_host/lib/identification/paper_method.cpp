// SPDX-License-Identifier: Apache-2.0
#include "identification/paper_method.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "identification/motion.hpp"
#include "identification/window.hpp"

namespace trackservo::identification {

const double kPaperDampingRatio = std::sqrt(0.5);

double paper_damping_nm_s_rad(double inertia_kg_m2, double stiffness_nm_rad, double viscous_nm_s_rad,
                              double damping_ratio) {
  return 2.0 * damping_ratio * std::sqrt(inertia_kg_m2 * stiffness_nm_rad) - viscous_nm_s_rad;
}

double presliding_damping_ratio(double inertia_kg_m2, double stiffness_nm_rad, double damping_nm_s_rad,
                                double viscous_nm_s_rad) {
  return (damping_nm_s_rad + viscous_nm_s_rad) / (2.0 * std::sqrt(inertia_kg_m2 * stiffness_nm_rad));
}

namespace {

constexpr std::size_t kShortestLeg_ticks = 50;
constexpr double kSpeedBand = 0.3;  // maximum relative deviation of the mean speed of a leg from the commanded one

struct Mean {
  double sum = 0;
  double count = 0;
  void add(double value) {
    sum += value;
    count += 1;
  }
  double value() const { return sum / count; }
};

// Both directions of one speed.
struct SpeedMeans {
  Mean speed_rad_s[2];
  Mean torque_nm[2];
};

// Speeds that differ by less than a thousandth are equal.
long speed_key(double speed_rad_s) { return std::lround(1000.0 * std::log(speed_rad_s)); }

// Adds the second half of a leg, ticks [first, last), in which the reference did not change.
void add_leg(const Recording& recording, const Motion& motion, std::size_t first, std::size_t last,
             std::map<long, SpeedMeans>& speeds) {
  const double reference = recording.reference[first];
  if (last - first < kShortestLeg_ticks || reference == 0.0) {
    return;
  }
  Mean rate;
  Mean torque;
  for (std::size_t i = (first + last) / 2; i < last; ++i) {
    rate.add(motion.joint_rate_rad_s[i]);
    torque.add(recording.torque_nm[i]);
  }
  if (std::abs(rate.value() - reference) > kSpeedBand * std::abs(reference)) {
    return;
  }
  SpeedMeans& means = speeds[speed_key(std::abs(reference))];
  const int side = reference > 0 ? 1 : 0;
  means.speed_rad_s[side].add(std::abs(rate.value()));
  means.torque_nm[side].add(torque.value());
}

std::map<long, SpeedMeans> sweep_means(const Recording& recording, const Motion& motion) {
  std::map<long, SpeedMeans> speeds;
  for (const Stretch& stretch : motion.stretches) {
    std::size_t first = stretch.first;
    for (std::size_t i = stretch.first; i <= stretch.last; ++i) {
      const bool goes_on = i < stretch.last && recording.kind[i] == RunKind::kSpeedSweep &&
                           recording.run[i] == recording.run[first] &&
                           recording.reference[i] == recording.reference[first];
      if (!goes_on) {
        if (recording.kind[first] == RunKind::kSpeedSweep) {
          add_leg(recording, motion, first, i, speeds);
        }
        first = i;
      }
    }
  }
  return speeds;
}

SteadySpeeds steady_speeds(const Recording& recording, const Motion& motion) {
  const std::map<long, SpeedMeans> speeds = sweep_means(recording, motion);
  SteadySpeeds steady;
  Mean load;
  for (const auto& [key, means] : speeds) {
    if (means.torque_nm[0].count > 0 && means.torque_nm[1].count > 0) {
      load.add(0.5 * (means.torque_nm[0].value() + means.torque_nm[1].value()));
    }
  }
  steady.load_nm = load.count > 0 ? load.value() : 0.0;
  for (const auto& [key, means] : speeds) {
    for (const int side : {0, 1}) {
      if (means.torque_nm[side].count > 0) {
        const double against_nm = (side == 1 ? 1.0 : -1.0) * (means.torque_nm[side].value() - steady.load_nm);
        (side == 1 ? steady.positive : steady.negative)
            .push_back({means.speed_rad_s[side].value(), against_nm, means.torque_nm[side].count});
      }
    }
  }
  return steady;
}

// Torque against acceleration under the window, both differenced once: friction and wind change slowly in comparison.
double inertia_by_excitation(const Recording& recording, const Motion& motion) {
  const bool excited = recording.has(RunKind::kTorqueExcitation);
  double product = 0;
  double square = 0;
  for (const Stretch& stretch : motion.stretches) {
    double last_torque = NAN;
    double last_acceleration = 0;
    for (std::size_t i = stretch.first + kWindowReach; i + kWindowReach < stretch.last; i += kHalfWindow) {
      if (excited && recording.kind[i] != RunKind::kTorqueExcitation) {
        last_torque = NAN;
        continue;
      }
      const double torque = triangle_mean(recording.torque_nm, i);
      const double acceleration = triangle_second_derivative(recording.joint_angle_rad, i);
      if (!std::isnan(last_torque)) {
        product += (torque - last_torque) * (acceleration - last_acceleration);
        square += (acceleration - last_acceleration) * (acceleration - last_acceleration);
      }
      last_torque = torque;
      last_acceleration = acceleration;
    }
  }
  return square > 0 ? product / square : 0.0;
}

// Slopes du/dtheta, eq. (16), at each zero of the friction torque after a reversal of the axis: there the bristles are
// relaxed, and LuGre's slope is sigma0.
class SlopeFinder {
 public:
  SlopeFinder(const Recording& recording, const Motion& motion, const PaperEstimate& so_far)
      : recording_(recording), motion_(motion), so_far_(so_far) {
    level_nm_ = 0.5 * (so_far.friction.positive.coulomb_nm + so_far.friction.negative.coulomb_nm);
  }

  // The median of the slopes found, 0 when there is none; in pre-sliding runs only, or in all.
  double find(bool presliding_runs_only) {
    slopes_.clear();
    for (const Stretch& stretch : motion_.stretches) {
      for (std::size_t i = stretch.first + kWindowReach; i + kWindowReach < stretch.last; ++i) {
        const RunKind kind = recording_.kind[i];
        const bool wanted = !presliding_runs_only || kind == RunKind::kTorqueRamps || kind == RunKind::kHysteresis;
        add(wanted,
            triangle_mean(recording_.torque_nm, i) - so_far_.load_nm -
                so_far_.inertia_kg_m2 * triangle_second_derivative(recording_.joint_angle_rad, i),
            recording_.joint_angle_rad[i]);
      }
      end_crossing();
    }
    if (slopes_.empty()) {
      return 0.0;
    }
    const auto middle = slopes_.begin() + static_cast<std::ptrdiff_t>(slopes_.size() / 2);
    std::nth_element(slopes_.begin(), middle, slopes_.end());
    return *middle;
  }

 private:
  static constexpr double kNearZero = 0.4;       // of Tc
  static constexpr double kWholeCrossing = 0.5;  // of Tc: a shorter crossing does not count

  void add(bool wanted, double friction_nm, double angle_rad) {
    if (wanted && std::abs(friction_nm) < kNearZero * level_nm_) {
      torque_.push_back(friction_nm);
      angle_.push_back(angle_rad);
    } else {
      end_crossing();
    }
  }

  void end_crossing() {
    if (torque_.size() > 2 && std::abs(torque_.back() - torque_.front()) > kWholeCrossing * level_nm_) {
      const double slope = (torque_.back() - torque_.front()) / (angle_.back() - angle_.front());
      if (std::isfinite(slope) && slope > 0) {
        slopes_.push_back(slope);
      }
    }
    torque_.clear();
    angle_.clear();
  }

  const Recording& recording_;
  const Motion& motion_;
  const PaperEstimate& so_far_;
  double level_nm_ = 0;
  std::vector<double> torque_;
  std::vector<double> angle_;
  std::vector<double> slopes_;
};

// A start value where no steady speeds were recorded: all torque is Coulomb friction.
DirectionFriction guess_direction(const Recording& recording, const Motion& motion) {
  Mean torque;
  Mean speed;
  for (std::size_t i = 0; i < recording.ticks(); ++i) {
    torque.add(std::abs(recording.torque_nm[i]));
    speed.add(std::abs(motion.joint_rate_rad_s[i]));
  }
  const double level_nm = std::max(torque.value(), 1e-6);
  const double speed_rad_s = std::max(speed.value(), 1e-6);
  return {level_nm, 1.3 * level_nm, 0.3 * speed_rad_s, 0.1 * level_nm / speed_rad_s};
}

}  // namespace

SteadySpeeds steady_speeds(const Recording& recording) { return steady_speeds(recording, analyse_motion(recording)); }

PaperEstimate paper_estimate(const Recording& recording) {
  const Motion motion = analyse_motion(recording);
  const SteadySpeeds steady = steady_speeds(recording, motion);
  PaperEstimate estimate;
  estimate.load_nm = steady.load_nm;
  const std::optional<DirectionFriction> positive = fit_stribeck(steady.positive);
  const std::optional<DirectionFriction> negative = fit_stribeck(steady.negative);
  if (!positive || !negative) {
    estimate.missing.emplace_back("Tc, Ts, vs, sigma2: no run has at least four constant speeds in both directions");
  }
  const DirectionFriction guess = guess_direction(recording, motion);
  estimate.friction.positive = positive.value_or(negative.value_or(guess));
  estimate.friction.negative = negative.value_or(positive.value_or(guess));

  estimate.inertia_kg_m2 = inertia_by_excitation(recording, motion);
  if (!(estimate.inertia_kg_m2 > 0)) {
    estimate.missing.emplace_back("J: no run accelerates the axis");
    estimate.inertia_kg_m2 = 1.0;
  }
  SlopeFinder slopes(recording, motion, estimate);
  double stiffness = slopes.find(true);
  stiffness = stiffness > 0 ? stiffness : slopes.find(false);
  if (!(stiffness > 0)) {
    estimate.missing.emplace_back("sigma0: no run reverses slowly enough to show the slope in pre-sliding");
    stiffness = 1e3 * estimate.friction.positive.coulomb_nm;
  }
  estimate.friction.stiffness_nm_rad = stiffness;
  const double viscous =
      0.5 * (estimate.friction.positive.viscous_nm_s_rad + estimate.friction.negative.viscous_nm_s_rad);
  const double damping = paper_damping_nm_s_rad(estimate.inertia_kg_m2, stiffness, viscous, kPaperDampingRatio);
  estimate.friction.damping_nm_s_rad = std::max(damping, 0.1 * viscous);
  return estimate;
}

}  // namespace trackservo::identification
