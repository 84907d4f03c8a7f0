/* SPDX-License-Identifier: Apache-2.0 */
#include "control/lugre.h"

#include "base/scalar.h"

static control_status check_direction(const lugre_direction *d, float stiffness_nm_rad) {
  const scalar_range ranges[] = {
      {d->coulomb_nm, 1e-6f, 1e4f},
      {d->breakaway_nm, 1e-6f, 1e4f},
      {d->stribeck_speed_rad_s, 1e-6f, 1e2f},
      {d->viscous_nm_s_rad, 0.0f, 1e4f},
  };
  const control_status status = scalar_check_ranges(ranges, 4);
  if (status != CONTROL_OK) {
    return status;
  }
  if (d->breakaway_nm < d->coulomb_nm || d->breakaway_nm > stiffness_nm_rad) {
    return CONTROL_INCONSISTENT;
  }
  return CONTROL_OK;
}

control_status lugre_check(const lugre_params *params) {
  const scalar_range ranges[] = {
      {params->stiffness_nm_rad, 1e-3f, 1e9f},
      {params->damping_nm_s_rad, 0.0f, 1e6f},
  };
  control_status status = scalar_check_ranges(ranges, 2);
  if (status == CONTROL_OK) {
    status = check_direction(&params->positive, params->stiffness_nm_rad);
  }
  if (status == CONTROL_OK) {
    status = check_direction(&params->negative, params->stiffness_nm_rad);
  }
  return status;
}

void lugre_reset(lugre_state *state) { state->deflection_rad = 0.0f; }

static const lugre_direction *direction_of(const lugre_params *params, float speed_rad_s) {
  return speed_rad_s >= 0.0f ? &params->positive : &params->negative;
}

float lugre_stribeck_nm(const lugre_direction *direction, float speed_rad_s) {
  const float ratio = scalar_min(scalar_abs(speed_rad_s) / direction->stribeck_speed_rad_s, 10.0f);
  return direction->coulomb_nm + (direction->breakaway_nm - direction->coulomb_nm) * scalar_exp_minus(ratio * ratio);
}

float lugre_steady_nm(const lugre_params *params, float speed_rad_s) {
  if (speed_rad_s == 0.0f) {
    return 0.0f;
  }
  const lugre_direction *direction = direction_of(params, speed_rad_s);
  const float level_nm = lugre_stribeck_nm(direction, speed_rad_s);
  return (speed_rad_s > 0.0f ? level_nm : -level_nm) + direction->viscous_nm_s_rad * speed_rad_s;
}

void lugre_settle(lugre_state *state, const lugre_params *params, float speed_rad_s) {
  const float viscous_nm = direction_of(params, speed_rad_s)->viscous_nm_s_rad * speed_rad_s;
  state->deflection_rad = (lugre_steady_nm(params, speed_rad_s) - viscous_nm) / params->stiffness_nm_rad;
}

/* The two functions of x = rate * dt that solve dz/dt = slope - rate (z - z0) over one tick:
 * the end point moves by slope dt end(x), the mean by slope dt mean(x). */
typedef struct {
  float end;  /* (1 - exp(-x)) / x */
  float mean; /* (x - 1 + exp(-x)) / x^2 */
} bristle_weights;

static bristle_weights weights_of(float x) {
  bristle_weights w;
  if (x < 0.5f) {
    /* Series, because the closed forms cancel here; remainder below 3e-8. */
    const float tail = 1.0f / 720.0f - x * (1.0f / 5040.0f - x / 40320.0f);
    w.mean = 0.5f - x * (1.0f / 6.0f - x * (1.0f / 24.0f - x * (1.0f / 120.0f - x * tail)));
    w.end = 1.0f - x * w.mean;
  } else {
    w.end = (1.0f - scalar_exp_minus(x)) / x;
    w.mean = (1.0f - w.end) / x;
  }
  return w;
}

float lugre_step(lugre_state *state, const lugre_params *params, float speed_rad_s, float dt_s) {
  const lugre_direction *direction = direction_of(params, speed_rad_s);
  const float magnitude_rad_s = scalar_abs(speed_rad_s);
  const float level_nm = lugre_stribeck_nm(direction, speed_rad_s);
  const float rate_per_s = params->stiffness_nm_rad * magnitude_rad_s / level_nm;
  const bristle_weights weight = weights_of(rate_per_s * dt_s);

  const float z0_rad = state->deflection_rad;
  const float slope_rad_s = speed_rad_s - rate_per_s * z0_rad; /* eq. (2) at the start of the tick */
  const float mean_rad = z0_rad + slope_rad_s * dt_s * weight.mean;
  const float mean_slope_rad_s = slope_rad_s * weight.end;
  state->deflection_rad = z0_rad + dt_s * mean_slope_rad_s;

  float damping_nm_s_rad = params->damping_nm_s_rad;
  if (damping_nm_s_rad * magnitude_rad_s > 4.0f * level_nm) {
    damping_nm_s_rad = 4.0f * level_nm / magnitude_rad_s; /* keeps the model passive; see the header */
  }
  return params->stiffness_nm_rad * mean_rad + damping_nm_s_rad * mean_slope_rad_s +
         direction->viscous_nm_s_rad * speed_rad_s;
}
