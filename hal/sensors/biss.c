#include "sensors/biss.h"

#include <string.h>

enum { ANSWER_BITS = BISS_CHECKED_BITS + BISS_CRC_BITS, CRC_MASK = (1 << BISS_CRC_BITS) - 1 };
_Static_assert(BISS_MOST_DELAY_BITS < 32, "the start bit lies in the first word");

/* Six bits at a time: entry n is n x^6 modulo the polynomial. */
uint32_t biss_crc(uint32_t checked_bits) {
  static const uint8_t remainder_of[64] = {
      0x00, 0x03, 0x06, 0x05, 0x0C, 0x0F, 0x0A, 0x09, 0x18, 0x1B, 0x1E, 0x1D, 0x14, 0x17, 0x12, 0x11,
      0x30, 0x33, 0x36, 0x35, 0x3C, 0x3F, 0x3A, 0x39, 0x28, 0x2B, 0x2E, 0x2D, 0x24, 0x27, 0x22, 0x21,
      0x23, 0x20, 0x25, 0x26, 0x2F, 0x2C, 0x29, 0x2A, 0x3B, 0x38, 0x3D, 0x3E, 0x37, 0x34, 0x31, 0x32,
      0x13, 0x10, 0x15, 0x16, 0x1F, 0x1C, 0x19, 0x1A, 0x0B, 0x08, 0x0D, 0x0E, 0x07, 0x04, 0x01, 0x02,
  };
  uint32_t crc = 0;
  for (int shift = BISS_CHECKED_BITS / BISS_CRC_BITS * BISS_CRC_BITS; shift >= 0; shift -= BISS_CRC_BITS) {
    crc = remainder_of[(crc ^ checked_bits >> shift) & CRC_MASK];
  }
  return crc;
}

static uint32_t word_at(const uint8_t *bytes) {
  uint32_t word;
  memcpy(&word, bytes, sizeof word);
  return __builtin_bswap32(word);
}

/* Zeros before the first one; 32 when there is none. */
static int leading_zeros(uint32_t word) { return word == 0 ? 32 : __builtin_clz(word); }

biss_status biss_decode(const uint8_t bytes[BISS_BYTES], biss_reading *reading) {
  const uint32_t first = word_at(bytes);
  const int line = leading_zeros(~first);
  const int delay = line < 32 ? line + leading_zeros(first << line) : 32;
  if (line == 0 || delay > BISS_MOST_DELAY_BITS) {
    return BISS_NO_ANSWER;
  }
  const int behind = 8 * BISS_BYTES - delay - 2 - ANSWER_BITS; /* start bit and CDS are before */
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
