// SPDX-License-Identifier: Apache-2.0
// Start of the joint fit when wind hides the results of the paper's method.
//
// With the bristles' length L = Tc/sigma0 and the Stribeck speed given, and bristles that bend alike at all speeds,
//   torque = J a + h (Tc (1 - E) + Ts E) + s2 v + c dh/dt + load,   dh/dt = (v - |v| h)/L,   E = exp(-(v/vs)^2)
// is linear in all that is left, each direction with its own Tc, Ts and s2. A grid of L and vs, each solved with
// whitened residuals, therefore finds the neighbourhood of the best fit without a start value and without getting
// stuck. The joint fit then drops the simplification.
#ifndef TRACKSERVO_IDENTIFICATION_START_SEARCH_HPP
#define TRACKSERVO_IDENTIFICATION_START_SEARCH_HPP

#include "identification/motion.hpp"
#include "identification/paper_method.hpp"
#include "identification/recording.hpp"

namespace trackservo::identification {

// Searches all bristle lengths from microradians to a tenth of a radian, and all speeds that occur: no knowledge of the
// machine is needed. Values that the data do not determine stay as in `paper`.
PaperEstimate search_start(const Recording& recording, const Motion& motion, const PaperEstimate& paper);

}  // namespace trackservo::identification

#endif
