// SPDX-License-Identifier: Apache-2.0
// The loop gain of an axis measured on the simulated machine, in the band that decides its margins.
#ifndef TRACKSERVO_SIM_ANALYSIS_MARGIN_MEASUREMENT_HPP
#define TRACKSERVO_SIM_ANALYSIS_MARGIN_MEASUREMENT_HPP

#include <cstdint>

#include "design/loop_margins.hpp"
#include "machine/base/firmware.hpp"

namespace trackservo::sim {

// Returns the loop gain around the crossover and the frequency that decides the gain margin, sliding at 2 deg/s or in
// pre-sliding. `computed` gives these frequencies. Takes 19 s of simulated time.
FrequencyResponse measured_near_crossover(const PlantConfig& plant, const servo_params& params, int axis,
                                          bool pre_sliding, const Margins& computed, std::uint64_t seed = 1,
                                          double pitch_rad = 0.0);

}  // namespace trackservo::sim

#endif
