// SPDX-License-Identifier: Apache-2.0
// Figures of merit of one run, always computed from the plant's true state, never from a sensor.
//
// Windows are half-open intervals [begin_s, end_s) of the trace's time. A window without rows gives NaN, which the
// result table shows as "no value".
#ifndef TRACKSERVO_SIM_ANALYSIS_METRICS_HPP
#define TRACKSERVO_SIM_ANALYSIS_METRICS_HPP

#include "machine/run/trace.hpp"

namespace trackservo::sim {

struct Window {
  double begin_s;
  double end_s;
};

// Returns the largest |true rate - reference| [rad/s].
double peak_rate_error_rad_s(const Trace& trace, int axis, Window window);

// Returns the root mean square of (true rate - reference) [rad/s].
double rms_rate_error_rad_s(const Trace& trace, int axis, Window window);

// How long the true rate must stay at 90 % to count as arrived. The start-up transient has ended by then (the slowest
// time constant of a 30 Hz loop is about 15 ms), while a gust with a corner of 0.5 Hz has hardly changed. A later dip
// is a disturbance of the motion, not part of its start.
constexpr double kArrivalDwell_s = 0.1;

// Returns the time from window.begin_s until the true rate has 90 % of `step_rad_s` AND stays at or above it, row for
// row, for kArrivalDwell_s [s]; an earlier crossing that sags again does not count. Infinite when it never does, or
// when the window ends before the dwell; NaN for a step of 0.
double time_to_90_percent_s(const Trace& trace, int axis, Window window, double step_rad_s);

// Returns how far the true rate exceeds `step_rad_s` in its direction, as a fraction of it; 0 when it never does, NaN
// for a step of 0.
double overshoot_fraction(const Trace& trace, int axis, Window window, double step_rad_s);

// Returns the standard deviation of the line-of-sight error [rad].
double tracking_sigma_rad(const Trace& trace, int axis, Window window);

// Returns the root mean square of the torque command minus its own 50 ms moving mean [Nm]: the controller's response to
// noise.
double torque_noise_nm(const Trace& trace, int axis, Window window);

// Returns the row by row mean of runs of equal length that differ only in their seeds: the part that remains when noise
// averages out.
Trace ensemble_mean(const std::vector<Trace>& runs);

}  // namespace trackservo::sim

#endif
