#include "drive/drive_motion.h"

#include <limits.h>
#include <math.h>
#include <stddef.h>

#include "base/scalar.h"

/* Share of 607F that the position loop may use to correct an error, and at which a torque may drive the axis. */
#define BEYOND_LIMIT 1.1f

/* At this distance from the end of the travel a rate is held as a position. */
#define END_RAD 5e-5f

bool drive_mode_supported(int8_t mode) {
  return mode == DRIVE_TRACKING || mode == DRIVE_NO_MODE || mode == DRIVE_PROFILE_POSITION ||
         mode == DRIVE_PROFILE_VELOCITY || mode == DRIVE_HOMING ||
         (mode >= DRIVE_CYCLIC_POSITION && mode <= DRIVE_CYCLIC_TORQUE);
}

profile_limits drive_profile_limits(const drive_limit_objects *limit, float rate_rad_s, uint32_t deceleration) {
  return (profile_limits){
      .rate_rad_s = rate_rad_s,
      .acceleration_rad_s2 = drive_limit_from_counts(limit->acceleration),
      .deceleration_rad_s2 = drive_limit_from_counts(deceleration),
      .jerk_rad_s3 = drive_limit_from_counts(limit->jerk),
  };
}

/* The limits of pv, of the cyclic modes and of a slow-down. */
static profile_limits velocity_limits(const drive_bounds *bounds, const drive_limit_objects *limit) {
  return drive_profile_limits(limit, bounds->rate_rad_s, limit->deceleration);
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

/* Closes another loop without a step: the ramp begins at the speed loop's set-point of the last tick. */
static void close_loop(drive_motion *motion, servo_mode loop, const drive_feedback *feedback) {
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

static void move_demand(drive_angle *demand, float *rest, float travel_rad) {
  const float units = travel_rad / ANGLE_RAD_PER_TURN32 + *rest;
  const float whole = scalar_round(units);
  *demand += angle_integer(whole);
  *rest = units - whole;
}

/* The set-point of now, taken before the ramp makes its tick; its acceleration is known after the tick. */
static drive_setpoint setpoint_of(const drive_motion *motion, const drive_feedback *feedback) {
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

/* The state from which the next set-point continues. */
static drive_angle start_of(const drive_motion *motion, drive_angle position) {
  return motion->loop == SERVO_POSITION ? motion->demand : position;
}

/* Whether an axis commanded in this direction must stop now to come to rest within the travel: `ahead` is its ramp in
 * the next tick. Once stopping, it continues until the command reverses: a set-point held against the limit must not
 * make it creep. An axis that drifts out of the travel without a command is stopped as well. */
static bool limit_blocks(drive_motion *motion, const drive_feedback *feedback, const profile_limits *braking,
                         float demanded, const profile_ramp *ahead, float dt_s) {
  if (demanded * motion->blocked_direction < 0.0f) {
    motion->blocked_direction = 0.0f;
  }
  if (motion->blocked_direction == 0.0f && drive_travel_is_limited(&motion->bounds.travel)) {
    const drive_angle from = start_of(motion, feedback->position);
    const float side = drive_travel_side(&motion->bounds, from);
    const float direction = demanded < 0.0f ? -1.0f : demanded > 0.0f ? 1.0f : side;
    const float margin_rad = drive_travel_room_rad(&motion->bounds, from, direction) - ahead->rate_rad_s * dt_s -
                             profile_stop_travel_rad(ahead, braking);
    motion->blocked_direction = direction != 0.0f && margin_rad * direction <= 0.0f ? direction : 0.0f;
  }
  return motion->blocked_direction != 0.0f;
}

/* To standstill; the interpolations are ready to continue from there. A limit of the travel holds the position: a rate
 * of 0 refers to inertial space, so the axis would drift beyond the limit with the base. */
static drive_setpoint stop(drive_motion *motion, const drive_feedback *feedback, const profile_limits *limits,
                           float dt_s) {
  const drive_angle from = start_of(motion, feedback->position);
  profile_limits within = *limits;
  const bool limited = drive_stop_within(&motion->bounds, &within, &motion->ramp, from);
  const bool held = limited || motion->blocked_direction != 0.0f || motion->loop == SERVO_POSITION ||
                    drive_travel_side(&motion->bounds, from) != 0.0f;
  close_loop(motion, held || controls_position(motion->mode) ? SERVO_POSITION : SERVO_SPEED, feedback);
  drive_setpoint setpoint = setpoint_of(motion, feedback);
  const profile_motion step = profile_towards_rate(&motion->ramp, &within, 0.0f, dt_s);
  motion->travel_rad = step.travel_rad;
  move_demand(&motion->demand, &motion->demand_rest, step.travel_rad);
  rate_interpolation_reset(&motion->rates, motion->ramp.rate_rad_s);
  position_interpolation_reset(&motion->positions, motion->demand, motion->ramp.rate_rad_s);
  setpoint.command.speed.acceleration_rad_s2 = step.mean_acceleration_rad_s2;
  setpoint.limited = motion->blocked_direction != 0.0f;
  setpoint.followed = false;
  setpoint.stopped = profile_at_rest(&motion->ramp);
  return setpoint;
}

/* --- the modes --- */

static float clamped_rate(float wanted_rad_s, const profile_limits *limits, bool *limited) {
  const float rate_rad_s = scalar_clamp(wanted_rad_s, -limits->rate_rad_s, limits->rate_rad_s);
  *limited = rate_rad_s != wanted_rad_s;
  return rate_rad_s;
}

/* The limits of pp. */
static profile_limits position_limits(const drive_bounds *bounds, const drive_limit_objects *limit) {
  const float rate_rad_s = scalar_min(drive_limit_from_counts(limit->profile_velocity), bounds->position_rad_s);
  return drive_profile_limits(limit, rate_rad_s, limit->deceleration);
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
  move_demand(&step->demand, &step->demand_rest, made->travel_rad);
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
  return drive_travel_room_rad(&motion->bounds, start_of(motion, motion->position), direction) - moving_rad;
}

/* Of homing: 609A while the speed increases and decreases. */
static profile_limits homing_limits(const drive_bounds *bounds, const drive_objects *objects) {
  profile_limits limits = velocity_limits(bounds, &objects->limit);
  limits.acceleration_rad_s2 = drive_limit_from_counts(objects->homing.acceleration);
  limits.deceleration_rad_s2 = limits.acceleration_rad_s2;
  return limits;
}

/* Of pv and hm. */
static drive_profile_step prepare_velocity(const drive_motion *motion, const drive_objects *objects, float dt_s) {
  const drive_bounds *bounds = &motion->bounds;
  const bool homes = motion->mode == DRIVE_HOMING;
  const profile_limits limits = homes ? homing_limits(bounds, objects) : velocity_limits(bounds, &objects->limit);
  const profile_limits braking = drive_braking_within(bounds, &limits);
  drive_profile_step step = step_from_now(motion);
  bool clamped;
  const float target_rad_s = clamped_rate(
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

void drive_motion_prepare(drive_motion *motion, const drive_objects *objects, const drive_machine *machine,
                          float dt_s) {
  drive_bounds_update(&motion->bounds, objects, machine);
  motion->next.ready = false;
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

/* The set-point of now, then the prepared one. */
static drive_setpoint take_step(drive_motion *motion, const drive_feedback *feedback, float dt_s) {
  if (!motion->next.ready) {
    motion->next = carry_on(motion, dt_s);
  }
  const drive_profile_step *next = &motion->next;
  drive_setpoint setpoint = setpoint_of(motion, feedback);
  setpoint.command.speed.acceleration_rad_s2 = next->mean_acceleration_rad_s2;
  setpoint.limited = next->limited;
  motion->ramp = next->ramp;
  motion->travel_rad = next->travel_rad;
  motion->demand = next->demand;
  motion->demand_rest = next->demand_rest;
  return setpoint;
}

static drive_setpoint profile_position(drive_motion *motion, const drive_objects *objects,
                                       const drive_feedback *feedback, float dt_s) {
  if (!motion->setpoints.under_way) {
    const profile_limits limits = position_limits(&motion->bounds, &objects->limit);
    drive_setpoint stopping = stop(motion, feedback, &limits, dt_s);
    stopping.limited = motion->setpoints.target.limited;
    return stopping;
  }
  close_loop(motion, SERVO_POSITION, feedback);
  const drive_setpoint setpoint = take_step(motion, feedback, dt_s);
  if (motion->next.arrived && motion->next.target == motion->setpoints.target.angle) {
    (void)setpoint_queue_finish(&motion->setpoints);
  }
  return setpoint;
}

static drive_setpoint profile_velocity(drive_motion *motion, const drive_feedback *feedback, float dt_s) {
  const servo_mode before = motion->loop;
  close_loop(motion, motion->next.ready && motion->next.held ? SERVO_POSITION : SERVO_SPEED, feedback);
  if (motion->next.ready && motion->loop != before) { /* the demand is the present position of the axis */
    motion->next.demand = motion->demand;
    motion->next.demand_rest = 0.0f;
    move_demand(&motion->next.demand, &motion->next.demand_rest, motion->next.travel_rad);
  }
  return take_step(motion, feedback, dt_s);
}

/* Whether a cyclic mode has no set-point: none since it was entered, or none for too long. */
static bool setpoints_missing(drive_motion *motion, const drive_feedback *feedback, int period_ticks) {
  if (feedback->setpoint_arrived) {
    motion->setpoint_age_ticks = 0;
  } else if (motion->setpoint_age_ticks < INT_MAX) {
    ++motion->setpoint_age_ticks;
  }
  return interpolation_stale(motion->setpoint_age_ticks, period_ticks);
}

/* A stop that a fault, a command or missing set-points order: not more gentle than protection allows. An acceleration
 * of the ramp in the direction of the motion that its jerk cannot end soon is dropped. */
static drive_setpoint ordered_stop(drive_motion *motion, const drive_feedback *feedback, const profile_limits *wanted,
                                   float dt_s) {
  profile_limits limits = *wanted;
  drive_stop_at_least(&motion->bounds, &limits, &motion->ramp);
  motion->ordered = true;
  return stop(motion, feedback, &limits, dt_s);
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
    move_demand(&motion->demand, &motion->demand_rest, slow_rad_s * dt_s);
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
static drive_setpoint cyclic_position(drive_motion *motion, const drive_objects *objects,
                                      const drive_feedback *feedback, float dt_s) {
  const drive_limit_objects *limit = &objects->limit;
  const profile_limits limits = drive_profile_limits(limit, motion->bounds.position_rad_s, limit->deceleration);
  const int period_ticks = period_of(motion, limit, dt_s);
  if (setpoints_missing(motion, feedback, period_ticks)) {
    return ordered_stop(motion, feedback, &limits, dt_s);
  }
  close_loop(motion, SERVO_POSITION, feedback);
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
  drive_setpoint setpoint = setpoint_of(motion, feedback);
  const float wanted_rad_s = rate_rad_s + drive_rate_from_velocity(objects->velocity.offset);
  const float bounded_rad_s = scalar_clamp(wanted_rad_s, -limits.rate_rad_s, limits.rate_rad_s);
  setpoint.command.speed.rate_rad_s = drive_rate_within(&motion->bounds, &braking, motion->demand, bounded_rad_s, dt_s);
  setpoint.limited =
      cut || braked || target != objects->position.target || setpoint.command.speed.rate_rad_s != wanted_rad_s;
  return setpoint;
}

/* The rate in the direction of `wanted_rad_s`, at most as fast, from which the axis can still stop within the travel:
 * at 80 % of the deceleration, because the rate itself follows with a lag. */
static float stoppable_rate(const drive_motion *motion, const profile_limits *braking, drive_angle position,
                            float wanted_rad_s, float dt_s) {
  profile_limits gentle = *braking;
  gentle.deceleration_rad_s2 *= 0.8f;
  return drive_rate_within(&motion->bounds, &gentle, position, wanted_rad_s, dt_s);
}

static drive_setpoint cyclic_velocity(drive_motion *motion, const drive_objects *objects,
                                      const drive_feedback *feedback, float dt_s) {
  const profile_limits limits = velocity_limits(&motion->bounds, &objects->limit);
  const int period_ticks = period_of(motion, &objects->limit, dt_s);
  const profile_limits braking = drive_braking_within(&motion->bounds, &limits);
  if (setpoints_missing(motion, feedback, period_ticks)) {
    return ordered_stop(motion, feedback, &braking, dt_s);
  }
  bool clamped;
  const float target_rad_s = clamped_rate(
      drive_rate_from_velocity(drive_add(objects->velocity.target, objects->velocity.offset)), &limits, &clamped);
  rate_interpolation rates = motion->rates;
  if (feedback->setpoint_arrived) {
    rate_interpolation_aim(&rates, target_rad_s, period_ticks, dt_s);
  }
  interpolated_rate now = rate_interpolation_step(&rates, dt_s);
  const float wanted_rad_s = rates.rate_rad_s;
  rates.rate_rad_s = stoppable_rate(motion, &braking, start_of(motion, feedback->position), wanted_rad_s, dt_s);
  const bool braked = rates.rate_rad_s != wanted_rad_s;
  if (braked) {
    now.acceleration_rad_s2 = (rates.rate_rad_s - now.rate_rad_s) / dt_s;
  }
  const profile_ramp ahead = {.rate_rad_s = rates.rate_rad_s};
  if (limit_blocks(motion, feedback, &braking, target_rad_s, &ahead, dt_s)) {
    return stop(motion, feedback, &braking, dt_s);
  }
  close_loop(motion, SERVO_SPEED, feedback);
  /* The ramp keeps the rate but not the acceleration: the client's may exceed what a jerk limit can bring back. */
  motion->rates = rates;
  motion->ramp = (profile_ramp){.rate_rad_s = now.rate_rad_s};
  drive_setpoint setpoint = setpoint_of(motion, feedback);
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

/* A torque does not limit the speed: above 607F the accelerating torque is reduced, to zero at 110 %. */
static float held_below_limit(float torque_nm, float rate_rad_s, float limit_rad_s) {
  const float ahead_rad_s = torque_nm < 0.0f ? -rate_rad_s : rate_rad_s;
  const float share = (BEYOND_LIMIT * limit_rad_s - ahead_rad_s) / ((BEYOND_LIMIT - 1.0f) * limit_rad_s);
  return torque_nm * scalar_clamp(share, 0.0f, 1.0f);
}

static drive_setpoint cyclic_torque(drive_motion *motion, const drive_objects *objects, const drive_feedback *feedback,
                                    float dt_s) {
  const drive_torque_objects *torque = &objects->torque;
  const profile_limits limits = velocity_limits(&motion->bounds, &objects->limit);
  const float target_nm = drive_torque_from_permille((int32_t)torque->target + torque->offset, torque->rated_mnm);
  profile_ramp ahead = motion->ramp;
  if (motion->loop == SERVO_TORQUE) { /* the rate gain of a tick is estimated from the last one */
    ahead.rate_rad_s = 2.0f * feedback->rate_rad_s - motion->ramp.rate_rad_s;
    motion->ramp = (profile_ramp){.rate_rad_s = feedback->rate_rad_s};
  }
  const profile_limits braking = drive_braking_within(&motion->bounds, &limits);
  if (setpoints_missing(motion, feedback, period_of(motion, &objects->limit, dt_s))) {
    return ordered_stop(motion, feedback, &braking, dt_s);
  }
  if (limit_blocks(motion, feedback, &braking, target_nm, &ahead, dt_s)) {
    return stop(motion, feedback, &braking, dt_s);
  }
  close_loop(motion, SERVO_TORQUE, feedback);
  motion->torque_nm = along_slope(motion->torque_nm, target_nm, torque, dt_s);
  motion->ramp = (profile_ramp){.rate_rad_s = feedback->rate_rad_s};
  drive_setpoint setpoint = setpoint_of(motion, feedback);
  setpoint.command.torque_nm = held_below_limit(motion->torque_nm, feedback->rate_rad_s, limits.rate_rad_s);
  setpoint.limited = setpoint.command.torque_nm != motion->torque_nm;
  return setpoint;
}

/* --- tracking --- */

/* No faster towards the target than the axis can still stop within the travel, and no change of the rate above 6083:
 * the first frame of a target may ask for any rate. */
static drive_tracking_limits tracking_within(const drive_motion *motion, const profile_limits *limits,
                                             const profile_limits *braking, const drive_feedback *feedback,
                                             float dt_s) {
  const float towards_rad_s = feedback->target->reference.rate_rad_s < 0.0f ? -limits->rate_rad_s : limits->rate_rad_s;
  const float fastest_rad_s = stoppable_rate(motion, braking, feedback->position, towards_rad_s, dt_s);
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
  drive_setpoint setpoint = profile_position(motion, objects, feedback, dt_s);
  setpoint.followed = false;
  motion->tracked_rad_s2 = motion->ramp.acceleration_rad_s2;
  return setpoint;
}

/* Without a target the axis stops and stays where it looks, or returns; at the end of the travel it waits for the
 * target. */
static drive_setpoint track(drive_motion *motion, const drive_objects *objects, const drive_feedback *feedback,
                            float dt_s) {
  const profile_limits limits = velocity_limits(&motion->bounds, &objects->limit);
  const profile_limits braking = drive_braking_within(&motion->bounds, &limits);
  const servo_target *target = feedback->target;
  const bool known = target != NULL && target->known && isfinite(target->reference.rate_rad_s);
  if (known) {
    motion->setpoints.under_way = target->at_loss == TARGET_LOSS_RETURN;
  } else if (motion->setpoints.under_way && !motion->bounds.position_unknown) {
    return return_to_start(motion, objects, feedback, dt_s);
  }
  if (!known || is_held_at_end(motion, feedback)) {
    drive_setpoint stopping = stop(motion, feedback, &braking, dt_s);
    stopping.limited = stopping.limited || known;
    stopping.followed = known;
    motion->tracked_rad_s2 = motion->ramp.acceleration_rad_s2;
    return stopping;
  }
  close_loop(motion, SERVO_SPEED, feedback);
  motion->tracking = tracking_within(motion, &limits, &braking, feedback, dt_s);
  const speed_reference reference = tracked_reference(motion, &target->reference, dt_s);
  motion->followed = target;
  motion->tracked_rad_s2 = reference.acceleration_rad_s2;
  motion->ramp = (profile_ramp){.rate_rad_s = reference.rate_rad_s};
  drive_setpoint setpoint = setpoint_of(motion, feedback);
  setpoint.command.speed = reference;
  setpoint.command.torque_nm = target->torque_nm;
  setpoint.limited = reference.rate_rad_s != target->reference.rate_rad_s;
  return setpoint;
}

/* --- an experiment --- */

/* Its set-point within the position limits and below 607F; the ramp follows, so that a stop begins at the actual rate.
 * A set-point that would leave the limits is blocked, which ends the experiment. */
static drive_setpoint follow(drive_motion *motion, const drive_objects *objects, const drive_feedback *feedback,
                             float dt_s) {
  const servo_axis_command *stimulus = feedback->stimulus;
  const profile_limits limits = velocity_limits(&motion->bounds, &objects->limit);
  const bool torque = stimulus->mode == SERVO_TORQUE;
  const drive_angle wanted = drive_angle_unwrap(feedback->position, stimulus->position);
  const int32_t position = drive_position_from_angle(wanted);
  const bool beyond =
      stimulus->mode == SERVO_POSITION && drive_travel_clamp(&motion->bounds.travel, position) != position;
  const profile_limits braking = drive_braking_within(&motion->bounds, &limits);
  const profile_ramp ahead = {.rate_rad_s = torque ? feedback->rate_rad_s : stimulus->speed.rate_rad_s};
  const float demanded = torque ? stimulus->torque_nm : stimulus->speed.rate_rad_s;
  if (beyond || limit_blocks(motion, feedback, &braking, demanded, &ahead, dt_s)) {
    motion->blocked_direction = beyond && motion->blocked_direction == 0.0f ? 1.0f : motion->blocked_direction;
    return stop(motion, feedback, &braking, dt_s);
  }
  close_loop(motion, stimulus->mode, feedback);
  motion->ramp = (profile_ramp){.rate_rad_s = torque ? feedback->rate_rad_s : stimulus->speed.rate_rad_s};
  motion->demand = wanted;
  motion->demand_rest = 0.0f;
  drive_setpoint setpoint = {.command = *stimulus, .followed = true};
  setpoint.position = stimulus->mode == SERVO_POSITION ? wanted : feedback->position;
  setpoint.command.speed.rate_rad_s = scalar_clamp(stimulus->speed.rate_rad_s, -limits.rate_rad_s, limits.rate_rad_s);
  setpoint.command.torque_nm =
      torque ? held_below_limit(stimulus->torque_nm, feedback->rate_rad_s, limits.rate_rad_s) : stimulus->torque_nm;
  return setpoint;
}

/* --- the tick --- */

static drive_setpoint run(drive_motion *motion, const drive_objects *objects, const drive_feedback *feedback,
                          float dt_s) {
  if (motion->bounds.position_unknown && controls_position(motion->mode)) { /* no target has a meaning */
    const profile_limits limits = velocity_limits(&motion->bounds, &objects->limit);
    drive_setpoint waiting = stop(motion, feedback, &limits, dt_s);
    waiting.limited = true;
    return waiting;
  }
  switch (motion->mode) {
    case DRIVE_PROFILE_POSITION:
      return profile_position(motion, objects, feedback, dt_s);
    case DRIVE_PROFILE_VELOCITY:
    case DRIVE_HOMING:
      return profile_velocity(motion, feedback, dt_s);
    case DRIVE_CYCLIC_POSITION:
      return cyclic_position(motion, objects, feedback, dt_s);
    case DRIVE_CYCLIC_VELOCITY:
      return cyclic_velocity(motion, objects, feedback, dt_s);
    case DRIVE_CYCLIC_TORQUE:
      return cyclic_torque(motion, objects, feedback, dt_s);
    case DRIVE_TRACKING:
      return track(motion, objects, feedback, dt_s);
    case DRIVE_NO_MODE:
    default: {
      if (feedback->stimulus != NULL) {
        return follow(motion, objects, feedback, dt_s);
      }
      motion->blocked_direction = 0.0f;
      const profile_limits limits = velocity_limits(&motion->bounds, &objects->limit);
      return stop(motion, feedback, &limits, dt_s);
    }
  }
}

/* 6072, 60E0 and 60E1, narrowed further by limits in the command; in csp and csv the torque offset 60B2. */
static void add_torque(const drive_motion *motion, const drive_torque_objects *torque, servo_axis_command *command) {
  const uint16_t up = torque->maximum < torque->positive_limit ? torque->maximum : torque->positive_limit;
  const uint16_t down = torque->maximum < torque->negative_limit ? torque->maximum : torque->negative_limit;
  const float up_nm = drive_torque_from_permille(up, torque->rated_mnm);
  const float down_nm = drive_torque_from_permille(down, torque->rated_mnm);
  const torque_limits own = command->torque_limited ? command->limits : (torque_limits){-down_nm, up_nm};
  command->torque_limited = true;
  command->limits = (torque_limits){scalar_max(own.minimum_nm, -down_nm), scalar_min(own.maximum_nm, up_nm)};
  if (motion->mode == DRIVE_CYCLIC_POSITION || motion->mode == DRIVE_CYCLIC_VELOCITY) {
    command->torque_nm = drive_torque_from_permille(torque->offset, torque->rated_mnm);
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
                          .demand = start_of(motion, feedback->position),
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
    close_loop(motion, controls_position(mode) ? SERVO_POSITION : SERVO_SPEED, feedback);
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
    const profile_limits limits = drive_profile_limits(limit, motion->bounds.rate_rad_s, deceleration);
    setpoint = ordered_stop(motion, feedback, &limits, dt_s);
  }
  motion->next.ready = false;
  add_torque(motion, &objects->torque, &setpoint.command);
  setpoint.command.rate_limit_rad_s = BEYOND_LIMIT * motion->bounds.rate_rad_s;
  keep_plausible(&setpoint.command);
  return setpoint;
}
