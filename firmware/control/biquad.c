/* SPDX-License-Identifier: Apache-2.0 */
#include "control/biquad.h"

#include <math.h>

#include "base/scalar.h"

biquad_params biquad_pass(void) { return (biquad_params){.b0 = 1.0f}; }

/* Values at a limit of their range are taken, however their products are rounded. */
#define ROUNDING 1e-6f

static control_status check_frequency(float frequency_rad_s, float dt_s) {
  const float rad_per_turn = 2.0f * SCALAR_PI;
  const scalar_range range = {frequency_rad_s * dt_s, (1.0f - ROUNDING) * BIQUAD_LOWEST_TURNS * rad_per_turn,
                              (1.0f + ROUNDING) * BIQUAD_HIGHEST_TURNS * rad_per_turn};
  return scalar_check_ranges(&range, 1);
}

/* Denominator 1 + a1 z^-1 + a2 z^-2 of a resonance at w; `spread` = damping * sin(w dt). */
static void set_poles(biquad_params *params, float angle_rad, float spread) {
  const float half_sine = scalar_sin(0.5f * angle_rad);
  const float cosine = 1.0f - 2.0f * half_sine * half_sine; /* rounded once, also near 1 */
  params->a1 = -2.0f * cosine / (1.0f + spread);
  params->a2 = (1.0f - spread) / (1.0f + spread);
}

control_status biquad_design_lowpass(biquad_params *params, float frequency_rad_s, float damping, float dt_s) {
  const scalar_range range = {damping, 0.1f, 2.0f};
  control_status status = check_frequency(frequency_rad_s, dt_s);
  if (status == CONTROL_OK) {
    status = scalar_check_ranges(&range, 1);
  }
  if (status != CONTROL_OK) {
    return status;
  }
  const float angle_rad = frequency_rad_s * dt_s;
  set_poles(params, angle_rad, damping * scalar_sin(angle_rad));
  /* (1 - cos)/2 / (1 + spread), taken from the rounded poles, so that the gain at 0 is exactly 1. */
  params->b0 = 0.25f * (1.0f + params->a1 + params->a2);
  params->b1 = 2.0f * params->b0;
  params->b2 = params->b0;
  return CONTROL_OK;
}

control_status biquad_design_notch(biquad_params *params, float frequency_rad_s, float width_rad_s, float depth,
                                   float dt_s) {
  const scalar_range ranges[] = {
      {width_rad_s, (1.0f - ROUNDING) * BIQUAD_NARROWEST_SHARE * frequency_rad_s,
       (1.0f + ROUNDING) * BIQUAD_WIDEST_SHARE * frequency_rad_s},
      {width_rad_s * dt_s, 0.0f, (1.0f + ROUNDING) * BIQUAD_WIDEST_RAD},
      {depth, 0.0f, 1.0f},
  };
  control_status status = check_frequency(frequency_rad_s, dt_s);
  if (status == CONTROL_OK) {
    status = scalar_check_ranges(ranges, 3);
  }
  if (status != CONTROL_OK) {
    return status;
  }
  const float half_width_rad = 0.5f * width_rad_s * dt_s;
  const float spread = scalar_sin(half_width_rad) / scalar_cos(half_width_rad); /* prewarps the width as well */
  set_poles(params, frequency_rad_s * dt_s, spread);
  params->b0 = (1.0f + depth * spread) / (1.0f + spread);
  params->b1 = params->a1;
  params->b2 = params->a2 + (1.0f - params->b0); /* unity gain at 0 with the rounded poles */
  return CONTROL_OK;
}

/* |c0 + c1 q + c2 q^2| with q = exp(-j w): as |q| = 1, of c0 / q + c1 + c2 q. */
static float size_at(float c0, float c1, float c2, float cosine, float sine) {
  const float re = (c0 + c2) * cosine + c1;
  const float im = (c0 - c2) * sine;
  return sqrtf(re * re + im * im);
}

float biquad_gain(const biquad_params *params, float omega_rad) {
  const float cosine = scalar_cos(omega_rad);
  const float sine = scalar_sin(omega_rad);
  return size_at(params->b0, params->b1, params->b2, cosine, sine) /
         size_at(1.0f, params->a1, params->a2, cosine, sine);
}

control_status biquad_check(const biquad_params *params) {
  const scalar_range ranges[] = {
      {params->b0, -1e3f, 1e3f}, {params->b1, -1e3f, 1e3f}, {params->b2, -1e3f, 1e3f},
      {params->a1, -2.0f, 2.0f}, {params->a2, -1.0f, 1.0f},
  };
  const control_status status = scalar_check_ranges(ranges, 5);
  if (status != CONTROL_OK) {
    return status;
  }
  const bool stable = scalar_abs(params->a2) < 1.0f && scalar_abs(params->a1) < 1.0f + params->a2;
  return stable ? CONTROL_OK : CONTROL_INCONSISTENT;
}

void biquad_reset(biquad_state *state, const biquad_params *params, float input) {
  const float gain = (params->b0 + params->b1 + params->b2) / (1.0f + params->a1 + params->a2);
  const float output = gain * input;
  state->s1 = output - params->b0 * input;
  state->s2 = params->b2 * input - params->a2 * output;
}
