#include "canopen/heard_frames.h"

#include <stddef.h>

const heard_range heard_ranges[HEARD_RANGES] = {
    {0x000, 0x000, false}, /* NMT */
    {0x080, 0x100, true},  /* SYNC, EMCY, TIME */
    {0x181, 0x580, true},  /* PDOs */
    {0x600, 0x600, true},
    {0x601, 0x67F, false}, /* SDO requests to each node id */
    {0x680, 0x6DF, true},
    {0x700, 0x700, true},
    {0x701, 0x77F, false}, /* heartbeats */
    {HEARD_LSS_REQUEST, HEARD_LSS_REQUEST, false},
};

static const heard_range *find(uint32_t identifier) {
  const heard_range *found = NULL;
  for (uint32_t i = 0; i < HEARD_RANGES; i++) {
    if (identifier >= heard_ranges[i].first && identifier <= heard_ranges[i].last) {
      found = &heard_ranges[i];
    }
  }
  return found;
}

bool heard_frame(const can_frame *frame) { return frame->flags == 0 && find(frame->id) != NULL; }

bool heard_identifier_is_free(uint32_t identifier) {
  const heard_range *range = find(identifier);
  return range != NULL && range->free;
}
