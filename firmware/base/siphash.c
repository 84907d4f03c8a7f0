/* SPDX-License-Identifier: Apache-2.0 */
#include "base/siphash.h"

enum { WORD_BYTES = 8, ROUNDS = 2, FINAL_ROUNDS = 4 };

typedef struct {
  uint64_t v0;
  uint64_t v1;
  uint64_t v2;
  uint64_t v3;
} sip_state;

static uint64_t rotated(uint64_t value, uint32_t bits) {
  const uint32_t others = 64u - bits;
  return value << bits | value >> others;
}

static void mix(sip_state *s, int rounds) {
  /* Bound: FINAL_ROUNDS. */
  for (int i = 0; i < rounds; ++i) {
    s->v0 += s->v1;
    s->v2 += s->v3;
    s->v1 = rotated(s->v1, 13) ^ s->v0;
    s->v3 = rotated(s->v3, 16) ^ s->v2;
    s->v0 = rotated(s->v0, 32);
    s->v2 += s->v1;
    s->v0 += s->v3;
    s->v1 = rotated(s->v1, 17) ^ s->v2;
    s->v3 = rotated(s->v3, 21) ^ s->v0;
    s->v2 = rotated(s->v2, 32);
  }
}

static void take_word(sip_state *s, uint64_t word) {
  s->v3 ^= word;
  mix(s, ROUNDS);
  s->v0 ^= word;
}

static uint64_t word_of(const uint8_t *bytes, uint32_t length) {
  uint64_t word = 0;
  /* Bound: WORD_BYTES. */
  for (uint32_t i = 0; i < length; ++i) {
    const uint32_t shift = 8u * i;
    word |= (uint64_t)bytes[i] << shift;
  }
  return word;
}

uint64_t siphash(const siphash_key *key, const uint8_t *bytes, uint32_t length) {
  /* "somepseudorandomlygeneratedbytes" */
  sip_state s = {.v0 = key->low ^ UINT64_C(0x736F6D6570736575),
                 .v1 = key->high ^ UINT64_C(0x646F72616E646F6D),
                 .v2 = key->low ^ UINT64_C(0x6C7967656E657261),
                 .v3 = key->high ^ UINT64_C(0x7465646279746573)};
  const uint32_t rest = length % WORD_BYTES;
  /* Bound: 8 bytes of a word of the access lock. */
  for (uint32_t i = 0; i + WORD_BYTES <= length; i += WORD_BYTES) {
    take_word(&s, word_of(&bytes[i], WORD_BYTES));
  }
  take_word(&s, word_of(&bytes[length - rest], rest) | (uint64_t)length << 56u);
  s.v2 ^= 0xFFu;
  mix(&s, FINAL_ROUNDS);
  return s.v0 ^ s.v1 ^ s.v2 ^ s.v3;
}
