/* SPDX-License-Identifier: Apache-2.0 */
/* The data of one SDO transfer: a value through a small buffer, or a DOMAIN through its owner's stream.
 *
 * Standard: CiA 301 v4.2.0, clause 7.2.4 leaves the source of the bytes open; this file hides it from the protocols.
 * The SDO server opens a transfer, moves bytes, and commits or cancels: until the commit the object is unchanged. */
#ifndef TRACKSERVO_CANOPEN_SDO_TRANSFER_H
#define TRACKSERVO_CANOPEN_SDO_TRANSFER_H

#include "canopen/object_dictionary.h"

enum { SDO_BUFFER_BYTES = 64 }; /* maximum length of a VISIBLE_STRING that can be read or written */

typedef struct {
  od_object object;
  bool open;
  bool writing;
  uint32_t size;     /* all bytes when reading; announced when writing, or OD_SIZE_UNKNOWN */
  uint32_t position; /* bytes written so far */
  uint8_t buffer[SDO_BUFFER_BYTES];
} sdo_transfer;

od_abort sdo_transfer_open_read(sdo_transfer *transfer, const od_object *object);

/* Reads any piece within the size, in any order. */
od_abort sdo_transfer_read(sdo_transfer *transfer, uint32_t offset, uint8_t *bytes, uint32_t length);

/* Opens a write. Refuses at once what cannot succeed: wrong access or announced size. */
od_abort sdo_transfer_open_write(sdo_transfer *transfer, const od_object *object, uint32_t announced_size);

od_abort sdo_transfer_append(sdo_transfer *transfer, const uint8_t *bytes, uint32_t length);

/* Writes the object. Call again in the next tick after OD_PENDING; any other result ends the transfer. */
od_abort sdo_transfer_commit(sdo_transfer *transfer);

/* Ends a transfer that was read, or a write that is abandoned. Has no effect when none is open. */
void sdo_transfer_close(sdo_transfer *transfer);

#endif
