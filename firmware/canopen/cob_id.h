/* SPDX-License-Identifier: Apache-2.0 */
/* COB-IDs as the objects hold them: an identifier and the flags in the bits above it.
 *
 * Standard: CiA 301 v4.2.0, clause 7.5.2 (bit 31: not valid). PDO, SYNC and EMCY use it to check a written COB-ID and
 * to compare frames with it. */
#ifndef TRACKSERVO_CANOPEN_COB_ID_H
#define TRACKSERVO_CANOPEN_COB_ID_H

#include "canopen/heard_frames.h"

#define COB_ID_INVALID 0x80000000u
#define COB_ID_NO_REMOTE 0x40000000u
#define COB_ID_EXTENDED 0x20000000u
#define COB_ID_IDENTIFIER 0x000007FFu

static inline bool cob_id_is_valid(uint32_t cob_id) { return (cob_id & COB_ID_INVALID) == 0; }

/* Returns whether a PDO, SYNC, EMCY or further SDO channel may use this 11-bit identifier, so that the node must be
 * able to receive it. */
static inline bool cob_id_is_allowed(uint32_t cob_id) {
  const uint32_t beyond_11_bits = 0x1FFFF800u;
  return (cob_id & (COB_ID_EXTENDED | beyond_11_bits)) == 0 && heard_identifier_is_free(cob_id & COB_ID_IDENTIFIER);
}

#endif
