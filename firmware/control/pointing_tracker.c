#include "control/pointing_tracker.h"

#include "base/scalar.h"

static target_tracker_params estimator_of(const pointing_tracker_params *params) {
  return (target_tracker_params){.kind = TRACKER_PREDICTIVE,
                                 .proportional_per_s = params->proportional_per_s,
                                 .estimator_rad_s = params->estimator_rad_s,
                                 .rate_limit_rad_s = params->rate_limit_rad_s.pitch,
                                 .coast_s = params->coast_s};
}

control_status pointing_tracker_check(const pointing_tracker_params *params) {
  const scalar_range ranges[] = {{params->rate_limit_rad_s.azimuth, 1e-5f, 1e2f}};
  const target_tracker_params estimator = estimator_of(params);
  const control_status status = target_tracker_check(&estimator);
  return status != CONTROL_OK ? status : scalar_check_ranges(ranges, 1);
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

/* The image was turned by what phi was at exposure. */
image_vector pointing_tracker_frame_error(const pointing_tracker_state *state, const pointing_frame *frame) {
  const bool known = frame->fresh && frame->age_ticks >= 0 && frame->age_ticks < TARGET_TRACKER_HISTORY;
  if (!known) {
    return frame->error;
  }
  const unsigned then = (state->newest + TARGET_TRACKER_HISTORY - (unsigned)frame->age_ticks) % TARGET_TRACKER_HISTORY;
  return turned(rotation_of(state->past_phi[then]), frame->error);
}

static void estimate(pointing_tracker_state *state, const pointing_tracker_params *params, const pointing_frame *frame,
                     image_vector los_rad_s, float dt_s) {
  const target_tracker_params estimator = estimator_of(params);
  const image_vector error = pointing_tracker_frame_error(state, frame);
  /* A frame is good in both components or in none. */
  const bool valid = frame->valid && scalar_within(error.x, SCALAR_PI) && scalar_within(error.y, SCALAR_PI);
  const camera_frame seen = {.fresh = frame->fresh, .valid = valid, .age_ticks = frame->age_ticks};
  camera_frame along_x = seen;
  camera_frame along_y = seen;
  along_x.error_rad = error.x;
  along_y.error_rad = error.y;
  (void)target_tracker_step(&state->along[0], &estimator, &along_x, los_rad_s.x, dt_s);
  (void)target_tracker_step(&state->along[1], &estimator, &along_y, los_rad_s.y, dt_s);
}

static float clamp_rate(float wanted_rad_s, float limit_rad_s, bool *limited) {
  const float rate_rad_s = scalar_clamp(wanted_rad_s, -limit_rad_s, limit_rad_s);
  *limited = *limited || rate_rad_s != wanted_rad_s;
  return rate_rad_s;
}

/* Image axes at the target: those of the line of sight, turned by what the azimuth's way to the target rolls them. */
static rotation axes_at_target(rotation pitch, joint_vector error_rad) {
  return reverse(rotation_of(turn32_of(error_rad.azimuth * pitch.sine)));
}

/* Rates and accelerations of the joints that keep pointing at the target. */
static void follow_target(pointing_command *out, rotation pitch_at_target, image_vector rate,
                          image_vector acceleration) {
  const float cosine = pitch_at_target.cosine;
  const bool at_zenith = scalar_within(cosine, POINTING_ZENITH_COSINE);
  const float secant = at_zenith ? cosine / (POINTING_ZENITH_COSINE * POINTING_ZENITH_COSINE) : 1.0f / cosine;
  const float azimuth_rad_s = rate.x * secant;
  const float tangent = pitch_at_target.sine * secant;
  out->rate_rad_s = (joint_vector){.azimuth = azimuth_rad_s, .pitch = rate.y};
  out->acceleration_rad_s2 = (joint_vector){
      .azimuth = acceleration.x * secant + 2.0f * azimuth_rad_s * rate.y * tangent,
      .pitch = acceleration.y - azimuth_rad_s * azimuth_rad_s * pitch_at_target.sine * cosine,
  };
}

pointing_command pointing_tracker_step(pointing_tracker_state *state, const pointing_tracker_params *params,
                                       const pointing_frame *frame, const line_of_sight_rates *los,
                                       angle_turn32 pitch_angle, float dt_s) {
  follow_roll(state, los->roll_rad_s, dt_s);
  const rotation phi = rotation_of(state->phi);
  estimate(state, params, frame, turned(phi, los->rad_s), dt_s);
  const target_tracker_state *x = &state->along[0];
  const target_tracker_state *y = &state->along[1];
  pointing_command out = {.locked = x->locked && y->locked};
  if (!out.locked) {
    return out;
  }
  const rotation back = reverse(phi);
  const rotation pitch = rotation_of(pitch_angle);
  out.error_rad = turned(back, (image_vector){x->error_rad, y->error_rad});
  out.error_of_joints_rad = line_of_sight_joint_errors(pitch, out.error_rad);
  const rotation at_target = axes_at_target(pitch, out.error_of_joints_rad);
  const image_vector rate = turned(back, (image_vector){x->target_rate_rad_s, y->target_rate_rad_s});
  const image_vector acceleration =
      turned(back, (image_vector){x->target_acceleration_rad_s2, y->target_acceleration_rad_s2});
  const rotation pitch_at_target = rotation_of(pitch_angle + turn32_of(out.error_of_joints_rad.pitch));
  follow_target(&out, pitch_at_target, turned(at_target, rate), turned(at_target, acceleration));
  const float k = params->proportional_per_s;
  out.rate_rad_s.azimuth = clamp_rate(out.rate_rad_s.azimuth + k * out.error_of_joints_rad.azimuth,
                                      params->rate_limit_rad_s.azimuth, &out.limited);
  out.rate_rad_s.pitch = clamp_rate(out.rate_rad_s.pitch + k * out.error_of_joints_rad.pitch,
                                    params->rate_limit_rad_s.pitch, &out.limited);
  if (out.limited) {
    out.acceleration_rad_s2 = (joint_vector){0};
  }
  return out;
}
