// SPDX-License-Identifier: Apache-2.0
// Rate gyro of one axis (fibre-optic class): measures an inertial rate.
//
//   reading = clip((1 + scale) F{rate}(t - latency) + bias + F{noise})
//
// F is a first- or second-order (Butterworth) low-pass of the given bandwidth. The signal passes it at the PWM rate;
// this is exact for a rate that is linear within a period. The noise is white with variance density^2 fs/2 at the tick
// rate fs = 1 kHz. It passes the same low-pass sampled at fs, so the density at low frequency is the one in the data
// sheet. The valid flag is the gyro's own: false while its range is exceeded.
//
// Use: advance() once per PWM period, sample() once per tick.
#ifndef TRACKSERVO_SIM_SENSORS_GYRO_HPP
#define TRACKSERVO_SIM_SENSORS_GYRO_HPP

#include <cstdint>

#include "machine/base/axis.hpp"
#include "machine/base/key.hpp"
#include "machine/base/random.hpp"
#include "machine/sensors/history.hpp"
#include "machine/sensors/low_pass.hpp"

namespace trackservo::sim {

// Where the gyro is fixed, and so which rate it measures.
//
//   kJoint        about the joint's axis: that of the azimuth stage, or of the line of sight (pitch)
//   kLineOfSight  along the picture's axes: the azimuth's gyro measures cross-elevation, the pitch's measures elevation
//   kStage        on the azimuth stage: the pitch's gyro does not see its own joint
//   kBase         on the base, along both axes at azimuth 0: neither sees a joint
enum class GyroMounting { kJoint = 0, kLineOfSight = 1, kStage = 2, kBase = 3 };

// Returns whether it is fixed on what carries this axis, and measures about the axis, whatever the joints do.
inline bool is_below_joint(GyroMounting mounting, int axis) {
  return mounting == (axis == kAzimuth ? GyroMounting::kBase : GyroMounting::kStage);
}

struct GyroConfig {
  double noise_density_rad_s_rthz = 0;  // one-sided
  double bandwidth_hz = 440;
  int filter_order = 1;
  double bias_rad_s = 0;
  double scale_error = 0;
  double range_rad_s = 8.5;
  double latency_s = 0;
  GyroMounting mounting = GyroMounting::kJoint;
};

const Keys<GyroConfig>& gyro_keys();

class Gyro {
 public:
  struct Reading {
    double rate_rad_s = 0;
    bool valid = false;
  };

  // Makes a gyro. dt_s: time between advance() calls [s]; tick_s: between sample() calls [s].
  Gyro(const GyroConfig& config, double dt_s, double tick_s, std::uint64_t seed, int axis);

  void advance(double sensed_rate_rad_s) { history_.push(signal_.advance(sensed_rate_rad_s)); }

  // Returns the reading [rad/s]. Draws noise.
  Reading sample();

 private:
  GyroConfig config_;
  LowPass signal_;
  LowPass noise_filter_;
  History history_;
  RandomStream noise_;
  double noise_rms_rad_s_;
};

}  // namespace trackservo::sim

#endif
