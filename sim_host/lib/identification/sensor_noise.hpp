// SPDX-License-Identifier: Apache-2.0
// Noise of a sensor from its recorded values alone, while the axis moves.
#ifndef TRACKSERVO_IDENTIFICATION_SENSOR_NOISE_HPP
#define TRACKSERVO_IDENTIFICATION_SENSOR_NOISE_HPP

#include <vector>

#include "identification/recording.hpp"

namespace trackservo::identification {

// Returns the rms of the part that is white from tick to tick, in the values' unit; 0 where no stretch has five ticks.
// Ticks without a value (NaN) are left out.
double white_noise_rms(const std::vector<double>& values, const std::vector<Stretch>& stretches);

}  // namespace trackservo::identification

#endif
