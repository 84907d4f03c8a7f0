/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "canopen/canopen_node_parts.h"
#include "canopen/cob_id.h"
#include "canopen/node_objects.h"

/* Returns false when there is nothing to send or no room for it. */
static bool send_sdo(canopen_node *node, uint32_t channel) {
  sdo_server *server = &node->sdo[channel];
  const uint8_t *bytes = sdo_server_outgoing(server);
  if (bytes == NULL) {
    return false;
  }
  can_frame frame = {.id = node->objects.sdo[channel].response_cob_id & COB_ID_IDENTIFIER, .length = SDO_BYTES};
  memcpy(frame.data, bytes, SDO_BYTES);
  const bool sent = canopen_send(node, &frame);
  if (sent) {
    sdo_server_sent(server);
  }
  return sent;
}

void canopen_send_sdos(canopen_node *node, uint32_t limit) {
  uint32_t idle = 0;
  /* Bound: CANOPEN_SDO_FRAMES_PER_CALL: what its caller gives. */
  for (uint32_t i = 0; i < limit && idle < SDO_CHANNELS; i++) {
    idle = send_sdo(node, node->first_sdo) ? 0 : idle + 1;
    node->first_sdo = (node->first_sdo + 1) % SDO_CHANNELS;
  }
}

static void receive_sdo(canopen_node *node, uint32_t channel, const can_frame *frame) {
  if (frame->length == SDO_BYTES) {
    canopen_node_heard(node);
    node->sdo_client = channel;
    sdo_server_receive(&node->sdo[channel], frame->data);
    node->sdo_client = SDO_CHANNELS;
    (void)send_sdo(node, channel);
  }
}

uint32_t canopen_sdo_commits(const canopen_node *node) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < SDO_CHANNELS; i++) {
    count += sdo_server_commits(&node->sdo[i]) ? 1 : 0;
  }
  return count;
}

/* Long commands on both channels go on in turn: both in one ms would hold up the next tick. */
void canopen_tick_sdo(canopen_node *node) {
  const bool in_turn = canopen_sdo_commits(node) == SDO_CHANNELS;
  if (in_turn) {
    node->commit_turn = (node->commit_turn + 1) % SDO_CHANNELS;
  }
  for (uint32_t i = 0; i < SDO_CHANNELS; i++) {
    if (in_turn && i != node->commit_turn) {
      continue;
    }
    if (canopen_sdo_is_on(node, i)) {
      node->sdo_client = i;
      sdo_server_tick(&node->sdo[i]);
    } else {
      sdo_server_reset(&node->sdo[i]);
    }
  }
  node->sdo_client = SDO_CHANNELS;
}

void canopen_lose_producer(canopen_node *node, uint8_t lost) {
  const emergency_error error = {.code = EMERGENCY_HEARTBEAT, .register_bits = ERROR_COMMUNICATION, .detail = lost};
  (void)canopen_node_raise(node, &error);
  if (node->config.events.heartbeat_lost != NULL) {
    node->config.events.heartbeat_lost(node->config.context, lost);
  }
  canopen_obey_error_behaviour(node);
}

static void receive_heartbeat(canopen_node *node, const can_frame *frame) {
  const uint8_t producer = (uint8_t)(frame->id - HEARTBEAT_COB_ID);
  if (frame->length != 1) {
    return;
  }
  for (uint32_t i = 0; i < HEARTBEAT_CONSUMERS; i++) {
    const uint32_t object = node->objects.heartbeat_consumer[i];
    if (!heartbeat_consumer_active(object) || heartbeat_consumer_node(object) != producer) {
      continue;
    }
    const heartbeat_news news = heartbeat_consumer_hear(&node->consumers[i], frame->data[0]);
    if (news == HEARTBEAT_RESET) {
      canopen_lose_producer(node, producer);
    } else if (news != HEARTBEAT_BOOTED) {
      canopen_node_heard(node);
    }
    if (news == HEARTBEAT_BACK) {
      node_objects_judge_heartbeats(node);
    }
  }
}

/* --- LSS --------------------------------------------------------------------------------------------------------- */

static bool is_lss(const can_frame *frame) {
  return frame->id == LSS_REQUEST_COB_ID && frame->flags == 0 && frame->length == LSS_BYTES;
}

static uint32_t identity_of(const canopen_node *node, uint8_t sub) {
  od_object object;
  return od_find(&node->dictionary, 0x1018, sub, &object) == OD_OK ? (uint32_t)od_get(&object).i : 0;
}

void canopen_send_lss(canopen_node *node) {
  const uint8_t *bytes = lss_slave_outgoing(&node->lss);
  if (bytes != NULL) {
    can_frame frame = {.id = LSS_RESPONSE_COB_ID, .length = LSS_BYTES};
    memcpy(frame.data, bytes, LSS_BYTES);
    if (canopen_send(node, &frame)) {
      lss_slave_sent(&node->lss);
    }
  }
}

/* In every NMT state, also without a node id. The identity is read here, because the serial number is set after the
 * start.
 */
static void receive_lss(canopen_node *node, const can_frame *frame) {
  uint32_t identity[LSS_IDENTITY_PARTS];
  for (uint32_t part = 0; part < LSS_IDENTITY_PARTS; part++) {
    identity[part] = identity_of(node, (uint8_t)(part + 1));
  }
  lss_slave_identify(&node->lss, identity);
  if (lss_slave_receive(&node->lss, frame->data)) {
    canopen_begin_reset(node, false);
  }
  canopen_send_lss(node);
}

void canopen_receive_service(canopen_node *node, const can_frame *frame) {
  const uint32_t channel = canopen_sdo_channel_of(node, frame);
  if (is_lss(frame)) {
    receive_lss(node, frame);
  } else if (node->state == NMT_INITIALISING) {
    return;
  } else if (canopen_is_heartbeat(frame)) {
    receive_heartbeat(node, frame);
  } else if (nmt_allows_sdo(node->state) && channel < SDO_CHANNELS && !lss_slave_is_silent(&node->lss)) {
    receive_sdo(node, channel, frame);
  }
}
