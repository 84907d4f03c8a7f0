// SPDX-License-Identifier: Apache-2.0
#include "studies/straight_passes/straight_passes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/metrics.hpp"
#include "analysis/statistics.hpp"
#include "base/json_file.hpp"
#include "run/scenario_run.hpp"
#include "target/fly_by.hpp"

namespace trackservo::sim {
namespace {

// Of the tracking loop (2011:5). Long enough to coast through the half turn at the zenith; the estimate then leads
// back to the target.
constexpr double kCoast_s = 5.0;

constexpr double kAcceleration_rad_s2 =
    5.0;  // that the azimuth's motor gives (2060:19); no drive limits it in these runs

ScenarioConfig scenario_of(const PassesSetup& setup, const PassChoice& choice) {
  ScenarioConfig scenario = setup.scenario;
  scenario.pass->height_m = choice.height_m;
  scenario.pass->elevation_rad = choice.elevation_deg * kRadPerDeg;
  scenario.pass->evasive_m_s2 = choice.evasive_m_s2;
  scenario.fly_by = course_of(*scenario.pass);
  if (choice.dropout_s > 0.0) {
    scenario.camera.dropouts_at_s = {scenario.pass->closest_at_s};
    scenario.camera.dropout_s = choice.dropout_s;
  }
  return scenario;
}

servo_params params_of(const PassesSetup& setup, std::uint64_t seed) {
  DesignOptions design;
  design.tracker = TRACKER_PREDICTIVE;
  design.seed = seed;
  servo_params params = design_controller(setup.plant, controller_spec("pi_vob_ftc"), design);
  for (servo_axis_params& axis : params.axis) {
    axis.tracker.coast_s = static_cast<float>(kCoast_s);
    axis.tracker.estimator_rad_s = kPassEstimator_rad_s;
    axis.tracker.proportional_per_s = kPassProportional_per_s;
  }
  return params;
}

PassRun run_of(const PassesSetup& setup, const PassChoice& choice, std::uint64_t seed) {
  const ScenarioConfig scenario = scenario_of(setup, choice);
  RunRequest request;
  request.plant = &setup.plant;
  request.scenario = &scenario;
  request.params = params_of(setup, seed);
  request.seed = seed;
  const Trace trace = run_scenario(request);
  const double dropout_end_s = scenario.pass->closest_at_s + choice.dropout_s + kBack_s;
  const double from_s = choice.dropout_s > 0.0 ? dropout_end_s : scenario.settle_s;
  PassRun run;
  for (int axis = 0; axis < kAxes; ++axis) {
    run.sigma_rad[static_cast<std::size_t>(axis)] = tracking_sigma_rad(trace, axis, {from_s, scenario.duration_s});
  }
  double square_rad2 = 0.0;
  std::size_t rows = 0;
  LostTime lost;
  for (const TraceRow& row : trace) {
    if (row.time_s < from_s) {
      continue;
    }
    const double angle_rad = std::hypot(row.axis[kAzimuth].tracking_error_rad, row.axis[kPitch].tracking_error_rad);
    square_rad2 += angle_rad * angle_rad;
    ++rows;
    lost.add(row.time_s, angle_rad);
  }
  run.rms_rad = std::sqrt(square_rad2 / static_cast<double>(rows));
  run.lost_s = lost.seconds();
  return run;
}

std::vector<double> over_runs(const PassResult& result, const std::function<double(const PassRun&)>& value) {
  std::vector<double> values;
  for (const PassRun& run : result.runs) {
    values.push_back(value(run));
  }
  return values;
}

double worst_lost_s(const PassResult& result) {
  const std::vector<double> lost_s = over_runs(result, [](const PassRun& run) { return run.lost_s; });
  return *std::max_element(lost_s.begin(), lost_s.end());
}

std::string seconds_text(double time_s) {
  return std::isinf(time_s) ? "not found again" : fmt::format("{:.2f} s", time_s);
}

std::string name_of(const PassChoice& choice) {
  std::string name = fmt::format("{:g} deg, {:g} m", choice.elevation_deg, choice.height_m);
  name += choice.dropout_s > 0.0 ? fmt::format(", {:g} s without frames", choice.dropout_s) : "";
  return name + (choice.evasive_m_s2 > 0.0 ? fmt::format(", evades {:g} m/s2", choice.evasive_m_s2) : "");
}

std::string goal_text(const PassResult& result) {
  const char *const met = meets_goal(result) ? "yes" : "no";
  switch (result.choice.goal) {
    case PassGoal::kSigma:
      return fmt::format("1 sigma <= {:g} urad: {}", 1e6 * kSigmaGoal_rad, met);
    case PassGoal::kLost:
      return fmt::format("lost <= {:.2f} s: {}", kLostGoal * result.optimal_lost_s, met);
    case PassGoal::kNone:
    default:
      return "-";
  }
}

nlohmann::ordered_json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace

std::vector<PassChoice> shipped_passes() {
  return {{500.0, 60.0, PassGoal::kSigma},      {500.0, 80.0, PassGoal::kSigma},
          {500.0, 85.0, PassGoal::kSigma},      {500.0, 88.0, PassGoal::kLost},
          {500.0, 90.0, PassGoal::kLost},       {150.0, 85.0, PassGoal::kLost},
          {500.0, 60.0, PassGoal::kSigma, 1.0}, {500.0, 60.0, PassGoal::kNone, 0.0, 5.0}};
}

std::vector<Requirement> requirements_of(const PassResult& result) {
  const std::string name = "pass at " + name_of(result.choice) + ", by run";
  std::vector<Requirement> requirements;
  if (result.choice.goal == PassGoal::kSigma) {
    for (int axis = 0; axis < kAxes; ++axis) {
      const auto of_run = [axis](const PassRun& run) { return 1e6 * run.sigma_rad[static_cast<std::size_t>(axis)]; };
      requirements.push_back({name, axis_name(axis), "sigma", "urad", 1e6 * kSigmaGoal_rad, over_runs(result, of_run)});
    }
  } else if (result.choice.goal == PassGoal::kLost) {
    requirements.push_back({name, "", "time_lost", "s", kLostGoal * result.optimal_lost_s,
                            over_runs(result, [](const PassRun& run) { return run.lost_s; })});
  }
  return requirements;
}

bool meets_goal(const PassResult& result) {
  const std::vector<Requirement> requirements = requirements_of(result);
  return std::all_of(requirements.begin(), requirements.end(), is_met);
}

std::vector<PassResult> run_passes(const PassesSetup& setup,
                                   const std::function<void(int, int, const std::string&)>& progress) {
  const double rate_limit_rad_s =
      static_cast<double>(params_of(setup, setup.seeds.front()).axis[kAzimuth].tracker.rate_limit_rad_s);
  std::vector<PassResult> results;
  for (const PassChoice& choice : setup.passes) {
    PassResult result;
    result.choice = choice;
    const PassConfig pass = scenario_of(setup, choice).pass.value();
    result.fastest_azimuth_rad_s = fastest_azimuth_rad_s(pass);
    result.optimal_lost_s = optimal_lost_s(pass, {rate_limit_rad_s, kAcceleration_rad_s2});
    result.runs.resize(setup.seeds.size());
    results.push_back(result);
  }
  const std::size_t seeds = setup.seeds.size();
  JobPool pool(setup.threads, static_cast<int>(results.size() * seeds), progress);
  pool.run(results.size() * seeds, [&](std::size_t job) {
    PassResult& result = results[job / seeds];
    result.runs[job % seeds] = run_of(setup, result.choice, setup.seeds[job % seeds]);
    return "pass: " + name_of(result.choice);
  });
  return results;
}

void print(const PassesSetup& setup, const std::vector<PassResult>& results) {
  constexpr double kZenith_deg_s = 1e4;
  fmt::print("{}: {} seeds, on {}\n", setup.scenario.title, setup.seeds.size(), setup.plant.name);
  const char *const line = "  {:<34} {:<10} {:<23} {:<23} {:<10} {:<16} {}\n";
  fmt::print(fmt::runtime(line), "pass", "azimuth", "cross-elevation 1 sigma", "elevation 1 sigma", "angle rms", "lost",
             "goal");
  for (const PassResult& result : results) {
    const auto sigma = [&](std::size_t axis) {
      const std::vector<double> values =
          over_runs(result, [axis](const PassRun& r) { return 1e6 * r.sigma_rad[axis]; });
      return fmt::format("{:.2f}, worst {:.2f}", mean(values), quantile(values, 1.0));
    };
    const double rate_deg_s = result.fastest_azimuth_rad_s * kDegPerRad;
    const double rms_urad = mean(over_runs(result, [](const PassRun& r) { return 1e6 * r.rms_rad; }));
    fmt::print(fmt::runtime(line), name_of(result.choice),
               rate_deg_s < kZenith_deg_s ? fmt::format("{:.0f} deg/s", rate_deg_s) : "zenith", sigma(kAzimuth),
               sigma(kPitch), fmt::format("{:.2f}", rms_urad),
               result.choice.goal == PassGoal::kNone ? "-" : seconds_text(worst_lost_s(result)), goal_text(result));
  }
  fmt::print(
      "Errors in urad, mean over the seeds. Lost: time above {:g} urad, the worst seed; the goal is {:g} times the "
      "time-optimal plan.\n",
      1e6 * kLost_rad, kLostGoal);
}

void write_passes(const PassesSetup& setup, const std::vector<PassResult>& results, const std::string& git,
                  const std::filesystem::path& file) {
  nlohmann::ordered_json json;
  json["generator"] = {
      {"program", "sim_host passes"}, {"git", git}, {"plant", setup.plant.name}, {"seeds", setup.seeds}};
  json["goal"] = {{"sigma_urad", 1e6 * kSigmaGoal_rad}, {"lost_per_optimal", kLostGoal}};
  const std::array<const char *, 3> goals{"sigma", "lost", "none"};
  json["passes"] = nlohmann::ordered_json::array();
  for (const PassResult& result : results) {
    nlohmann::ordered_json pass{{"name", name_of(result.choice)},
                                {"goal", goals.at(static_cast<std::size_t>(result.choice.goal))},
                                {"height_m", result.choice.height_m},
                                {"elevation_deg", result.choice.elevation_deg},
                                {"speed_m_s", setup.scenario.pass->speed_m_s},
                                {"dropout_s", result.choice.dropout_s},
                                {"evasive_m_s2", result.choice.evasive_m_s2},
                                {"fastest_azimuth_deg_s", finite_or_null(kDegPerRad * result.fastest_azimuth_rad_s)},
                                {"optimal_lost_s", result.optimal_lost_s},
                                {"meets_goal", meets_goal(result)},
                                {"runs", nlohmann::ordered_json::array()}};
    for (std::size_t i = 0; i < result.runs.size(); ++i) {
      const PassRun& run = result.runs[i];
      pass["runs"].push_back({{"seed", setup.seeds[i]},
                              {"cross_elevation_sigma_urad", finite_or_null(1e6 * run.sigma_rad[kAzimuth])},
                              {"elevation_sigma_urad", finite_or_null(1e6 * run.sigma_rad[kPitch])},
                              {"angle_rms_urad", finite_or_null(1e6 * run.rms_rad)},
                              {"lost_s", finite_or_null(run.lost_s)}});
    }
    json["passes"].push_back(pass);
  }
  write_json(json, file);
}

}  // namespace trackservo::sim
