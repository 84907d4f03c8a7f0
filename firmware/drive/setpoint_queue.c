#include "drive/setpoint_queue.h"

#include "drive/drive_state.h"
#include "drive/drive_units.h"

void setpoint_queue_reset(setpoint_queue *queue, int32_t position, bool bit_before) {
  *queue = (setpoint_queue){.target = position, .next = position, .edge_before = bit_before};
}

static bool take(setpoint_queue *queue, uint16_t controlword, int32_t target) {
  const bool relative = (controlword & DRIVE_CONTROL_RELATIVE) != 0;
  const bool immediately = (controlword & DRIVE_CONTROL_CHANGE_IMMEDIATELY) != 0;
  const int32_t last = queue->waiting && !immediately ? queue->next : queue->target;
  const int32_t absolute = relative ? drive_add(last, target) : target;
  if (immediately || !queue->under_way) {
    queue->target = absolute;
    queue->under_way = true;
    queue->waiting = false;
    return true;
  }
  if (!queue->waiting) {
    queue->next = absolute;
    queue->waiting = true;
  }
  return false;
}

bool setpoint_queue_step(setpoint_queue *queue, uint16_t controlword, int32_t target) {
  const bool bit = (controlword & DRIVE_CONTROL_NEW_SETPOINT) != 0;
  const bool edge = bit && !queue->edge_before;
  queue->edge_before = bit;
  const bool started = edge && take(queue, controlword, target);
  /* Stays set until the client has cleared bit 4 and another set-point could be taken. */
  queue->acknowledged = edge || (queue->acknowledged && bit) || queue->waiting;
  return started;
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
