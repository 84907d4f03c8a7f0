/* SPDX-License-Identifier: Apache-2.0 */
#include "node/turn_back.h"

#include "base/scalar.h"

/* Leaves what `follow` and `begin` set anew: this happens in each tick without a target. */
void turn_back_reset(turn_back *self) {
  self->follows = false;
  self->running = false;
  self->expected = (pointing_output){0};
  self->absence_s = 0.0f;
}

bool turn_back_is_outside(const turn_back *self, const joint_travel *travel) {
  const float azimuth_rad = self->now.angle_rad.azimuth;
  const float beyond_rad = azimuth_rad - joint_travel_clamp(travel, azimuth_rad);
  return self->follows && !scalar_within(beyond_rad, TURN_BACK_BEYOND_RAD);
}

/* A joint that is turns further in one tick has not moved: its turn has been found. */
static void count_turns(turn_back *self, float joint_rad) {
  const float turns = scalar_round((joint_rad - self->joint_rad) / (2.0f * SCALAR_PI));
  self->joint_rad = joint_rad;
  if (turns != 0.0f) {
    const float by_rad = turns * 2.0f * SCALAR_PI;
    self->acquired_rad += by_rad;
    self->marks[0].angle_rad.azimuth += by_rad;
    self->marks[1].angle_rad.azimuth += by_rad;
  }
}

static void follow(turn_back *self, const turn_back_inputs *inputs) {
  count_turns(self, inputs->joint_rad.azimuth);
  self->now = (target_mark){.at = inputs->tick,
                            .angle_rad = {.azimuth = inputs->joint_rad.azimuth + inputs->error_rad.azimuth,
                                          .pitch = inputs->joint_rad.pitch + inputs->error_rad.pitch}};
  if (!self->follows) {
    self->follows = true;
    self->acquired_rad = self->now.angle_rad.azimuth;
    self->marks[0] = self->now;
    self->marks[1] = self->now;
  } else if (inputs->tick - self->marks[1].at >= TURN_BACK_MARK_TICKS) {
    self->marks[0] = self->marks[1];
    self->marks[1] = self->now;
  }
}

/* Mean rates since the older mark. */
static joint_vector rates_of(const turn_back *self) {
  const target_mark *from = &self->marks[0];
  const target_mark *to = &self->now;
  const float ticks = scalar_max((float)(to->at - from->at), 1.0f);
  return (joint_vector){.azimuth = (to->angle_rad.azimuth - from->angle_rad.azimuth) / (ticks * SERVO_TICK_S),
                        .pitch = (to->angle_rad.pitch - from->angle_rad.pitch) / (ticks * SERVO_TICK_S)};
}

/* Both marks are of this target, so its rate is known, and it moves outwards. */
static int revolutions(const turn_back *self, const turn_back_inputs *inputs) {
  const joint_travel *travel = &inputs->limits->azimuth_travel;
  const bool estimated = self->marks[0].at != self->marks[1].at;
  if (!inputs->allowed || !estimated || !turn_back_is_outside(self, travel)) {
    return 0;
  }
  const float rate_rad_s = rates_of(self).azimuth;
  const int turns = cable_wrap_turns(travel, self->now.angle_rad.azimuth, rate_rad_s);
  return (float)turns * rate_rad_s < 0.0f ? turns : 0;
}

static void begin(turn_back *self, const pointing *line_of_sight, const turn_back_inputs *inputs, int turns) {
  const bool round = !scalar_within(self->now.angle_rad.azimuth - self->acquired_rad, SCALAR_PI);
  const pointing_target target = pointing_tracker_target(&line_of_sight->tracker);
  self->path =
      round ? target_path_round(self->now.angle_rad, rates_of(self)) : target_path_straight(inputs->joint_rad, &target);
  self->begun = inputs->tick;
  self->direction = (float)turns;
  self->running = true;
}

/* Both joints towards the target, or the tracking loop again. */
static void turn(turn_back *self, pointing *line_of_sight, const pointing_motion *motion,
                 const turn_back_inputs *inputs) {
  const target_return_limits *limits = inputs->limits;
  const float time_s = (float)(inputs->tick - self->begun) * SERVO_TICK_S;
  const target_place target = target_path_at(&self->path, time_s);
  const float azimuth_rad =
      target_return_error_rad(target.azimuth.angle_rad - inputs->joint_rad.azimuth, self->direction);
  const float pitch_rad = target.pitch.angle_rad - inputs->joint_rad.pitch;
  pointing_look_away(line_of_sight);
  if (scalar_within(azimuth_rad, TURN_BACK_NEAR_RAD)) {
    const pointing_target expected = target_path_seen(&target, azimuth_rad, motion->pitch);
    self->running = false;
    self->follows = false;
    self->expected = (pointing_output){0};
    self->absence_s = (float)line_of_sight->tracker.along[0].ticks_since_frame * SERVO_TICK_S;
    pointing_tracker_assume(&line_of_sight->tracker, &expected);
    return;
  }
  const float kp = limits->proportional_per_s;
  const joint_vector braking = limits->acceleration_limit_rad_s2;
  const joint_vector rate = {.azimuth = target_return_rate_rad_s(&target.azimuth, azimuth_rad, kp, braking.azimuth),
                             .pitch = target_return_rate_rad_s(&target.pitch, pitch_rad, kp, braking.pitch)};
  const joint_vector limit = limits->rate_limit_rad_s;
  self->expected = (pointing_output){
      .locked = true,
      .limited = true,
      .error_rad = {.x = azimuth_rad * target.horizontal, .y = pitch_rad},
      .error_of_joints_rad = {.azimuth = azimuth_rad, .pitch = pitch_rad},
      .reference = {[SERVO_AZIMUTH] = {.rate_rad_s = scalar_clamp(rate.azimuth, -limit.azimuth, limit.azimuth)},
                    [SERVO_PITCH] = {.rate_rad_s = scalar_clamp(rate.pitch, -limit.pitch, limit.pitch)}}};
}

void turn_back_step(turn_back *self, pointing *line_of_sight, const pointing_motion *motion,
                    const turn_back_inputs *inputs) {
  if (!self->running && inputs->seen) {
    follow(self, inputs);
    self->absence_s = line_of_sight->tracker.along[0].ticks_since_frame == 0 ? 0.0f : self->absence_s;
    const int turns = revolutions(self, inputs);
    if (turns != 0) {
      begin(self, line_of_sight, inputs, turns);
    }
  } else if (!self->running || !inputs->allowed) {
    turn_back_reset(self);
  }
  if (self->running) {
    turn(self, line_of_sight, motion, inputs);
  }
}
