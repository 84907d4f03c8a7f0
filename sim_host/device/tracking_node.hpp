// SPDX-License-Identifier: Apache-2.0
// The servo's node while it tracks: a simulated machine, an image processor that sends frames of a scenario's target,
// and both axes in mode -1.
#ifndef TRACKSERVO_SIM_DEVICE_TRACKING_NODE_HPP
#define TRACKSERVO_SIM_DEVICE_TRACKING_NODE_HPP

#include <array>
#include <cstdint>
#include <optional>

#include "device/driven_node.hpp"
#include "machine/base/random.hpp"
#include "machine/sensors/base_sensor.hpp"
#include "machine/target/target_camera.hpp"

namespace trackservo::sim {

// Returns the tracking loop of the default design for this plant.
target_tracker_params designed_tracking_loop(const PlantConfig& plant, tracker_kind kind);

// Maps the base sensor, takes it into use and declares that the base moves. Before start_tracking.
void use_base_rates(DrivenNode& node);

// Maps the camera and enables both axes in mode -1, with this tracking loop or with that of the node's set-up. Throws
// std::runtime_error when the node refuses.
void start_tracking(DrivenNode& node, const std::optional<target_tracker_params>& loop = std::nullopt);

class TrackingNode {
 public:
  // Starts the node on the first angles of the course and enables its axes in pp, as for a cue; then they change to
  // mode -1, and the course begins. An axis that does not take part in the scenario holds the rate 0. `setup` must
  // exist longer; `loop` replaces its tracking loop. `base_sensor`: an inertial sensor on the base sends its rates, and
  // the axes add what their gyros do not see of them. Throws std::runtime_error when the node refuses the loop or does
  // not enable its axes.
  TrackingNode(const NodeSetup& setup, const ScenarioConfig& scenario, std::uint64_t seed,
               const std::optional<target_tracker_params>& loop = std::nullopt, bool base_sensor = false);

  void tick();

  // Returns the time since the course began.
  double time_s() const { return truth().time_s; }

  // Returns the machine's state, with the time of the course.
  TruthState truth() const;

  // Returns target minus line of sight, as TargetCamera::error_rad.
  std::array<double, kAxes> error_rad() const { return camera_.error_rad(truth()); }

  // Sets what the image processor adds to the age of its frames: it does not know its own delay.
  void misstate_age(double by_s) { misstated_s_ = by_s; }

  // Sets the shares of the strobe's edges that do not come, of edges that nobody exposed (one per exposure at most),
  // and of frames that are lost on the bus.
  void disturb(double missing, double additional, double lost) { disturbance_ = {missing, additional, lost}; }

  DrivenNode& node() { return node_; }
  const DrivenNode& node() const { return node_; }

 private:
  void strobe();

  TargetCamera camera_;
  std::optional<BaseSensor> base_sensor_;
  DrivenNode node_;
  double misstated_s_ = 0;
  struct Disturbance {
    double missing = 0;
    double additional = 0;
    double lost = 0;
  };
  Disturbance disturbance_;
  RandomStream chance_;
  int ms_to_additional_ = 0;  // 0: none is due
};

}  // namespace trackservo::sim

#endif
