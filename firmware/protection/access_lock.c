/* SPDX-License-Identifier: Apache-2.0 */
#include "protection/access_lock.h"

#include <stddef.h>

#include "base/siphash.h"

static bool has_caller(const access_lock *lock) { return *lock->caller < ACCESS_LOCK_CLIENTS; }

/* NULL: the request came through no SDO channel. */
static access_client *caller_of(access_lock *lock) { return has_caller(lock) ? &lock->client[*lock->caller] : NULL; }

uint32_t access_lock_ticks_left(const access_lock *lock) {
  return has_caller(lock) ? lock->client[*lock->caller].ticks_left : 0;
}

uint32_t access_lock_delay_ticks(const access_lock *lock) {
  return has_caller(lock) ? lock->client[*lock->caller].delay_ticks : 0;
}

bool access_lock_is_open(const access_lock *lock) { return access_lock_ticks_left(lock) > 0; }

uint64_t access_lock_hash(const access_lock *lock, uint64_t word) {
  const siphash_key key = {UINT64_C(0x6B636F6C74737274) /* "trstlock" */, lock->salt};
  uint8_t bytes[sizeof word];
  for (uint32_t i = 0; i < sizeof word; ++i) {
    const uint32_t shift = 8u * i;
    bytes[i] = (uint8_t)(word >> shift);
  }
  const uint64_t hash = siphash(&key, bytes, sizeof bytes);
  return hash == 0 ? 1 : hash;
}

static bool is_right(const access_lock *lock, uint64_t word) {
  return lock->hash == 0 ? word == ACCESS_LOCK_WORD : access_lock_hash(lock, word) == lock->hash;
}

static void delay(access_client *client) {
  const uint32_t now = client->next_delay == 0 ? ACCESS_LOCK_FIRST_DELAY : client->next_delay;
  client->delay_ticks = now;
  client->next_delay = now < ACCESS_LOCK_LAST_DELAY ? 2 * now : now;
}

access_answer access_lock_open(access_lock *lock, uint64_t word) {
  access_client *client = caller_of(lock);
  if (client == NULL) {
    return ACCESS_NO_CLIENT;
  }
  if (client->delay_ticks > 0) {
    return ACCESS_DELAYED;
  }
  if (!is_right(lock, word)) {
    client->ticks_left = 0;
    delay(client);
    return ACCESS_WRONG_WORD;
  }
  *client = (access_client){.ticks_left = ACCESS_LOCK_TICKS};
  return ACCESS_OPENED;
}

void access_lock_close(access_lock *lock) {
  access_client *client = caller_of(lock);
  if (client != NULL) {
    client->ticks_left = 0;
  }
}

void access_lock_close_all(access_lock *lock) {
  for (uint32_t i = 0; i < ACCESS_LOCK_CLIENTS; ++i) {
    lock->client[i].ticks_left = 0;
  }
}

void access_lock_tick(access_lock *lock) {
  for (uint32_t i = 0; i < ACCESS_LOCK_CLIENTS; ++i) {
    access_client *client = &lock->client[i];
    client->ticks_left -= client->ticks_left > 0 ? 1 : 0;
    client->delay_ticks -= client->delay_ticks > 0 ? 1 : 0;
  }
}
