/* COB-IDs as the objects hold them: an identifier and what the bits above it say.
 *
 * Standard: CiA 301 v4.2.0, clause 7.5.2 (bit 31: not valid) and table 40 (identifiers that stay reserved). Used by
 * PDO, SYNC and EMCY to judge a written COB-ID and to compare frames with it. */
#ifndef TRACKSERVO_CANOPEN_COB_ID_H
#define TRACKSERVO_CANOPEN_COB_ID_H

#include "canopen/can_frame.h"

#define COB_ID_INVALID 0x80000000u
#define COB_ID_NO_REMOTE 0x40000000u
#define COB_ID_EXTENDED 0x20000000u
#define COB_ID_IDENTIFIER 0x000007FFu

static inline bool cob_id_is_valid(uint32_t cob_id) { return (cob_id & COB_ID_INVALID) == 0; }

/* An 11-bit identifier that a PDO, SYNC or EMCY may have. */
static inline bool cob_id_is_allowed(uint32_t cob_id) {
  static const struct {
    uint16_t first;
    uint16_t last;
  } reserved[] = {{0x000, 0x07F}, {0x101, 0x180}, {0x581, 0x5FF}, {0x601, 0x67F}, {0x6E0, 0x7FF}};
  if ((cob_id & COB_ID_EXTENDED) != 0 || (cob_id & 0x1FFFF800u) != 0) {
    return false;
  }
  const uint32_t id = cob_id & COB_ID_IDENTIFIER;
  for (uint32_t i = 0; i < sizeof reserved / sizeof reserved[0]; i++) {
    if (id >= reserved[i].first && id <= reserved[i].last) {
      return false;
    }
  }
  return true;
}

#endif
