// SPDX-License-Identifier: Apache-2.0
#include "machine_variables.hpp"

#include <cmath>
#include <stdexcept>

#include "machine/run/scenario_check.hpp"

namespace trackservo::fmi {

std::string of_axis(std::size_t axis, const char *name) {
  return std::string(sim::axis_name(static_cast<int>(axis))) + "." + name;
}

void MachineChoice::add_to(std::vector<Variable>& variables) {
  variables.push_back({"plant_file", Causality::kParameter, "",
                       "Plant file; a name without a folder is one of those in the unit: tracker.toml, "
                       "paper_simulation.toml, bench_motor.toml; a relative path is that of the importer's folder",
                       &plant_file});
  variables.push_back({"seed", Causality::kParameter, "", "Seed of all noise; equal seeds give equal runs", &seed});
  for (std::size_t i = 0; i < sim::kAxes; ++i) {
    variables.push_back({of_axis(i, "start_angle_rad"), Causality::kParameter, "rad",
                         "Joint angle at the beginning, at rest", &start_angle_rad[i]});
  }
}

sim::PlantConfig MachineChoice::plant(const std::filesystem::path& resources) const {
  const std::filesystem::path file = plant_file;
  sim::PlantConfig plant = sim::load_plant(file.has_parent_path() ? file : resources / "plants" / file);
  for (std::size_t i = 0; i < sim::kAxes; ++i) {
    if (const auto problem = sim::start_problem(plant, static_cast<int>(i), start_angle_rad[i])) {
      throw std::invalid_argument(of_axis(i, "start_angle_rad") + ": " + *problem + "; start between these angles.");
    }
  }
  return plant;
}

void MachineTruth::add_to(std::vector<Variable>& variables) {
  for (std::size_t i = 0; i < sim::kAxes; ++i) {
    const auto add = [&variables, i](const char *name, const char *unit, const char *description, auto *value) {
      variables.push_back({of_axis(i, name), Causality::kOutput, unit, description, value});
    };
    add("joint_angle_rad", "rad", "True joint angle, not wrapped", &axis[i].joint_angle_rad);
    add("joint_rate_rad_s", "rad/s", "True joint rate", &axis[i].joint_rate_rad_s);
    add("inertial_rate_rad_s", "rad/s", "True inertial rate: joint rate and sway of the base",
        &axis[i].inertial_rate_rad_s);
    add("motor_torque_nm", "N.m", "True torque of the motor, mean of the last PWM period", &axis[i].motor_torque_nm);
    add("friction_torque_nm", "N.m", "True friction torque, positive against forward motion",
        &axis[i].friction_torque_nm);
    add("load_torque_nm", "N.m",
        "True torque of wind, cable, imbalance, coupling, end stop and from outside, with friction's sign",
        &axis[i].load_torque_nm);
    add("motor_current_a", "A", "True motor current", &axis[i].motor_current_a);
  }
  variables.push_back({"bus_voltage_v", Causality::kOutput, "V", "True voltage of the DC bus", &bus_voltage_v});
}

void MachineTruth::renew(const sim::TruthState& truth) {
  for (std::size_t i = 0; i < sim::kAxes; ++i) {
    axis[i] = {truth.joint_angle_rad[i], truth.joint_rate_rad_s[i],   truth.inertial_rate_rad_s[i],
               truth.motor_torque_nm[i], truth.friction_torque_nm[i], truth.load_torque_nm[i],
               truth.current_a[i]};
  }
  bus_voltage_v = truth.bus_voltage_v;
}

void AxisReadings::add_to(std::vector<Variable>& variables, const std::string& axis) {
  variables.push_back({axis + ".encoder_angle_rad", Causality::kOutput, "rad",
                       "Reading of the encoder, within half a turn; new each 1 ms", &encoder_angle_rad});
  variables.push_back(
      {axis + ".gyro_rate_rad_s", Causality::kOutput, "rad/s", "Reading of the gyro; new each 1 ms", &gyro_rate_rad_s});
  variables.push_back(
      {axis + ".gyro_valid", Causality::kOutput, "", "Whether the gyro's reading is good", &gyro_valid});
}

void AxisReadings::renew(const hal_axis_samples& samples) {
  const auto turn32 = static_cast<std::int32_t>(samples.joint_angle_turn32);
  encoder_angle_rad = std::ldexp(2.0 * sim::kPi * static_cast<double>(turn32), -32);
  gyro_rate_rad_s = static_cast<double>(samples.gyro_rad_s);
  gyro_valid = samples.gyro_valid;
}

}  // namespace trackservo::fmi
