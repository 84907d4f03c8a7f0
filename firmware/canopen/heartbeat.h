/* SPDX-License-Identifier: Apache-2.0 */
/* Heartbeats: sends this node's heartbeat and detects the loss of another node's.
 *
 * Standard: CiA 301 v4.2.0, clause 7.2.8.3.2, objects 0x1017 (producer) and 0x1016 (consumers). The 1 ms tick advances
 * both sides. A consumer monitors a node from its first heartbeat on; a boot-up message is none. From a node that is
 * monitored it means a reset: the node is lost. */
#ifndef TRACKSERVO_CANOPEN_HEARTBEAT_H
#define TRACKSERVO_CANOPEN_HEARTBEAT_H

#include <stdbool.h>
#include <stdint.h>

enum { HEARTBEAT_COB_ID = 0x700, HEARTBEAT_CONSUMERS = 4 };

typedef struct {
  uint16_t elapsed_ms; /* since the last heartbeat */
} heartbeat_producer;

/* Returns whether a heartbeat is due now; call it once per ms. It stays due until `heartbeat_producer_sent`, so a full
 * bus delays a heartbeat but never loses it. Period 0: never. */
bool heartbeat_producer_due(heartbeat_producer *producer, uint16_t period_ms);
void heartbeat_producer_sent(heartbeat_producer *producer);

typedef enum {
  HEARTBEAT_UNKNOWN, /* nothing heard yet, or not monitored */
  HEARTBEAT_ALIVE,
  HEARTBEAT_LOST
} heartbeat_health;

typedef struct {
  heartbeat_health health;
  uint16_t silent_ms;
} heartbeat_consumer;

/* Fields of 0x1016:n. Node 0, nodes above 127 and time 0 switch the consumer off. */
uint8_t heartbeat_consumer_node(uint32_t object);
uint16_t heartbeat_consumer_time_ms(uint32_t object);
bool heartbeat_consumer_active(uint32_t object);

void heartbeat_consumer_reset(heartbeat_consumer *consumer);

typedef enum {
  HEARTBEAT_HEARD, /* the node is monitored */
  HEARTBEAT_BACK,  /* the same, and it had been lost */
  HEARTBEAT_RESET, /* the monitored node has booted: it is lost now */
  HEARTBEAT_BOOTED /* a node that is not monitored has */
} heartbeat_news;

/* Takes a heartbeat or boot-up message of the node. */
heartbeat_news heartbeat_consumer_hear(heartbeat_consumer *consumer, uint8_t remote_state);

/* Counts one ms. Returns true once, in the tick that declares the node lost. */
bool heartbeat_consumer_tick(heartbeat_consumer *consumer, uint32_t object);

#endif
