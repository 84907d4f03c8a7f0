// SPDX-License-Identifier: Apache-2.0
// Distance of a speed loop from instability on a simulated plant, computed from its difference equations and the
// plant's numbers.
//
// Two conditions count: the seal slides (a viscous load), and pre-sliding (the seal is a spring). Margins are those at
// pitch 0, where the loops are designed and the azimuth inertia is largest; its gains follow the inertia. Stability is
// required over the whole pitch travel. It uses the arithmetic of the gain design.
#ifndef TRACKSERVO_SIM_DESIGN_LOOP_MARGINS_HPP
#define TRACKSERVO_SIM_DESIGN_LOOP_MARGINS_HPP

#include "gain_design/margins.hpp"
#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

using gain_design::closed_loop_bandwidth_hz;
using gain_design::closed_loop_gain;
using gain_design::computed_loop_gain;
using gain_design::FrequencyResponse;
using gain_design::is_stable_in_closed_loop;
using gain_design::keeps_margins;
using gain_design::LinearMachine;
using gain_design::log_space;
using gain_design::Margins;
using gain_design::margins_of;

// Margins that every controller variant must keep, computed with the tick's delay.
constexpr gain_design::MinMargins kMinMargins;

// Returns the linear machine of one axis for computed margins: sliding, or in pre-sliding.
LinearMachine linear_machine(const PlantConfig& plant, int axis, bool pre_sliding);

// Returns the smaller one of the margins sliding and in pre-sliding.
Margins worst_margins(const PlantConfig& plant, int axis, const speed_loop_params& speed_loop);

// Returns the smallest inertia that the axis' motor turns within the pitch travel [kg m2].
double min_inertia_kg_m2(const PlantConfig& plant, int axis);

// Returns the loop as the firmware runs it at a pitch angle: the azimuth's gains follow the inertia
// (speed_loop_follow), which the device knows from 2056:1 and 2056:2.
speed_loop_params loop_at_pitch(const PlantConfig& plant, int axis, const speed_loop_params& speed_loop,
                                double pitch_rad);

// Returns whether the loop is stable sliding and in pre-sliding, with the inertia at pitch 0 and with the smallest one.
bool speed_loop_is_stable(const PlantConfig& plant, int axis, const speed_loop_params& speed_loop);

}  // namespace trackservo::sim

#endif
