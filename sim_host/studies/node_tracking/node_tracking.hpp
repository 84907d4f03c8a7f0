// Tracking in the running node: frames of the camera arrive as PDOs, and both axes are in mode -1. Beside it the same
// target in `sim_host run`, which hands the frames over without a bus.
//
//   fly-by    the paper's UAV (Fig. 16), with the paper's tracking loop and with the predictive one
//   pass      a straight pass at 20 m/s, 500 m up, with one loop for the line of sight
//   dropout   the fly-by, no frame shows the target from 20 s to 21 s: both axes coast, errors count from 0.5 s after
//   it
#ifndef TRACKSERVO_SIM_STUDIES_NODE_TRACKING_HPP
#define TRACKSERVO_SIM_STUDIES_NODE_TRACKING_HPP

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/job_pool.hpp"
#include "config/scenario_config.hpp"
#include "studies/shared/tracking_node.hpp"

namespace trackservo::sim {

// What every seed must meet.
struct NodeTrackingGoal {
  std::array<double, kAxes> sigma_rad{};
  std::optional<double> per_run;  // sigma, of that by run
  std::optional<double> step_nm;  // largest change of the torque in a tick
};

struct NodeTrackingCase {
  std::string name;
  ScenarioConfig scenario;
  target_tracker_params loop;
  NodeTrackingGoal goal;
  double count_from_s = 0;  // errors count from here on
  bool by_run = false;      // compared with run
};

struct NodeTrackingRun {
  std::array<double, kAxes> sigma_rad{};
  std::array<double, kAxes> run_sigma_rad{};  // by run; 0 without it
  double step_nm = 0;                         // largest change of the torque in a tick, from the settling time on
  std::uint32_t dropped = 0;                  // frames that did not count
};

struct NodeTrackingResult {
  NodeTrackingCase tried;
  std::vector<NodeTrackingRun> runs;  // one for each seed
};

struct NodeTrackingSetup {
  PlantConfig plant;
  std::vector<NodeTrackingCase> cases;
  std::vector<std::uint64_t> seeds{1, 2, 3, 4, 5};
  int threads = usable_threads();
};

// With the loops that are designed for this plant. `data_dir` has the scenarios.
std::vector<NodeTrackingCase> shipped_node_tracking(const PlantConfig& plant, const std::filesystem::path& data_dir);

NodeTrackingRun run_of(const NodeSetup& setup, const NodeTrackingCase& tried, std::uint64_t seed);

std::vector<NodeTrackingResult> run_node_tracking(const NodeTrackingSetup& setup,
                                                  const std::function<void(int, int, const std::string&)>& progress);

bool meets_goal(const NodeTrackingResult& result);

void print(const NodeTrackingSetup& setup, const std::vector<NodeTrackingResult>& results);

void write_node_tracking(const NodeTrackingSetup& setup, const std::vector<NodeTrackingResult>& results,
                         const std::string& git, const std::filesystem::path& file);

}  // namespace trackservo::sim

#endif
