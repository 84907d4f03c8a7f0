// SPDX-License-Identifier: Apache-2.0
// Resonances of the structure: peaks of the measured frequency response beyond the rigid body that was identified.
//
//     H(jw) = exp(-jw delay) / (J jw / R(jw) + sigma2),   R = 1 for a rigid body
//
// The equation is solved for R. Where it is above 1, one mode (structural_mode.hpp) is fitted to it, together with a
// gain and a delay of its own, so that neither an error of J nor another mode far away affects it.
#ifndef TRACKSERVO_IDENTIFICATION_RESONANCES_HPP
#define TRACKSERVO_IDENTIFICATION_RESONANCES_HPP

#include <vector>

#include "identification/frequency_response.hpp"
#include "identification/structural_mode.hpp"

namespace trackservo::identification {

// The rigid axis while it slides.
struct RigidAxis {
  double inertia_kg_m2 = 1.0;
  double viscous_nm_s_rad = 0.0;
  double delay_s = 0.0;  // delay of the measured motion relative to the torque
};

// Below this coherence no resonance is searched.
constexpr double kGoodCoherence = 0.8;

// One window alone is always coherent: at least this many must have been averaged.
constexpr int kMinWindows = 8;

// A peak must exceed the rigid body and its neighbourhood by this.
constexpr double kMinHeight = 1.5;

// Returns the resonances by rising frequency; at most three. Returns none where fewer than kMinWindows were averaged.
std::vector<gain_design::StructuralMode> find_resonances(const AxisResponse& response, const RigidAxis& rigid);

}  // namespace trackservo::identification

#endif
