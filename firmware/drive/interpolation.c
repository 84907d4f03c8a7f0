/* SPDX-License-Identifier: Apache-2.0 */
#include "drive/interpolation.h"

#include "base/scalar.h"

int interpolation_ticks(uint8_t period, int8_t exponent, float dt_s) {
  float period_s = (float)period;
  /* Bound: 128: i begins with an int8_t. */
  for (int8_t i = exponent; i < 0 && period_s > 0.0f; ++i) { /* at most 128 */
    period_s /= 10.0f;
  }
  const float ticks = scalar_round(period_s / dt_s);
  const bool usable = exponent <= 0 && ticks >= 1.0f && ticks <= (float)INTERPOLATION_MAX_TICKS;
  return usable ? (int)ticks : 0;
}

bool interpolation_stale(int age_ticks, int period_ticks) {
  return age_ticks > INTERPOLATION_HELD_TICKS && age_ticks > INTERPOLATION_HELD_PERIODS * period_ticks;
}

void rate_interpolation_reset(rate_interpolation *state, float rate_rad_s) {
  *state = (rate_interpolation){.rate_rad_s = rate_rad_s, .target_rad_s = rate_rad_s};
}

void rate_interpolation_aim(rate_interpolation *state, float target_rad_s, int period_ticks, float dt_s) {
  state->target_rad_s = target_rad_s;
  state->slope_rad_s2 = (target_rad_s - state->rate_rad_s) / ((float)period_ticks * dt_s);
  state->left_ticks = period_ticks;
}

interpolated_rate rate_interpolation_step(rate_interpolation *state, float dt_s) {
  const bool moving = state->left_ticks > 0;
  const interpolated_rate now = {.rate_rad_s = state->rate_rad_s,
                                 .acceleration_rad_s2 = moving ? state->slope_rad_s2 : 0.0f};
  state->left_ticks -= moving ? 1 : 0;
  state->rate_rad_s = state->target_rad_s - state->slope_rad_s2 * ((float)state->left_ticks * dt_s);
  return now;
}

void position_interpolation_reset(position_interpolation *state, drive_angle position, float rate_rad_s) {
  /* Every field is named: to clear all of it first would be a call. */
  *state = (position_interpolation){
      .last = position,
      .last_travel_rad = 0.0f,
      .known_points = 1,
      .start = position,
      .end = position,
      .travel_rad = 0.0f,
      .start_rad_s = rate_rad_s,
      .end_rad_s = rate_rad_s,
      .elapsed_ticks = 0,
      .period_ticks = 0,
  };
}

static drive_angle moved(drive_angle from, float travel_rad) {
  return from + angle_integer(scalar_round(travel_rad / ANGLE_RAD_PER_TURN32));
}

/* The present demand and its rate. Distances are measured from the end, where they vanish. */
static interpolated_position evaluate(const position_interpolation *state, float dt_s) {
  if (state->elapsed_ticks == 0) {
    return (interpolated_position){.position = state->start, .rate_rad_s = state->start_rad_s};
  }
  const float time_s = (float)state->elapsed_ticks * dt_s;
  const float period_s = (float)state->period_ticks * dt_s;
  if (state->elapsed_ticks >= state->period_ticks) {
    return (interpolated_position){.position = moved(state->end, state->end_rad_s * (time_s - period_s)),
                                   .rate_rad_s = state->end_rad_s};
  }
  const float mean_rad_s = state->travel_rad / period_s;
  const float start_rad_s = state->start_rad_s - mean_rad_s;
  const float end_rad_s = state->end_rad_s - mean_rad_s;
  const float u = time_s / period_s;
  const float rest = 1.0f - u;
  /* The straight line and its curvature. */
  const float ahead_rad_s = mean_rad_s - u * (rest * start_rad_s - u * end_rad_s);
  const float rate_rad_s = mean_rad_s + rest * (1.0f - 3.0f * u) * start_rad_s - u * (2.0f - 3.0f * u) * end_rad_s;
  return (interpolated_position){.position = moved(state->end, -ahead_rad_s * rest * period_s),
                                 .rate_rad_s = rate_rad_s};
}

/* The slope at the newest of the last set-points, of the parabola (or line) through them. */
static float slope_at_end(const position_interpolation *state, float before_rad, float period_s) {
  if (state->known_points < INTERPOLATION_POINTS) {
    return state->last_travel_rad / period_s;
  }
  return (1.5f * state->last_travel_rad - 0.5f * before_rad) / period_s;
}

bool position_interpolation_aim(position_interpolation *state, drive_angle target, int period_ticks,
                                float rate_limit_rad_s, float dt_s) {
  const float period_s = (float)period_ticks * dt_s;
  const interpolated_position now = evaluate(state, dt_s);
  const float before_rad = state->last_travel_rad;
  state->last_travel_rad = drive_angle_difference_rad(target, state->last);
  state->last = target;
  state->known_points += state->known_points < INTERPOLATION_POINTS ? 1 : 0;

  const float wanted_rad = drive_angle_difference_rad(target, now.position);
  const float longest_rad = rate_limit_rad_s * period_s;
  const bool cut = scalar_abs(wanted_rad) > longest_rad;
  state->travel_rad = scalar_clamp(wanted_rad, -longest_rad, longest_rad);
  state->end = cut ? moved(now.position, state->travel_rad) : target;
  state->start = now.position;
  state->start_rad_s = now.rate_rad_s;
  state->end_rad_s = scalar_clamp(slope_at_end(state, before_rad, period_s), -rate_limit_rad_s, rate_limit_rad_s);
  state->elapsed_ticks = 0;
  state->period_ticks = period_ticks;
  return cut;
}

interpolated_position position_interpolation_step(position_interpolation *state, float dt_s) {
  const interpolated_position now = evaluate(state, dt_s);
  if (state->elapsed_ticks < INT32_MAX) {
    ++state->elapsed_ticks;
  }
  return now;
}
