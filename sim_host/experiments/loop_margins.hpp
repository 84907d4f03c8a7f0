// How far a speed loop is from instability, computed from its difference equations and the plant's numbers.
//
// Two conditions count: the seal slides (a viscous load), and pre-sliding (the seal is a spring). Margins are those at
// pitch 0, where the loops are designed and the azimuth inertia is largest; towards the zenith they shrink, because the
// same gains turn less inertia. Stability is asked of the whole pitch travel.
#ifndef TRACKSERVO_SIM_EXPERIMENTS_LOOP_MARGINS_HPP
#define TRACKSERVO_SIM_EXPERIMENTS_LOOP_MARGINS_HPP

#include "analysis/frequency_response.hpp"
#include "config/plant_config.hpp"
#include "run/firmware.hpp"

namespace trackservo::sim {

// What every controller variant must keep, computed with the tick's delay.
constexpr double kLeastGainMargin_db = 6.0;
constexpr double kLeastPhaseMargin_deg = 40.0;

// The linear machine of one axis for computed margins: sliding, or in pre-sliding.
LinearMachine linear_machine(const PlantConfig& plant, int axis, bool pre_sliding);

// The smaller one of the margins sliding and in pre-sliding. Margins are distances: they do not tell on which side of
// L = -1 a loop is. Ask speed_loop_is_stable, too.
Margins worst_margins(const PlantConfig& plant, int axis, const speed_loop_params& speed_loop);

// True when both margins are what every controller must keep.
bool keeps_margins(const Margins& margins);

// Nyquist's criterion for a loop gain without unstable poles, integrators allowed: the phase of 1 + L, followed from
// low frequency on, ends at zero. The points must begin far below and end far above the crossover, a few per cent
// apart.
bool is_stable_in_closed_loop(const FrequencyResponse& response);

// The least inertia that the axis' motor turns within the pitch travel [kg m2].
double least_inertia_kg_m2(const PlantConfig& plant, int axis);

// Stable sliding and in pre-sliding, with the inertia at pitch 0 and with the least one.
bool speed_loop_is_stable(const PlantConfig& plant, int axis, const speed_loop_params& speed_loop);

}  // namespace trackservo::sim

#endif
