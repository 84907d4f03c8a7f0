/* SPDX-License-Identifier: Apache-2.0 */
/* SDO server, from any state that satisfies `is_good`, on objects of any type, size and access:
 * - with BLOCK_TRANSFERS 1: every segment, confirmation and end of a block transfer (any 8 bytes), and what is sent
 * next;
 * - with 0: a tick, with every request that initiates a transfer (any 8 bytes) and any answer of an owner that was not
 *   finished; an answer that was sent; a reset.
 * After each:
 * - the state satisfies `is_good`, too: a transfer is open exactly when one is under way, in its own direction;
 * sub-blocks have 1 to 127 segments, and none begins beyond the size;
 * - bytes are read, written and committed only in an open transfer of that direction, at most 7 at a time, and what is
 *   read lies within the size; a transfer begins only when none is open;
 * - no access outside the server and a request.
 * The dictionary, the transfer (prove_sdo_transfer.c) and the CRC are replaced by their contracts. */
#include "canopen/crc_xmodem.h"
#include "canopen/sdo_protocol.h"

#include "any_dictionary.h"
#include "proof.h"

static sdo_server server;

static od_abort any_refusal(void) { return any_bool() ? OD_OK : OD_GENERAL; }

/* The transfer as prove_sdo_transfer.c has proven it. */

static void open(sdo_transfer *transfer, const od_object *object, bool writing, od_abort answer) {
  REQUIRE(!transfer->open, "a transfer begins when none is open");
  transfer->object = *object;
  transfer->writing = writing;
  transfer->position = 0;
  transfer->open = answer == OD_OK;
}

od_abort sdo_transfer_open_read(sdo_transfer *transfer, const od_object *object) {
  const od_abort answer = any_refusal();
  open(transfer, object, false, answer);
  transfer->size = any_u32();
  return answer;
}

od_abort sdo_transfer_open_write(sdo_transfer *transfer, const od_object *object, uint32_t announced_size) {
  const od_abort answer = any_refusal();
  open(transfer, object, true, answer);
  transfer->size = announced_size;
  return answer;
}

od_abort sdo_transfer_read(sdo_transfer *transfer, uint32_t offset, uint8_t *bytes, uint32_t length) {
  REQUIRE(transfer->open && !transfer->writing, "what is read was opened for it");
  REQUIRE(length <= SDO_SEGMENT_BYTES && offset <= transfer->size && length <= transfer->size - offset,
          "a piece lies within the size");
  REQUIRE(bytes >= server.reply && bytes + length <= server.reply + SDO_BYTES, "a piece fits its answer");
  return any_refusal();
}

od_abort sdo_transfer_append(sdo_transfer *transfer, const uint8_t *bytes, uint32_t length) {
  (void)bytes;
  REQUIRE(transfer->open && transfer->writing, "what is written was opened for it");
  REQUIRE(length <= SDO_SEGMENT_BYTES, "a piece is a segment at most");
  const od_abort answer = any_refusal();
  transfer->position += answer == OD_OK ? length : 0;
  return answer;
}

od_abort sdo_transfer_commit(sdo_transfer *transfer) {
  REQUIRE(transfer->open && transfer->writing, "what is committed was opened for writing");
  const od_abort answer = any_bool() ? OD_PENDING : any_refusal();
  transfer->open = answer == OD_PENDING;
  return answer;
}

void sdo_transfer_close(sdo_transfer *transfer) { transfer->open = false; }

uint16_t crc_xmodem(uint16_t crc, const uint8_t *bytes, uint32_t length) {
  (void)crc;
  (void)bytes;
  REQUIRE(length <= SDO_SEGMENT_BYTES, "the CRC is that of a segment");
  return any_u16();
}

static bool is_writing_state(sdo_state state) {
  return state == SDO_DOWNLOADING || state == SDO_BLOCK_DOWNLOADING || state == SDO_BLOCK_DOWNLOAD_END ||
         state == SDO_COMMITTING;
}

static bool block_is_good(void) {
  const bool sending = server.state == SDO_BLOCK_UPLOADING;
  switch (server.state) {
    case SDO_BLOCK_DOWNLOADING:
      return server.block_size == SDO_BLOCK_SEGMENTS && server.sequence < server.block_size;
    case SDO_BLOCK_UPLOAD_START:
    case SDO_BLOCK_UPLOADING:
    case SDO_BLOCK_UPLOAD_ACK:
      return server.block_size >= 1 && server.block_size <= SDO_BLOCK_SEGMENTS_MAX &&
             (!sending || server.sequence < server.block_size);
    default:
      return true;
  }
}

static bool is_good(void) {
  const bool under_way = server.state != SDO_IDLE;
  return server.state <= SDO_COMMITTING && server.transfer.open == under_way &&
         (!under_way || server.transfer.writing == is_writing_state(server.state)) &&
         (!under_way || server.transfer.writing || server.offset <= server.transfer.size) && block_is_good() &&
         server.quiet_ms <= SDO_QUIET_MS && server.silent_ms < SDO_TIME_OUT_MS;
}

static od_entry any_entry(void) {
  od_entry entry = {0};
  entry.type = any_u8();
  entry.access = any_u8() & 3u;
  entry.bytes = any_u16();
  return entry;
}

static void any_eight(uint8_t bytes[SDO_BYTES]) {
  for (int i = 0; i < SDO_BYTES; ++i) {
    bytes[i] = any_u8();
  }
}

static void any_state(const object_dictionary *dictionary) {
  server.dictionary = dictionary;
  server.state = (sdo_state)any_u8();
  server.transfer.object.part = &part;
  server.transfer.object.entry = any_bool() ? &one : &other;
  server.transfer.open = any_bool();
  server.transfer.writing = any_bool();
  server.transfer.size = any_u32();
  server.transfer.position = any_u32();
  server.index = any_u16();
  server.sub = any_u8();
  server.toggle = any_bool();
  server.offset = any_u32();
  server.silent_ms = any_u16();
  server.block_offset = any_u32();
  server.block_size = any_u8();
  server.sequence = any_u8();
  server.use_crc = any_bool();
  server.crc = any_u16();
  server.crc_offset = any_u32();
  server.holding = any_bool();
  server.quiet_ms = any_u8();
  server.request_held = any_bool();
  server.reply_waiting = any_bool();
  any_eight(server.held_request);
  ASSUME(is_good());
}

static void block_transfer(const uint8_t request[SDO_BYTES]) {
  const uint8_t operation = any_u8();
  if (operation == 0) {
    ASSUME(server.state == SDO_BLOCK_DOWNLOADING);
    sdo_block_download_segment(&server, request);
  } else if (operation == 1) {
    ASSUME(server.state == SDO_BLOCK_DOWNLOAD_END);
    sdo_block_download_end(&server, request);
  } else if (operation == 2) {
    ASSUME((request[0] & 3u) != 0); /* what initiates an upload comes with the tick */
    sdo_block_upload_receive(&server, request);
  } else {
    const uint8_t *answer = sdo_server_outgoing(&server);
    REQUIRE(answer == (server.reply_waiting ? server.reply : NULL), "the answer is the one that waits");
  }
}

/* The tick takes the request that waits: any that initiates a transfer. */
static void pass_time(void) {
  const uint8_t operation = any_u8();
  if (operation == 0) {
    sdo_server_tick(&server);
  } else if (operation == 1) {
    sdo_server_sent(&server);
  } else {
    sdo_server_reset(&server);
  }
}

int main(void) {
  const object_dictionary dictionary = {&part, 1, NULL};
  one = any_entry();
  other = any_entry();
  any_state(&dictionary);
  uint8_t request[SDO_BYTES];
  any_eight(request);
  if (BLOCK_TRANSFERS) {
    block_transfer(request);
  } else {
    pass_time();
  }
  REQUIRE(is_good(), "the state is good after each operation");
  return 0;
}
