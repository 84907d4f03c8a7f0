// SPDX-License-Identifier: Apache-2.0
// How small the rate error can be with any linear controller at all: what PI and observer are measured against.
//
// All controllers that keep a stable machine (viscous friction above 0) stable are u = -Q (y - G u) with a stable Q
// [Youla, Jabr & Bongiorno, IEEE TAC 21, 1976]. Sensitivity 1 - G Q and rate error are linear in Q, so the least rms of
// the error under a limit for the sensitivity's peak is a convex problem [Boyd & Barratt, Linear Controller Design,
// 1991]. Here
//
//     Q = Q0 (1 + x1 L1 + x2 L2 + ...)
//
// Q0: that of a loop that is known to be good. L: Laguerre functions, which come as near to every stable function as
// one likes. It is solved by the alternating direction method of multipliers [Boyd et al., Found. Trends Mach. Learn.
// 3, 2011].
#ifndef TRACKSERVO_GAIN_DESIGN_RATE_ERROR_BOUND_HPP
#define TRACKSERVO_GAIN_DESIGN_RATE_ERROR_BOUND_HPP

#include <optional>

#include "gain_design/rate_error.hpp"

namespace trackservo::gain_design {

struct RateErrorBound {
  RateError error;           // of the best controller that was found, by causes
  double sensitivity = 0.0;  // its largest |1 / (1 + L)|
};

// Returns the least error of a controller that reads the same rate: rate estimator and fusion are those of `loop`, its
// notch and low-pass are free. `loop` must be stable on the machine. `most_sensitivity` (> 1): absent, that of `loop`;
// where no controller keeps a smaller one, the result is `loop`, with its sensitivity. Takes a tenth of a second.
RateErrorBound rate_error_bound(const LinearMachine& machine, const speed_loop_params& loop,
                                const Disturbance& disturbance, const SensorNoise& noise,
                                std::optional<double> most_sensitivity = {});

}  // namespace trackservo::gain_design

#endif
