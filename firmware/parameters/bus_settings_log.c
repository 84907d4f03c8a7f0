#include "parameters/bus_settings_log.h"

#include "base/crc32.h"

typedef struct {
  uint32_t content;
  uint32_t crc;
} log_entry;

_Static_assert(sizeof(log_entry) == HAL_FLASH_UNIT_BYTES, "an entry is programmed in one piece");

static uint32_t units_per_page(const hal_flash *flash) { return flash->page_bytes / HAL_FLASH_UNIT_BYTES; }

/* --- entries ------------------------------------------------------------------------------------------------------ */

static uint32_t crc_of(uint32_t content) {
  return crc32_end(crc32_add(CRC32_START, (const uint8_t *)&content, sizeof content));
}

static log_entry entry_of(const bus_settings *settings, uint32_t sequence) {
  const uint32_t content = settings->node_id | (uint32_t)bus_index_of_kbit_s(settings->kbit_s) << 8 | sequence << 16;
  return (log_entry){.content = content, .crc = crc_of(content)};
}

static uint32_t sequence_of(const log_entry *entry) { return entry->content >> 16; }

static bus_settings settings_of(const log_entry *entry) {
  return (bus_settings){.node_id = (uint8_t)entry->content,
                        .kbit_s = bus_kbit_s_of_index((uint8_t)(entry->content >> 8))};
}

/* An erased double word has a correct CRC, but no sequence number. */
static bool is_good(const log_entry *entry) {
  const bus_settings settings = settings_of(entry);
  return entry->crc == crc_of(entry->content) && sequence_of(entry) <= BUS_SETTINGS_LOG_MAX_SAVES &&
         bus_node_id_is_good(settings.node_id) && settings.kbit_s != 0;
}

static bool is_blank(const log_entry *entry) { return (entry->content & entry->crc) == UINT32_MAX; }

/* --- start -------------------------------------------------------------------------------------------------------- */

/* Returns the first unit after the last one that is not blank. */
static uint32_t look_at_page(bus_settings_log *log, uint32_t page) {
  const hal_flash *flash = log->flash;
  uint32_t end = 0;
  for (uint32_t unit = 0; unit < units_per_page(flash); ++unit) {
    log_entry entry;
    const uint32_t offset = page * flash->page_bytes + unit * HAL_FLASH_UNIT_BYTES;
    const bool readable = flash->read(flash, offset, &entry, sizeof entry);
    if (readable && is_blank(&entry)) {
      continue;
    }
    end = unit + 1;
    if (readable && is_good(&entry) && (!log->found || sequence_of(&entry) > log->sequence)) {
      log->found = true;
      log->newest = settings_of(&entry);
      log->newest_page = page;
      log->sequence = sequence_of(&entry);
    }
  }
  return end;
}

/* After a skipped unit: one whose programming was interrupted can look blank. */
void bus_settings_log_open(bus_settings_log *log, const hal_flash *flash, const bus_settings *defaults) {
  *log = (bus_settings_log){.flash = flash, .newest = *defaults};
  if (flash == NULL) {
    return;
  }
  uint32_t end[BUS_SETTINGS_LOG_PAGES];
  for (uint32_t page = 0; page < BUS_SETTINGS_LOG_PAGES; ++page) {
    end[page] = look_at_page(log, page);
  }
  log->page = log->newest_page;
  log->unit = end[log->page] + 1;
}

/* --- saving ------------------------------------------------------------------------------------------------------- */

bool bus_settings_log_begin(bus_settings_log *log, const bus_settings *settings) {
  if (atomic_load_explicit(&log->work, memory_order_acquire) == BUS_SETTINGS_REQUESTED) {
    return false;
  }
  log->wanted = *settings;
  const bool is_stored = bus_settings_are_same(settings, &log->newest) && (log->found || log->flash == NULL);
  atomic_store_explicit(&log->work, is_stored ? BUS_SETTINGS_SAVED : BUS_SETTINGS_REQUESTED, memory_order_release);
  return true;
}

bus_settings_work bus_settings_log_take_result(bus_settings_log *log) {
  const uint32_t work = atomic_load_explicit(&log->work, memory_order_acquire);
  if (work == BUS_SETTINGS_SAVED || work == BUS_SETTINGS_FAILED) {
    atomic_store_explicit(&log->work, BUS_SETTINGS_IDLE, memory_order_release);
  }
  return (bus_settings_work)work;
}

static bool is_full(const bus_settings_log *log) {
  return log->flash != NULL && log->unit >= units_per_page(log->flash);
}

/* The page without the newest entry, also when that page is full of failed entries. */
static void erase_other_page(bus_settings_log *log) {
  const uint32_t page = BUS_SETTINGS_LOG_PAGES - 1 - log->newest_page;
  log->erase_failed = !log->flash->erase(log->flash, page);
  if (!log->erase_failed) {
    log->page = page;
    log->unit = 0;
  }
}

static bool program(bus_settings_log *log) {
  if (log->sequence >= BUS_SETTINGS_LOG_MAX_SAVES || is_full(log)) {
    return false; /* full: the erase failed */
  }
  log->sequence++; /* of a failed save too: its remains must not be taken for the next one */
  const log_entry entry = entry_of(&log->wanted, log->sequence);
  const uint32_t words[2] = {entry.content, entry.crc};
  const uint32_t offset = log->page * log->flash->page_bytes + log->unit * HAL_FLASH_UNIT_BYTES;
  log->unit++;
  if (!log->flash->program(log->flash, offset, words)) {
    return false;
  }
  log->newest_page = log->page;
  log->found = true;
  return true;
}

static void save(bus_settings_log *log) {
  const bool saved = log->flash == NULL || program(log);
  if (saved) {
    log->newest = log->wanted;
  }
  atomic_store_explicit(&log->work, saved ? BUS_SETTINGS_SAVED : BUS_SETTINGS_FAILED, memory_order_release);
}

bool bus_settings_log_step(bus_settings_log *log) {
  const bool requested = atomic_load_explicit(&log->work, memory_order_acquire) == BUS_SETTINGS_REQUESTED;
  if (is_full(log) && (requested || !log->erase_failed)) {
    erase_other_page(log);
    if (!log->erase_failed) {
      return true;
    }
  }
  if (requested) {
    save(log);
  }
  return requested;
}
