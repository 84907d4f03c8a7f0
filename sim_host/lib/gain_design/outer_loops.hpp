// SPDX-License-Identifier: Apache-2.0
// Position and tracking loop around the speed loop.
#ifndef TRACKSERVO_GAIN_DESIGN_OUTER_LOOPS_HPP
#define TRACKSERVO_GAIN_DESIGN_OUTER_LOOPS_HPP

#include "gain_design/margins.hpp"

namespace trackservo::gain_design {

// Delay of a tracking loop on the camera: 20 ms for a frame and 10 ms on average for the next one.
constexpr double kCameraDelay_s = 0.030;

// The same plus 6 ms for a speed loop of 30 Hz.
constexpr double kTrackingDelay_s = 0.036;

// Returns the natural frequency of a critically damped PI on an integrator, with a pure delay, whose closed loop is at
// -3 dB at the bandwidth [rad/s]. The paper gives "about 2 Hz" for its tracking loop and 20 ms of camera delay.
double tracking_frequency_rad_s(double bandwidth_hz, double delay_s);

// An outer loop from an angle's error to the rate set-point: proportional + integral / s after a delay.
struct OuterLoop {
  double proportional_per_s = 0.0;
  double integral_per_s2 = 0.0;
  double delay_s = 0.0;
};

// Returns the smallest margins over the machines, whose speed loop is closed with its own set-point weight.
Margins outer_margins(const std::vector<LinearMachine>& machines, const speed_loop_params& speed_loop,
                      const OuterLoop& outer);

}  // namespace trackservo::gain_design

#endif
