// SPDX-License-Identifier: Apache-2.0
// The record of one run: one row per 1 ms tick, both axes, SI units.
#ifndef TRACKSERVO_SIM_RUN_TRACE_HPP
#define TRACKSERVO_SIM_RUN_TRACE_HPP

#include <array>
#include <filesystem>
#include <vector>

#include "machine/base/firmware.hpp"

namespace trackservo::sim {

struct AxisRow {
  double reference_rad_s;      // inertial rate set-point
  double rate_rad_s;           // true inertial rate
  double measured_rate_rad_s;  // feedback of the controller
  double joint_rate_rad_s;     // true
  double joint_angle_rad;      // true
  double torque_nm;            // true motor torque
  double friction_nm;          // true
  double friction_feedforward_nm;
  double disturbance_estimate_nm;
  double load_nm;             // true wind, cable, imbalance, coupling
  double tracking_error_rad;  // true target - line of sight; 0 outside tracking
  double command_nm;          // torque command before any injected torque
  double injected_nm;         // torque added for a frequency response
};

struct TraceRow {
  double time_s;
  std::array<AxisRow, SERVO_AXES> axis;
};

using Trace = std::vector<TraceRow>;

struct CsvForm {
  int decimation = 1;  // every so many rows one (>= 1)
  int digits = 12;     // significant ones
};

// Writes the rows as CSV with units in the header. Throws std::runtime_error naming the file when it cannot be written.
void write_csv(const Trace& trace, const std::filesystem::path& file, const CsvForm& form = {});

}  // namespace trackservo::sim

#endif
