/* SPDX-License-Identifier: Apache-2.0 */
/* The lock of dangerous parameters: they can be written only through a channel that has opened it.
 *
 * CAN does not say who sent a frame, but the node has two SDO channels (decisions 0019, 0032): a client opens the
 * lock for its own channel, for 60 s. The word is set by the owner. While none is set, the word is "open", which
 * everybody knows: the lock then prevents a typing error, a wrong script or a stray frame, and no intent. A wrong word
 * delays its channel only, each time twice as long. The node keeps a SipHash of the owner's word, with the serial
 * number as its salt. */
#ifndef TRACKSERVO_PROTECTION_ACCESS_LOCK_H
#define TRACKSERVO_PROTECTION_ACCESS_LOCK_H

#include <stdbool.h>
#include <stdint.h>

#define ACCESS_LOCK_WORD 0x6E65706Fu /* "open", lowest byte first */

enum {
  ACCESS_LOCK_CLIENTS = 2,        /* SDO channels */
  ACCESS_LOCK_TICKS = 60000,      /* 60 s */
  ACCESS_LOCK_FIRST_DELAY = 1000, /* after a wrong word; then 2 s, 4 s ... */
  ACCESS_LOCK_LAST_DELAY = 64000
};

typedef struct {
  uint32_t ticks_left;  /* 0: locked */
  uint32_t delay_ticks; /* left until another word is compared */
  uint32_t next_delay;  /* 0: ACCESS_LOCK_FIRST_DELAY */
} access_client;

typedef struct {
  access_client client[ACCESS_LOCK_CLIENTS];
  const uint32_t *caller; /* the channel whose request is being executed; ACCESS_LOCK_CLIENTS or more: none */
  bool powered;           /* an axis has torque: nothing guarded changes then */
  uint64_t hash;          /* of the owner's word; 0: none is set */
  uint32_t salt;          /* the device's serial number */
} access_lock;

typedef enum { ACCESS_OPENED, ACCESS_WRONG_WORD, ACCESS_DELAYED, ACCESS_NO_CLIENT } access_answer;

/* Returns whether the lock is open for the caller. Each function acts for the caller. */
bool access_lock_is_open(const access_lock *lock);

/* Compares the word (8 letters, lowest byte first) with the owner's, or with "open" while none is set. A wrong word
 * locks. */
access_answer access_lock_open(access_lock *lock, uint64_t word);

void access_lock_close(access_lock *lock);

uint32_t access_lock_ticks_left(const access_lock *lock);
uint32_t access_lock_delay_ticks(const access_lock *lock);

/* Closes the lock for all callers. Call after a reset or bus-off. The delays go on. */
void access_lock_close_all(access_lock *lock);

/* Returns what the node stores of a word; never 0. */
uint64_t access_lock_hash(const access_lock *lock, uint64_t word);

/* Counts one ms. */
void access_lock_tick(access_lock *lock);

#endif
