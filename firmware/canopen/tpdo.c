/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/tpdo.h"

#include <string.h>

#include "canopen/cob_id.h"

void tpdo_reset(tpdo *self) {
  self->event = true;
  self->due = 0;
  self->waiting = false;
  self->sync_started = false;
  self->sync_count = 0;
  self->inhibit_ms = 0;
  self->elapsed_ms = 0;
}

void tpdo_configure(tpdo *self, const object_dictionary *dictionary, const pdo_communication *communication,
                    const pdo_mapping *mapping) {
  (void)pdo_resolve(dictionary, PDO_TRANSMIT, mapping, &self->map);
  self->communication = communication;
  self->on = self->map.count > 0 && cob_id_is_valid(communication->cob_id);
  self->synchronous = pdo_is_synchronous(communication);
  self->frame = (can_frame){.id = communication->cob_id & COB_ID_IDENTIFIER, .length = self->map.length};
  tpdo_reset(self);
}

void tpdo_request(tpdo *self) { self->event = true; }

/* Of more SYNCs in one ms the bus has no room for the answers of every TPDO. */
enum { SYNCS_AT_ONCE = 4 };

static bool send(tpdo *self, const can_sender *sender) {
  self->waiting = !sender->send(sender->context, &self->frame);
  return !self->waiting;
}

/* Whether a byte that matters differs from the last frame. */
static bool has_changed(const tpdo *self, const uint8_t *bytes) {
  if (memcmp(bytes, self->frame.data, CAN_FRAME_BYTES) == 0) {
    return false;
  }
  /* Bound: 8 bytes of a frame: a mapping is refused beyond them. */
  for (uint8_t i = 0; i < self->map.length; i++) {
    if ((self->map.event_mask >> i & 1u) != 0 && bytes[i] != self->frame.data[i]) {
      return true;
    }
  }
  return false;
}

static bool sync_is_due(tpdo *self, uint8_t counter) {
  const pdo_communication *communication = self->communication;
  if (communication->type == PDO_SYNC_ACYCLIC) {
    return true; /* if something has changed by then */
  }
  if (!self->sync_started) {
    const bool any = communication->sync_start == 0 || counter == 0;
    if (!any && counter != communication->sync_start) {
      return false;
    }
    self->sync_started = true;
    /* With a start value, the SYNC that carries it is already answered. */
    self->sync_count = any ? 0 : (uint8_t)(communication->type - 1u);
  }
  self->sync_count++;
  if (self->sync_count < communication->type) {
    return false;
  }
  self->sync_count = 0;
  return true;
}

void tpdo_sync(tpdo *self, uint8_t counter) {
  if (self->on && self->synchronous && sync_is_due(self, counter)) {
    const bool once = self->communication->type == PDO_SYNC_ACYCLIC;
    self->due = once ? 1 : (uint8_t)(self->due + (self->due < SYNCS_AT_ONCE ? 1 : 0));
  }
}

static void tick_by_sync(tpdo *self, const can_sender *sender) {
  const uint8_t due = self->due;
  if (due == 0) {
    if (self->waiting) {
      (void)send(self, sender);
    }
    return;
  }
  self->due = 0;
  uint8_t bytes[CAN_FRAME_BYTES] = {0};
  pdo_gather(&self->map, bytes);
  if (self->communication->type == PDO_SYNC_ACYCLIC && !self->event && !has_changed(self, bytes)) {
    return;
  }
  self->event = false;
  memcpy(self->frame.data, bytes, sizeof bytes);
  /* Bound: SYNCS_AT_ONCE. */
  for (uint8_t i = 0; i < due; i++) { /* one per SYNC, however fast they come */
    (void)send(self, sender);
  }
}

static void tick_by_event(tpdo *self, const can_sender *sender) {
  const pdo_communication *communication = self->communication;
  if (self->elapsed_ms < UINT16_MAX) {
    self->elapsed_ms++;
  }
  if (self->inhibit_ms > 0) {
    self->inhibit_ms--;
  }
  const bool timer = communication->event_ms != 0 && self->elapsed_ms >= communication->event_ms;
  self->event = self->event || timer || self->waiting;
  const bool may_send = self->inhibit_ms == 0;
  const bool looks_on = !self->event && self->map.event_mask != 0;
  if (!looks_on && !(self->event && may_send)) {
    return; /* no SYNC requests the current values */
  }
  uint8_t bytes[CAN_FRAME_BYTES] = {0};
  pdo_gather(&self->map, bytes);
  self->event = self->event || has_changed(self, bytes);
  if (!self->event || !may_send) {
    return;
  }
  memcpy(self->frame.data, bytes, sizeof bytes);
  if (send(self, sender)) {
    self->event = false;
    self->elapsed_ms = 0;
    self->inhibit_ms = (uint16_t)((communication->inhibit_100us + 9u) / 10u);
  }
}

void tpdo_tick(tpdo *self, const can_sender *sender) {
  if (!self->on) {
    return;
  }
  if (self->synchronous) {
    tick_by_sync(self, sender);
  } else {
    tick_by_event(self, sender);
  }
}
