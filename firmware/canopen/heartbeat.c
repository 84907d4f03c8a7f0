/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/heartbeat.h"

bool heartbeat_producer_due(heartbeat_producer *producer, uint16_t period_ms) {
  if (period_ms == 0) {
    producer->elapsed_ms = 0;
    return false;
  }
  if (producer->elapsed_ms < UINT16_MAX) {
    producer->elapsed_ms++;
  }
  return producer->elapsed_ms >= period_ms;
}

void heartbeat_producer_sent(heartbeat_producer *producer) { producer->elapsed_ms = 0; }

uint8_t heartbeat_consumer_node(uint32_t object) { return (uint8_t)(object >> 16); }

uint16_t heartbeat_consumer_time_ms(uint32_t object) { return (uint16_t)object; }

bool heartbeat_consumer_active(uint32_t object) {
  const uint8_t node = heartbeat_consumer_node(object);
  return node >= 1 && node <= 127 && heartbeat_consumer_time_ms(object) != 0;
}

void heartbeat_consumer_reset(heartbeat_consumer *consumer) {
  *consumer = (heartbeat_consumer){.health = HEARTBEAT_UNKNOWN};
}

static heartbeat_news hear_boot_up(heartbeat_consumer *consumer) {
  if (consumer->health != HEARTBEAT_ALIVE) {
    return HEARTBEAT_BOOTED;
  }
  consumer->health = HEARTBEAT_LOST;
  return HEARTBEAT_RESET;
}

heartbeat_news heartbeat_consumer_hear(heartbeat_consumer *consumer, uint8_t remote_state) {
  const uint8_t without_toggle_bit = 0x7F; /* of node guarding */
  const bool back = consumer->health == HEARTBEAT_LOST;
  if ((remote_state & without_toggle_bit) == 0) {
    return hear_boot_up(consumer);
  }
  consumer->health = HEARTBEAT_ALIVE;
  consumer->silent_ms = 0;
  return back ? HEARTBEAT_BACK : HEARTBEAT_HEARD;
}

bool heartbeat_consumer_tick(heartbeat_consumer *consumer, uint32_t object) {
  if (consumer->health != HEARTBEAT_ALIVE || !heartbeat_consumer_active(object)) {
    return false;
  }
  consumer->silent_ms++;
  if (consumer->silent_ms < heartbeat_consumer_time_ms(object)) {
    return false;
  }
  consumer->health = HEARTBEAT_LOST;
  return true;
}
