// SPDX-License-Identifier: Apache-2.0
// Absolute angle encoder of one joint.
//
//   reading = quantise(angle(t - latency) + e sin(angle + phase) + s sin(n angle) + jitter), resolution 2^bits per turn
//   sample  = mean of the last `reads_per_tick` readings, one per PWM period
//
// e: eccentricity of the disc, one period per turn. s: error within the n lines of the disc, which the encoder divides
// by interpolation. The reading is 32 bits for one turn and wraps. An encoder of fewer
// bits leaves the lower bits of a reading zero; the mean of several readings may use them.
//
// Use: advance() once per PWM period, sample() once per tick or read() at every reading.
#ifndef TRACKSERVO_SIM_SENSORS_ENCODER_HPP
#define TRACKSERVO_SIM_SENSORS_ENCODER_HPP

#include <cstdint>

#include "machine/base/key.hpp"
#include "machine/base/random.hpp"
#include "machine/sensors/history.hpp"

namespace trackservo::sim {

struct EncoderConfig {
  int resolution_bits = 26;
  double jitter_rms_rad = 0;
  double eccentricity_rad = 0;
  double eccentricity_phase_rad = 0;
  double subdivision_error_rad = 0;
  int lines_per_turn = 20000;
  double latency_s = 0;
  int reads_per_tick = 1;  // readings averaged per tick, those of the last PWM periods
};

const Keys<EncoderConfig>& encoder_keys();

class Encoder {
 public:
  // Makes an encoder. dt_s: time between advance() calls [s].
  Encoder(const EncoderConfig& config, double dt_s, std::uint64_t seed, int axis);

  // Places the joint as if it had always been at this angle [rad].
  void place(double joint_angle_rad) { history_.fill(joint_angle_rad); }

  void advance(double joint_angle_rad) { history_.push(joint_angle_rad); }

  // Returns the mean of this tick's readings in 2^-32 turns. Draws noise.
  std::uint32_t sample();

  // Returns a single reading now, for a caller that averages itself. Draws noise.
  std::uint32_t read();

 private:
  // Returns the reading for an angle of the disc.
  std::uint32_t reading(double shown_rad);

  // Returns the error of the interpolation at an angle of the joint.
  double subdivision_rad(double angle_rad) const;

  EncoderConfig config_;
  double counts_per_rad_;
  History history_;
  RandomStream jitter_;
};

}  // namespace trackservo::sim

#endif
