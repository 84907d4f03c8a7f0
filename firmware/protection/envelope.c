#include "protection/envelope.h"

#include <math.h>

#include "base/scalar.h"

/* The rate is a mean over two ticks, so it is 1 ms old; a tick may pass until it is judged, and 1.5 ms until the
 * current has reversed. Its change is that over two ticks. */
#define AHEAD 1.75f

#define DEAD_TIME_S 0.004f
#define RATE_RESERVE 1.03f

/* The braking: its current falls with the rate below a Ts, and with the distance from where it holds. */
#define SOFT_S 0.02f
#define HOLD_S 0.06f

/* An ordered stop: how long it may take to begin, by how much it may overshoot, which share of the guarded deceleration
 * it must reach, and where it has ended. A ramp with limited jerk has no more at its beginning and end. */
#define STOP_BEGINS_S 0.5f
#define STOP_OVERSHOOT_RAD_S 0.1f
#define STOP_SHARE 0.5f

/* The braking must reach half of the sure deceleration after this time. */
#define BRAKING_BEGINS_S 0.01f
#define BRAKING_SHARE 0.5f

#define TURNS_RAD_S 0.02f  /* slower than this, an axis without power has come to rest */
#define REST_RAD_S 0.005f  /* the same for an axis that is braked, */
enum { REST_TICKS = 100 }; /* for this time */

#define OUTSIDE_RAD_S 0.01f /* beyond the end of the travel, noise and drift are no motion outwards */

void envelope_reset(envelope_state *state) { *state = (envelope_state){0}; }

static void sense(envelope_state *state, const envelope_inputs *in) {
  if (!in->angle_valid) {
    state->known = 0;
    return;
  }
  for (int i = ENVELOPE_ANGLES - 1; i > 0; --i) {
    state->angle[i] = state->angle[i - 1];
  }
  state->angle[0] = in->angle;
  state->known += state->known < ENVELOPE_ANGLES ? 1 : 0;
}

/* The rate by the time at which a braking that begins now has its current: only acceleration counts. */
static float rate_ahead_rad_s(envelope_state *state, float dt_s) {
  const float now_rad = angle_difference_rad(state->angle[0], state->angle[2]);
  const float before_rad = angle_difference_rad(state->angle[2], state->angle[4]);
  const float per_s = 0.5f / dt_s;
  state->rate_rad_s = now_rad * per_s;
  const float gain_rad = now_rad - before_rad;
  return now_rad * gain_rad > 0.0f ? (now_rad + AHEAD * gain_rad) * per_s : state->rate_rad_s;
}

static bool is_limited(const envelope_params *params) { return params->minimum_rad < params->maximum_rad; }

static bool too_fast(const envelope_params *params, float position_rad, float ahead_rad_s) {
  const float speed_rad_s = scalar_abs(ahead_rad_s);
  if (params->slow) {
    return speed_rad_s > ENVELOPE_SLOW_RAD_S;
  }
  if (!is_limited(params) || speed_rad_s < OUTSIDE_RAD_S) {
    return false;
  }
  const float room_rad = ahead_rad_s < 0.0f ? position_rad - params->minimum_rad : params->maximum_rad - position_rad;
  const float square = RATE_RESERVE * RATE_RESERVE * speed_rad_s * speed_rad_s;
  return square > 2.0f * params->deceleration_rad_s2 * (room_rad - DEAD_TIME_S * speed_rad_s);
}

/* Whether the axis still has the power, or the momentum, that the drive gave it. */
static void follow_power(envelope_state *state, const envelope_inputs *in) {
  state->turns = in->phase != ENVELOPE_UNTRUSTED &&
                 (in->powered || (state->turns && !scalar_within(state->rate_rad_s, TURNS_RAD_S)));
}

static bool stop_ignored(envelope_state *state, const envelope_params *params, const envelope_inputs *in, float dt_s) {
  const float speed_rad_s = scalar_abs(state->rate_rad_s);
  const bool ordered = in->phase == ENVELOPE_STOPPING || (state->stopping && in->phase == ENVELOPE_POWERLESS);
  if (!ordered || !state->turns) {
    state->stopping = false;
    return false;
  }
  if (!state->stopping) {
    state->stopping = true;
    state->stop_s = 0.0f;
    state->stop_limit_rad_s = speed_rad_s + STOP_OVERSHOOT_RAD_S;
  }
  state->stop_s += dt_s;
  if (state->stop_s > STOP_BEGINS_S) {
    const float slower_rad_s = state->stop_limit_rad_s - STOP_SHARE * params->stop_deceleration_rad_s2 * dt_s;
    state->stop_limit_rad_s = scalar_max(slower_rad_s, ENVELOPE_SLOW_RAD_S);
  }
  return speed_rad_s > state->stop_limit_rad_s;
}

/* The braking that began in the last tick at the latest. */
static void judge_braking(envelope_state *state, const envelope_params *params, const envelope_inputs *in,
                          envelope_output *out, float dt_s) {
  const float speed_rad_s = scalar_abs(state->rate_rad_s);
  if (in->phase != ENVELOPE_BRAKING) {
    state->braking = false;
    state->holds = false;
    state->rest_ticks = 0;
    return;
  }
  const float fall_rad_s2 = BRAKING_SHARE * params->deceleration_rad_s2;
  if (!state->braking) {
    state->braking = true;
    state->braking_limit_rad_s = speed_rad_s + (BRAKING_BEGINS_S + SOFT_S) * fall_rad_s2;
  }
  state->braking_limit_rad_s =
      scalar_max(state->braking_limit_rad_s - fall_rad_s2 * dt_s, SOFT_S * params->deceleration_rad_s2);
  out->braking_fails = speed_rad_s > state->braking_limit_rad_s;
  const int one_more = state->rest_ticks + (state->rest_ticks < REST_TICKS ? 1 : 0);
  state->rest_ticks = speed_rad_s < REST_RAD_S ? one_more : 0;
  out->at_rest = state->rest_ticks >= REST_TICKS;
}

static float braking_current(envelope_state *state, const envelope_params *params) {
  const float soft_rad_s = SOFT_S * params->deceleration_rad_s2;
  if (!state->holds && state->braking && scalar_abs(state->rate_rad_s) < soft_rad_s) {
    state->holds = true;
    state->held = state->angle[0];
  }
  const float away_rad = state->holds ? angle_difference_rad(state->angle[0], state->held) : 0.0f;
  return -scalar_clamp((state->rate_rad_s + away_rad / HOLD_S) / soft_rad_s, -1.0f, 1.0f);
}

envelope_output envelope_step(envelope_state *state, const envelope_params *params, const envelope_inputs *in,
                              float dt_s) {
  envelope_output out = {0};
  sense(state, in);
  if (state->known < ENVELOPE_ANGLES) {
    state->turns = state->turns && in->phase != ENVELOPE_UNTRUSTED;
    state->stopping = false;
    return out;
  }
  const float ahead_rad_s = rate_ahead_rad_s(state, dt_s);
  follow_power(state, in);
  out.too_fast = state->turns && too_fast(params, in->position_rad, ahead_rad_s);
  out.stop_ignored = stop_ignored(state, params, in, dt_s);
  judge_braking(state, params, in, &out, dt_s);
  out.brake = braking_current(state, params);
  return out;
}

float envelope_fastest_rad_s(const envelope_params *params, float room_rad) {
  const float room = scalar_max(room_rad, 0.0f);
  const float a = params->deceleration_rad_s2 / (RATE_RESERVE * RATE_RESERVE);
  const float dead_rad_s = a * DEAD_TIME_S;
  return sqrtf(dead_rad_s * dead_rad_s + 2.0f * a * room) - dead_rad_s;
}
