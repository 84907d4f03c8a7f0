/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/crc_xmodem.h"
#include "canopen/sdo_protocol.h"

enum {
  SUBCOMMAND = 0x03,
  INITIATE = 0,
  END = 1,
  CONFIRM = 2,
  START = 3,
  CRC_WANTED = 0x04,
  ANSWER_INITIATE = 0xC0,
  ANSWER_END = 0xC1,
  CRC_OFFERED = 0x04,
  SIZE_GIVEN = 0x02,
  LAST_SEGMENT = 0x80
};

static bool block_size_is_good(uint8_t segments) { return segments >= 1 && segments <= SDO_BLOCK_SEGMENTS_MAX; }

static void initiate(sdo_server *server, const uint8_t *request) {
  if (!sdo_server_open(server, request, false, 0)) {
    return;
  }
  if (!block_size_is_good(request[4])) {
    sdo_server_abort(server, OD_BAD_BLOCK_SIZE);
    return;
  }
  server->state = SDO_BLOCK_UPLOAD_START;
  server->block_size = request[4];
  server->use_crc = (request[0] & CRC_WANTED) != 0;
  server->crc = 0;
  server->crc_offset = 0;
  /* Only for a client that requested the CRC: some check a CRC that they did not request. */
  sdo_server_answer(server, (uint8_t)(ANSWER_INITIATE | SIZE_GIVEN | (server->use_crc ? CRC_OFFERED : 0)));
  sdo_server_put_multiplexer(server);
  sdo_put_u32(&server->reply[4], server->transfer.size);
}

static void begin_sub_block(sdo_server *server, uint32_t offset) {
  server->block_offset = offset;
  server->offset = offset;
  server->sequence = 0;
  server->reply_waiting = false;
  server->state = SDO_BLOCK_UPLOADING;
}

void sdo_block_upload_next_segment(sdo_server *server) {
  const uint32_t left = server->transfer.size - server->offset;
  const uint32_t length = left < SDO_SEGMENT_BYTES ? left : SDO_SEGMENT_BYTES;
  const bool last = length == left;
  server->sequence++;
  sdo_server_answer(server, (uint8_t)(server->sequence | (last ? LAST_SEGMENT : 0)));
  const od_abort answer = sdo_transfer_read(&server->transfer, server->offset, &server->reply[1], length);
  if (answer != OD_OK) {
    sdo_server_abort(server, answer);
    return;
  }
  if (server->offset == server->crc_offset) {
    server->crc = crc_xmodem(server->crc, &server->reply[1], length);
    server->crc_offset += length;
  }
  server->offset += length;
  if (last || server->sequence == server->block_size) {
    server->state = SDO_BLOCK_UPLOAD_ACK;
  }
}

static void say_end(sdo_server *server) {
  const uint32_t size = server->transfer.size;
  const uint32_t in_last = size == 0 ? 0 : (size - 1) % SDO_SEGMENT_BYTES + 1;
  sdo_server_answer(server, (uint8_t)(ANSWER_END | (SDO_SEGMENT_BYTES - in_last) << 2));
  const uint16_t crc = server->use_crc ? server->crc : 0;
  server->reply[1] = (uint8_t)crc;
  server->reply[2] = (uint8_t)(crc >> 8);
  server->state = SDO_BLOCK_UPLOAD_END;
}

/* The client has all segments up to the confirmed one; the following segments are sent again. */
static void confirm(sdo_server *server, const uint8_t *request) {
  const uint8_t confirmed = request[1];
  if (confirmed > server->sequence) {
    sdo_server_abort(server, OD_BAD_SEQUENCE);
    return;
  }
  if (!block_size_is_good(request[2])) {
    sdo_server_abort(server, OD_BAD_BLOCK_SIZE);
    return;
  }
  server->block_size = request[2];
  const uint32_t size = server->transfer.size;
  const uint32_t reached = server->block_offset + (uint32_t)confirmed * SDO_SEGMENT_BYTES;
  const bool all = confirmed == server->sequence && server->offset == size && confirmed > 0;
  if (all) {
    say_end(server);
  } else {
    begin_sub_block(server, reached < size ? reached : size);
  }
}

void sdo_block_upload_receive(sdo_server *server, const uint8_t *request) {
  const uint8_t subcommand = request[0] & SUBCOMMAND;
  const sdo_state state = server->state;
  if (subcommand == INITIATE) {
    initiate(server, request);
  } else if (subcommand == START && state == SDO_BLOCK_UPLOAD_START) {
    begin_sub_block(server, 0);
  } else if (subcommand == CONFIRM && (state == SDO_BLOCK_UPLOADING || state == SDO_BLOCK_UPLOAD_ACK)) {
    confirm(server, request);
  } else if (subcommand == END && state == SDO_BLOCK_UPLOAD_END) {
    sdo_transfer_close(&server->transfer);
    server->state = SDO_IDLE;
  } else {
    sdo_server_abort(server, OD_BAD_COMMAND);
  }
}
