// SPDX-License-Identifier: Apache-2.0
// The firmware compiled into this program, on the simulated machine, with the start gains of a device.
#ifndef TRACKSERVO_SIM_CHECK_HOST_DEVICE_HPP
#define TRACKSERVO_SIM_CHECK_HOST_DEVICE_HPP

#include "check/device.hpp"
#include "device/driven_node.hpp"

namespace trackservo::sim {

class HostDevice : public CheckedDevice {
 public:
  HostDevice(const PlantConfig& plant, std::uint64_t seed, const std::array<double, kAxes>& joint_angle_rad);

  std::uint32_t write(std::uint16_t index, std::uint8_t sub, std::uint32_t bits, int bytes) override;
  std::optional<std::uint32_t> read(std::uint16_t index, std::uint8_t sub) override;
  bool enable() override;
  void command(const std::array<double, kAxes>& rate_rad_s) override;
  void disturb(int axis, double torque_nm) override { node_.machine().inject_torque(axis, torque_nm); }
  bool can_disturb() const override { return true; }
  void pass_ms() override { node_.tick(); }
  TruthState truth() const override { return node_.machine().truth(); }
  int set_point_delay_ms() const override { return kSetPointDelay_ms; }
  double torque_command_nm(int axis) const override;
  std::optional<std::string> failure() override;

  DrivenNode& node() { return node_; }

 private:
  // One of interpolation: 60FF is written before the tick that uses it.
  static constexpr int kSetPointDelay_ms = 1;

  NodeSetup setup_;
  mutable DrivenNode node_;
};

// A maker of HostDevice.
std::unique_ptr<CheckedDevice> make_host_device(const PlantConfig& plant, std::uint64_t seed,
                                                const std::array<double, kAxes>& joint_angle_rad);

}  // namespace trackservo::sim

#endif
