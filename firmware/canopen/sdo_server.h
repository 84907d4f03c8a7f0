/* SDO server: reading and writing the object dictionary from the bus.
 *
 * Standard: CiA 301 v4.2.0, clause 7.2.4: expedited, segmented and block transfer in both directions with
 * CRC-16/XMODEM. It knows no CAN: the node gives it the 8 bytes of each request, sends what `sdo_server_outgoing`
 * shows, and tells it the time; whatever ends in an abort has changed nothing.
 *
 * Two clients on one channel (docs/decisions/0019): nothing in a request says who sent it, and both clients see each
 * answer. So a transfer never passes from one client to the other: an initiate request ends a transfer that goes on,
 * and another transfer of several requests begins only when the former client can have no request on its way any more
 * (SDO_QUIET_MS). A segment request that meets no transfer meanwhile is answered with an abort, which both see. */
#ifndef TRACKSERVO_CANOPEN_SDO_SERVER_H
#define TRACKSERVO_CANOPEN_SDO_SERVER_H

#include "canopen/sdo_transfer.h"

enum {
  SDO_BYTES = 8,
  SDO_TIME_OUT_MS = 1000,
  /* Longest time in which a client sends its next request of a transfer, else it is taken for gone. */
  SDO_QUIET_MS = 100,
  /* What this server asks of a block download: must fit the receive queue in one go, and be below the first byte of
   * each initiate request, 0x20, so that none is taken for a segment. */
  SDO_BLOCK_SEGMENTS = 31
};

typedef enum {
  SDO_IDLE,
  SDO_DOWNLOADING,
  SDO_UPLOADING,
  SDO_BLOCK_DOWNLOADING,  /* within the sub-blocks */
  SDO_BLOCK_DOWNLOAD_END, /* all segments are here, the end request is not */
  SDO_BLOCK_UPLOAD_START, /* answered, the client has not started it yet */
  SDO_BLOCK_UPLOADING,    /* segments go out */
  SDO_BLOCK_UPLOAD_ACK,   /* sub-block sent, waiting for its confirmation */
  SDO_BLOCK_UPLOAD_END,   /* end sent, waiting for its confirmation */
  SDO_COMMITTING          /* the owner has not finished writing, the answer waits */
} sdo_state;

typedef struct {
  const object_dictionary *dictionary;
  sdo_state state;
  sdo_transfer transfer;
  uint16_t index; /* of the transfer, or of the last request */
  uint8_t sub;
  bool toggle;        /* expected in the next segment request */
  uint32_t offset;    /* next byte to upload */
  uint16_t silent_ms; /* since a frame came or went */

  /* Block transfer */
  uint32_t block_offset; /* first byte of the sub-block being uploaded */
  uint8_t block_size;    /* segments of a sub-block */
  uint8_t sequence;      /* last segment sent or accepted */
  bool use_crc;
  uint16_t crc;
  uint32_t crc_offset; /* bytes in the CRC of an upload, so that what is sent again counts once */
  bool holding;        /* the last segment waits in `held`: only the end says how much of it is data */
  uint8_t held[SDO_BYTES - 1];

  /* Two clients */
  uint8_t quiet_ms; /* still to pass before a transfer of several requests may begin */
  bool request_held;
  uint8_t held_request[SDO_BYTES]; /* an initiate request that waits for that, or for the answer to another one */

  uint8_t reply[SDO_BYTES];
  bool reply_waiting;
} sdo_server;

void sdo_server_init(sdo_server *server, const object_dictionary *dictionary);

/* Gives up what goes on, without telling the client. */
void sdo_server_reset(sdo_server *server);

/* A request of exactly 8 bytes. A client that crashed half-way hinders nobody: an expedited request is answered at
 * once, any other within SDO_QUIET_MS. */
void sdo_server_receive(sdo_server *server, const uint8_t request[SDO_BYTES]);

/* The 8 bytes to send next, or NULL. They stay until `sdo_server_sent`. */
const uint8_t *sdo_server_outgoing(sdo_server *server);
void sdo_server_sent(sdo_server *server);

/* One ms: time-out (abort 0504 0000), and asking again an owner who said OD_PENDING. */
void sdo_server_tick(sdo_server *server);

#endif
