/* SPDX-License-Identifier: Apache-2.0 */
#include "node/waiting_stops.h"

#include "drive/drive_state.h"

static uint16_t both(uint16_t a, uint16_t b) {
  return (uint16_t)((a & b & ~DRIVE_CONTROL_HALT) | ((a | b) & DRIVE_CONTROL_HALT));
}

void waiting_stops_add(waiting_stops *self, uint16_t controlword) {
  if (self->count == WAITING_STOPS) {
    self->word[WAITING_STOPS - 1] = both(self->word[WAITING_STOPS - 1], controlword);
  } else if (self->count == 0 || self->word[self->count - 1] != controlword) {
    self->word[self->count] = controlword;
    self->count++;
  }
}

uint16_t waiting_stops_take(waiting_stops *self) {
  const uint16_t first = self->word[0];
  self->count--;
  for (uint32_t i = 0; i < WAITING_STOPS - 1; i++) {
    self->word[i] = self->word[i + 1];
  }
  return first;
}
