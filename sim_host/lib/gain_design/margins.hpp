// SPDX-License-Identifier: Apache-2.0
// Distance of a loop from instability, and whether it is stable.
#ifndef TRACKSERVO_GAIN_DESIGN_MARGINS_HPP
#define TRACKSERVO_GAIN_DESIGN_MARGINS_HPP

#include <vector>

#include "gain_design/loop_gain.hpp"

namespace trackservo::gain_design {

// Margins are distances: they do not say on which side of L = -1 a loop is. Check is_stable_in_closed_loop too.
struct Margins {
  double gain_margin_db = 0.0;      // smallest |gain change in dB|, up or down, that reaches L = -1
  double phase_margin_deg = 0.0;    // smallest over all crossings of |L| = 1
  double crossover_hz = 0.0;        // highest frequency with |L| = 1
  double phase_crossover_hz = 0.0;  // frequency of the gain margin; infinite when there is none
};

// Margins that a loop must keep.
struct MinMargins {
  double gain_margin_db = 6.0;
  double phase_margin_deg = 40.0;
};

// Returns the margins by linear interpolation between the given points; infinite where there is no crossing.
Margins margins_of(const FrequencyResponse& response);

// Returns the first machine's margins, with the smallest gain and phase margin of all of them.
Margins worst_margins(const std::vector<LinearMachine>& machines, const speed_loop_params& loop);

bool keeps_margins(const Margins& margins, const MinMargins& least = {});

// Returns whether a loop is stable by Nyquist's criterion, for a loop gain without unstable poles, integrators allowed:
// the phase of 1 + L, followed from low frequency on, ends at zero. The points must begin far below and end far above
// the crossover, a few per cent apart.
bool is_stable_in_closed_loop(const FrequencyResponse& response);

// Returns whether the loop is stable on every one of the machines. Takes about 0.2 ms each.
bool is_stable(const std::vector<LinearMachine>& machines, const speed_loop_params& loop);

}  // namespace trackservo::gain_design

#endif
