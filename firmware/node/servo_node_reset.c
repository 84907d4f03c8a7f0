/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/node_objects.h"
#include "node/servo_node_parts.h"

static bool is_braked(const servo_node_axis *axis) {
  return axis->drive.state.action == DRIVE_BRAKE || axis->drive.state.action == DRIVE_PROTECTIVE_STOP;
}

/* Without torque and without a set-point; the drive stays "not ready" until the reset has ended. An axis that a fault
 * brakes is braked to the end, and keeps the fault. */
static void switch_off(servo_node *node, int i) {
  servo_node_axis *axis = &node->axis[i];
  experiment_abort(&axis->experiment.running, EXPERIMENT_DRIVE_STOPPED);
  if (is_braked(axis)) {
    return;
  }
  axis_monitor_reset(&axis->monitor);
  drive_axis_restart(&axis->drive, node->board.samples.axis[i].sensors.joint_angle_turn32);
}

/* A reset of the communication removes the supervision of the axes: like an NMT stop, it stops those that turn. */
void servo_node_reset_begins(void *context, bool whole_node) {
  servo_node *node = context;
  if (!node->started) {
    return;
  }
  if (!whole_node && servo_node_any_axis_is_powered(node)) {
    servo_node_command_fault(node, FAULT_NODE_STOPPED);
  }
  access_lock_close_all(&node->lock);
  for (int i = 0; i < SERVO_AXES && whole_node; ++i) {
    switch_off(node, i);
  }
}

/* Every part with commands gets its defaults; gains come from the stored parameters. */
static void restore_part(servo_node *node, const od_part *part) {
  if (part->has_commands) {
    od_restore_defaults(part, node->canopen.config.node_id);
  }
}

static void reset_application(servo_node *node, uint32_t step) {
  const uint32_t part_count = node->canopen.dictionary.count;
  if (step < part_count) {
    restore_part(node, &node->canopen.dictionary.parts[step]);
  } else {
    servo_node_take_stored(node, (int)(step - part_count));
    servo_node_take_shared(node, &node->storage.stored);
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

bool servo_node_reset(void *context, bool whole_node, uint32_t step) {
  servo_node *node = context;
  const uint32_t application_steps = whole_node && node->started ? node->canopen.dictionary.count + SERVO_AXES : 0;
  if (step < application_steps) {
    reset_application(node, step);
    return false;
  }
  if (step == application_steps) {
    if (!node->started) {
      servo_node_start_storage(node);
    }
    take_stored_communication(node);
    return false;
  }
  for (int i = 0; i < SERVO_AXES; ++i) {
    node->axis[i].left_alone = false;
    node->axis[i].waiting = (waiting_stops){0};
    node->axis[i].tuning.command = whole_node ? 0 : node->axis[i].tuning.command;
    node->axis[i].reports = (fault_reports){0}; /* the bus has lost its reports: a fault that lasts is reported again */
  }
  if (whole_node) {
    tracking_forget(&node->tracking);
    moving_base_forget(&node->base);
  }
  node->camera_is_stale = false;
  servo_node_report_stored(node);
  if ((whole_node || !node->started) && (servo_node_lost_parameters(node) & ~COB_IDS_COLLIDE) != 0) {
    servo_node_command_fault(node, FAULT_PARAMETERS_LOST); /* older limits may be wrong: somebody must acknowledge it */
  }
  return true;
}
