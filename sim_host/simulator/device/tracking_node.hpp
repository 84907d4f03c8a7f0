// SPDX-License-Identifier: Apache-2.0
// The servo's node while it tracks: a simulated machine, an image processor that sends frames of a scenario's target,
// and both axes in mode -1.
#ifndef TRACKSERVO_SIM_STUDIES_TRACKING_NODE_HPP
#define TRACKSERVO_SIM_STUDIES_TRACKING_NODE_HPP

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/random.hpp"
#include "device/driven_node.hpp"
#include "sensors/base_sensor.hpp"
#include "target/target_camera.hpp"

namespace trackservo::sim {

// Standard deviation of both axes' errors.
class ErrorSpread {
 public:
  void add(const std::array<double, kAxes>& error_rad);
  // 0 before the first error.
  std::array<double, kAxes> sigma_rad() const;
  double sigma_urad(std::size_t axis) const { return 1e6 * sigma_rad()[axis]; }

 private:
  int count_ = 0;
  std::array<double, kAxes> mean_rad_{};
  std::array<double, kAxes> squares_rad2_{};
};

// The tracking loop of the default design for this plant.
target_tracker_params designed_tracking_loop(const PlantConfig& plant, tracker_kind kind);

// Base sensor mapped and in use, the base declared to move. Before start_tracking.
void use_base_rates(DrivenNode& node);

// Camera mapped, loop in force, both axes enabled in mode -1. Throws std::runtime_error when the node refuses.
void start_tracking(DrivenNode& node, const target_tracker_params& loop);

class TrackingNode {
 public:
  // Enabled, on the first angles of the course; `setup` must exist longer. Throws std::runtime_error when the node
  // refuses the loop or does not enable its axes. `base_sensor`: an inertial sensor on the base sends its rates, and
  // the axes add what their gyros do not see of them.
  TrackingNode(const NodeSetup& setup, const ScenarioConfig& scenario, std::uint64_t seed,
               const target_tracker_params& loop, bool base_sensor = false);

  void tick();

  double time_s() const { return node_.machine().truth().time_s; }
  // Target minus line of sight, as TargetCamera::error_rad.
  std::array<double, kAxes> error_rad() const { return camera_.error_rad(node_.machine().truth()); }

  // What the image processor adds to the age of its frames: it does not know its own delay.
  void misstate_age(double by_s) { misstated_s_ = by_s; }

  // Shares of the strobe's edges that do not come, of edges that nobody exposed (one per exposure at most), and of
  // frames that are lost on the bus.
  void disturb(double missing, double additional, double lost) { disturbance_ = {missing, additional, lost}; }

  DrivenNode& node() { return node_; }

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
