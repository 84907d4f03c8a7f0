#include "control/target_tracker.h"

#include "base/scalar.h"

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

/* Moves the estimate forward by one tick of target and line-of-sight motion. */
static void propagate(target_tracker_state *state, float los_rate_rad_s, float dt_s) {
  const float mean_rate_rad_s = state->target_rate_rad_s + 0.5f * state->target_acceleration_rad_s2 * dt_s;
  state->error_rad += (mean_rate_rad_s - los_rate_rad_s) * dt_s;
  state->target_rate_rad_s += state->target_acceleration_rad_s2 * dt_s;
}

/* Corrects the estimate with a frame; the residual belongs to the time of exposure. */
static void correct(target_tracker_state *state, const target_tracker_params *params, const camera_frame *frame,
                    float dt_s) {
  const float age_s = (float)frame->age_ticks * dt_s;
  const float target_motion_rad = (state->target_rate_rad_s - 0.5f * state->target_acceleration_rad_s2 * age_s) * age_s;
  const float expected_rad =
      state->error_rad + target_tracker_los_motion_rad(state, frame->age_ticks, dt_s) - target_motion_rad;
  const float residual_rad = frame->error_rad - expected_rad;

  const float interval_s = scalar_max((float)state->ticks_since_frame, 1.0f) * dt_s;
  const float pole = scalar_exp_minus(params->estimator_rad_s * interval_s);
  const float gap = 1.0f - pole;
  const float rate_step_rad_s = 1.5f * gap * gap * (1.0f + pole) * residual_rad / interval_s;
  const float acceleration_step_rad_s2 = gap * gap * gap * residual_rad / (interval_s * interval_s);
  /* The corrections are those at exposure; extrapolate them to now. */
  state->error_rad += (1.0f - pole * pole * pole) * residual_rad + rate_step_rad_s * age_s +
                      0.5f * acceleration_step_rad_s2 * age_s * age_s;
  state->target_rate_rad_s += rate_step_rad_s + acceleration_step_rad_s2 * age_s;
  state->target_acceleration_rad_s2 += acceleration_step_rad_s2;
}

static void acquire(target_tracker_state *state, const camera_frame *frame, float los_rate_rad_s, float dt_s) {
  state->error_rad = frame->error_rad - target_tracker_los_motion_rad(state, frame->age_ticks, dt_s);
  state->target_rate_rad_s = los_rate_rad_s;
  state->target_acceleration_rad_s2 = 0.0f;
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
    acquire(state, frame, los_rate_rad_s, dt_s);
  } else {
    correct(state, params, frame, dt_s);
  }
  state->ticks_since_frame = 0;
}

static bool usable(const camera_frame *frame) {
  return frame->fresh && frame->valid && frame->age_ticks >= 0 && frame->age_ticks < TARGET_TRACKER_HISTORY &&
         scalar_abs(frame->error_rad) <= SCALAR_PI; /* false for NaN as well */
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

speed_reference target_tracker_step(target_tracker_state *state, const target_tracker_params *params,
                                    const camera_frame *frame, float los_rate_rad_s, float dt_s) {
  remember_los(state, los_rate_rad_s);
  if (state->ticks_since_frame < 1000000) {
    ++state->ticks_since_frame;
  }
  if (params->kind == TRACKER_PREDICTIVE && state->locked) {
    propagate(state, los_rate_rad_s, dt_s);
  }
  if (usable(frame)) {
    take_frame(state, params, frame, los_rate_rad_s, dt_s);
  } else if ((float)state->ticks_since_frame * dt_s > params->coast_s) {
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
