// The experiments of firmware/commissioning on a simulated machine, one after the other, and what was recorded.
//
// The very experiments that run on the device, on the firmware's own tick, without a bus and as fast as the computer
// goes. What is recorded is what the firmware sees: encoder, gyro, measured current; never the truth.
#ifndef TRACKSERVO_SIM_COMMISSIONING_ACQUISITION_HPP
#define TRACKSERVO_SIM_COMMISSIONING_ACQUISITION_HPP

#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include "plant/tracker.hpp"
#include "run/firmware.hpp"

extern "C" {
#include "commissioning/experiment.h"
}

namespace trackservo::sim {

struct PlannedExperiment {
  stimulus_setup setup;
  experiment_limits limits;
};

struct RecordedTick {
  double time_s;  // of the machine, all experiments together
  int run;        // which experiment, from 1
  stimulus_kind kind;
  double joint_angle_rad;      // unwrapped
  double joint_rate_rad_s;     // the firmware's estimate
  double inertial_rate_rad_s;  // the gyro; NaN where there is none
  double torque_nm;            // Kt times the mean current since the last tick
  double reference;            // rad/s; rad in hysteresis loops; Nm in torque ramps and break-away
};

struct Recording {
  std::vector<RecordedTick> ticks;
  std::vector<experiment> ended;  // each experiment as it was when over: its state, its break-away statistics
};

// An experiment was refused, or did not come to its end.
class ExperimentError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Both axes are controlled with `params`; `axis` makes the experiments, the other one stands. Each begins at rest, at
// the joint angle that the axis has then; the first at `start_angle_rad`. Throws ExperimentError, which names the
// experiment and says what was wrong with it.
Recording run_experiments(const PlantConfig& plant, const servo_params& params, int axis,
                          const std::array<double, kAxes>& start_angle_rad, const std::vector<PlannedExperiment>& plan,
                          std::uint64_t seed);

// One row per tick: time_s, run, kind, joint_angle_rad, joint_rate_rad_s, inertial_rate_rad_s, torque_nm, reference.
// Throws std::runtime_error naming the file when it cannot be written.
void write_recording(const Recording& recording, const std::filesystem::path& file);

}  // namespace trackservo::sim

#endif
