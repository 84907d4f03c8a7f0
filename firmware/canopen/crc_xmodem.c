/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/crc_xmodem.h"

/* One nibble at a time, so the table has only 16 words. */
static uint16_t step(uint16_t crc, uint8_t nibble) {
  static const uint16_t table[16] = {0x0000, 0x1021, 0x2042, 0x3063, 0x4084, 0x50A5, 0x60C6, 0x70E7,
                                     0x8108, 0x9129, 0xA14A, 0xB16B, 0xC18C, 0xD1AD, 0xE1CE, 0xF1EF};
  return (uint16_t)((uint32_t)crc << 4 ^ table[(crc >> 12 ^ nibble) & 0xFu]);
}

uint16_t crc_xmodem(uint16_t crc, const uint8_t *bytes, uint32_t length) {
  /* Bound: 7 bytes of a segment. */
  for (uint32_t i = 0; i < length; i++) {
    crc = step(crc, (uint8_t)(bytes[i] >> 4));
    crc = step(crc, (uint8_t)(bytes[i] & 0xFu));
  }
  return crc;
}
