/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/emergency.h"

#include <string.h>

#include "canopen/cob_id.h"

static void update_register(const emergency_producer *self, emergency_objects *objects) {
  uint8_t bits = 0;
  /* Bound: EMERGENCY_ACTIVE: none is added beyond it. */
  for (uint8_t i = 0; i < self->active_count; i++) {
    bits = (uint8_t)(bits | self->active[i].register_bits | ERROR_GENERIC);
  }
  objects->error_register = bits;
}

static void remember(emergency_objects *objects, const emergency_error *error) {
  memmove(&objects->history[1], &objects->history[0], sizeof objects->history - sizeof objects->history[0]);
  objects->history[0] = error->code | (uint32_t)error->detail << 16 | (uint32_t)error->source << 24;
  if (objects->count < EMERGENCY_HISTORY) {
    objects->count++;
  }
}

static void report(emergency_producer *self, const emergency_objects *objects, const emergency_error *error) {
  if (self->waiting_count == EMERGENCY_WAITING) {
    if (self->dropped < UINT16_MAX) {
      self->dropped++;
    }
    return;
  }
  uint8_t *message = self->waiting[(self->waiting_first + self->waiting_count) % EMERGENCY_WAITING];
  self->waiting_count++;
  memset(message, 0, CAN_FRAME_BYTES);
  message[0] = (uint8_t)error->code;
  message[1] = (uint8_t)(error->code >> 8);
  message[2] = objects->error_register;
  message[3] = error->detail;
  message[4] = error->source;
  message[5] = (uint8_t)(error->object >> 8);
  message[6] = (uint8_t)(error->object >> 16);
  message[7] = (uint8_t)error->object;
}

/* Index of an error among the active ones; active_count when it is not active. */
static uint8_t find(const emergency_producer *self, uint8_t source, uint16_t code) {
  uint8_t i = 0;
  /* Bound: EMERGENCY_ACTIVE: none is added beyond it. */
  while (i < self->active_count && (self->active[i].code != code || self->active[i].source != source)) {
    i++;
  }
  return i;
}

void emergency_reset(emergency_producer *self, emergency_objects *objects) {
  *self = (emergency_producer){.active_count = 0};
  objects->error_register = 0;
}

bool emergency_raise(emergency_producer *self, emergency_objects *objects, const emergency_error *error) {
  if (self->active_count == EMERGENCY_ACTIVE || emergency_is_active(self, error->source, error->code)) {
    return false;
  }
  self->active[self->active_count] = *error;
  self->active_count++;
  update_register(self, objects);
  remember(objects, error);
  report(self, objects, error);
  return true;
}

bool emergency_raise_again(emergency_producer *self, emergency_objects *objects, const emergency_error *error) {
  const uint8_t place = find(self, error->source, error->code);
  if (place == self->active_count) {
    return emergency_raise(self, objects, error);
  }
  self->active[place].register_bits |= error->register_bits;
  update_register(self, objects);
  remember(objects, error);
  report(self, objects, error);
  return true;
}

bool emergency_clear(emergency_producer *self, emergency_objects *objects, uint8_t source, uint16_t code) {
  const uint8_t place = find(self, source, code);
  if (place == self->active_count) {
    return false;
  }
  self->active_count--;
  self->active[place] = self->active[self->active_count];
  update_register(self, objects);
  report(self, objects, &(emergency_error){.code = EMERGENCY_NONE, .source = source});
  return true;
}

bool emergency_is_active(const emergency_producer *self, uint8_t source, uint16_t code) {
  return find(self, source, code) < self->active_count;
}

void emergency_tick(emergency_producer *self, const emergency_objects *objects, const can_sender *sender) {
  if (self->inhibit_ms > 0) {
    self->inhibit_ms--;
  }
  if (self->waiting_count == 0 || self->inhibit_ms > 0) {
    return;
  }
  if ((objects->cob_id & COB_ID_INVALID) == 0) {
    can_frame frame = {.id = objects->cob_id & COB_ID_IDENTIFIER, .length = CAN_FRAME_BYTES};
    memcpy(frame.data, self->waiting[self->waiting_first], CAN_FRAME_BYTES);
    if (!sender->send(sender->context, &frame)) {
      return;
    }
    self->inhibit_ms = (uint16_t)((objects->inhibit_100us + 9u) / 10u);
  }
  self->waiting_first = (uint8_t)((self->waiting_first + 1u) % EMERGENCY_WAITING);
  self->waiting_count--;
}
