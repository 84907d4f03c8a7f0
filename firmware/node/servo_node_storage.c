/* SPDX-License-Identifier: Apache-2.0 */
#include "node/objects/drive_dictionary.h"
#include "node/schema_hash.h"
#include "node/servo_node_parts.h"
#include "parameters/axis_dictionary.h"

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
  kept->base = node->base.objects;
  return kept;
}

int servo_node_lost_parameters(const servo_node *node) {
  const persisted_report *report = &node->storage.report;
  return (report->damaged > 0 ? SET_DAMAGED : 0) + (report->unfinished > 0 ? SET_UNFINISHED : 0) +
         (report->refused > 0 ? SET_REFUSED : 0) + (node->cob_ids_collide ? COB_IDS_COLLIDE : 0) +
         (node->objects.bus.log.in_doubt ? BUS_SETTINGS_IN_DOUBT : 0);
}

void servo_node_report_stored(servo_node *node) {
  const persisted_report *report = &node->storage.report;
  for (int i = 0; i < SERVO_AXES; ++i) {
    node->axis[i].tuning.stored_crc = axis_parameters_crc(&node->storage.stored.parameters[i]);
  }
  node->objects.persisted_set = *report;
  const int detail = servo_node_lost_parameters(node);
  if (detail == 0) {
    (void)canopen_node_clear(&node->canopen, SOURCE_STORAGE, fault_table[FAULT_PARAMETERS_LOST].code);
    return;
  }
  servo_node_raise_emergency(node, FAULT_PARAMETERS_LOST, SOURCE_STORAGE, (uint8_t)detail);
}

/* The flash is not written while an axis has torque, or still turns since it had: protection may have to brake it. It
 * is never needed then, and its safety is not proven. */
bool servo_node_any_axis_moves(const servo_node *node) {
  bool moves = servo_node_any_axis_is_powered(node);
  for (int i = 0; i < SERVO_AXES; ++i) {
    moves = moves || node->axis[i].monitor.envelope.turns;
  }
  return moves;
}

/* An axis that is enabled meanwhile waits for the end; limit_motion permits it again. */
static od_abort write_storage(servo_node *node, persisted_command command) {
  command.powered = servo_node_any_axis_moves(node);
  const od_abort answer = persisted_storage_command(&node->storage, &command);
  for (int i = 0; i < SERVO_AXES; ++i) {
    drive_axis_inputs *inputs = &node->axis[i].inputs;
    inputs->may_enable = inputs->may_enable && !persisted_storage_writes(&node->storage);
  }
  return answer;
}

static od_abort storage_command_of(servo_node *node, bool saving, uint8_t group) {
  return write_storage(node, (persisted_command){.saving = saving, .group = group, .in_force = in_force(node)});
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

od_abort servo_node_save(void *context, uint8_t group) {
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
od_abort servo_node_restore(void *context, uint8_t group) {
  servo_node *node = context;
  const bool application = (retained_groups(group) & PERSISTED_APPLICATION) != 0;
  if (application && !persisted_objects_same_guarded(in_force(node), &node->storage.factory) &&
      guarded_change(&node->lock) != OD_OK) {
    return OD_DEVICE_STATE;
  }
  return storage_command_of(node, false, group);
}

/* --- the owner's word -------------------------------------------------------------------------------------------- */

od_abort servo_node_store_word(void *context, uint64_t hash) {
  servo_node *node = context;
  return write_storage(node, (persisted_command){.saving = true, .group = 0, .access_hash = hash});
}

void servo_node_take_word(servo_node *node) {
  const uint64_t hash = persisted_storage_access_hash(&node->storage);
  node->lock.hash = hash == node->waived_hash ? 0 : hash;
}

/* Values that both axes share. */
void servo_node_take_shared(servo_node *node, const persisted_objects *from) {
  node->scales = from->scales;
  hal_set_scales(node->board.machine, &node->scales);
  guarded_sets_take_scales(&node->guarded);
  od_copy_stored(&master_objects_table, &from->master, &node->master);
  od_copy_stored(&camera_objects_table, &from->camera, &node->tracking.objects);
  od_copy_stored(&base_objects_table, &from->base, &node->base.objects);
}

/* They have been checked. */
void servo_node_take_limits(servo_node_axis *axis, const protection_limits *limits) {
  axis->limits.written = *limits;
  axis->monitor.limits = *limits;
  axis->limits.changes++;
}

/* Gains, limits and drive objects from the stored parameters. */
void servo_node_take_stored(servo_node *node, int i) {
  servo_node_axis *axis = &node->axis[i];
  /* Cannot be refused: the stored values were in effect before, or were checked when they were found. */
  (void)axis_tuning_start(&axis->tuning, &node->storage.stored.parameters[i], &node->board.app.params.axis[i]);
  od_copy_stored(&drive_objects_table, &node->storage.stored.drive[i], &axis->objects);
  servo_node_take_limits(axis, &node->storage.stored.protection[i]);
}

/* The first reset, in which all objects have their defaults: 0x1011 restores these. */
void servo_node_start_storage(servo_node *node) {
  node->objects.schema_hash = schema_hash(&node->canopen.dictionary);
  persisted_storage_start(&node->storage, &node->canopen.dictionary, in_force(node), node->flash,
                          node->objects.schema_hash);
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_node_take_stored(node, i);
  }
  servo_node_take_shared(node, &node->storage.stored);
  node->waived_hash = node->recovering ? persisted_storage_access_hash(&node->storage) : 0;
  servo_node_take_word(node);
}
