/* SPDX-License-Identifier: Apache-2.0 */
/* Profile ramp: one tick towards a rate, from any rate and acceleration, with any limits that profile_limits_check
 * accepts, at 1 kHz: no division by zero, no root of a negative number, no value that is not finite. The ramps within a
 * room and over a distance are out of reach of intervals: their search relates a time to its distance. */
#include "drive/profile_ramp.h"

#include "proof.h"

static profile_limits any_limits(void) {
  return (profile_limits){.rate_rad_s = any_float(1e-6f, 4300.0f),
                          .acceleration_rad_s2 = any_float(1e-6f, 4300.0f),
                          .deceleration_rad_s2 = any_float(1e-6f, 4300.0f),
                          .jerk_rad_s3 = any_float(1e-6f, 4300.0f)};
}

static profile_ramp any_ramp(void) {
  return (profile_ramp){.rate_rad_s = any_float(-4300.0f, 4300.0f),
                        .acceleration_rad_s2 = any_float(-4300.0f, 4300.0f),
                        .rate_rest_rad_s = any_float(-1.0f, 1.0f),
                        .acceleration_rest_rad_s2 = any_float(-1.0f, 1.0f)};
}

static bool is_finite(profile_motion motion) {
  return motion.travel_rad >= -3.4e38f && motion.travel_rad <= 3.4e38f && motion.mean_acceleration_rad_s2 >= -3.4e38f &&
         motion.mean_acceleration_rad_s2 <= 3.4e38f;
}

int main(void) {
  const profile_limits limits = any_limits();
  profile_ramp ramp = any_ramp();
  const float dt_s = 0.001f;
  REQUIRE(is_finite(profile_towards_rate(&ramp, &limits, any_float(-4300.0f, 4300.0f), dt_s)), "towards a rate");
  return 0;
}
