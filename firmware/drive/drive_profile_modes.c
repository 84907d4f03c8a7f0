/* SPDX-License-Identifier: Apache-2.0 */
#include "drive/drive_motion_parts.h"

#define BLOCKED_RAD 2e-4f /* further than wind moves an axis that holds its position */
#define BACK_OFF_RAD 1e-3f

enum { BLOCKED_MS = 100 }; /* a push inwards is shorter */

/* The limits of pp. */
static profile_limits position_limits(const drive_bounds *bounds, const drive_limit_objects *limit) {
  const float rate_rad_s = scalar_min(drive_limit_from_counts(limit->profile_velocity), bounds->position_rad_s);
  return drive_profile_limits(bounds, limit, rate_rad_s, limit->deceleration);
}

/* An axis that cannot brake as hard as 6084 would overshoot its target; the overshoot must not leave the travel. */
static profile_limits limits_of_move(const drive_motion *motion, const drive_objects *objects, drive_angle end,
                                     float distance_rad) {
  const drive_bounds *bounds = &motion->bounds;
  const profile_limits limits = position_limits(bounds, &objects->limit);
  if (!drive_travel_is_limited(&bounds->travel)) {
    return limits;
  }
  const float behind_rad = drive_travel_room_rad(bounds, end, distance_rad);
  const float longest_rad = limits.rate_rad_s * limits.rate_rad_s / (2.0f * bounds->braking_rad_s2);
  return scalar_abs(behind_rad) < longest_rad ? drive_braking_within(bounds, &limits) : limits;
}

static drive_profile_step step_from_now(const drive_motion *motion) {
  /* Every field is named, as in setpoint_of. */
  return (drive_profile_step){.ready = true,
                              .ramp = motion->ramp,
                              .demand = motion->demand,
                              .demand_rest = motion->demand_rest,
                              .target = motion->setpoints.target.angle,
                              .travel_rad = 0.0f,
                              .mean_acceleration_rad_s2 = 0.0f,
                              .held = false,
                              .limited = false,
                              .arrived = false};
}

static void finish_step(drive_profile_step *step, const profile_motion *made) {
  motion_move_demand(&step->demand, &step->demand_rest, made->travel_rad);
  step->travel_rad = made->travel_rad;
  step->mean_acceleration_rad_s2 = made->mean_acceleration_rad_s2;
}

static drive_profile_step prepare_position(const drive_motion *motion, const drive_objects *objects, float dt_s) {
  drive_profile_step step = step_from_now(motion);
  const drive_angle end = step.target;
  const float distance_rad =
      drive_angle_difference_rad(end, motion->demand) - motion->demand_rest * ANGLE_RAD_PER_TURN32;
  const profile_limits limits = limits_of_move(motion, objects, end, distance_rad);
  const profile_motion made = profile_towards_distance(&step.ramp, &limits, distance_rad, dt_s);
  finish_step(&step, &made);
  step.limited = motion->setpoints.target.limited;
  step.arrived = made.arrived;
  if (made.arrived) {
    step.demand = end;
    step.demand_rest = 0.0f;
  }
  return step;
}

/* The room in the coming tick: by then a demand has moved already, and an axis has moved with its ramp. */
static float room_ahead_rad(const drive_motion *motion, float direction) {
  const float moving_rad = motion->loop == SERVO_POSITION ? 0.0f : motion->travel_rad;
  return drive_travel_room_rad(&motion->bounds, motion_start(motion, motion->position), direction) - moving_rad;
}

/* Of homing: 609A while the speed increases and decreases. */
static profile_limits homing_limits(const drive_bounds *bounds, const drive_objects *objects) {
  profile_limits limits = motion_velocity_limits(bounds, &objects->limit);
  limits.acceleration_rad_s2 = drive_limit_from_counts(objects->homing.acceleration);
  limits.deceleration_rad_s2 = limits.acceleration_rad_s2;
  return limits;
}

/* Of pv and hm. */
static drive_profile_step prepare_velocity(const drive_motion *motion, const drive_objects *objects, float dt_s) {
  const drive_bounds *bounds = &motion->bounds;
  const bool homes = motion->mode == DRIVE_HOMING;
  const profile_limits limits =
      homes ? homing_limits(bounds, objects) : motion_velocity_limits(bounds, &objects->limit);
  const profile_limits braking = drive_braking_within(bounds, &limits);
  drive_profile_step step = step_from_now(motion);
  bool clamped;
  const float target_rad_s = motion_clamped_rate(
      homes ? motion->homing_rad_s : drive_rate_from_velocity(objects->velocity.target), &limits, &clamped);
  const profile_motion made = drive_travel_is_limited(&bounds->travel) && target_rad_s != 0.0f
                                  ? profile_towards_rate_within(&step.ramp, &limits, &braking, target_rad_s,
                                                                room_ahead_rad(motion, target_rad_s), dt_s)
                                  : profile_towards_rate(&step.ramp, &limits, target_rad_s, dt_s);
  finish_step(&step, &made);
  const bool stays =
      target_rad_s == 0.0f && (motion->loop == SERVO_POSITION || drive_travel_side(bounds, motion->position) != 0.0f);
  step.held = made.stops || stays;
  step.limited = clamped || made.stops;
  return step;
}

/* A held position may lie where the axis cannot get to: the ramp of an axis that was moving outwards when it was turned
 * on may end behind an end stop. It would push against it until fault 21. */
static void back_off(drive_motion *motion) {
  if (motion->loop != SERVO_POSITION || !profile_at_rest(&motion->ramp)) {
    motion->blocked_ms = 0;
    return;
  }
  const float side = drive_travel_side(&motion->bounds, motion->position);
  const bool blocked = side * drive_angle_difference_rad(motion->demand, motion->position) > BLOCKED_RAD;
  motion->blocked_ms = (uint16_t)(blocked ? motion->blocked_ms + 1 : 0);
  if (motion->blocked_ms >= BLOCKED_MS) {
    motion->blocked_ms = 0;
    motion->demand = motion->position;
    motion->demand_rest = 0.0f;
    motion_move_demand(&motion->demand, &motion->demand_rest, -side * BACK_OFF_RAD);
  }
}

static void keep_jerk(drive_motion *motion, const drive_limit_objects *limit) {
  const float now_rad_s3 = drive_limit_from_counts(limit->jerk);
  const float begun_rad_s3 = motion->ramp.acceleration_rad_s2 != 0.0f ? motion->bounds.jerk_rad_s3 : 0.0f;
  motion->bounds.jerk_rad_s3 = scalar_max(now_rad_s3, begun_rad_s3);
}

void drive_motion_prepare(drive_motion *motion, const drive_objects *objects, const drive_machine *machine,
                          float dt_s) {
  drive_bounds_update(&motion->bounds, objects, machine);
  keep_jerk(motion, &objects->limit);
  motion->next.ready = false;
  back_off(motion);
  const bool has_target = motion->mode == DRIVE_PROFILE_POSITION || motion->mode == DRIVE_TRACKING;
  if (has_target) {
    setpoint_queue_limit(&motion->setpoints, &motion->bounds.travel);
  }
  if (has_target && motion->loop == SERVO_POSITION && motion->setpoints.under_way && !motion->bounds.position_unknown) {
    motion->next = prepare_position(motion, objects, dt_s);
  } else if ((motion->mode == DRIVE_PROFILE_VELOCITY || motion->mode == DRIVE_HOMING) &&
             servo_mode_closes(motion->loop)) {
    motion->next = prepare_velocity(motion, objects, dt_s);
  }
}

/* While nothing is prepared: no jerk. */
static drive_profile_step carry_on(const drive_motion *motion, float dt_s) {
  drive_profile_step step = step_from_now(motion);
  const float gain_rad_s = motion->ramp.acceleration_rad_s2 * dt_s;
  const profile_motion made = {.travel_rad = (motion->ramp.rate_rad_s + 0.5f * gain_rad_s) * dt_s,
                               .mean_acceleration_rad_s2 = motion->ramp.acceleration_rad_s2};
  step.ramp.rate_rad_s += gain_rad_s;
  finish_step(&step, &made);
  return step;
}

/* The set-point of now, then the prepared one. A master that changes the mode in each tick, so that nothing is ever
 * prepared, stops the axis. */
static drive_setpoint take_step(drive_motion *motion, const drive_limit_objects *limit, const drive_feedback *feedback,
                                float dt_s) {
  const bool prepared = motion->next.ready;
  if (!prepared) {
    motion->next = carry_on(motion, dt_s);
    if (motion->carried_on) {
      const profile_limits limits = motion_velocity_limits(&motion->bounds, limit);
      return motion_stop(motion, feedback, &limits, dt_s);
    }
  }
  motion->carried_on = !prepared;
  const drive_profile_step *next = &motion->next;
  drive_setpoint setpoint = motion_setpoint(motion, feedback);
  setpoint.command.speed.acceleration_rad_s2 = next->mean_acceleration_rad_s2;
  setpoint.limited = next->limited;
  motion->ramp = next->ramp;
  motion->travel_rad = next->travel_rad;
  motion->demand = next->demand;
  motion->demand_rest = next->demand_rest;
  return setpoint;
}

drive_setpoint motion_profile_position(drive_motion *motion, const drive_objects *objects,
                                       const drive_feedback *feedback, float dt_s) {
  if (!motion->setpoints.under_way) {
    const profile_limits limits = position_limits(&motion->bounds, &objects->limit);
    drive_setpoint stopping = motion_stop(motion, feedback, &limits, dt_s);
    stopping.limited = motion->setpoints.target.limited;
    return stopping;
  }
  motion_close_loop(motion, SERVO_POSITION, feedback);
  const drive_setpoint setpoint = take_step(motion, &objects->limit, feedback, dt_s);
  if (motion->next.arrived && motion->next.target == motion->setpoints.target.angle) {
    (void)setpoint_queue_finish(&motion->setpoints);
  }
  return setpoint;
}

drive_setpoint motion_profile_velocity(drive_motion *motion, const drive_limit_objects *limit,
                                       const drive_feedback *feedback, float dt_s) {
  const servo_mode before = motion->loop;
  motion_close_loop(motion, motion->next.ready && motion->next.held ? SERVO_POSITION : SERVO_SPEED, feedback);
  if (motion->next.ready && motion->loop != before) { /* the demand is the present position of the axis */
    motion->next.demand = motion->demand;
    motion->next.demand_rest = 0.0f;
    motion_move_demand(&motion->next.demand, &motion->next.demand_rest, motion->next.travel_rad);
  }
  return take_step(motion, limit, feedback, dt_s);
}
