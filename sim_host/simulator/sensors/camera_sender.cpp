#include "sensors/camera_sender.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {
namespace {

constexpr double kCount_rad = 1e-6;
constexpr double kTime_s = 1e-5;
constexpr std::uint8_t kSure = 100;
constexpr std::uint32_t kNotValid = 0x80000000;
constexpr std::uint16_t kFrameObject = 0x3070;

std::uint16_t counts_of(double error_rad) {
  return static_cast<std::uint16_t>(
      static_cast<std::int16_t>(std::clamp(std::lround(error_rad / kCount_rad), -32767L, 32767L)));
}

void put(can_frame& frame, std::size_t at, std::uint16_t value) {
  frame.data[at] = static_cast<std::uint8_t>(value);
  frame.data[at + 1] = static_cast<std::uint8_t>(value >> 8);
}

}  // namespace

can_frame CameraSender::frame_of(const CameraFrame& result) {
  can_frame frame{};
  frame.id = cob_id_;
  frame.length = 8;
  put(frame, 0, counts_of(result.error_rad[kAzimuth]));
  put(frame, 2, counts_of(result.error_rad[kPitch]));
  put(frame, 4, static_cast<std::uint16_t>(std::clamp(std::lround(result.delay_s / kTime_s), 0L, 65535L)));
  frame.data[6] = result.valid ? kSure : 0;
  frame.data[7] = ++counter_;
  return frame;
}

std::array<ObjectWrite, 9> camera_mapping(int number, std::uint32_t cob_id) {
  const auto parameters = static_cast<std::uint16_t>(0x1400 + number - 1);
  const auto mapping = static_cast<std::uint16_t>(0x1600 + number - 1);
  std::array<ObjectWrite, 9> writes{ObjectWrite{parameters, 1, kNotValid | cob_id}, ObjectWrite{mapping, 0, 0}};
  constexpr std::array<std::uint32_t, 5> kBits{16, 16, 16, 8, 8};
  for (std::size_t i = 0; i < kBits.size(); ++i) {
    const auto sub = static_cast<std::uint8_t>(i + 1);
    writes[i + 2] = {mapping, sub, std::uint32_t{kFrameObject} << 16 | std::uint32_t{sub} << 8 | kBits[i]};
  }
  writes[7] = {mapping, 0, 5};
  writes[8] = {parameters, 1, cob_id};
  return writes;
}

}  // namespace trackservo::sim
