/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/rpdo.h"

#include <string.h>

#include "canopen/cob_id.h"

void rpdo_reset(rpdo *self) {
  self->heard = false;
  self->late = false;
  self->wrong_length = false;
  self->waiting = false;
  self->silent_ms = 0;
  self->refused_object = 0;
  self->was_too_short = false;
  self->was_refused = 0;
}

static bool speaks(const pdo_map *map) {
  bool measures = map->count > 0;
  /* Bound: PDO_OBJECTS. */
  for (uint32_t i = 0; i < map->count; i++) {
    const od_part *part = map->item[i].object.part;
    measures = measures && part != NULL && part->measures;
  }
  return !measures;
}

void rpdo_configure(rpdo *self, const object_dictionary *dictionary, const pdo_communication *communication,
                    const pdo_mapping *mapping) {
  (void)pdo_resolve(dictionary, PDO_RECEIVE, mapping, &self->map);
  const bool valid = cob_id_is_valid(communication->cob_id);
  self->on = valid && self->map.count > 0;
  self->speaks = speaks(&self->map);
  self->synchronous = pdo_is_synchronous(communication);
  self->monitored_ms = valid ? communication->event_ms : 0;
  rpdo_reset(self);
}

static rpdo_verdict apply(rpdo *self, const uint8_t *bytes) {
  od_object refused = {NULL, NULL};
  self->refused_object = 0;
  if (pdo_scatter(&self->map, bytes, &refused) == OD_OK) {
    return RPDO_APPLIED;
  }
  self->refused++;
  self->refused_object = (uint32_t)od_index(&refused) << 8 | refused.entry->sub;
  self->was_refused = self->refused_object;
  return RPDO_REFUSED;
}

bool rpdo_must_wait(const rpdo *self, const can_frame *frame) {
  if (frame == NULL) {
    return self->waiting && pdo_must_wait(&self->map, self->bytes);
  }
  return self->on && !self->synchronous && frame->length >= self->map.length && pdo_must_wait(&self->map, frame->data);
}

void rpdo_obey_stops(rpdo *self, const can_frame *frame) {
  (void)pdo_obey_stops(&self->map, frame == NULL ? self->bytes : frame->data, self->map.length);
  self->waiting = self->waiting && frame != NULL;
}

rpdo_verdict rpdo_receive(rpdo *self, const can_frame *frame) {
  if (!self->on) {
    return RPDO_IGNORED;
  }
  if (frame->length < self->map.length) {
    self->wrong_length = true;
    self->was_too_short = true;
    if (pdo_obey_stops(&self->map, frame->data, frame->length)) {
      self->waiting = false; /* an earlier command must not undo the stop at the next SYNC */
    }
    return RPDO_TOO_SHORT;
  }
  self->heard = true;
  self->late = false;
  self->wrong_length = false;
  self->silent_ms = 0;
  if (!self->synchronous) {
    return apply(self, frame->data);
  }
  if (self->waiting) { /* the newer frame replaces the one before, but not a stop in it */
    (void)pdo_obey_stops(&self->map, self->bytes, self->map.length);
  }
  memcpy(self->bytes, frame->data, CAN_FRAME_BYTES);
  self->waiting = true;
  return RPDO_WAITS;
}

rpdo_verdict rpdo_sync(rpdo *self) {
  if (!self->waiting) {
    return RPDO_IGNORED;
  }
  self->waiting = false;
  return apply(self, self->bytes);
}

rpdo_errors rpdo_take_errors(rpdo *self) {
  const rpdo_errors errors = {.short_one = self->wrong_length || self->was_too_short,
                              .refused_object = self->refused_object != 0 ? self->refused_object : self->was_refused};
  self->was_too_short = false;
  self->was_refused = 0;
  return errors;
}

bool rpdo_tick(rpdo *self) {
  if (!rpdo_is_monitored(self)) {
    return false;
  }
  self->silent_ms++;
  self->late = self->silent_ms >= self->monitored_ms;
  return self->late;
}
