// A node with an image processor on its bus, the simulated machine and the target of a scenario: for tests of tracking
// (mode -1) with frames that come as PDOs.
#ifndef TRACKSERVO_TESTS_CLOSED_LOOP_TRACKING_BENCH_HPP
#define TRACKSERVO_TESTS_CLOSED_LOOP_TRACKING_BENCH_HPP

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "design/control_design.hpp"
#include "fault_injection/driven_node.hpp"
#include "sensors/camera_sender.hpp"
#include "support/camera_on_bus.hpp"

namespace bench {

namespace sim = trackservo::sim;

constexpr std::int8_t kTracking = -1;
constexpr double kUrad = 1e-6;

inline const sim::NodeSetup& tracker_setup() {
  static const sim::NodeSetup tracker(sim::load_plant("sim_host/plants/tracker.toml"));
  return tracker;
}

inline sim::ScenarioConfig tracking_scenario() { return sim::load_scenario("sim_host/scenarios/tracking.toml"); }

// Of the default design, with this loop.
inline target_tracker_params designed_tracker(tracker_kind kind) {
  sim::DesignOptions design;
  design.tracker = kind;
  return sim::design_controller(tracker_setup().plant, sim::controller_spec("pi_vob_ftc"), design).axis[0].tracker;
}

// Standard deviation of both axes' errors.
struct Spread {
  void add(const std::array<double, sim::kAxes>& error_rad) {
    ++count;
    for (std::size_t i = 0; i < sim::kAxes; ++i) {
      const double change = error_rad[i] - mean[i];
      mean[i] += change / count;
      square[i] += change * (error_rad[i] - mean[i]);
    }
  }
  double urad(std::size_t axis) const { return std::sqrt(square[axis] / count) / kUrad; }

  int count = 0;
  std::array<double, sim::kAxes> mean{};
  std::array<double, sim::kAxes> square{};
};

inline void write_tracker(sim::DrivenNode& node, const target_tracker_params& tracker) {
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    node.write(axis, 0x2011, 1, tracker.kind);
    node.write_real(axis, 0x2011, 2, static_cast<double>(tracker.proportional_per_s));
    node.write_real(axis, 0x2011, 3, static_cast<double>(tracker.integral_per_s2));
    node.write_real(axis, 0x2011, 4, static_cast<double>(tracker.estimator_rad_s));
    node.write_real(axis, 0x2011, 5, static_cast<double>(tracker.coast_s));
    node.write(axis, 0x2070, 1, 1);
  }
}

// The node with an image processor on its bus, and the target of a scenario.
class TrackingBench {
 public:
  TrackingBench(const sim::ScenarioConfig& with, std::uint64_t seed, const target_tracker_params& tracker)
      : scenario_(with), camera_(with, seed), node_(tracker_setup(), seed, camera_.first_angle_rad()) {
    for (const sim::ObjectWrite& write : sim::camera_mapping(4, CameraOnBus::kId)) {
      node_.write(sim::kAzimuth, write.index, write.sub, write.value);
    }
    write_tracker(node_, tracker);
    node_.unlock();
    node_.write(sim::kAzimuth, 0x2061, 5, 0);  // it stands in this turn: a start beyond 75 deg may be in two
    for (int i = 0; i < 8; ++i) {
      node_.tick();
    }
    node_.receive(can_frame{0x000, 0, 2, {0x01, 0x00}});
    node_.enable(kTracking);
  }

  sim::DrivenNode& node() { return node_; }

  // What the image processor adds to the age of its frames: it does not know its own delay.
  void misstate_age(double by_s) { misstated_ = static_cast<int>(std::lround(by_s / 1e-5)); }

  double time_s() const { return node_.machine().truth().time_s; }

  std::array<double, sim::kAxes> error_rad() const { return camera_.error_rad(node_.machine().truth()); }

  void tick() {
    if (std::optional<can_frame> frame = camera_.look(node_.machine().truth())) {
      const int age = frame->data[4] + 256 * frame->data[5] + misstated_;
      frame->data[4] = static_cast<std::uint8_t>(age);
      frame->data[5] = static_cast<std::uint8_t>(age >> 8);
      node_.receive(*frame);
    }
    node_.tick();
  }

  // From the settling time of the scenario to its end.
  Spread track() {
    Spread spread;
    while (time_s() < scenario_.duration_s) {
      if (time_s() >= scenario_.settle_s) {
        spread.add(error_rad());
      }
      tick();
    }
    return spread;
  }

 private:
  sim::ScenarioConfig scenario_;
  CameraOnBus camera_;
  sim::DrivenNode node_;
  int misstated_ = 0;  // in the unit of a frame's time
};

}  // namespace bench

#endif
