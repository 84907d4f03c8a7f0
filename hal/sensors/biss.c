/* SPDX-License-Identifier: Apache-2.0 */
#include "sensors/biss.h"

#include <string.h>

enum { ANSWER_BITS = BISS_CHECKED_BITS + BISS_CRC_BITS, CRC_MASK = (1 << BISS_CRC_BITS) - 1 };
_Static_assert(BISS_MAX_DELAY_BITS < 32, "the start bit lies in the first word");

/* Entry n is n x^6 modulo the polynomial: the sum of the contributions of its bits. */
#define BIT(n, bit, remainder) (((n) >> (bit)&1u) != 0 ? (remainder) : 0u)
#define ENTRY(n)                                                                                                     \
  (BIT(n, 0, 0x03u) ^ BIT(n, 1, 0x06u) ^ BIT(n, 2, 0x0Cu) ^ BIT(n, 3, 0x18u) ^ BIT(n, 4, 0x30u) ^ BIT(n, 5, 0x23u) ^ \
   BIT(n, 6, 0x05u) ^ BIT(n, 7, 0x0Au))
#define ENTRIES_4(n) ENTRY(n), ENTRY((n) + 1u), ENTRY((n) + 2u), ENTRY((n) + 3u)
#define ENTRIES_16(n) ENTRIES_4(n), ENTRIES_4((n) + 4u), ENTRIES_4((n) + 8u), ENTRIES_4((n) + 12u)
#define ENTRIES_64(n) ENTRIES_16(n), ENTRIES_16((n) + 16u), ENTRIES_16((n) + 32u), ENTRIES_16((n) + 48u)

/* Four bits, then eight at a time. */
uint32_t biss_crc(uint32_t checked_bits) {
  static const uint8_t remainder_of[256] = {ENTRIES_64(0u), ENTRIES_64(64u), ENTRIES_64(128u), ENTRIES_64(192u)};
  uint32_t crc = remainder_of[checked_bits >> 24 & 0x0Fu];
  crc = remainder_of[crc << 2 ^ (checked_bits >> 16 & 0xFFu)];
  crc = remainder_of[crc << 2 ^ (checked_bits >> 8 & 0xFFu)];
  return remainder_of[crc << 2 ^ (checked_bits & 0xFFu)];
}
_Static_assert(BISS_CHECKED_BITS == 28 && BISS_CRC_BITS == 6, "as the shifts above");

static uint32_t word_at(const uint8_t *bytes) {
  uint32_t word;
  memcpy(&word, bytes, sizeof word);
  return __builtin_bswap32(word);
}

/* Number of zeros before the first one bit; 32 when there is none. */
static int leading_zeros(uint32_t word) { return word == 0 ? 32 : __builtin_clz(word); }

biss_status biss_decode(const uint8_t bytes[BISS_BYTES], biss_reading *reading) {
  const uint32_t first = word_at(bytes);
  const int line = leading_zeros(~first);
  const int delay = line < 32 ? line + leading_zeros(first << line) : 32;
  if (line == 0 || delay > BISS_MAX_DELAY_BITS) {
    return BISS_NO_ANSWER;
  }
  const int behind = 8 * BISS_BYTES - delay - 2 - ANSWER_BITS; /* start bit and CDS come before */
  const uint64_t answer = ((uint64_t)first << 32 | word_at(bytes + 4)) >> behind;
  const uint32_t checked = (uint32_t)(answer >> BISS_CRC_BITS) & ((1u << BISS_CHECKED_BITS) - 1u);
  const uint32_t sent_crc = ~(uint32_t)answer & CRC_MASK;
  if (biss_crc(checked) != sent_crc) {
    return BISS_BAD_CRC;
  }
  if ((checked & 2u) == 0) {
    return BISS_ERROR;
  }
  reading->angle_turn32 = (checked >> 2) << (32 - BISS_POSITION_BITS);
  reading->warning = (checked & 1u) == 0;
  return BISS_OK;
}
