/* SPDX-License-Identifier: Apache-2.0 */
/* Identifies the image: 96 bytes at offset 0x200 of the flash, where tools find them without running anything.
 *
 * Length and CRC are written after linking (tools/image/stamp_image.py). The CRC-32 (IEEE 802.3) covers
 * the image from its first byte to its length, without the four bytes of the CRC itself. */
#ifndef TRACKSERVO_HAL_VERSION_BLOCK_H
#define TRACKSERVO_HAL_VERSION_BLOCK_H

#include <assert.h>
#include <stdint.h>

enum { VERSION_BLOCK_FORMAT = 1, VERSION_TEXT_BYTES = 16, VERSION_GIT_BYTES = 48, VERSION_BOARD_BYTES = 12 };

#define VERSION_BLOCK_MAGIC 0x56535354u /* "TSSV" */

typedef struct {
  uint32_t magic;
  uint32_t format;
  uint32_t image_bytes;
  uint32_t crc32;
  char version[VERSION_TEXT_BYTES]; /* filled up with zeros */
  char git[VERSION_GIT_BYTES];
  uint32_t schema_hash;            /* of the object dictionary; see node/schema_hash.h */
  char board[VERSION_BOARD_BYTES]; /* the folder of hal/boards; zeros in an image of before 2026-12 */
} version_block;
static_assert(sizeof(version_block) == 96, "as tools/image/stamp_image.py writes it");

/* The product's folder fills it in. volatile: the compiler must not believe that what it sees there is what the flash
 * will hold. */
extern const volatile version_block image_version_block;

#endif
