// SPDX-License-Identifier: Apache-2.0
// Frequency response of the axis from torque to joint rate, measured in the runs with torque excitation.
//
//     H = S_ur / S_uu,   coherence = |S_ur|^2 / (S_uu S_rr)        (Welch: Hann windows, overlapping by half)
//
// u: mean torque of a tick, r: mean joint rate of the same tick, so both are averaged equally and no filter lies
// between them. The axis is in closed loop while it is excited. With good coherence the excitation is so much stronger
// than wind and friction that the estimate is that of the axis alone. Torque between the ticks is aliased: 1 % at 90
// Hz, 5 % at 200 Hz.
#ifndef TRACKSERVO_IDENTIFICATION_FREQUENCY_RESPONSE_HPP
#define TRACKSERVO_IDENTIFICATION_FREQUENCY_RESPONSE_HPP

#include <complex>
#include <vector>

#include "identification/recording.hpp"

namespace trackservo::identification {

struct AxisResponse {
  std::vector<double> frequency_hz;        // evenly spaced
  std::vector<std::complex<double>> gain;  // rad/s per Nm
  std::vector<double> coherence;           // 0 .. 1; 0 where no chirp excited the axis
  int windows = 0;                         // that were averaged; 0: no run was long enough
};

// Returns the response of all runs of kind 4 of at least 4.096 s, up to 400 Hz (as far as a chirp goes).
AxisResponse axis_response(const Recording& recording);

}  // namespace trackservo::identification

#endif
