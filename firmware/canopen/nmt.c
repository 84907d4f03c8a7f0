/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/nmt.h"

enum {
  COMMAND_START = 1,
  COMMAND_STOP = 2,
  COMMAND_PRE_OPERATIONAL = 128,
  COMMAND_RESET_NODE = 129,
  COMMAND_RESET_COMMUNICATION = 130
};

nmt_request nmt_receive(nmt_state *state, uint8_t node_id, const can_frame *frame) {
  if (!nmt_is_addressed(node_id, frame) || *state == NMT_INITIALISING) {
    return NMT_NOTHING;
  }
  switch (frame->data[0]) {
    case COMMAND_START:
      *state = NMT_OPERATIONAL;
      break;
    case COMMAND_STOP:
      *state = NMT_STOPPED;
      break;
    case COMMAND_PRE_OPERATIONAL:
      *state = NMT_PRE_OPERATIONAL;
      break;
    case COMMAND_RESET_NODE:
      *state = NMT_INITIALISING;
      return NMT_RESET_NODE;
    case COMMAND_RESET_COMMUNICATION:
      *state = NMT_INITIALISING;
      return NMT_RESET_COMMUNICATION;
    default:
      break;
  }
  return NMT_NOTHING;
}
