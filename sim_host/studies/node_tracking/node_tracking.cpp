#include "studies/node_tracking/node_tracking.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/metrics.hpp"
#include "base/json_file.hpp"
#include "run/scenario_run.hpp"

namespace trackservo::sim {
namespace {

constexpr double kUrad = 1e-6;
constexpr double kPerRun = 1.1;

// As in the study of straight passes.
constexpr float kPassProportional_per_s = 30.0F;
constexpr float kPassEstimator_rad_s = 6.0F;

constexpr double kDropoutAt_s = 20.0;
constexpr double kDropout_s = 1.0;
constexpr double kBack_s = 0.5;
constexpr float kCoast_s = 2.0F;
constexpr double kStep_nm = 3.0;  // a third of the break-away torque

NodeTrackingCase pass_at(double elevation_deg, const std::filesystem::path& data_dir,
                         const target_tracker_params& loop) {
  NodeTrackingCase tried;
  tried.name = fmt::format("pass at {:g} deg, 500 m up", elevation_deg);
  tried.scenario = load_scenario(data_dir / "studies/straight_passes/scenario.toml");
  tried.scenario.pass->elevation_rad = elevation_deg * kRadPerDeg;
  tried.scenario.fly_by = course_of(*tried.scenario.pass);
  tried.loop = loop;
  tried.loop.proportional_per_s = kPassProportional_per_s;
  tried.loop.estimator_rad_s = kPassEstimator_rad_s;
  tried.goal.sigma_rad = {5.0 * kUrad, 5.0 * kUrad};
  tried.count_from_s = tried.scenario.settle_s;
  return tried;
}

std::array<double, kAxes> sigma_by_run(const PlantConfig& plant, const NodeTrackingCase& tried,
                                       const servo_params& params, std::uint64_t seed) {
  RunRequest request;
  request.plant = &plant;
  request.scenario = &tried.scenario;
  request.params = params;
  request.seed = seed;
  const Trace trace = run_scenario(request);
  const Window window{tried.count_from_s, tried.scenario.duration_s};
  return {tracking_sigma_rad(trace, kAzimuth, window), tracking_sigma_rad(trace, kPitch, window)};
}

bool keeps(const NodeTrackingGoal& goal, const NodeTrackingRun& run) {
  bool kept = run.dropped == 0 && (!goal.step_nm || run.step_nm <= *goal.step_nm);
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    kept = kept && run.sigma_rad[axis] <= goal.sigma_rad[axis] &&
           (!goal.per_run || run.sigma_rad[axis] <= *goal.per_run * run.run_sigma_rad[axis]);
  }
  return kept;
}

std::string spread_text(const NodeTrackingResult& result, const std::array<double, kAxes> NodeTrackingRun::*sigma_rad) {
  std::array<double, kAxes> worst{};
  for (const NodeTrackingRun& run : result.runs) {
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      worst[axis] = std::max(worst[axis], (run.*sigma_rad)[axis] / kUrad);
    }
  }
  return fmt::format("{:.2f} and {:.2f}", worst[kAzimuth], worst[kPitch]);
}

std::string goal_text(const NodeTrackingGoal& goal) {
  std::string text =
      fmt::format("{:g} and {:g} urad", goal.sigma_rad[kAzimuth] / kUrad, goal.sigma_rad[kPitch] / kUrad);
  text += goal.per_run ? fmt::format(", {:g} of run", *goal.per_run) : "";
  return text + (goal.step_nm ? fmt::format(", {:g} Nm per tick", *goal.step_nm) : "");
}

double largest_step_nm(const NodeTrackingResult& result) {
  double step_nm = 0.0;
  for (const NodeTrackingRun& run : result.runs) {
    step_nm = std::max(step_nm, run.step_nm);
  }
  return step_nm;
}

}  // namespace

std::vector<NodeTrackingCase> shipped_node_tracking(const PlantConfig& plant, const std::filesystem::path& data_dir) {
  const target_tracker_params predictive = designed_tracking_loop(plant, TRACKER_PREDICTIVE);
  NodeTrackingCase fly_by;
  fly_by.scenario = load_scenario(data_dir / "scenarios/tracking.toml");
  fly_by.count_from_s = fly_by.scenario.settle_s;
  fly_by.by_run = true;
  fly_by.name = "fly-by, paper's loop";
  fly_by.loop = designed_tracking_loop(plant, TRACKER_PI);
  fly_by.goal = {{15.0 * kUrad, 15.0 * kUrad}, kPerRun, std::nullopt};
  std::vector<NodeTrackingCase> cases{fly_by};
  fly_by.name = "fly-by, predictive loop";
  fly_by.loop = predictive;
  fly_by.goal = {{2.5 * kUrad, 3.0 * kUrad}, kPerRun, std::nullopt};
  cases.push_back(fly_by);
  for (const double elevation_deg : {60.0, 80.0, 85.0}) {
    cases.push_back(pass_at(elevation_deg, data_dir, predictive));
  }
  NodeTrackingCase dropout = fly_by;
  dropout.name = "fly-by, 1 s without the target";
  dropout.by_run = false;
  dropout.loop.coast_s = kCoast_s;
  dropout.scenario.camera.dropouts_at_s = {kDropoutAt_s};
  dropout.scenario.camera.dropout_s = kDropout_s;
  dropout.scenario.duration_s = kDropoutAt_s + kDropout_s + 10.0;
  dropout.count_from_s = kDropoutAt_s + kDropout_s + kBack_s;
  dropout.goal = {{5.0 * kUrad, 5.0 * kUrad}, std::nullopt, kStep_nm};
  cases.push_back(dropout);
  return cases;
}

NodeTrackingRun run_of(const NodeSetup& setup, const NodeTrackingCase& tried, std::uint64_t seed) {
  TrackingNode tracking(setup, tried.scenario, seed, tried.loop);
  NodeTrackingRun run;
  ErrorSpread spread;
  std::array<double, kAxes> last_nm{};
  while (tracking.time_s() < tried.scenario.duration_s) {
    for (int axis = 0; axis < kAxes; ++axis) {
      const double now_nm = static_cast<double>(tracking.node().machine().firmware(axis).commanded_nm);
      double& last = last_nm[static_cast<std::size_t>(axis)];
      run.step_nm = tracking.time_s() > tried.scenario.settle_s ? std::max(run.step_nm, std::abs(now_nm - last)) : 0.0;
      last = now_nm;
    }
    if (tracking.time_s() >= tried.count_from_s) {
      spread.add(tracking.error_rad());
    }
    tracking.tick();
  }
  run.sigma_rad = spread.sigma_rad();
  run.dropped = tracking.node().node().tracking.frames.dropped;
  if (tried.by_run) {
    run.run_sigma_rad = sigma_by_run(setup.plant, tried, tracking.node().node().board.app.params, seed);
  }
  return run;
}

std::vector<NodeTrackingResult> run_node_tracking(const NodeTrackingSetup& setup,
                                                  const std::function<void(int, int, const std::string&)>& progress) {
  const NodeSetup node(setup.plant);
  std::vector<NodeTrackingResult> results;
  for (const NodeTrackingCase& tried : setup.cases) {
    results.push_back({tried, std::vector<NodeTrackingRun>(setup.seeds.size())});
  }
  const std::size_t seeds = setup.seeds.size();
  JobPool pool(setup.threads, static_cast<int>(results.size() * seeds), progress);
  pool.run(results.size() * seeds, [&](std::size_t job) {
    NodeTrackingResult& result = results[job / seeds];
    result.runs[job % seeds] = run_of(node, result.tried, setup.seeds[job % seeds]);
    return result.tried.name;
  });
  return results;
}

bool meets_goal(const NodeTrackingResult& result) {
  return std::all_of(result.runs.begin(), result.runs.end(),
                     [&result](const NodeTrackingRun& run) { return keeps(result.tried.goal, run); });
}

void print(const NodeTrackingSetup& setup, const std::vector<NodeTrackingResult>& results) {
  fmt::print("Tracking in the running node, camera frames over CAN: {} seeds, on {}\n", setup.seeds.size(),
             setup.plant.name);
  const char *const line = "  {:<31} {:<17} {:<17} {:<9} {:<36} {}\n";
  fmt::print(fmt::runtime(line), "target", "1 sigma, urad", "by run", "Nm/tick", "goal", "met");
  for (const NodeTrackingResult& result : results) {
    fmt::print(fmt::runtime(line), result.tried.name, spread_text(result, &NodeTrackingRun::sigma_rad),
               result.tried.by_run ? spread_text(result, &NodeTrackingRun::run_sigma_rad) : "-",
               result.tried.goal.step_nm ? fmt::format("{:.2f}", largest_step_nm(result)) : "-",
               goal_text(result.tried.goal), meets_goal(result) ? "yes" : "no");
  }
  fmt::print("Azimuth (or cross-elevation) and pitch (or elevation), the largest of the seeds.\n");
}

void write_node_tracking(const NodeTrackingSetup& setup, const std::vector<NodeTrackingResult>& results,
                         const std::string& git, const std::filesystem::path& file) {
  nlohmann::ordered_json json;
  json["generator"] = {
      {"program", "sim_host node-tracking"}, {"git", git}, {"plant", setup.plant.name}, {"seeds", setup.seeds}};
  json["cases"] = nlohmann::ordered_json::array();
  for (const NodeTrackingResult& result : results) {
    const NodeTrackingGoal& goal = result.tried.goal;
    nlohmann::ordered_json tried{{"name", result.tried.name},
                                 {"goal_urad", {goal.sigma_rad[0] / kUrad, goal.sigma_rad[1] / kUrad}},
                                 {"meets_goal", meets_goal(result)},
                                 {"runs", nlohmann::ordered_json::array()}};
    for (std::size_t i = 0; i < result.runs.size(); ++i) {
      const NodeTrackingRun& run = result.runs[i];
      nlohmann::ordered_json one{{"seed", setup.seeds[i]},
                                 {"azimuth_sigma_urad", run.sigma_rad[kAzimuth] / kUrad},
                                 {"pitch_sigma_urad", run.sigma_rad[kPitch] / kUrad},
                                 {"largest_step_nm", run.step_nm},
                                 {"frames_dropped", run.dropped}};
      if (result.tried.by_run) {
        one["azimuth_sigma_by_run_urad"] = run.run_sigma_rad[kAzimuth] / kUrad;
        one["pitch_sigma_by_run_urad"] = run.run_sigma_rad[kPitch] / kUrad;
      }
      tried["runs"].push_back(one);
    }
    json["cases"].push_back(tried);
  }
  write_json(json, file);
}

}  // namespace trackservo::sim
