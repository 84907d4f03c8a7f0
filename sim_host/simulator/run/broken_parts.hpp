// Injected faults of a simulated machine: the HAL's functions and the bridge read them.
//
// There is none by default. Faults are injected and removed between two ticks, through `Machine::broken`.
#ifndef TRACKSERVO_SIM_RUN_BROKEN_PARTS_HPP
#define TRACKSERVO_SIM_RUN_BROKEN_PARTS_HPP

#include <array>
#include <optional>

#include "base/axis.hpp"
#include "base/firmware.hpp"

namespace trackservo::sim {

struct BrokenAxis {
  bool encoder_lost = false;
  bool encoder_stuck = false;  // repeats its last reading
  bool encoder_reversed = false;
  double encoder_shift_rad = 0;
  bool gyro_lost = false;
  bool gyro_stuck = false;
  bool gyro_reversed = false;
  std::optional<double> gyro_reads_rad_s;
  std::optional<double> current_reads_a;
  bool current_stuck = false;
  double current_shift_a = 0;
  bool motor_reversed = false;  // its leads are swapped
  bool motor_open = false;      // one of them is off
  bool joint_held = false;      // an obstacle blocks the joint
  double push_nm = 0;           // from outside, in the direction of positive angles
  hal_health health = HAL_GOOD;
};

struct BrokenParts {
  std::array<BrokenAxis, kAxes> axis;
  std::optional<double> bus_reads_v;
};

}  // namespace trackservo::sim

#endif
