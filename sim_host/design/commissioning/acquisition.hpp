// SPDX-License-Identifier: Apache-2.0
// Runs a test plan on a simulated machine and records it.
//
// These are the experiments of the device, in the firmware's own tick, without a bus and at full computer speed. The
// recording has the signals of the firmware: encoder, gyro, measured current; never the truth. The recording has no
// gap: moves between the places and rests between the experiments are included, as speed sweeps.
#ifndef TRACKSERVO_SIM_COMMISSIONING_ACQUISITION_HPP
#define TRACKSERVO_SIM_COMMISSIONING_ACQUISITION_HPP

#include <array>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "identification/recording.hpp"
#include "machine/base/firmware.hpp"
#include "machine/config/plant_config.hpp"
#include "test_plan/test_plan.hpp"

namespace trackservo::sim {

struct AcquisitionSetup {
  const PlantConfig *plant = nullptr;
  servo_params params{};  // of both axes, during the test plan
  int axis = kAzimuth;    // the axis that makes the experiments; the other one holds its place
  std::array<double, kAxes> start_angle_rad{};
  std::uint64_t seed = 1;
};

struct Acquisition {
  identification::Recording recording;
  std::vector<experiment> ended;  // each experiment at its end: its state, its break-away statistics
};

// An experiment was refused, or did not complete.
class ExperimentError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Throws ExperimentError, which names the experiment and the error. A break-away that wind takes beyond its limits ends
// there, and the test plan continues.
Acquisition acquire(const AcquisitionSetup& setup, const commissioning::TestPlan& test_plan);

}  // namespace trackservo::sim

#endif
