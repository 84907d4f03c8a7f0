/* SPDX-License-Identifier: Apache-2.0 */
/* Second-order filter section: low-pass and notch, by bilinear transform with prewarping at the named frequency.
 *
 *     y = (b0 + b1 z^-1 + b2 z^-2) / (1 + a1 z^-1 + a2 z^-2) x     (transposed direct form II)
 *
 * Coefficients are designed when a parameter is set; the tick costs five multiplications. */
#ifndef TRACKSERVO_CONTROL_BIQUAD_H
#define TRACKSERVO_CONTROL_BIQUAD_H

#include "base/status.h"

typedef struct {
  float b0, b1, b2;
  float a1, a2;
} biquad_params;

typedef struct {
  float s1, s2;
} biquad_state;

/* Range of the frequency, in turns per sample, and widest notch, in radians per sample. */
#define BIQUAD_LOWEST_TURNS 1e-3f
#define BIQUAD_HIGHEST_TURNS 0.49f
#define BIQUAD_WIDEST_RAD 2.8f

/* -3 dB width of a notch, as a share of its frequency. */
#define BIQUAD_NARROWEST_SHARE 1e-3f
#define BIQUAD_WIDEST_SHARE 2.0f

/* Returns parameters that pass the signal unchanged. */
biquad_params biquad_pass(void);

/* Designs a low-pass: unity gain at 0, 2nd-order roll-off; frequency 1e-3 .. 0.49 of the sampling rate, damping 0.1 ..
 * 2. On an error `*params` is left unchanged. */
control_status biquad_design_lowpass(biquad_params *params, float frequency_rad_s, float damping, float dt_s);

/* Designs a notch: unity gain at 0, gain `depth` (0 .. 1) at the frequency, which has the low-pass's range; -3 dB width
 * `width_rad_s` (for depth 0), 1e-3 .. 2 of the frequency and width_rad_s * dt_s <= 2.8. On an error `*params` is left
 * unchanged. */
control_status biquad_design_notch(biquad_params *params, float frequency_rad_s, float width_rad_s, float depth,
                                   float dt_s);

/* Checks that the filter is finite and stable: poles inside the unit circle (|a2| < 1, |a1| < 1 + a2). */
control_status biquad_check(const biquad_params *params);

/* Returns the gain at this frequency, 0 .. pi rad per sample. */
float biquad_gain(const biquad_params *params, float omega_rad);

/* Settles the filter at a constant input (with unity gain at 0 the output starts at `input`). */
void biquad_reset(biquad_state *state, const biquad_params *params, float input);

static inline float biquad_step(biquad_state *state, const biquad_params *params, float input) {
  const float output = params->b0 * input + state->s1;
  state->s1 = params->b1 * input - params->a1 * output + state->s2;
  state->s2 = params->b2 * input - params->a2 * output;
  return output;
}

#endif
