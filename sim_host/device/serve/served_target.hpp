// SPDX-License-Identifier: Apache-2.0
// A target in front of a served machine, and who observes it: `sim_host serve --target SCENARIO`.
//
// The target waits at the scenario's start until an axis follows it (3072:5 or :6 is 2 or more). Then it flies for
// `duration_s`, and disappears. When no axis is in mode -1 any more, it waits at the start again. So every client that
// connects finds it, whenever it comes.
//
// An observer sees the scene in every tick of 1 ms. make_observer() decides who turns it into frames of a camera.
#ifndef TRACKSERVO_SIM_SERVE_SERVED_TARGET_HPP
#define TRACKSERVO_SIM_SERVE_SERVED_TARGET_HPP

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "device/bus/virtual_bus.hpp"
#include "device/serve/scene.hpp"
#include "machine/config/scenario_config.hpp"
#include "machine/plant/truth.hpp"
#include "machine/sensors/camera_sender.hpp"
#include "machine/target/fly_by.hpp"
#include "machine/target/target_camera.hpp"

namespace trackservo::sim {

struct TargetOptions {
  std::optional<ScenarioConfig> scenario;      // none: no target and no camera
  std::uint32_t camera_cob_id = kCameraCobId;  // of the first node, the others count up
  std::string video;                           // "pgm-tcp:PORT": pictures instead of the camera's frames; empty: none
  std::filesystem::path truth_csv;  // the true error of the line of sight in every tick of a flight; empty: none
};

// Makes frames of a camera from the scene and sends them onto the bus; calls `strobe` at each exposure.
std::unique_ptr<SceneObserver> make_observer(const CameraConfig& camera, std::uint64_t seed, VirtualBus& bus,
                                             std::uint32_t cob_id, std::function<void()> strobe);

class ServedTarget {
 public:
  // Throws std::invalid_argument for a scenario without a target or a wrong address of the pictures, std::runtime_error
  // for a file that cannot be written or a port that cannot be opened.
  ServedTarget(const TargetOptions& options, std::uint64_t seed, VirtualBus& bus, std::function<void()> strobe);

  // Returns the address of the pictures; empty without them.
  const std::string& video_address() const { return video_address_; }

  // Call after each tick of the machine; `tracking`: states of both axes as 3072:5 and :6.
  void tick(const TruthState& truth, const std::array<std::uint8_t, kAxes>& tracking);

 private:
  Scene scene_of(const TruthState& truth) const;

  ScenarioConfig scenario_;
  FlyBy target_;
  std::optional<double> started_s_;
  std::string video_address_;
  std::vector<std::unique_ptr<SceneObserver>> observers_;
};

}  // namespace trackservo::sim

#endif
