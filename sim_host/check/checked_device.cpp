// SPDX-License-Identifier: Apache-2.0
#include "check/checked_device.hpp"

#include <fmt/format.h>

#include <cmath>

#include "device/simulated_device.hpp"

namespace trackservo::sim {
namespace {

constexpr int kCyclicVelocity = 9;
constexpr double kCountsPerRad_s = 1e6;
constexpr std::size_t kSourceByte = 4;  // of an EMCY: the axis + 1, or another source

}  // namespace

std::unique_ptr<Device> make_simulated_device(const PlantConfig& plant, VirtualBus& bus, std::uint64_t seed,
                                              const std::array<double, kAxes>& joint_angle_rad) {
  SimulatedDevice::Options options;
  options.seed = seed;
  options.joint_angle_rad = joint_angle_rad;
  options.setup = product_setup(plant);
  return std::make_unique<SimulatedDevice>(plant, bus, options);
}

CheckedDevice::CheckedDevice(const DeviceMaker& make, const PlantConfig& plant, std::uint64_t seed,
                             const std::array<double, kAxes>& joint_angle_rad)
    : device_(make(plant, bus_, seed, joint_angle_rad)),
      client_(bus_, [this] { device_->pass_ms(); }),
      ticks_(device_->settle()) {
  client_.start_node();
}

std::uint32_t CheckedDevice::write(std::uint16_t index, std::uint8_t sub, std::uint32_t bits, int bytes) {
  constexpr std::uint32_t kGeneralError = 0x08000000;
  return client_.write(index, sub, bits, bytes) ? 0 : client_.abort_code().value_or(kGeneralError);
}

bool CheckedDevice::enable() { return client_.enable(kCyclicVelocity); }

void CheckedDevice::command(const std::array<double, kAxes>& rate_rad_s) {
  const auto counts = [](double rate) { return static_cast<std::int32_t>(std::lround(kCountsPerRad_s * rate)); };
  client_.set_speeds(counts(rate_rad_s[kAzimuth]), counts(rate_rad_s[kPitch]));
}

std::optional<std::string> CheckedDevice::failure() const {
  for (const CanClient::Emergency& emergency : client_.emergencies()) {
    if (emergency.code != 0) {
      const int axis = emergency.bytes[kSourceByte] - 1;
      return fmt::format("{}fault {:04X}h",
                         axis == kAzimuth || axis == kPitch ? axis_name(axis) + std::string(": ") : "", emergency.code);
    }
  }
  return ticks_ ? device_->defect() : std::optional<std::string>("the image does not run its control task");
}

}  // namespace trackservo::sim
