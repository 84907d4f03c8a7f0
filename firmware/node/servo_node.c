/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/node_objects.h"
#include "node/servo_node_parts.h"

bool servo_node_any_axis_is_powered(const servo_node *node) {
  bool powered = false;
  for (int i = 0; i < SERVO_AXES; ++i) {
    powered = powered || node->axis[i].drive.state.action != DRIVE_OFF;
  }
  return powered;
}

void servo_node_command_fault(servo_node *node, fault_id fault) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    node->axis[i].bus_faults |= fault_bit(fault);
  }
}

emergency_error servo_node_error_of(fault_id fault, uint8_t source, uint8_t detail) {
  const fault_row *row = &fault_table[fault];
  return (emergency_error){.code = row->code, .register_bits = row->register_bits, .source = source, .detail = detail};
}

void servo_node_raise_emergency(servo_node *node, fault_id fault, uint8_t source, uint8_t detail) {
  const emergency_error error = servo_node_error_of(fault, source, detail);
  (void)canopen_node_raise(&node->canopen, &error);
}

/* --- tick ------------------------------------------------------------------------------------------------------- */

/* The board's state of an axis; an axis that becomes not ready in operation must react, too. */
static fault_set faults_of_board(hal_health health, drive_power_state power) {
  static const fault_id fault_of[] = {[HAL_OVER_CURRENT] = FAULT_OVER_CURRENT_TRIP,
                                      [HAL_POWER_STAGE] = FAULT_POWER_STAGE,
                                      [HAL_TOO_HOT] = FAULT_OVER_TEMPERATURE,
                                      [HAL_TIMING_LOST] = FAULT_TICK_LATE,
                                      [HAL_IMAGE_DAMAGED] = FAULT_IMAGE_DAMAGED,
                                      [HAL_SAFE_TORQUE_OFF] = FAULT_SAFE_TORQUE_OFF,
                                      [HAL_SAFE_TORQUE_FAULT] = FAULT_SAFE_TORQUE_FAULT,
                                      [HAL_CLOCK_WRONG] = FAULT_CLOCK};
  if (health == HAL_GOOD || (health == HAL_NOT_READY && power == DRIVE_NOT_READY)) {
    return 0;
  }
  return fault_bit(health == HAL_NOT_READY ? FAULT_SELF_TEST : fault_of[health]);
}

/* Inlined, this and step_axis: out of line the monitors find their values 500 instructions per tick more slowly. */
static inline __attribute__((always_inline)) void gather_inputs(servo_node *node, int i) {
  servo_node_axis *axis = &node->axis[i];
  drive_axis_inputs *inputs = &axis->inputs;
  const hal_health health = hal_axis_health(node->board.machine, i);
  inputs->ready = health != HAL_NOT_READY && !node->canopen.reset.pending;
  inputs->voltage_present = node->board.samples.bus_voltage_v >= axis->monitor.limits.under_voltage_v;
  inputs->remote = node->canopen.state != NMT_STOPPED;
  inputs->setpoint_arrived = axis->setpoint_arrived;
  inputs->faults = axis->bus_faults | faults_of_board(health, axis->drive.state.power) |
                   axis_monitor_step(&axis->monitor, &node->board, i, &axis->drive);
  if (axis->monitor.oscillates && !axis_tuning_can_take_back(&axis->tuning)) {
    inputs->faults |= fault_bit(FAULT_OSCILLATION);
  }
  inputs->brake = axis_monitor_brake(&axis->monitor);
  inputs->brake_contact_open = inputs->brake.feedback_used && hal_brake_is_released(node->board.machine, i);
  if (inputs->faults != 0 || axis->drive.state.action == DRIVE_PROTECTIVE_STOP) {
    axis_monitor_protect(&axis->monitor, &node->board.app.params.axis[i], inputs);
  }
  inputs->warning = axis_protection_warns(&axis->monitor.state, &axis->monitor.limits);
  axis->bus_faults = 0;
  inputs->target = &node->tracking.joint[i];
  drive_axis_sense(inputs, &node->board.app.axis[i], &node->board.app.params.axis[i], &node->board.samples.axis[i]);
  axis->setpoint_arrived = false;
}

static inline __attribute__((always_inline)) void step_axis(servo_node *node, int i) {
  servo_node_axis *axis = &node->axis[i];
  gather_inputs(node, i);
  const float joint_rate_rad_s = node->board.app.axis[i].signals.rates.joint_rate_rad_s;
  const bool stimulated = experiment_objects_step(&axis->experiment, &axis->drive, axis->inputs.joint_angle,
                                                  joint_rate_rad_s, &axis->stimulus, SERVO_TICK_S);
  axis->inputs.stimulus = stimulated ? &axis->stimulus : NULL;
  node->board.command.axis[i] = *drive_axis_step(&axis->drive, &axis->objects, &axis->inputs, SERVO_TICK_S);
  node->board.command.axis[i].torque_nm += axis->monitor.proof.torque_nm;
}

void servo_node_take(servo_node *node) { canopen_node_take(&node->canopen); }

void servo_node_tick(servo_node *node) {
  servo_node_take(node);
  servo_node_tick_taken(node);
}

static float azimuth_swing_kg_m2(const servo_node *node) {
  const axis_parameters *azimuth = &node->axis[SERVO_AZIMUTH].tuning.active;
  return azimuth->plant.inertia_kg_m2 - azimuth->plant.min_inertia_kg_m2;
}

/* A drive that leaves the mode in this tick does not count. Returns whether a drive takes a new mode. */
static bool count_tracking(const servo_node *node, int *count) {
  bool any_changes = false;
  for (int i = 0; i < SERVO_AXES; ++i) {
    const drive_axis *drive = &node->axis[i].drive;
    const int8_t wanted = node->axis[i].objects.state.mode;
    const bool changes = wanted != drive->motion.mode && drive_mode_supported(wanted);
    any_changes = any_changes || changes;
    *count += drive->motion.mode == DRIVE_TRACKING && drive->state.action == DRIVE_RUN && !changes ? 1 : 0;
  }
  return any_changes;
}

void servo_node_tick_taken(servo_node *node) {
  servo_board_sample(&node->board);
  int tracking_axes = 0;
  const bool changes = count_tracking(node, &tracking_axes);
  tracking_take(&node->tracking, &node->board, node->objects.ticks, tracking_axes, changes);
  for (int i = 0; i < SERVO_AXES; ++i) {
    step_axis(node, i);
  }
  servo_board_control(&node->board);
  for (int i = 0; i < SERVO_AXES; ++i) {
    hal_release_brake(node->board.machine, i, node->axis[i].drive.brake.coil_on);
  }
}

/* --- after it ----------------------------------------------------------------------------------------------------- */

/* Without an angle the samples are implausible, too, up to a tick longer: that is the same fault. */
static fault_set faults_to_report(const servo_node_axis *axis) {
  const fault_set found = axis->drive.faults;
  const bool lost = ((found | axis->reports.reported) & fault_bit(FAULT_ENCODER_LOST)) != 0;
  return lost ? found & ~fault_bit(FAULT_IMPLAUSIBLE) : found;
}

/* EMCY and log of faults that come while an axis is in fault, and EMCY for those that end. The axes are separate
 * sources, so that 1001 shows a fault as long as one of them is in it. */
static void report_faults(servo_node *node, int i) {
  servo_node_axis *axis = &node->axis[i];
  const uint8_t source = (uint8_t)(i + 1);
  const fault_reports_item item = fault_reports_step(&axis->reports, axis->drive.fault, faults_to_report(axis));
  if (item.over != FAULT_NONE) {
    (void)canopen_node_clear(&node->canopen, source, fault_table[item.over].code);
  }
  if (item.reported != FAULT_NONE) {
    const emergency_error error = servo_node_error_of(item.reported, source, (uint8_t)item.reported);
    (void)canopen_node_raise_again(&node->canopen, &error);
    fault_log_write(&node->log, i, item.reported, node->objects.ticks);
  }
}

/* For 0x2101, and for the scope, which triggers on any power state and any fault. */
static void record(servo_node *node) {
  uint32_t states = 0;
  uint32_t faults = 0;
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_node_axis *axis = &node->axis[i];
    recorded_tick_take(&axis->recorded, &node->board, i, &axis->experiment, axis->inputs.stimulus != NULL,
                       node->objects.ticks);
    const drive_power_state power = axis->drive.state.power;
    states = states << 8 | (uint32_t)power;
    faults |= (power == DRIVE_FAULT || power == DRIVE_FAULT_REACTION_ACTIVE ? 1u : 0u) << i;
  }
  scope_step(&node->recorder, states, faults);
}

/* New gains that make the axis oscillate: the proven ones instead, from the next tick on. */
static void keep_gains_quiet(servo_node *node, int i) {
  servo_node_axis *axis = &node->axis[i];
  if (!axis->monitor.oscillates || !axis_tuning_can_take_back(&axis->tuning)) {
    axis_tuning_ran(&axis->tuning, axis->monitor.seen.speed_closed && !axis->monitor.oscillates);
    return;
  }
  axis_tuning_take_back(&axis->tuning, &node->board.app.axis[i], &node->board.app.params.axis[i],
                        axis->monitor.swings.mean_nm, SERVO_TICK_S);
  axis_monitor_retuned(&axis->monitor);
  const uint8_t source = (uint8_t)(i + 1);
  servo_node_raise_emergency(node, FAULT_GAINS_TAKEN_BACK, source, (uint8_t)FAULT_GAINS_TAKEN_BACK);
  (void)canopen_node_clear(&node->canopen, source, fault_table[FAULT_GAINS_TAKEN_BACK].code);
  fault_log_write(&node->log, i, FAULT_GAINS_TAKEN_BACK, node->objects.ticks);
}

static void report_axis(servo_node *node, int i) {
  servo_node_axis *axis = &node->axis[i];
  const axis_monitor_setting setting = {.tick = node->objects.ticks,
                                        .new_gains = axis_tuning_can_take_back(&axis->tuning),
                                        .stimulated = axis->inputs.stimulus != NULL,
                                        .reduced_speed = axis->limits.reduced_speed != 0,
                                        .motion = &axis->drive.motion};
  axis_monitor_judge(&axis->monitor, &node->board, i, &setting);
  keep_gains_quiet(node, i);
  axis_monitor_remember(&axis->monitor, i, &node->log);
  drive_axis_sense(&axis->inputs, &node->board.app.axis[i], &node->board.app.params.axis[i],
                   &node->board.samples.axis[i]);
  axis->inputs.warning = axis->inputs.warning || axis->left_alone;
  drive_axis_report(&axis->drive, &axis->objects, &axis->inputs, SERVO_TICK_S);
  report_faults(node, i);
}

/* --- a silent master ---------------------------------------------------------------------------------------------- */

/* The stop is written to the controlword, so that only a new command can end it. */
static void leave_alone(servo_node *node, int i) {
  servo_node_axis *axis = &node->axis[i];
  drive_state_objects *objects = &axis->objects.state;
  if (objects->option.master_silent == DRIVE_SILENT_GO_ON) {
    return;
  }
  node->master.stops++;
  if (objects->option.master_silent == DRIVE_SILENT_FAULT) {
    axis->bus_faults |= fault_bit(FAULT_MASTER_SILENT);
    return;
  }
  const bool off = objects->option.master_silent == DRIVE_SILENT_OFF;
  objects->controlword = off ? 0 : DRIVE_CONTROL_ENABLE_VOLTAGE;
  axis->left_alone = true;
  servo_node_raise_emergency(node, FAULT_MASTER_SILENT, (uint8_t)(i + 1), FAULT_MASTER_SILENT);
  fault_log_write(&node->log, i, FAULT_MASTER_SILENT, node->objects.ticks);
}

static void supervise_master(servo_node *node) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_node_axis *axis = &node->axis[i];
    if (axis->left_alone && axis->drive.state.action == DRIVE_RUN) {
      axis->left_alone = false;
      (void)canopen_node_clear(&node->canopen, (uint8_t)(i + 1), fault_table[FAULT_MASTER_SILENT].code);
    }
  }
  if (canopen_node_silent_ms(&node->canopen) < node->master.longest_silence_ms) {
    return;
  }
  for (int i = 0; i < SERVO_AXES; ++i) {
    if (drive_axis_turns(&node->axis[i].drive, &node->axis[i].inputs) && !node->axis[i].left_alone) {
      leave_alone(node, i);
    }
  }
}

static void guard_sets(servo_node *node) {
  guarded_sets_step(&node->guarded);
  for (int i = 0; i < SERVO_AXES && node->guarded.damaged != 0; ++i) {
    node->axis[i].bus_faults |= guarded_sets_damaged(&node->guarded, i) ? fault_bit(FAULT_ACTIVE_SET) : 0;
  }
}

static void show_envelope(protection_objects *objects, const axis_monitor *monitor) {
  objects->restrictions = monitor->restrictions;
  objects->turn = monitor->turn;
  objects->lowest_turn = monitor->candidates.lowest;
  objects->highest_turn = monitor->candidates.highest;
  objects->fastest_down_rad_s = axis_monitor_fastest_rad_s(monitor, -1.0f);
  objects->fastest_up_rad_s = axis_monitor_fastest_rad_s(monitor, 1.0f);
}

/* An axis that is told to stop stops its joint, as does one behind a brake that is not open. */
static void aim_base(servo_node *node, int i) {
  const drive_axis *drive = &node->axis[i].drive;
  const moving_base_axis axis = {
      .index = i,
      .fixed = axis_monitor_base_is_fixed(&node->axis[i].monitor),
      .follows = drive->state.action == DRIVE_RUN && drive->brake.opened && !drive->motion.ordered};
  moving_base_aim(&node->base, &node->board.app, &node->board.samples, &axis);
}

/* Faults that a wrong bus voltage can cause. */
static bool voltage_is_doubted(const servo_node *node) {
  const fault_set of_voltage = fault_bit(FAULT_CURRENT_SENSOR) | fault_bit(FAULT_UNDER_VOLTAGE) |
                               fault_bit(FAULT_OVER_VOLTAGE) | fault_bit(FAULT_MOTOR_CONTRADICTS) |
                               fault_bit(FAULT_MOTOR_WEAK);
  bool doubted = false;
  for (int i = 0; i < SERVO_AXES; ++i) {
    const drive_axis *drive = &node->axis[i].drive;
    doubted = doubted || (drive->state.power == DRIVE_FAULT && (of_voltage & fault_bit(drive->fault)) != 0);
  }
  return doubted;
}

/* What changes only with parameters, or slowly: a quarter of it in each ms, because all at once costs too much. */
static void limit_motion(servo_node *node) {
  const uint32_t turn = (node->objects.ticks - 1) % (2 * SERVO_AXES); /* each axis is located before it is limited */
  const int i = (int)(turn % SERVO_AXES);
  servo_node_axis *axis = &node->axis[i];
  if (turn < SERVO_AXES) {
    aim_base(node, i);
    axis_monitor_distrust(&axis->monitor, &axis->drive, voltage_is_doubted(node),
                          &node->board.app.axis[i].speed.rate_fusion);
    axis_monitor_locate(&axis->monitor, &axis->drive);
    axis->inputs.may_enable = !persisted_storage_writes(&node->storage) && axis_monitor_may_enable(&axis->monitor);
    return;
  }
  axis_monitor_limit(&axis->monitor);
  axis_monitor_inform_homing(&axis->monitor, &axis->inputs);
  axis->machine = axis_monitor_machine(&axis->monitor, &node->board.app.params.axis[i]);
  show_envelope(&axis->limits, &axis->monitor);
}

static void report_camera(servo_node *node) {
  const bool stale = tracking_is_stale(&node->tracking);
  if (stale && !node->camera_is_stale) {
    servo_node_report(node, FAULT_CAMERA_STALE, node->tracking.objects.last_drop, true);
  } else if (!stale && node->camera_is_stale) {
    (void)canopen_node_clear(&node->canopen, SOURCE_BOARD, fault_table[FAULT_CAMERA_STALE].code);
  }
  node->camera_is_stale = stale;
}

/* When the tick has taken the word before it. */
static void give_waiting_stop(servo_node_axis *axis) {
  if (axis->waiting.count > 0 && axis->objects.state.controlword == axis->drive.controlword) {
    axis->objects.state.controlword = waiting_stops_take(&axis->waiting);
  }
}

void servo_node_serve(servo_node *node) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    report_axis(node, i);
  }
  tracking_report(&node->tracking, &node->axis[SERVO_AZIMUTH].drive, &node->axis[SERVO_PITCH].drive,
                  node->objects.ticks);
  report_camera(node);
  tracking_prepare(&node->tracking, &node->board.app.params, azimuth_swing_kg_m2(node),
                   node->axis[SERVO_AZIMUTH].tuning.changes + node->axis[SERVO_PITCH].tuning.changes);
  node->objects.ticks++;
  node->objects.board_status = hal_status(node->board.machine);
  record(node);
  guard_sets(node);
  access_lock_tick(&node->lock);
  node->lock.powered = servo_node_any_axis_is_powered(node);
  if (!canopen_sdo_is_on(&node->canopen, 1)) {
    node->lock.client[1].ticks_left = 0; /* who switches the channel on may be another client */
  }
  canopen_node_serve(&node->canopen);
  supervise_master(node);
  moving_base_step(&node->base, &node->board.app, node->objects.ticks);
  limit_motion(node);
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_node_axis *axis = &node->axis[i];
    give_waiting_stop(axis);
    drive_axis_prepare(&axis->drive, &axis->objects, &axis->machine, SERVO_TICK_S);
  }
  if (persisted_storage_tick(&node->storage)) {
    node->cob_ids_collide = false;
    servo_node_take_word(node);
    servo_node_report_stored(node);
  }
}

/* An LSS master waits 20 ms, a client of 0x1010 0.3 s. */
void servo_node_background(servo_node *node) {
  if (!bus_settings_log_step(&node->objects.bus.log)) {
    persisted_storage_background(&node->storage);
  }
}

const object_dictionary *servo_node_dictionary(const servo_node *node) { return &node->canopen.dictionary; }

/* --- from outside ------------------------------------------------------------------------------------------------- */

bool servo_node_receive(servo_node *node, const can_frame *frame) {
  return canopen_node_receive(&node->canopen, frame);
}

void servo_node_bus_off(servo_node *node) {
  servo_node_command_fault(node, FAULT_BUS_OFF);
  access_lock_close_all(&node->lock);
}

void servo_node_report(servo_node *node, fault_id fault, uint8_t detail, bool lasts) {
  servo_node_raise_emergency(node, fault, SOURCE_BOARD, detail);
  if (!lasts) {
    (void)canopen_node_clear(&node->canopen, SOURCE_BOARD, fault_table[fault].code);
  }
  fault_log_write(&node->log, FAULT_LOG_BOARD, fault, node->objects.ticks);
}
