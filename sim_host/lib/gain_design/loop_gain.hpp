// SPDX-License-Identifier: Apache-2.0
// Loop gain of the speed loop at the torque command, from the firmware's difference equations.
//
//     L(jw) = P(jw) H(jw) C(z),  z = exp(jw T)
//
// P: torque command to joint rate, with the tick's zero-order hold and latency and the current loop;
// H: sensors; C(z): the controller's own difference equations (rate estimator, fusion, filters, PI, observer).
// Friction feedforward is not included: it runs on the set-point, not on the measured joint rate. The same response can
// be measured on the full simulated machine (sim_host/design/frequency_measurement.hpp).
#ifndef TRACKSERVO_GAIN_DESIGN_LOOP_GAIN_HPP
#define TRACKSERVO_GAIN_DESIGN_LOOP_GAIN_HPP

#include <complex>
#include <vector>

#include "gain_design/firmware.hpp"
#include "gain_design/log_space.hpp"
#include "identification/structural_mode.hpp"

namespace trackservo::gain_design {

// The linear machine around one operating point of an axis.
struct LinearMachine {
  double inertia_kg_m2 = 1.0;
  double viscous_nm_s_rad = 0.0;
  double bristle_stiffness_nm_rad = 0.0;  // 0 while the seal slides; sigma0 in pre-sliding
  double bristle_damping_nm_s_rad = 0.0;  // sigma1, used in pre-sliding only
  std::vector<StructuralMode> modes;
  double actuation_delay_s = 0.0;   // from sampling to the voltage taking effect
  double current_loop_rad_s = 1e4;  // first-order bandwidth
  double encoder_latency_s = 0.0;
  double gyro_latency_s = 0.0;
  double gyro_bandwidth_rad_s = 1e4;  // first-order
  bool gyro_below_joint = false;      // it does not see the joint's motion, which comes from the encoder then
  bool gyro_on_payload = false;       // it is behind the spring of the first mode
};

// The transfers of the loop at one frequency, with the base at rest.
struct LoopTransfers {
  std::complex<double> mechanics;  // torque on the axis to joint rate
  std::complex<double> drive;      // torque command to joint rate
  std::complex<double> angle;      // the encoder's reading to the feedback of the controller
  std::complex<double> gyro;       // the gyro's reading to the feedback
  std::complex<double> sensor;     // joint rate to the feedback, by both
  std::complex<double> forward;    // set-point to torque command
  std::complex<double> feedback;   // feedback to minus the torque command

  std::complex<double> loop_gain() const { return drive * sensor * feedback; }
};

LoopTransfers loop_transfers(const LinearMachine& machine, const speed_loop_params& params, double frequency_hz);

struct FrequencyResponse {
  std::vector<double> frequency_hz;
  std::vector<std::complex<double>> loop_gain;  // L, negative feedback: instability at L = -1
};

// Returns frequencies as log_space does, with more of them from the antiresonance to beyond the resonance of every
// mode, where the loop gain turns within a few tenths of a hertz.
std::vector<double> log_space_with_modes(const LinearMachine& machine, double first_hz, double last_hz, int count);

FrequencyResponse computed_loop_gain(const LinearMachine& machine, const speed_loop_params& params,
                                     const std::vector<double>& frequency_hz);

// Returns the closed-loop set-point response at one frequency: joint rate over set-point, with set-point weight and
// set-point model.
std::complex<double> closed_loop_gain(const LinearMachine& machine, const speed_loop_params& params,
                                      double frequency_hz);

// Returns the loop with set-point weight 1 and without a set-point model.
speed_loop_params with_plain_set_point(speed_loop_params params);

// Returns the bandwidth of the closed-loop set-point response with set-point weight 1 and no model (the usual
// meaning of "speed-loop bandwidth"): the highest frequency below which it stays above -3 dB, in Hz.
double closed_loop_bandwidth_hz(const LinearMachine& machine, const speed_loop_params& params);

}  // namespace trackservo::gain_design

#endif
