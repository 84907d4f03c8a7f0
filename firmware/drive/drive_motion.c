/* SPDX-License-Identifier: Apache-2.0 */
#include <limits.h>
#include <stddef.h>

#include "base/scalar.h"
#include "drive/drive_motion_parts.h"

/* Share of 607F that the position loop may use to correct an error, and at which a torque may drive the axis. */
#define BEYOND_LIMIT 1.1f

bool drive_mode_supported(int8_t mode) {
  return mode == DRIVE_TRACKING || mode == DRIVE_NO_MODE || mode == DRIVE_PROFILE_POSITION ||
         mode == DRIVE_PROFILE_VELOCITY || mode == DRIVE_HOMING ||
         (mode >= DRIVE_CYCLIC_POSITION && mode <= DRIVE_CYCLIC_TORQUE);
}

profile_limits drive_profile_limits(const drive_bounds *bounds, const drive_limit_objects *limit, float rate_rad_s,
                                    uint32_t deceleration) {
  return (profile_limits){
      .rate_rad_s = rate_rad_s,
      .acceleration_rad_s2 = drive_limit_from_counts(limit->acceleration),
      .deceleration_rad_s2 = drive_limit_from_counts(deceleration),
      .jerk_rad_s3 = scalar_max(drive_limit_from_counts(limit->jerk), bounds->jerk_rad_s3),
  };
}

profile_limits motion_velocity_limits(const drive_bounds *bounds, const drive_limit_objects *limit) {
  return drive_profile_limits(bounds, limit, bounds->rate_rad_s, limit->deceleration);
}

void drive_motion_reset(drive_motion *motion, drive_angle position) {
  const int8_t mode = motion->mode;
  const drive_bounds bounds = motion->bounds;
  *motion = (drive_motion){.mode = mode, .demand = position, .setpoint_age_ticks = INT_MAX, .bounds = bounds};
  motion->setpoints.edge_before = true; /* enabling the axis causes no motion */
}

void drive_motion_shift(drive_motion *motion, drive_angle by) {
  motion->position += by;
  motion->demand += by;
  motion->next.ready = false;
  setpoint_queue_reset(&motion->setpoints, motion->demand, motion->setpoints.edge_before);
  position_interpolation_reset(&motion->positions, motion->demand, motion->ramp.rate_rad_s);
}

/* --- handing over --- */

void motion_close_loop(drive_motion *motion, servo_mode loop, const drive_feedback *feedback) {
  const servo_mode before = motion->loop;
  if (loop == before) {
    return;
  }
  if (before == SERVO_OFF || before == SERVO_TORQUE) {
    motion->ramp = (profile_ramp){.rate_rad_s = feedback->rate_rad_s};
  } else if (before == SERVO_POSITION && loop != SERVO_TORQUE) {
    motion->ramp.rate_rad_s = feedback->reference_rad_s;
    motion->ramp.rate_rest_rad_s = 0.0f;
  }
  motion->demand = feedback->position;
  motion->demand_rest = 0.0f;
  motion->torque_nm = feedback->torque_demand_nm;
  motion->loop = loop;
  rate_interpolation_reset(&motion->rates, motion->ramp.rate_rad_s);
  position_interpolation_reset(&motion->positions, motion->demand, motion->ramp.rate_rad_s);
}

static bool controls_position(int8_t mode) { return mode == DRIVE_PROFILE_POSITION || mode == DRIVE_CYCLIC_POSITION; }

/* A bit 4 that rises together with the mode is a new set-point: RPDO1 carries both in one frame. */
static void enter_mode(drive_motion *motion, int8_t mode, const drive_feedback *feedback) {
  motion->mode = mode;
  motion->next.ready = false;
  motion->blocked_direction = 0.0f;
  motion->tracked_rad_s2 = motion->ramp.acceleration_rad_s2;
  motion->setpoint_age_ticks = INT_MAX;
  const drive_angle from = motion->loop == SERVO_POSITION ? motion->demand : feedback->position;
  setpoint_queue_reset(&motion->setpoints, from, motion->setpoints.edge_before);
  rate_interpolation_reset(&motion->rates, motion->ramp.rate_rad_s);
  position_interpolation_reset(&motion->positions, from, motion->ramp.rate_rad_s);
}

/* --- one tick of the ramp --- */

void motion_move_demand(drive_angle *demand, float *rest, float travel_rad) {
  const float units = travel_rad / ANGLE_RAD_PER_TURN32 + *rest;
  const float whole = scalar_round(units);
  *demand += angle_integer(whole);
  *rest = units - whole;
}

drive_setpoint motion_setpoint(const drive_motion *motion, const drive_feedback *feedback) {
  const bool controlled = motion->loop == SERVO_POSITION;
  /* Every field is named: clearing all of it first would cost a call. */
  return (drive_setpoint){
      .command = {.mode = motion->loop,
                  .speed = {.rate_rad_s = motion->ramp.rate_rad_s, .acceleration_rad_s2 = 0.0f},
                  .position = (angle_turn32)motion->demand,
                  .rate_limit_rad_s = 0.0f,
                  .torque_nm = 0.0f,
                  .torque_limited = false,
                  .limits = {.minimum_nm = 0.0f, .maximum_nm = 0.0f}},
      .position = controlled ? motion->demand : feedback->position,
      .limited = false,
      .followed = true,
      .stopped = false,
  };
}

/* --- the end of the travel --- */

drive_angle motion_start(const drive_motion *motion, drive_angle position) {
  return motion->loop == SERVO_POSITION ? motion->demand : position;
}

bool motion_limit_blocks(drive_motion *motion, const drive_feedback *feedback, const profile_limits *braking,
                         float demanded, const profile_ramp *ahead, float dt_s) {
  if (demanded * motion->blocked_direction < 0.0f) {
    motion->blocked_direction = 0.0f;
  }
  if (motion->blocked_direction == 0.0f && drive_travel_is_limited(&motion->bounds.travel)) {
    const drive_angle from = motion_start(motion, feedback->position);
    const float side = drive_travel_side(&motion->bounds, from);
    const float direction = demanded < 0.0f ? -1.0f : demanded > 0.0f ? 1.0f : side;
    const float margin_rad = drive_travel_room_rad(&motion->bounds, from, direction) - ahead->rate_rad_s * dt_s -
                             profile_stop_travel_rad(ahead, braking);
    motion->blocked_direction = direction != 0.0f && margin_rad * direction <= 0.0f ? direction : 0.0f;
  }
  return motion->blocked_direction != 0.0f;
}

drive_setpoint motion_stop(drive_motion *motion, const drive_feedback *feedback, const profile_limits *limits,
                           float dt_s) {
  const drive_angle from = motion_start(motion, feedback->position);
  profile_limits within = *limits;
  const bool limited = drive_stop_within(&motion->bounds, &within, &motion->ramp, from);
  const bool held = limited || motion->blocked_direction != 0.0f || motion->loop == SERVO_POSITION ||
                    drive_travel_side(&motion->bounds, from) != 0.0f;
  motion_close_loop(motion, held || controls_position(motion->mode) ? SERVO_POSITION : SERVO_SPEED, feedback);
  drive_setpoint setpoint = motion_setpoint(motion, feedback);
  const profile_motion step = profile_towards_rate(&motion->ramp, &within, 0.0f, dt_s);
  /* When the axis goes on before the stop has ended, its deceleration must end before the rate passes 0. */
  motion->bounds.jerk_rad_s3 = scalar_max(motion->bounds.jerk_rad_s3, within.jerk_rad_s3);
  motion->travel_rad = step.travel_rad;
  motion_move_demand(&motion->demand, &motion->demand_rest, step.travel_rad);
  rate_interpolation_reset(&motion->rates, motion->ramp.rate_rad_s);
  position_interpolation_reset(&motion->positions, motion->demand, motion->ramp.rate_rad_s);
  setpoint.command.speed.acceleration_rad_s2 = step.mean_acceleration_rad_s2;
  setpoint.limited = motion->blocked_direction != 0.0f;
  setpoint.followed = false;
  setpoint.stopped = profile_at_rest(&motion->ramp);
  return setpoint;
}

drive_setpoint motion_ordered_stop(drive_motion *motion, const drive_feedback *feedback, const profile_limits *wanted,
                                   float dt_s) {
  profile_limits limits = *wanted;
  drive_stop_at_least(&motion->bounds, &limits, &motion->ramp);
  motion->ordered = true;
  return motion_stop(motion, feedback, &limits, dt_s);
}

float motion_stoppable_rate(const drive_motion *motion, const profile_limits *braking, drive_angle position,
                            float wanted_rad_s, float dt_s) {
  profile_limits gentle = *braking;
  gentle.deceleration_rad_s2 *= 0.8f;
  return drive_rate_within(&motion->bounds, &gentle, position, wanted_rad_s, dt_s);
}

float motion_held_below_limit(float torque_nm, float rate_rad_s, float limit_rad_s) {
  if (!(limit_rad_s > 0.0f)) {
    return 0.0f;
  }
  const float ahead_rad_s = torque_nm < 0.0f ? -rate_rad_s : rate_rad_s;
  const float share = (BEYOND_LIMIT * limit_rad_s - ahead_rad_s) / ((BEYOND_LIMIT - 1.0f) * limit_rad_s);
  return torque_nm * scalar_clamp(share, 0.0f, 1.0f);
}

float motion_clamped_rate(float wanted_rad_s, const profile_limits *limits, bool *limited) {
  const float rate_rad_s = scalar_clamp(wanted_rad_s, -limits->rate_rad_s, limits->rate_rad_s);
  *limited = rate_rad_s != wanted_rad_s;
  return rate_rad_s;
}

/* --- an experiment --- */

/* Its set-point within the position limits and below 607F; the ramp follows, so that a stop begins at the actual rate.
 * A set-point that would leave the limits is blocked, which ends the experiment. */
static drive_setpoint follow(drive_motion *motion, const drive_objects *objects, const drive_feedback *feedback,
                             float dt_s) {
  const servo_axis_command *stimulus = feedback->stimulus;
  const profile_limits limits = motion_velocity_limits(&motion->bounds, &objects->limit);
  const bool torque = stimulus->mode == SERVO_TORQUE;
  const drive_angle wanted = drive_angle_unwrap(feedback->position, stimulus->position);
  const int32_t position = drive_position_from_angle(wanted);
  const bool beyond =
      stimulus->mode == SERVO_POSITION && drive_travel_clamp(&motion->bounds.travel, position) != position;
  const profile_limits braking = drive_braking_within(&motion->bounds, &limits);
  const profile_ramp ahead = {.rate_rad_s = torque ? feedback->rate_rad_s : stimulus->speed.rate_rad_s};
  const float demanded = torque ? stimulus->torque_nm : stimulus->speed.rate_rad_s;
  if (beyond || motion_limit_blocks(motion, feedback, &braking, demanded, &ahead, dt_s)) {
    motion->blocked_direction = beyond && motion->blocked_direction == 0.0f ? 1.0f : motion->blocked_direction;
    return motion_stop(motion, feedback, &braking, dt_s);
  }
  motion_close_loop(motion, stimulus->mode, feedback);
  motion->ramp = (profile_ramp){.rate_rad_s = torque ? feedback->rate_rad_s : stimulus->speed.rate_rad_s};
  motion->demand = wanted;
  motion->demand_rest = 0.0f;
  drive_setpoint setpoint = {.command = *stimulus, .followed = true};
  setpoint.position = stimulus->mode == SERVO_POSITION ? wanted : feedback->position;
  setpoint.command.speed.rate_rad_s = scalar_clamp(stimulus->speed.rate_rad_s, -limits.rate_rad_s, limits.rate_rad_s);
  setpoint.command.torque_nm =
      torque ? motion_held_below_limit(stimulus->torque_nm, feedback->rate_rad_s, limits.rate_rad_s)
             : stimulus->torque_nm;
  return setpoint;
}

/* --- the tick --- */

static drive_setpoint run(drive_motion *motion, const drive_objects *objects, const drive_feedback *feedback,
                          float dt_s) {
  if (motion->bounds.position_unknown && controls_position(motion->mode)) { /* no target has a meaning */
    const profile_limits limits = motion_velocity_limits(&motion->bounds, &objects->limit);
    drive_setpoint waiting = motion_stop(motion, feedback, &limits, dt_s);
    waiting.limited = true;
    return waiting;
  }
  switch (motion->mode) {
    case DRIVE_PROFILE_POSITION:
      return motion_profile_position(motion, objects, feedback, dt_s);
    case DRIVE_PROFILE_VELOCITY:
    case DRIVE_HOMING:
      return motion_profile_velocity(motion, &objects->limit, feedback, dt_s);
    case DRIVE_CYCLIC_POSITION:
      return motion_cyclic_position(motion, objects, feedback, dt_s);
    case DRIVE_CYCLIC_VELOCITY:
      return motion_cyclic_velocity(motion, objects, feedback, dt_s);
    case DRIVE_CYCLIC_TORQUE:
      return motion_cyclic_torque(motion, objects, feedback, dt_s);
    case DRIVE_TRACKING:
      return motion_track(motion, objects, feedback, dt_s);
    case DRIVE_NO_MODE:
    default: {
      if (feedback->stimulus != NULL) {
        return follow(motion, objects, feedback, dt_s);
      }
      motion->blocked_direction = 0.0f;
      const profile_limits limits = motion_velocity_limits(&motion->bounds, &objects->limit);
      return motion_stop(motion, feedback, &limits, dt_s);
    }
  }
}

/* 6072, 60E0 and 60E1, narrowed further by limits in the command; in csp and csv the torque offset 60B2. */
static void add_torque(const drive_motion *motion, const drive_torque_objects *torque, float rate_rad_s,
                       servo_axis_command *command) {
  const uint16_t up = torque->maximum < torque->positive_limit ? torque->maximum : torque->positive_limit;
  const uint16_t down = torque->maximum < torque->negative_limit ? torque->maximum : torque->negative_limit;
  const float up_nm = drive_torque_from_permille(up, torque->rated_mnm);
  const float down_nm = drive_torque_from_permille(down, torque->rated_mnm);
  const torque_limits own = command->torque_limited ? command->limits : (torque_limits){-down_nm, up_nm};
  command->torque_limited = true;
  command->limits = (torque_limits){scalar_max(own.minimum_nm, -down_nm), scalar_min(own.maximum_nm, up_nm)};
  if (motion->mode == DRIVE_CYCLIC_POSITION || motion->mode == DRIVE_CYCLIC_VELOCITY) {
    const float offset_nm = drive_torque_from_permille(torque->offset, torque->rated_mnm);
    const bool held = motion->bounds.position_unknown; /* an end stop may be anywhere: as 6071 */
    command->torque_nm = held ? motion_held_below_limit(offset_nm, rate_rad_s, motion->bounds.rate_rad_s) : offset_nm;
  }
}

/* Whatever the objects hold: they are limited only by their integer types, and the servo axis treats implausible inputs
 * as a sensor fault. */
static void keep_plausible(servo_axis_command *command) {
  const float max_nm = SERVO_PLAUSIBLE_TORQUE_NM;
  const float max_rad_s2 = SERVO_PLAUSIBLE_ACCELERATION_RAD_S2;
  command->speed.acceleration_rad_s2 = scalar_clamp(command->speed.acceleration_rad_s2, -max_rad_s2, max_rad_s2);
  command->torque_nm = scalar_clamp(command->torque_nm, -max_nm, max_nm);
  command->limits.minimum_nm = scalar_max(command->limits.minimum_nm, -max_nm);
  command->limits.maximum_nm = scalar_min(command->limits.maximum_nm, max_nm);
}

/* No loop of the drive is closed. */
static drive_setpoint open_setpoint(drive_action action, const drive_feedback *feedback) {
  drive_setpoint setpoint = {.command = {.mode = SERVO_OFF}, .position = feedback->position};
  if (action == DRIVE_BRAKE) {
    setpoint.command.mode = SERVO_BRAKE;
  } else if (action == DRIVE_PROTECTIVE_STOP) {
    setpoint.command.mode = SERVO_PROTECTIVE_STOP;
    setpoint.command.torque_nm = feedback->protective_nm;
  }
  return setpoint;
}

static setpoint_order order_of(const drive_motion *motion, const drive_objects *objects,
                               const drive_feedback *feedback) {
  return (setpoint_order){.controlword = objects->state.controlword,
                          .target = objects->position.target,
                          .option = objects->position.option,
                          .demand = motion_start(motion, feedback->position),
                          .actual = feedback->position,
                          .wraps = !drive_travel_is_limited(&motion->bounds.travel)};
}

drive_setpoint drive_motion_step(drive_motion *motion, const drive_objects *objects, drive_action action,
                                 const drive_feedback *feedback, float dt_s) {
  const int8_t mode = drive_mode_supported(objects->state.mode) ? objects->state.mode : motion->mode;
  if (action == DRIVE_OFF || action == DRIVE_BRAKE || action == DRIVE_PROTECTIVE_STOP) {
    drive_motion_reset(motion, feedback->position);
    motion->mode = mode;
    return open_setpoint(action, feedback);
  }
  motion->position = feedback->position;
  motion->ordered = false;
  motion->followed = NULL;
  if (motion->loop == SERVO_OFF) {
    motion_close_loop(motion, controls_position(mode) ? SERVO_POSITION : SERVO_SPEED, feedback);
    enter_mode(motion, mode, feedback);
  } else if (mode != motion->mode) {
    enter_mode(motion, mode, feedback);
  }
  if (mode == DRIVE_PROFILE_POSITION) {
    const setpoint_order order = order_of(motion, objects, feedback);
    (void)setpoint_queue_step(&motion->setpoints, &order);
  } else {
    setpoint_queue_idle(&motion->setpoints, objects->state.controlword);
  }
  drive_setpoint setpoint;
  if (action == DRIVE_RUN) {
    setpoint = run(motion, objects, feedback, dt_s);
  } else {
    const drive_limit_objects *limit = &objects->limit;
    const uint32_t deceleration = action == DRIVE_QUICK_STOP ? limit->quick_stop_deceleration : limit->deceleration;
    const profile_limits limits = drive_profile_limits(&motion->bounds, limit, motion->bounds.rate_rad_s, deceleration);
    setpoint = motion_ordered_stop(motion, feedback, &limits, dt_s);
  }
  motion->next.ready = false;
  add_torque(motion, &objects->torque, feedback->rate_rad_s, &setpoint.command);
  setpoint.command.rate_limit_rad_s = BEYOND_LIMIT * motion->bounds.rate_rad_s;
  keep_plausible(&setpoint.command);
  return setpoint;
}
