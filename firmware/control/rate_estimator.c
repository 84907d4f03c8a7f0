/* SPDX-License-Identifier: Apache-2.0 */
#include "control/rate_estimator.h"

#include <stdbool.h>

control_status rate_estimator_check(const rate_estimator_params *params) {
  const bool in_range = params->window_ticks >= 2 && params->window_ticks <= RATE_ESTIMATOR_MAX_WINDOW;
  return in_range ? CONTROL_OK : CONTROL_OUT_OF_RANGE;
}

void rate_estimator_reset(rate_estimator_state *state, angle_turn32 angle) {
  for (int i = 0; i < RATE_ESTIMATOR_MAX_WINDOW; ++i) {
    state->history[i] = angle;
  }
  state->newest = 0;
}

float rate_estimator_step(rate_estimator_state *state, const rate_estimator_params *params, angle_turn32 angle,
                          float dt_s) {
  state->newest = (state->newest + 1u) % RATE_ESTIMATOR_MAX_WINDOW;
  state->history[state->newest] = angle;

  if (params->window_ticks == 2) { /* the usual one, in a third of the instructions */
    const angle_turn32 last = state->history[(state->newest - 1u) % RATE_ESTIMATOR_MAX_WINDOW];
    return (float)(int32_t)(angle - last) * ANGLE_RAD_PER_TURN32 / dt_s;
  }

  /* Slope of a line through N points at ages 0 .. N-1 ticks: sum (age_mean - age) angle / sum (age - age_mean)^2. */
  const int n = params->window_ticks;
  float weight = 0.5f * (float)(n - 1);
  float weighted_turn32 = 0.0f;
  unsigned place = state->newest;
  /* Bound: RATE_ESTIMATOR_WINDOW_MAX: window_ticks is checked when parameters are set. */
  for (int age = n - 1; age > 0; --age) {
    place = (place - 1u) % RATE_ESTIMATOR_MAX_WINDOW;
    weight -= 1.0f;
    weighted_turn32 += weight * (float)(int32_t)(state->history[place] - angle);
  }
  const float twelve_spreads = (float)(n * (n * n - 1));
  return weighted_turn32 * (12.0f * ANGLE_RAD_PER_TURN32) / (twelve_spreads * dt_s);
}
