/* SPDX-License-Identifier: Apache-2.0 */
/* The 96 bits that identify a chip, programmed in the factory: RM0440, "Unique device ID register". */
#ifndef TRACKSERVO_STM32G4_UNIQUE_ID_H
#define TRACKSERVO_STM32G4_UNIQUE_ID_H

#include <stdint.h>

#include "base/crc32.h"

enum { UNIQUE_ID_WORDS = 3 };

#define UNIQUE_ID ((const volatile uint32_t *)0x1FFF7590u)

/* Returns the CRC-32 (IEEE 802.3) of its bytes, lowest first: object 1018:4 has no room for more. */
static inline uint32_t unique_id_serial_number(void) {
  uint32_t crc = CRC32_START;
  for (int i = 0; i < UNIQUE_ID_WORDS; ++i) {
    const uint32_t word = UNIQUE_ID[i];
    crc = crc32_add(crc, (const uint8_t *)&word, sizeof word);
  }
  return crc32_end(crc);
}

#endif
