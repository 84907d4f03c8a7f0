// SPDX-License-Identifier: Apache-2.0
#include "studies/shared/study.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "device/tracking_run.hpp"
#include "judge/analysis/metrics.hpp"
#include "machine/run/scenario_run.hpp"

namespace trackservo::sim {
namespace {

constexpr double kStartWindow_s = 0.5;  // window of the start-up overshoot

void add_error_figures(std::vector<Figure>& figures, const Trace& trace, int axis, Window window) {
  figures.push_back({axis, "peak_error", "deg/s", kDegPerRad * peak_rate_error_rad_s(trace, axis, window)});
  figures.push_back({axis, "rms_error", "deg/s", kDegPerRad * rms_rate_error_rad_s(trace, axis, window)});
  figures.push_back({axis, "torque_noise", "Nm", torque_noise_nm(trace, axis, window)});
}

void add_tracking_figures(std::vector<Figure>& figures, const Trace& trace, int axis, Window window) {
  figures.push_back({axis, "tracking_sigma", "urad", 1e6 * tracking_sigma_rad(trace, axis, window)});
  figures.push_back({axis, "torque_noise", "Nm", torque_noise_nm(trace, axis, window)});
}

void add_overshoot(std::vector<Figure>& figures, const Trace& trace, int axis, Window window, double step_rad_s) {
  figures.push_back({axis, "overshoot", "%", 100.0 * overshoot_fraction(trace, axis, window, step_rad_s)});
}

void add_start_figures(std::vector<Figure>& figures, const Trace& trace, int axis, Window start, double step_rad_s) {
  figures.push_back({axis, "time_to_90_percent", "ms", 1e3 * time_to_90_percent_s(trace, axis, start, step_rad_s)});
  add_overshoot(figures, trace, axis, {start.begin_s, std::min(start.end_s, start.begin_s + kStartWindow_s)},
                step_rad_s);
}

}  // namespace

std::string study_name(const Study& study) {
  const bool improved = study.tracker == TRACKER_PREDICTIVE;
  return study.experiment + " on " + study.plant.name + (improved ? ", improved loop" : "");
}

std::string friction_name(FrictionModel model) {
  switch (model) {
    case FrictionModel::kLugre:
      return "lugre";
    case FrictionModel::kMaxwellSlip:
      return "maxwell_slip";
    case FrictionModel::kNone:
    default:
      return "none";
  }
}

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

DesignOptions design_options(const Study& study, std::uint64_t seed, double friction_parameter_error) {
  return {seed, friction_parameter_error, study.tracker, study.identified, study.least_error};
}

Trace run_case(const Study& study, const StudyCase& study_case, const RunChoice& choice) {
  PlantConfig plant = study.plant;
  plant.friction_model = choice.friction;
  const DesignOptions options = design_options(study, choice.seed, choice.friction_parameter_error);
  servo_params params = design_controller(plant, *choice.controller, options);
  if (study.scenario.kind == ScenarioKind::kTracking) {
    AxesParameters parameters = design_axes(plant, *choice.controller, options);
    for (int axis = 0; axis < kAxes && choice.pi; ++axis) {
      set_pi(parameters[static_cast<std::size_t>(axis)], *choice.pi);
    }
    return run_tracking(NodeSetup(plant, parameters), study.scenario, choice.seed);
  }
  for (int axis = 0; axis < kAxes && choice.pi; ++axis) {
    set_pi(params, axis, *choice.pi);
  }
  return run_scenario({&plant, &study.scenario, study_case.speed_rad_s, params, choice.seed});
}

Purpose purpose_of(const ScenarioConfig& scenario) {
  if (scenario.kind == ScenarioKind::kTracking) {
    return Purpose::kTracking;
  }
  if (scenario.kind == ScenarioKind::kSpeedSine || scenario.settle_s > 0.0) {
    return Purpose::kSteady;
  }
  return scenario.disturbance_amplitude_rad_s > 0.0 ? Purpose::kDisturbedStep : Purpose::kStart;
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
    switch (purpose_of(scenario)) {
      case Purpose::kTracking:
        add_tracking_figures(figures, trace, axis, settled);
        break;
      case Purpose::kStart:
        add_start_figures(figures, trace, axis, started, study_case.speed_rad_s);
        break;
      case Purpose::kDisturbedStep:
        add_overshoot(figures, trace, axis, started, study_case.speed_rad_s);
        break;
      case Purpose::kSteady:
      default:
        add_error_figures(figures, trace, axis, settled);
        break;
    }
  }
  return figures;
}

std::vector<std::string> metrics_of(const ScenarioConfig& scenario) {
  switch (purpose_of(scenario)) {
    case Purpose::kTracking:
      return {"tracking_sigma", "torque_noise"};
    case Purpose::kStart:
      return {"time_to_90_percent", "overshoot"};
    case Purpose::kDisturbedStep:
      return {"overshoot"};
    case Purpose::kSteady:
    default:
      return {"peak_error", "rms_error", "torque_noise"};
  }
}

std::string deciding_metric(const Study& study) { return metrics_of(study.scenario).front(); }

}  // namespace trackservo::sim
