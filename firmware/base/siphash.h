/* SPDX-License-Identifier: Apache-2.0 */
/* SipHash-2-4: a keyed hash of a short message, 64 bits.
 *
 * J.-P. Aumasson, D. J. Bernstein, "SipHash: a fast short-input PRF", 2012. Two rounds for each 8 bytes, four at the
 * end. It is made for short keys and messages and is no slow password hash: who has a hash and its key can try words
 * quickly. */
#ifndef TRACKSERVO_BASE_SIPHASH_H
#define TRACKSERVO_BASE_SIPHASH_H

#include <stdint.h>

/* The 16 bytes of the key as two words, lowest byte first. */
typedef struct {
  uint64_t low;
  uint64_t high;
} siphash_key;

uint64_t siphash(const siphash_key *key, const uint8_t *bytes, uint32_t length);

#endif
