#include "node/servo_node.h"

#include <string.h>

#include "canopen/emergency.h"
#include "canopen/node_objects.h"
#include "node/objects/clock_objects.h"
#include "node/objects/device_dictionary.h"
#include "node/objects/drive_dictionary.h"
#include "node/schema_hash.h"
#include "node/scope_signals.h"
#include "node/shared_dictionary.h"
#include "parameters/axis_dictionary.h"

enum { FIRST_AXIS_INDEX = 0x2000, FIRST_SHARED_INDEX = 0x3000 };

_Static_assert(FIRST_AXIS_INDEX + SERVO_AXES * AXIS_INDEX_SHIFT <= FIRST_SHARED_INDEX,
               "a third axis has no room for its parameters: docs/decisions/0025-one-parameter-list.md");

/* Details of FAULT_PARAMETERS_LOST, as a sum. */
enum { SET_DAMAGED = 1, SET_UNFINISHED = 2, SET_REFUSED = 4, COB_IDS_COLLIDE = 8, BUS_SETTINGS_IN_DOUBT = 16 };

/* Of EMCY messages; the source of an axis is its number + 1. */
enum { SOURCE_BOARD = SERVO_AXES + 1, SOURCE_STORAGE = SERVO_AXES + 2 };

/* --- objects of the drive --------------------------------------------------------------------------------------- */

static bool is_option(uint16_t index) { return index >= 0x605A && index <= 0x605E; }

static bool is_setpoint(uint16_t index) { return index == 0x607A || index == 0x60FF || index == 0x6071; }

static bool is_home(uint16_t index) { return index == 0x607C; }

static bool is_period(uint16_t index) { return index == 0x60C2; }

static bool period_is_supported(const drive_limit_objects *limit, uint8_t sub, od_number value) {
  const uint8_t period = sub == 1 ? (uint8_t)value.i : limit->interpolation_period;
  const int8_t exponent = sub == 1 ? limit->interpolation_exponent : (int8_t)value.i;
  return interpolation_ticks(period, exponent, SERVO_TICK_S) != 0;
}

/* Where the operator has seen the axis: one of the possible turns. Its position must not jump under power without a
 * command of the master, so the axes are off, and homing confirms it later. */
static od_abort accept_home(const servo_node_axis *axis, int64_t position) {
  const od_abort guarded = guarded_change(axis->limits_owner.lock);
  const bool possible = axis_monitor_may_see(&axis->monitor, &axis->drive, (int32_t)position);
  return guarded != OD_OK || possible ? guarded : OD_BAD_VALUE;
}

static od_abort accept_drive(void *owner, const od_object *object, od_number value) {
  const servo_node_axis *axis = owner;
  const drive_limit_objects *limit = &axis->objects.limit;
  const uint16_t index = object->entry->index;
  if (is_period(index) && !period_is_supported(limit, object->entry->sub, value)) {
    return OD_BAD_VALUE;
  }
  if (is_option(index) && !drive_option_supported(index, (int16_t)value.i)) {
    return OD_BAD_VALUE;
  }
  if (is_home(index)) {
    return accept_home(axis, value.i);
  }
  if (index == 0x60F2 && !setpoint_option_supported((uint16_t)value.i)) {
    return OD_BAD_VALUE;
  }
  if (index == 0x6098 && !homing_method_supported((int8_t)value.i)) {
    return OD_BAD_VALUE;
  }
  if (index == 0x6060 && value.i != DRIVE_NO_MODE && !drive_mode_supported((int8_t)value.i)) {
    return OD_BAD_VALUE;
  }
  return OD_OK;
}

/* Whatever ends operation, or halts in it. */
static bool stops_drive(const od_object *object, od_number value) {
  const uint32_t running = DRIVE_CONTROL_SWITCH_ON | DRIVE_CONTROL_ENABLE_VOLTAGE | DRIVE_CONTROL_NO_QUICK_STOP |
                           DRIVE_CONTROL_ENABLE_OPERATION;
  return object->entry->index == 0x6040 && ((uint32_t)value.i & (running | DRIVE_CONTROL_HALT)) != running;
}

/* Every controlword takes effect in a tick of its own, or a stop could be lost between two ticks. */
static bool drive_waits(void *owner, const od_object *object) {
  const servo_node_axis *axis = owner;
  return object->entry->index == 0x6040 && axis->objects.state.controlword != axis->drive.controlword;
}

/* A set-point counts as new even when its value is the old one. */
static void changed_drive(void *owner, const od_object *object) {
  servo_node_axis *axis = owner;
  axis->setpoint_arrived = axis->setpoint_arrived || is_setpoint(object->entry->index);
  if (is_home(object->entry->index)) {
    axis_monitor_see(&axis->monitor, &axis->drive, axis->objects.homing.offset);
  }
}

static unsigned needed_by_drive(const od_object *object) {
  const uint16_t index = object->entry->index;
  const bool checked =
      is_option(index) || is_period(index) || is_home(index) || index == 0x6060 || index == 0x6098 || index == 0x60F2;
  return (checked ? OD_HOOK_ACCEPT : 0u) | (index == 0x6040 ? OD_HOOK_WAITS : 0u) |
         (is_setpoint(index) || is_home(index) ? OD_HOOK_CHANGED : 0u);
}

static const od_hooks drive_hooks = {.accept = accept_drive,
                                     .changed = changed_drive,
                                     .stops = stops_drive,
                                     .waits = drive_waits,
                                     .needed = needed_by_drive};

/* --- objects of the board --- */

static bool any_axis_is_powered(const servo_node *node) {
  bool powered = false;
  for (int i = 0; i < SERVO_AXES; ++i) {
    powered = powered || node->axis[i].drive.state.action != DRIVE_OFF;
  }
  return powered;
}

/* Changing the scale of a flowing current would look like a current step; guarded_write wants the axes off. */
static od_abort accept_board(void *owner, const od_object *object, od_number value) {
  (void)value;
  return guarded_write(&((const servo_node *)owner)->lock, object->entry);
}

static void changed_board(void *owner, const od_object *object) {
  (void)object;
  servo_node *node = owner;
  hal_set_scales(node->board.machine, &node->scales);
  guarded_sets_take_scales(&node->guarded);
}

static const od_hooks board_hooks = {.accept = accept_board, .changed = changed_board};

/* --- the clock on the bus --- */

static od_abort refresh_clock(void *owner, const od_object *object) {
  (void)object;
  servo_node *node = owner;
  node->clock.time_us = hal_clock_us(node->board.machine) + node->tracking.clock.offset_us;
  return OD_OK;
}

/* The value is that of the instant at which its frame began. A synchronous PDO's frame is the SYNC. */
static void changed_clock(void *owner, const od_object *object) {
  (void)object;
  servo_node *node = owner;
  const uint32_t now_us = hal_clock_us(node->board.machine);
  const uint16_t waited_us = (uint16_t)(now_us - node->canopen.received_us);
  exposure_clock_set(&node->tracking.clock, node->clock.time_us, now_us - waited_us);
}

static const od_hooks clock_hooks = {.refresh = refresh_clock, .changed = changed_clock};

/* A fault of both axes in the next tick. */
static void command_fault(servo_node *node, fault_id fault) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    node->axis[i].bus_faults |= fault_bit(fault);
  }
}

/* --- storage and bus events ------------------------------------------------------------------------------------- */

/* The values in effect now, as a set to persist; too large for the stack. */
static persisted_objects *in_force(servo_node *node) {
  persisted_objects *kept = &node->in_force;
  kept->communication = node->canopen.objects;
  kept->bus = canopen_node_settings(&node->canopen);
  for (int i = 0; i < SERVO_AXES; ++i) {
    kept->parameters[i] = node->axis[i].tuning.active;
    kept->drive[i] = node->axis[i].objects;
    kept->protection[i] = node->axis[i].monitor.limits;
  }
  kept->scales = node->scales;
  kept->master = node->master;
  kept->camera = node->tracking.objects;
  return kept;
}

/* EMCY of a row of the fault table. */
static emergency_error error_of(fault_id fault, uint8_t source, uint8_t detail) {
  const fault_row *row = &fault_table[fault];
  return (emergency_error){.code = row->code, .register_bits = row->register_bits, .source = source, .detail = detail};
}

static void raise_emergency(servo_node *node, fault_id fault, uint8_t source, uint8_t detail) {
  const emergency_error error = error_of(fault, source, detail);
  (void)canopen_node_raise(&node->canopen, &error);
}

/* The detail of FAULT_PARAMETERS_LOST; 0: what is stored was found. */
static int lost_parameters(const servo_node *node) {
  const persisted_report *report = &node->storage.report;
  return (report->damaged > 0 ? SET_DAMAGED : 0) + (report->unfinished > 0 ? SET_UNFINISHED : 0) +
         (report->refused > 0 ? SET_REFUSED : 0) + (node->cob_ids_collide ? COB_IDS_COLLIDE : 0) +
         (node->objects.bus.log.in_doubt ? BUS_SETTINGS_IN_DOUBT : 0);
}

/* 0x2070:5, 0x3031, and EMCY while what is damaged, cut off or refused has not been replaced by a good save. */
static void report_stored(servo_node *node) {
  const persisted_report *report = &node->storage.report;
  for (int i = 0; i < SERVO_AXES; ++i) {
    node->axis[i].tuning.stored_crc = axis_parameters_crc(&node->storage.stored.parameters[i]);
  }
  node->objects.persisted_set = *report;
  const int detail = lost_parameters(node);
  if (detail == 0) {
    (void)canopen_node_clear(&node->canopen, SOURCE_STORAGE, fault_table[FAULT_PARAMETERS_LOST].code);
    return;
  }
  raise_emergency(node, FAULT_PARAMETERS_LOST, SOURCE_STORAGE, (uint8_t)detail);
}

/* A save is not started while an axis has torque: it is never needed then, and its safety is not proven. */
static od_abort storage_command_of(servo_node *node, bool saving, uint8_t group) {
  return persisted_storage_command(
      &node->storage,
      &(persisted_command){
          .saving = saving, .group = group, .powered = any_axis_is_powered(node), .in_force = in_force(node)});
}

/* Values that wait cannot be stored, and storing only the rest without an error would be wrong. */
static bool any_limits_wait(const servo_node *node) {
  bool wait = false;
  for (int i = 0; i < SERVO_AXES; ++i) {
    wait = wait || protection_objects_waiting(&node->axis[i].limits_owner) != 0;
  }
  return wait;
}

/* What is stored starts without a check: gains that were never found stable need the lock for that, too. */
static bool any_gains_are_unchecked(const servo_node *node) {
  bool unchecked = false;
  for (int i = 0; i < SERVO_AXES; ++i) {
    unchecked = unchecked || node->axis[i].tuning.overridden;
  }
  return unchecked;
}

static od_abort save(void *context, uint8_t group) {
  servo_node *node = context;
  if ((retained_groups(group) & PERSISTED_APPLICATION) != 0 && any_gains_are_unchecked(node) &&
      !access_lock_is_open(&node->lock)) {
    return OD_DEVICE_STATE;
  }
  if ((retained_groups(group) & PERSISTED_APPLICATION) != 0 && any_limits_wait(node)) {
    return OD_INCOMPATIBLE;
  }
  return storage_command_of(node, true, group);
}

/* Defaults of guarded values come into force by the next reset, so they need the lock as a write does. */
static od_abort restore(void *context, uint8_t group) {
  servo_node *node = context;
  const bool application = (retained_groups(group) & PERSISTED_APPLICATION) != 0;
  if (application && node->storage.progress == PERSISTED_IDLE &&
      !persisted_objects_same_guarded(in_force(node), &node->storage.factory) && guarded_change(&node->lock) != OD_OK) {
    return OD_DEVICE_STATE;
  }
  return storage_command_of(node, false, group);
}

/* --- the owner's word -------------------------------------------------------------------------------------------- */

static od_abort store_word(void *context, uint64_t hash) {
  servo_node *node = context;
  return persisted_storage_command(
      &node->storage,
      &(persisted_command){.saving = true, .group = 0, .access_hash = hash, .powered = any_axis_is_powered(node)});
}

static void take_word(servo_node *node) {
  const uint64_t hash = persisted_storage_access_hash(&node->storage);
  node->lock.hash = hash == node->waived_hash ? 0 : hash;
}

/* Values that both axes share. */
static void take_shared(servo_node *node, const persisted_objects *from) {
  node->scales = from->scales;
  hal_set_scales(node->board.machine, &node->scales);
  guarded_sets_take_scales(&node->guarded);
  od_copy_stored(&master_objects_table, &from->master, &node->master);
  od_copy_stored(&camera_objects_table, &from->camera, &node->tracking.objects);
}

/* They have been checked. */
static void take_limits(servo_node_axis *axis, const protection_limits *limits) {
  axis->limits.written = *limits;
  axis->monitor.limits = *limits;
  axis->limits.changes++;
}

/* Gains, limits and drive objects from the stored parameters. */
static void take_stored(servo_node *node, int i) {
  servo_node_axis *axis = &node->axis[i];
  /* Cannot be refused: the stored values were in effect before, or were checked when they were found. */
  (void)axis_tuning_start(&axis->tuning, &node->storage.stored.parameters[i], &node->board.app.params.axis[i]);
  od_copy_stored(&drive_objects_table, &node->storage.stored.drive[i], &axis->objects);
  take_limits(axis, &node->storage.stored.protection[i]);
}

/* The first reset, in which all objects have their defaults: 0x1011 restores these. */
static void start_storage(servo_node *node) {
  node->objects.schema_hash = schema_hash(&node->canopen.dictionary);
  persisted_storage_start(&node->storage, &node->canopen.dictionary, in_force(node), node->flash,
                          node->objects.schema_hash);
  for (int i = 0; i < SERVO_AXES; ++i) {
    take_stored(node, i);
  }
  take_shared(node, &node->storage.stored);
  node->waived_hash = node->recovering ? persisted_storage_access_hash(&node->storage) : 0;
  take_word(node);
}

/* --- reset: off at once, then one piece per ms ------------------------------------------------------------------- */

/* Without torque and without a set-point; the drive stays "not ready" until the reset has ended. */
static void switch_off(servo_node *node, int i) {
  servo_node_axis *axis = &node->axis[i];
  experiment_abort(&axis->experiment.running, EXPERIMENT_DRIVE_STOPPED);
  axis_monitor_reset(&axis->monitor);
  drive_axis_restart(&axis->drive, node->board.samples.axis[i].sensors.joint_angle_turn32);
}

/* A reset of the communication removes the supervision of the axes: like an NMT stop, it stops those that turn. */
static void reset_begins(void *context, bool whole_node) {
  servo_node *node = context;
  if (!node->started) {
    return;
  }
  if (!whole_node && any_axis_is_powered(node)) {
    command_fault(node, FAULT_NODE_STOPPED);
  }
  access_lock_close_all(&node->lock);
  for (int i = 0; i < SERVO_AXES && whole_node; ++i) {
    switch_off(node, i);
  }
}

/* Every part with commands gets its defaults; gains come from the stored parameters. */
static void restore_part(servo_node *node, const od_part *part) {
  if (part->hooks == &drive_hooks || part->hooks == &experiment_objects_hooks || part->hooks == &scope_objects_hooks ||
      part->hooks == &fault_objects_hooks) {
    od_restore_defaults(part, node->canopen.config.node_id);
  }
}

static void reset_application(servo_node *node, uint32_t step) {
  const uint32_t part_count = node->canopen.dictionary.count;
  if (step < part_count) {
    restore_part(node, &node->canopen.dictionary.parts[step]);
  } else {
    take_stored(node, (int)(step - part_count));
    take_shared(node, &node->storage.stored);
  }
}

static void take_communication(servo_node *node, const persisted_objects *from) {
  const bus_settings now = canopen_node_settings(&node->canopen);
  persisted_communication_copy(&node->canopen.objects, &from->communication);
  persisted_communication_follow(&node->canopen.objects, &from->bus, &now);
}

/* With defaults for the node id and bit rate in effect now. A COB-ID that was set can meet a default one of a new node
 * id: then all have their defaults, because one of the two services would receive nothing. */
static void take_stored_communication(servo_node *node) {
  take_communication(node, &node->storage.stored);
  node->cob_ids_collide = node_objects_receivers_collide(&node->canopen.objects);
  if (node->cob_ids_collide) {
    take_communication(node, &node->storage.factory);
  }
  node->objects.bus.in_force = node->canopen.lss.active;
}

static bool reset(void *context, bool whole_node, uint32_t step) {
  servo_node *node = context;
  const uint32_t application_steps = whole_node && node->started ? node->canopen.dictionary.count + SERVO_AXES : 0;
  if (step < application_steps) {
    reset_application(node, step);
    return false;
  }
  if (step == application_steps) {
    if (!node->started) {
      start_storage(node);
    }
    take_stored_communication(node);
    return false;
  }
  for (int i = 0; i < SERVO_AXES; ++i) {
    node->axis[i].left_alone = false;
    node->axis[i].tuning.command = whole_node ? 0 : node->axis[i].tuning.command;
    node->axis[i].reports = (fault_reports){0}; /* the bus has lost its reports: a fault that lasts is reported again */
  }
  if (whole_node) {
    tracking_forget(&node->tracking);
  }
  node->camera_is_stale = false;
  report_stored(node);
  if ((whole_node || !node->started) && (lost_parameters(node) & ~COB_IDS_COLLIDE) != 0) {
    command_fault(node, FAULT_PARAMETERS_LOST); /* older limits may be wrong: somebody must acknowledge it */
  }
  return true;
}

static void heartbeat_lost(void *context, uint8_t node_id) {
  (void)node_id;
  command_fault(context, FAULT_HEARTBEAT_LOST);
}

static void rpdo_late(void *context, uint32_t n) {
  (void)n;
  command_fault(context, FAULT_RPDO_LATE);
}

static void state_changed(void *context, nmt_state state) {
  if (state == NMT_STOPPED) {
    command_fault(context, FAULT_NODE_STOPPED);
  }
}

/* --- LSS ---------------------------------------------------------------------------------------------------------- */

static bool has_torque(void *context) { return any_axis_is_powered(context); }

static lss_store_progress store_bus(void *context, const bus_settings *settings) {
  servo_node *node = context;
  const lss_store_progress progress = bus_objects_store(&node->objects.bus, settings);
  if (progress == LSS_STORE_DONE) {
    report_stored(node);
  }
  return progress;
}

static void activate_bit_rate(void *context, uint16_t kbit_s) {
  servo_node *node = context;
  canopen_node_set_bit_rate(&node->canopen, kbit_s);
  bus_objects_join(&node->objects.bus, kbit_s);
}

/* --- start ------------------------------------------------------------------------------------------------------ */

static void start_bus(servo_node *node, const servo_node_config *config) {
  const uint16_t kbit_s = config->bus.kbit_s == 0 ? BUS_DEFAULT_KBIT_S : config->bus.kbit_s;
  const bus_settings defaults = {.node_id = config->node_id, .kbit_s = kbit_s};
  bus_objects_start(&node->objects.bus, &defaults, config->bus.recovering, config->bus.flash, &config->bus.joiner);
}

/* Parts of the application, in the order of their indices. */
static uint32_t describe_parts(servo_node *node, od_part *parts) {
  static const char *const prefixes[SERVO_AXES] = {"Azimuth ", "Pitch "};
  const persisted_objects *factory = &node->storage.factory;
  uint32_t count = 0;
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_node_axis *axis = &node->axis[i];
    const uint16_t shift = (uint16_t)(i * AXIS_INDEX_SHIFT);
    axis->owner = (tuning_owner){&axis->tuning, &node->board, i, &node->lock};
    axis->limits_owner = (protection_owner){&axis->limits, &axis->monitor.limits, &axis->monitor.start,
                                            &axis->objects.limit, &node->lock};
    parts[count++] = (od_part){.table = axis_parameters_table,
                               .shift = shift,
                               .prefix = prefixes[i],
                               .values = &axis->tuning,
                               .owner = &axis->owner,
                               .hooks = &tuning_objects_hooks,
                               .defaults = &factory->parameters[i]};
    parts[count++] = (od_part){.table = protection_objects_table,
                               .shift = shift,
                               .prefix = prefixes[i],
                               .values = &axis->limits,
                               .owner = &axis->limits_owner,
                               .hooks = &protection_objects_hooks,
                               .defaults = &factory->protection[i]};
    parts[count++] = (od_part){.table = experiment_objects_table,
                               .shift = shift,
                               .prefix = prefixes[i],
                               .values = &axis->experiment,
                               .owner = axis,
                               .hooks = &experiment_objects_hooks};
    parts[count++] =
        (od_part){.table = recorded_tick_table, .shift = shift, .prefix = prefixes[i], .values = &axis->recorded};
    parts[count++] = (od_part){.table = drive_objects_table,
                               .shift = shift,
                               .prefix = prefixes[i],
                               .values = &axis->objects,
                               .owner = axis,
                               .hooks = &drive_hooks,
                               .defaults = &factory->drive[i]};
  }
  parts[count++] = (od_part){.table = scope_objects_table,
                             .prefix = "",
                             .values = &node->scope_setup,
                             .owner = node,
                             .hooks = &scope_objects_hooks};
  parts[count++] = (od_part){.table = scope_signals_table, .prefix = "", .values = node};
  node->fault_owner = (fault_objects_owner){&node->fault_setup, &node->log};
  parts[count++] = (od_part){.table = fault_objects_table,
                             .prefix = "",
                             .values = &node->fault_setup,
                             .owner = &node->fault_owner,
                             .hooks = &fault_objects_hooks};
  parts[count++] = (od_part){.table = shared_table, .prefix = "", .values = &node->objects};
  parts[count++] = (od_part){.table = board_objects_table,
                             .prefix = "",
                             .values = &node->scales,
                             .owner = node,
                             .hooks = &board_hooks,
                             .defaults = &factory->scales};
  node->master_part = (master_owner){&node->master, &node->lock, store_word, node};
  parts[count++] = (od_part){.table = master_objects_table,
                             .prefix = "",
                             .values = &node->master,
                             .owner = &node->master_part,
                             .hooks = &master_objects_hooks};
  parts[count++] = (od_part){.table = camera_objects_table,
                             .prefix = "",
                             .values = &node->tracking.objects,
                             .owner = &node->tracking,
                             .hooks = &tracking_hooks};
  parts[count++] = (od_part){
      .table = clock_objects_table, .prefix = "", .values = &node->clock, .owner = node, .hooks = &clock_hooks};
  return count;
}

static bool start_servo(servo_node *node, const servo_node_config *config) {
  servo_params params;
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_node_axis *axis = &node->axis[i];
    axis->tuning.gains_follow = i == SERVO_AZIMUTH;
    if (axis_tuning_start(&axis->tuning, &config->parameters[i], &params.axis[i]) != CONTROL_OK ||
        protection_check(&config->limits[i]) != CONTROL_OK) {
      return false;
    }
    take_limits(axis, &config->limits[i]);
  }
  return servo_board_start(&node->board, config->machine, &params) == CONTROL_OK;
}

/* Before the first reset, so that 0x1011 restores these values. */
static void limit_travel(servo_node_axis *axis) {
  const drive_travel travel = axis_monitor_default_travel(&axis->monitor);
  axis->objects.limit.position_minimum = travel.minimum;
  axis->objects.limit.position_maximum = travel.maximum;
}

static void name_hardware(char *name, const char *text) {
  for (uint32_t i = 0; text != NULL && i < CANOPEN_HARDWARE_VERSION && text[i] != '\0'; ++i) {
    name[i] = text[i];
  }
}

static bool start_guard(servo_node *node) {
  guarded_axis axes[SERVO_AXES];
  for (int i = 0; i < SERVO_AXES; ++i) {
    const servo_node_axis *axis = &node->axis[i];
    axes[i] = (guarded_axis){.built = &node->board.app.params.axis[i],
                             .tuning = &axis->tuning,
                             .objects = &axis->limits,
                             .limits = &axis->monitor.limits};
  }
  return guarded_sets_start(&node->guarded, axes, &node->scales);
}

bool servo_node_start(servo_node *node, const servo_node_config *config) {
  memset(node, 0, sizeof *node);
  scope_reset(&node->recorder);
  if (!start_servo(node, config)) {
    return false;
  }
  tracking_start(&node->tracking, config->machine);
  node->flash = config->flash;
  node->recovering = config->bus.recovering;
  node->canopen.sdo_client = SDO_CHANNELS;
  node->lock = (access_lock){.caller = &node->canopen.sdo_client, .salt = config->serial_number};
  const od_part board_part = {.table = board_objects_table, .values = &node->scales};
  od_restore_defaults(&board_part, config->node_id);
  if (config->scales != NULL) {
    node->scales = *config->scales;
  }
  if (board_objects_check(&node->scales) != CONTROL_OK) {
    return false;
  }
  od_part parts[CANOPEN_PARTS];
  const uint32_t count = describe_parts(node, parts);
  for (uint32_t i = 0; i < count; ++i) {
    if (parts[i].hooks != &tuning_objects_hooks && parts[i].hooks != &protection_objects_hooks &&
        parts[i].hooks != &board_hooks) { /* configured */
      od_restore_defaults(&parts[i], config->node_id);
    }
  }
  for (int i = 0; i < SERVO_AXES; ++i) {
    limit_travel(&node->axis[i]);
  }
  start_bus(node, config);
  const canopen_config canopen = {
      .node_id = node->objects.bus.in_force.node_id,
      .kbit_s = node->objects.bus.in_force.kbit_s,
      .device_table = &device_table,
      .parts = parts,
      .part_count = count,
      .sender = config->sender,
      .process_data = node->process_data,
      .services = node->services,
      .queue_capacity = SERVO_NODE_QUEUE,
      .storage = {.save = save, .restore = restore, .context = node},
      .lss = {.has_torque = has_torque, .store = store_bus, .activate = activate_bit_rate, .context = node},
      .events = {.reset_begins = reset_begins,
                 .reset = reset,
                 .heartbeat_lost = heartbeat_lost,
                 .rpdo_late = rpdo_late,
                 .state_changed = state_changed},
      .context = node,
  };
  if (!canopen_node_init(&node->canopen, &canopen)) {
    return false;
  }
  node->canopen.objects.serial_number = config->serial_number;
  name_hardware(node->canopen.objects.hardware_version, config->hardware_version);
  bus_objects_join(&node->objects.bus, node->canopen.config.kbit_s);
  node->started = true;
  return start_guard(node);
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
  tracking_take(&node->tracking, &node->board, tracking_axes, changes);
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
    const emergency_error error = error_of(item.reported, source, (uint8_t)item.reported);
    (void)canopen_node_raise_again(&node->canopen, &error);
    fault_log_write(&node->log, i, item.reported, node->objects.ticks);
  }
}

/* For 0x2101, and for the scope, which triggers on any power state and any fault. */
static void record(servo_node *node) {
  uint32_t states = 0;
  bool fault = false;
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_node_axis *axis = &node->axis[i];
    recorded_tick_take(&axis->recorded, &node->board, i, &axis->experiment, axis->inputs.stimulus != NULL,
                       node->objects.ticks);
    const drive_power_state power = axis->drive.state.power;
    states = states << 8 | (uint32_t)power;
    fault = fault || power == DRIVE_FAULT || power == DRIVE_FAULT_REACTION_ACTIVE;
  }
  scope_step(&node->recorder, states, fault);
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
  raise_emergency(node, FAULT_GAINS_TAKEN_BACK, source, (uint8_t)FAULT_GAINS_TAKEN_BACK);
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
  raise_emergency(node, FAULT_MASTER_SILENT, (uint8_t)(i + 1), FAULT_MASTER_SILENT);
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

/* What changes only with parameters, or slowly: a quarter of it in each ms, because all at once costs too much. */
static void limit_motion(servo_node *node) {
  const uint32_t turn = (node->objects.ticks - 1) % (2 * SERVO_AXES); /* each axis is located before it is limited */
  const int i = (int)(turn % SERVO_AXES);
  servo_node_axis *axis = &node->axis[i];
  if (turn < SERVO_AXES) {
    axis_monitor_distrust(&axis->monitor, &axis->drive);
    axis_monitor_locate(&axis->monitor, &axis->drive);
    return;
  }
  axis_monitor_limit(&axis->monitor);
  axis->inputs.may_enable = axis_monitor_may_enable(&axis->monitor);
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
  node->lock.powered = any_axis_is_powered(node);
  if (!node_objects_sdo_is_on(&node->canopen.objects, 1)) {
    node->lock.client[1].ticks_left = 0; /* who switches the channel on may be another client */
  }
  canopen_node_serve(&node->canopen);
  supervise_master(node);
  limit_motion(node);
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_node_axis *axis = &node->axis[i];
    drive_axis_prepare(&axis->drive, &axis->objects, &axis->machine, SERVO_TICK_S);
  }
  if (persisted_storage_tick(&node->storage)) {
    node->cob_ids_collide = false;
    take_word(node);
    report_stored(node);
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
  command_fault(node, FAULT_BUS_OFF);
  access_lock_close_all(&node->lock);
}

void servo_node_report(servo_node *node, fault_id fault, uint8_t detail, bool lasts) {
  raise_emergency(node, fault, SOURCE_BOARD, detail);
  if (!lasts) {
    (void)canopen_node_clear(&node->canopen, SOURCE_BOARD, fault_table[fault].code);
  }
  fault_log_write(&node->log, FAULT_LOG_BOARD, fault, node->objects.ticks);
}
