/* SPDX-License-Identifier: Apache-2.0 */
#include "control/pointing_tracker.h"

#include "base/scalar.h"
#include "control/approach.h"

static target_tracker_params estimator_of(const pointing_tracker_params *params) {
  return (target_tracker_params){.kind = TRACKER_PREDICTIVE,
                                 .proportional_per_s = params->proportional_per_s,
                                 .estimator_rad_s = params->estimator_rad_s,
                                 .rate_limit_rad_s = params->rate_limit_rad_s.pitch,
                                 .coast_s = params->coast_s};
}

control_status pointing_tracker_check(const pointing_tracker_params *params) {
  const scalar_range ranges[] = {{params->rate_limit_rad_s.azimuth, 1e-5f, 1e2f},
                                 {params->braking_rad_s2.azimuth, 0.0f, 1e4f},
                                 {params->braking_rad_s2.pitch, 0.0f, 1e4f}};
  const target_tracker_params estimator = estimator_of(params);
  const control_status status = target_tracker_check(&estimator);
  return status != CONTROL_OK ? status : scalar_check_ranges(ranges, 3);
}

void pointing_tracker_reset(pointing_tracker_state *state) { *state = (pointing_tracker_state){0}; }

static image_vector turned(rotation by, image_vector v) {
  return (image_vector){.x = by.cosine * v.x - by.sine * v.y, .y = by.sine * v.x + by.cosine * v.y};
}

static rotation reverse(rotation of) { return (rotation){.sine = -of.sine, .cosine = of.cosine}; }

static angle_turn32 turn32_of(float angle_rad) {
  return (angle_turn32)angle_integer(scalar_round(angle_rad / ANGLE_RAD_PER_TURN32));
}

static void follow_roll(pointing_tracker_state *state, float roll_rad_s, float dt_s) {
  state->phi += turn32_of(roll_rad_s * dt_s);
  state->newest = (state->newest + 1u) % TARGET_TRACKER_HISTORY;
  state->past_phi[state->newest] = state->phi;
}

image_vector pointing_tracker_los_motion(const pointing_tracker_state *state, int age_ticks, float dt_s) {
  return (image_vector){.x = target_tracker_los_motion_rad(&state->along[0], age_ticks, dt_s),
                        .y = target_tracker_los_motion_rad(&state->along[1], age_ticks, dt_s)};
}

/* The image was turned by what phi was at exposure. The estimators take no frame of another age. */
image_vector pointing_tracker_frame_error(const pointing_tracker_state *state, const pointing_frame *frame) {
  if (!frame->fresh) {
    return frame->error;
  }
  const unsigned then = (state->newest + TARGET_TRACKER_HISTORY - (unsigned)frame->age_ticks) % TARGET_TRACKER_HISTORY;
  return turned(rotation_of(state->past_phi[then]), frame->error);
}

static void estimate(pointing_tracker_state *state, const pointing_tracker_params *params, const pointing_frame *frame,
                     image_vector los_rad_s, float dt_s) {
  const target_tracker_params estimator = estimator_of(params);
  const image_vector error = pointing_tracker_frame_error(state, frame);
  const camera_frame seen = {.fresh = frame->fresh, .valid = frame->valid, .age_ticks = frame->age_ticks};
  const float errors[] = {error.x, error.y};
  const float rates[] = {los_rad_s.x, los_rad_s.y};
  target_tracker_step_components(state->along, &estimator, &state->gains, &seen, errors, rates, dt_s);
}

typedef struct {
  joint_vector rate_rad_s;
  joint_vector acceleration_rad_s2;
} joint_motion;

/* Rates and accelerations of the joints that keep pointing at the target. */
static joint_motion follow_target(rotation pitch_at_target, image_vector rate, image_vector acceleration) {
  const float cosine = pitch_at_target.cosine;
  const bool at_zenith = scalar_within(cosine, POINTING_ZENITH_COSINE);
  const float secant = at_zenith ? cosine / (POINTING_ZENITH_COSINE * POINTING_ZENITH_COSINE) : 1.0f / cosine;
  const float azimuth_rad_s = rate.x * secant;
  const float tangent = pitch_at_target.sine * secant;
  return (joint_motion){
      .rate_rad_s = {.azimuth = azimuth_rad_s, .pitch = rate.y},
      .acceleration_rad_s2 = {.azimuth = acceleration.x * secant + 2.0f * azimuth_rad_s * rate.y * tangent,
                              .pitch = acceleration.y - azimuth_rad_s * azimuth_rad_s * pitch_at_target.sine * cosine}};
}

static joint_vector limited_to(joint_vector limit, joint_vector rate) {
  return (joint_vector){.azimuth = scalar_clamp(rate.azimuth, -limit.azimuth, limit.azimuth),
                        .pitch = scalar_clamp(rate.pitch, -limit.pitch, limit.pitch)};
}

static pointing_target target_along(const target_tracker_state *x, const target_tracker_state *y, rotation back) {
  return (pointing_target){.error = turned(back, (image_vector){x->error_rad, y->error_rad}),
                           .rate_rad_s = turned(back, (image_vector){x->target_rate_rad_s, y->target_rate_rad_s}),
                           .acceleration_rad_s2 = turned(
                               back, (image_vector){x->target_acceleration_rad_s2, y->target_acceleration_rad_s2})};
}

pointing_target pointing_tracker_target(const pointing_tracker_state *state) {
  return target_along(&state->along[0], &state->along[1], reverse(rotation_of(state->phi)));
}

void pointing_tracker_assume(pointing_tracker_state *state, const pointing_target *target) {
  const rotation phi = rotation_of(state->phi);
  const image_vector error = turned(phi, target->error);
  const image_vector rate = turned(phi, target->rate_rad_s);
  const image_vector acceleration = turned(phi, target->acceleration_rad_s2);
  target_tracker_assume(&state->along[0], error.x, rate.x, acceleration.x);
  target_tracker_assume(&state->along[1], error.y, rate.y, acceleration.y);
}

void pointing_tracker_lose(pointing_tracker_state *state) {
  state->along[0].locked = false;
  state->along[1].locked = false;
}

pointing_command pointing_tracker_step(pointing_tracker_state *state, const pointing_tracker_params *params,
                                       const pointing_frame *frame, const line_of_sight_rates *los, rotation pitch,
                                       float dt_s) {
  follow_roll(state, los->roll_rad_s, dt_s);
  const rotation phi = rotation_of(state->phi);
  estimate(state, params, frame, turned(phi, los->rad_s), dt_s);
  const target_tracker_state *x = &state->along[0];
  const target_tracker_state *y = &state->along[1];
  if (!x->locked || !y->locked) {
    return (pointing_command){0};
  }
  const pointing_target target = target_along(x, y, reverse(phi));
  const line_of_sight_turn turn = line_of_sight_turn_to(pitch, target.error);
  const joint_motion motion =
      follow_target(turn.pitch, turned(turn.image, target.rate_rad_s), turned(turn.image, target.acceleration_rad_s2));
  state->azimuth_rad_s2 = motion.acceleration_rad_s2.azimuth;
  const float k = params->proportional_per_s;
  const joint_vector wanted = {
      .azimuth = motion.rate_rad_s.azimuth + (k - state->softer_per_s.azimuth) * turn.error_rad.azimuth,
      .pitch = motion.rate_rad_s.pitch + (k - state->softer_per_s.pitch) * turn.error_rad.pitch};
  const joint_vector given = limited_to(params->rate_limit_rad_s, wanted);
  const joint_vector none = {0};
  const image_vector untaken =
      turned(turn.image, turned(reverse(phi), (image_vector){.x = x->untaken_rad, .y = y->untaken_rad}));
  const float cosine = scalar_max(turn.pitch.cosine, POINTING_ZENITH_COSINE);
  const bool limited = given.azimuth != wanted.azimuth || given.pitch != wanted.pitch;
  return (pointing_command){
      .locked = true,
      .limited = limited,
      .error_rad = target.error,
      .error_of_joints_rad = turn.error_rad,
      .seen_rad = {.azimuth = turn.error_rad.azimuth + untaken.x / cosine, .pitch = turn.error_rad.pitch + untaken.y},
      .rate_rad_s = given,
      .acceleration_rad_s2 = limited ? none : motion.acceleration_rad_s2};
}

/* Proportional to the error it is the rate of approach.h. */
static float softer(float proportional_per_s, float limit_rad_s2, float error_rad, float target_rad_s2) {
  const float braking_rad_s2 = approach_braking(limit_rad_s2, error_rad, target_rad_s2);
  const float linear_rad_s = proportional_per_s * error_rad;
  const float rate_rad_s = approach_rate(proportional_per_s, braking_rad_s2, error_rad);
  return rate_rad_s == linear_rad_s ? 0.0f : (linear_rad_s - rate_rad_s) / error_rad;
}

void pointing_tracker_prepare(pointing_tracker_state *state, const pointing_tracker_params *params,
                              joint_vector error_rad, float dt_s) {
  state->softer_per_s = (joint_vector){0};
  if (!state->along[0].locked) {
    return;
  }
  const target_tracker_params estimator = estimator_of(params);
  state->gains = target_tracker_prepare_gains(&state->along[0], &estimator, dt_s);
  target_tracker_follow_straight_path(state->along, dt_s);
  const float k = params->proportional_per_s;
  const joint_vector limit = params->braking_rad_s2;
  state->softer_per_s = (joint_vector){.azimuth = softer(k, limit.azimuth, error_rad.azimuth, state->azimuth_rad_s2),
                                       .pitch = softer(k, limit.pitch, error_rad.pitch, 0.0f)};
}
