#include "parameters/parameter_store.h"

#include <string.h>

#include "base/crc32.h"

#define MAGIC 0x54535631u  /* "1VST": a record in this layout begins */
#define COMMIT 0x444E4521u /* "!END": the record is complete */

/* A first word close to the magic was one: its record is damaged, not absent. */
enum { MAX_WRONG_BITS = 4 };

/* A double word of flash. */
typedef struct {
  uint32_t low;
  uint32_t high;
} flash_unit;

_Static_assert(sizeof(parameter_row) == HAL_FLASH_UNIT_BYTES, "a row is programmed in one piece");
_Static_assert(sizeof(flash_unit) == HAL_FLASH_UNIT_BYTES, "no padding");

typedef enum { PLACE_EMPTY, PLACE_COMPLETE, PLACE_UNFINISHED, PLACE_DAMAGED } place_verdict;

static uint32_t units_of(uint32_t rows) { return rows + PARAMETER_STORE_FRAME_UNITS; }

static uint32_t units_per_page(const hal_flash *flash) { return flash->page_bytes / HAL_FLASH_UNIT_BYTES; }

static uint32_t pages_of(const hal_flash *flash, uint32_t rows) {
  const uint32_t per_page = units_per_page(flash);
  return (units_of(rows) + per_page - 1) / per_page;
}

static uint32_t add_unit(uint32_t crc, flash_unit unit) { return crc32_add(crc, (const uint8_t *)&unit, sizeof unit); }

/* --- reading ---------------------------------------------------------------------------------------------------- */

/* Double word `unit` counts from the beginning of `page`. */
static bool read_unit(const hal_flash *flash, uint32_t page, uint32_t unit, flash_unit *read) {
  const uint32_t offset = page * flash->page_bytes + unit * HAL_FLASH_UNIT_BYTES;
  return flash->read(flash, offset, read, sizeof *read);
}

static bool is_nearly_magic(uint32_t word) {
  uint32_t wrong = word ^ MAGIC;
  uint32_t count = 0;
  for (int i = 0; i < 32; ++i) {
    count += wrong & 1u;
    wrong >>= 1;
  }
  return count <= MAX_WRONG_BITS;
}

static bool fits(const hal_flash *flash, uint32_t page, uint32_t rows) {
  return rows <= PARAMETER_STORE_MAX_ROWS && pages_of(flash, rows) <= flash->pages - page;
}

/* Sum of a record's head and rows; `rows` receives the latter if it is not NULL. */
static bool sum(const hal_flash *flash, const parameter_record *record, parameter_row *rows, uint32_t *crc) {
  const flash_unit head[] = {{MAGIC, record->sequence}, {record->schema_hash, record->rows}};
  *crc = add_unit(add_unit(CRC32_START, head[0]), head[1]);
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
  if (!read_unit(flash, record->page, 0, &head[0]) || !read_unit(flash, record->page, 1, &head[1])) {
    return PLACE_DAMAGED;
  }
  if (head[0].low != MAGIC) {
    return is_nearly_magic(head[0].low) ? PLACE_DAMAGED : PLACE_EMPTY;
  }
  record->sequence = head[0].high;
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
  while (rank > 0 && record->sequence > store->found[rank - 1].sequence) {
    store->found[rank] = store->found[rank - 1];
    --rank;
  }
  store->found[rank] = *record;
}

/* Returns the page after the examined ones. */
static uint32_t look_at_page(parameter_store *store, uint32_t area, uint32_t page) {
  const hal_flash *flash = &store->areas[area];
  parameter_record record = {.area = area, .page = page};
  switch (look(flash, &record)) {
    case PLACE_COMPLETE:
      insert(store, &record);
      return page + pages_of(flash, record.rows);
    case PLACE_UNFINISHED:
      store->unfinished++;
      break;
    case PLACE_DAMAGED:
      store->damaged++;
      break;
    case PLACE_EMPTY:
      break;
  }
  return page + 1;
}

void parameter_store_open(parameter_store *store, const hal_flash areas[PARAMETER_STORE_AREAS]) {
  memset(store, 0, sizeof *store);
  store->areas = areas;
  for (uint32_t area = 0; area < PARAMETER_STORE_AREAS; ++area) {
    uint32_t page = 0;
    while (page < areas[area].pages && page < PARAMETER_STORE_MAX_PAGES) {
      page = look_at_page(store, area, page);
    }
  }
  if (store->count > 0) {
    store->last_sequence = store->found[0].sequence;
    parameter_store_use(store, 0);
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
  }
}

/* --- saving ----------------------------------------------------------------------------------------------------- */

bool parameter_store_begin(parameter_store *store, uint32_t schema_hash, const parameter_row *rows, uint32_t count) {
  if (parameter_store_progress(store) == PARAMETER_STORE_BUSY || !fits(&store->areas[0], 0, count) ||
      store->last_sequence >= PARAMETER_STORE_MAX_SAVES) {
    return false;
  }
  store->last_sequence++; /* of a failed save too: its remains must not be taken for the next one */
  store->save = (parameter_save){
      .rows = rows,
      .record = {.sequence = store->last_sequence, .schema_hash = schema_hash, .rows = count},
      .crc = CRC32_START,
  };
  atomic_store_explicit(&store->state, PARAMETER_STORE_BUSY, memory_order_release);
  return true;
}

static bool is_blank(const hal_flash *flash, uint32_t page, uint32_t pages) {
  for (uint32_t unit = 0; unit < pages * units_per_page(flash); ++unit) {
    flash_unit read;
    if (!read_unit(flash, page, unit, &read) || (read.low & read.high) != UINT32_MAX) {
      return false;
    }
  }
  return true;
}

/* Behind the record in use, when the rest of its area is blank: then no save was attempted there. */
static void place(parameter_store *store) {
  parameter_save *save = &store->save;
  save->placed = true;
  save->record.area = 0;
  save->record.page = 0;
  save->erase = 0;
  if (!store->has_in_use) {
    return;
  }
  const parameter_record *used = &store->in_use;
  const hal_flash *flash = &store->areas[used->area];
  const uint32_t next = used->page + pages_of(flash, used->rows);
  if (next < flash->pages && fits(flash, next, save->record.rows) && is_blank(flash, next, flash->pages - next)) {
    save->record.area = used->area;
    save->record.page = next;
    save->erase = flash->pages; /* nothing */
  } else {
    save->record.area = PARAMETER_STORE_AREAS - 1 - used->area;
  }
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

static parameter_store_state work(parameter_store *store) {
  parameter_save *save = &store->save;
  if (!save->placed) {
    place(store);
    return PARAMETER_STORE_BUSY;
  }
  const hal_flash *flash = &store->areas[save->record.area];
  if (save->erase < flash->pages) {
    return flash->erase(flash, save->erase++) ? PARAMETER_STORE_BUSY : PARAMETER_STORE_FAILED;
  }
  if (!program_next(flash, save)) {
    return PARAMETER_STORE_FAILED;
  }
  if (save->unit < units_of(save->record.rows)) {
    return PARAMETER_STORE_BUSY;
  }
  store->in_use = save->record;
  store->has_in_use = true;
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
