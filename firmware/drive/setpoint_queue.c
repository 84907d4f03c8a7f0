/* SPDX-License-Identifier: Apache-2.0 */
#include "drive/setpoint_queue.h"

#include "drive/drive_state.h"

/* A target may be a thousand million turns away: relative set-points that only add up have that end. */
#define FARTHEST_COUNTS (INT64_C(1) << 55)

/* In 2^-32 turn, rounded up. A target nearer than this is here, and no way leads once round to it. */
#define ONE_COUNT 69

bool setpoint_option_supported(uint16_t option) {
  return (option & ~(unsigned)(SETPOINT_WAY | SETPOINT_RELATIVE_TO)) == 0 &&
         (option & SETPOINT_RELATIVE_TO) <= SETPOINT_FROM_ACTUAL;
}

static setpoint_target target_of(drive_angle origin, int64_t counts) {
  return (setpoint_target){
      .origin = origin, .counts = counts, .angle = origin + drive_angle_from_position(counts), .limited = false};
}

/* To the nearest count. */
static setpoint_target target_at(drive_angle angle) {
  const drive_angle within = drive_angle_wrap(angle);
  return target_of(angle - within, drive_position_from_angle(within));
}

void setpoint_queue_reset(setpoint_queue *queue, drive_angle position, bool bit_before) {
  const setpoint_target here = target_at(position);
  *queue = (setpoint_queue){.target = here, .next = here, .edge_before = bit_before};
}

static int64_t farther(int64_t counts, int32_t by) {
  const int64_t sum = counts + by;
  if (sum > FARTHEST_COUNTS) {
    return FARTHEST_COUNTS;
  }
  return sum < -FARTHEST_COUNTS ? -FARTHEST_COUNTS : sum;
}

static setpoint_target relative_target(const setpoint_target *before, const setpoint_order *order) {
  setpoint_target base = *before;
  switch (order->option & SETPOINT_RELATIVE_TO) {
    case SETPOINT_FROM_DEMAND:
      base = target_at(order->demand);
      break;
    case SETPOINT_FROM_ACTUAL:
      base = target_at(order->actual);
      break;
    default:
      break;
  }
  return target_of(base.origin, farther(base.counts, order->target));
}

/* Whole ranges to add to a way of less than a range. */
static drive_angle ranges_of_way(drive_angle way, uint16_t option) {
  switch (option & SETPOINT_WAY) {
    case SETPOINT_DOWN:
      return way > ONE_COUNT ? -DRIVE_RANGE : 0;
    case SETPOINT_UP:
      return way < -ONE_COUNT ? DRIVE_RANGE : 0;
    case SETPOINT_SHORTER:
      return drive_angle_wrap(way) - way;
    default:
      return 0;
  }
}

static setpoint_target absolute_target(drive_angle from, const setpoint_order *order) {
  if (!order->wraps) {
    return target_of(0, order->target);
  }
  const drive_angle given = drive_angle_from_position(order->target);
  const drive_angle range = from - drive_angle_wrap(from);
  const drive_angle origin = range + drive_angle_wrap(given) - given;
  return target_of(origin + ranges_of_way(origin + given - from, order->option), order->target);
}

static bool take(setpoint_queue *queue, const setpoint_order *order) {
  const bool relative = (order->controlword & DRIVE_CONTROL_RELATIVE) != 0;
  const bool immediately = (order->controlword & DRIVE_CONTROL_CHANGE_IMMEDIATELY) != 0;
  const bool at_once = immediately || !queue->under_way;
  const setpoint_target *before = queue->waiting && !immediately ? &queue->next : &queue->target;
  const setpoint_target taken =
      relative ? relative_target(before, order) : absolute_target(at_once ? order->demand : before->angle, order);
  if (at_once) {
    queue->target = taken;
    queue->under_way = true;
    queue->waiting = false;
    return true;
  }
  if (!queue->waiting) {
    queue->next = taken;
    queue->waiting = true;
  }
  return false;
}

bool setpoint_queue_step(setpoint_queue *queue, const setpoint_order *order) {
  const bool bit = (order->controlword & DRIVE_CONTROL_NEW_SETPOINT) != 0;
  const bool edge = bit && !queue->edge_before;
  queue->edge_before = bit;
  const bool started = edge && take(queue, order);
  /* Stays set until the client has cleared bit 4 and another set-point could be taken. */
  queue->acknowledged = edge || (queue->acknowledged && bit) || queue->waiting;
  return started;
}

static void limit(setpoint_target *target, const drive_travel *travel) {
  const bool here = target->origin == 0;
  if (here && target->counts >= travel->minimum && target->counts <= travel->maximum) {
    return;
  }
  const bool below = here ? target->counts < travel->minimum : target->origin < 0;
  *target = target_of(0, below ? travel->minimum : travel->maximum);
  target->limited = true;
}

void setpoint_queue_limit(setpoint_queue *queue, const drive_travel *travel) {
  if (drive_travel_is_limited(travel)) {
    limit(&queue->target, travel);
    if (queue->waiting) {
      limit(&queue->next, travel);
    }
  }
}

void setpoint_queue_idle(setpoint_queue *queue, uint16_t controlword) {
  queue->edge_before = (controlword & DRIVE_CONTROL_NEW_SETPOINT) != 0;
}

bool setpoint_queue_finish(setpoint_queue *queue) {
  queue->under_way = queue->waiting;
  if (!queue->waiting) {
    return false;
  }
  queue->target = queue->next;
  queue->waiting = false;
  return true;
}
