#include "sensors/biss.h"

static uint64_t as_bits(const uint8_t bytes[BISS_BYTES]) {
  uint64_t bits = 0;
  for (int i = 0; i < BISS_BYTES; ++i) {
    bits = bits << 8 | bytes[i];
  }
  return bits;
}

/* Zeros before the first one; 64 when there is none. */
static int leading_zeros(uint64_t bits) { return bits == 0 ? 64 : __builtin_clzll(bits); }

/* Two bits at a time: what the two bits that leave the register add to it. */
uint32_t biss_crc(uint32_t checked_bits) {
  static const uint8_t feedback[4] = {0x00, 0x03, 0x06, 0x05};
  uint32_t crc = 0;
  for (int position = BISS_CHECKED_BITS - 2; position >= 0; position -= 2) {
    const uint32_t leaving = (crc >> 4 ^ checked_bits >> position) & 3u;
    crc = (crc << 2 & 0x3Fu) ^ feedback[leaving];
  }
  return crc;
}

biss_status biss_decode(const uint8_t bytes[BISS_BYTES], biss_reading *reading) {
  const uint64_t bits = as_bits(bytes);
  const int line = leading_zeros(~bits);
  const uint64_t from_acknowledge = line < 64 ? bits << line : 0;
  const int acknowledge = leading_zeros(from_acknowledge);
  if (line == 0 || line + acknowledge > BISS_MOST_DELAY_BITS) {
    return BISS_NO_ANSWER;
  }
  const uint64_t data = from_acknowledge << acknowledge << 2; /* start bit and CDS are gone */
  const uint32_t checked = (uint32_t)(data >> (64 - BISS_CHECKED_BITS));
  const uint32_t sent_crc = ~(uint32_t)(data >> (64 - BISS_CHECKED_BITS - BISS_CRC_BITS)) & 0x3Fu;
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
