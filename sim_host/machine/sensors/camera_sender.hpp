// SPDX-License-Identifier: Apache-2.0
// The image processor's end of the bus: a result of the camera as the frame of one PDO (objects 3070:1 to :5).
//
// Errors count 1 urad (3071:1 as by default), beyond +-32.767 mrad they are clipped. The time is the age of the
// exposure (3071:5 = 0). The quality is 100 for a target that was found.
#ifndef TRACKSERVO_SIM_SENSORS_CAMERA_SENDER_HPP
#define TRACKSERVO_SIM_SENSORS_CAMERA_SENDER_HPP

#include <cstdint>
#include <vector>

#include "machine/sensors/camera.hpp"
#include "machine/sensors/sender_mapping.hpp"

extern "C" {
#include "base/can_frame.h"
}

namespace trackservo::sim {

class CameraSender {
 public:
  // Takes `cob_id` of the frame, as in 140x:1.
  explicit CameraSender(std::uint32_t cob_id) : cob_id_(cob_id) {}

  // Returns the next frame; each call is one more of its counter.
  can_frame frame_of(const CameraFrame& result);

 private:
  std::uint32_t cob_id_;
  std::uint8_t counter_ = 0;
};

// Returns what a master writes so that RPDO `number` (1 to 4) takes these frames.
std::vector<ObjectWrite> camera_mapping(int number, std::uint32_t cob_id);

}  // namespace trackservo::sim

#endif
