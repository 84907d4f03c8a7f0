/* SPDX-License-Identifier: Apache-2.0 */
#include "parameters/parameter_store.h"

#include <string.h>

#include "base/crc32.h"

#define MAGIC 0x54535631u  /* "1VST": a record in this layout begins */
#define COMMIT 0x444E4521u /* "!END": the record is complete */

/* A double word of flash. */
typedef struct {
  uint32_t low;
  uint32_t high;
} flash_unit;

_Static_assert(sizeof(parameter_row) == HAL_FLASH_UNIT_BYTES, "a row is programmed in one piece");
_Static_assert(sizeof(flash_unit) == HAL_FLASH_UNIT_BYTES, "no padding");

typedef enum { PLACE_NO_HEAD, PLACE_COMPLETE, PLACE_UNFINISHED, PLACE_DAMAGED } place_verdict;

/* One area, in the order of its pages. */
typedef struct {
  uint32_t complete;
  uint32_t damaged;    /* after the last complete record */
  uint32_t unfinished; /* likewise */
  bool in_doubt;       /* the page before is not blank and not of a complete record */
} area_account;

static uint32_t units_of(uint32_t rows) { return rows + PARAMETER_STORE_FRAME_UNITS; }

static uint32_t units_per_page(const hal_flash *flash) { return flash->page_bytes / HAL_FLASH_UNIT_BYTES; }

static uint32_t pages_of(const hal_flash *flash, uint32_t rows) {
  const uint32_t per_page = units_per_page(flash);
  return (units_of(rows) + per_page - 1) / per_page;
}

static uint32_t add_unit(uint32_t crc, flash_unit unit) { return crc32_add(crc, (const uint8_t *)&unit, sizeof unit); }

static uint32_t other_area(uint32_t area) { return PARAMETER_STORE_AREAS - 1 - area; }

/* --- reading ---------------------------------------------------------------------------------------------------- */

/* Double word `unit` counts from the beginning of `page`. */
static bool read_unit(const hal_flash *flash, uint32_t page, uint32_t unit, flash_unit *read) {
  const uint32_t offset = page * flash->page_bytes + unit * HAL_FLASH_UNIT_BYTES;
  return flash->read(flash, offset, read, sizeof *read);
}

/* A double word that cannot be read is not blank. */
static bool is_blank(const hal_flash *flash, uint32_t page) {
  /* Bound: 256: double words of a page of 2 KiB. */
  for (uint32_t unit = 0; unit < units_per_page(flash); ++unit) {
    flash_unit read;
    if (!read_unit(flash, page, unit, &read) || (read.low & read.high) != UINT32_MAX) {
      return false;
    }
  }
  return true;
}

static bool fits(const hal_flash *flash, uint32_t page, uint32_t rows) {
  return rows <= PARAMETER_STORE_MAX_ROWS && pages_of(flash, rows) <= flash->pages - page;
}

/* Sum of a record's head and rows; `rows` receives the latter if it is not NULL. */
static bool sum(const hal_flash *flash, const parameter_record *record, parameter_row *rows, uint32_t *crc) {
  const flash_unit head[] = {{MAGIC, record->sequence}, {record->schema_hash, record->rows}};
  *crc = add_unit(add_unit(CRC32_START, head[0]), head[1]);
  /* Bound: rows that fit the area: a record with more is damaged, and not read. */
  for (uint32_t row = 0; row < record->rows; ++row) {
    flash_unit unit;
    if (!read_unit(flash, record->page, row + 2, &unit)) {
      return false;
    }
    *crc = add_unit(*crc, unit);
    if (rows != NULL) {
      rows[row] = (parameter_row){unit.low, unit.high};
    }
  }
  *crc = crc32_end(*crc);
  return true;
}

static bool sum_is_right(const hal_flash *flash, const parameter_record *record, parameter_row *rows) {
  flash_unit end;
  uint32_t crc = 0;
  return read_unit(flash, record->page, record->rows + 2, &end) && end.high == ~end.low &&
         sum(flash, record, rows, &crc) && crc == end.low;
}

/* Head and commit mark are read here, the rest by sum_is_right. */
static place_verdict look(const hal_flash *flash, parameter_record *record) {
  flash_unit head[2];
  flash_unit mark;
  if (!read_unit(flash, record->page, 0, &head[0]) || head[0].low != MAGIC) {
    return PLACE_NO_HEAD;
  }
  record->sequence = head[0].high;
  if (!read_unit(flash, record->page, 1, &head[1])) {
    return PLACE_DAMAGED;
  }
  record->schema_hash = head[1].low;
  record->rows = head[1].high;
  if (head[1].low == UINT32_MAX && head[1].high == UINT32_MAX) {
    return PLACE_UNFINISHED; /* no longer programmed */
  }
  if (record->sequence > PARAMETER_STORE_MAX_SAVES || !fits(flash, record->page, record->rows) ||
      !read_unit(flash, record->page, record->rows + 3, &mark)) {
    return PLACE_DAMAGED;
  }
  if (mark.low != COMMIT || mark.high != record->sequence) {
    return PLACE_UNFINISHED;
  }
  return sum_is_right(flash, record, NULL) ? PLACE_COMPLETE : PLACE_DAMAGED;
}

/* Keeps found[] in order, the newest first. */
static void insert(parameter_store *store, const parameter_record *record) {
  uint32_t rank = store->count++;
  /* Bound: PARAMETER_STORE_MAX_RECORDS: rank is counted down. */
  while (rank > 0 && record->sequence > store->found[rank - 1].sequence) {
    store->found[rank] = store->found[rank - 1];
    --rank;
  }
  store->found[rank] = *record;
}

/* A page of a record whose head is on a page before it is not counted again. */
static void count_doubt(area_account *account, const hal_flash *flash, uint32_t page, place_verdict verdict) {
  if (verdict == PLACE_NO_HEAD && is_blank(flash, page)) {
    account->in_doubt = false;
    return;
  }
  account->unfinished += verdict == PLACE_UNFINISHED ? 1u : 0u;
  account->damaged += verdict == PLACE_DAMAGED || (verdict == PLACE_NO_HEAD && !account->in_doubt) ? 1u : 0u;
  account->in_doubt = true;
}

/* Returns the page after the examined ones. */
static uint32_t look_at_page(parameter_store *store, area_account *account, uint32_t area, uint32_t page) {
  const hal_flash *flash = &store->areas[area];
  parameter_record record = {.area = area, .page = page};
  const place_verdict verdict = look(flash, &record);
  if (verdict != PLACE_COMPLETE) {
    count_doubt(account, flash, page, verdict);
    return page + 1;
  }
  insert(store, &record);
  *account = (area_account){.complete = account->complete + 1}; /* what lies before it is older */
  return page + pages_of(flash, record.rows);
}

/* An area is filled after it was erased as a whole: the older of two complete records shows that its area is the older
 * one. What is in doubt there cannot be newer than the newest record. */
static void add_doubts(parameter_store *store, const area_account accounts[PARAMETER_STORE_AREAS]) {
  for (uint32_t area = 0; area < PARAMETER_STORE_AREAS; ++area) {
    const area_account *account = &accounts[area];
    if (account->complete == 0 || store->found[0].area == area) {
      store->damaged += account->damaged;
      store->unfinished += account->unfinished;
    }
  }
  store->in_doubt = store->damaged + store->unfinished > 0;
}

/* Without a complete record: every head and every mark that can be read has the number of one. */
static void raise_sequence(parameter_store *store, const hal_flash *flash) {
  /* Bound: 1024: double words of an area, at a start without a complete record. */
  for (uint32_t unit = 0; unit < flash->pages * units_per_page(flash); ++unit) {
    flash_unit read;
    if (read_unit(flash, 0, unit, &read) && (read.low == MAGIC || read.low == COMMIT) &&
        read.high > store->last_sequence && read.high <= PARAMETER_STORE_MAX_SAVES) {
      store->last_sequence = read.high;
    }
  }
}

void parameter_store_open(parameter_store *store, const hal_flash areas[PARAMETER_STORE_AREAS]) {
  area_account accounts[PARAMETER_STORE_AREAS] = {{0}};
  memset(store, 0, sizeof *store);
  store->areas = areas;
  for (uint32_t area = 0; area < PARAMETER_STORE_AREAS; ++area) {
    uint32_t page = 0;
    /* Bound: PARAMETER_STORE_MAX_PAGES: each round goes at least one page on. */
    while (page < areas[area].pages && page < PARAMETER_STORE_MAX_PAGES) {
      page = look_at_page(store, &accounts[area], area, page);
    }
  }
  add_doubts(store, accounts);
  if (store->count > 0) {
    store->last_sequence = store->found[0].sequence;
    parameter_store_use(store, 0);
    return;
  }
  for (uint32_t area = 0; area < PARAMETER_STORE_AREAS; ++area) {
    raise_sequence(store, &areas[area]);
  }
}

bool parameter_store_load(const parameter_store *store, uint32_t n, parameter_row *rows, uint32_t capacity) {
  if (n >= store->count || store->found[n].rows > capacity) {
    return false;
  }
  const parameter_record *record = &store->found[n];
  return sum_is_right(&store->areas[record->area], record, rows);
}

void parameter_store_use(parameter_store *store, uint32_t n) {
  if (n < store->count) {
    store->in_use = store->found[n];
    store->has_in_use = true;
    store->in_doubt = store->in_doubt || n > 0;
  }
}

/* --- saving ----------------------------------------------------------------------------------------------------- */

/* Far above any record in doubt, whose number may be unknown. */
static uint32_t next_sequence(const parameter_store *store) {
  return store->last_sequence + (store->in_doubt ? PARAMETER_STORE_DOUBT_STEP : 1u);
}

bool parameter_store_begin(parameter_store *store, uint32_t schema_hash, const parameter_row *rows, uint32_t count) {
  if (parameter_store_progress(store) == PARAMETER_STORE_BUSY || !fits(&store->areas[0], 0, count) ||
      next_sequence(store) > PARAMETER_STORE_MAX_SAVES) {
    return false;
  }
  store->last_sequence = next_sequence(store); /* of a failed save too */
  store->save = (parameter_save){
      .rows = rows,
      .record = {.sequence = store->last_sequence, .schema_hash = schema_hash, .rows = count},
      .crc = CRC32_START,
  };
  atomic_store_explicit(&store->state, PARAMETER_STORE_BUSY, memory_order_release);
  return true;
}

/* Each page of a record begins with a double word that is not blank. */
static bool is_begun(const hal_flash *flash, uint32_t page) {
  flash_unit first;
  return !read_unit(flash, page, 0, &first) || (first.low & first.high) != UINT32_MAX;
}

/* The area may have the record that is in doubt. The first or the last pages are taken, so that the end of the last
 * record there, which is the newest, stays until the new one is complete: else a loss of power would leave no trace of
 * it. */
static void place_in_doubt(const parameter_store *store, parameter_save *save) {
  const hal_flash *flash = &store->areas[save->record.area];
  const uint32_t pages = pages_of(flash, save->record.rows);
  uint32_t end = flash->pages;
  /* Bound: pages of an area: end is counted down. */
  while (end > 0 && !is_begun(flash, end - 1)) {
    --end;
  }
  if (end <= pages) {
    save->record.page = flash->pages - pages;
    save->erase = save->record.page;
  }
  save->erase_end = save->record.page + pages;
  save->rest = 0;
}

/* Behind the record in use, when these pages were erased since the start and no save was attempted there. */
static void place(parameter_store *store) {
  parameter_save *save = &store->save;
  const uint32_t used = store->in_use.area;
  const uint32_t pages = store->areas[used].pages;
  save->placed = true;
  save->rest = PARAMETER_STORE_AREAS * pages; /* nothing */
  if (store->has_in_use && store->free_page > 0 && fits(&store->areas[used], store->free_page, save->record.rows)) {
    save->record.area = used;
    save->record.page = store->free_page;
  } else {
    save->record.area = store->has_in_use ? other_area(used) : 0;
    save->erase_end = pages;
    if (store->in_doubt) {
      place_in_doubt(store, save);
    }
  }
  store->free_page = 0;
}

/* Page `rest` of both areas neither belongs to the new record nor is in the area of the one in use. */
static bool is_of_rest(const parameter_store *store, const parameter_save *save) {
  const hal_flash *flash = &store->areas[0];
  const uint32_t area = save->rest / flash->pages;
  const uint32_t page = save->rest % flash->pages;
  const uint32_t first = save->record.page;
  const bool is_new = area == save->record.area && page >= first && page < first + pages_of(flash, save->record.rows);
  return !is_new && (!store->has_in_use || area != store->in_use.area);
}

/* Passes over pages that stay. */
static bool has_rest(const parameter_store *store, parameter_save *save) {
  const uint32_t pages = PARAMETER_STORE_AREAS * store->areas[0].pages;
  /* Bound: pages of both areas: rest is counted up. */
  while (save->rest < pages && !is_of_rest(store, save)) {
    save->rest++;
  }
  return save->rest < pages;
}

static flash_unit unit_to_program(const parameter_save *save) {
  const parameter_record *record = &save->record;
  const uint32_t end = record->rows + 2;
  if (save->unit == 0) {
    return (flash_unit){MAGIC, record->sequence};
  }
  if (save->unit == 1) {
    return (flash_unit){record->schema_hash, record->rows};
  }
  if (save->unit < end) {
    const parameter_row *row = &save->rows[save->unit - 2];
    return (flash_unit){row->id, row->value};
  }
  const uint32_t crc = crc32_end(save->crc);
  return save->unit == end ? (flash_unit){crc, ~crc} : (flash_unit){COMMIT, record->sequence};
}

static bool program_next(const hal_flash *flash, parameter_save *save) {
  const flash_unit unit = unit_to_program(save);
  const uint32_t words[2] = {unit.low, unit.high};
  const uint32_t offset = save->record.page * flash->page_bytes + save->unit * HAL_FLASH_UNIT_BYTES;
  if (!flash->program(flash, offset, words)) {
    return false;
  }
  if (save->unit < save->record.rows + 2) {
    save->crc = add_unit(save->crc, unit);
  }
  save->unit++;
  return true;
}

/* One operation. */
static bool go_on(const parameter_store *store, parameter_save *save) {
  const hal_flash *flash = &store->areas[save->record.area];
  if (save->erase < save->erase_end) {
    return flash->erase(flash, save->erase++);
  }
  if (save->unit < units_of(save->record.rows)) {
    return program_next(flash, save);
  }
  const hal_flash *area = &store->areas[save->rest / flash->pages];
  return area->erase(area, save->rest++ % flash->pages);
}

static parameter_store_state work(parameter_store *store) {
  parameter_save *save = &store->save;
  if (!save->placed) {
    place(store);
  }
  if (!go_on(store, save)) {
    return PARAMETER_STORE_FAILED;
  }
  const hal_flash *flash = &store->areas[save->record.area];
  if (save->unit < units_of(save->record.rows) || has_rest(store, save)) {
    return PARAMETER_STORE_BUSY;
  }
  store->in_use = save->record;
  store->has_in_use = true;
  store->in_doubt = false;
  store->free_page = save->record.page + pages_of(flash, save->record.rows);
  return PARAMETER_STORE_SAVED;
}

void parameter_store_step(parameter_store *store) {
  if (atomic_load_explicit(&store->state, memory_order_acquire) == PARAMETER_STORE_BUSY) {
    atomic_store_explicit(&store->state, (uint32_t)work(store), memory_order_release);
  }
}

parameter_store_state parameter_store_progress(const parameter_store *store) {
  return (parameter_store_state)atomic_load_explicit(&store->state, memory_order_acquire);
}
