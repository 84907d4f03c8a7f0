/* SPDX-License-Identifier: Apache-2.0 */
#include "base/scalar.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* 2^exponent for -126 <= exponent <= 0, written into the exponent field of an IEEE 754 single. */
static float power_of_two(int32_t exponent) {
  const uint32_t bits = (uint32_t)(exponent + 127) << 23;
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

float scalar_exp_minus(float x) {
  if (x >= 87.0f) {
    return 0.0f;
  }
  /* exp(-x) = 2^-n * exp(-r) with |r| <= ln(2)/2; ln(2) is split so that r keeps its low bits. */
  const float ln2_high = 0.693359375f;
  const float ln2_low = -2.12194440e-4f;
  const int32_t n = (int32_t)(x * 1.44269504f + 0.5f);
  const float turns = (float)n;
  const float r = -((x - turns * ln2_high) - turns * ln2_low);
  /* 1 + r + r^2 q(r); q has the least relative error, 4e-9, and comes from tools/minimax/exp_series.py. */
  float series = 0.00138146128f;
  series = series * r + 0.00836871006f;
  series = series * r + 0.041668389f;
  series = series * r + 0.166665211f;
  series = series * r + 0.49999994f;
  series = series * r + 1.0f;
  series = series * r + 1.0f;
  return series * power_of_two(-n);
}

/* sin on [-pi/2, pi/2] by its Taylor series to x^11. */
static float sin_centred(float x) {
  const float square = x * x;
  float series = -1.0f / 39916800.0f;
  series = series * square + 1.0f / 362880.0f;
  series = series * square - 1.0f / 5040.0f;
  series = series * square + 1.0f / 120.0f;
  series = series * square - 1.0f / 6.0f;
  series = series * square + 1.0f;
  return series * x;
}

float scalar_sin(float angle_rad) {
  return sin_centred(angle_rad > 0.5f * SCALAR_PI ? SCALAR_PI - angle_rad : angle_rad);
}

float scalar_cos(float angle_rad) { return sin_centred(0.5f * SCALAR_PI - angle_rad); }

/* atan for 0 <= x <= 1. */
static float atan_of_share(float x) {
  const float tan_of_eighth = 0.414213562f;
  const bool upper = x > tan_of_eighth;
  const float z = upper ? (x - 1.0f) / (x + 1.0f) : x; /* atan(x) = pi/4 + atan((x - 1) / (x + 1)) */
  const float square = z * z;
  /* z + z^3 q(z^2); q has the least relative error, 2.2e-8, and comes from tools/minimax/atan_series.py. */
  float series = 0.0805372298f;
  series = series * square - 0.138776794f;
  series = series * square + 0.199777097f;
  series = series * square - 0.333329499f;
  return (upper ? 0.25f * SCALAR_PI : 0.0f) + (z + z * square * series);
}

float scalar_atan2(float y, float x) {
  const float up = scalar_abs(y);
  const float along = scalar_abs(x);
  if (up == 0.0f && along == 0.0f) {
    return 0.0f;
  }
  const bool steep = up > along;
  const float share = atan_of_share(steep ? along / up : up / along);
  const float first = steep ? 0.5f * SCALAR_PI - share : share; /* in the first quadrant */
  const float turned = x < 0.0f ? SCALAR_PI - first : first;
  return y < 0.0f ? -turned : turned;
}

control_status scalar_check_ranges(const scalar_range *ranges, int count) {
  /* Bound: length of the caller's array of ranges, which is constant. */
  for (int i = 0; i < count; ++i) {
    if (!isfinite(ranges[i].value)) {
      return CONTROL_NOT_FINITE;
    }
    if (ranges[i].value < ranges[i].low || ranges[i].value > ranges[i].high) {
      return CONTROL_OUT_OF_RANGE;
    }
  }
  return CONTROL_OK;
}
