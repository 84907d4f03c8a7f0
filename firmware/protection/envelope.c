/* SPDX-License-Identifier: Apache-2.0 */
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
enum { STOP_BEGINS_TICKS = 500 };
#define STOP_OVERSHOOT_RAD_S 0.1f
#define STOP_SHARE 0.5f

/* The braking has its current after these ticks. From then on the rate must fall by half of the sure deceleration, with
 * a reserve of 30 ticks. */
enum { BRAKING_TICKS = 5 };
#define BRAKING_RESERVE_TICKS 30.0f
#define BRAKING_SHARE 0.5f

#define TURNS_RAD_S 0.02f  /* slower than this, an axis without power has come to rest */
#define REST_RAD_S 0.005f  /* the same for an axis that is braked, */
enum { REST_TICKS = 100 }; /* for this time */

/* Slower than this nothing is too fast: when a brake opens at the end of the travel, the axis jerks by less. */
#define OUTSIDE_RAD_S 0.03f

#define FAR_RAD 1e9f
#define FASTER_THAN_ALL_RAD_S 1e9f

envelope_limits envelope_prepare(const envelope_params *params, float dt_s) {
  const bool ends = !params->slow && params->minimum_rad < params->maximum_rad;
  return (envelope_limits){
      .rad_s_per_step = ANGLE_RAD_PER_TURN32 * 0.5f / dt_s,
      .fastest_rad_s = params->slow ? ENVELOPE_SLOW_RAD_S : FASTER_THAN_ALL_RAD_S,
      .minimum_rad = ends ? params->minimum_rad : -FAR_RAD,
      .maximum_rad = ends ? params->maximum_rad : FAR_RAD,
      .twice_rad_s2 = 2.0f * params->deceleration_rad_s2 / (RATE_RESERVE * RATE_RESERVE),
      .soft_rad_s = SOFT_S * params->deceleration_rad_s2,
      .braking_fall_rad_s = BRAKING_SHARE * params->deceleration_rad_s2 * dt_s,
      .stop_fall_rad_s = STOP_SHARE * params->stop_deceleration_rad_s2 * dt_s,
  };
}

/* The rate by the time at which a braking that begins now has its current: only acceleration counts. */
static float rate_ahead_rad_s(const envelope_limits *limits, float step, float step_before) {
  const float gain = step - step_before;
  const float ahead = step * gain > 0.0f ? step + AHEAD * gain : step;
  return ahead * limits->rad_s_per_step;
}

static bool too_fast(const envelope_limits *limits, float position_rad, float ahead_rad_s) {
  const float speed_rad_s = scalar_abs(ahead_rad_s);
  if (speed_rad_s < OUTSIDE_RAD_S) {
    return false;
  }
  const float room_rad = ahead_rad_s < 0.0f ? position_rad - limits->minimum_rad : limits->maximum_rad - position_rad;
  const float square = speed_rad_s * speed_rad_s;
  return speed_rad_s > limits->fastest_rad_s || square > limits->twice_rad_s2 * (room_rad - DEAD_TIME_S * speed_rad_s);
}

static float speed_of(const envelope_state *state, const envelope_limits *limits) {
  return scalar_abs((float)state->step[0]) * limits->rad_s_per_step;
}

/* The drive may still have to catch up with its set-point when the stop begins. */
static unsigned judge_stop(envelope_state *state, const envelope_limits *limits, float speed_rad_s,
                           float reference_rad_s) {
  if (!state->stopping) {
    state->stopping = true;
    state->ticks = 0;
    state->limit_rad_s = speed_rad_s + STOP_OVERSHOOT_RAD_S;
  }
  if (state->ticks < STOP_BEGINS_TICKS) {
    ++state->ticks;
    state->limit_rad_s = scalar_max(scalar_abs(reference_rad_s) + STOP_OVERSHOOT_RAD_S, state->limit_rad_s);
  } else {
    state->limit_rad_s = scalar_max(state->limit_rad_s - limits->stop_fall_rad_s, ENVELOPE_SLOW_RAD_S);
  }
  return speed_rad_s > state->limit_rad_s ? ENVELOPE_STOP_IGNORED : 0;
}

/* The braking that began in the last tick at the latest. */
static unsigned judge_braking(envelope_state *state, const envelope_limits *limits, float speed_rad_s) {
  if (!state->braking) {
    state->braking = true;
    state->holds = false;
    state->ticks = 0;
    state->rest_ticks = 0;
  }
  if (state->ticks < BRAKING_TICKS) {
    ++state->ticks;
    state->limit_rad_s = speed_rad_s + BRAKING_RESERVE_TICKS * limits->braking_fall_rad_s;
  }
  state->limit_rad_s = scalar_max(state->limit_rad_s - limits->braking_fall_rad_s, limits->soft_rad_s);
  const int one_more = state->rest_ticks + (state->rest_ticks < REST_TICKS ? 1 : 0);
  state->rest_ticks = speed_rad_s < REST_RAD_S ? one_more : 0;
  return speed_rad_s > state->limit_rad_s ? ENVELOPE_BRAKING_FAILS : 0;
}

/* An axis that does not simply run: whether it still has the power, or the momentum, that the drive gave it, and
 * whether it slows down as it must. */
static unsigned judge_phase(envelope_state *state, const envelope_limits *limits, envelope_phase phase, bool powered,
                            float reference_rad_s) {
  const float speed_rad_s = speed_of(state, limits);
  const bool stays = state->stopping && phase == ENVELOPE_POWERLESS;
  state->turns = phase != ENVELOPE_UNTRUSTED && (powered || (state->turns && speed_rad_s > TURNS_RAD_S));
  if (phase == ENVELOPE_BRAKING) {
    state->stopping = false;
    return judge_braking(state, limits, speed_rad_s);
  }
  state->braking = false;
  if ((phase == ENVELOPE_STOPPING || stays) && state->turns) {
    return judge_stop(state, limits, speed_rad_s, reference_rad_s);
  }
  state->stopping = false;
  return 0;
}

static void judge_nothing(envelope_state *state, envelope_phase phase) {
  state->turns = state->turns && phase != ENVELOPE_UNTRUSTED;
  state->stopping = false;
  state->braking = false;
}

void envelope_lose(envelope_state *state, envelope_phase phase) {
  state->known = 0;
  judge_nothing(state, phase);
}

void envelope_release(envelope_state *state) { judge_nothing(state, ENVELOPE_POWERLESS); }

unsigned envelope_step(envelope_state *state, const envelope_limits *limits, envelope_phase phase, bool powered,
                       angle_turn32 angle, float position_rad, float reference_rad_s) {
  const int32_t step = (int32_t)(angle - state->angle[1]);
  const int32_t step_before = state->step[1];
  state->angle[1] = state->angle[0];
  state->angle[0] = angle;
  state->step[1] = state->step[0];
  state->step[0] = step;
  if (state->known < ENVELOPE_ANGLES && ++state->known < ENVELOPE_ANGLES) {
    judge_nothing(state, phase);
    return 0;
  }
  unsigned found = 0;
  if (phase == ENVELOPE_RUNNING) {
    state->turns = true;
    state->stopping = false;
    state->braking = false;
  } else {
    found = judge_phase(state, limits, phase, powered, reference_rad_s);
  }
  const bool fast =
      state->turns && too_fast(limits, position_rad, rate_ahead_rad_s(limits, (float)step, (float)step_before));
  return found | (fast ? ENVELOPE_TOO_FAST : 0u);
}

float envelope_brake(envelope_state *state, const envelope_limits *limits) {
  if (state->known < ENVELOPE_ANGLES) {
    return 0.0f;
  }
  const float rate_rad_s = (float)state->step[0] * limits->rad_s_per_step;
  if (!state->holds && state->braking && scalar_abs(rate_rad_s) < limits->soft_rad_s) {
    state->holds = true;
    state->held = state->angle[0];
  }
  const float away_rad = state->braking && state->holds ? angle_difference_rad(state->angle[0], state->held) : 0.0f;
  return -scalar_clamp((rate_rad_s + away_rad / HOLD_S) / limits->soft_rad_s, -1.0f, 1.0f);
}

bool envelope_at_rest(const envelope_state *state) { return state->braking && state->rest_ticks >= REST_TICKS; }

float envelope_fastest_rad_s(const envelope_limits *limits, float room_rad) {
  const float room = scalar_max(room_rad, 0.0f);
  const float dead_rad_s = 0.5f * limits->twice_rad_s2 * DEAD_TIME_S;
  const float rate_rad_s = sqrtf(dead_rad_s * dead_rad_s + limits->twice_rad_s2 * room) - dead_rad_s;
  return scalar_clamp(rate_rad_s, 0.0f, limits->fastest_rad_s);
}
