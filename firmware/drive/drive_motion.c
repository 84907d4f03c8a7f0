#include "drive/drive_motion.h"

#include <limits.h>
#include <math.h>
#include <stddef.h>

#include "control/scalar.h"

/* Of 607F: so fast the position loop may go to make good an error, and a torque may drive the axis. */
#define BEYOND_LIMIT 1.1f

bool drive_mode_supported(int8_t mode) {
  return mode == DRIVE_NO_MODE || mode == DRIVE_PROFILE_POSITION || mode == DRIVE_PROFILE_VELOCITY ||
         (mode >= DRIVE_CYCLIC_POSITION && mode <= DRIVE_CYCLIC_TORQUE);
}

profile_limits drive_profile_limits(const drive_limit_objects *limit, uint32_t velocity, uint32_t deceleration) {
  return (profile_limits){
      .rate_rad_s = drive_limit_from_counts(velocity),
      .acceleration_rad_s2 = drive_limit_from_counts(limit->acceleration),
      .deceleration_rad_s2 = drive_limit_from_counts(deceleration),
      .jerk_rad_s3 = drive_limit_from_counts(limit->jerk),
  };
}

/* The limits of pv, of the cyclic modes and of a slow-down. */
static profile_limits velocity_limits(const drive_limit_objects *limit) {
  return drive_profile_limits(limit, limit->maximum_velocity, limit->deceleration);
}

void drive_motion_reset(drive_motion *motion, drive_angle position) {
  const int8_t mode = motion->mode;
  *motion = (drive_motion){.mode = mode, .demand = position, .setpoint_age_ticks = INT_MAX};
}

/* --- handing over --- */

/* Closes another loop without a step: what was asked of the speed loop in the last tick is where the ramp begins. */
static void close_loop(drive_motion *motion, servo_mode loop, const drive_feedback *feedback) {
  const servo_mode before = motion->loop;
  if (loop == before) {
    return;
  }
  if (before == SERVO_OFF || before == SERVO_TORQUE) {
    motion->ramp = (profile_ramp){.rate_rad_s = feedback->rate_rad_s};
  } else if (before == SERVO_POSITION && loop == SERVO_SPEED) {
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

static void enter_mode(drive_motion *motion, int8_t mode, const drive_feedback *feedback) {
  motion->mode = mode;
  motion->next.ready = false;
  motion->blocked_direction = 0.0f;
  motion->setpoint_age_ticks = INT_MAX;
  const drive_angle from = motion->loop == SERVO_POSITION ? motion->demand : feedback->position;
  setpoint_queue_reset(&motion->setpoints, drive_position_from_angle(from));
  rate_interpolation_reset(&motion->rates, motion->ramp.rate_rad_s);
  position_interpolation_reset(&motion->positions, from, motion->ramp.rate_rad_s);
}

/* --- a tick of the ramp --- */

static void move_demand(drive_angle *demand, float *rest, float travel_rad) {
  const float units = travel_rad / ANGLE_RAD_PER_TURN32 + *rest;
  const float whole = scalar_round(units);
  *demand += angle_integer(whole);
  *rest = units - whole;
}

/* The set-point of now, to be taken before the ramp makes its tick; what accelerates is known after it. */
static drive_setpoint setpoint_of(const drive_motion *motion, const drive_feedback *feedback) {
  const bool controlled = motion->loop == SERVO_POSITION;
  /* Every field is named: to clear all of it first would be a call. */
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

/* To standstill; the interpolations stand by to go on from there. */
static drive_setpoint stop(drive_motion *motion, const drive_feedback *feedback, const profile_limits *limits,
                           float dt_s) {
  close_loop(motion, controls_position(motion->mode) ? SERVO_POSITION : SERVO_SPEED, feedback);
  drive_setpoint setpoint = setpoint_of(motion, feedback);
  const profile_motion step = profile_towards_rate(&motion->ramp, limits, 0.0f, dt_s);
  motion->travel_rad = step.travel_rad;
  move_demand(&motion->demand, &motion->demand_rest, step.travel_rad);
  rate_interpolation_reset(&motion->rates, motion->ramp.rate_rad_s);
  position_interpolation_reset(&motion->positions, motion->demand, motion->ramp.rate_rad_s);
  setpoint.command.speed.acceleration_rad_s2 = step.mean_acceleration_rad_s2;
  setpoint.followed = false;
  setpoint.stopped = profile_at_rest(&motion->ramp);
  return setpoint;
}

/* --- position limits (607D) --- */

static bool is_limited(const drive_travel *travel) { return travel->minimum < travel->maximum; }

static int32_t clamped_position(const drive_travel *travel, int32_t position) {
  if (!is_limited(travel)) {
    return position;
  }
  if (position < travel->minimum) {
    return travel->minimum;
  }
  return position > travel->maximum ? travel->maximum : position;
}

/* 607D within the hard travel; the hard travel alone where the two have nothing in common. */
static drive_travel travel_in_force(const drive_limit_objects *limit, const drive_travel *hard) {
  const drive_travel soft = {limit->position_minimum, limit->position_maximum};
  const drive_travel both = {clamped_position(hard, soft.minimum), clamped_position(hard, soft.maximum)};
  return is_limited(&soft) && is_limited(&both) ? both : *hard;
}

/* Way from a position to the limit that lies in this direction, signed. */
static float room_rad(const drive_travel *travel, drive_angle position, float direction) {
  const int32_t end = direction < 0.0f ? travel->minimum : travel->maximum;
  return drive_angle_difference_rad(drive_angle_from_position(end), position);
}

/* Whether an axis that is asked to go in the direction of `asked` must stop now to come to rest before the limit.
 * Once it must, it does until it is asked to go the other way: a set-point held against the limit shall not make it
 * creep. */
static bool limit_blocks(drive_motion *motion, const drive_feedback *feedback, const profile_limits *limits,
                         float asked) {
  if (asked * motion->blocked_direction <= 0.0f) {
    motion->blocked_direction = 0.0f;
  }
  if (motion->blocked_direction == 0.0f && asked != 0.0f && is_limited(&motion->travel)) {
    const float direction = asked < 0.0f ? -1.0f : 1.0f;
    const float margin_rad =
        room_rad(&motion->travel, feedback->position, direction) - profile_stop_travel_rad(&motion->ramp, limits);
    motion->blocked_direction = margin_rad * direction <= 0.0f ? direction : 0.0f;
  }
  return motion->blocked_direction != 0.0f;
}

/* --- the modes --- */

static float clamped_rate(int32_t velocity, const profile_limits *limits, bool *limited) {
  const float wanted_rad_s = drive_rate_from_velocity(velocity);
  const float rate_rad_s = scalar_clamp(wanted_rad_s, -limits->rate_rad_s, limits->rate_rad_s);
  *limited = rate_rad_s != wanted_rad_s;
  return rate_rad_s;
}

/* The limits of pp. */
static profile_limits position_limits(const drive_limit_objects *limit) {
  const uint32_t velocity =
      limit->profile_velocity < limit->maximum_velocity ? limit->profile_velocity : limit->maximum_velocity;
  return drive_profile_limits(limit, velocity, limit->deceleration);
}

static drive_profile_step step_from_now(const drive_motion *motion) {
  return (drive_profile_step){.ready = true,
                              .ramp = motion->ramp,
                              .demand = motion->demand,
                              .demand_rest = motion->demand_rest,
                              .target = motion->setpoints.target};
}

static void finish_step(drive_profile_step *step, const profile_motion *made) {
  move_demand(&step->demand, &step->demand_rest, made->travel_rad);
  step->travel_rad = made->travel_rad;
  step->mean_acceleration_rad_s2 = made->mean_acceleration_rad_s2;
}

static drive_profile_step prepare_position(const drive_motion *motion, const drive_objects *objects, float dt_s) {
  const profile_limits limits = position_limits(&objects->limit);
  drive_profile_step step = step_from_now(motion);
  const int32_t target = clamped_position(&motion->travel, step.target);
  const drive_angle end = drive_angle_from_position(target);
  const float distance_rad =
      drive_angle_difference_rad(end, motion->demand) - motion->demand_rest * ANGLE_RAD_PER_TURN32;
  const profile_motion made = profile_towards_distance(&step.ramp, &limits, distance_rad, dt_s);
  finish_step(&step, &made);
  step.limited = target != step.target;
  step.arrived = made.arrived;
  if (made.arrived) {
    step.demand = end;
    step.demand_rest = 0.0f;
  }
  return step;
}

/* The room that there will be in the coming tick: the axis goes as its ramp until then. */
static drive_profile_step prepare_velocity(const drive_motion *motion, const drive_objects *objects, float dt_s) {
  const profile_limits limits = velocity_limits(&objects->limit);
  drive_profile_step step = step_from_now(motion);
  bool clamped;
  const float target_rad_s = clamped_rate(objects->velocity.target, &limits, &clamped);
  const profile_motion made =
      is_limited(&motion->travel) && target_rad_s != 0.0f
          ? profile_towards_rate_within(&step.ramp, &limits, target_rad_s,
                                        room_rad(&motion->travel, motion->position, target_rad_s) - motion->travel_rad,
                                        dt_s)
          : profile_towards_rate(&step.ramp, &limits, target_rad_s, dt_s);
  finish_step(&step, &made);
  step.limited = clamped || (profile_at_rest(&step.ramp) && target_rad_s != 0.0f);
  return step;
}

void drive_motion_prepare(drive_motion *motion, const drive_objects *objects, float dt_s) {
  motion->next.ready = false;
  if (motion->mode == DRIVE_PROFILE_POSITION && motion->loop == SERVO_POSITION && motion->setpoints.under_way) {
    motion->next = prepare_position(motion, objects, dt_s);
  } else if (motion->mode == DRIVE_PROFILE_VELOCITY && motion->loop == SERVO_SPEED) {
    motion->next = prepare_velocity(motion, objects, dt_s);
  }
}

/* As long as nothing is prepared: no jerk. */
static drive_profile_step carry_on(const drive_motion *motion, float dt_s) {
  drive_profile_step step = step_from_now(motion);
  const float gain_rad_s = motion->ramp.acceleration_rad_s2 * dt_s;
  const profile_motion made = {.travel_rad = (motion->ramp.rate_rad_s + 0.5f * gain_rad_s) * dt_s,
                               .mean_acceleration_rad_s2 = motion->ramp.acceleration_rad_s2};
  step.ramp.rate_rad_s += gain_rad_s;
  finish_step(&step, &made);
  return step;
}

/* The set-point of now, then what was prepared. */
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
    const profile_limits limits = position_limits(&objects->limit);
    return stop(motion, feedback, &limits, dt_s);
  }
  close_loop(motion, SERVO_POSITION, feedback);
  const drive_setpoint setpoint = take_step(motion, feedback, dt_s);
  if (motion->next.arrived && motion->next.target == motion->setpoints.target) {
    (void)setpoint_queue_finish(&motion->setpoints);
  }
  return setpoint;
}

static drive_setpoint profile_velocity(drive_motion *motion, const drive_feedback *feedback, float dt_s) {
  close_loop(motion, SERVO_SPEED, feedback);
  return take_step(motion, feedback, dt_s);
}

/* Whether a cyclic mode has nothing to follow: no set-point since it was entered, or none any more. */
static bool setpoints_missing(drive_motion *motion, const drive_feedback *feedback, int period_ticks) {
  if (feedback->setpoint_arrived) {
    motion->setpoint_age_ticks = 0;
  } else if (motion->setpoint_age_ticks < INT_MAX) {
    ++motion->setpoint_age_ticks;
  }
  return interpolation_stale(motion->setpoint_age_ticks, period_ticks);
}

/* Divided out again only when 60C2 has changed. */
static int period_of(drive_motion *motion, const drive_limit_objects *limit, float dt_s) {
  setpoint_period *known = &motion->period;
  const bool same = known->mantissa == limit->interpolation_period && known->exponent == limit->interpolation_exponent;
  if (known->ticks == 0 || !same) {
    const int ticks = interpolation_ticks(limit->interpolation_period, limit->interpolation_exponent, dt_s);
    *known = (setpoint_period){limit->interpolation_period, limit->interpolation_exponent, ticks > 0 ? ticks : 1};
  }
  return known->ticks;
}

/* A set-point of position leads an acceleration only as far as its own digits: 1e-7 rad within a period of 1 ms is
 * 0.1 rad/s^2. So csp gives position and rate; who knows the acceleration sends it as a torque (60B2). */
static drive_setpoint cyclic_position(drive_motion *motion, const drive_objects *objects,
                                      const drive_feedback *feedback, float dt_s) {
  const drive_limit_objects *limit = &objects->limit;
  const profile_limits limits = velocity_limits(limit);
  const int period_ticks = period_of(motion, limit, dt_s);
  if (setpoints_missing(motion, feedback, period_ticks)) {
    return stop(motion, feedback, &limits, dt_s);
  }
  close_loop(motion, SERVO_POSITION, feedback);
  const int32_t target = clamped_position(&motion->travel, objects->position.target);
  bool cut = false;
  if (feedback->setpoint_arrived) {
    cut = position_interpolation_aim(&motion->positions, drive_angle_from_position(target), period_ticks,
                                     limits.rate_rad_s, dt_s);
  }
  const interpolated_position now = position_interpolation_step(&motion->positions, dt_s);
  motion->demand = now.position;
  motion->demand_rest = 0.0f;
  motion->ramp = (profile_ramp){.rate_rad_s = now.rate_rad_s};
  drive_setpoint setpoint = setpoint_of(motion, feedback);
  const float wanted_rad_s = now.rate_rad_s + drive_rate_from_velocity(objects->velocity.offset);
  setpoint.command.speed.rate_rad_s = scalar_clamp(wanted_rad_s, -limits.rate_rad_s, limits.rate_rad_s);
  setpoint.limited = cut || target != objects->position.target || setpoint.command.speed.rate_rad_s != wanted_rad_s;
  return setpoint;
}

static drive_setpoint cyclic_velocity(drive_motion *motion, const drive_objects *objects,
                                      const drive_feedback *feedback, float dt_s) {
  const profile_limits limits = velocity_limits(&objects->limit);
  const int period_ticks = period_of(motion, &objects->limit, dt_s);
  bool clamped;
  const float target_rad_s =
      clamped_rate(drive_add(objects->velocity.target, objects->velocity.offset), &limits, &clamped);
  const bool missing = setpoints_missing(motion, feedback, period_ticks);
  if (missing || limit_blocks(motion, feedback, &limits, target_rad_s)) {
    drive_setpoint stopping = stop(motion, feedback, &limits, dt_s);
    stopping.limited = !missing;
    return stopping;
  }
  close_loop(motion, SERVO_SPEED, feedback);
  if (feedback->setpoint_arrived) {
    rate_interpolation_aim(&motion->rates, target_rad_s, period_ticks, dt_s);
  }
  /* The ramp keeps the rate but not the acceleration: the client's may be beyond what a jerk limit can bring back. */
  const interpolated_rate now = rate_interpolation_step(&motion->rates, dt_s);
  motion->ramp = (profile_ramp){.rate_rad_s = now.rate_rad_s};
  drive_setpoint setpoint = setpoint_of(motion, feedback);
  setpoint.command.speed.acceleration_rad_s2 = now.acceleration_rad_s2;
  motion->ramp.rate_rad_s = motion->rates.rate_rad_s; /* of the next tick, as in the other modes */
  setpoint.limited = clamped;
  return setpoint;
}

static float along_slope(float from_nm, float to_nm, const drive_torque_objects *torque, float dt_s) {
  if (torque->slope_per_s == 0) {
    return to_nm;
  }
  const float step_nm = (float)torque->slope_per_s * dt_s * ((float)torque->rated_mnm / 1e6f);
  return scalar_clamp(to_nm, from_nm - step_nm, from_nm + step_nm);
}

/* A torque is no speed: beyond 607F what would drive the axis on is taken back, all of it at 110 %. */
static float held_below_limit(float torque_nm, float rate_rad_s, float limit_rad_s) {
  const float ahead_rad_s = torque_nm < 0.0f ? -rate_rad_s : rate_rad_s;
  const float share = (BEYOND_LIMIT * limit_rad_s - ahead_rad_s) / ((BEYOND_LIMIT - 1.0f) * limit_rad_s);
  return torque_nm * scalar_clamp(share, 0.0f, 1.0f);
}

static drive_setpoint cyclic_torque(drive_motion *motion, const drive_objects *objects, const drive_feedback *feedback,
                                    float dt_s) {
  const drive_torque_objects *torque = &objects->torque;
  const profile_limits limits = velocity_limits(&objects->limit);
  const float target_nm = drive_torque_from_permille((int32_t)torque->target + torque->offset, torque->rated_mnm);
  if (motion->loop == SERVO_TORQUE) {
    motion->ramp = (profile_ramp){.rate_rad_s = feedback->rate_rad_s};
  }
  const bool missing = setpoints_missing(motion, feedback, period_of(motion, &objects->limit, dt_s));
  if (missing || limit_blocks(motion, feedback, &limits, target_nm)) {
    drive_setpoint stopping = stop(motion, feedback, &limits, dt_s);
    stopping.limited = !missing;
    return stopping;
  }
  close_loop(motion, SERVO_TORQUE, feedback);
  motion->torque_nm = along_slope(motion->torque_nm, target_nm, torque, dt_s);
  motion->ramp = (profile_ramp){.rate_rad_s = feedback->rate_rad_s};
  drive_setpoint setpoint = setpoint_of(motion, feedback);
  setpoint.command.torque_nm = held_below_limit(motion->torque_nm, feedback->rate_rad_s, limits.rate_rad_s);
  setpoint.limited = setpoint.command.torque_nm != motion->torque_nm;
  return setpoint;
}

/* --- an experiment --- */

/* Its set-point within the position limits and below 607F; the ramp goes along, so that a stop begins where it is. One
 * that would leave the limits is blocked, which ends the experiment. */
static drive_setpoint follow(drive_motion *motion, const drive_objects *objects, const drive_feedback *feedback,
                             float dt_s) {
  const servo_axis_command *stimulus = feedback->stimulus;
  const profile_limits limits = velocity_limits(&objects->limit);
  const bool torque = stimulus->mode == SERVO_TORQUE;
  const drive_angle wanted = drive_angle_unwrap(feedback->position, stimulus->position);
  const int32_t position = drive_position_from_angle(wanted);
  const bool beyond = stimulus->mode == SERVO_POSITION && clamped_position(&motion->travel, position) != position;
  if (beyond || limit_blocks(motion, feedback, &limits, torque ? stimulus->torque_nm : stimulus->speed.rate_rad_s)) {
    motion->blocked_direction = beyond && motion->blocked_direction == 0.0f ? 1.0f : motion->blocked_direction;
    return stop(motion, feedback, &limits, dt_s);
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
  switch (motion->mode) {
    case DRIVE_PROFILE_POSITION:
      return profile_position(motion, objects, feedback, dt_s);
    case DRIVE_PROFILE_VELOCITY:
      return profile_velocity(motion, feedback, dt_s);
    case DRIVE_CYCLIC_POSITION:
      return cyclic_position(motion, objects, feedback, dt_s);
    case DRIVE_CYCLIC_VELOCITY:
      return cyclic_velocity(motion, objects, feedback, dt_s);
    case DRIVE_CYCLIC_TORQUE:
      return cyclic_torque(motion, objects, feedback, dt_s);
    case DRIVE_NO_MODE:
    default: {
      if (feedback->stimulus != NULL) {
        return follow(motion, objects, feedback, dt_s);
      }
      motion->blocked_direction = 0.0f;
      const profile_limits limits = velocity_limits(&objects->limit);
      return stop(motion, feedback, &limits, dt_s);
    }
  }
}

/* 6072, 60E0 and 60E1, narrowed further where the command brings limits; in csp and csv the torque offset 60B2. */
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

drive_setpoint drive_motion_step(drive_motion *motion, const drive_objects *objects, drive_action action,
                                 const drive_feedback *feedback, float dt_s) {
  const int8_t mode = drive_mode_supported(objects->state.mode) ? objects->state.mode : motion->mode;
  if (action == DRIVE_OFF || action == DRIVE_BRAKE) {
    drive_motion_reset(motion, feedback->position);
    motion->mode = mode;
    return (drive_setpoint){.command = {.mode = action == DRIVE_BRAKE ? SERVO_BRAKE : SERVO_OFF},
                            .position = feedback->position};
  }
  motion->travel = travel_in_force(&objects->limit, &feedback->hard_travel);
  motion->position = feedback->position;
  if (motion->loop == SERVO_OFF) {
    close_loop(motion, controls_position(mode) ? SERVO_POSITION : SERVO_SPEED, feedback);
    enter_mode(motion, mode, feedback);
  } else if (mode != motion->mode) {
    enter_mode(motion, mode, feedback);
  }
  if (mode == DRIVE_PROFILE_POSITION) {
    (void)setpoint_queue_step(&motion->setpoints, objects->state.controlword, objects->position.target);
  }
  drive_setpoint setpoint;
  if (action == DRIVE_RUN) {
    setpoint = run(motion, objects, feedback, dt_s);
  } else {
    const drive_limit_objects *limit = &objects->limit;
    const uint32_t deceleration = action == DRIVE_QUICK_STOP ? limit->quick_stop_deceleration : limit->deceleration;
    const profile_limits limits = drive_profile_limits(limit, limit->maximum_velocity, deceleration);
    setpoint = stop(motion, feedback, &limits, dt_s);
  }
  motion->next.ready = false;
  add_torque(motion, &objects->torque, &setpoint.command);
  setpoint.command.rate_limit_rad_s = BEYOND_LIMIT * drive_limit_from_counts(objects->limit.maximum_velocity);
  return setpoint;
}
