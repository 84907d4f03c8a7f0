/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "canopen/node_objects.h"
#include "node/objects/clock_objects.h"
#include "node/objects/device_dictionary.h"
#include "node/objects/drive_dictionary.h"
#include "node/scope_signals.h"
#include "node/servo_node_parts.h"
#include "node/shared_dictionary.h"
#include "parameters/axis_dictionary.h"

enum { FIRST_AXIS_INDEX = 0x2000, FIRST_SHARED_INDEX = 0x3000 };

_Static_assert(FIRST_AXIS_INDEX + SERVO_AXES * AXIS_INDEX_SHIFT <= FIRST_SHARED_INDEX,
               "a third axis has no room for its parameters: docs/decisions/dictionary.md");

/* --- what the bus tells ------------------------------------------------------------------------------------------ */

static void heartbeat_lost(void *context, uint8_t node_id) {
  (void)node_id;
  servo_node_command_fault(context, FAULT_HEARTBEAT_LOST);
}

static void rpdo_late(void *context, uint32_t n) {
  (void)n;
  servo_node_command_fault(context, FAULT_RPDO_LATE);
}

static void state_changed(void *context, nmt_state state) {
  if (state == NMT_STOPPED) {
    servo_node_command_fault(context, FAULT_NODE_STOPPED);
  }
}

/* --- LSS ---------------------------------------------------------------------------------------------------------- */

static bool has_torque(void *context) { return servo_node_any_axis_moves(context); }

static lss_store_progress store_bus(void *context, const bus_settings *settings) {
  servo_node *node = context;
  const lss_store_progress progress = bus_objects_store(&node->objects.bus, settings);
  if (progress == LSS_STORE_DONE) {
    servo_node_report_stored(node);
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
                               .hooks = &experiment_objects_hooks,
                               .has_commands = true};
    parts[count++] =
        (od_part){.table = recorded_tick_table, .shift = shift, .prefix = prefixes[i], .values = &axis->recorded};
    parts[count++] = (od_part){.table = drive_objects_table,
                               .shift = shift,
                               .prefix = prefixes[i],
                               .values = &axis->objects,
                               .owner = axis,
                               .hooks = &servo_node_drive_hooks,
                               .has_commands = true,
                               .defaults = &factory->drive[i]};
  }
  parts[count++] = (od_part){.table = scope_objects_table,
                             .prefix = "",
                             .values = &node->scope_setup,
                             .owner = node,
                             .hooks = &scope_objects_hooks,
                             .has_commands = true};
  parts[count++] = (od_part){.table = scope_signals_table, .prefix = "", .values = node};
  node->fault_owner = (fault_objects_owner){&node->fault_setup, &node->log};
  parts[count++] = (od_part){.table = fault_objects_table,
                             .prefix = "",
                             .values = &node->fault_setup,
                             .owner = &node->fault_owner,
                             .hooks = &fault_objects_hooks,
                             .has_commands = true};
  parts[count++] = (od_part){.table = shared_table, .prefix = "", .values = &node->objects};
  parts[count++] = (od_part){.table = board_objects_table,
                             .prefix = "",
                             .values = &node->scales,
                             .owner = node,
                             .hooks = &servo_node_board_hooks,
                             .defaults = &factory->scales};
  node->master_part = (master_owner){&node->master, &node->lock, servo_node_store_word, node};
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
  parts[count++] = (od_part){.table = base_objects_table,
                             .prefix = "",
                             .values = &node->base.objects,
                             .owner = &node->base,
                             .hooks = &moving_base_hooks,
                             .measures = true};
  parts[count++] = (od_part){.table = clock_objects_table,
                             .prefix = "",
                             .values = &node->clock,
                             .owner = node,
                             .hooks = &servo_node_clock_hooks};
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
    servo_node_take_limits(axis, &config->limits[i]);
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
  /* Bound: CANOPEN_HARDWARE_VERSION. */
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
  od_part parts[CANOPEN_PARTS];
  const uint32_t count = describe_parts(node, parts);
  /* Bound: CANOPEN_PARTS: what describe_parts has counted. */
  for (uint32_t i = 0; i < count; ++i) {
    od_restore_defaults(&parts[i], config->node_id); /* gains and limits as configured follow with the first reset */
  }
  if (config->scales != NULL) {
    node->scales = *config->scales;
  }
  if (board_objects_check(&node->scales) != CONTROL_OK) {
    return false;
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
      .storage = {.save = servo_node_save, .restore = servo_node_restore, .context = node},
      .lss = {.has_torque = has_torque, .store = store_bus, .activate = activate_bit_rate, .context = node},
      .events = {.reset_begins = servo_node_reset_begins,
                 .reset = servo_node_reset,
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
