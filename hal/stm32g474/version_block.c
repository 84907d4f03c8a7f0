#include "version_block.h"

#include <stddef.h>

#include "parameters/crc32.h"

extern const uint8_t image_start[]; /* the linker script's */

enum { MOST_IMAGE_BYTES = 0x7C000 };

/* volatile: the compiler must not believe that what it sees here is what the flash will hold. */
__attribute__((section(".version_block"), used)) static const volatile version_block block = {
    .magic = VERSION_BLOCK_MAGIC, .format = VERSION_BLOCK_FORMAT, .version = TRACKSERVO_VERSION, .git = TRACKSERVO_GIT};

bool version_block_image_is_whole(void) {
  const uint32_t bytes = block.image_bytes;
  const uint32_t crc_at = (uint32_t)((uintptr_t)&block.crc32 - (uintptr_t)image_start);
  const uint32_t behind_crc = crc_at + (uint32_t)sizeof block.crc32;
  if (bytes < behind_crc || bytes > MOST_IMAGE_BYTES) {
    return false;
  }
  uint32_t crc = crc32_add(CRC32_START, image_start, crc_at);
  crc = crc32_add(crc, image_start + behind_crc, bytes - behind_crc);
  return crc32_end(crc) == block.crc32;
}
