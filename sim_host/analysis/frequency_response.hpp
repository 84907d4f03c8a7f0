// Loop gain of the speed loop at the torque command, and the margins read from it.
//
//     L(jw) = P(jw) H(jw) C(z),  z = exp(jw T)
//
// P: torque command to joint rate, with the tick's zero-order hold and latency and the current loop;
// H: sensors; C(z): the controller's own difference equations (rate estimator, fusion, filters, PI, observer).
// The same margins are also taken from a response measured on the full simulated machine (experiments/margins).
#ifndef TRACKSERVO_SIM_ANALYSIS_FREQUENCY_RESPONSE_HPP
#define TRACKSERVO_SIM_ANALYSIS_FREQUENCY_RESPONSE_HPP

#include <complex>
#include <vector>

#include "run/firmware.hpp"

namespace trackservo::sim {

// The linear machine around one operating point of an axis.
struct LinearMachine {
  double inertia_kg_m2 = 1.0;
  double viscous_nm_s_rad = 0.0;
  double bristle_stiffness_nm_rad = 0.0;  // 0 while the seal slides; sigma0 in pre-sliding
  double bristle_damping_nm_s_rad = 0.0;  // sigma1, counts in pre-sliding only
  double actuation_delay_s = 0.0;         // from sampling to the voltage being applied
  double current_loop_rad_s = 1e4;        // first-order bandwidth
  double encoder_latency_s = 0.0;
  double gyro_latency_s = 0.0;
  double gyro_bandwidth_rad_s = 1e4;  // first-order
};

struct FrequencyResponse {
  std::vector<double> frequency_hz;
  std::vector<std::complex<double>> loop_gain;  // L, negative feedback: instability at L = -1
};

struct Margins {
  double gain_margin_db = 0.0;      // smallest |gain change in dB|, up or down, that reaches L = -1
  double phase_margin_deg = 0.0;    // smallest over all crossings of |L| = 1
  double crossover_hz = 0.0;        // highest frequency with |L| = 1
  double phase_crossover_hz = 0.0;  // where the gain margin is taken; infinite when there is none
};

// `count` frequencies, logarithmically spaced.
std::vector<double> log_space(double first_hz, double last_hz, int count);

FrequencyResponse computed_loop_gain(const LinearMachine& machine, const speed_loop_params& params,
                                     const std::vector<double>& frequency_hz);

// Closed-loop set-point response at one frequency, with set-point weight 1: inertial rate over set-point.
std::complex<double> closed_loop_gain(const LinearMachine& machine, const speed_loop_params& params,
                                      double frequency_hz);

// Closed-loop set-point response with set-point weight 1 (the usual meaning of "speed-loop bandwidth"): the highest
// frequency below which it stays above -3 dB, in Hz.
double closed_loop_bandwidth_hz(const LinearMachine& machine, const speed_loop_params& params);

// Margins by linear interpolation between the given points; infinite where there is no crossing.
Margins margins_of(const FrequencyResponse& response);

}  // namespace trackservo::sim

#endif
