/* SPDX-License-Identifier: Apache-2.0 */
#include "base/scalar.h"
#include "node/tracking_parts.h"

enum { SILENT_TICKS = 500 };

void tracking_look_for_a_frozen_picture(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch,
                                        uint32_t tick) {
  const camera_objects *objects = &self->objects;
  if (!self->tracked || self->frames.taken == objects->taken || self->message.quality < objects->params.min_quality) {
    return;
  }
  const joint_place joints = {.azimuth = (angle_turn32)azimuth->position, .pitch = (angle_turn32)pitch->position};
  frozen_picture_take(&self->picture, self->error, objects->params.scale_rad, joints, tick);
}

/* What the line of sight has done: as one, or each joint for itself. */
static image_vector moved_rad(const target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch,
                              int ticks) {
  if (tracking_is_together(self)) {
    return pointing_tracker_los_motion(&self->line_of_sight.tracker, ticks, SERVO_TICK_S);
  }
  const target_tracker_state *joints = self->joints.axis;
  image_vector moved = {0};
  if (azimuth->motion.followed != NULL) {
    moved.x = target_tracker_los_motion_rad(&joints[SERVO_AZIMUTH], ticks, SERVO_TICK_S);
  }
  if (pitch->motion.followed != NULL) {
    moved.y = target_tracker_los_motion_rad(&joints[SERVO_PITCH], ticks, SERVO_TICK_S);
  }
  return moved;
}

/* The error of the newest frame: of the line of sight, or of each joint that follows. */
static image_vector seen_rad(const target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch,
                             int age_ticks) {
  if (tracking_is_together(self)) {
    const pointing_frame frame = {.fresh = true, .age_ticks = age_ticks, .error = self->error};
    return pointing_tracker_frame_error(&self->line_of_sight.tracker, &frame);
  }
  const rotation at = rotation_of((angle_turn32)pitch->position);
  const joint_vector errors = line_of_sight_joint_errors(at, self->error);
  return (image_vector){.x = azimuth->motion.followed != NULL ? errors.azimuth : 0.0f,
                        .y = pitch->motion.followed != NULL ? errors.pitch : 0.0f};
}

/* At the target's own rate: a picture that led away would not let it. */
static bool follows(const target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch) {
  if (tracking_is_together(self)) {
    return self->target.locked && !self->target.limited;
  }
  const bool by_azimuth = azimuth->motion.followed != NULL;
  const bool by_pitch = pitch->motion.followed != NULL;
  return (by_azimuth || by_pitch) && !(by_azimuth && self->held_back[SERVO_AZIMUTH]) &&
         !(by_pitch && self->held_back[SERVO_PITCH]);
}

/* What the frame of this ms says beyond what was known, of the axes that follow. */
static image_vector residual_of(const target_tracker_state states[2], const target_tracker_gains gains[2],
                                const bool follow[2]) {
  image_vector residual = {0};
  if (follow[0]) {
    residual.x = target_tracker_residual_rad(&states[0], &gains[0]);
  }
  if (follow[1]) {
    residual.y = target_tracker_residual_rad(&states[1], &gains[1]);
  }
  return residual;
}

void tracking_drop_stray_frame(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch, bool tracks) {
  stray_frames *strays = &self->strays;
  if (!tracks) {
    stray_frames_settle(strays, false);
    return;
  }
  const bool together = tracking_is_together(self);
  target_tracker_state *states = together ? self->line_of_sight.tracker.along : self->joints.axis;
  stray_frames_pass_ms(strays);
  if (self->frames.taken != self->objects.taken && states[0].ticks_since_frame == 0) {
    const bool follow[2] = {together || (azimuth->motion.followed != NULL && self->predicts[SERVO_AZIMUTH]),
                            together || (pitch->motion.followed != NULL && self->predicts[SERVO_PITCH])};
    const int others = together ? SERVO_AZIMUTH : SERVO_PITCH; /* the azimuth's estimator is that of both */
    const target_tracker_gains gains[2] = {
        target_tracker_gains_after(strays->ms, self->estimator_rad_s[SERVO_AZIMUTH], SERVO_TICK_S),
        target_tracker_gains_after(strays->ms, self->estimator_rad_s[others], SERVO_TICK_S)};
    if (stray_frames_take(strays, residual_of(states, gains, follow))) {
      const int age_ticks = camera_delay_age(&self->delay, &self->objects.delay, self->objects.age_ms);
      for (int i = 0; i < 2; ++i) {
        target_tracker_take_back(&states[i], &gains[i], age_ticks, SERVO_TICK_S);
      }
      self->target.error_of_joints_rad = (joint_vector){0}; /* with it no turn back must begin */
      camera_input_take_back(&self->frames, CAMERA_STRAY);
      camera_delay_leave_out(&self->delay);
      return;
    }
  }
  stray_frames_settle(strays, self->orientation.verdict != PICTURE_NOT_JUDGED && follows(self, azimuth, pitch));
}

static bool is_out_of_sight(const target_tracking *self) {
  const int coast_ticks = (int)(PICTURE_UNPROVEN_COAST_S / SERVO_TICK_S);
  return self->orientation.verdict == PICTURE_NOT_JUDGED &&
         self->joints.axis[SERVO_AZIMUTH].ticks_since_frame > coast_ticks;
}

static void stop_following(target_tracking *self) {
  self->frames.last_drop = CAMERA_PICTURE_WRONG;
  pointing_look_away(&self->line_of_sight);
  turn_back_reset(&self->turn);
  joint_tracking_lose(&self->joints);
}

/* Of a sender that was silent meanwhile: it has been mended, and the place may be a target's. */
static void forget_a_frozen_place(target_tracking *self) {
  const bool silent = self->frames.dropped == self->objects.dropped && self->frames.taken == self->objects.taken;
  self->silent_ticks = (uint16_t)(silent ? self->silent_ticks + 1 : 0);
  if (self->silent_ticks >= SILENT_TICKS) {
    self->silent_ticks = 0;
    self->picture = (frozen_picture){0};
  }
}

void tracking_check_picture(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch, bool tracks) {
  if (!tracks) {
    if (self->tracked) {
      picture_check_reset(&self->orientation);
    }
    self->tracked = false;
    forget_a_frozen_place(self);
    return;
  }
  if (!self->tracked) {
    frozen_picture_begin(&self->picture);
  }
  self->tracked = true;
  self->silent_ticks = 0;
  picture_check_tick(&self->orientation, moved_rad(self, azimuth, pitch, 1), follows(self, azimuth, pitch));
  const camera_objects *objects = &self->objects;
  if (self->frames.taken != objects->taken && self->message.quality >= objects->params.min_quality) {
    const int age_ticks = camera_delay_age(&self->delay, &objects->delay, objects->age_ms);
    picture_check_take(&self->orientation, seen_rad(self, azimuth, pitch, age_ticks),
                       moved_rad(self, azimuth, pitch, age_ticks), age_ticks);
  }
  if (picture_check_is_wrong(&self->orientation)) {
    stop_following(self);
  } else if (is_out_of_sight(self)) {
    joint_tracking_lose(&self->joints);
  }
}

void tracking_report_picture(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch) {
  camera_objects *objects = &self->objects;
  const picture_check *check = &self->orientation;
  objects->azimuth_tracking = (uint8_t)azimuth->tracking;
  objects->pitch_tracking = (uint8_t)pitch->tracking;
  objects->picture_verdict = (uint8_t)check->verdict;
  if (check->verdict == PICTURE_NOT_JUDGED) {
    objects->picture_roll = 0;
    return;
  }
  objects->picture_roll = (int16_t)scalar_round(check->roll_rad * (float)CAMERA_ROLL_COUNTS_PER_RAD);
  if (picture_check_is_wrong(check)) {
    objects->azimuth_tracking = azimuth->tracking != DRIVE_NOT_TRACKING ? PICTURE_IS_WRONG : 0;
    objects->pitch_tracking = pitch->tracking != DRIVE_NOT_TRACKING ? PICTURE_IS_WRONG : 0;
  }
}
