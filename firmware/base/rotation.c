/* SPDX-License-Identifier: Apache-2.0 */
#include "base/rotation.h"

/* By their Taylor series, for |x| <= pi / 4. */
static float sine_of_eighth(float x) {
  const float square = x * x;
  float series = 1.0f / 362880.0f;
  series = series * square - 1.0f / 5040.0f;
  series = series * square + 1.0f / 120.0f;
  series = series * square - 1.0f / 6.0f;
  return x + x * square * series;
}

static float cosine_of_eighth(float x) {
  const float square = x * x;
  float series = -1.0f / 3628800.0f;
  series = series * square + 1.0f / 40320.0f;
  series = series * square - 1.0f / 720.0f;
  series = series * square + 1.0f / 24.0f;
  series = series * square - 0.5f;
  return 1.0f + square * series;
}

rotation rotation_of(angle_turn32 angle) {
  const angle_turn32 eighth = UINT32_C(1) << 29;
  const uint32_t quadrant = (angle + eighth) >> 30;
  const float rest_rad = angle_difference_rad(angle, quadrant << 30);
  const float sine = sine_of_eighth(rest_rad);
  const float cosine = cosine_of_eighth(rest_rad);
  const float along[] = {sine, cosine, -sine, -cosine}; /* the cosine is the sine of a quarter turn later */
  return (rotation){.sine = along[quadrant], .cosine = along[(quadrant + 1u) % 4u]};
}

float rotation_cosine(angle_turn32 angle) {
  const angle_turn32 eighth = UINT32_C(1) << 29;
  const uint32_t quadrant = (angle + eighth) >> 30;
  const float rest_rad = angle_difference_rad(angle, quadrant << 30);
  const float size = quadrant % 2u == 0u ? cosine_of_eighth(rest_rad) : sine_of_eighth(rest_rad);
  return quadrant == 1u || quadrant == 2u ? -size : size;
}
