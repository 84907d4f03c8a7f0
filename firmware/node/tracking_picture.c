#include "base/scalar.h"
#include "node/tracking_parts.h"

void tracking_look_for_a_frozen_picture(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch,
                                        uint32_t tick) {
  const camera_objects *objects = &self->objects;
  if (self->frames.taken == objects->taken || objects->message.quality < objects->params.min_quality) {
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

void tracking_check_picture(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch, bool tracks) {
  if (!tracks) {
    if (self->tracked) {
      picture_check_reset(&self->orientation);
    }
    self->tracked = false;
    return;
  }
  self->tracked = true;
  picture_check_tick(&self->orientation, moved_rad(self, azimuth, pitch, 1), follows(self, azimuth, pitch));
  const camera_objects *objects = &self->objects;
  if (self->frames.taken != objects->taken && objects->message.quality >= objects->params.min_quality) {
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
