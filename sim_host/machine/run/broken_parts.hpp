// SPDX-License-Identifier: Apache-2.0
// Injected faults of a simulated machine: the HAL's functions and the bridge read them.
//
// There is none by default. Faults are injected and removed between two ticks, through `Machine::broken`.
#ifndef TRACKSERVO_SIM_RUN_BROKEN_PARTS_HPP
#define TRACKSERVO_SIM_RUN_BROKEN_PARTS_HPP

#include <array>
#include <optional>

#include "machine/base/axis.hpp"
#include "machine/base/firmware.hpp"

namespace trackservo::sim {

// A sensor that is slow, stale or intermittent. Encoder and gyro are read once a tick, the converters once a PWM
// period. Shares are probabilities for each reading.
struct BadReadings {
  int late_readings = 0;     // each reading is so old
  int repeats = 1;           // only every so many readings a new one
  double lost_share = 0;     // no reading; a converter gives its last one
  double garbage_share = 0;  // any reading

  bool are_good() const { return late_readings == 0 && repeats == 1 && lost_share == 0.0 && garbage_share == 0.0; }
};

struct BrokenAxis {
  double encoder_shift_rad = 0;
  double encoder_creep_rad_s = 0;            // its reading walks away at this rate
  double encoder_stale_share = 0;            // of the readings: those of the tick before
  double encoder_bit_share = 0;              // of the readings: with a wrong bit 10 of 26
  std::optional<double> sensors_show_share;  // of the motion from now on: encoder and gyro alike; 0: frozen, with noise
  std::optional<double> gyro_reads_rad_s;
  double gyro_shift_rad_s = 0;
  std::optional<double> current_reads_a;
  double current_shift_a = 0;
  double motor_share = 1;  // of torque and back-EMF that its magnets still give
  double push_nm = 0;      // from outside, in the direction of positive angles
  BadReadings encoder;
  BadReadings gyro;
  BadReadings current;
  hal_health health = HAL_GOOD;
  bool encoder_lost = false;
  bool encoder_stuck = false;  // repeats its last reading
  bool encoder_reversed = false;
  bool gyro_lost = false;
  bool gyro_stuck = false;
  bool gyro_reversed = false;
  bool current_stuck = false;
  bool motor_reversed = false;           // its leads are swapped
  bool motor_open = false;               // one of them is off
  bool joint_held = false;               // an obstacle blocks the joint
  std::optional<bool> brake_reads_open;  // its contact
};

struct BrokenParts {
  std::array<BrokenAxis, kAxes> axis;
  std::optional<double> bus_reads_v;
  BadReadings bus;
  double bus_capacitor_share = 1;  // left of its capacitance
  double clock_error = 0;          // the firmware's clock is slow by this share; its tick then lasts longer
};

}  // namespace trackservo::sim

#endif
