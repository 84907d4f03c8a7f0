/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stddef.h>

#include "base/scalar.h"
#include "drive/drive_motion_parts.h"

/* No faster towards the target than the axis can still stop within the travel, and no change of the rate above 6083:
 * the first frame of a target may ask for any rate. */
static drive_tracking_limits tracking_within(const drive_motion *motion, const profile_limits *limits,
                                             const profile_limits *braking, const drive_feedback *feedback,
                                             float dt_s) {
  const float towards_rad_s = feedback->target->reference.rate_rad_s < 0.0f ? -limits->rate_rad_s : limits->rate_rad_s;
  const float fastest_rad_s = motion_stoppable_rate(motion, braking, feedback->position, towards_rad_s, dt_s);
  return (drive_tracking_limits){.minimum_rad_s = towards_rad_s < 0.0f ? fastest_rad_s : -limits->rate_rad_s,
                                 .maximum_rad_s = towards_rad_s < 0.0f ? limits->rate_rad_s : fastest_rad_s,
                                 .acceleration_rad_s2 = limits->acceleration_rad_s2,
                                 .jerk_rad_s3 = limits->jerk_rad_s3};
}

/* At or beyond an end of the travel, while the target does not lead back inside. */
static bool is_held_at_end(const drive_motion *motion, const drive_feedback *feedback) {
  const float side = drive_travel_side(&motion->bounds, feedback->position);
  return side != 0.0f && side * feedback->target->reference.rate_rad_s >= 0.0f;
}

/* A rate that is limited for some ticks only would make the torque jump, so its acceleration is fed forward with
 * limited jerk. */
static speed_reference tracked_reference(const drive_motion *motion, const speed_reference *wanted, float dt_s) {
  const drive_tracking_limits *limits = &motion->tracking;
  const float before_rad_s = motion->ramp.rate_rad_s;
  const float rate_rad_s = drive_tracking_rate_within(limits, wanted->rate_rad_s, before_rad_s, dt_s);
  const bool limited = rate_rad_s != wanted->rate_rad_s;
  const float step_rad_s2 = limits->jerk_rad_s3 * dt_s;
  return (speed_reference){
      .rate_rad_s = rate_rad_s,
      .acceleration_rad_s2 = scalar_clamp(limited ? (rate_rad_s - before_rad_s) / dt_s : wanted->acceleration_rad_s2,
                                          motion->tracked_rad_s2 - step_rad_s2, motion->tracked_rad_s2 + step_rad_s2)};
}

/* To where mode -1 began. */
static drive_setpoint return_to_start(drive_motion *motion, const drive_objects *objects,
                                      const drive_feedback *feedback, float dt_s) {
  drive_setpoint setpoint = motion_profile_position(motion, objects, feedback, dt_s);
  setpoint.followed = false;
  motion->tracked_rad_s2 = motion->ramp.acceleration_rad_s2;
  return setpoint;
}

/* Without a target the axis stops and stays where it looks, or returns if that is within the travel; at the end of the
 * travel it waits for the target. */
drive_setpoint motion_track(drive_motion *motion, const drive_objects *objects, const drive_feedback *feedback,
                            float dt_s) {
  const profile_limits limits = motion_velocity_limits(&motion->bounds, &objects->limit);
  const profile_limits braking = drive_braking_within(&motion->bounds, &limits);
  const servo_target *target = feedback->target;
  const bool known = target != NULL && target->known && isfinite(target->reference.rate_rad_s);
  if (known) {
    motion->setpoints.under_way = target->at_loss == TARGET_LOSS_RETURN;
  } else if (motion->setpoints.under_way && !motion->setpoints.target.limited && !motion->bounds.position_unknown) {
    return return_to_start(motion, objects, feedback, dt_s);
  }
  if (!known || is_held_at_end(motion, feedback)) {
    drive_setpoint stopping = motion_stop(motion, feedback, &braking, dt_s);
    stopping.limited = stopping.limited || known;
    stopping.followed = known;
    motion->tracked_rad_s2 = motion->ramp.acceleration_rad_s2;
    return stopping;
  }
  motion_close_loop(motion, SERVO_SPEED, feedback);
  motion->tracking = tracking_within(motion, &limits, &braking, feedback, dt_s);
  const speed_reference reference = tracked_reference(motion, &target->reference, dt_s);
  motion->followed = target;
  motion->tracked_rad_s2 = reference.acceleration_rad_s2;
  motion->ramp = (profile_ramp){.rate_rad_s = reference.rate_rad_s};
  drive_setpoint setpoint = motion_setpoint(motion, feedback);
  setpoint.command.speed = reference;
  setpoint.command.torque_nm = target->torque_nm;
  setpoint.limited = reference.rate_rad_s != target->reference.rate_rad_s;
  return setpoint;
}
