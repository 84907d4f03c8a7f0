// SPDX-License-Identifier: Apache-2.0
#include "check/host_device.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace trackservo::sim {
namespace {

constexpr std::uint16_t kTargetVelocity = 0x60FF;
constexpr double kCountsPerRad_s = 1e6;

}  // namespace

HostDevice::HostDevice(const PlantConfig& plant, std::uint64_t seed, const std::array<double, kAxes>& joint_angle_rad)
    : setup_(product_setup(plant)), node_(setup_, seed, joint_angle_rad) {}

std::uint32_t HostDevice::write(std::uint16_t index, std::uint8_t sub, std::uint32_t bits, int bytes) {
  std::uint8_t data[4];
  for (int i = 0; i < 4; ++i) {
    data[i] = static_cast<std::uint8_t>(bits >> (8 * i));
  }
  od_object object;
  const od_abort found = od_find(servo_node_dictionary(&node_.node()), index, sub, &object);
  node_.node().canopen.sdo_client = 0;  // whose lock it is (0x3040)
  od_abort answer = found != OD_OK ? found : od_write(&object, data, static_cast<std::uint16_t>(bytes));
  while (answer == OD_PENDING) {  // each call does a slice of the work; no time passes, so that equal seeds stay equal
    answer = od_write(&object, data, static_cast<std::uint16_t>(bytes));
  }
  node_.node().canopen.sdo_client = SDO_CHANNELS;
  return answer;
}

std::optional<std::uint32_t> HostDevice::read(std::uint16_t index, std::uint8_t sub) {
  std::uint8_t bytes[4] = {};
  std::uint16_t length = 0;
  od_object object;
  if (od_find(servo_node_dictionary(&node_.node()), index, sub, &object) != OD_OK ||
      od_read(&object, bytes, sizeof bytes, &length) != OD_OK) {
    return std::nullopt;
  }
  std::uint32_t bits = 0;
  for (int i = 3; i >= 0; --i) {
    bits = bits << 8 | bytes[i];
  }
  return bits;
}

bool HostDevice::enable() {
  try {
    node_.enable(DRIVE_CYCLIC_VELOCITY);
  } catch (const std::runtime_error&) {
    return false;
  }
  return true;
}

void HostDevice::command(const std::array<double, kAxes>& rate_rad_s) {
  for (int axis = 0; axis < kAxes; ++axis) {
    node_.write(axis, kTargetVelocity, 0, std::llround(kCountsPerRad_s * rate_rad_s[static_cast<std::size_t>(axis)]));
  }
}

double HostDevice::torque_command_nm(int axis) const {
  return static_cast<double>(node_.machine().firmware(axis).signals.torque.torque_nm);
}

std::optional<std::string> HostDevice::failure() {
  for (int axis = 0; axis < kAxes; ++axis) {
    const std::uint16_t code = node_.axis(axis).objects.state.error_code;
    if (code != 0 || node_.axis(axis).drive.state.power != DRIVE_OPERATION_ENABLED) {
      return fmt::format("{}: fault {:04X}h", axis_name(axis), code);
    }
  }
  return std::nullopt;
}

std::unique_ptr<CheckedDevice> make_host_device(const PlantConfig& plant, std::uint64_t seed,
                                                const std::array<double, kAxes>& joint_angle_rad) {
  return std::make_unique<HostDevice>(plant, seed, joint_angle_rad);
}

}  // namespace trackservo::sim
