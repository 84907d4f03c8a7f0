/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/sdo_server.h"

#include <string.h>

#include "canopen/sdo_protocol.h"

/* Fields of the first byte. */
enum {
  EXPEDITED = 0x02,
  SIZE_GIVEN = 0x01,
  LAST_SEGMENT = 0x01,
  TOGGLE = 0x10,
  BLOCK_END = 0x01,               /* of a block download: end instead of initiate */
  BLOCK_UPLOAD_SUBCOMMAND = 0x03, /* 0: initiate */
  ANSWER_DOWNLOAD = 0x60,
  ANSWER_DOWNLOAD_SEGMENT = 0x20,
  ANSWER_UPLOAD = 0x40,
  ABORT = 0x80
};

enum { EXPEDITED_BYTES = 4 };

uint32_t sdo_get_u32(const uint8_t *bytes) {
  return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

uint32_t sdo_announced_size(const uint8_t *request) {
  const uint32_t size = sdo_get_u32(&request[4]);
  return size == OD_SIZE_UNKNOWN ? OD_SIZE_UNKNOWN - 1 : size;
}

void sdo_put_u32(uint8_t *bytes, uint32_t value) {
  for (uint32_t i = 0; i < 4; i++) {
    bytes[i] = (uint8_t)(value >> (8 * i));
  }
}

void sdo_server_init(sdo_server *server, const object_dictionary *dictionary) {
  *server = (sdo_server){.dictionary = dictionary, .state = SDO_IDLE};
}

static void end_transfer(sdo_server *server) {
  sdo_transfer_close(&server->transfer);
  server->state = SDO_IDLE;
  server->reply_waiting = false;
  server->silent_ms = 0;
}

void sdo_server_reset(sdo_server *server) {
  end_transfer(server);
  server->quiet_ms = 0;
  server->request_held = false;
}

/* A transfer whose client waits for an answer or will send its next request soon. */
static bool is_running(const sdo_server *server) {
  return server->state != SDO_IDLE && server->state != SDO_COMMITTING;
}

/* Ends a transfer that its client may still continue. */
static void break_off(sdo_server *server) {
  if (is_running(server) && server->silent_ms < SDO_QUIET_MS) {
    server->quiet_ms = SDO_QUIET_MS;
  }
  end_transfer(server);
}

void sdo_server_answer(sdo_server *server, uint8_t command) {
  memset(server->reply, 0, SDO_BYTES);
  server->reply[0] = command;
  server->reply_waiting = true;
}

void sdo_server_put_multiplexer(sdo_server *server) {
  server->reply[1] = (uint8_t)server->index;
  server->reply[2] = (uint8_t)(server->index >> 8);
  server->reply[3] = server->sub;
}

static bool is_segmented_download(const uint8_t *request) {
  return request[0] >> 5 == SDO_CCS_DOWNLOAD && (request[0] & EXPEDITED) == 0;
}

/* An answer to a download names its object, but few clients check it. So a client whose request was refused can have
 * taken the other client's confirmation for its own, and may already have sent a segment. */
static void refuse(sdo_server *server, const uint8_t *request) {
  if (is_segmented_download(request)) {
    server->quiet_ms = SDO_QUIET_MS;
  }
}

static void drop_held_request(sdo_server *server) {
  if (server->request_held) {
    refuse(server, server->held_request);
  }
  server->request_held = false;
}

/* A request that does not continue the transfer can come from another client, which sees this abort too. */
static bool is_out_of_turn(od_abort code) {
  return code == OD_TOGGLE || code == OD_BAD_COMMAND || code == OD_BAD_SEQUENCE || code == OD_NOT_TRANSFERRED;
}

void sdo_server_abort(sdo_server *server, od_abort code) {
  if (is_out_of_turn(code)) {
    break_off(server);
    drop_held_request(server);
  }
  end_transfer(server);
  sdo_server_answer(server, ABORT);
  sdo_server_put_multiplexer(server);
  sdo_put_u32(&server->reply[4], (uint32_t)code);
}

static void conclude_commit(sdo_server *server, od_abort answer) {
  if (answer == OD_PENDING) {
    server->state = SDO_COMMITTING;
    server->reply_waiting = false;
  } else if (answer == OD_OK) {
    server->state = SDO_IDLE;
    server->reply_waiting = true;
  } else {
    sdo_server_abort(server, answer);
  }
}

void sdo_server_commit(sdo_server *server, uint8_t command, bool with_multiplexer) {
  sdo_server_answer(server, command);
  if (with_multiplexer) {
    sdo_server_put_multiplexer(server);
  }
  conclude_commit(server, sdo_transfer_commit(&server->transfer));
}

static void take_multiplexer(sdo_server *server, const uint8_t *request) {
  server->index = (uint16_t)(request[1] | request[2] << 8);
  server->sub = request[3];
}

bool sdo_server_open(sdo_server *server, const uint8_t *request, bool writing, uint32_t size) {
  end_transfer(server);
  take_multiplexer(server, request);
  od_object object;
  od_abort answer = od_find(server->dictionary, server->index, server->sub, &object);
  if (answer == OD_OK) {
    answer = writing ? sdo_transfer_open_write(&server->transfer, &object, size)
                     : sdo_transfer_open_read(&server->transfer, &object);
  }
  if (answer != OD_OK) {
    sdo_server_abort(server, answer);
    return false;
  }
  server->toggle = false;
  server->offset = 0;
  return true;
}

/* An expedited download may omit its length: then it is the length of the type, up to four bytes. */
static uint32_t expedited_length(const sdo_server *server, uint8_t command) {
  if ((command & SIZE_GIVEN) != 0) {
    return 4u - (command >> 2 & 3u);
  }
  const uint16_t bytes = server->transfer.object.entry->bytes;
  return bytes >= 1 && bytes < 4 ? bytes : 4;
}

static void download_initiate(sdo_server *server, const uint8_t *request) {
  const uint8_t command = request[0];
  const bool expedited = (command & EXPEDITED) != 0;
  const bool size_given = (command & SIZE_GIVEN) != 0;
  uint32_t size = OD_SIZE_UNKNOWN;
  if (size_given) {
    size = expedited ? 4u - (command >> 2 & 3u) : sdo_announced_size(request);
  }
  if (!sdo_server_open(server, request, true, size)) {
    refuse(server, request);
    return;
  }
  if (!expedited) {
    server->state = SDO_DOWNLOADING;
    sdo_server_answer(server, ANSWER_DOWNLOAD);
    sdo_server_put_multiplexer(server);
    return;
  }
  const od_abort answer = sdo_transfer_append(&server->transfer, &request[4], expedited_length(server, command));
  if (answer != OD_OK) {
    sdo_server_abort(server, answer);
    return;
  }
  sdo_server_commit(server, ANSWER_DOWNLOAD, true);
}

static void download_segment(sdo_server *server, const uint8_t *request) {
  const uint8_t command = request[0];
  if (((command & TOGGLE) != 0) != server->toggle) {
    sdo_server_abort(server, OD_TOGGLE);
    return;
  }
  const uint32_t length = SDO_SEGMENT_BYTES - (command >> 1 & 7u);
  const od_abort answer = sdo_transfer_append(&server->transfer, &request[1], length);
  if (answer != OD_OK) {
    sdo_server_abort(server, answer);
    return;
  }
  const uint8_t reply = (uint8_t)(ANSWER_DOWNLOAD_SEGMENT | (server->toggle ? TOGGLE : 0));
  server->toggle = !server->toggle;
  if ((command & LAST_SEGMENT) != 0) {
    sdo_server_commit(server, reply, false);
  } else {
    sdo_server_answer(server, reply);
  }
}

static void upload_initiate(sdo_server *server, const uint8_t *request) {
  if (!sdo_server_open(server, request, false, 0)) {
    return;
  }
  const uint32_t size = server->transfer.size;
  const bool expedited = size >= 1 && size <= EXPEDITED_BYTES;
  sdo_server_answer(server, ANSWER_UPLOAD | SIZE_GIVEN);
  sdo_server_put_multiplexer(server);
  if (!expedited) {
    sdo_put_u32(&server->reply[4], size);
    server->state = SDO_UPLOADING;
    return;
  }
  server->reply[0] = (uint8_t)(ANSWER_UPLOAD | EXPEDITED | SIZE_GIVEN | (4u - size) << 2);
  const od_abort answer = sdo_transfer_read(&server->transfer, 0, &server->reply[4], size);
  if (answer != OD_OK) {
    sdo_server_abort(server, answer);
    return;
  }
  sdo_transfer_close(&server->transfer);
}

static void upload_segment(sdo_server *server, const uint8_t *request) {
  if (((request[0] & TOGGLE) != 0) != server->toggle) {
    sdo_server_abort(server, OD_TOGGLE);
    return;
  }
  const uint32_t left = server->transfer.size - server->offset;
  const uint32_t length = left < SDO_SEGMENT_BYTES ? left : SDO_SEGMENT_BYTES;
  const bool last = length == left;
  sdo_server_answer(
      server, (uint8_t)((server->toggle ? TOGGLE : 0) | (SDO_SEGMENT_BYTES - length) << 1 | (last ? LAST_SEGMENT : 0)));
  const od_abort answer = sdo_transfer_read(&server->transfer, server->offset, &server->reply[1], length);
  if (answer != OD_OK) {
    sdo_server_abort(server, answer);
    return;
  }
  server->offset += length;
  server->toggle = !server->toggle;
  if (last) {
    sdo_transfer_close(&server->transfer);
    server->state = SDO_IDLE;
  }
}

static void refuse_command(sdo_server *server, const uint8_t *request) {
  if (server->state == SDO_IDLE) {
    take_multiplexer(server, request);
  }
  sdo_server_abort(server, OD_BAD_COMMAND);
}

static void dispatch(sdo_server *server, const uint8_t *request) {
  const uint8_t specifier = request[0] >> 5;
  if (specifier == SDO_CCS_DOWNLOAD) {
    download_initiate(server, request);
  } else if (specifier == SDO_CCS_UPLOAD) {
    upload_initiate(server, request);
  } else if (specifier == SDO_CCS_DOWNLOAD_SEGMENT && server->state == SDO_DOWNLOADING) {
    download_segment(server, request);
  } else if (specifier == SDO_CCS_UPLOAD_SEGMENT && server->state == SDO_UPLOADING) {
    upload_segment(server, request);
  } else if (specifier == SDO_CCS_BLOCK_DOWNLOAD && (request[0] & BLOCK_END) == 0) {
    sdo_block_download_initiate(server, request);
  } else if (specifier == SDO_CCS_BLOCK_DOWNLOAD && server->state == SDO_BLOCK_DOWNLOAD_END) {
    sdo_block_download_end(server, request);
  } else if (specifier == SDO_CCS_BLOCK_UPLOAD) {
    sdo_block_upload_receive(server, request);
  } else {
    refuse_command(server, request);
  }
}

static bool is_initiate(const uint8_t *request) {
  switch (request[0] >> 5) {
    case SDO_CCS_DOWNLOAD:
    case SDO_CCS_UPLOAD:
      return true;
    case SDO_CCS_BLOCK_DOWNLOAD:
      return (request[0] & BLOCK_END) == 0;
    case SDO_CCS_BLOCK_UPLOAD:
      return (request[0] & BLOCK_UPLOAD_SUBCOMMAND) == 0;
    default:
      return false;
  }
}

/* Needs more than one answer. */
static bool takes_several_requests(const sdo_server *server, const uint8_t *request) {
  const uint8_t specifier = request[0] >> 5;
  if (specifier == SDO_CCS_DOWNLOAD) {
    return is_segmented_download(request);
  }
  od_object object;
  const uint16_t index = (uint16_t)(request[1] | request[2] << 8);
  if (specifier == SDO_CCS_UPLOAD && od_find(server->dictionary, index, request[3], &object) == OD_OK) {
    const uint8_t type = object.entry->type;
    return type == OD_DOMAIN || type == OD_VISIBLE_STRING || object.entry->bytes > EXPEDITED_BYTES;
  }
  return specifier != SDO_CCS_UPLOAD;
}

static bool must_wait(const sdo_server *server, const uint8_t *request) {
  return server->quiet_ms > 0 && takes_several_requests(server, request);
}

/* The previous request has no answer yet, or the answer is not sent, so this request comes from another client. */
static bool is_answering(const sdo_server *server) {
  return server->state == SDO_COMMITTING || (server->reply_waiting && server->state != SDO_BLOCK_UPLOADING);
}

static void hold(sdo_server *server, const uint8_t *request) {
  memcpy(server->held_request, request, SDO_BYTES);
  server->request_held = true;
}

static void begin_or_hold(sdo_server *server, const uint8_t *request) {
  break_off(server);
  if (!must_wait(server, request)) {
    dispatch(server, request);
  } else if (!server->request_held) {
    hold(server, request);
  } else { /* two clients compete: neither gets the channel, and both see the abort */
    take_multiplexer(server, request);
    sdo_server_abort(server, OD_NOT_TRANSFERRED);
    refuse(server, request);
  }
}

static bool can_take_held_request(const sdo_server *server) {
  return server->request_held && !is_answering(server) && !must_wait(server, server->held_request);
}

static void receive_initiate(sdo_server *server, const uint8_t *request) {
  if (is_answering(server)) {
    hold(server, request);
  } else if (can_take_held_request(server)) { /* it came before this one */
    uint8_t first[SDO_BYTES];
    memcpy(first, server->held_request, SDO_BYTES);
    hold(server, request);
    break_off(server);
    dispatch(server, first);
  } else {
    begin_or_hold(server, request);
  }
}

/* An abort that names another object than that of the transfer can come from another client. A client that waits for an
 * answer meanwhile gets one: otherwise it would take the next answer, for another request, as its own. */
static void receive_abort(sdo_server *server, const uint8_t *request) {
  const bool own = server->index == (uint16_t)(request[1] | request[2] << 8) && server->sub == request[3];
  const bool awaited = !own && server->reply_waiting && server->state != SDO_BLOCK_UPLOADING;
  if (own && !server->request_held) {
    end_transfer(server);
  } else if (server->request_held) {
    take_multiplexer(server, server->held_request);
    sdo_server_abort(server, OD_NOT_TRANSFERRED);
  } else if (awaited) {
    sdo_server_abort(server, OD_NOT_TRANSFERRED);
  } else {
    break_off(server);
  }
}

void sdo_server_receive(sdo_server *server, const uint8_t request[SDO_BYTES]) {
  const bool gone = server->silent_ms >= SDO_QUIET_MS;
  if (request[0] == ABORT) {
    receive_abort(server, request);
  } else if (server->state == SDO_BLOCK_DOWNLOADING && !(gone && is_initiate(request))) {
    server->silent_ms = 0;
    sdo_block_download_segment(server, request);
  } else if (is_initiate(request)) {
    receive_initiate(server, request);
  } else if (server->state != SDO_COMMITTING) {
    server->silent_ms = 0;
    dispatch(server, request);
  }
}

const uint8_t *sdo_server_outgoing(sdo_server *server) {
  if (!server->reply_waiting && server->state == SDO_BLOCK_UPLOADING) {
    sdo_block_upload_next_segment(server);
  }
  return server->reply_waiting ? server->reply : NULL;
}

void sdo_server_sent(sdo_server *server) {
  server->reply_waiting = false;
  server->silent_ms = 0;
}

static void take_held_request(sdo_server *server) {
  if (can_take_held_request(server)) {
    uint8_t request[SDO_BYTES];
    memcpy(request, server->held_request, SDO_BYTES);
    server->request_held = false;
    begin_or_hold(server, request);
  }
}

static void monitor_time(sdo_server *server) {
  if (server->state == SDO_IDLE) {
    server->silent_ms = 0;
    return;
  }
  server->silent_ms++;
  if (server->silent_ms >= SDO_TIME_OUT_MS) {
    sdo_server_abort(server, OD_TIME_OUT);
  }
}

void sdo_server_tick(sdo_server *server) {
  server->quiet_ms = (uint8_t)(server->quiet_ms - (server->quiet_ms > 0 ? 1 : 0));
  if (server->state == SDO_COMMITTING) {
    conclude_commit(server, sdo_transfer_commit(&server->transfer));
  } else {
    monitor_time(server);
  }
  take_held_request(server);
}
