// SPDX-License-Identifier: Apache-2.0
// The same node on two machines with one difference: on one the firmware runs on the host, on the other the board's
// image runs on the emulated chip. Both are accessed over CAN alone.
#ifndef TRACKSERVO_TARGET_RIG_HPP
#define TRACKSERVO_TARGET_RIG_HPP

#include <cstdlib>
#include <string>
#include <vector>

#include "board/board_device.hpp"
#include "device/can_client.hpp"
#include "device/simulated_device.hpp"
#include "machine/run/trace.hpp"

namespace bench {

namespace sim = trackservo::sim;
namespace target = trackservo::target;
using sim::CanClient;

// The tick, after period 0 has begun: docs/board.md states it, test_board_wiring measures it.
constexpr double kTick_us = 24.0;

inline sim::PlantConfig tracker_plant() { return sim::load_plant("sim_host/plants/tracker.toml"); }

// The image in TARGET_IMAGE; it must have been built.
inline target::Image board_image() {
  const char *name = std::getenv("TARGET_IMAGE");
  return target::read_image(name != nullptr ? name : "TARGET_IMAGE is not set");
}

// The plant's motion, loads and friction, measured without noise: encoder, current and duty are still quantised.
inline sim::PlantConfig without_sensor_noise(sim::PlantConfig plant) {
  for (sim::AxisConfig& axis : plant.axis) {
    axis.encoder.jitter_rms_rad = 0.0;
    axis.gyro.noise_density_rad_s_rthz = 0.0;
  }
  plant.adc.current_noise_rms_a = 0.0;
  plant.adc.voltage_noise_rms_v = 0.0;
  return plant;
}

// Also without quantisation.
inline sim::PlantConfig without_quantisation(const sim::PlantConfig& plant) {
  constexpr int kFineEncoder_bits = 32;
  constexpr int kFineAdc_bits = 24;
  constexpr int kFinePwm_counts = 1'000'000;
  sim::PlantConfig fine = without_sensor_noise(plant);
  for (sim::AxisConfig& axis : fine.axis) {
    axis.encoder.resolution_bits = kFineEncoder_bits;
  }
  fine.adc.resolution_bits = kFineAdc_bits;
  fine.supply.pwm_counts = kFinePwm_counts;
  return fine;
}

// Board and host are two machines with the same wind and friction and with their own measuring errors. The effect of
// such errors on the motion is measured on the host: the rms s of its difference to a host without them. Two of them
// differ by s times the square root of two; the board's gyro is read at another time of the tick, hence 2 s.
constexpr double kMaxDifference = 2.0;

constexpr std::array<double, sim::kAxes> kStart_rad = {0.0, 20.0 * sim::kRadPerDeg};

class HostRig {
 public:
  explicit HostRig(const sim::PlantConfig& plant, std::uint64_t seed = 1,
                   const std::array<double, sim::kAxes>& joint_angle_rad = kStart_rad)
      : device_(plant, bus_, {seed, joint_angle_rad}) {}

  void pass_ms() { device_.pass_ms(); }
  sim::TruthState truth() const { return device_.truth(); }

 private:
  sim::VirtualBus bus_;
  sim::SimulatedDevice device_;

 public:
  CanClient client{bus_, [this] { pass_ms(); }};
};

class BoardRig {
 public:
  explicit BoardRig(const sim::PlantConfig& plant, std::uint64_t seed = 1, bool holding_brakes = false,
                    const std::array<double, sim::kAxes>& joint_angle_rad = kStart_rad)
      : machine(board_image(), plant, bus, {seed, joint_angle_rad, 11, holding_brakes}) {
    client.set_bit_rate(1e6);
  }

  void pass_ms() { machine.run(sim::kTick_s); }
  sim::TruthState truth() const { return machine.truth(); }

  sim::VirtualBus bus{1e6, sim::kPwmPeriod_s};
  target::BoardMachine machine;
  CanClient client{bus, [this] { pass_ms(); }};
};

}  // namespace bench

#endif
