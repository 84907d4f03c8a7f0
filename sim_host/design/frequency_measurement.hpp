// SPDX-License-Identifier: Apache-2.0
// The loop gain as an engineer measures it on the machine: a multisine torque is added behind the controller while the
// axis turns at constant rate (or rests). Noise, friction, quantisation and coupling stay as they are.
//
//     L(jw) = -U_controller / (U_controller + U_injected)
#ifndef TRACKSERVO_SIM_ANALYSIS_FREQUENCY_MEASUREMENT_HPP
#define TRACKSERVO_SIM_ANALYSIS_FREQUENCY_MEASUREMENT_HPP

#include <cstdint>

#include "gain_design/loop_gain.hpp"
#include "machine/base/firmware.hpp"
#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

struct MeasurementRequest {
  const PlantConfig *plant = nullptr;
  servo_params params{};
  int axis = 0;
  double pitch_rad = 0.0;        // the pitch joint rests there when it starts
  double bias_rate_rad_s = 0.0;  // constant set-point during the measurement
  double torque_rms_nm = 0.0;    // of the whole multisine
  double first_hz = 0.5;         // multiples of 0.25 Hz are excited, about logarithmically spaced
  double last_hz = 250.0;
  std::uint64_t seed = 1;
};

// Takes 3 s to settle and 16 s to measure, in simulated time.
gain_design::FrequencyResponse measured_loop_gain(const MeasurementRequest& request);

}  // namespace trackservo::sim

#endif
