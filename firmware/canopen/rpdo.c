#include "canopen/rpdo.h"

#include <string.h>

#include "canopen/cob_id.h"

void rpdo_reset(rpdo *self) {
  self->heard = false;
  self->late = false;
  self->wrong_length = false;
  self->waiting = false;
  self->silent_ms = 0;
}

void rpdo_configure(rpdo *self, const object_dictionary *dictionary, const pdo_mapping *mapping) {
  (void)pdo_resolve(dictionary, PDO_RECEIVE, mapping, &self->map);
  rpdo_reset(self);
}

static rpdo_verdict apply(rpdo *self) {
  if (pdo_scatter(&self->map, self->bytes) == OD_OK) {
    return RPDO_APPLIED;
  }
  self->refused++;
  return RPDO_REFUSED;
}

rpdo_verdict rpdo_receive(rpdo *self, const pdo_communication *communication, const can_frame *frame) {
  if (self->map.count == 0 || !cob_id_matches(communication->cob_id, frame)) {
    return RPDO_IGNORED;
  }
  if (frame->length < self->map.length) {
    self->wrong_length = true;
    return RPDO_TOO_SHORT;
  }
  self->heard = true;
  self->late = false;
  self->wrong_length = false;
  self->silent_ms = 0;
  memcpy(self->bytes, frame->data, CAN_FRAME_BYTES);
  if (pdo_is_synchronous(communication)) {
    self->waiting = true;
    return RPDO_WAITS;
  }
  return apply(self);
}

rpdo_verdict rpdo_sync(rpdo *self) {
  if (!self->waiting) {
    return RPDO_IGNORED;
  }
  self->waiting = false;
  return apply(self);
}

bool rpdo_tick(rpdo *self, const pdo_communication *communication) {
  const bool watched = cob_id_is_valid(communication->cob_id) && communication->event_ms != 0;
  if (!watched || !self->heard || self->late) {
    return false;
  }
  self->silent_ms++;
  self->late = self->silent_ms >= communication->event_ms;
  return self->late;
}
