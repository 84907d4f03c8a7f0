/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the SDO server share: command specifiers, answers, and the two block protocols.
 *
 * Standard: CiA 301 v4.2.0, clause 7.2.4.3, figures 29 to 45. For sdo_server.c, sdo_block_download.c and
 * sdo_block_upload.c only. */
#ifndef TRACKSERVO_CANOPEN_SDO_PROTOCOL_H
#define TRACKSERVO_CANOPEN_SDO_PROTOCOL_H

#include "canopen/sdo_server.h"

enum { SDO_SEGMENT_BYTES = 7, SDO_BLOCK_SEGMENTS_MAX = 127 };

/* Client command specifiers, upper three bits of the first byte. */
enum {
  SDO_CCS_DOWNLOAD_SEGMENT = 0,
  SDO_CCS_DOWNLOAD = 1,
  SDO_CCS_UPLOAD = 2,
  SDO_CCS_UPLOAD_SEGMENT = 3,
  SDO_CS_ABORT = 4,
  SDO_CCS_BLOCK_UPLOAD = 5,
  SDO_CCS_BLOCK_DOWNLOAD = 6
};

/* Ends the transfer and answers with an abort. */
void sdo_server_abort(sdo_server *server, od_abort code);

/* Clears the reply, sets its first byte and marks it to be sent. */
void sdo_server_answer(sdo_server *server, uint8_t command);
void sdo_server_put_multiplexer(sdo_server *server);

/* Commits what was downloaded; `command` is the first byte of the answer when that succeeds. */
void sdo_server_commit(sdo_server *server, uint8_t command, bool with_multiplexer);

/* Finds the object that the request names and opens it; on a refusal an abort is prepared. */
bool sdo_server_open(sdo_server *server, const uint8_t *request, bool writing, uint32_t size);

/* Returns the announced size in an initiate request. FFFFFFFFh is a size, too, and not "unknown". */
uint32_t sdo_announced_size(const uint8_t *request);

uint32_t sdo_get_u32(const uint8_t *bytes);
void sdo_put_u32(uint8_t *bytes, uint32_t value);

void sdo_block_download_initiate(sdo_server *server, const uint8_t *request);
void sdo_block_download_segment(sdo_server *server, const uint8_t *request);
void sdo_block_download_end(sdo_server *server, const uint8_t *request);

/* Takes a request to initiate, start, confirm or end, from the lowest two bits of the request. */
void sdo_block_upload_receive(sdo_server *server, const uint8_t *request);
void sdo_block_upload_next_segment(sdo_server *server);

#endif
