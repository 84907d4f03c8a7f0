/* SPDX-License-Identifier: Apache-2.0 */
/* Reader of the parameter store, for any contents of the flash (each read gives any bytes, or fails, and may differ
 * from the read before), at any page of an area: every read lies within the area; a record that counts as complete fits
 * the area, and its sequence is in range; no sum wraps. The CRC is replaced by any function of the bytes. Bound: areas
 * of 4 pages of 4 double words, so up to 12 rows; the code uses these sizes in sums and comparisons only. */
#include "parameters/parameter_store.c"

#include "proof.h"

enum { PAGES = 4, PAGE_BYTES = 32, ROWS = 12 };

uint32_t crc32_add(uint32_t crc, const uint8_t *bytes, uint32_t count) {
  (void)crc;
  (void)bytes;
  (void)count;
  return any_u32();
}

static bool any_read(const hal_flash *flash, uint32_t offset, void *bytes, uint32_t count) {
  (void)flash;
  REQUIRE(count == HAL_FLASH_UNIT_BYTES && offset <= PAGES * PAGE_BYTES - HAL_FLASH_UNIT_BYTES,
          "a read lies within the area");
  flash_unit *unit = bytes;
  unit->low = any_u32();
  unit->high = any_u32();
  return any_bool();
}

int main(void) {
  const hal_flash flash = {.read = any_read, .page_bytes = PAGE_BYTES, .pages = PAGES};
  parameter_record record = {.area = 0, .page = any_u32()};
  ASSUME(record.page < PAGES);
  if (look(&flash, &record) == PLACE_COMPLETE) {
    REQUIRE(record.sequence <= PARAMETER_STORE_MAX_SAVES, "a sequence in range");
    REQUIRE((record.rows + PARAMETER_STORE_FRAME_UNITS) * HAL_FLASH_UNIT_BYTES <= (PAGES - record.page) * PAGE_BYTES,
            "a record within its area");
  }
  return 0;
}
