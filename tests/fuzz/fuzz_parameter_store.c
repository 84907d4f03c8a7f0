/* SPDX-License-Identifier: Apache-2.0 */
/* libFuzzer harness of the parameter store's reader: any flash contents, then a save, which may be cut.
 *
 * Input: a byte for the number of rows of the save, a byte for the operation at which the power fails (255: none), then
 * the contents of both areas, the rest of them blank. Up to two bytes more: double words that cannot be read at the
 * start after the save. A save that was acknowledged is found then, or its loss is reported. Bit 7 of the first byte:
 * CRC, complement and commit mark of a record at the beginning of either area are corrected, so that the fuzzer also
 * gets behind these checks. */
#include <string.h>

#include "base/crc32.h"
#include "parameters/parameter_store.h"
#include "require.h"
#include "support/flash_model.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { PAGE_BYTES = 64, PAGES = 4, AREA_BYTES = PAGE_BYTES * PAGES, MAX_ROWS = AREA_BYTES / HAL_FLASH_UNIT_BYTES };

static flash_model model;
static hal_flash areas[PARAMETER_STORE_AREAS];
static parameter_store store;

static void make_record_right(uint8_t *area) {
  uint32_t head[4];
  memcpy(head, area, sizeof head);
  const uint32_t rows = head[3] % MAX_ROWS;
  const uint32_t end = (rows + 2) * HAL_FLASH_UNIT_BYTES;
  if (end + 16 > AREA_BYTES) {
    return;
  }
  head[0] = 0x54535631;
  head[3] = rows;
  memcpy(area, head, sizeof head);
  const uint32_t crc = crc32_end(crc32_add(CRC32_START, area, end));
  const uint32_t tail[4] = {crc, ~crc, 0x444E4521, head[1]};
  memcpy(area + end, tail, sizeof tail);
}

static void restart(void) {
  flash_model_start(&model);
  parameter_store_open(&store, areas);
  require(store.count + store.damaged + store.unfinished <= PARAMETER_STORE_MAX_RECORDS);
  require(model.rule_breaks == 0);
}

/* A copy of the newest set; its number of rows, or UINT32_MAX. */
static uint32_t newest(parameter_row *rows) {
  for (uint32_t n = 0; n < store.count; ++n) {
    require(parameter_store_load(&store, n, rows, MAX_ROWS)); /* it was complete just before */
  }
  return store.count > 0 && parameter_store_load(&store, 0, rows, MAX_ROWS) ? store.found[0].rows : UINT32_MAX;
}

static bool save(const parameter_row *rows, uint32_t count) {
  if (!parameter_store_begin(&store, 1, rows, count)) {
    require(store.last_sequence > PARAMETER_STORE_MAX_SAVES - PARAMETER_STORE_DOUBT_STEP);
    return false;
  }
  for (int step = 0; step < 2 * MAX_ROWS && parameter_store_progress(&store) == PARAMETER_STORE_BUSY; ++step) {
    parameter_store_step(&store);
  }
  require(parameter_store_progress(&store) != PARAMETER_STORE_BUSY && model.rule_breaks == 0);
  return parameter_store_progress(&store) == PARAMETER_STORE_SAVED;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static parameter_row old[MAX_ROWS], next[MAX_ROWS], read[MAX_ROWS];
  if (size < 2) {
    return 0;
  }
  flash_model_init(&model, PAGE_BYTES, PAGES);
  areas[0] = flash_model_area(&model, 0);
  areas[1] = flash_model_area(&model, 1);
  const size_t contents = size - 2 < 2 * (size_t)AREA_BYTES ? size - 2 : 2 * (size_t)AREA_BYTES;
  memcpy(model.bytes, data + 2, contents);
  if ((data[0] & 0x80) != 0) {
    make_record_right(model.bytes);
    make_record_right(model.bytes + AREA_BYTES);
  }
  restart();
  const uint32_t old_count = newest(old);
  const uint32_t count = data[0] % (MAX_ROWS - PARAMETER_STORE_FRAME_UNITS + 1);
  for (uint32_t i = 0; i < count; ++i) {
    next[i] = (parameter_row){i, data[1]};
  }
  model.operations_left = data[1] == 255 ? -1 : data[1] % 64;
  model.cut = (flash_cut)(data[1] % FLASH_CUTS);
  const bool saved = save(next, count);
  for (size_t extra = 2 + contents; extra < size && extra < 4 + contents; ++extra) {
    model.weak[data[extra] % (2 * AREA_BYTES / HAL_FLASH_UNIT_BYTES)].shows = SHOWS_UNREADABLE;
  }
  restart();
  const bool may_be_lost = size > 2 + contents && store.damaged + store.unfinished > 0;
  const uint32_t found = newest(read);
  const bool is_next = found == count && memcmp(read, next, count * sizeof next[0]) == 0;
  const bool is_old = found == old_count && (found == UINT32_MAX || memcmp(read, old, found * sizeof old[0]) == 0);
  require(may_be_lost || is_next || (!saved && is_old));
  return 0;
}
