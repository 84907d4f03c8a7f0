/* SPDX-License-Identifier: Apache-2.0 */
/* Converts between the integers of CiA 402 and the angles, rates and torques of the control core.
 *
 * Position: 1e-7 rad <-> 2^-32 turn, unwrapped over many turns (2 pi 1e7 / 2^32 = 0.0146 counts per unit); velocity:
 * 1e-6 rad/s <-> rad/s; torque: 0.1 % of rated <-> Nm (CiA 402-2 clause 8, objects 60A8, 60A9, 6076). Everything rounds
 * to the nearest, halves away from zero, and saturates at the ends of the integer; NaN becomes 0. */
#ifndef TRACKSERVO_DRIVE_DRIVE_UNITS_H
#define TRACKSERVO_DRIVE_DRIVE_UNITS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/angle.h"

/* An angle in 2^-32 turn that also counts turns: 2^31 of them, so it never wraps in use. */
typedef int64_t drive_angle;

/* The range of positions on the bus (607B) while no travel is limited: 64 turns, from -32 turns. */
#define DRIVE_RANGE (INT64_C(1) << 38)
#define DRIVE_RANGE_END 2010619298 /* 32 turns in 1e-7 rad, cut off */

/* Returns the same direction within the range: whole ranges added. */
static inline drive_angle drive_angle_wrap(drive_angle angle) {
  const uint64_t from_start = (uint64_t)angle + (uint64_t)DRIVE_RANGE / 2;
  return (drive_angle)(from_start & ((uint64_t)DRIVE_RANGE - 1)) - DRIVE_RANGE / 2;
}

/* Returns the angle near `before` at which the encoder reads `now`: within half a turn. */
static inline drive_angle drive_angle_unwrap(drive_angle before, angle_turn32 now) {
  return before + (int32_t)(now - (angle_turn32)before);
}

/* Returns to - from in rad. A float keeps 24 bits of it: exact to 1.5 nrad within 25 mrad, to 120 ppb beyond. */
static inline float drive_angle_difference_rad(drive_angle to, drive_angle from) {
  const drive_angle difference = to - from;
  const bool is_short = difference >= INT32_MIN && difference <= INT32_MAX;
  /* The FPU converts 32 bits at a time; to convert 64 is a library function of 90 instructions. */
  const float units = is_short ? (float)(int32_t)difference
                               : (float)(int32_t)(difference >> 32) * 0x1p32f + (float)(uint32_t)difference;
  return units * ANGLE_RAD_PER_TURN32;
}

/* Returns 1e-7 rad, saturated at +-214.7 rad (34 turns). The constant has 57 bits: the error is at most 0.5 + 2e-8
 * counts. */
int32_t drive_position_from_angle(drive_angle angle);

/* Converts within half a unit of 2^-32 turn, below 2^56 counts; the inverse function restores the position, for every
 * int32. */
drive_angle drive_angle_from_position(int64_t position);

/* Returns 1e-6 rad/s, the exact product rounded once. */
int32_t drive_velocity_from_rate(float rate_rad_s);

/* Returns a difference of angles as a position: 1e-7 rad. Saturates; not a number gives 0. */
static inline int32_t drive_position_from_rad(float angle_rad) { return drive_velocity_from_rate(10.0f * angle_rad); }

/* Returns rad/s; the inverse function restores the velocity below 16 rad/s, and is within 60 ppb beyond. */
static inline float drive_rate_from_velocity(int32_t velocity) { return (float)velocity / 1e6f; }

/* Returns rad/s, rad/s^2 or rad/s^3 of an unsigned limit; at least 1e-6, so that a ramp always ends. */
static inline float drive_limit_from_counts(uint32_t counts) { return (float)(counts == 0 ? 1 : counts) / 1e6f; }

/* Returns 0.1 % of rated, within 0.504; 0 when the rated torque is 0. */
int16_t drive_permille_from_torque(float torque_nm, uint32_t rated_mnm);

static inline float drive_torque_from_permille(int32_t permille, uint32_t rated_mnm) {
  return (float)permille * (float)rated_mnm / 1e6f;
}

/* Returns the sum, saturated. */
int32_t drive_add(int32_t a, int32_t b);

#endif
