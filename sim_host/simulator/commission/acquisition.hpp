// A programme of experiments on a simulated machine, and what was recorded.
//
// The very experiments that run on the device, in the firmware's own tick, without a bus and as fast as the computer
// goes. What is recorded is what the firmware sees: encoder, gyro, measured current; never the truth. The recording has
// no gap: moves between the places and rests between the experiments are in it, as speed sweeps.
#ifndef TRACKSERVO_SIM_COMMISSION_ACQUISITION_HPP
#define TRACKSERVO_SIM_COMMISSION_ACQUISITION_HPP

#include <array>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "base/firmware.hpp"
#include "config/plant_config.hpp"
#include "identification/recording.hpp"
#include "test_plan/test_plan.hpp"

namespace trackservo::sim {

struct AcquisitionSetup {
  const PlantConfig *plant = nullptr;
  servo_params params{};  // of both axes, while it lasts
  int axis = kAzimuth;    // makes the experiments; the other one holds its place
  std::array<double, kAxes> start_angle_rad{};
  std::uint64_t seed = 1;
};

struct Acquisition {
  identification::Recording recording;
  std::vector<experiment> ended;  // each experiment as it was when over: its state, its break-away statistics
};

// An experiment was refused, or did not come to its end.
class ExperimentError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Throws ExperimentError, which names the experiment and says what was wrong with it. A break-away that wind takes
// beyond its limits ends there, and the programme goes on.
Acquisition acquire(const AcquisitionSetup& setup, const commissioning::Programme& programme);

}  // namespace trackservo::sim

#endif
