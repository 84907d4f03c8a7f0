/* SPDX-License-Identifier: Apache-2.0 */
#include "protection/oscillation.h"

#include "base/scalar.h"

/* Swings of the rate error, peak to peak. */
#define VISIBLE_RAD_S 0.0175f /* 1 deg/s: below it nobody sees a motion */
#define RETREAT_SHARE 0.3f    /* a turning point: this share of the swing is taken back */
#define RETREAT_RAD_S 0.0044f
#define UNEXPLAINED_RATIO 2.5f /* swing over the impulse that would explain it; 2 is the usual peak of |S| */
#define DECAY 0.7f             /* smaller than this share of the swing before: it dies out */
#define GROWTH 1.5f            /* larger: it diverges */
#define STEPPED_RATIO 2.5f     /* swing over a recent change of the set-point, of which the loop may still recover */
#define STEPPED_S 0.1f
#define STEPPED_FADES_S 0.2f
#define LONGEST_SWING_TICKS 600.0f
#define STEADY_SWINGS 4.0f
#define GROWING_SWINGS 3.0f
/* Two swings in a row of new gains suffice, if they are slow and nothing from outside changes meanwhile: half a second
 * has no more of them. */
#define SLOW_TICKS 300.0f
#define UNCHANGED_TORQUE 0.02f /* share of the motor's torque */
/* A swing that is smaller than half of the visible one for this time has not begun. */
#define QUIET_TICKS 100.0f

/* Swings of the torque, peak to peak. */
#define SHAKING_TORQUE 0.5f              /* smallest swing, as a share of the motor's torque */
#define LONGEST_TORQUE_SWING_TICKS 20.0f /* 25 Hz and faster */
#define EXCITED_RATIO 2.0f /* swing over the range of what comes from outside; 1.5 is the usual peak of |T| */
#define EXCITED_FADES_S 0.1f
#define TORQUE_SWINGS 16.0f /* of the smallest size; one from limit to limit counts as four */
#define PROVEN_TORQUE_SWINGS 48.0f

/* Torque that drives the axis away from its set-point, as a share of the motor's. A step of the set-point makes healthy
 * loops overshoot; at rest they never do. */
#define WRONG_TORQUE 0.6f
#define WRONG_TICKS 4.0f
#define WRONG_TORQUE_AT_REST 0.12f
#define WRONG_TORQUE_IN_TRACKING 0.15f /* the camera may want it */
#define WRONG_TICKS_AT_REST 2.0f

#define MEAN_S 0.3f /* of the torque: static loads */

void oscillation_reset(oscillation *state) {
  *state = (oscillation){.rate = {.rising = 1.0f}, .torque = {.rising = 1.0f}};
}

/* Returns true when `now` has turned: then `to` is the turning point. */
static bool has_turned(oscillation_swings *swings, float now, float retreat) {
  swings->since += 1.0f;
  const float beyond = swings->rising * (now - swings->to);
  if (beyond >= 0.0f) {
    swings->to = now;
    swings->ticks += swings->since;
    swings->since = 0.0f;
    return false;
  }
  return -beyond > retreat;
}

static void turn(oscillation_swings *swings, float now) {
  swings->before = scalar_abs(swings->to - swings->from);
  swings->from = swings->to;
  swings->to = now;
  swings->ticks = swings->since;
  swings->since = 0.0f;
  swings->rising = -swings->rising;
}

/* A swing begins where the axis leaves its quiet: what happened before has no part in it. */
static void begin_at(oscillation *state, float now) {
  state->rate = (oscillation_swings){.from = now, .to = now, .rising = state->rate.rising};
  state->impulse = 0.0f;
  state->impulse_to = 0.0f;
  state->lasted = 0.0f;
}

/* Whether the motor made this swing. */
static bool made_by_motor(const oscillation *state, const oscillation_params *params, float size, float dt_s) {
  const float friction_nm_s = params->friction_nm * state->rate.ticks * dt_s;
  const float unexplained_nm_s = scalar_abs(state->impulse_to) - friction_nm_s;
  return params->inertia_kg_m2 * size > UNEXPLAINED_RATIO * unexplained_nm_s;
}

static float smallest_rad_s(const oscillation *state) {
  return scalar_max(VISIBLE_RAD_S, STEPPED_RATIO * state->stepped_rad_s);
}

static bool rate_shakes(oscillation *state, const oscillation_params *params, const oscillation_inputs *in,
                        float error_rad_s, float dt_s) {
  oscillation_swings *swings = &state->rate;
  const bool turned =
      has_turned(swings, error_rad_s, scalar_max(RETREAT_SHARE * scalar_abs(swings->to - swings->from), RETREAT_RAD_S));
  if (swings->since == 0.0f) {
    state->impulse_to = state->impulse;
  }
  const float size = scalar_abs(swings->to - swings->from);
  const bool counts = size >= smallest_rad_s(state) && size >= DECAY * swings->before &&
                      swings->ticks < LONGEST_SWING_TICKS && made_by_motor(state, params, size, dt_s);
  const bool grows =
      params->suspect && counts && size >= GROWTH * swings->before && swings->count >= GROWING_SWINGS - 1.0f;
  const float lasted = state->lasted + swings->ticks;
  const bool left_alone = in->reference_known && state->unchanged >= lasted && smallest_rad_s(state) <= VISIBLE_RAD_S;
  const bool slow = params->suspect && counts && swings->count >= 1.0f && lasted >= SLOW_TICKS && left_alone;
  const bool shakes = grows || slow || (counts && swings->count >= STEADY_SWINGS - 1.0f);
  if (turned) {
    swings->count = counts ? swings->count + 1.0f : 0.0f;
    state->lasted = counts ? lasted : 0.0f;
    turn(swings, error_rad_s);
    state->impulse -= state->impulse_to;
    state->impulse_to = state->impulse;
  } else if (swings->since > QUIET_TICKS && size < 0.5f * VISIBLE_RAD_S) {
    begin_at(state, error_rad_s);
  }
  return shakes;
}

static bool torque_shakes(oscillation *state, const oscillation_params *params, float loop_nm) {
  oscillation_swings *swings = &state->torque;
  const float min_nm = SHAKING_TORQUE * params->torque_nm;
  if (swings->since > LONGEST_TORQUE_SWING_TICKS) {
    swings->count = 0.0f;
  }
  if (has_turned(swings, loop_nm, 0.5f * min_nm)) {
    const float size = scalar_abs(swings->to - swings->from);
    const float explained_nm = EXCITED_RATIO * (state->outside_high_nm - state->outside_low_nm);
    const bool counts = size >= scalar_max(min_nm, explained_nm) && swings->ticks < LONGEST_TORQUE_SWING_TICKS;
    swings->count = counts ? scalar_min(swings->count + size / min_nm, PROVEN_TORQUE_SWINGS) : 0.0f;
    turn(swings, loop_nm);
  }
  return swings->count >= (params->suspect ? TORQUE_SWINGS : PROVEN_TORQUE_SWINGS);
}

/* The first swing of a loop with much delay: it accelerates beyond the set-point with full torque, and nothing from
 * outside explains it. */
static bool drives_away(oscillation *state, const oscillation_params *params, const oscillation_inputs *in,
                        float error_rad_s, float dt_s) {
  const float wrong_nm = -(state->last_feedback_nm - state->mean_back_nm) * (error_rad_s < 0.0f ? -1.0f : 1.0f);
  const float size = scalar_abs(state->rate.to - state->rate.from);
  const float smallest = smallest_rad_s(state);
  const bool at_rest = smallest <= VISIBLE_RAD_S;
  const float rest_share = in->reference_known ? WRONG_TORQUE_AT_REST : WRONG_TORQUE_IN_TRACKING;
  const float wrong_share = at_rest ? rest_share : WRONG_TORQUE;
  const bool away = params->suspect && scalar_abs(error_rad_s) >= 0.5f * smallest && size >= smallest &&
                    state->rate.since == 0.0f && wrong_nm > wrong_share * params->torque_nm &&
                    made_by_motor(state, params, size, dt_s);
  const bool much = at_rest && wrong_nm > WRONG_TORQUE * params->torque_nm; /* it accelerates by 1 deg/s in a tick */
  state->wrong_ticks = away ? state->wrong_ticks + (much ? WRONG_TICKS_AT_REST : 1.0f) : 0.0f;
  return state->wrong_ticks >= (at_rest ? WRONG_TICKS_AT_REST : WRONG_TICKS);
}

bool oscillation_step(oscillation *state, const oscillation_params *params, const oscillation_inputs *in, float dt_s) {
  if (!in->closed) {
    oscillation_reset(state);
    return false;
  }
  const float error_rad_s = in->reference_rad_s - in->rate_rad_s;
  /* The rate is the mean of a tick: it has seen the torques of two commands. */
  const float acting_nm = 0.5f * (in->loop_nm + state->last_loop_nm);
  state->mean_nm += (acting_nm - state->mean_nm) * (dt_s / MEAN_S);
  state->mean_back_nm += (in->loop_nm - in->feedforward_nm - state->mean_back_nm) * (dt_s / MEAN_S);
  state->impulse +=
      params->inertia_kg_m2 * (error_rad_s - state->last_error_rad_s) + (acting_nm - state->mean_nm) * dt_s;
  const float required_nm = params->inertia_kg_m2 * (in->reference_rad_s - state->last_reference_rad_s) / dt_s;
  const float outside_nm = scalar_clamp(required_nm + in->added_nm, -params->torque_nm, params->torque_nm);
  const float fades = dt_s / EXCITED_FADES_S;
  state->outside_high_nm =
      scalar_max(outside_nm, state->outside_high_nm + (outside_nm - state->outside_high_nm) * fades);
  state->outside_low_nm = scalar_min(outside_nm, state->outside_low_nm + (outside_nm - state->outside_low_nm) * fades);
  const bool changes = state->outside_high_nm - state->outside_low_nm > UNCHANGED_TORQUE * params->torque_nm;
  state->unchanged = changes ? 0.0f : state->unchanged + 1.0f;
  state->last_error_rad_s = error_rad_s;
  state->last_loop_nm = in->loop_nm;
  state->last_feedback_nm = in->loop_nm - in->feedforward_nm;
  state->last_reference_rad_s = in->reference_rad_s;
  state->slow_reference_rad_s += (in->reference_rad_s - state->slow_reference_rad_s) * (dt_s / STEPPED_S);
  const float stepped_rad_s = scalar_abs(in->reference_rad_s - state->slow_reference_rad_s);
  state->stepped_rad_s = scalar_max(stepped_rad_s, state->stepped_rad_s * (1.0f - dt_s / STEPPED_FADES_S));
  const bool rate = rate_shakes(state, params, in, error_rad_s, dt_s);
  const bool away = drives_away(state, params, in, error_rad_s, dt_s);
  const bool torque = torque_shakes(state, params, in->loop_nm);
  return rate || torque || away;
}
