/* SPDX-License-Identifier: Apache-2.0 */
#include "node/axis_monitor.h"

#include <math.h>
#include <stddef.h>

#include "base/scalar.h"

#define COMMISSIONING_KIND 2.0f
#define ENDLESS_KIND 1.0f

/* Wrong readings that look like valid ones: the fusion takes them for the base's rate. */
#define MISREADINGS                                                                                    \
  (fault_bit(FAULT_ENCODER_JUMP) | fault_bit(FAULT_ENCODER_STUCK) | fault_bit(FAULT_ENCODER_ERRATIC) | \
   fault_bit(FAULT_SENSORS_DISAGREE) | fault_bit(FAULT_GYRO_STUCK) | fault_bit(FAULT_GYRO_SATURATED))

/* Every 4 ms, as long as the smoothed difference of the two remembers the wrong readings. */
enum { RENEWALS = 10 };

/* After a second without an angle the axis may have turned by more than half a turn. */
enum { FORGET_TICKS = 997 }; /* and up to 3 until axis_monitor_locate */

void axis_monitor_reset(axis_monitor *monitor) {
  axis_protection_reset(&monitor->state);
  monitor->slow = (slow_monitors){.found = 0};
  monitor->proof = (motion_proof){.tick = 0};
  monitor->judged = 0;
  envelope_release(&monitor->envelope);
  axis_monitor_retuned(monitor);
}

void axis_monitor_retuned(axis_monitor *monitor) {
  oscillation_reset(&monitor->swings);
  monitor->oscillates = false;
}

static protection_motor motor_of(const servo_axis_params *params) {
  return (protection_motor){
      .resistance_ohm = params->resistance_ohm,
      .back_emf_v_s_rad = params->current.back_emf_v_s_rad,
      .current_limit_a = params->current_limit_a,
      .torque_constant_nm_a = params->torque_constant_nm_a,
      .time_constant_s = params->current.pi.proportional_gain / params->current.pi.integral_gain,
  };
}

static void look(protection_inputs *in, const servo_board *board, int i, drive_angle before) {
  const servo_axis *axis = &board->app.axis[i];
  const servo_axis_samples *samples = &board->samples.axis[i];
  const bool closed = servo_mode_closes(axis->mode);
  const bool valid = !samples->sensors.encoder_failed;
  const drive_angle position = valid ? drive_angle_unwrap(before, samples->sensors.joint_angle_turn32) : before;
  in->angle_valid = valid;
  in->angle = samples->sensors.joint_angle_turn32;
  in->gyro_valid = samples->sensors.gyro_valid;
  in->gyro_used = board->app.params.axis[i].speed.rate_fusion.source != RATE_FROM_ENCODER;
  in->gyro_rad_s = samples->sensors.gyro_rad_s;
  in->gyro_gain = axis->speed.gyro.gain;
  in->gyro_of_joint = axis->speed.gyro.of_joint;
  in->position_rad = drive_angle_difference_rad(position, 0);
  in->mean_current_a = samples->sensors.mean_current_a;
  in->tick_voltage_v = samples->tick_voltage_v;
  in->tick_current_a = samples->tick_current_a;
  in->bus_voltage_v = board->samples.bus_voltage_v;
  in->powered = axis->mode != SERVO_OFF;
  in->closed = servo_mode_drives(axis->mode);
  in->speed_closed = closed && axis->mode != SERVO_TORQUE;
  in->limited = axis->signals.torque.limited;
  in->torque_nm = axis->commanded_nm;
  in->reference_rad_s = axis->signals.reference.rate_rad_s - axis->speed.carried_rad_s;
  in->rate_rad_s = axis->signals.rates.rate_rad_s - axis->speed.carried_rad_s;
}

/* What the torque limits of the last command leave; never less than a tenth of the motor's torque: below it nothing
 * shakes. */
static float torque_in_force_nm(const servo_axis_params *params, const servo_axis_command *command) {
  const float motor_nm = params->current_limit_a * params->torque_constant_nm_a;
  if (!command->torque_limited) {
    return motor_nm;
  }
  return scalar_clamp(scalar_max(command->limits.maximum_nm, -command->limits.minimum_nm), 0.1f * motor_nm, motor_nm);
}

static float friction_nm(const servo_axis_params *params) {
  const lugre_params *lugre = &params->speed.friction.lugre;
  return scalar_max(lugre->positive.coulomb_nm, lugre->negative.coulomb_nm);
}

/* What the target asks for: the set-point of an axis that follows its set-point at once. Such an axis would be
 * `ahead_rad` farther, and its tracking loop would see this much less of the error. */
static float tracked_rad_s(ideal_tracking *ideal, const servo_axis *axis, const drive_motion *motion) {
  const servo_target *target = motion->followed;
  const float wanted_rad_s = target->reference.rate_rad_s - target->proportional_per_s * ideal->ahead_rad;
  ideal->rate_rad_s = drive_tracking_rate_within(&motion->tracking, wanted_rad_s, ideal->rate_rad_s, SERVO_TICK_S);
  ideal->ahead_rad += (ideal->rate_rad_s - axis->signals.rates.rate_rad_s) * SERVO_TICK_S;
  return ideal->rate_rad_s;
}

/* The rate that the axis gets from outside. */
static float outer_reference_rad_s(axis_monitor *monitor, const servo_board *board, int i, const drive_motion *motion) {
  const servo_axis *axis = &board->app.axis[i];
  const servo_axis_command *command = &board->command.axis[i];
  const float increment_rad = angle_difference_rad(command->position, monitor->last_setpoint);
  monitor->last_setpoint = command->position;
  if (motion->followed != NULL) {
    return tracked_rad_s(&monitor->ideal, axis, motion);
  }
  monitor->ideal = (ideal_tracking){.ahead_rad = 0.0f, .rate_rad_s = axis->signals.reference.rate_rad_s};
  switch (axis->mode) {
    case SERVO_SPEED:
      return axis->signals.reference.rate_rad_s;
    case SERVO_POSITION:
      return increment_rad / SERVO_TICK_S;
    default:
      return 0.0f;
  }
}

/* The commands of this tick, for the motion that the next one sees. */
static void note_commands(axis_monitor *monitor, const servo_board *board, int i, const drive_motion *motion) {
  const servo_axis *axis = &board->app.axis[i];
  const bool known = motion->followed == NULL && (axis->mode == SERVO_SPEED || axis->mode == SERVO_POSITION);
  monitor->torque_nm = torque_in_force_nm(&board->app.params.axis[i], &board->command.axis[i]);
  monitor->commanded =
      (oscillation_inputs){.reference_rad_s = outer_reference_rad_s(monitor, board, i, motion),
                           .reference_known = known,
                           .loop_nm = axis->commanded_nm - axis->added_nm,
                           .feedforward_nm = axis->signals.torque.friction_nm + axis->signals.torque.acceleration_nm,
                           .added_nm = axis->added_nm};
}

/* A loop that feeds back the gyro alone, or what the base's rates add, holds the inertial rate: on a turning base the
 * joint's swings are healthy. */
static bool look_for_oscillation(axis_monitor *monitor, const servo_axis_params *params, float carried_rad_s,
                                 bool suspect) {
  const bool rate_from_gyro = params->speed.rate_fusion.source == RATE_FROM_GYRO;
  const oscillation_params plant = {.inertia_kg_m2 = params->plant_inertia_kg_m2,
                                    .friction_nm = scalar_min(friction_nm(params), 0.3f * monitor->torque_nm),
                                    .torque_nm = monitor->torque_nm,
                                    .suspect = suspect};
  oscillation_inputs in = monitor->commanded;
  in.closed = monitor->seen.speed_closed && monitor->seen.angle_valid;
  const bool inertial = rate_from_gyro && monitor->seen.gyro_valid;
  in.rate_rad_s = inertial ? monitor->state.last_inertial_rad_s : monitor->state.last_step_rad / SERVO_TICK_S;
  in.rate_rad_s += carried_rad_s;
  return oscillation_step(&monitor->swings, &plant, &in, SERVO_TICK_S);
}

/* In a fast oscillation voltage and current alternate within a tick, and their means say little: until the new gains
 * are proven or taken back, a difference shows no broken sensor. */
static fault_set without_current(axis_monitor *monitor, fault_set found) {
  if (!monitor->may_shake) {
    return found;
  }
  monitor->state.mismatch_ticks = 0;
  return found & ~(fault_bit(FAULT_CURRENT_SENSOR) | fault_bit(FAULT_MOTOR_CONTRADICTS) | fault_bit(FAULT_MOTOR_WEAK));
}

/* Of an axis whose mode of operation does not decide. */
static envelope_phase phase_of(const drive_axis *drive) {
  const drive_state *state = &drive->state;
  const bool in_fault = state->power == DRIVE_FAULT_REACTION_ACTIVE || state->power == DRIVE_FAULT;
  if (in_fault && state->reaction >= DRIVE_FAULT_BRAKES) {
    return ENVELOPE_UNTRUSTED;
  }
  switch (state->action) {
    case DRIVE_PROTECTIVE_STOP:
      return ENVELOPE_BRAKING;
    case DRIVE_RUN:
    case DRIVE_SLOW_DOWN:
    case DRIVE_QUICK_STOP:
      return ENVELOPE_STOPPING;
    case DRIVE_OFF:
    case DRIVE_BRAKE:
    default:
      return in_fault ? ENVELOPE_STOPPING : ENVELOPE_POWERLESS;
  }
}

static fault_set bit_if(unsigned found, fault_id fault) { return found != 0 ? fault_bit(fault) : 0; }

static fault_set keep_within(axis_monitor *monitor, const drive_axis *drive) {
  const protection_inputs *seen = &monitor->seen;
  const bool runs = drive->state.action == DRIVE_RUN && !drive->motion.ordered;
  const envelope_phase phase = runs ? ENVELOPE_RUNNING : phase_of(drive);
  if (!seen->angle_valid) {
    envelope_lose(&monitor->envelope, phase);
    return 0;
  }
  const unsigned found = envelope_step(&monitor->envelope, &monitor->allowed, phase, seen->powered, seen->angle,
                                       seen->position_rad, seen->reference_rad_s);
  if (found == 0) {
    return 0;
  }
  return bit_if(found & ENVELOPE_TOO_FAST, FAULT_TOO_FAST) | bit_if(found & ENVELOPE_STOP_IGNORED, FAULT_STOP_IGNORED) |
         bit_if(found & ENVELOPE_BRAKING_FAILS, FAULT_BRAKING_FAILS);
}

/* A gyro that is certainly wrong raises no doubt of the encoder: the axis cannot have got to the end of its range in
 * the 5 ticks of their comparison, and one that repeats its reading differs from the encoder because the axis brakes.
 */
static __attribute__((noinline)) void weigh_found(axis_monitor *monitor) {
  monitor->jumped = monitor->jumped || (monitor->found & fault_bit(FAULT_ENCODER_JUMP)) != 0;
  monitor->misread = (monitor->found & MISREADINGS) != 0 ? RENEWALS : monitor->misread;
  if ((monitor->found & (fault_bit(FAULT_GYRO_STUCK) | fault_bit(FAULT_GYRO_SATURATED))) != 0) {
    monitor->found &= ~(fault_bit(FAULT_SENSORS_DISAGREE) | fault_bit(FAULT_ENCODER_ERRATIC));
    axis_protection_forget_differences(&monitor->state);
  }
}

fault_set axis_monitor_step(axis_monitor *monitor, const servo_board *board, int axis, const drive_axis *drive) {
  const protection_motor motor = motor_of(&board->app.params.axis[axis]);
  look(&monitor->seen, board, axis, drive->position);
  monitor->found = axis_protection_step(&monitor->state, &monitor->limits, &motor, &monitor->seen, SERVO_TICK_S);
  if (monitor->found != FAULT_NONE) {
    weigh_found(monitor);
  }
  return monitor->judged | without_current(monitor, monitor->found) | keep_within(monitor, drive);
}

void axis_monitor_protect(axis_monitor *monitor, const servo_axis_params *params, drive_axis_inputs *inputs) {
  const float share = envelope_brake(&monitor->envelope, &monitor->allowed);
  inputs->turns = monitor->envelope.turns;
  inputs->at_rest = envelope_at_rest(&monitor->envelope);
  inputs->protective_nm = share * params->current_limit_a * params->torque_constant_nm_a;
}

float axis_monitor_fastest_rad_s(const axis_monitor *monitor, float direction) {
  const envelope_limits *limits = &monitor->allowed;
  const float position_rad = monitor->seen.position_rad;
  const float room_rad = direction < 0.0f ? position_rad - limits->minimum_rad : limits->maximum_rad - position_rad;
  return scalar_min(envelope_fastest_rad_s(limits, room_rad), monitor->limits.overspeed_rad_s);
}

static float stop_deceleration_rad_s2(const protection_limits *limits) {
  return scalar_min(limits->stop_deceleration_rad_s2, 0.5f * limits->deceleration_rad_s2);
}

static uint8_t restrictions_of(const axis_monitor *monitor) {
  const protection_limits *limits = &monitor->limits;
  const bool commissioning = limits->travel_kind >= COMMISSIONING_KIND;
  const bool none = !protection_has_travel(limits) && limits->travel_kind < ENDLESS_KIND;
  const bool unknown = protection_has_travel(limits) && !monitor->candidates.known;
  return (uint8_t)((none ? RESTRICTED_NO_TRAVEL : 0) | (unknown ? RESTRICTED_POSITION_UNKNOWN : 0) |
                   (commissioning ? RESTRICTED_COMMISSIONING : 0));
}

#define TURN (INT64_C(1) << 32)

static float count_rad_of(const axis_monitor *monitor, const drive_axis *drive) {
  return drive_angle_difference_rad(drive->position - monitor->turn * TURN, 0);
}

static bool turn_at(const axis_monitor *monitor, const drive_axis *drive, int32_t position, int8_t *turn) {
  const float position_rad = drive_angle_difference_rad(drive_angle_from_position(position), 0);
  const start_candidates *possible = &monitor->candidates;
  return start_position_turn_at(count_rad_of(monitor, drive), position_rad, turn) &&
         (possible->lowest > possible->highest || (*turn >= possible->lowest && *turn <= possible->highest));
}

bool axis_monitor_may_see(const axis_monitor *monitor, const drive_axis *drive, int32_t position) {
  int8_t turn;
  return turn_at(monitor, drive, position, &turn);
}

void axis_monitor_see(axis_monitor *monitor, const drive_axis *drive, int32_t position) {
  int8_t turn;
  if (turn_at(monitor, drive, position, &turn)) {
    start_position_see(&monitor->start, turn);
  }
}

void axis_monitor_inform_homing(const axis_monitor *monitor, drive_axis_inputs *inputs) {
  const float contact_s = 0.25f; /* before the stall fault */
  inputs->position_known = monitor->candidates.known;
  inputs->turn_seen = monitor->start.seen;
  inputs->contact_s = scalar_min(contact_s, 0.5f * monitor->limits.stall_s);
}

static void find_turn(axis_monitor *monitor, drive_axis *drive) {
  const protection_limits *limits = &monitor->limits;
  const bool known_before = monitor->candidates.known;
  const float count_rad = count_rad_of(monitor, drive);
  if (drive->homing.phase == HOMING_CONFIRMING) {
    start_position_take_seen(&monitor->start);
  }
  monitor->candidates = start_position_step(&monitor->start, count_rad, limits->minimum_rad, limits->maximum_rad);
  if (monitor->candidates.known && (!known_before || monitor->start.turn != monitor->turn)) {
    drive_axis_shift(drive, monitor->start.turn - monitor->turn);
    monitor->turn = monitor->start.turn;
  }
}

static void renew_base_rate(axis_monitor *monitor, rate_fusion_state *fusion) {
  if (monitor->misread > 0 && monitor->state.gyro_missing_ticks == 0 && monitor->state.angles_known > 1) {
    fusion->base_rate_rad_s = monitor->state.difference_rad_s;
    monitor->misread--;
  }
}

void axis_monitor_distrust(axis_monitor *monitor, const drive_axis *drive, bool voltage_doubted,
                           rate_fusion_state *fusion) {
  const bool misled = drive->state.reaction >= DRIVE_FAULT_BRAKES;
  if (voltage_doubted || (misled && drive->state.power == DRIVE_FAULT)) {
    motor_witness_forget_motor(&monitor->state.witness);
  }
  if (drive->fault == FAULT_SENSORS_DRIFT) {
    monitor->misread = RENEWALS;
  }
  renew_base_rate(monitor, fusion);
}

static bool is_endless(const protection_limits *limits) {
  return !protection_has_travel(limits) && limits->travel_kind >= ENDLESS_KIND &&
         limits->travel_kind < COMMISSIONING_KIND;
}

/* Readings that jump may have counted hundreds of turns: as at the start, from within half a turn of the encoder's
 * zero. Without end stops nothing else tells the turn: within half a turn of the last good position. */
static void count_anew(axis_monitor *monitor, drive_axis *drive) {
  const bool endless = is_endless(&monitor->limits);
  const drive_angle near = endless ? drive->trusted_position : 0;
  const drive_angle position = near + (int32_t)(angle_turn32)(drive->position - near);
  drive_axis_shift(drive, (int)((position - drive->position) / TURN));
  drive->trusted_position = near;
  monitor->turn = endless ? monitor->turn : 0;
}

/* Wrong readings may stand still for a while. Half a second passes before an encoder is trusted again, or less if the
 * axis could turn too far in it. */
enum { LOCATED_TICKS = 4, LONGEST_DOUBT = 125 };
#define DOUBT_RAD 1.5f

static void begin_to_doubt(axis_monitor *monitor) {
  const float calls = DOUBT_RAD / ((float)LOCATED_TICKS * SERVO_TICK_S * monitor->limits.overspeed_rad_s);
  monitor->doubtful = (uint8_t)scalar_clamp(calls, 1.0f, (float)LONGEST_DOUBT);
}

static void trust_position(axis_monitor *monitor, drive_axis *drive) {
  const fault_set doubts = fault_bit(FAULT_ENCODER_ERRATIC) | fault_bit(FAULT_SENSORS_DISAGREE);
  const float tick_rad = monitor->limits.overspeed_rad_s * SERVO_TICK_S;
  if ((monitor->found & doubts) != 0 || !scalar_within(monitor->state.last_step_rad, tick_rad)) {
    begin_to_doubt(monitor);
  } else if (monitor->doubtful > 0) {
    monitor->doubtful--;
  } else {
    drive->trusted_position = drive->position;
  }
}

void axis_monitor_locate(axis_monitor *monitor, drive_axis *drive) {
  const bool jumps = monitor->jumped;
  monitor->jumped = false;
  if (monitor->seen.angle_valid && !jumps) {
    find_turn(monitor, drive);
    trust_position(monitor, drive);
  } else if (jumps || monitor->gap_ticks >= FORGET_TICKS) {
    start_position_forget(&monitor->start);
    begin_to_doubt(monitor);
    count_anew(monitor, drive);
    monitor->candidates = (start_candidates){.lowest = 1, .known = false};
  }
}

void axis_monitor_limit(axis_monitor *monitor) {
  const protection_limits *limits = &monitor->limits;
  monitor->restrictions = restrictions_of(monitor);
  const bool slow = monitor->restrictions != 0;
  const envelope_params envelope = {.minimum_rad = limits->minimum_rad,
                                    .maximum_rad = limits->maximum_rad,
                                    .deceleration_rad_s2 = limits->deceleration_rad_s2,
                                    .stop_deceleration_rad_s2 = stop_deceleration_rad_s2(limits),
                                    .slow = slow};
  monitor->allowed = envelope_prepare(&envelope, SERVO_TICK_S);
  monitor->seen.ends_known = !slow;
}

/* Set-point 0, or a position that does not change. */
static bool stands(axis_monitor *monitor, const servo_axis_command *command) {
  const bool held = command->mode == SERVO_POSITION && command->position == monitor->last_position;
  monitor->last_position = command->position;
  return (held || command->mode == SERVO_SPEED) && command->speed.rate_rad_s == 0.0f;
}

/* The axes in different ticks. */
static bool judges_slowly(uint32_t tick, int axis) {
  const uint32_t period = SLOW_MONITOR_TICKS;
  return (tick + (uint32_t)axis * (period / (uint32_t)SERVO_AXES)) % period == 0;
}

static fault_set judge_slowly(axis_monitor *monitor, const protection_motor *motor, const servo_axis_command *command,
                              int axis, const axis_monitor_setting *setting) {
  slow_monitors_add(&monitor->slow, &monitor->state, monitor->found, monitor->seen.torque_nm);
  if (judges_slowly(setting->tick, axis)) {
    monitor->stands = stands(monitor, command) && !setting->stimulated;
    const slow_commands commands = {.standing = monitor->stands, .reduced = setting->reduced_speed};
    slow_monitors_judge(&monitor->slow, &monitor->limits, motor, &monitor->state, &monitor->seen, &commands,
                        SERVO_TICK_S);
  }
  return monitor->slow.found;
}

/* What opposes the test torque of a standing axis: the identified plant (2056), whatever its friction model says, and
 * its gains. */
static motion_proof_axis opposition_of(const servo_axis_params *params) {
  const speed_loop_params *speed = &params->speed;
  const float omega_rad = 2.0f * SCALAR_PI / (float)MOTION_PROOF_PERIOD_TICKS;
  return (motion_proof_axis){
      .inertia_kg_m2 = params->plant_inertia_kg_m2,
      .stiffness_nm_rad = params->plant_stiffness_nm_rad,
      .damping_nm_s_rad = params->plant_damping_nm_s_rad + params->plant_viscous_nm_s_rad,
      .proportional_gain = speed->pi.proportional_gain,
      .integral_gain = speed->pi.integral_gain,
      .filter_gain = biquad_gain(&speed->notch, omega_rad) * biquad_gain(&speed->lowpass, omega_rad),
      .position_per_s = params->position.proportional_per_s,
      .observer_rad_s = speed->observer_on ? speed->observer.bandwidth_rad_s : 0.0f,
      .observer_inertia_kg_m2 = speed->observer.inertia_kg_m2,
      .observer_viscous_nm_s_rad = speed->observer.viscous_nm_s_rad,
  };
}

/* Not with an encoder alone: it may be too coarse to show the swing; nor with a gyro that hardly turns with the axis;
 * nor before the axis is identified. */
static bool is_tested(const axis_monitor *monitor, const speed_loop_pose *pose) {
  const bool by_gyro = monitor->seen.gyro_used && monitor->seen.gyro_valid && !pose->gyro_below &&
                       !scalar_within(pose->gyro_share, SPEED_LOOP_MIN_GYRO_SHARE);
  return monitor->limits.proof_rad_s > 0.0f && monitor->stands && monitor->seen.speed_closed && by_gyro &&
         (monitor->restrictions & RESTRICTED_COMMISSIONING) == 0;
}

#define PROOF_SHARE 0.02f /* of the motor's torque, at most */

static fault_set prove_motion(axis_monitor *monitor, const servo_axis *axis, const servo_axis_params *params) {
  if (!is_tested(monitor, &axis->speed.pose)) {
    monitor->proof = (motion_proof){.tick = 0};
    return 0;
  }
  const float motor_nm = params->current_limit_a * params->torque_constant_nm_a;
  const motion_proof_limits limits = {.answer_rad_s = monitor->limits.proof_rad_s, .most_nm = PROOF_SHARE * motor_nm};
  const motion_proof_axis opposition =
      monitor->proof.tick == 0 ? opposition_of(params) : (motion_proof_axis){.inertia_kg_m2 = 0.0f};
  const bool limited = monitor->seen.limited || monitor->torque_nm <= 0.1f * motor_nm || monitor->may_shake;
  motion_proof_step(&monitor->proof, &limits, &opposition, monitor->seen.rate_rad_s, limited, SERVO_TICK_S);
  return bit_if(monitor->proof.unanswered, FAULT_NO_ANSWER);
}

/* Fault 2 does not compare across ticks without an angle. Farther away than the axis can have got, the next angle may
 * count a turn too many. */
static void look_across_a_gap(axis_monitor *monitor) {
  const protection_inputs *seen = &monitor->seen;
  if (!seen->angle_valid) {
    monitor->gap_ticks = (uint16_t)(monitor->gap_ticks + (monitor->gap_ticks < UINT16_MAX ? 1u : 0u));
    return;
  }
  if (monitor->gap_ticks > 0) {
    const float passed_s = (float)(monitor->gap_ticks + 1) * SERVO_TICK_S;
    const float farthest_rad = monitor->limits.overspeed_rad_s * passed_s + monitor->limits.encoder_jump_rad;
    const float moved_rad = angle_difference_rad(seen->angle, monitor->last_angle);
    const bool near = farthest_rad < SCALAR_PI && scalar_within(moved_rad, farthest_rad);
    monitor->jumped = monitor->jumped || !near;
    monitor->gap_ticks = 0;
  }
  monitor->last_angle = seen->angle;
}

/* A rate that a long window has delayed is behind for RUNAWAY_TICKS and some after the window got shorter. */
static float delay_of_rate_s(float before_s, const rate_estimator_params *params) {
  const float delay_s = 0.5f * (float)(params->window_ticks - 2) * SERVO_TICK_S;
  return scalar_max(delay_s, before_s - 0.2f * SERVO_TICK_S);
}

void axis_monitor_judge(axis_monitor *monitor, const servo_board *board, int axis,
                        const axis_monitor_setting *setting) {
  const servo_axis_params *params = &board->app.params.axis[axis];
  const servo_axis_command *command = &board->command.axis[axis];
  const protection_motor motor = motor_of(params);
  look_across_a_gap(monitor);
  monitor->seen.rate_delay_s = delay_of_rate_s(monitor->seen.rate_delay_s, &params->speed.rate_estimator);
  const fault_set found =
      axis_protection_judge(&monitor->state, &monitor->limits, &motor, &monitor->seen, SERVO_TICK_S);
  monitor->oscillates =
      look_for_oscillation(monitor, params, board->app.axis[axis].speed.carried_rad_s, setting->new_gains);
  monitor->may_shake = setting->new_gains && oscillation_may_begin(&monitor->swings);
  monitor->judged = without_current(monitor, found) | judge_slowly(monitor, &motor, command, axis, setting) |
                    prove_motion(monitor, &board->app.axis[axis], params);
  note_commands(monitor, board, axis, setting->motion);
}

void axis_monitor_remember(const axis_monitor *monitor, int axis, fault_log *log) {
  const protection_inputs *seen = &monitor->seen;
  const fault_log_sample sample = {
      .joint_angle_rad = angle_difference_rad(seen->angle, 0),
      .joint_rate_rad_s = monitor->state.last_step_rad / SERVO_TICK_S,
      .gyro_rad_s = seen->gyro_valid ? seen->gyro_rad_s : NAN,
      .reference_rad_s = seen->reference_rad_s,
      .rate_rad_s = seen->rate_rad_s,
      .torque_nm = seen->torque_nm,
      .current_a = seen->mean_current_a,
      .bus_voltage_v = seen->bus_voltage_v,
  };
  fault_log_sample_tick(log, axis, &sample);
}

static int32_t position_of(float angle_rad) {
  const float counts_per_rad = 1e7f;
  return (int32_t)(angle_rad * counts_per_rad);
}

static drive_travel hard_travel(const protection_limits *limits) {
  return (drive_travel){position_of(limits->minimum_rad), position_of(limits->maximum_rad)};
}

drive_machine axis_monitor_machine(const axis_monitor *monitor, const servo_axis_params *params) {
  const protection_limits *limits = &monitor->limits;
  return (drive_machine){.hard = hard_travel(limits),
                         .margin = position_of(limits->stopping_margin_rad),
                         .overspeed_rad_s = limits->overspeed_rad_s,
                         .position_rad_s = params->position.rate_limit_rad_s,
                         .torque_nm = params->current_limit_a * params->torque_constant_nm_a,
                         .deceleration_rad_s2 = limits->deceleration_rad_s2,
                         .stop_deceleration_rad_s2 = stop_deceleration_rad_s2(limits),
                         .slow = monitor->restrictions != 0,
                         .position_unknown = (monitor->restrictions & RESTRICTED_POSITION_UNKNOWN) != 0};
}

holding_brake_times axis_monitor_brake(const axis_monitor *monitor) {
  const protection_limits *limits = &monitor->limits;
  return (holding_brake_times){.release_s = limits->brake_release_s,
                               .engage_s = limits->brake_engage_s,
                               .feedback_used = limits->brake_feedback >= 0.5f};
}

drive_travel axis_monitor_default_travel(const axis_monitor *monitor) {
  const int32_t margin = 174533; /* 1 degree */
  const drive_travel hard = hard_travel(&monitor->limits);
  if ((int64_t)hard.maximum - hard.minimum < 4 * (int64_t)margin) {
    return (drive_travel){0, 0};
  }
  return (drive_travel){hard.minimum + margin, hard.maximum - margin};
}
