/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/sync.h"

enum { TICK_US = 1000 };

void sync_reset(sync_consumer *consumer) { *consumer = (sync_consumer){.heard = false}; }

sync_verdict sync_receive(sync_consumer *consumer, const sync_objects *objects, const can_frame *frame) {
  const uint8_t expected = objects->overflow == 0 ? 0 : 1;
  if (frame->length != expected) {
    return SYNC_WRONG_LENGTH;
  }
  consumer->heard = true;
  consumer->late = false;
  consumer->silent_us = 0;
  consumer->counter = expected == 0 ? 0 : frame->data[0];
  return SYNC_GOOD;
}

bool sync_tick(sync_consumer *consumer, const sync_objects *objects) {
  if (!consumer->heard || consumer->late || objects->period_us == 0) {
    return false;
  }
  const uint32_t limit_us =
      objects->period_us > UINT32_MAX / 2 ? UINT32_MAX : objects->period_us + objects->period_us / 2;
  if (consumer->silent_us < UINT32_MAX - TICK_US) {
    consumer->silent_us += TICK_US;
  }
  /* A SYNC may arrive up to one tick before it is handled, so never report an error within that time. */
  consumer->late = consumer->silent_us > limit_us && consumer->silent_us > objects->period_us + TICK_US;
  return consumer->late;
}
