/* SPDX-License-Identifier: Apache-2.0 */
#include "node/servo_node_parts.h"

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

static void defer_stop(void *owner, const od_object *object, od_number value) {
  (void)object;
  servo_node_axis *axis = owner;
  waiting_stops_add(&axis->waiting, (uint16_t)value.i);
}

/* Every controlword takes effect in a tick of its own, or a stop could be lost between two ticks. */
static bool drive_waits(void *owner, const od_object *object) {
  const servo_node_axis *axis = owner;
  return object->entry->index == 0x6040 &&
         (axis->waiting.count > 0 || axis->objects.state.controlword != axis->drive.controlword);
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

const od_hooks servo_node_drive_hooks = {.accept = accept_drive,
                                         .changed = changed_drive,
                                         .stops = stops_drive,
                                         .defer = defer_stop,
                                         .waits = drive_waits,
                                         .needed = needed_by_drive};

/* --- objects of the board --- */

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

const od_hooks servo_node_board_hooks = {.accept = accept_board, .changed = changed_board};

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

const od_hooks servo_node_clock_hooks = {.refresh = refresh_clock, .changed = changed_clock};
