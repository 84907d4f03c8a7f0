// Position and tracking loop around the speed loop.
#ifndef TRACKSERVO_GAIN_DESIGN_OUTER_LOOPS_HPP
#define TRACKSERVO_GAIN_DESIGN_OUTER_LOOPS_HPP

#include "gain_design/margins.hpp"

namespace trackservo::gain_design {

// A tracking loop on the camera waits 20 ms for a frame, 10 ms on average for the next, and some for the speed loop.
constexpr double kCameraDelay_s = 0.030;
constexpr double kTrackingDelay_s = kCameraDelay_s + 0.006;

// Natural frequency of a critically damped PI on an integrator, with a pure delay, whose closed loop is at -3 dB at
// the bandwidth [rad/s]. The paper gives "about 2 Hz" for its tracking loop and 20 ms of camera delay.
double tracking_frequency_rad_s(double bandwidth_hz, double delay_s);

}  // namespace trackservo::gain_design

#endif
