// SPDX-License-Identifier: Apache-2.0
#include "judge/analysis/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "judge/analysis/metrics.hpp"
#include "machine/run/demand.hpp"

namespace trackservo::sim {
namespace {

constexpr double kOverSpeed_rad_s = 1.5;  // 2060:1 of a served machine
constexpr double kOverSpeedShare = 3.0;   // of a faster set-point
constexpr double kMaxError = 0.5;         // of the set-point, both rms

double rms(double sum_of_squares, std::size_t count) {
  return std::sqrt(sum_of_squares / static_cast<double>(std::max<std::size_t>(count, 1)));
}

// Figures of one axis of a run in its analysis window.
struct Seen {
  bool is_finite = true;
  double highest_rate_rad_s = 0;  // of the joint, in the whole run
  double highest_reference_rad_s = 0;
  double rms_error_rad_s = 0;
  double rms_reference_rad_s = 0;
  double largest_miss_rad = 0;  // of the target
};

Seen look(const ScenarioConfig& scenario, const Trace& trace, int axis) {
  const Window window{scenario.rest_s + scenario.settle_s, scenario.duration_s};
  Seen seen;
  double errors = 0.0;
  double references = 0.0;
  std::size_t count = 0;
  for (const TraceRow& row : trace) {
    const AxisRow& a = row.axis[static_cast<std::size_t>(axis)];
    seen.is_finite = seen.is_finite && std::isfinite(a.joint_rate_rad_s + a.torque_nm + a.command_nm);
    seen.highest_rate_rad_s = std::max(seen.highest_rate_rad_s, std::abs(a.joint_rate_rad_s));
    seen.highest_reference_rad_s = std::max(seen.highest_reference_rad_s, std::abs(a.reference_rad_s));
    if (row.time_s >= window.begin_s && row.time_s < window.end_s) {
      errors += (a.rate_rad_s - a.reference_rad_s) * (a.rate_rad_s - a.reference_rad_s);
      references += a.reference_rad_s * a.reference_rad_s;
      seen.largest_miss_rad = std::max(seen.largest_miss_rad, std::abs(a.tracking_error_rad));
      ++count;
    }
  }
  seen.rms_error_rad_s = rms(errors, count);
  seen.rms_reference_rad_s = rms(references, count);
  return seen;
}

// At the beginning of a step the axis is far from its set-point.
bool is_start(const ScenarioConfig& scenario) {
  return scenario.kind == ScenarioKind::kSpeedStep && scenario.settle_s <= 0.0;
}

bool never_arrives(const ScenarioConfig& scenario, double speed_rad_s, const Trace& trace, int axis) {
  return is_start(scenario) && scenario.disturbance_amplitude_rad_s <= 0.0 &&
         std::isinf(time_to_90_percent_s(trace, axis, {scenario.rest_s, scenario.duration_s}, speed_rad_s));
}

// The error, or nothing.
std::string failure(const ScenarioConfig& scenario, double speed_rad_s, const Trace& trace, int axis) {
  const Seen seen = look(scenario, trace, axis);
  const double over_speed_rad_s = std::max(kOverSpeed_rad_s, kOverSpeedShare * seen.highest_reference_rad_s);
  if (!seen.is_finite) {
    return "its signals are not finite";
  }
  if (seen.highest_rate_rad_s > over_speed_rad_s) {
    return fmt::format("it reaches {:.3g} deg/s, above the over-speed limit of {:.3g} deg/s",
                       kDegPerRad * seen.highest_rate_rad_s, kDegPerRad * over_speed_rad_s);
  }
  if (!scenario.axes[static_cast<std::size_t>(axis)]) {
    return "";
  }
  if (scenario.kind == ScenarioKind::kTracking) {
    const int pixels = axis == kAzimuth ? scenario.camera.width_px : scenario.camera.height_px;
    const double reach_rad = 0.5 * pixels * scenario.camera.pixel_rad;
    return seen.largest_miss_rad > reach_rad
               ? fmt::format("the target is {:.3g} deg off, outside the image, which ends at {:.3g} deg",
                             kDegPerRad * seen.largest_miss_rad, kDegPerRad * reach_rad)
               : "";
  }
  if (seen.rms_error_rad_s > (is_start(scenario) ? 1.0 : kMaxError) * seen.rms_reference_rad_s) {
    return fmt::format("its rms error is {:.3g} deg/s at a set-point of {:.3g} deg/s rms",
                       kDegPerRad * seen.rms_error_rad_s, kDegPerRad * seen.rms_reference_rad_s);
  }
  return never_arrives(scenario, speed_rad_s, trace, axis)
             ? fmt::format("it does not reach 90 % of {:.3g} deg/s", kDegPerRad * speed_rad_s)
             : "";
}

}  // namespace

std::vector<std::string> uncontrolled_axes(const PlantConfig& plant, const ScenarioConfig& scenario, double speed_rad_s,
                                           const Trace& trace) {
  constexpr double kMinReference_rad_s = 1e-3;  // where an axis only holds its position
  std::vector<std::string> own_fault;
  std::vector<std::string> others_fault;
  for (int axis = 0; axis < kAxes; ++axis) {
    const std::string what = failure(scenario, speed_rad_s, trace, axis);
    if (what.empty()) {
      continue;
    }
    const double reference_rad_s = std::max(look(scenario, trace, axis).highest_reference_rad_s, kMinReference_rad_s);
    const Demand first = demands_on(plant, scenario, axis, reference_rad_s).front();
    const std::string reason = fmt::format("{} is not controlled ({}): {}", axis_name(axis), what, first.reason);
    std::vector<std::string>& sentences = first.share > 1.0 ? own_fault : others_fault;
    sentences.emplace_back(plant.lines.error(first.key, reason, first.remedy).what());
  }
  return own_fault.empty() ? others_fault : own_fault;
}

}  // namespace trackservo::sim
