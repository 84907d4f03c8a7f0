/* SPDX-License-Identifier: Apache-2.0 */
/* Network management: the node's own state and the commands that change it.
 *
 * Standard: CiA 301 v4.2.0, clause 7.2.8 and 7.3.2 (NMT state machine, figure 47). The node passes each NMT frame to
 * `nmt_receive` and acts on the result. The `nmt_allows_*` functions say which services work in which state. */
#ifndef TRACKSERVO_CANOPEN_NMT_H
#define TRACKSERVO_CANOPEN_NMT_H

#include "base/can_frame.h"

/* As sent in the heartbeat. */
typedef enum {
  NMT_INITIALISING = 0, /* boot-up message not sent yet */
  NMT_STOPPED = 4,
  NMT_OPERATIONAL = 5,
  NMT_PRE_OPERATIONAL = 127
} nmt_state;

/* Actions of the node beyond the change of its state. */
typedef enum {
  NMT_NOTHING,
  NMT_RESET_COMMUNICATION, /* reset objects 1000 to 1FFF, then boot-up */
  NMT_RESET_NODE           /* the whole device */
} nmt_request;

enum { NMT_COB_ID = 0x000 };

/* Returns whether a frame is a command for this node or for all nodes, also an unknown one. */
static inline bool nmt_is_addressed(uint8_t node_id, const can_frame *frame) {
  return frame->length == 2 && (frame->data[1] == 0 || frame->data[1] == node_id);
}

/* Executes a command frame (start 1, stop 2, pre-operational 128, reset node 129, reset communication 130). Frames with
 * another length, for another node or with another command are ignored. */
nmt_request nmt_receive(nmt_state *state, uint8_t node_id, const can_frame *frame);

static inline bool nmt_allows_pdo(nmt_state state) { return state == NMT_OPERATIONAL; }

/* Returns whether SDO, SYNC and EMCY are allowed in this state. */
static inline bool nmt_allows_sdo(nmt_state state) { return state == NMT_OPERATIONAL || state == NMT_PRE_OPERATIONAL; }

#endif
