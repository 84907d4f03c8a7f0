/* Dangerous parameters can be written only while this lock is open.
 *
 * Object 0x3040: the word "open" opens it for a minute, any other value locks it. It is no protection against intent.
 * It prevents a typing error, a wrong script or a stray frame from raising a limit. It starts locked. */
#ifndef TRACKSERVO_PROTECTION_ACCESS_LOCK_H
#define TRACKSERVO_PROTECTION_ACCESS_LOCK_H

#include <stdbool.h>
#include <stdint.h>

#define ACCESS_LOCK_WORD 0x6E65706Fu /* "open", lowest byte first */
#define ACCESS_LOCK_TICKS 60000u     /* 60 s */

typedef struct {
  uint32_t ticks_left; /* 0: locked */
} access_lock;

static inline bool access_lock_is_open(const access_lock *lock) { return lock->ticks_left > 0; }

/* 0x3040:1 was written. */
static inline void access_lock_take(access_lock *lock, uint32_t word) {
  lock->ticks_left = word == ACCESS_LOCK_WORD ? ACCESS_LOCK_TICKS : 0;
}

static inline void access_lock_tick(access_lock *lock) { lock->ticks_left -= lock->ticks_left > 0 ? 1 : 0; }

#endif
