/* SPDX-License-Identifier: Apache-2.0 */
#include "drive/drive_axis.h"

#include <math.h>
#include <stddef.h>

#include "base/scalar.h"

/* 2^30 units: beyond half a turn the position loop would turn in the other direction. */
#define QUARTER_TURN (INT64_C(1) << 30)

bool drive_axis_obeys_stimulus(const drive_axis *axis) {
  return axis->state.action == DRIVE_RUN && axis->brake.opened && axis->motion.mode == DRIVE_NO_MODE &&
         axis->motion.blocked_direction == 0.0f;
}

bool drive_axis_turns(const drive_axis *axis, const drive_axis_inputs *inputs) {
  return axis->state.action == DRIVE_RUN && (inputs->stimulus != NULL || !profile_at_rest(&axis->motion.ramp));
}

void drive_axis_reset(drive_axis *axis, angle_turn32 joint_angle) {
  axis->position = 0;
  axis->trusted_position = 0;
  drive_axis_restart(axis, joint_angle);
}

void drive_axis_restart(drive_axis *axis, angle_turn32 joint_angle) {
  *axis = (drive_axis){.position = drive_angle_unwrap(axis->position, joint_angle),
                       .trusted_position = axis->trusted_position};
  drive_state_reset(&axis->state);
  drive_motion_reset(&axis->motion, axis->position);
}

void drive_axis_shift(drive_axis *axis, int turns) {
  const drive_angle by = (drive_angle)turns * (INT64_C(1) << 32);
  axis->position += by;
  axis->trusted_position += by;
  axis->setpoint.position += by;
  drive_motion_shift(&axis->motion, by);
}

void drive_axis_sense(drive_axis_inputs *inputs, const servo_axis *servo, const servo_axis_params *params,
                      const servo_axis_samples *samples) {
  inputs->joint_angle = samples->sensors.joint_angle_turn32;
  inputs->rate_rad_s = servo->signals.rates.rate_rad_s;
  inputs->reference_rad_s = servo->signals.reference.rate_rad_s;
  inputs->torque_nm = params->torque_constant_nm_a * samples->sensors.mean_current_a;
  inputs->torque_demand_nm = servo->commanded_nm;
  inputs->torque_limited = servo->signals.torque.limited;
  inputs->implausible = servo->implausible;
}

static bool inputs_are_finite(const drive_axis_inputs *inputs) {
  return isfinite(inputs->rate_rad_s) && isfinite(inputs->reference_rad_s) && isfinite(inputs->torque_nm) &&
         isfinite(inputs->torque_demand_nm);
}

static drive_feedback feedback_of(const drive_axis *axis, const drive_axis_inputs *inputs, bool finite) {
  return (drive_feedback){
      .position = axis->position,
      .rate_rad_s = finite ? inputs->rate_rad_s : 0.0f,
      .reference_rad_s = finite ? inputs->reference_rad_s : 0.0f,
      .torque_demand_nm = finite ? inputs->torque_demand_nm : 0.0f,
      .setpoint_arrived = inputs->setpoint_arrived,
      .target = inputs->target,
      .stimulus = inputs->stimulus,
      .protective_nm = inputs->protective_nm,
  };
}

static void write_actual_values(const drive_axis *axis, drive_objects *objects, const drive_axis_inputs *inputs) {
  objects->position.actual = drive_travel_position(&axis->motion.bounds.travel, axis->position);
  objects->velocity.actual = drive_velocity_from_rate(inputs->rate_rad_s);
  objects->torque.actual = drive_permille_from_torque(inputs->torque_nm, objects->torque.rated_mnm);
  objects->torque.demand = drive_permille_from_torque(inputs->torque_demand_nm, objects->torque.rated_mnm);
}

_Static_assert((int)DRIVE_NO_FAULT == (int)REACTION_REPORT && (int)DRIVE_FAULT_STOPS == (int)REACTION_STOP &&
                   (int)DRIVE_FAULT_PROTECTS == (int)REACTION_PROTECT &&
                   (int)DRIVE_FAULT_BRAKES == (int)REACTION_BRAKE && (int)DRIVE_FAULT_CUTS == (int)REACTION_CUT,
               "the table's reactions are the drive's");

/* All active faults: from the caller or from the drive itself. The shorted motor brakes without any sample, so the
 * missing angle that caused the braking must not end it. */
static fault_set faults_of(const drive_axis *axis, const drive_axis_inputs *inputs, bool finite) {
  const bool unusable = (inputs->implausible || !finite) && axis->state.action != DRIVE_BRAKE;
  return inputs->faults | (unusable ? fault_bit(FAULT_IMPLAUSIBLE) : 0) |
         (axis->following_failed ? fault_bit(FAULT_FOLLOWING_ERROR) : 0) |
         (axis->brake.failed ? fault_bit(FAULT_HOLDING_BRAKE) : 0);
}

static uint32_t distance_between(int32_t a, int32_t b) {
  const int64_t difference = (int64_t)a - b;
  return (uint32_t)(difference < 0 ? -difference : difference);
}

static bool stop_is_over(drive_axis *axis, const drive_objects *objects, float rate_rad_s, float dt_s) {
  const uint16_t longest_wait_ms = 200;
  const bool stopping = axis->state.action == DRIVE_SLOW_DOWN || axis->state.action == DRIVE_QUICK_STOP;
  const bool ended = stopping && profile_at_rest(&axis->motion.ramp);
  const bool waited = dwell_timer_step(&axis->ramp_ended, ended, longest_wait_ms, dt_s);
  return ended && (waited || scalar_abs(rate_rad_s) <= drive_limit_from_counts(objects->velocity.threshold));
}

static drive_action step_state(drive_axis *axis, const drive_objects *objects, const drive_axis_inputs *inputs,
                               bool finite, float dt_s) {
  const drive_power_state before = axis->state.power;
  axis->faults = faults_of(axis, inputs, finite);
  axis->controlword = objects->state.controlword;
  const fault_id found = fault_worst(axis->faults);
  const bool protects = axis->state.action == DRIVE_PROTECTIVE_STOP;
  const bool over = protects ? inputs->at_rest : stop_is_over(axis, objects, inputs->rate_rad_s, dt_s);
  const bool waits = axis->state.ends_off && inputs->brake.engage_s > 0.0f; /* for the brake, with torque */
  const drive_state_inputs in = {
      .controlword = axis->controlword,
      .fault = (drive_fault)fault_table[found].reaction,
      .ready = inputs->ready,
      .voltage_present = inputs->voltage_present,
      .stopped = waits ? holding_brake_has_engaged(&axis->brake, &inputs->brake) && (over || !protects) : over,
      .may_enable = inputs->may_enable,
      .turns = inputs->turns,
  };
  const drive_action action = drive_state_step(&axis->state, &objects->state.option, &in);
  /* A protective stop of an axis that coasts leaves its brake engaged. */
  const bool torque_stands =
      action != DRIVE_OFF && action != DRIVE_BRAKE && (action != DRIVE_PROTECTIVE_STOP || axis->brake.coil_on);
  const bool engages = waits && axis->state.ends_off && (over || !axis->brake.coil_on); /* once, without chatter */
  holding_brake_step(&axis->brake, &inputs->brake, torque_stands && !engages, inputs->brake_contact_open, dt_s);
  if (axis->state.power == DRIVE_FAULT_REACTION_ACTIVE && before != DRIVE_FAULT_REACTION_ACTIVE &&
      before != DRIVE_FAULT) {
    axis->fault = found;
  } else if (before == DRIVE_FAULT && axis->state.power != DRIVE_FAULT) {
    axis->fault = FAULT_NONE;
  }
  return action;
}

/* Of 6067, and of 6065 likewise: UINT32_MAX contains everything. */
static bool is_within(uint32_t window, int32_t error) { return distance_between(error, 0) <= window; }

/* 60F4 and its window: the status bit (window left for longer than 6066) and the fault. */
static bool monitor_following(drive_axis *axis, drive_objects *objects, const drive_setpoint *setpoint, float dt_s) {
  drive_position_objects *position = &objects->position;
  const bool controlled = setpoint->command.mode == SERVO_POSITION;
  const drive_angle error = setpoint->position - axis->position;
  position->following_error = controlled ? drive_position_from_angle(error) : 0;
  const bool outside = !is_within(position->following_error_window, position->following_error);
  const bool too_long =
      dwell_timer_step(&axis->following_error, controlled && outside, position->following_error_ms, dt_s);
  axis->following_failed = too_long || (controlled && (error > QUARTER_TURN || error < -QUARTER_TURN));
  return axis->following_failed;
}

static bool is_tracking(const drive_axis *axis, drive_action action) {
  return action == DRIVE_RUN && axis->motion.mode == DRIVE_TRACKING;
}

static drive_tracking tracking_after(drive_tracking before, const drive_axis_inputs *inputs, bool on_target) {
  if (inputs->target == NULL || !inputs->target->known) {
    return before == DRIVE_NOT_TRACKING || before == DRIVE_SEARCHING ? DRIVE_SEARCHING : DRIVE_TARGET_LOST;
  }
  if (inputs->target->frame_age_ticks > DRIVE_COASTS_AFTER) {
    return DRIVE_COASTING;
  }
  return on_target ? DRIVE_ON_TARGET : DRIVE_ACQUIRING;
}

static void step_homing(drive_axis *axis, const drive_objects *objects, const drive_axis_inputs *inputs,
                        drive_action action, float dt_s) {
  const bool runs = action == DRIVE_RUN; /* a start may come before its brake has opened */
  const bool start = (objects->state.controlword & DRIVE_CONTROL_NEW_SETPOINT) != 0;
  const bool in_mode = axis->motion.mode == DRIVE_HOMING;
  if (!in_mode && homing_is_idle(&axis->homing)) {
    homing_pass(&axis->homing, runs, start);
    return;
  }
  const homing_inputs in = {.runs = runs,
                            .in_mode = in_mode,
                            .start = start,
                            .position_known = inputs->position_known,
                            .turn_seen = inputs->turn_seen,
                            .torque_limited = inputs->torque_limited,
                            .rate_rad_s = inputs->rate_rad_s,
                            .reference_rad_s = inputs->reference_rad_s,
                            .contact_s = inputs->contact_s};
  homing_step(&axis->homing, &objects->homing, &in, dt_s);
  axis->motion.homing_rad_s = axis->homing.target_rad_s;
}

/* 60F4 is the distance to the target then; no window of 6065 judges it. 6068 counts into the window and out of it. */
static void step_tracking(drive_axis *axis, drive_objects *objects, const drive_axis_inputs *inputs,
                          drive_action action, float dt_s) {
  drive_position_objects *position = &objects->position;
  const bool follows = is_tracking(axis, action) && inputs->target != NULL && inputs->target->known;
  if (follows) {
    position->following_error = drive_position_from_rad(inputs->target->error_rad);
  }
  const bool near = follows && is_within(position->window, position->following_error);
  const bool was_on_target = axis->tracking == DRIVE_ON_TARGET;
  const bool changes = dwell_timer_step(&axis->target_window, near != was_on_target, position->window_ms, dt_s);
  const bool on_target = was_on_target != changes;
  axis->tracking = is_tracking(axis, action) ? tracking_after(axis->tracking, inputs, on_target) : DRIVE_NOT_TRACKING;
}

/* A target that 607D has cut while the axis stood may be elsewhere. */
static bool is_at_target(const drive_motion *motion, const drive_setpoint *setpoint) {
  return !motion->setpoints.under_way && motion->setpoints.target.angle == setpoint->position;
}

static bool target_reached(drive_axis *axis, const drive_objects *objects, const drive_setpoint *setpoint,
                           drive_action action, float dt_s) {
  const drive_position_objects *position = &objects->position;
  const drive_velocity_objects *velocity = &objects->velocity;
  const int8_t mode = axis->motion.mode;
  const bool runs = action == DRIVE_RUN;
  const bool position_reached =
      dwell_timer_step(&axis->position_reached,
                       runs && mode == DRIVE_PROFILE_POSITION && is_at_target(&axis->motion, setpoint) &&
                           is_within(position->window, drive_position_from_angle(setpoint->position - axis->position)),
                       position->window_ms, dt_s);
  const bool near_velocity = distance_between(velocity->target, velocity->actual) <= velocity->window;
  const bool velocity_reached = dwell_timer_step(
      &axis->velocity_reached, runs && mode == DRIVE_PROFILE_VELOCITY && near_velocity, velocity->window_ms, dt_s);
  const bool homing_ended =
      runs && mode == DRIVE_HOMING && homing_is_idle(&axis->homing) && profile_at_rest(&axis->motion.ramp);
  return position_reached || velocity_reached || homing_ended || axis->tracking == DRIVE_ON_TARGET ||
         (!runs && setpoint->stopped);
}

/* Statusword bit 12; its meaning depends on the mode. */
static bool mode_bit(drive_axis *axis, const drive_objects *objects, const drive_setpoint *setpoint,
                     drive_action action, float dt_s) {
  const drive_velocity_objects *velocity = &objects->velocity;
  const bool moving = dwell_timer_step(&axis->moving, distance_between(velocity->actual, 0) > velocity->threshold,
                                       velocity->threshold_ms, dt_s);
  switch (axis->motion.mode) {
    case DRIVE_PROFILE_POSITION:
      return axis->motion.setpoints.acknowledged;
    case DRIVE_PROFILE_VELOCITY:
      return !moving;
    case DRIVE_HOMING:
      return axis->homing.phase == HOMING_ATTAINED;
    case DRIVE_NO_MODE:
      return false;
    default:
      return action == DRIVE_RUN && setpoint->followed;
  }
}

static uint16_t bit_if(bool condition, uint16_t bit) { return condition ? bit : 0; }

static uint16_t statusword_of(drive_axis *axis, drive_objects *objects, const drive_axis_inputs *inputs,
                              const drive_setpoint *setpoint, drive_action action, float dt_s) {
  const bool wraps = !drive_travel_is_limited(&axis->motion.bounds.travel);
  const bool following_failed = monitor_following(axis, objects, setpoint, dt_s);
  step_homing(axis, objects, inputs, action, dt_s);
  const bool homing_failed = axis->motion.mode == DRIVE_HOMING && axis->homing.phase == HOMING_FAILED;
  step_tracking(axis, objects, inputs, action, dt_s);
  const bool reached = target_reached(axis, objects, setpoint, action, dt_s);
  const bool bit_12 = mode_bit(axis, objects, setpoint, action, dt_s);
  const bool limited = action != DRIVE_OFF && (inputs->torque_limited || setpoint->limited);
  return (uint16_t)(drive_state_statusword(axis->state.power) |
                    bit_if(inputs->voltage_present, DRIVE_STATUS_VOLTAGE_ENABLED) |
                    bit_if(inputs->warning, DRIVE_STATUS_WARNING) | bit_if(inputs->remote, DRIVE_STATUS_REMOTE) |
                    bit_if(reached, DRIVE_STATUS_TARGET_REACHED) | bit_if(limited, DRIVE_STATUS_INTERNAL_LIMIT) |
                    bit_if(bit_12, DRIVE_STATUS_MODE_12) |
                    bit_if(following_failed || homing_failed, DRIVE_STATUS_MODE_13) |
                    bit_if(wraps && axis->position != drive_angle_wrap(axis->position), DRIVE_STATUS_WRAPPED));
}

const servo_axis_command *drive_axis_step(drive_axis *axis, const drive_objects *objects,
                                          const drive_axis_inputs *inputs, float dt_s) {
  axis->position = drive_angle_unwrap(axis->position, inputs->joint_angle);
  const bool finite = inputs_are_finite(inputs);
  const drive_feedback feedback = feedback_of(axis, inputs, finite);
  const drive_action action = step_state(axis, objects, inputs, finite, dt_s);
  /* An axis whose brake has not opened yet holds its position, as when it is halted. */
  const drive_action motion = action == DRIVE_RUN && !axis->brake.opened ? DRIVE_SLOW_DOWN : action;
  axis->setpoint = drive_motion_step(&axis->motion, objects, motion, &feedback, dt_s);
  return &axis->setpoint.command;
}

void drive_axis_report(drive_axis *axis, drive_objects *objects, const drive_axis_inputs *inputs, float dt_s) {
  const drive_setpoint *setpoint = &axis->setpoint;
  const drive_travel *travel = &axis->motion.bounds.travel;
  const bool wraps = !drive_travel_is_limited(travel);
  write_actual_values(axis, objects, inputs);
  objects->position.range_minimum = wraps ? -DRIVE_RANGE_END : 0;
  objects->position.range_maximum = wraps ? DRIVE_RANGE_END : 0;
  objects->state.error_code = fault_table[axis->fault].code;
  objects->state.mode_display = axis->motion.mode;
  objects->position.demand = setpoint->position == axis->position ? objects->position.actual
                                                                  : drive_travel_position(travel, setpoint->position);
  objects->velocity.demand = drive_velocity_from_rate(setpoint->command.speed.rate_rad_s);
  objects->state.statusword = statusword_of(axis, objects, inputs, setpoint, axis->state.action, dt_s);
}

void drive_axis_prepare(drive_axis *axis, const drive_objects *objects, const drive_machine *machine, float dt_s) {
  const drive_travel *travel = &axis->motion.bounds.travel;
  const bool wrapped = !drive_travel_is_limited(travel);
  drive_motion_prepare(&axis->motion, objects, machine, dt_s);
  if (wrapped && drive_travel_is_limited(travel)) {
    const drive_angle ranges = axis->position - drive_angle_wrap(axis->position);
    if (ranges != 0) {
      drive_axis_shift(axis, (int)(-ranges / (INT64_C(1) << 32)));
    }
  }
}
