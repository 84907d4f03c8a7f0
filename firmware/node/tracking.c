#include "node/tracking.h"

#include "base/scalar.h"

enum { TICKS_PER_S = 1000 };

/* The node's clock at this tick, in the unit of a camera message. */
static uint16_t clock_at(uint32_t tick) { return (uint16_t)(tick * CAMERA_TIMES_PER_TICK); }

static pointing_frame take_frame(target_tracking *self, uint32_t tick) {
  if (!self->objects.arrived) {
    return (pointing_frame){0};
  }
  self->objects.arrived = false;
  pointing_frame frame =
      camera_input_take(&self->frames, &self->objects.params, &self->objects.message, clock_at(tick));
  if (frame.fresh) {
    self->objects.age_ms = (uint8_t)frame.age_ticks;
    camera_delay_notice(&self->delay, &frame);
    frame.age_ticks = camera_delay_age(&self->delay, &self->objects.delay, frame.age_ticks);
  }
  return frame;
}

/* A frame from the bus stands for one of a direct link: each axis gets how far its joint is from the target. */
static void show_joints(servo_board *board, const pointing_frame *frame) {
  servo_axis_samples *samples = board->samples.axis;
  const rotation pitch = rotation_of(samples[SERVO_PITCH].sensors.joint_angle_turn32);
  const joint_vector errors = line_of_sight_joint_errors(pitch, frame->error);
  for (int i = 0; i < SERVO_AXES; ++i) {
    samples[i].sensors.frame = (hal_camera_frame){.fresh = true,
                                                  .target_found = frame->valid,
                                                  .age_ticks = frame->age_ticks,
                                                  .error_rad = i == SERVO_PITCH ? errors.pitch : errors.azimuth};
  }
}

/* The azimuth's loop decides; each joint keeps its own rate limit. 2056 is the azimuth's inertia at pitch 0. */
static pointing_params params_of(const servo_params *servo, float swing_kg_m2) {
  const servo_axis_params *azimuth = &servo->axis[SERVO_AZIMUTH];
  const servo_axis_params *pitch = &servo->axis[SERVO_PITCH];
  return (pointing_params){.tracker = {.proportional_per_s = azimuth->tracker.proportional_per_s,
                                       .estimator_rad_s = azimuth->tracker.estimator_rad_s,
                                       .coast_s = azimuth->tracker.coast_s,
                                       .rate_limit_rad_s = {.azimuth = azimuth->tracker.rate_limit_rad_s,
                                                            .pitch = pitch->tracker.rate_limit_rad_s}},
                           .inertia = {.azimuth_kg_m2 = azimuth->plant_inertia_kg_m2 - swing_kg_m2,
                                       .azimuth_swing_kg_m2 = swing_kg_m2,
                                       .pitch_kg_m2 = pitch->plant_inertia_kg_m2},
                           .fed_forward_kg_m2 = {.azimuth = azimuth->speed.acceleration_inertia_kg_m2,
                                                 .pitch = pitch->speed.acceleration_inertia_kg_m2}};
}

static bool predicts(const servo_params *servo) {
  return servo->axis[SERVO_AZIMUTH].tracker.kind == TRACKER_PREDICTIVE &&
         servo->axis[SERVO_PITCH].tracker.kind == TRACKER_PREDICTIVE;
}

/* The drives see the target of the line of sight. */
static void show_target(const target_tracking *self, servo_app *app) {
  const joint_vector errors = self->target.error_of_joints_rad;
  for (int i = 0; i < SERVO_AXES; ++i) {
    app->axis[i].signals.target =
        (servo_target){.known = self->target.locked,
                       .error_rad = i == SERVO_PITCH ? errors.pitch : errors.azimuth,
                       .rate_rad_s = self->target.reference[i].rate_rad_s,
                       .frame_age_ticks = self->line_of_sight.tracker.along[0].ticks_since_frame};
  }
}

void tracking_take(target_tracking *self, servo_board *board, bool both_track, float azimuth_swing_kg_m2,
                   uint32_t tick) {
  const pointing_frame frame = take_frame(self, tick);
  const bool wanted = both_track && predicts(&board->app.params);
  if (wanted && !self->together) { /* gains that change while it tracks count from the next time on */
    const pointing_params params = params_of(&board->app.params, azimuth_swing_kg_m2);
    self->together = pointing_configure(&self->line_of_sight, &params) == CONTROL_OK;
  } else if (!wanted) {
    self->together = false;
  }
  if (self->together) {
    const pointing_motion motion = pointing_motion_of(&board->app, &board->samples);
    self->target = pointing_step(&self->line_of_sight, &frame, &motion, SERVO_TICK_S);
    show_target(self, &board->app);
  } else if (frame.fresh) {
    show_joints(board, &frame);
  }
  self->dither_rad_s = camera_delay_dither(&self->delay, &self->objects.delay,
                                           self->together && self->objects.dither_s != 0, SERVO_TICK_S);
}

void tracking_command(const target_tracking *self, int axis, drive_axis *drive, servo_axis_command *command) {
  if (self->together && command->mode == SERVO_TRACKING) {
    drive->motion.tracking.given = true;
    command->speed = self->target.reference[axis];
    command->torque_nm += self->target.torque_nm[axis];
    command->speed.rate_rad_s += axis == SERVO_PITCH ? self->dither_rad_s : 0.0f;
  }
}

static int16_t time_of(float time_s) {
  const float most = 32767.0f;
  return (int16_t)scalar_round(scalar_clamp(time_s * (float)CAMERA_TIMES_PER_TICK / SERVO_TICK_S, -most, most));
}

static void measure_delay(target_tracking *self, uint32_t tick) {
  camera_objects *objects = &self->objects;
  camera_delay_step(&self->delay, &objects->delay, &self->line_of_sight.tracker, self->together && self->target.locked,
                    SERVO_TICK_S);
  if (!self->together) {
    objects->dither_s = 0;
  } else if (objects->dither_s != 0 && tick % TICKS_PER_S == 0) {
    objects->dither_s--;
  }
  const delay_error *found = &self->delay.found;
  objects->delay_error = time_of(found->error_s);
  objects->delay_half_width = found->known ? (uint16_t)time_of(found->half_width_s) : CAMERA_DELAY_UNKNOWN;
  objects->correction_ms = objects->delay.use == CAMERA_DELAY_CORRECTED ? (int8_t)self->delay.offset_ticks : 0;
}

void tracking_report(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch, uint32_t tick) {
  camera_objects *objects = &self->objects;
  objects->taken = self->frames.taken;
  objects->missed = self->frames.missed;
  objects->dropped = self->frames.dropped;
  objects->last_drop = (uint8_t)self->frames.last_drop;
  objects->azimuth_tracking = (uint8_t)azimuth->tracking;
  objects->pitch_tracking = (uint8_t)pitch->tracking;
  objects->clock = clock_at(tick);
  measure_delay(self, tick);
}
