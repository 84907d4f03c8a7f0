// Figures of merit of one run, always taken from the plant's true state, never from a sensor.
//
// Windows are half-open intervals [begin_s, end_s) of the trace's time. A window without rows gives NaN, which the
// result table shows as "no value".
#ifndef TRACKSERVO_SIM_ANALYSIS_METRICS_HPP
#define TRACKSERVO_SIM_ANALYSIS_METRICS_HPP

#include "run/trace.hpp"

namespace trackservo::sim {

struct Window {
  double begin_s;
  double end_s;
};

// Largest |true rate - reference| [rad/s].
double peak_rate_error_rad_s(const Trace& trace, int axis, Window window);

// Root mean square of (true rate - reference) [rad/s].
double rms_rate_error_rad_s(const Trace& trace, int axis, Window window);

// Time from window.begin_s until the true rate first reaches 90 % of `step_rad_s` (> 0) [s]; the whole window's length
// when it never does.
double time_to_90_percent_s(const Trace& trace, int axis, Window window, double step_rad_s);

// How far the true rate exceeds `step_rad_s` (> 0), as a fraction of it; 0 when it never does.
double overshoot_fraction(const Trace& trace, int axis, Window window, double step_rad_s);

// Standard deviation of the line-of-sight error [rad].
double tracking_sigma_rad(const Trace& trace, int axis, Window window);

// Root mean square of the torque command less its own 50 ms moving mean [Nm]: what the controller makes of noise.
double torque_noise_nm(const Trace& trace, int axis, Window window);

// Row by row mean of runs of equal length that differ in their seeds only: what is left when noise averages out.
Trace ensemble_mean(const std::vector<Trace>& runs);

}  // namespace trackservo::sim

#endif
