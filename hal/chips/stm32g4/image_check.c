/* SPDX-License-Identifier: Apache-2.0 */
#include "image_check.h"

#include <stddef.h>

#include "base/crc32.h"
#include "version_block.h"

extern const uint8_t image_start[]; /* the linker script's */

enum { MAX_IMAGE_BYTES = 0x7C000 };

enum { STRETCHES = 2 }; /* of the image: before the CRC, and after it */

image_check image_check_begin(void) { return (image_check){.at = 0, .crc = CRC32_START}; }

image_verdict image_check_step(image_check *check, uint32_t max_bytes) {
  const uint32_t image_bytes = image_version_block.image_bytes;
  const uint32_t crc_at = (uint32_t)((uintptr_t)&image_version_block.crc32 - (uintptr_t)image_start);
  const uint32_t behind_crc = crc_at + (uint32_t)sizeof image_version_block.crc32;
  if (check->at == crc_at) {
    check->at = behind_crc;
  }
  if (image_bytes <= behind_crc || image_bytes > MAX_IMAGE_BYTES || check->at > image_bytes) {
    return IMAGE_DAMAGED; /* the length itself */
  }
  const uint32_t left = (check->at < crc_at ? crc_at : image_bytes) - check->at;
  const uint32_t count = left < max_bytes ? left : max_bytes;
  check->crc = crc32_add(check->crc, image_start + check->at, count);
  check->at += count;
  if (check->at < image_bytes) {
    return IMAGE_NOT_YET_KNOWN;
  }
  const bool whole = crc32_end(check->crc) == image_version_block.crc32;
  *check = image_check_begin();
  return whole ? IMAGE_WHOLE : IMAGE_DAMAGED;
}

bool image_check_is_whole(void) {
  image_check check = image_check_begin();
  image_verdict verdict = IMAGE_NOT_YET_KNOWN;
  for (int i = 0; i < STRETCHES; ++i) {
    verdict = image_check_step(&check, MAX_IMAGE_BYTES);
  }
  return verdict == IMAGE_WHOLE;
}
