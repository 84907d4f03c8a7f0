/* SPDX-License-Identifier: Apache-2.0 */
#include "base/scalar.h"
#include "node/tracking_parts.h"

enum { CAMERA = 0x3071, CAMERA_SCALE = 1, CAMERA_ROLL = 2, CAMERA_MIRRORED = 7, CAMERA_STATED_DELAY = 8 };

#define TRUSTED_RAD 2e-4f

enum { MESSAGES_PER_MS = 2 };
enum { US_PER_TICK = 1000, US_PER_TIME = 10, ESTIMATED_TICKS = 500, STALE_TICKS = 1000 };

/* Told: eight repeated frames in a row or six others; in the long run more than half of the frames, or two in five. So
 * a sender that sends each frame twice is not told, and of two senders at once each is. */
enum { STALE_DROPS = 16, DROP_OF_REPEATED = 2, DROP_OF_OTHER = 3, BACK_OF_TAKEN = 2 };

void tracking_start(target_tracking *self, hal *machine) {
  self->machine = machine;
  exposure_clock_reset(&self->clock);
  strobe_log_reset(&self->strobe);
  picture_check_reset(&self->orientation);
}

void tracking_forget(target_tracking *self) {
  joint_tracking_reset(&self->joints);
  camera_input_reset(&self->frames);
  camera_delay_reset(&self->delay);
  self->objects.dither_s = 0;
  self->picture = (frozen_picture){0};
  self->jumps = (jumping_picture){0};
  self->strays = (stray_frames){0};
  picture_check_reset(&self->orientation);
  self->arrived = false;
  self->stale = false;
}

static void take_strobes(target_tracking *self) {
  hal_strobes strobes;
  hal_take_strobes(self->machine, &strobes);
  strobe_log_add(&self->strobe, &strobes);
}

/* What the message says of its exposure, and by which clock. */
static int32_t stated_age(target_tracking *self) {
  const camera_objects *objects = &self->objects;
  const bool by_clock = (objects->params.time & CAMERA_NODE_CLOCK) != 0;
  self->objects.time_source = by_clock ? CAMERA_NODE_CLOCK : CAMERA_AGE;
  const int32_t age = by_clock ? exposure_clock_age(&self->clock, objects->message.time) : objects->message.time;
  return age == CAMERA_AGE_AMBIGUOUS ? age : age + objects->stated_delay;
}

static int32_t find_age(target_tracking *self) {
  const camera_objects *objects = &self->objects;
  if (objects->params.time < CAMERA_STROBE_OR_AGE) {
    return stated_age(self);
  }
  take_strobes(self);
  if (!strobe_log_pair(&self->strobe, &objects->strobe, objects->message.counter, self->clock.next_tick_us)) {
    return stated_age(self);
  }
  self->objects.time_source = CAMERA_STROBE_OR_AGE;
  return (int32_t)(self->strobe.age_us / US_PER_TIME);
}

static bool is_mounting(const od_object *object) {
  const uint8_t sub = object->entry->sub;
  return object->entry->index == CAMERA && (sub == CAMERA_SCALE || sub == CAMERA_ROLL || sub == CAMERA_MIRRORED);
}

static bool is_stated_delay(const od_object *object) {
  return object->entry->index == CAMERA && object->entry->sub == CAMERA_STATED_DELAY;
}

/* Of many messages in one ms the tick can take only one; to look at each would make it late. */
static void take_message(target_tracking *self) {
  if (self->messages >= MESSAGES_PER_MS) {
    camera_input_refuse(&self->frames, CAMERA_NOT_NEWER);
    return;
  }
  self->messages++;
  const camera_message *message = &self->objects.message;
  const image_vector error = camera_input_error(&self->frames, &self->objects.params, message);
  if (message->quality >= self->objects.params.min_quality && frozen_picture_shows(&self->picture, error)) {
    camera_input_refuse(&self->frames, CAMERA_FROZEN);
    return;
  }
  if (picture_check_is_wrong(&self->orientation)) {
    camera_input_refuse(&self->frames, CAMERA_PICTURE_WRONG);
    return;
  }
  if (self->arrived && message->counter != self->message.counter) {
    camera_input_refuse(&self->frames, CAMERA_NOT_NEWER); /* the one before in this ms */
  }
  self->exposure_age = find_age(self);
  self->message = *message; /* a later one that is refused must not change it */
  self->error = error;
  self->arrived = true;
}

static void changed(void *owner, const od_object *object) {
  target_tracking *self = owner;
  if (camera_objects_hand_over(object)) {
    take_message(self);
  } else if (is_mounting(object)) {
    picture_check_reset(&self->orientation);
  } else if (is_stated_delay(object)) {
    camera_delay_reset(&self->delay);
  }
}

static unsigned needed(const od_object *object) {
  return camera_objects_hand_over(object) || is_mounting(object) || is_stated_delay(object) ? OD_HOOK_CHANGED : 0u;
}

const od_hooks tracking_hooks = {.changed = changed, .needed = needed};

/* The frame that has arrived in this tick, if it counts. */
static pointing_frame newest_frame(target_tracking *self, uint32_t tick) {
  pointing_frame frame = {0};
  if (self->arrived) {
    self->arrived = false;
    frame =
        camera_input_take(&self->frames, &self->objects.params, &self->message, self->error, self->exposure_age, tick);
  }
  if (jumping_picture_take(&self->jumps, &frame, SERVO_TICK_S)) {
    camera_input_take_back(&self->frames, CAMERA_JUMPS);
    return (pointing_frame){0};
  }
  return frame;
}

static pointing_frame take_frame(target_tracking *self, uint32_t tick) {
  pointing_frame frame = newest_frame(self, tick);
  if (frame.fresh) {
    self->objects.age_ms = (uint8_t)frame.age_ticks;
    camera_delay_notice(&self->delay, &frame);
    frame.age_ticks = camera_delay_age(&self->delay, &self->objects.delay, frame.age_ticks);
  }
  return frame;
}

/* How far each joint is from the target. */
static joint_frame joints_of(const servo_board *board, const pointing_frame *frame, bool changes) {
  if (!frame->fresh || changes) {
    return (joint_frame){0};
  }
  return (joint_frame){.fresh = true,
                       .valid = frame->valid,
                       .age_ticks = frame->age_ticks,
                       .error_rad = line_of_sight_joint_errors(board->samples.pitch, frame->error)};
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

/* The drives follow the target of the line of sight, the pitch with the dither on it. */
static void show_target(target_tracking *self, const servo_params *servo) {
  const joint_vector errors = self->target.seen_rad;
  for (int i = 0; i < SERVO_AXES; ++i) {
    self->joint[i] = (servo_target){.known = self->target.locked,
                                    .error_rad = i == SERVO_PITCH ? errors.pitch : errors.azimuth,
                                    .reference = self->target.reference[i],
                                    .torque_nm = self->target.torque_nm[i],
                                    .proportional_per_s = self->line_of_sight.params.tracker.proportional_per_s,
                                    .frame_age_ticks = self->line_of_sight.tracker.along[0].ticks_since_frame,
                                    .at_loss = servo->axis[i].at_loss};
  }
  self->joint[SERVO_PITCH].reference.rate_rad_s += self->dither_rad_s;
}

/* An axis begins to track what its joint knows of the target. A slew by frames whose ages are not exact leaves a false
 * rate, or an estimate that the last frame contradicts: then that frame counts alone, as the first one of a target
 * does. */
static void begin(target_tracking *self, int axis, const drive_axis *drive) {
  target_tracker_state *joint = &self->joints.axis[axis];
  const bool tracks = drive->tracking != DRIVE_NOT_TRACKING;
  const bool begins = tracks && !self->joints.tracks[axis];
  self->joints.tracks[axis] = tracks;
  if (!begins || !joint->locked || !self->predicts[axis]) {
    return;
  }
  const bool steady = self->joints.steady[axis].ticks >= JOINT_STEADY_TICKS;
  if (!steady || !scalar_within(joint->untaken_rad, TRUSTED_RAD)) {
    const float rate_rad_s = drive->motion.ramp.rate_rad_s;
    const int age_ticks = camera_delay_age(&self->delay, &self->objects.delay, self->objects.age_ms);
    const float error_rad = target_tracker_seen_rad(joint, age_ticks, rate_rad_s, SERVO_TICK_S);
    target_tracker_assume(joint, error_rad, rate_rad_s, 0.0f);
  }
}

/* What each joint has known of the target, until frames say more. */
static void join(target_tracking *self, const drive_axis *pitch_drive) {
  self->phase = TRACKING_JOINED;
  const target_tracker_state *azimuth = &self->joints.axis[SERVO_AZIMUTH];
  const target_tracker_state *pitch = &self->joints.axis[SERVO_PITCH];
  if (!azimuth->locked || !pitch->locked) {
    return;
  }
  const float cosine = rotation_cosine((angle_turn32)pitch_drive->position);
  const pointing_target target = {
      .error = {.x = cosine * azimuth->error_rad, .y = pitch->error_rad},
      .rate_rad_s = {.x = cosine * azimuth->target_rate_rad_s, .y = pitch->target_rate_rad_s},
      .acceleration_rad_s2 = {.x = cosine * azimuth->target_acceleration_rad_s2,
                              .y = pitch->target_acceleration_rad_s2}};
  pointing_tracker_assume(&self->line_of_sight.tracker, &target);
  for (int i = 0; i < 2; ++i) {
    self->line_of_sight.tracker.along[i].ticks_since_frame = self->joints.axis[SERVO_AZIMUTH].ticks_since_frame;
  }
}

/* The axis that stays goes on with what the line of sight has known. */
static void part(target_tracking *self) {
  const target_tracker_state *along = &self->line_of_sight.tracker.along[0];
  if (!along->locked || self->turn.running) {
    return;
  }
  const float k = self->line_of_sight.params.tracker.proportional_per_s;
  for (int i = 0; i < SERVO_AXES; ++i) {
    const joint_vector errors = self->target.error_of_joints_rad;
    const float error_rad = i == SERVO_PITCH ? errors.pitch : errors.azimuth;
    const speed_reference *reference = &self->target.reference[i];
    target_tracker_assume(&self->joints.axis[i], error_rad, reference->rate_rad_s - k * error_rad,
                          reference->acceleration_rad_s2);
    self->joints.axis[i].ticks_since_frame = along->ticks_since_frame;
  }
}

/* Limits the rate of a joint that follows by itself, until the picture is known to be right. */
static void hold_back(target_tracking *self) {
  const bool judged = self->orientation.verdict != PICTURE_NOT_JUDGED;
  const float limit_rad_s = self->orientation.rate_limit_rad_s;
  for (int i = 0; i < SERVO_AXES; ++i) {
    speed_reference *reference = &self->joint[i].reference;
    self->held_back[i] = !judged && !scalar_within(reference->rate_rad_s, limit_rad_s);
    if (self->held_back[i]) {
      reference->rate_rad_s = scalar_clamp(reference->rate_rad_s, -limit_rad_s, limit_rad_s);
      reference->acceleration_rad_s2 = 0.0f;
    }
  }
}

void tracking_take(target_tracking *self, const servo_board *board, uint32_t tick, int tracking_axes, bool changes) {
  const pointing_frame frame = take_frame(self, tick);
  const bool before = tracking_is_together(self);
  const bool may = tracking_axes == SERVO_AXES && self->prepared && predicts(&board->app.params);
  if (may) {
    self->phase = before || self->phase == TRACKING_JOINED ? TRACKING_TOGETHER : TRACKING_JOINS;
  } else {
    self->phase = before ? TRACKING_PARTS : TRACKING_APART;
  }
  self->prepared = self->prepared && (may || !before);
  if (tracking_is_together(self)) {
    self->motion = pointing_motion_of(&board->app, &board->samples);
    self->target = pointing_step(&self->line_of_sight, &frame, &self->motion, SERVO_TICK_S);
    if (!self->target.locked) {
      self->target = self->turn.expected;
    }
    show_target(self, &board->app.params);
    joint_tracking_remember(&self->joints, &board->app);
  } else if (self->phase == TRACKING_PARTS) { /* the axis that stays goes on as it did */
    joint_tracking_remember(&self->joints, &board->app);
  } else {
    const joint_frame joints = joints_of(board, &frame, changes);
    joint_tracking_step(&self->joints, &board->app, &joints, self->joint);
    hold_back(self);
  }
}

void tracking_prepare(target_tracking *self, const servo_params *servo, float azimuth_swing_kg_m2, uint32_t changes) {
  if (tracking_is_together(self) || (self->prepared && self->prepared_changes == changes)) {
    return;
  }
  self->prepared_changes = changes;
  const pointing_params params = params_of(servo, azimuth_swing_kg_m2);
  self->prepared = pointing_configure(&self->line_of_sight, &params) == CONTROL_OK;
  for (int i = 0; i < SERVO_AXES; ++i) {
    self->predicts[i] = servo->axis[i].tracker.kind == TRACKER_PREDICTIVE;
    self->estimator_rad_s[i] = servo->axis[i].tracker.estimator_rad_s;
  }
  self->coast_s = params.tracker.coast_s;
  self->rate_rad_s = params.tracker.rate_limit_rad_s;
}

static int16_t time_of(float time_s) {
  const float most = 32767.0f;
  return (int16_t)scalar_round(scalar_clamp(time_s * (float)CAMERA_TIMES_PER_TICK / SERVO_TICK_S, -most, most));
}

/* By its frames; while the azimuth turns back, the target is only expected. */
static bool is_seen(const target_tracking *self) {
  return tracking_is_together(self) && self->line_of_sight.tracker.along[0].locked;
}

static void measure_delay(target_tracking *self, uint32_t tick) {
  camera_objects *objects = &self->objects;
  camera_delay_step(&self->delay, &objects->delay, &self->line_of_sight.tracker, objects->params.scale_rad,
                    is_seen(self), SERVO_TICK_S);
  if (!tracking_is_together(self)) {
    objects->dither_s = 0;
  } else if (objects->dither_s != 0 && tick % SERVO_TICKS_PER_S == 0) {
    objects->dither_s--;
  }
  self->dither_rad_s = camera_delay_dither(&self->delay, &objects->delay, objects->dither_s != 0, SERVO_TICK_S);
  const delay_error *found = &self->delay.found;
  objects->delay_error = time_of(found->error_s);
  objects->delay_half_width = found->known ? (uint16_t)time_of(found->half_width_s) : CAMERA_DELAY_UNKNOWN;
  objects->correction_ms = objects->delay.use == CAMERA_DELAY_CORRECTED ? (int8_t)self->delay.offset_ticks : 0;
}

static void report_strobe(target_tracking *self) {
  camera_objects *objects = &self->objects;
  const strobe_log *strobe = &self->strobe;
  objects->strobe_time_us = strobe_log_newest_us(strobe) + self->clock.offset_us;
  objects->strobe_edges = strobe->edges;
  objects->strobe_paired = strobe->paired;
  objects->strobe_unpaired = strobe->unpaired;
  objects->strobe_refusal = (uint8_t)strobe->last_refusal;
  objects->strobe_missing = strobe->missing;
  objects->strobe_additional = strobe->additional;
  objects->strobe_floods = strobe->floods;
  objects->strobe_age = (uint16_t)(strobe->age_us / US_PER_TIME);
}

/* Within the range 607B: a float has no digits for more turns. */
static float joint_rad(const drive_axis *drive) {
  return drive_angle_difference_rad(drive_angle_wrap(drive->position), 0);
}

static joint_travel travel_of(const drive_bounds *bounds) {
  return (joint_travel){drive_angle_difference_rad(bounds->lowest, 0), drive_angle_difference_rad(bounds->highest, 0)};
}

static target_return_limits limits_of(const target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch) {
  return (target_return_limits){
      .proportional_per_s = self->line_of_sight.params.tracker.proportional_per_s,
      .rate_limit_rad_s = {.azimuth = scalar_min(self->rate_rad_s.azimuth, azimuth->motion.bounds.rate_rad_s),
                           .pitch = scalar_min(self->rate_rad_s.pitch, pitch->motion.bounds.rate_rad_s)},
      .acceleration_limit_rad_s2 = {.azimuth = azimuth->motion.tracking.acceleration_rad_s2,
                                    .pitch = pitch->motion.tracking.acceleration_rad_s2},
      .azimuth_travel = travel_of(&azimuth->motion.bounds)};
}

/* A target that has just been found is taken to move as the line of sight does. While that may be wrong, braking by it
 * would be, too: the first frames count, and the loop returns to them as fast as it can. */
static joint_vector braking_of(const target_tracking *self, const target_return_limits *limits) {
  return self->locked_ticks >= ESTIMATED_TICKS ? limits->acceleration_limit_rad_s2 : (joint_vector){0};
}

static uint8_t wrap_state(const target_tracking *self, const target_return_limits *limits) {
  if (self->turn.running) {
    return CAMERA_TURNS_BACK;
  }
  return turn_back_is_outside(&self->turn, &limits->azimuth_travel) ? CAMERA_TARGET_OUTSIDE : CAMERA_WITHIN_TRAVEL;
}

/* Until the target is to be back it may be absent, and for 2011:5 longer. */
static float coast_s(const target_tracking *self) {
  if (self->orientation.verdict == PICTURE_NOT_JUDGED) {
    return scalar_min(self->coast_s, PICTURE_UNPROVEN_COAST_S);
  }
  return self->coast_s + scalar_max(return_prediction_absence_s(&self->back), self->turn.absence_s);
}

/* Of the joints, until the picture is known to be right. */
static joint_vector rate_limit_of(const target_tracking *self) {
  if (self->orientation.verdict != PICTURE_NOT_JUDGED) {
    return self->rate_rad_s;
  }
  const float limit_rad_s = self->orientation.rate_limit_rad_s;
  const float cosine = scalar_max(scalar_abs(self->motion.pitch.cosine), POINTING_ZENITH_COSINE);
  return (joint_vector){.azimuth = scalar_min(self->rate_rad_s.azimuth, limit_rad_s / cosine),
                        .pitch = scalar_min(self->rate_rad_s.pitch, limit_rad_s)};
}

static void look_ahead(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch, uint32_t tick) {
  camera_objects *objects = &self->objects;
  if (!tracking_is_together(self)) {
    if (self->phase == TRACKING_PARTS) {
      part(self);
    }
    self->locked_ticks = 0;
    return_prediction_reset(&self->back);
    turn_back_reset(&self->turn);
    objects->back_in_ms = 0;
    objects->wrap_state = CAMERA_WITHIN_TRAVEL;
    if (self->phase == TRACKING_JOINS) {
      join(self, pitch);
    }
    return;
  }
  const target_return_limits limits = limits_of(self, azimuth, pitch);
  const joint_vector joints_rad = {.azimuth = joint_rad(azimuth), .pitch = joint_rad(pitch)};
  pointing_tracker_params *loop = &self->line_of_sight.params.tracker;
  if (!self->turn.running) { /* what is expected of a target has been estimated */
    self->locked_ticks = is_seen(self) ? self->locked_ticks + 1 : 0;
  }
  loop->braking_rad_s2 = braking_of(self, &limits);
  loop->rate_limit_rad_s = rate_limit_of(self);
  const turn_back_inputs turn = {.allowed = objects->turn_back != 0 && !azimuth->motion.bounds.position_unknown,
                                 .seen = is_seen(self),
                                 .tick = tick,
                                 .joint_rad = joints_rad,
                                 .error_rad = self->target.error_of_joints_rad,
                                 .limits = &limits};
  turn_back_step(&self->turn, &self->line_of_sight, &self->motion, &turn);
  const return_prediction_inputs inputs = {.line_of_sight = &self->line_of_sight,
                                           .motion = &self->motion,
                                           .target = &self->target,
                                           .turn = &self->turn,
                                           .joint_rad = joints_rad};
  objects->back_in_ms = return_prediction_step(&self->back, &limits, &inputs, tick);
  objects->wrap_state = wrap_state(self, &limits);
  loop->coast_s = coast_s(self);
  pointing_tracker_prepare(&self->line_of_sight.tracker, loop, self->target.error_of_joints_rad, SERVO_TICK_S);
}

/* Another target with the counter of the last message is that of a second sender. */
static bool shows_the_same(const target_tracking *self) {
  const camera_message *now = &self->message;
  const camera_message *before = &self->counted;
  return now->x == before->x && now->y == before->y && now->quality == before->quality;
}

/* Before the objects have the counts of this tick. */
static void count_drops(target_tracking *self, bool tracks) {
  if (!tracks) {
    self->drops = 0;
    self->stale = false;
    camera_input_expect_restarts(&self->frames);
    return;
  }
  const uint32_t dropped = self->frames.dropped - self->objects.dropped;
  if (self->frames.taken != self->objects.taken) {
    self->drops = (uint16_t)(self->drops > BACK_OF_TAKEN ? self->drops - BACK_OF_TAKEN : 0);
    self->counted = self->message;
  } else if (dropped > 0 && self->drops < STALE_DROPS) {
    const bool repeated = self->frames.last_drop == CAMERA_NOT_NEWER && self->frames.repeated && shows_the_same(self);
    self->drops = (uint16_t)(self->drops + (repeated ? DROP_OF_REPEATED : DROP_OF_OTHER));
  }
  self->quiet_ticks = (uint16_t)(dropped == 0 && self->quiet_ticks < STALE_TICKS ? self->quiet_ticks + 1 : 0);
  self->stale = self->drops >= STALE_DROPS || picture_check_is_wrong(&self->orientation) ||
                (self->stale && self->quiet_ticks < STALE_TICKS);
}

bool tracking_is_stale(const target_tracking *self) { return self->stale; }

void tracking_report(target_tracking *self, const drive_axis *azimuth, const drive_axis *pitch, uint32_t tick) {
  camera_objects *objects = &self->objects;
  self->messages = 0;
  const bool tracks = azimuth->tracking != DRIVE_NOT_TRACKING || pitch->tracking != DRIVE_NOT_TRACKING;
  tracking_drop_stray_frame(self, azimuth, pitch, tracks);
  count_drops(self, tracks);
  if (tracks || self->tracked) {
    begin(self, SERVO_AZIMUTH, azimuth);
    begin(self, SERVO_PITCH, pitch);
  }
  tracking_check_picture(self, azimuth, pitch, tracks);
  tracking_look_for_a_frozen_picture(self, azimuth, pitch, tick);
  objects->taken = self->frames.taken;
  objects->missed = self->frames.missed;
  objects->dropped = self->frames.dropped;
  objects->last_drop = (uint8_t)self->frames.last_drop;
  tracking_report_picture(self, azimuth, pitch);
  objects->clock = self->clock.stamp;
  take_strobes(self);
  report_strobe(self);
  exposure_clock_tick(&self->clock, hal_tick_us(self->machine) + US_PER_TICK);
  measure_delay(self, tick);
  look_ahead(self, azimuth, pitch, tick);
}
