/* SPDX-License-Identifier: Apache-2.0 */
#include "drive/homing.h"

#include "base/scalar.h"
#include "drive/drive_units.h"

/* Slower than this share of its set-point, at the torque limit, an axis is blocked. */
#define BLOCKED_SHARE 0.5f

bool homing_method_supported(int8_t method) {
  return method == HOMING_NONE || method == HOMING_DOWN_FIRST || method == HOMING_UP_FIRST ||
         method == HOMING_HERE_OLD || method == HOMING_HERE;
}

static void enter(drive_homing *state, homing_phase phase, float direction) {
  state->phase = phase;
  state->direction = direction;
  state->blocked_s = 0.0f;
}

static void begin(drive_homing *state, int8_t method, const homing_inputs *in) {
  const bool here = method == HOMING_HERE || method == HOMING_HERE_OLD;
  const bool moves = method == HOMING_DOWN_FIRST || method == HOMING_UP_FIRST;
  if (here && in->turn_seen) {
    enter(state, HOMING_CONFIRMING, 0.0f);
  } else if ((here || moves) && in->position_known) {
    enter(state, HOMING_ATTAINED, 0.0f);
  } else if (moves) {
    enter(state, HOMING_FIRST_PATH, method == HOMING_DOWN_FIRST ? -1.0f : 1.0f);
  } else {
    enter(state, HOMING_FAILED, 0.0f);
  }
}

/* While the ramp still reverses, nothing is judged. */
static bool touches(drive_homing *state, const homing_inputs *in, float dt_s) {
  const bool commanded = in->reference_rad_s * state->direction > 0.0f;
  const bool slow = in->rate_rad_s * state->direction < BLOCKED_SHARE * scalar_abs(in->reference_rad_s);
  state->blocked_s = commanded && slow && in->torque_limited ? state->blocked_s + dt_s : 0.0f;
  return state->blocked_s > in->contact_s;
}

static void move(drive_homing *state, const homing_inputs *in, float dt_s) {
  if (in->position_known) {
    enter(state, HOMING_ATTAINED, 0.0f);
  } else if (touches(state, in, dt_s)) {
    const bool first = state->phase == HOMING_FIRST_PATH;
    enter(state, first ? HOMING_SECOND_PATH : HOMING_FAILED, first ? -state->direction : 0.0f);
  }
}

static void go_on(drive_homing *state, const homing_inputs *in, float dt_s) {
  switch (state->phase) {
    case HOMING_CONFIRMING:
      if (!in->turn_seen) {
        enter(state, in->position_known ? HOMING_ATTAINED : HOMING_FAILED, 0.0f);
      }
      break;
    case HOMING_FIRST_PATH:
    case HOMING_SECOND_PATH:
      move(state, in, dt_s);
      break;
    case HOMING_ATTAINED: /* an encoder that jumped has lost the turn again */
      enter(state, in->position_known ? HOMING_ATTAINED : HOMING_NOT_STARTED, 0.0f);
      break;
    case HOMING_NOT_STARTED:
    case HOMING_FAILED:
    default:
      break;
  }
}

void homing_step(drive_homing *state, const drive_homing_objects *objects, const homing_inputs *in, float dt_s) {
  const bool active = in->runs && in->in_mode;
  const bool starts = active && state->ran_before && in->start && !state->start_before;
  if (starts) {
    begin(state, objects->method, in);
  } else if (!homing_is_idle(state) && !(active && in->start)) {
    enter(state, HOMING_NOT_STARTED, 0.0f);
  } else {
    go_on(state, in, dt_s);
  }
  homing_pass(state, in->runs, in->start);
  const uint32_t speed = state->phase == HOMING_SECOND_PATH ? objects->second_speed : objects->first_speed;
  state->target_rad_s = state->direction == 0.0f ? 0.0f : state->direction * drive_limit_from_counts(speed);
}
