/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "canopen/crc_xmodem.h"
#include "canopen/sdo_protocol.h"

enum {
  CRC_WANTED = 0x04,
  SIZE_GIVEN = 0x02,
  LAST_SEGMENT = 0x80,
  SEQUENCE = 0x7F,
  ANSWER_INITIATE = 0xA0,
  ANSWER_SUB_BLOCK = 0xA2,
  ANSWER_END = 0xA1,
  CRC_OFFERED = 0x04
};

void sdo_block_download_initiate(sdo_server *server, const uint8_t *request) {
  const uint32_t size = (request[0] & SIZE_GIVEN) != 0 ? sdo_announced_size(request) : OD_SIZE_UNKNOWN;
  if (!sdo_server_open(server, request, true, size)) {
    return;
  }
  server->state = SDO_BLOCK_DOWNLOADING;
  server->use_crc = (request[0] & CRC_WANTED) != 0;
  server->crc = 0;
  server->sequence = 0;
  server->holding = false;
  server->block_size = SDO_BLOCK_SEGMENTS;
  /* Only for a client that requested the CRC: some check a CRC that they did not request. */
  sdo_server_answer(server, (uint8_t)(ANSWER_INITIATE | (server->use_crc ? CRC_OFFERED : 0)));
  sdo_server_put_multiplexer(server);
  server->reply[4] = server->block_size;
}

/* Passes on the segment that was held back, or its first `length` bytes. */
static od_abort pass_on_held(sdo_server *server, uint32_t length) {
  if (!server->holding) {
    return OD_OK;
  }
  server->holding = false;
  server->crc = crc_xmodem(server->crc, server->held, length);
  return sdo_transfer_append(&server->transfer, server->held, length);
}

static od_abort accept_segment(sdo_server *server, const uint8_t *request) {
  const od_abort answer = pass_on_held(server, SDO_SEGMENT_BYTES);
  if (answer == OD_OK) {
    memcpy(server->held, &request[1], SDO_SEGMENT_BYTES);
    server->holding = true;
    server->sequence++;
  }
  return answer;
}

void sdo_block_download_segment(sdo_server *server, const uint8_t *request) {
  const uint8_t sequence = request[0] & SEQUENCE;
  const bool last = (request[0] & LAST_SEGMENT) != 0;
  const bool in_order = sequence == server->sequence + 1;
  if (sequence == 0 || sequence > server->block_size) {
    sdo_server_abort(server, OD_BAD_SEQUENCE);
    return;
  }
  if (in_order) {
    const od_abort answer = accept_segment(server, request);
    if (answer != OD_OK) {
      sdo_server_abort(server, answer);
      return;
    }
  }
  if (!last && sequence != server->block_size) {
    return;
  }
  /* The client repeats the segments after the confirmed one. */
  sdo_server_answer(server, ANSWER_SUB_BLOCK);
  server->reply[1] = server->sequence;
  server->reply[2] = server->block_size;
  server->sequence = 0;
  if (last && in_order) {
    server->state = SDO_BLOCK_DOWNLOAD_END;
  }
}

void sdo_block_download_end(sdo_server *server, const uint8_t *request) {
  const uint32_t unused = request[0] >> 2 & 7u;
  const od_abort answer = pass_on_held(server, SDO_SEGMENT_BYTES - unused);
  if (answer != OD_OK) {
    sdo_server_abort(server, answer);
    return;
  }
  const uint16_t crc = (uint16_t)(request[1] | request[2] << 8);
  if (server->use_crc && crc != server->crc) {
    sdo_server_abort(server, OD_BAD_CRC);
    return;
  }
  sdo_server_commit(server, ANSWER_END, false);
}
