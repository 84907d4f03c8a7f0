/* SPDX-License-Identifier: Apache-2.0 */
/* SDO server: reading and writing the object dictionary from the bus.
 *
 * Standard: CiA 301 v4.2.0, clause 7.2.4: expedited, segmented and block transfer in both directions with
 * CRC-16/XMODEM. It does not handle CAN: the node passes the 8 bytes of each request, sends what `sdo_server_outgoing`
 * returns, and advances the time. A transfer that ends with an abort has changed nothing.
 *
 * Two clients on one channel (decision 0019): a request does not identify its sender, and both clients see each
 * answer. So a transfer never passes from one client to the other: an initiate request ends the transfer in progress.
 * Another transfer of several requests begins only when the former client can have no request in transit
 * (SDO_QUIET_MS). A segment request without a transfer is answered with an abort meanwhile, which both clients see. */
#ifndef TRACKSERVO_CANOPEN_SDO_SERVER_H
#define TRACKSERVO_CANOPEN_SDO_SERVER_H

#include "canopen/sdo_transfer.h"

enum {
  SDO_BYTES = 8,
  SDO_TIME_OUT_MS = 1000,
  /* Maximum time until a client sends its next request of a transfer; later it counts as gone. */
  SDO_QUIET_MS = 100,
  /* Segments per block that this server requests in a block download. They must fit into the receive queue at once. The
   * number must be below the first byte of every initiate request, 0x20, so that none is mistaken for a segment. */
  SDO_BLOCK_SEGMENTS = 31
};

typedef enum {
  SDO_IDLE,
  SDO_DOWNLOADING,
  SDO_UPLOADING,
  SDO_BLOCK_DOWNLOADING,  /* within the sub-blocks */
  SDO_BLOCK_DOWNLOAD_END, /* all segments arrived, the end request did not */
  SDO_BLOCK_UPLOAD_START, /* answered; the client has not started the upload yet */
  SDO_BLOCK_UPLOADING,    /* segments are being sent */
  SDO_BLOCK_UPLOAD_ACK,   /* sub-block sent; waits for its confirmation */
  SDO_BLOCK_UPLOAD_END,   /* end sent; waits for its confirmation */
  SDO_COMMITTING          /* the owner has not finished writing; the answer waits */
} sdo_state;

typedef struct {
  const object_dictionary *dictionary;
  sdo_state state;
  sdo_transfer transfer;
  uint16_t index; /* of the transfer, or of the last request */
  uint8_t sub;
  bool toggle;        /* expected in the next segment request */
  uint32_t offset;    /* next byte to upload */
  uint16_t silent_ms; /* since the last received or sent frame */

  /* Block transfer */
  uint32_t block_offset; /* first byte of the sub-block being uploaded */
  uint8_t block_size;    /* segments of a sub-block */
  uint8_t sequence;      /* last segment sent or accepted */
  bool use_crc;
  uint16_t crc;
  uint32_t crc_offset; /* bytes included in the CRC of an upload, so that repeated bytes count once */
  bool holding;        /* the last segment waits in `held`: only the end request says how much of it is data */
  uint8_t held[SDO_BYTES - 1];

  /* Two clients */
  uint8_t quiet_ms; /* time left before a transfer of several requests may begin */
  bool request_held;
  uint8_t
      held_request[SDO_BYTES]; /* an initiate request that waits for that time, or for the answer to another request */

  uint8_t reply[SDO_BYTES];
  bool reply_waiting;
} sdo_server;

void sdo_server_init(sdo_server *server, const object_dictionary *dictionary);

/* Drops the transfer without an abort to the client. */
void sdo_server_reset(sdo_server *server);

/* Takes a request of exactly 8 bytes. A client that crashed during a transfer blocks nobody: an expedited request is
 * answered at once, any other within SDO_QUIET_MS. */
void sdo_server_receive(sdo_server *server, const uint8_t request[SDO_BYTES]);

/* Returns the 8 bytes to send next, or NULL. They stay until `sdo_server_sent`. */
const uint8_t *sdo_server_outgoing(sdo_server *server);
void sdo_server_sent(sdo_server *server);

/* Returns whether an owner has answered OD_PENDING and has not ended yet. */
static inline bool sdo_server_commits(const sdo_server *server) { return server->state == SDO_COMMITTING; }

/* Handles the time-out (abort 0504 0000), and calls an owner again who returned OD_PENDING. Call once per ms. */
void sdo_server_tick(sdo_server *server);

#endif
