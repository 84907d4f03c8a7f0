// SPDX-License-Identifier: Apache-2.0
#include "gain_design/loop_gain.hpp"

#include <algorithm>
#include <cmath>

#include "units.hpp"

namespace trackservo::gain_design {
namespace {

using Complex = std::complex<double>;
static_assert(static_cast<float>(kTick_s) == SERVO_TICK_S);

Complex delay(Complex s, double seconds) { return std::exp(-s * seconds); }
Complex low_pass(Complex s, double bandwidth_rad_s) { return 1.0 / (1.0 + s / bandwidth_rad_s); }

// Torque on the axis to joint rate.
Complex mechanics(const LinearMachine& m, Complex s) {
  const Complex damping = m.viscous_nm_s_rad + m.bristle_damping_nm_s_rad;
  const Complex free = m.modes.empty() ? m.inertia_kg_m2 * s : m.inertia_kg_m2 * s / structural_factor(m.modes, s);
  return 1.0 / (free + damping + m.bristle_stiffness_nm_rad / s);
}

// Torque command (a number that changes once per tick) to torque on the axis.
Complex actuation(const LinearMachine& m, Complex s) {
  const Complex hold = (1.0 - std::exp(-s * kTick_s)) / (s * kTick_s);
  return hold * delay(s, m.actuation_delay_s) * low_pass(s, m.current_loop_rad_s);
}

Complex biquad(const biquad_params& p, Complex z_inverse) {
  const double b0 = static_cast<double>(p.b0), b1 = static_cast<double>(p.b1), b2 = static_cast<double>(p.b2);
  const double a1 = static_cast<double>(p.a1), a2 = static_cast<double>(p.a2);
  return (b0 + z_inverse * (b1 + z_inverse * b2)) / (1.0 + z_inverse * (a1 + z_inverse * a2));
}

// Slope weights of rate_estimator.h: angles of the ticks to joint rate.
Complex slope_estimator(const rate_estimator_params& p, Complex z_inverse) {
  const int n = p.window_ticks;
  const double spread = n * (n * n - 1) / 12.0;
  Complex slope = 0.0;
  Complex age_shift = 1.0;
  for (int age = 0; age < n; ++age) {
    slope += (0.5 * (n - 1) - age) * age_shift;
    age_shift *= z_inverse;
  }
  return slope / (spread * kTick_s);
}

// Weight of the readings in the feedback of the controller, filters included.
struct SensorWeights {
  Complex joint;  // of the rate estimated from the angle
  Complex gyro;
};

SensorWeights sensor_weights(const speed_loop_params& p, Complex z_inverse) {
  const double step = static_cast<double>(p.rate_fusion.crossover_rad_s) * kTick_s;
  const double blend = step / (1.0 + step);
  const Complex base = blend / (1.0 - (1.0 - blend) * z_inverse);
  const Complex filters = biquad(p.notch, z_inverse) * biquad(p.lowpass, z_inverse);
  switch (p.rate_fusion.source) {
    case RATE_FROM_GYRO:
      return {0.0, filters};
    case RATE_FUSED:
      return {filters * (1.0 - base), filters * base};
    case RATE_FROM_ENCODER:
    default:
      return {filters, 0.0};
  }
}

struct ControllerResponse {
  Complex forward;   // set-point to torque
  Complex feedback;  // measured rate to minus torque
};

// The difference equations of setpoint_model.h, for a set-point whose acceleration is not announced.
struct ShownSetPoint {
  Complex rate;          // set-point to rate
  Complex acceleration;  // set-point to acceleration
};

ShownSetPoint shown_set_point(const setpoint_model_params& p, Complex z_inverse) {
  if (p.gain_per_s == 0.0F) {
    return {1.0, 0.0};
  }
  const double gain_per_s = static_cast<double>(p.gain_per_s);
  const Complex lag = 1.0 - static_cast<double>(p.decay) * z_inverse;
  const Complex caught = gain_per_s * kTick_s * z_inverse;
  const Complex all = (1.0 - z_inverse) * lag + caught;
  return {caught / all, gain_per_s * (1.0 - z_inverse) / all};
}

// The difference equations of pi_controller.c and disturbance_observer.c.
ControllerResponse controller(const speed_loop_params& p, Complex z_inverse) {
  const double kp = static_cast<double>(p.pi.proportional_gain);
  const double ki = static_cast<double>(p.pi.integral_gain);
  const Complex integral = ki * kTick_s * z_inverse / (1.0 - z_inverse);
  const Complex pi = kp + integral;
  const ShownSetPoint shown = shown_set_point(p.setpoint_model, z_inverse);
  const Complex set_point = (static_cast<double>(p.pi.setpoint_weight) * kp + integral) * shown.rate +
                            static_cast<double>(p.acceleration_inertia_kg_m2) * shown.acceleration;
  if (p.observer_on) {
    const double blend = 1.0 - std::exp(-static_cast<double>(p.observer.bandwidth_rad_s) * kTick_s);
    const double momentum = blend * static_cast<double>(p.observer.inertia_kg_m2) / kTick_s;
    const double viscous = blend * static_cast<double>(p.observer.viscous_nm_s_rad);
    const Complex lag = 1.0 - (1.0 - blend) * z_inverse;
    const Complex observed = (momentum * (1.0 - z_inverse) + viscous * z_inverse) / lag;
    const Complex inner = blend * z_inverse / lag;
    return {set_point / (1.0 - inner), (pi + observed) / (1.0 - inner)};
  }
  return {set_point, pi};
}

}  // namespace

LoopTransfers loop_transfers(const LinearMachine& machine, const speed_loop_params& params, double frequency_hz) {
  const Complex s(0.0, 2.0 * M_PI * frequency_hz);
  const Complex z_inverse = std::exp(-s * kTick_s);
  const SensorWeights weights = sensor_weights(params, z_inverse);
  const ControllerResponse c = controller(params, z_inverse);
  LoopTransfers at;
  at.mechanics = mechanics(machine, s);
  at.drive = actuation(machine, s) * at.mechanics;
  at.angle = weights.joint * slope_estimator(params.rate_estimator, z_inverse);
  at.gyro = weights.gyro;
  const Complex joint = slope_estimator(params.rate_estimator, z_inverse) / s * delay(s, machine.encoder_latency_s);
  const Complex gyro = machine.gyro_below_joint
                           ? joint
                           : delay(s, machine.gyro_latency_s) * low_pass(s, machine.gyro_bandwidth_rad_s) *
                                 (machine.gyro_on_payload ? payload_factor(machine.modes.front(), s) : 1.0);
  at.sensor = weights.joint * joint + weights.gyro * gyro;
  at.forward = c.forward;
  at.feedback = c.feedback;
  return at;
}

std::vector<double> log_space_with_modes(const LinearMachine& machine, double first_hz, double last_hz, int count) {
  constexpr int kPerMode = 400;
  std::vector<double> points = log_space(first_hz, last_hz, count);
  for (const StructuralMode& mode : machine.modes) {
    const double resonance_hz = mode.frequency_rad_s / (2.0 * M_PI);
    const double from_hz = 0.8 * resonance_hz / std::sqrt(1.0 + std::max(mode.share, 0.0));
    const std::vector<double> close = log_space(from_hz, std::min(1.2 * resonance_hz, last_hz), kPerMode);
    points.insert(points.end(), close.begin(), close.end());
  }
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

FrequencyResponse computed_loop_gain(const LinearMachine& machine, const speed_loop_params& params,
                                     const std::vector<double>& frequency_hz) {
  FrequencyResponse response{frequency_hz, {}};
  response.loop_gain.reserve(frequency_hz.size());
  for (const double f_hz : frequency_hz) {
    response.loop_gain.push_back(loop_transfers(machine, params, f_hz).loop_gain());
  }
  return response;
}

std::complex<double> closed_loop_gain(const LinearMachine& machine, const speed_loop_params& params,
                                      double frequency_hz) {
  const LoopTransfers at = loop_transfers(machine, params, frequency_hz);
  return at.drive * at.forward / (1.0 + at.loop_gain());
}

speed_loop_params with_plain_set_point(speed_loop_params params) {
  params.setpoint_model = {};
  params.pi.setpoint_weight = 1.0F;
  return params;
}

double closed_loop_bandwidth_hz(const LinearMachine& machine, const speed_loop_params& params) {
  const speed_loop_params plain = with_plain_set_point(params);
  double bandwidth_hz = 0.0;
  for (const double f_hz : log_space(0.02, 400.0, 2000)) {
    if (std::abs(closed_loop_gain(machine, plain, f_hz)) < M_SQRT1_2) {
      break;
    }
    bandwidth_hz = f_hz;
  }
  return bandwidth_hz;
}

}  // namespace trackservo::gain_design
