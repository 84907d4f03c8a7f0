#include "canopen/tpdo.h"

#include <string.h>

#include "canopen/cob_id.h"

void tpdo_reset(tpdo *self) {
  self->event = true;
  self->waiting = false;
  self->sync_started = false;
  self->sync_count = 0;
  self->inhibit_ms = 0;
  self->elapsed_ms = 0;
}

void tpdo_configure(tpdo *self, const object_dictionary *dictionary, const pdo_mapping *mapping) {
  (void)pdo_resolve(dictionary, PDO_TRANSMIT, mapping, &self->map);
  memset(self->bytes, 0, sizeof self->bytes);
  tpdo_reset(self);
}

void tpdo_request(tpdo *self) { self->event = true; }

static bool is_active(const tpdo *self, const pdo_communication *communication) {
  return self->map.count > 0 && cob_id_is_valid(communication->cob_id);
}

static bool send(tpdo *self, const pdo_communication *communication, const can_sender *sender) {
  can_frame frame = {.id = communication->cob_id & COB_ID_IDENTIFIER, .length = self->map.length};
  memcpy(frame.data, self->bytes, CAN_FRAME_BYTES);
  self->waiting = !sender->send(sender->context, &frame);
  return !self->waiting;
}

/* Does a byte that matters differ from the last frame? */
static bool has_changed(const tpdo *self, const uint8_t *bytes) {
  for (uint8_t i = 0; i < self->map.length; i++) {
    if ((self->map.event_mask >> i & 1u) != 0 && bytes[i] != self->bytes[i]) {
      return true;
    }
  }
  return false;
}

static bool sync_is_due(tpdo *self, const pdo_communication *communication, uint8_t counter) {
  if (communication->type == PDO_SYNC_ACYCLIC) {
    return self->event;
  }
  if (!self->sync_started) {
    const bool any = communication->sync_start == 0 || counter == 0;
    if (!any && counter != communication->sync_start) {
      return false;
    }
    self->sync_started = true;
    /* With a start value, the SYNC that carries it is already one to answer. */
    self->sync_count = any ? 0 : (uint8_t)(communication->type - 1u);
  }
  self->sync_count++;
  if (self->sync_count < communication->type) {
    return false;
  }
  self->sync_count = 0;
  return true;
}

void tpdo_sync(tpdo *self, const pdo_communication *communication, uint8_t counter, const can_sender *sender) {
  if (!is_active(self, communication) || !pdo_is_synchronous(communication)) {
    return;
  }
  if (communication->type == PDO_SYNC_ACYCLIC) { /* the others need not know whether something has changed */
    uint8_t bytes[CAN_FRAME_BYTES];
    pdo_gather(&self->map, bytes);
    self->event = self->event || has_changed(self, bytes);
  }
  if (sync_is_due(self, communication, counter)) {
    pdo_gather(&self->map, self->bytes);
    self->event = false;
    (void)send(self, communication, sender);
  }
}

static void tick_by_event(tpdo *self, const pdo_communication *communication, const can_sender *sender) {
  uint8_t bytes[CAN_FRAME_BYTES];
  pdo_gather(&self->map, bytes);
  if (self->elapsed_ms < UINT16_MAX) {
    self->elapsed_ms++;
  }
  if (self->inhibit_ms > 0) {
    self->inhibit_ms--;
  }
  const bool timer = communication->event_ms != 0 && self->elapsed_ms >= communication->event_ms;
  self->event = self->event || timer || self->waiting || has_changed(self, bytes);
  if (!self->event || self->inhibit_ms > 0) {
    return;
  }
  memcpy(self->bytes, bytes, sizeof bytes);
  if (send(self, communication, sender)) {
    self->event = false;
    self->elapsed_ms = 0;
    self->inhibit_ms = (uint16_t)((communication->inhibit_100us + 9u) / 10u);
  }
}

void tpdo_tick(tpdo *self, const pdo_communication *communication, const can_sender *sender) {
  if (!is_active(self, communication)) {
    return;
  }
  if (!pdo_is_synchronous(communication)) {
    tick_by_event(self, communication, sender);
  } else if (self->waiting) {
    (void)send(self, communication, sender);
  }
}
