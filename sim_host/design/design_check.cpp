// SPDX-License-Identifier: Apache-2.0
#include "design/design_check.hpp"

#include <fmt/format.h>

#include <cmath>
#include <optional>

#include "design/plant_remedy.hpp"
#include "gain_design/speed_loop_pi.hpp"

namespace trackservo::sim {
namespace {

using gain_design::lowered;
using gain_design::pi_alone;

// A requirement to change, and its new value.
struct Advice {
  std::string key;  // dotted, of the plant file
  std::string text;
  double share = 0.0;  // share of the requirement that remains; 0: no smaller one helps
};

bool is_good(const PlantConfig& plant, int axis, const speed_loop_params& loop) {
  return keeps_margins(worst_margins(plant, axis, loop)) && speed_loop_is_stable(plant, axis, loop);
}

// The largest share, in steps of a twentieth, at which `loop_at(share)` is good.
template <class LoopAt>
std::optional<double> good_share(const PlantConfig& plant, int axis, LoopAt loop_at) {
  constexpr int kSteps = 90;  // down to a hundredth
  for (int step = 1; step <= kSteps; ++step) {
    const double share = std::pow(0.95, step);
    if (is_good(plant, axis, loop_at(share))) {
      return share;
    }
  }
  return std::nullopt;
}

// Three digits, never more than the value.
std::string rounded_down(double value) {
  const double step = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
  return fmt::format("{:g}", std::floor(value / step) * step);
}

std::string at_most(double value) { return "give at most " + rounded_down(value); }

// The PI's requirement, in the key that the file uses.
Advice pi_advice(const PlantConfig& plant, int axis, const speed_loop_params& loop, double share) {
  const DesignConfig& design = plant.design[static_cast<std::size_t>(axis)];
  if (design.speed_loop_natural_frequency_rad_s) {
    return {"speed_loop_natural_frequency_rad_s", at_most(share * *design.speed_loop_natural_frequency_rad_s), share};
  }
  const speed_loop_params alone = pi_alone(lowered(loop, share, 1.0));
  const double bandwidth_hz = closed_loop_bandwidth_hz(linear_machine(plant, axis, false), alone);
  if (!(bandwidth_hz > 0.0)) {  // the axis alone is slower than every evaluated frequency
    return {"speed_loop_bandwidth_hz", at_most(share * *design.speed_loop_bandwidth_hz), share};
  }
  return {"speed_loop_bandwidth_hz", at_most(bandwidth_hz), share};
}

// The observer is lowered first, if that is enough: it is the most demanding part.
Advice advice_for(const PlantConfig& plant, int axis, const speed_loop_params& loop) {
  const DesignConfig& design = plant.design[static_cast<std::size_t>(axis)];
  const auto observer_lowered = [&](double share) { return lowered(loop, 1.0, share); };
  const auto both_lowered = [&](double share) { return lowered(loop, share, share); };
  if (loop.observer_on) {
    if (const auto share = good_share(plant, axis, observer_lowered)) {
      return {"observer_bandwidth_hz", at_most(*share * design.observer_bandwidth_hz), *share};
    }
  }
  if (const auto share = good_share(plant, axis, both_lowered)) {
    Advice advice = pi_advice(plant, axis, loop, *share);
    if (loop.observer_on) {
      advice.text += fmt::format(", and with it observer_bandwidth_hz at most {}",
                                 rounded_down(*share * design.observer_bandwidth_hz));
    }
    return advice;
  }
  return {design.speed_loop_bandwidth_hz ? "speed_loop_bandwidth_hz" : "speed_loop_natural_frequency_rad_s",
          "a smaller bandwidth does not help: check latencies, fusion and inertia", 0.0};
}

std::string alternatives(const speed_loop_params& loop) {
  constexpr int kShortestWindow_ticks = 2;
  if (loop.rate_fusion.source == RATE_FROM_GYRO || loop.rate_estimator.window_ticks <= kShortestWindow_ticks) {
    return "";
  }
  return fmt::format(
      ", or fewer rate_window_ticks: {} of them delay the encoder's rate by {:g} ms (for a coarse encoder use feedback "
      "= \"gyro\" instead)",
      loop.rate_estimator.window_ticks, 0.5 * (loop.rate_estimator.window_ticks - 1));
}

// The error of this axis' loop, at the line of the key that should change. A requirement is the likely cause. Only
// if it would have to be reduced very much, a wrong number of the machine is more likely.
ConfigError error(const PlantConfig& plant, int axis, const speed_loop_params& loop, const std::string& reason,
                  const IsPossible& is_possible = {}) {
  constexpr double kLikelyShare = 0.1;
  const Advice advice = advice_for(plant, axis, loop);
  std::string more = alternatives(loop);
  if (is_possible && advice.share < kLikelyShare) {
    return design_error(plant, axis, reason, is_possible, more);
  }
  if (is_possible) {
    for (const Remedy& remedy : plant_remedies(plant, axis, is_possible)) {
      more += remedy.is_requirement ? "" : ", or " + other_text(remedy);
    }
  }
  return plant.lines.error(fmt::format("design.{}.{}", axis_name(axis), advice.key), reason, advice.text + more);
}

// Why an axis has two of them.
std::string inertia_text(const PlantConfig& plant, int axis) {
  const AxisConfig& config = plant.axis[static_cast<std::size_t>(axis)];
  return config.inertia_swing_kg_m2 > 0.0 ? fmt::format(" (inertia_kg_m2 = {:g}, inertia_swing_kg_m2 = {:g})",
                                                        config.inertia_kg_m2, config.inertia_swing_kg_m2)
                                          : "";
}

const char *loop_text(const speed_loop_params& loop) { return loop.observer_on ? "PI and observer" : "PI"; }

}  // namespace

void refuse_unstable_loops(const PlantConfig& plant, const servo_params& params,
                           const std::function<bool(const PlantConfig& plant, int axis)>& is_possible) {
  for (int axis = 0; axis < kAxes; ++axis) {
    const speed_loop_params& loop = params.axis[axis].speed;
    if (!speed_loop_is_stable(plant, axis, loop)) {
      const auto is_possible_here = [&](const PlantConfig& changed) { return is_possible(changed, axis); };
      throw error(
          plant, axis, loop,
          fmt::format("makes the speed loop with {} unstable at an inertia of {:g} or {:g} kg m2{}", loop_text(loop),
                      min_inertia_kg_m2(plant, axis), axis_inertia_kg_m2(plant, axis, 0.0), inertia_text(plant, axis)),
          is_possible ? IsPossible(is_possible_here) : IsPossible());
    }
  }
}

std::vector<std::string> margin_warnings(const PlantConfig& plant, const servo_params& params) {
  std::vector<std::string> warnings;
  for (int axis = 0; axis < kAxes; ++axis) {
    const speed_loop_params& loop = params.axis[axis].speed;
    const Margins margins = worst_margins(plant, axis, loop);
    if (!keeps_margins(margins)) {
      const std::string reason = fmt::format(
          "leaves the speed loop with {} {:.1f} dB gain margin and {:.0f} deg phase margin, but {:g} dB and {:g} deg "
          "are required",
          loop_text(loop), margins.gain_margin_db, margins.phase_margin_deg, kMinMargins.gain_margin_db,
          kMinMargins.phase_margin_deg);
      warnings.emplace_back(error(plant, axis, loop, reason).what());
    }
  }
  return warnings;
}

}  // namespace trackservo::sim
