/* SPDX-License-Identifier: Apache-2.0 */
#include "control/target_tracker.h"

#include "base/scalar.h"

#define LEAST_UNTAKEN 1e-3f
#define MAX_STRAIGHT_RAD_S 1.0f /* faster ones count as this fast in the jerk */

control_status target_tracker_check(const target_tracker_params *params) {
  if ((unsigned)params->kind > (unsigned)TRACKER_PREDICTIVE) {
    return CONTROL_OUT_OF_RANGE;
  }
  const scalar_range ranges[] = {
      {params->proportional_per_s, 0.0f, 1e2f}, {params->integral_per_s2, 0.0f, 1e3f},
      {params->estimator_rad_s, 0.1f, 50.0f},   {params->rate_limit_rad_s, 1e-5f, 1e2f},
      {params->coast_s, 0.0f, 10.0f},
  };
  return scalar_check_ranges(ranges, 5);
}

void target_tracker_reset(target_tracker_state *state) { *state = (target_tracker_state){0}; }

/* Counts whole blocks as one. */
float target_tracker_los_motion_rad(const target_tracker_state *state, int age_ticks, float dt_s) {
  const unsigned before = (state->newest + TARGET_TRACKER_HISTORY - (unsigned)age_ticks) % TARGET_TRACKER_HISTORY;
  const unsigned begun = state->newest % TARGET_TRACKER_BLOCK;
  float sum_rad_s = state->los_sum_rad_s[state->newest];
  if ((unsigned)age_ticks > begun) {
    const unsigned blocks = ((unsigned)age_ticks - begun - 1u) / TARGET_TRACKER_BLOCK + 1u;
    unsigned last = state->newest - begun + TARGET_TRACKER_HISTORY - 1u; /* rest of the oldest block */
    /* Bound: TARGET_TRACKER_HISTORY / TARGET_TRACKER_BLOCK: an age is below TARGET_TRACKER_HISTORY. */
    for (unsigned i = 0; i < blocks; ++i) {
      sum_rad_s += state->los_sum_rad_s[last % TARGET_TRACKER_HISTORY];
      last -= TARGET_TRACKER_BLOCK;
    }
  }
  return (sum_rad_s - state->los_sum_rad_s[before]) * dt_s;
}

static void remember_los(target_tracker_state *state, float los_rate_rad_s) {
  const float sum_rad_s = state->los_sum_rad_s[state->newest];
  state->newest = (state->newest + 1u) % TARGET_TRACKER_HISTORY;
  const bool begins = state->newest % TARGET_TRACKER_BLOCK == 0;
  state->los_sum_rad_s[state->newest] = begins ? los_rate_rad_s : sum_rad_s + los_rate_rad_s;
}

static int ticks_after(int ticks_since_frame) {
  return ticks_since_frame < 1000000 ? ticks_since_frame + 1 : ticks_since_frame;
}

/* Moves the estimate forward by one tick of target and line-of-sight motion. */
static void propagate(target_tracker_state *state, float los_rate_rad_s, float dt_s) {
  const float mean_rate_rad_s = state->target_rate_rad_s + 0.5f * state->target_acceleration_rad_s2 * dt_s;
  state->error_rad += (mean_rate_rad_s - los_rate_rad_s) * dt_s;
  state->target_rate_rad_s += state->target_acceleration_rad_s2 * dt_s;
}

target_tracker_gains target_tracker_gains_after(int ticks, float estimator_rad_s, float dt_s) {
  const float interval_s = scalar_max((float)ticks, 1.0f) * dt_s;
  const float pole = scalar_exp_minus(estimator_rad_s * interval_s);
  const float gap = 1.0f - pole;
  return (target_tracker_gains){.ticks = ticks,
                                .alpha = 1.0f - pole * pole * pole,
                                .beta = 1.5f * gap * gap * (1.0f + pole),
                                .gamma = gap * gap * gap,
                                .interval_s = interval_s};
}

target_tracker_gains target_tracker_prepare_gains(const target_tracker_state *state,
                                                  const target_tracker_params *params, float dt_s) {
  return target_tracker_gains_after(ticks_after(state->ticks_since_frame), params->estimator_rad_s, dt_s);
}

/* What a frame with this residual changes. The corrections are those at exposure, extrapolated to now. */
static inline __attribute__((always_inline)) void add_correction(target_tracker_state *state,
                                                                 const target_tracker_gains *gains, int age_ticks,
                                                                 float residual_rad, float dt_s) {
  const float age_s = (float)age_ticks * dt_s;
  const float rate_step_rad_s = gains->beta * residual_rad / gains->interval_s;
  const float acceleration_step_rad_s2 = gains->gamma * residual_rad / (gains->interval_s * gains->interval_s);
  state->error_rad +=
      gains->alpha * residual_rad + rate_step_rad_s * age_s + 0.5f * acceleration_step_rad_s2 * age_s * age_s;
  state->target_rate_rad_s += rate_step_rad_s + acceleration_step_rad_s2 * age_s;
  state->target_acceleration_rad_s2 += acceleration_step_rad_s2;
}

/* Corrects the estimate with a frame; the residual belongs to the time of exposure. */
static void correct(target_tracker_state *state, const target_tracker_gains *gains, int age_ticks, float error_rad,
                    float dt_s) {
  const float age_s = (float)age_ticks * dt_s;
  const float target_motion_rad = (state->target_rate_rad_s - 0.5f * state->target_acceleration_rad_s2 * age_s) * age_s;
  const float expected_rad =
      state->error_rad + target_tracker_los_motion_rad(state, age_ticks, dt_s) - target_motion_rad;
  const float residual_rad = error_rad - expected_rad;
  state->untaken_rad = (1.0f - gains->alpha) * residual_rad;
  add_correction(state, gains, age_ticks, residual_rad, dt_s);
}

float target_tracker_residual_rad(const target_tracker_state *state, const target_tracker_gains *gains) {
  const float untaken = 1.0f - gains->alpha;
  return untaken < LEAST_UNTAKEN ? 0.0f : state->untaken_rad / untaken;
}

void target_tracker_take_back(target_tracker_state *state, const target_tracker_gains *gains, int age_ticks,
                              float dt_s) {
  add_correction(state, gains, age_ticks, -target_tracker_residual_rad(state, gains), dt_s);
  state->untaken_rad = 0.0f;
  state->ticks_since_frame = gains->ticks;
}

static void acquire(target_tracker_state *state, int age_ticks, float error_rad, float los_rate_rad_s, float dt_s) {
  state->error_rad = error_rad - target_tracker_los_motion_rad(state, age_ticks, dt_s);
  state->target_rate_rad_s = los_rate_rad_s;
  state->target_acceleration_rad_s2 = 0.0f;
  state->untaken_rad = 0.0f;
  state->integral_rad_s = los_rate_rad_s;
  state->locked = true;
}

static void take_frame(target_tracker_state *state, const target_tracker_params *params, const camera_frame *frame,
                       float los_rate_rad_s, float dt_s) {
  if (params->kind == TRACKER_PI) {
    const float interval_s = (float)state->ticks_since_frame * dt_s;
    if (!state->locked) {
      state->integral_rad_s = los_rate_rad_s;
    } else {
      state->integral_rad_s += params->integral_per_s2 * frame->error_rad * scalar_min(interval_s, 0.1f);
    }
    state->integral_rad_s = scalar_clamp(state->integral_rad_s, -params->rate_limit_rad_s, params->rate_limit_rad_s);
    state->error_rad = frame->error_rad;
    state->locked = true;
  } else if (!state->locked) {
    acquire(state, frame->age_ticks, frame->error_rad, los_rate_rad_s, dt_s);
  } else {
    const target_tracker_gains gains =
        target_tracker_gains_after(state->ticks_since_frame, params->estimator_rad_s, dt_s);
    correct(state, &gains, frame->age_ticks, frame->error_rad, dt_s);
  }
  state->ticks_since_frame = 0;
}

static bool counts(const camera_frame *frame) {
  return frame->fresh && frame->valid && frame->age_ticks >= 0 && frame->age_ticks < TARGET_TRACKER_HISTORY;
}

static speed_reference limited(const target_tracker_params *params, float rate_rad_s, float acceleration_rad_s2) {
  const float limit_rad_s = params->rate_limit_rad_s;
  const float clamped_rad_s = scalar_clamp(rate_rad_s, -limit_rad_s, limit_rad_s);
  return (speed_reference){
      .rate_rad_s = clamped_rad_s,
      .acceleration_rad_s2 = clamped_rad_s == rate_rad_s ? acceleration_rad_s2 : 0.0f,
  };
}

void target_tracker_remember(target_tracker_state *state, float los_rate_rad_s) {
  remember_los(state, los_rate_rad_s);
  state->locked = false;
}

void target_tracker_assume(target_tracker_state *state, float error_rad, float rate_rad_s, float acceleration_rad_s2) {
  state->error_rad = error_rad;
  state->target_rate_rad_s = rate_rad_s;
  state->target_acceleration_rad_s2 = acceleration_rad_s2;
  state->untaken_rad = 0.0f;
  state->locked = true;
}

float target_tracker_seen_rad(const target_tracker_state *state, int age_ticks, float rate_rad_s, float dt_s) {
  const float since_s = (float)(age_ticks + state->ticks_since_frame) * dt_s;
  const float mean_rad_s = state->target_rate_rad_s - 0.5f * state->target_acceleration_rad_s2 * since_s;
  return state->error_rad + state->untaken_rad - (mean_rad_s - rate_rad_s) * since_s;
}

static void advance(target_tracker_state *state, bool predicts, float los_rate_rad_s, float dt_s) {
  remember_los(state, los_rate_rad_s);
  state->ticks_since_frame = ticks_after(state->ticks_since_frame);
  if (predicts && state->locked) {
    propagate(state, los_rate_rad_s, dt_s);
  }
}

static bool has_coasted(const target_tracker_state *state, const target_tracker_params *params, float dt_s) {
  return (float)state->ticks_since_frame * dt_s > params->coast_s;
}

/* Seen along a straight path, the rate w changes by a = -2 rho w, and rho = range rate / range by w^2 - rho^2. So the
 * jerk is (6 rho^2 - 2 w^2) w. A rho above w, far from the closest approach, may be noise of a. */
static float straight_jerk_per_rate(const target_tracker_state components[2]) {
  const target_tracker_state *x = &components[0];
  const target_tracker_state *y = &components[1];
  const float square = x->target_rate_rad_s * x->target_rate_rad_s + y->target_rate_rad_s * y->target_rate_rad_s;
  if (!(square > 0.0f)) {
    return 0.0f;
  }
  const float along =
      x->target_rate_rad_s * x->target_acceleration_rad_s2 + y->target_rate_rad_s * y->target_acceleration_rad_s2;
  const float twice_rho = along / square;
  const float counted = scalar_min(square, MAX_STRAIGHT_RAD_S * MAX_STRAIGHT_RAD_S);
  return scalar_min(1.5f * twice_rho * twice_rho, 6.0f * counted) - 2.0f * counted;
}

void target_tracker_follow_straight_path(target_tracker_state components[2], float dt_s) {
  const float jerk_per_rate_s2 = straight_jerk_per_rate(components);
  for (int i = 0; i < 2; ++i) {
    components[i].target_acceleration_rad_s2 += jerk_per_rate_s2 * components[i].target_rate_rad_s * dt_s;
  }
}

void target_tracker_step_components(target_tracker_state components[2], const target_tracker_params *params,
                                    const target_tracker_gains *prepared, const camera_frame *frame,
                                    const float error_rad[2], const float los_rate_rad_s[2], float dt_s) {
  for (int i = 0; i < 2; ++i) {
    advance(&components[i], true, los_rate_rad_s[i], dt_s);
  }
  if (!counts(frame) || !scalar_within(error_rad[0], SCALAR_PI) || !scalar_within(error_rad[1], SCALAR_PI)) {
    const bool lost = has_coasted(&components[0], params, dt_s);
    components[0].locked = components[0].locked && !lost;
    components[1].locked = components[0].locked;
    return;
  }
  const int ticks = components[0].ticks_since_frame;
  const target_tracker_gains gains =
      prepared->ticks == ticks ? *prepared : target_tracker_gains_after(ticks, params->estimator_rad_s, dt_s);
  for (int i = 0; i < 2; ++i) {
    if (components[i].locked) {
      correct(&components[i], &gains, frame->age_ticks, error_rad[i], dt_s);
    } else {
      acquire(&components[i], frame->age_ticks, error_rad[i], los_rate_rad_s[i], dt_s);
    }
    components[i].ticks_since_frame = 0;
  }
}

speed_reference target_tracker_step(target_tracker_state *state, const target_tracker_params *params,
                                    const camera_frame *frame, float los_rate_rad_s, float dt_s) {
  advance(state, params->kind == TRACKER_PREDICTIVE, los_rate_rad_s, dt_s);
  if (counts(frame) && scalar_within(frame->error_rad, SCALAR_PI)) {
    take_frame(state, params, frame, los_rate_rad_s, dt_s);
  } else if (has_coasted(state, params, dt_s)) {
    state->locked = false;
  }
  if (!state->locked) {
    return (speed_reference){0};
  }
  const float correction_rad_s = params->proportional_per_s * state->error_rad;
  if (params->kind == TRACKER_PI) {
    const bool stale = state->ticks_since_frame > TARGET_TRACKER_STALE_TICKS; /* then only the integral is known */
    return limited(params, (stale ? 0.0f : correction_rad_s) + state->integral_rad_s, 0.0f);
  }
  return limited(params, correction_rad_s + state->target_rate_rad_s, state->target_acceleration_rad_s2);
}
