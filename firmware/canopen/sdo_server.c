#include "canopen/sdo_server.h"

#include <string.h>

#include "canopen/sdo_protocol.h"

/* Fields of the first byte. */
enum {
  EXPEDITED = 0x02,
  SIZE_GIVEN = 0x01,
  LAST_SEGMENT = 0x01,
  TOGGLE = 0x10,
  BLOCK_END = 0x01, /* of a block download: end instead of initiate */
  ANSWER_DOWNLOAD = 0x60,
  ANSWER_DOWNLOAD_SEGMENT = 0x20,
  ANSWER_UPLOAD = 0x40,
  ABORT = 0x80
};

uint32_t sdo_get_u32(const uint8_t *bytes) {
  return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

void sdo_put_u32(uint8_t *bytes, uint32_t value) {
  for (uint32_t i = 0; i < 4; i++) {
    bytes[i] = (uint8_t)(value >> (8 * i));
  }
}

void sdo_server_init(sdo_server *server, const object_dictionary *dictionary) {
  *server = (sdo_server){.dictionary = dictionary, .state = SDO_IDLE};
}

void sdo_server_reset(sdo_server *server) {
  sdo_transfer_close(&server->transfer);
  server->state = SDO_IDLE;
  server->reply_waiting = false;
  server->silent_ms = 0;
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

void sdo_server_abort(sdo_server *server, od_abort code) {
  sdo_server_reset(server);
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
  sdo_server_reset(server);
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

/* An expedited download may leave its length open: then it is the type's, as far as four bytes reach. */
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
    size = expedited ? 4u - (command >> 2 & 3u) : sdo_get_u32(&request[4]);
  }
  if (!sdo_server_open(server, request, true, size)) {
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
  const bool expedited = size >= 1 && size <= 4;
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

void sdo_server_receive(sdo_server *server, const uint8_t request[SDO_BYTES]) {
  if (request[0] == ABORT) {
    sdo_server_reset(server);
    return;
  }
  if (server->state == SDO_COMMITTING) {
    return; /* the answer to the last request is still being worked out */
  }
  server->silent_ms = 0;
  if (server->state == SDO_BLOCK_DOWNLOADING) {
    sdo_block_download_segment(server, request);
  } else {
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

void sdo_server_tick(sdo_server *server) {
  if (server->state == SDO_COMMITTING) {
    conclude_commit(server, sdo_transfer_commit(&server->transfer));
    return;
  }
  if (server->state == SDO_IDLE) {
    server->silent_ms = 0;
    return;
  }
  server->silent_ms++;
  if (server->silent_ms >= SDO_TIME_OUT_MS) {
    sdo_server_abort(server, OD_TIME_OUT);
  }
}
