/* SPDX-License-Identifier: Apache-2.0 */
/* The data of an SDO transfer, for every call in any order, from any state that satisfies `is_good`, on objects of any
 * type, size and access:
 * - the next state satisfies `is_good`, too: what was moved lies within the announced size and the buffer;
 * - a value is written, and a stream ended as complete, only when all announced bytes have come;
 * - streams are read within their size and written in order;
 * - a refusal opens no transfer; a commit leaves one open only while the owner has not finished;
 * - no access outside the buffer and the bytes of the caller.
 * The dictionary and the owners of streams are replaced by their contracts. Bound: at most 8 bytes per call, as the SDO
 * server moves them (prove_sdo_server.c). */
#include "canopen/sdo_transfer.h"

#include "proof.h"

enum { PIECE_BYTES = 8 };

static sdo_transfer transfer;
static od_entry entry;

static od_abort any_refusal(void) { return any_bool() ? OD_OK : OD_GENERAL; }

static od_abort begin(void *owner, const od_object *object, bool writing, uint32_t *size) {
  (void)owner;
  (void)object;
  if (!writing) {
    *size = any_u32();
  }
  return any_refusal();
}

static od_abort read_piece(void *owner, const od_object *object, uint32_t offset, uint8_t *bytes, uint32_t length) {
  (void)owner;
  (void)object;
  REQUIRE(offset <= transfer.size && length <= transfer.size - offset, "a stream is read within its size");
  for (uint32_t i = 0; i < PIECE_BYTES; ++i) {
    if (i < length) {
      bytes[i] = any_u8();
    }
  }
  return any_refusal();
}

static od_abort write_piece(void *owner, const od_object *object, uint32_t offset, const uint8_t *bytes,
                            uint32_t length) {
  (void)owner;
  (void)object;
  (void)bytes;
  REQUIRE(offset == transfer.position && length >= 1 && length <= transfer.size - offset,
          "a stream is written in order, within its size");
  return any_refusal();
}

static bool is_complete(void) { return transfer.size == OD_SIZE_UNKNOWN || transfer.position == transfer.size; }

static od_abort end(void *owner, const od_object *object, bool writing, bool complete, uint32_t total) {
  (void)owner;
  (void)object;
  REQUIRE(!writing || !complete || (is_complete() && total == transfer.position),
          "a stream is complete when all announced bytes have come");
  return any_bool() ? OD_PENDING : any_refusal();
}

static const od_hooks hooks = {
    .stream_begin = begin, .stream_read = read_piece, .stream_write = write_piece, .stream_end = end};
static const od_part part = {.hooks = &hooks};

od_abort od_read(const od_object *object, uint8_t *bytes, uint16_t capacity, uint16_t *length) {
  (void)object;
  (void)bytes;
  *length = any_u16();
  ASSUME(*length <= capacity);
  return any_refusal();
}

od_abort od_write(const od_object *object, const uint8_t *bytes, uint16_t length) {
  (void)object;
  (void)bytes;
  REQUIRE(length <= SDO_BUFFER_BYTES && length == transfer.position && is_complete(),
          "a value is written when all announced bytes have come");
  return any_bool() ? OD_PENDING : any_refusal();
}

static bool is_good(void) {
  if (!transfer.open) {
    return true;
  }
  const bool stream = transfer.object.entry->type == OD_DOMAIN;
  if (transfer.writing) {
    return transfer.position <= transfer.size && transfer.position < OD_SIZE_UNKNOWN &&
           (stream || transfer.position <= SDO_BUFFER_BYTES);
  }
  return stream || transfer.size <= SDO_BUFFER_BYTES;
}

static void open(const od_object *object) {
  ASSUME(!transfer.open); /* as prove_sdo_server.c proves */
  const bool writing = any_bool();
  const od_abort answer =
      writing ? sdo_transfer_open_write(&transfer, object, any_u32()) : sdo_transfer_open_read(&transfer, object);
  REQUIRE(transfer.open == (answer == OD_OK), "a refusal opens no transfer");
  REQUIRE(!transfer.open || (transfer.writing == writing && transfer.position == 0), "it begins with the first byte");
}

static void move(void) {
  uint8_t bytes[PIECE_BYTES] = {0};
  const uint32_t before = transfer.position;
  const uint32_t length = any_u32();
  ASSUME(length <= PIECE_BYTES);
  if (any_bool()) {
    ASSUME(!transfer.open || !transfer.writing); /* what was opened for writing is not read: prove_sdo_server.c */
    (void)sdo_transfer_read(&transfer, any_u32(), bytes, length);
    REQUIRE(transfer.position == before, "a read moves no position");
  } else {
    const od_abort answer = sdo_transfer_append(&transfer, bytes, length);
    REQUIRE(transfer.position == before + (answer == OD_OK ? length : 0), "bytes that are refused do not count");
  }
}

int main(void) {
  entry.type = any_u8();
  entry.access = any_u8() & 3u;
  entry.bytes = any_u16();
  const od_object object = {&part, &entry};
  transfer.object = object;
  transfer.open = any_bool();
  transfer.writing = any_bool();
  transfer.size = any_u32();
  transfer.position = any_u32();
  ASSUME(is_good());
  const uint8_t operation = any_u8();
  if (operation == 0) {
    open(&object);
  } else if (operation == 1) {
    move();
  } else if (operation == 2) {
    const od_abort answer = sdo_transfer_commit(&transfer);
    REQUIRE(!transfer.open || answer == OD_PENDING || !transfer.writing, "a commit that is answered ends the transfer");
  } else {
    sdo_transfer_close(&transfer);
    REQUIRE(!transfer.open, "a transfer that was closed is not open");
  }
  REQUIRE(is_good(), "the state is good after each call");
  return 0;
}
