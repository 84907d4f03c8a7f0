// SPDX-License-Identifier: Apache-2.0
// A spectrum of base motion as a sum of sines.
//
// The band is divided into parts of equal ratio. Each part is one sine, whose power is the integral of the density over
// the part:
//
//     S(f) = c f^-slope on [low, high],  integral of S = rms^2,  amplitude = sqrt(2 integral over the part)
//
// Its frequency is drawn from the part, so that the sum does not repeat, and its phase from the whole turn.
#ifndef TRACKSERVO_SIM_PLANT_BASE_SPECTRUM_HPP
#define TRACKSERVO_SIM_PLANT_BASE_SPECTRUM_HPP

#include <vector>

#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

// Returns the sines of a band; `index` distinguishes bands with the same seed.
std::vector<BaseMotionLine> lines_of(const BaseSpectrum& band, int index);

// Returns all sines of a plant's base: those that are stated, then those of its spectra.
std::vector<BaseMotionLine> base_motion_lines(const PlantConfig& plant);

// Returns a rate that the base hardly exceeds [rad/s]: of each axis four standard deviations, but not more than all its
// sines together.
double fastest_base_rate_rad_s(const PlantConfig& plant);

}  // namespace trackservo::sim

#endif
