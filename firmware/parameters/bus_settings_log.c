/* SPDX-License-Identifier: Apache-2.0 */
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

/* What look_at_page found in a page. */
typedef struct {
  uint32_t end;  /* the unit after the last one that is not blank */
  uint32_t good; /* entries */
  bool in_doubt; /* behind the last of them there is a unit that is neither blank nor good */
} page_account;

static page_account look_at_page(bus_settings_log *log, uint32_t page) {
  const hal_flash *flash = log->flash;
  page_account account = {0};
  /* Bound: 256: double words of a page of 2 KiB; at the start only. */
  for (uint32_t unit = 0; unit < units_per_page(flash); ++unit) {
    log_entry entry;
    const uint32_t offset = page * flash->page_bytes + unit * HAL_FLASH_UNIT_BYTES;
    const bool readable = flash->read(flash, offset, &entry, sizeof entry);
    if (readable && is_blank(&entry)) {
      continue;
    }
    account.end = unit + 1;
    if (!readable || !is_good(&entry)) {
      account.in_doubt = true;
      continue;
    }
    account.in_doubt = false;
    account.good++;
    if (!log->found || sequence_of(&entry) > log->sequence) {
      log->found = true;
      log->newest = settings_of(&entry);
      log->newest_page = page;
      log->newest_unit = unit;
      log->sequence = sequence_of(&entry);
    }
  }
  return account;
}

/* The last unit is for leave_trace. */
static bool is_full(const bus_settings_log *log) {
  return log->flash != NULL && log->unit + 1 >= units_per_page(log->flash);
}

/* Entries follow each other in a page, and a page is erased before it is filled. So a unit in doubt can be newer than
 * the newest entry if it is behind it, or if there is no good entry in its page. */
static void judge(bus_settings_log *log, const page_account pages[BUS_SETTINGS_LOG_PAGES]) {
  for (uint32_t page = 0; page < BUS_SETTINGS_LOG_PAGES; ++page) {
    const bool may_be_newer = pages[page].good == 0 || page == log->newest_page;
    log->in_doubt = log->in_doubt || (may_be_newer && pages[page].in_doubt);
  }
}

/* The next entry goes after a skipped unit: one whose programming was interrupted can look blank. What is in doubt
 * stays until the next entry is there: that goes behind it, or the page is erased afterwards. Where no entry is good,
 * the numbers of those in doubt are unknown, and the next entry begins the other page, erased. */
static void place(bus_settings_log *log, const page_account pages[BUS_SETTINGS_LOG_PAGES]) {
  if (!log->found && log->in_doubt) {
    log->newest_page = pages[0].in_doubt ? 0 : 1;
    log->page = log->newest_page;
    log->unit = units_per_page(log->flash);
    log->erase_rest = true;
    return;
  }
  const uint32_t other = BUS_SETTINGS_LOG_PAGES - 1 - log->newest_page;
  const bool other_was_begun = pages[other].end == 0 && log->sequence >= units_per_page(log->flash);
  log->page = log->newest_page;
  log->unit = other_was_begun ? units_per_page(log->flash) : pages[log->page].end + 1;
  log->erase_rest = pages[other].good == 0 && pages[other].in_doubt;
}

void bus_settings_log_open(bus_settings_log *log, const hal_flash *flash, const bus_settings *defaults) {
  *log = (bus_settings_log){.flash = flash, .newest = *defaults};
  if (flash == NULL) {
    return;
  }
  page_account pages[BUS_SETTINGS_LOG_PAGES];
  for (uint32_t page = 0; page < BUS_SETTINGS_LOG_PAGES; ++page) {
    pages[page] = look_at_page(log, page);
  }
  judge(log, pages);
  place(log, pages);
  log->needs_mark = true;
}

/* --- saving ------------------------------------------------------------------------------------------------------- */

bool bus_settings_log_begin(bus_settings_log *log, const bus_settings *settings) {
  if (atomic_load_explicit(&log->work, memory_order_acquire) == BUS_SETTINGS_REQUESTED) {
    return false;
  }
  log->wanted = *settings;
  const bool is_stored =
      bus_settings_are_same(settings, &log->newest) && ((log->found && !log->in_doubt) || log->flash == NULL);
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

/* Before a page in doubt is erased: else a loss of power now would leave nothing that reports it. */
static bool leave_trace(const bus_settings_log *log) {
  const uint32_t words[2] = {0, 0};
  const uint32_t last = (log->newest_page + 1) * log->flash->page_bytes - HAL_FLASH_UNIT_BYTES;
  log_entry entry;
  const bool blank = log->flash->read(log->flash, last, &entry, sizeof entry) && is_blank(&entry);
  return !blank || log->flash->program(log->flash, last, words);
}

/* The page without the newest entry, also when that page is full of failed entries. */
static void erase_other_page(bus_settings_log *log) {
  const uint32_t page = BUS_SETTINGS_LOG_PAGES - 1 - log->newest_page;
  log->erase_failed = !log->flash->erase(log->flash, page);
  if (!log->erase_failed) {
    log->page = page;
    log->unit = 0;
    log->needs_mark = false;
    log->erase_rest = log->erase_rest && !log->found;
  }
}

/* It counts units, so that an entry in doubt, behind the newest one or in the other page, has a lower number. */
static uint32_t sequence_here(const bus_settings_log *log) {
  const uint32_t units_before = log->page == log->newest_page ? 0 : units_per_page(log->flash);
  return log->sequence + units_before + log->unit - log->newest_unit;
}

static bool program(bus_settings_log *log, uint32_t content, uint32_t crc) {
  const uint32_t words[2] = {content, crc};
  const uint32_t offset = log->page * log->flash->page_bytes + log->unit * HAL_FLASH_UNIT_BYTES;
  log->unit++;
  return log->flash->program(log->flash, offset, words);
}

static bool program_entry(bus_settings_log *log) {
  const uint32_t unit = log->unit;
  const uint32_t sequence = sequence_here(log);
  if (sequence > BUS_SETTINGS_LOG_MAX_SAVES || is_full(log)) {
    return false; /* full: the erase failed */
  }
  const log_entry entry = entry_of(&log->wanted, sequence);
  if (!program(log, entry.content, entry.crc)) {
    return false;
  }
  log->newest_page = log->page;
  log->newest_unit = unit;
  log->sequence = sequence;
  log->found = true;
  return true;
}

static void answer(bus_settings_log *log, bool saved) {
  if (saved) {
    log->newest = log->wanted;
    log->in_doubt = false;
  }
  log->entry_done = false;
  atomic_store_explicit(&log->work, saved ? BUS_SETTINGS_SAVED : BUS_SETTINGS_FAILED, memory_order_release);
}

/* One operation: the mark, the entry, or what was in doubt in the other page. */
static void save(bus_settings_log *log) {
  if (log->flash == NULL) {
    answer(log, true);
  } else if (log->entry_done) {
    log->erase_rest = !log->flash->erase(log->flash, BUS_SETTINGS_LOG_PAGES - 1 - log->newest_page);
    answer(log, !log->erase_rest);
  } else if (log->needs_mark && !is_full(log)) {
    log->needs_mark = !program(log, 0, 0);
  } else {
    const bool programmed = program_entry(log);
    log->entry_done = programmed && log->erase_rest;
    if (!log->entry_done) {
      answer(log, programmed);
    }
  }
}

/* Ahead of the request, so that it need not wait; not while the other page may have a newer entry. */
static bool erases_now(const bus_settings_log *log, bool requested) {
  return is_full(log) && !log->entry_done && (requested || (!log->erase_failed && !log->in_doubt));
}

bool bus_settings_log_step(bus_settings_log *log) {
  const bool requested = atomic_load_explicit(&log->work, memory_order_acquire) == BUS_SETTINGS_REQUESTED;
  if (erases_now(log, requested)) {
    if (log->erase_rest && log->found && !log->trace_left) {
      log->trace_left = leave_trace(log);
      if (!log->trace_left) {
        answer(log, false);
      }
      return true;
    }
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
