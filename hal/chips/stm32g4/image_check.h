/* SPDX-License-Identifier: Apache-2.0 */
/* Whether the program memory is still what was linked: its CRC-32 against that of the version block. */
#ifndef TRACKSERVO_STM32G4_IMAGE_CHECK_H
#define TRACKSERVO_STM32G4_IMAGE_CHECK_H

#include <stdbool.h>
#include <stdint.h>

/* Returns whether the flash holds the linked image. Takes about 30 ms for 64 KiB. */
bool image_check_is_whole(void);

/* The same piece by piece, in an endless cycle. */
typedef enum { IMAGE_NOT_YET_KNOWN = 0, IMAGE_WHOLE, IMAGE_DAMAGED } image_verdict;

typedef struct {
  uint32_t at; /* offset of the next byte */
  uint32_t crc;
} image_check;

/* Begins at the first byte. */
image_check image_check_begin(void);

/* Continues by at most this many bytes, 1 or more; after a result it begins again. Damage is reported in the second
 * cycle at the latest. */
image_verdict image_check_step(image_check *check, uint32_t max_bytes);

#endif
