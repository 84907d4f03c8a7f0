// SPDX-License-Identifier: Apache-2.0
// Tracking in the running node: frames of the camera arrive as PDOs, and both axes are in mode -1.
//
//   fly-by    the paper's UAV (Fig. 16), with the paper's tracking loop and with the predictive one
//   pass      a straight pass at 20 m/s, 500 m up, with one loop for the line of sight
//   lost      passes that no azimuth can follow: the time without the target beside the time-optimal plan's
//   dropout   the fly-by, no frame shows the target from 20 s to 21 s: both axes coast, errors count from 0.5 s after
//   it
//   evasion   a pass of a target that accelerates with 5 m/s2, in directions that change at random
//   ship      the fly-by on a base that moves with a spectrum: of a ship, of a vehicle; gyros on the line of sight, or
//             less, and then with and without the base's rates over CAN
//   delay     the fly-by from twice as far, 90 s; the stated age is 10 ms wrong, and the node corrects it
#ifndef TRACKSERVO_SIM_STUDIES_NODE_TRACKING_HPP
#define TRACKSERVO_SIM_STUDIES_NODE_TRACKING_HPP

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "device/tracking_node.hpp"
#include "machine/base/job_pool.hpp"
#include "machine/config/scenario_config.hpp"
#include "studies/shared/requirement.hpp"

namespace trackservo::sim {

inline constexpr double kUrad = 1e-6;

// What every seed must meet, besides that no frame is dropped.
struct NodeTrackingGoal {
  std::optional<std::array<double, kAxes>> sigma_rad;
  std::optional<double> per_reference;  // sigma, of that of frames with the right age
  std::optional<double> step_nm;        // largest change of the torque in a tick
  std::optional<double> lost_s;
};

struct NodeTrackingCase {
  std::string name;
  ScenarioConfig scenario;
  target_tracker_params loop;
  NodeTrackingGoal goal;
  double count_from_s = 0;                                 // errors count from here on
  std::vector<BaseSpectrum> base;                          // added to the plant
  FeedbackSource feedback = FeedbackSource::kGyro;         // of both axes, on that base
  GyroMounting azimuth_gyro = GyroMounting::kLineOfSight;  // likewise
  bool base_rates = false;                                 // a sensor on the base sends its rates (3076)
  double acceleration_rad_s2 = 0;                          // 6083 of both axes; 0: as delivered
  double misstated_s = 0;   // added to the age of each frame; the node corrects it (3073:1 = 2)
  double age_jitter_s = 0;  // largest error of a frame's age, another one for each frame
};

struct NodeTrackingRun {
  std::array<double, kAxes> sigma_rad{};
  std::array<double, kAxes> reference_sigma_rad{};  // with the right age; 0 where no goal asks for it
  double step_nm = 0;                               // largest change of the torque in a tick, from the settling time on
  double lost_s = 0;                                // LostTime, from the settling time on
  std::uint32_t dropped = 0;                        // frames that did not count
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

// Returns the cases with the loops that are designed for this plant. `data_dir` has the scenarios.
std::vector<NodeTrackingCase> shipped_node_tracking(const PlantConfig& plant, const std::filesystem::path& data_dir);

NodeTrackingRun run_of(const NodeSetup& still, const NodeTrackingCase& tried, std::uint64_t seed);

std::vector<NodeTrackingResult> run_node_tracking(const NodeTrackingSetup& setup,
                                                  const std::function<void(int, int, const std::string&)>& progress);

// Returns the goals of a case beside what was measured.
std::vector<Requirement> requirements_of(const NodeTrackingResult& result);

bool meets_goal(const NodeTrackingResult& result);

void print(const NodeTrackingSetup& setup, const std::vector<NodeTrackingResult>& results);

void write_node_tracking(const NodeTrackingSetup& setup, const std::vector<NodeTrackingResult>& results,
                         const std::string& git, const std::filesystem::path& file);

}  // namespace trackservo::sim

#endif
