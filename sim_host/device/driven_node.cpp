// SPDX-License-Identifier: Apache-2.0
#include "device/driven_node.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <stdexcept>
#include <string>

extern "C" {
#include "parameters/axis_dictionary.h"
#include "protection/access_lock.h"
}

namespace trackservo::sim {
namespace {

constexpr int kMaxTicksToEnable = 20;
constexpr std::int64_t kUnlocked = ACCESS_LOCK_WORD;
constexpr double kPositionCountsPerRad = 1e7;  // of positions

// ": azimuth has fault 7320h", or nothing.
std::string faults_text(const servo_node& node) {
  std::string text;
  for (int axis = 0; axis < kAxes; ++axis) {
    if (const std::uint16_t code = node.axis[axis].objects.state.error_code) {
      text += fmt::format("{}{} has fault {:04X}h", text.empty() ? ": " : ", ", axis_name(axis), code);
    }
  }
  return text;
}

}  // namespace

DrivenNode::DrivenNode(const NodeSetup& setup, std::uint64_t seed, const std::array<double, kAxes>& joint_angle_rad,
                       const NodeFittings& fittings)
    : simulated_(setup, seed, joint_angle_rad, fittings) {
  tick();  // it boots, and receives nothing before
}

void DrivenNode::tick() {
  if (speaks_) {
    canopen_node_heard(&node().canopen);
  }
  simulated_.tick();
}

// As an SDO server does: a command that is pending is called again in each tick.
bool DrivenNode::is_written(const od_object& object, const std::uint8_t *bytes) {
  for (;;) {
    node().canopen.sdo_client = 0;  // whose lock it is (0x3040)
    const od_abort answer = od_write(&object, bytes, object.entry->bytes);
    node().canopen.sdo_client = SDO_CHANNELS;
    if (answer != OD_PENDING) {
      return answer == OD_OK;
    }
    tick();
  }
}

void DrivenNode::write(int axis, std::uint16_t index, std::uint8_t sub, std::int64_t value) {
  const bool of_axis = index >= 0x2000 && (index < 0x3000 || index >= 0x6000);
  const std::uint16_t shifted = static_cast<std::uint16_t>(index + (of_axis && axis == kPitch ? AXIS_INDEX_SHIFT : 0));
  od_object object;
  std::uint8_t bytes[8];
  for (int i = 0; i < 8; ++i) {
    bytes[i] = static_cast<std::uint8_t>(static_cast<std::uint64_t>(value) >> (8 * i));
  }
  const bool written =
      od_find(servo_node_dictionary(&node()), shifted, sub, &object) == OD_OK && is_written(object, bytes);
  if (!written) {
    throw std::runtime_error(fmt::format("the node refuses {} in 0x{:04X}:{}", value, shifted, sub));
  }
}

void DrivenNode::write_real(int axis, std::uint16_t index, std::uint8_t sub, double value) {
  const auto real = static_cast<float>(value);
  std::uint32_t bits = 0;
  std::memcpy(&bits, &real, sizeof bits);
  write(axis, index, sub, bits);
}

void DrivenNode::unlock() { write(kAzimuth, 0x3040, 1, kUnlocked); }

void DrivenNode::enable(const std::array<std::int8_t, kAxes>& modes) {
  for (int axis = 0; axis < kAxes; ++axis) {
    write(axis, 0x6060, 0, modes[static_cast<std::size_t>(axis)]);
  }
  for (int tick = 0; tick < kMaxTicksToEnable; ++tick) {
    bool enabled = true;
    for (int axis = 0; axis < kAxes; ++axis) {
      const drive_power_state power = node().axis[axis].drive.state.power;
      write(axis, 0x6040, 0, power == DRIVE_SWITCH_ON_DISABLED ? 0x06 : 0x0F);
      enabled = enabled && power == DRIVE_OPERATION_ENABLED;
    }
    if (enabled) {
      for (int axis = 0; axis < kAxes; ++axis) {
        wanted_rad_[static_cast<std::size_t>(axis)] = node().axis[axis].objects.position.actual / kPositionCountsPerRad;
      }
      return;
    }
    this->tick();
  }
  throw std::runtime_error("the axes are not enabled after 20 ticks" + faults_text(node()) + ".");
}

void DrivenNode::set_rate(int axis, double rate_rad_s) {
  write(axis, 0x60FF, 0, static_cast<std::int64_t>(rate_rad_s * 1e6));
}

void DrivenNode::move(int axis, double rate_rad_s) {
  if (node().axis[axis].objects.state.mode != DRIVE_CYCLIC_POSITION) {
    set_rate(axis, rate_rad_s);
    return;
  }
  double& wanted_rad = wanted_rad_[static_cast<std::size_t>(axis)];
  wanted_rad += rate_rad_s * kTick_s;
  write(axis, 0x607A, 0, std::llround(wanted_rad * kPositionCountsPerRad));
}

}  // namespace trackservo::sim
