// SPDX-License-Identifier: Apache-2.0
// Parameters of an identified axis, and the linear machine on which loops are designed.
#ifndef TRACKSERVO_GAIN_DESIGN_IDENTIFIED_PLANT_HPP
#define TRACKSERVO_GAIN_DESIGN_IDENTIFIED_PLANT_HPP

#include <optional>
#include <vector>

#include "gain_design/loop_gain.hpp"
#include "gain_design/rate_error.hpp"

namespace trackservo::gain_design {

// The firmware's timing (decision 0007), the same on every board: a tick's set-points take effect in the third PWM
// period after its sampling.
constexpr double kPwmPeriod_s = 50e-6;  // SERVO_PWM_PERIOD_S, before it was rounded to float
constexpr double kActuationDelay_s = 2.0 * kPwmPeriod_s;

// Current is sampled at the beginning of each PWM period, so its mean over a tick is half a period old: the identified
// delay of the encoder is smaller by this.
constexpr double kCurrentAge_s = 0.5 * kPwmPeriod_s;

// Assumed for a gyro: the bandwidth of a fibre-optic one. The identification measures its whole delay; the part that
// the assumed low-pass does not explain is latency. Below the crossover of the fusion only the sum matters.
constexpr double kAssumedGyroBandwidth_hz = 440.0;
constexpr double kAssumedGyroLatency_s = 200e-6;  // only when no gyro was recorded

constexpr double kResonanceSpread = 0.05;
constexpr double kInertiaSpread = 0.3;

struct EncoderFacts {
  double latency_s = 0.0;  // from the joint's angle to the tick's sample of it, averaging included
  double noise_rad = 0.0;  // rms of a tick's angle
};

struct GyroFacts {
  double latency_s = kAssumedGyroLatency_s;
  double bandwidth_hz = kAssumedGyroBandwidth_hz;  // of a first-order low-pass
  double noise_rad_s = 0.0;                        // rms of a tick's rate
  bool below_joint = false;                        // what it shows of the joint's motion comes from the encoder
  bool on_payload = false;                         // behind the spring of the only mode
};

struct IdentifiedPlant {
  double inertia_kg_m2 = 0.0;
  lugre_params friction{};
  std::vector<StructuralMode> modes;
  EncoderFacts encoder;
  GyroFacts gyro;
  std::optional<Disturbance> disturbance;  // during the identification

  SensorNoise noise() const { return {encoder.noise_rad, gyro.noise_rad_s}; }
};

// Returns the linear machine of an axis: sliding beyond the Stribeck effect in the direction with less viscous
// friction, or in pre-sliding, where the bristles are a spring. The current loop comes from the device's parameters.
LinearMachine linear_machine(const IdentifiedPlant& plant, double current_loop_rad_s, bool pre_sliding);

// Returns the operating points for which a speed loop must be good: sliding, pre-sliding, and with resonances both
// again with all of them kResonanceSpread lower and higher: a resonance moves with load and temperature.
std::vector<LinearMachine> operating_points(const IdentifiedPlant& plant, double current_loop_rad_s);

// Returns these machines, and behind them all of them again with kInertiaSpread less and more inertia than is known.
std::vector<LinearMachine> with_other_inertia(std::vector<LinearMachine> machines);

// Writes the friction into the device's parameters, object 0x2030.
void set_friction(axis_parameters& parameters, const lugre_params& friction);

// Writes the plant into the device's parameters, object 0x2056: the device checks gains against it.
void set_plant(axis_parameters& parameters, const IdentifiedPlant& plant);

}  // namespace trackservo::gain_design

#endif
