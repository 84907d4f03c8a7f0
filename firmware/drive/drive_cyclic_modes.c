/* SPDX-License-Identifier: Apache-2.0 */
#include <limits.h>

#include "base/scalar.h"
#include "drive/drive_motion_parts.h"

/* Whether a cyclic mode has no set-point: none since it was entered, or none for too long. */
static bool setpoints_missing(drive_motion *motion, const drive_feedback *feedback, int period_ticks) {
  if (feedback->setpoint_arrived) {
    motion->setpoint_age_ticks = 0;
  } else if (motion->setpoint_age_ticks < INT_MAX) {
    ++motion->setpoint_age_ticks;
  }
  return interpolation_stale(motion->setpoint_age_ticks, period_ticks);
}

/* Divided again only when 60C2 has changed. */
static int period_of(drive_motion *motion, const drive_limit_objects *limit, float dt_s) {
  setpoint_period *known = &motion->period;
  const bool same = known->mantissa == limit->interpolation_period && known->exponent == limit->interpolation_exponent;
  if (known->ticks == 0 || !same) {
    const int ticks = interpolation_ticks(limit->interpolation_period, limit->interpolation_exponent, dt_s);
    *known = (setpoint_period){limit->interpolation_period, limit->interpolation_exponent, ticks > 0 ? ticks : 1};
  }
  return known->ticks;
}

/* Moves the demand towards the set-points, no faster than it can be stopped within the travel. Returns whether it was
 * held back. Then it lags the set-points, moves at the rate returned, and meets them again when they reverse. */
static bool demand_within(drive_motion *motion, const profile_limits *braking, drive_angle wanted, float *rate_rad_s,
                          float dt_s) {
  const float wanted_rad_s = drive_angle_difference_rad(wanted, motion->demand) / dt_s;
  const float slow_rad_s = drive_rate_within(&motion->bounds, braking, motion->demand, wanted_rad_s, dt_s);
  const bool braked = scalar_abs(slow_rad_s) < scalar_abs(wanted_rad_s);
  if (braked) {
    motion_move_demand(&motion->demand, &motion->demand_rest, slow_rad_s * dt_s);
    *rate_rad_s = slow_rad_s;
  } else {
    motion->demand = wanted;
    motion->demand_rest = 0.0f;
  }
  return braked;
}

/* Without a limited travel, the nearest angle with this direction in the range 607B. */
static drive_angle nearest_angle(const drive_motion *motion, int32_t position) {
  const drive_angle angle = drive_angle_from_position(position);
  return drive_travel_is_limited(&motion->bounds.travel) ? angle
                                                         : motion->demand + drive_angle_wrap(angle - motion->demand);
}

/* The acceleration from position set-points is only as fine as their resolution: 1e-7 rad within a period of 1 ms is
 * 0.1 rad/s^2. So csp gives position and rate; a client that knows the acceleration sends it as a torque (60B2). */
drive_setpoint motion_cyclic_position(drive_motion *motion, const drive_objects *objects,
                                      const drive_feedback *feedback, float dt_s) {
  const drive_limit_objects *limit = &objects->limit;
  const profile_limits limits =
      drive_profile_limits(&motion->bounds, limit, motion->bounds.position_rad_s, limit->deceleration);
  const int period_ticks = period_of(motion, limit, dt_s);
  if (setpoints_missing(motion, feedback, period_ticks)) {
    return motion_ordered_stop(motion, feedback, &limits, dt_s);
  }
  motion_close_loop(motion, SERVO_POSITION, feedback);
  const int32_t target = drive_travel_clamp(&motion->bounds.travel, objects->position.target);
  bool cut = false;
  if (feedback->setpoint_arrived) {
    cut = position_interpolation_aim(&motion->positions, nearest_angle(motion, target), period_ticks, limits.rate_rad_s,
                                     dt_s);
  }
  const interpolated_position now = position_interpolation_step(&motion->positions, dt_s);
  /* Set-points have no jerk limit; their deceleration is limited only by the motor. */
  const profile_limits braking = {.deceleration_rad_s2 = motion->bounds.braking_rad_s2, .jerk_rad_s3 = 1e9f};
  float rate_rad_s = now.rate_rad_s;
  const bool braked = demand_within(motion, &braking, now.position, &rate_rad_s, dt_s);
  motion->ramp = (profile_ramp){.rate_rad_s = rate_rad_s};
  drive_setpoint setpoint = motion_setpoint(motion, feedback);
  const float wanted_rad_s = rate_rad_s + drive_rate_from_velocity(objects->velocity.offset);
  const float bounded_rad_s = scalar_clamp(wanted_rad_s, -limits.rate_rad_s, limits.rate_rad_s);
  setpoint.command.speed.rate_rad_s = drive_rate_within(&motion->bounds, &braking, motion->demand, bounded_rad_s, dt_s);
  setpoint.limited =
      cut || braked || target != objects->position.target || setpoint.command.speed.rate_rad_s != wanted_rad_s;
  return setpoint;
}

drive_setpoint motion_cyclic_velocity(drive_motion *motion, const drive_objects *objects,
                                      const drive_feedback *feedback, float dt_s) {
  const profile_limits limits = motion_velocity_limits(&motion->bounds, &objects->limit);
  const int period_ticks = period_of(motion, &objects->limit, dt_s);
  const profile_limits braking = drive_braking_within(&motion->bounds, &limits);
  if (setpoints_missing(motion, feedback, period_ticks)) {
    return motion_ordered_stop(motion, feedback, &braking, dt_s);
  }
  bool clamped;
  const float target_rad_s = motion_clamped_rate(
      drive_rate_from_velocity(drive_add(objects->velocity.target, objects->velocity.offset)), &limits, &clamped);
  rate_interpolation rates = motion->rates;
  if (feedback->setpoint_arrived) {
    rate_interpolation_aim(&rates, target_rad_s, period_ticks, dt_s);
  }
  interpolated_rate now = rate_interpolation_step(&rates, dt_s);
  const float wanted_rad_s = rates.rate_rad_s;
  rates.rate_rad_s =
      motion_stoppable_rate(motion, &braking, motion_start(motion, feedback->position), wanted_rad_s, dt_s);
  const bool braked = rates.rate_rad_s != wanted_rad_s;
  if (braked) {
    now.acceleration_rad_s2 = (rates.rate_rad_s - now.rate_rad_s) / dt_s;
  }
  const profile_ramp ahead = {.rate_rad_s = rates.rate_rad_s};
  if (motion_limit_blocks(motion, feedback, &braking, target_rad_s, &ahead, dt_s)) {
    return motion_stop(motion, feedback, &braking, dt_s);
  }
  motion_close_loop(motion, SERVO_SPEED, feedback);
  /* The ramp keeps the rate but not the acceleration: the client's may exceed what a jerk limit can bring back. */
  motion->rates = rates;
  motion->ramp = (profile_ramp){.rate_rad_s = now.rate_rad_s};
  drive_setpoint setpoint = motion_setpoint(motion, feedback);
  setpoint.command.speed.acceleration_rad_s2 = now.acceleration_rad_s2;
  motion->ramp.rate_rad_s = motion->rates.rate_rad_s; /* of the next tick, as in the other modes */
  setpoint.limited = clamped || braked;
  return setpoint;
}

static float along_slope(float from_nm, float to_nm, const drive_torque_objects *torque, float dt_s) {
  if (torque->slope_per_s == 0) {
    return to_nm;
  }
  const float step_nm = (float)torque->slope_per_s * dt_s * ((float)torque->rated_mnm / 1e6f);
  return scalar_clamp(to_nm, from_nm - step_nm, from_nm + step_nm);
}

drive_setpoint motion_cyclic_torque(drive_motion *motion, const drive_objects *objects, const drive_feedback *feedback,
                                    float dt_s) {
  const drive_torque_objects *torque = &objects->torque;
  const profile_limits limits = motion_velocity_limits(&motion->bounds, &objects->limit);
  const float target_nm = drive_torque_from_permille((int32_t)torque->target + torque->offset, torque->rated_mnm);
  profile_ramp ahead = motion->ramp;
  if (motion->loop == SERVO_TORQUE) { /* the rate gain of a tick is estimated from the last one */
    ahead.rate_rad_s = 2.0f * feedback->rate_rad_s - motion->ramp.rate_rad_s;
    motion->ramp = (profile_ramp){.rate_rad_s = feedback->rate_rad_s};
  }
  const profile_limits braking = drive_braking_within(&motion->bounds, &limits);
  if (setpoints_missing(motion, feedback, period_of(motion, &objects->limit, dt_s))) {
    return motion_ordered_stop(motion, feedback, &braking, dt_s);
  }
  if (motion_limit_blocks(motion, feedback, &braking, target_nm, &ahead, dt_s)) {
    return motion_stop(motion, feedback, &braking, dt_s);
  }
  motion_close_loop(motion, SERVO_TORQUE, feedback);
  motion->torque_nm = along_slope(motion->torque_nm, target_nm, torque, dt_s);
  motion->ramp = (profile_ramp){.rate_rad_s = feedback->rate_rad_s};
  drive_setpoint setpoint = motion_setpoint(motion, feedback);
  setpoint.command.torque_nm = motion_held_below_limit(motion->torque_nm, feedback->rate_rad_s, limits.rate_rad_s);
  setpoint.limited = setpoint.command.torque_nm != motion->torque_nm;
  return setpoint;
}
