/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/heard_frames.h"

const can_id_range heard_ranges[HEARD_RANGES] = {
    {0x000, 0x000}, /* NMT */
    {0x080, 0x100}, /* SYNC, EMCY, TIME */
    {0x181, 0x580}, /* PDOs */
    {0x600, 0x600},
    {0x601, 0x67F}, /* SDO requests to each node id */
    {0x680, 0x6DF},
    {0x700, 0x700},
    {0x701, 0x77F}, /* heartbeats */
    {HEARD_LSS_REQUEST, HEARD_LSS_REQUEST},
};

/* Whether PDO, SYNC, EMCY and further SDO channels may have the identifiers of a range. */
static const bool is_free[HEARD_RANGES] = {[1] = true, [2] = true, [3] = true, [5] = true, [6] = true};

/* HEARD_RANGES: in none. */
static uint32_t range_of(uint32_t identifier) {
  uint32_t found = HEARD_RANGES;
  for (uint32_t i = 0; i < HEARD_RANGES; i++) {
    if (identifier >= heard_ranges[i].first && identifier <= heard_ranges[i].last) {
      found = i;
    }
  }
  return found;
}

bool heard_frame(const can_frame *frame) { return frame->flags == 0 && range_of(frame->id) < HEARD_RANGES; }

bool heard_identifier_is_free(uint32_t identifier) {
  const uint32_t range = range_of(identifier);
  return range < HEARD_RANGES && is_free[range];
}
