// SPDX-License-Identifier: Apache-2.0
// What both units tell of the simulated machine, and how it is chosen.
#ifndef TRACKSERVO_FMI_MACHINE_VARIABLES_HPP
#define TRACKSERVO_FMI_MACHINE_VARIABLES_HPP

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "machine/config/plant_config.hpp"
#include "machine/plant/truth.hpp"
#include "unit.hpp"

namespace trackservo::fmi {

// The parameters of the machine.
struct MachineChoice {
  std::string plant_file = "tracker.toml";
  std::uint64_t seed = 1;
  std::array<double, sim::kAxes> start_angle_rad{};

  void add_to(std::vector<Variable>& variables);

  // Reads the plant file, and checks the start. A name without a folder is one of those in `resources`/plants. Throws
  // std::exception.
  sim::PlantConfig plant(const std::filesystem::path& resources) const;
};

// The true state.
struct MachineTruth {
  struct Axis {
    double joint_angle_rad = 0;
    double joint_rate_rad_s = 0;
    double inertial_rate_rad_s = 0;
    double motor_torque_nm = 0;
    double friction_torque_nm = 0;
    double load_torque_nm = 0;
    double motor_current_a = 0;
  };
  std::array<Axis, sim::kAxes> axis;
  double bus_voltage_v = 0;

  void add_to(std::vector<Variable>& variables);
  void renew(const sim::TruthState& truth);
};

// The readings that electronics have of an axis.
struct AxisReadings {
  double encoder_angle_rad = 0;
  double gyro_rate_rad_s = 0;
  bool gyro_valid = true;

  void add_to(std::vector<Variable>& variables, const std::string& axis);
  void renew(const hal_axis_samples& samples);
};

// Bounds of inputs: beyond what any such machine has.
constexpr double kRateBound_rad_s = 100.0;
constexpr double kAccelerationBound_rad_s2 = 1e5;
constexpr double kTorqueBound_nm = 1e5;

// Returns the name of a variable of an axis: azimuth.joint_angle_rad.
std::string of_axis(std::size_t axis, const char *name);

}  // namespace trackservo::fmi

#endif
