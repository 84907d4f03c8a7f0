/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/canopen_node_parts.h"
#include "canopen/cob_id.h"
#include "canopen/node_objects.h"

static void receive_nmt(canopen_node *node, const can_frame *frame) {
  nmt_state wanted = node->state;
  if (nmt_is_addressed(node->config.node_id, frame)) {
    canopen_node_heard(node);
  }
  const nmt_request request = nmt_receive(&wanted, node->config.node_id, frame);
  if (request != NMT_NOTHING) {
    canopen_begin_reset(node, request == NMT_RESET_NODE);
  } else if (wanted != node->state) {
    canopen_enter(node, wanted);
  }
}

/* `frame` is NULL: the values that wait for SYNC. */
static void receive_pdo(canopen_node *node, rpdo *receiver, const can_frame *frame) {
  const bool was_bad = rpdo_is_bad(receiver);
  const rpdo_verdict verdict = frame == NULL ? rpdo_sync(receiver) : rpdo_receive(receiver, frame);
  node->rpdos_changed = node->rpdos_changed || was_bad || verdict >= RPDO_REFUSED;
}

/* A command that must wait for the one before it stays in the queue, with all that follows it: each takes effect in a
 * tick of its own. A queue more than half full is emptied all the same; of such a frame only a stop is obeyed then, and
 * the stop before it is not undone. */
static bool stays_in_queue(canopen_node *node, rpdo *receiver, const can_frame *frame) {
  if (can_queue_count(&node->process_data) <= node->process_data.capacity / 2) {
    return true;
  }
  node->dropped_commands++;
  rpdo_obey_stops(receiver, frame);
  return false;
}

/* Whether the frame has been used. No two RPDOs have the same identifier. */
static bool receive_pdos(canopen_node *node, const can_frame *frame) {
  uint32_t n = 0;
  /* Bound: RPDO_COUNT. */
  while (n < RPDO_COUNT && frame->id != node->listeners.rpdo[n]) {
    n++;
  }
  if (n == RPDO_COUNT) {
    return true;
  }
  rpdo *receiver = &node->rpdos[n];
  const bool must_wait = rpdo_must_wait(receiver, frame);
  if (must_wait && stays_in_queue(node, receiver, frame)) {
    return false;
  }
  if (receiver->speaks) {
    canopen_node_heard(node);
  }
  if (!must_wait) {
    receive_pdo(node, receiver, frame);
  }
  return true;
}

/* Whether SYNC can take effect on all RPDOs that wait for it. */
static bool sync_can_be_used(canopen_node *node) {
  for (uint32_t n = 0; n < RPDO_COUNT; n++) {
    if (rpdo_must_wait(&node->rpdos[n], NULL) && stays_in_queue(node, &node->rpdos[n], NULL)) {
      return false;
    }
  }
  return true;
}

static void receive_sync(canopen_node *node, const can_frame *frame) {
  node->sync_wrong_length = sync_receive(&node->sync, &node->objects.sync, frame) == SYNC_WRONG_LENGTH;
  canopen_raise_or_clear(node, EMERGENCY_SYNC_LENGTH, node->sync_wrong_length);
  if (node->sync_wrong_length) {
    return;
  }
  (void)canopen_node_clear(node, EMERGENCY_SOURCE_NODE, EMERGENCY_SYNC_TIME_OUT);
  if (sync_clock_hear(&node->clock, node->objects.sync.period_us)) {
    canopen_raise_or_clear(node, EMERGENCY_SYNC_CLOCK, node->clock.off);
  }
  if (!nmt_allows_pdo(node->state)) {
    return;
  }
  if (node->sync_is_used) {
    canopen_node_heard(node);
  }
  if (node->sync_count < CANOPEN_FRAMES_PER_CALL) {
    node->sync_counter[node->sync_count++] = node->sync.counter;
  }
  for (uint32_t n = 0; n < RPDO_COUNT; n++) {
    if (node->rpdos[n].waiting) {
      receive_pdo(node, &node->rpdos[n], NULL);
    }
  }
}

bool canopen_receive_process_data(canopen_node *node, const can_frame *frame) {
  if (frame->id == NMT_COB_ID) {
    receive_nmt(node, frame);
  } else if (lss_slave_is_silent(&node->lss)) {
    return true;
  } else if (frame->id == node->listeners.sync) {
    if (nmt_allows_pdo(node->state) && !sync_can_be_used(node)) {
      return false;
    }
    if (nmt_allows_sdo(node->state)) { /* also pre-operational, because of its length */
      receive_sync(node, frame);
    }
  } else if (nmt_allows_pdo(node->state)) {
    return receive_pdos(node, frame);
  }
  return true;
}
