// SPDX-License-Identifier: Apache-2.0
// A target and the camera that looks at it, for those who observe them in every tick of 1 ms.
#ifndef TRACKSERVO_SIM_SERVE_SCENE_HPP
#define TRACKSERVO_SIM_SERVE_SCENE_HPP

#include <Eigen/Core>
#include <optional>

#include "machine/sensors/picture.hpp"

namespace trackservo::sim {

inline constexpr double kSceneTolerance_s = 1e-9;  // sums of ticks do not match times exactly

struct Scene {
  double time_s = 0;               // of the machine
  std::optional<double> flight_s;  // since the target's start; none while it waits
  bool visible = true;             // false: in a dropout of the scenario, or the flight has ended
  Eigen::Vector3d target_m;        // from the camera, in the ground's frame
  PicturePose pose;                // true joints and base
};

class SceneObserver {
 public:
  SceneObserver() = default;
  SceneObserver(const SceneObserver&) = delete;
  SceneObserver& operator=(const SceneObserver&) = delete;
  virtual ~SceneObserver() = default;

  virtual void observe(const Scene& scene) = 0;
};

}  // namespace trackservo::sim

#endif
