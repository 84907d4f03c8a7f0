#include "experiments/study.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/metrics.hpp"

namespace trackservo::sim {
namespace {

constexpr double kDegPerRad = 180.0 / kPi;
constexpr double kStartWindow_s = 0.5;  // in which start-up overshoot is looked for

void add_error_figures(std::vector<Figure>& figures, const Trace& trace, int axis, Window window) {
  figures.push_back({axis, "peak_error", "deg/s", kDegPerRad * peak_rate_error_rad_s(trace, axis, window)});
  figures.push_back({axis, "rms_error", "deg/s", kDegPerRad * rms_rate_error_rad_s(trace, axis, window)});
  figures.push_back({axis, "torque_noise", "Nm", torque_noise_nm(trace, axis, window)});
}

void add_start_figures(std::vector<Figure>& figures, const Trace& trace, int axis, Window start, double step_rad_s) {
  figures.push_back({axis, "time_to_90_percent", "ms", 1e3 * time_to_90_percent_s(trace, axis, start, step_rad_s)});
  const Window first{start.begin_s, std::min(start.end_s, start.begin_s + kStartWindow_s)};
  figures.push_back({axis, "overshoot", "%", 100.0 * overshoot_fraction(trace, axis, first, step_rad_s)});
}

}  // namespace

std::vector<StudyCase> cases_of(const Study& study) {
  if (study.scenario.kind == ScenarioKind::kTracking) {
    return {{study.tracker == TRACKER_PI ? "paper loop" : "improved loop", 0.0}};
  }
  std::vector<StudyCase> cases;
  for (const double speed_rad_s : study.scenario.speeds_rad_s) {
    std::string name = fmt::format("{:g} deg/s", kDegPerRad * speed_rad_s);
    if (study.scenario.kind == ScenarioKind::kSpeedSine) {
      name += fmt::format(", {:g} Hz", study.scenario.frequency_hz);
    }
    cases.push_back({name, speed_rad_s});
  }
  return cases;
}

std::vector<Figure> measure(const Study& study, const StudyCase& study_case, const Trace& trace) {
  const ScenarioConfig& scenario = study.scenario;
  const Window settled{scenario.rest_s + scenario.settle_s, scenario.duration_s};
  const Window started{scenario.rest_s, scenario.duration_s};
  std::vector<Figure> figures;
  for (int axis = 0; axis < kAxes; ++axis) {
    if (!scenario.axes[static_cast<std::size_t>(axis)]) {
      continue;
    }
    if (scenario.kind == ScenarioKind::kTracking) {
      figures.push_back({axis, "tracking_sigma", "urad", 1e6 * tracking_sigma_rad(trace, axis, settled)});
      figures.push_back({axis, "torque_noise", "Nm", torque_noise_nm(trace, axis, settled)});
    } else if (study.experiment == "low_speed_start") {
      add_start_figures(figures, trace, axis, started, study_case.speed_rad_s);
    } else if (study.experiment == "step_disturbed") {
      figures.push_back(
          {axis, "overshoot", "%", 100.0 * overshoot_fraction(trace, axis, started, study_case.speed_rad_s)});
    } else {
      add_error_figures(figures, trace, axis, settled);
    }
  }
  return figures;
}

std::string deciding_metric(const Study& study) {
  if (study.scenario.kind == ScenarioKind::kTracking) {
    return "tracking_sigma";
  }
  if (study.experiment == "low_speed_start") {
    return "time_to_90_percent";
  }
  return study.experiment == "step_disturbed" ? "overshoot" : "peak_error";
}

}  // namespace trackservo::sim
