// SPDX-License-Identifier: Apache-2.0
#include "machine/sensors/camera_sender.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {
namespace {

constexpr double kCount_rad = 1e-6;
constexpr double kTime_s = 1e-5;
constexpr std::uint8_t kSure = 100;
constexpr std::uint16_t kFrameObject = 0x3070;

}  // namespace

can_frame CameraSender::frame_of(const CameraFrame& result) {
  can_frame frame{};
  frame.id = cob_id_;
  frame.length = 8;
  put_word(frame, 0, counts_of(result.error_rad[kAzimuth], kCount_rad));
  put_word(frame, 2, counts_of(result.error_rad[kPitch], kCount_rad));
  put_word(frame, 4, static_cast<std::uint16_t>(std::clamp(std::lround(result.delay_s / kTime_s), 0L, 65535L)));
  frame.data[6] = result.valid ? kSure : 0;
  frame.data[7] = ++counter_;
  return frame;
}

std::vector<ObjectWrite> camera_mapping(int number, std::uint32_t cob_id) {
  return sender_mapping(number, cob_id, kFrameObject, {16, 16, 16, 8, 8});
}

}  // namespace trackservo::sim
