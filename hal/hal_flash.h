/* SPDX-License-Identifier: Apache-2.0 */
/* A piece of flash memory for parameters: pages that are erased as a whole, double words that are programmed once.
 *
 * The rules are those of the hardware: an erased byte is FF; a double word is programmed once after an erase; after a
 * power failure the affected words are undefined. Tests use a simulated flash that can fail at any operation. */
#ifndef TRACKSERVO_HAL_FLASH_H
#define TRACKSERVO_HAL_FLASH_H

#include <stdbool.h>
#include <stdint.h>

enum { HAL_FLASH_UNIT_BYTES = 8 };

typedef struct hal_flash hal_flash;

/* Offsets and page numbers count from the start of the piece. All return false when the hardware refuses or the range
 * is not within the piece. Programming and erasing block the caller: for the background only. */
struct hal_flash {
  bool (*read)(const hal_flash *flash, uint32_t offset, void *bytes, uint32_t count);
  /* offset: a multiple of HAL_FLASH_UNIT_BYTES that is erased. Reads back. */
  bool (*program)(const hal_flash *flash, uint32_t offset, const uint32_t double_word[2]);
  bool (*erase)(const hal_flash *flash, uint32_t page);
  void (*waiting)(void *context); /* called while the flash is busy */
  void *context;                  /* passed to `waiting`; on a platform that never waits, for its own use */
  uint32_t area;                  /* the platform's */
  uint32_t page_bytes;
  uint32_t pages;
};

#endif
