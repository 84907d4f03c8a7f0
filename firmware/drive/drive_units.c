/* SPDX-License-Identifier: Apache-2.0 */
#include "drive/drive_units.h"

#include <math.h>
#include <string.h>

#include "base/scalar.h"

/* Binary fixed point, from 2 pi to 60 digits. Counts per turn: 2 pi 1e7 in 2^-30; units of 2^-32 turn per count: 2^32 /
 * (2 pi 1e7) in 2^-56. */
#define COUNTS_PER_TURN_Q30 UINT64_C(67465188522610095)
#define UNITS_PER_COUNT_Q56 UINT64_C(4925606912591084349)
#define COUNTS_FRACTION_BITS 30
#define UNITS_FRACTION_BITS 24 /* of 56, 32 are dropped with the low half of the product */

/* Of IEEE 754 single precision; the exponent counts from the mantissa's highest bit. */
enum { MANTISSA_BITS = 23, EXPONENT_BIAS = 127, LONGEST_PRODUCT_BITS = 46 };

/* No 32-bit position is farther away than this: 64 turns. */
#define FARTHEST_ANGLE (INT64_C(1) << 38)

static uint64_t magnitude_of(int64_t value) { return value < 0 ? (uint64_t)-value : (uint64_t)value; }

static int32_t saturated(int64_t value) {
  if (value > INT32_MAX) {
    return INT32_MAX;
  }
  return value < INT32_MIN ? INT32_MIN : (int32_t)value;
}

static int64_t signed_like(uint64_t magnitude, bool negative) {
  return negative ? -(int64_t)magnitude : (int64_t)magnitude;
}

int32_t drive_position_from_angle(drive_angle angle) {
  if (angle >= FARTHEST_ANGLE) {
    return INT32_MAX;
  }
  if (angle <= -FARTHEST_ANGLE) {
    return INT32_MIN;
  }
  /* A product of 96 bits in halves, for processors that multiply 32 by 32. */
  const uint64_t x_high = magnitude_of(angle) >> 32;
  const uint64_t x_low = magnitude_of(angle) & UINT32_MAX;
  const uint64_t product = x_high * COUNTS_PER_TURN_Q30 + x_low * (COUNTS_PER_TURN_Q30 >> 32) +
                           ((x_low * (COUNTS_PER_TURN_Q30 & UINT32_MAX)) >> 32);
  const uint64_t counts = (product + (UINT64_C(1) << (COUNTS_FRACTION_BITS - 1))) >> COUNTS_FRACTION_BITS;
  return saturated(signed_like(counts, angle < 0));
}

/* round(|position| units / 2^56): a product of 128 bits in quarters. */
drive_angle drive_angle_from_position(int64_t position) {
  const uint64_t m_high = UNITS_PER_COUNT_Q56 >> 32;
  const uint64_t m_low = UNITS_PER_COUNT_Q56 & UINT32_MAX;
  const uint64_t x_high = magnitude_of(position) >> 32;
  const uint64_t x_low = magnitude_of(position) & UINT32_MAX;
  const uint64_t low = x_high * m_low + x_low * m_high + ((x_low * m_low) >> 32);
  const uint64_t rounded = (low + (UINT64_C(1) << (UNITS_FRACTION_BITS - 1))) >> UNITS_FRACTION_BITS;
  return signed_like(((x_high * m_high) << (32 - UNITS_FRACTION_BITS)) + rounded, position < 0);
}

int32_t drive_velocity_from_rate(float rate_rad_s) {
  uint32_t bits;
  memcpy(&bits, &rate_rad_s, sizeof bits);
  const bool negative = bits >> 31 != 0;
  const int shift = MANTISSA_BITS + EXPONENT_BIAS - (int)(bits >> MANTISSA_BITS & 0xFFu);
  if (shift > LONGEST_PRODUCT_BITS) {
    return 0; /* half a count at most */
  }
  if (shift <= 0) { /* beyond 1.6e7 rad/s, infinite, or not a number */
    return isnan(rate_rad_s) ? 0 : negative ? INT32_MIN : INT32_MAX;
  }
  /* |rate| = mantissa 2^-shift, and the product is exact: 24 bits times 20. */
  const uint32_t mantissa = (bits & ((1u << MANTISSA_BITS) - 1u)) | 1u << MANTISSA_BITS;
  const uint64_t product = mantissa * UINT64_C(1000000);
  const uint64_t counts = ((product >> (shift - 1)) + 1) >> 1;
  return saturated(signed_like(counts, negative));
}

int16_t drive_permille_from_torque(float torque_nm, uint32_t rated_mnm) {
  if (rated_mnm == 0 || isnan(torque_nm)) {
    return 0;
  }
  const float permille = torque_nm / (float)rated_mnm * 1e6f;
  return (int16_t)scalar_round(scalar_clamp(permille, (float)INT16_MIN, (float)INT16_MAX));
}

int32_t drive_add(int32_t a, int32_t b) { return saturated((int64_t)a + b); }
