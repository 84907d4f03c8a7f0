#include "node/kept_storage.h"

#include <string.h>

static uint8_t at_most_u8(uint32_t count) { return count < UINT8_MAX ? (uint8_t)count : UINT8_MAX; }

static uint16_t at_most_u16(uint32_t count) { return count < UINT16_MAX ? (uint16_t)count : UINT16_MAX; }

/* --- start ------------------------------------------------------------------------------------------------------ */

/* Into `next`, so that nothing of a refused set remains. */
static bool take(kept_storage *storage, uint32_t n, const object_dictionary *dictionary, kept_rows_report *rows) {
  if (!parameter_store_load(&storage->store, n, storage->rows, KEPT_MOST_ROWS)) {
    return false;
  }
  storage->next = storage->factory;
  return kept_objects_from_rows(&storage->next, storage->rows, storage->store.found[n].rows, rows) &&
         kept_objects_are_good(&storage->next, dictionary);
}

static kept_source source_of(const kept_storage *storage, const parameter_record *record) {
  const kept_report *report = &storage->report;
  if (report->damaged + report->unfinished + report->refused > 0) {
    return record != NULL ? KEPT_OLDER : KEPT_DEFAULTS_BY_FAULT;
  }
  if (record == NULL || storage->groups == 0) {
    return KEPT_DEFAULTS;
  }
  return record->schema_hash == storage->schema_hash ? KEPT_STORED : KEPT_MIGRATED;
}

static const parameter_record *take_newest_good(kept_storage *storage, const object_dictionary *dictionary) {
  for (uint32_t n = 0; n < storage->store.count; ++n) {
    const parameter_record *record = &storage->store.found[n];
    kept_rows_report rows = {.groups = 0};
    if (take(storage, n, dictionary, &rows)) {
      parameter_store_use(&storage->store, n);
      storage->stored = storage->next;
      storage->groups = rows.groups;
      storage->report.sequence = record->sequence;
      storage->report.dropped = at_most_u16(rows.dropped);
      storage->report.missing = at_most_u16(rows.missing);
      return record;
    }
    storage->report.refused++;
  }
  return NULL;
}

void kept_storage_start(kept_storage *storage, const object_dictionary *dictionary, const kept_objects *factory,
                        const hal_flash *flash, uint32_t schema_hash) {
  memset(storage, 0, sizeof *storage);
  storage->factory = *factory;
  storage->stored = *factory;
  storage->schema_hash = schema_hash;
  storage->has_flash = flash != NULL;
  if (storage->has_flash) {
    parameter_store_open(&storage->store, flash);
    storage->report.damaged = at_most_u8(storage->store.damaged);
    storage->report.unfinished = at_most_u8(storage->store.unfinished);
    const parameter_record *record = take_newest_good(storage, dictionary);
    storage->report.source = (uint8_t)source_of(storage, record);
  }
}

/* --- commands --------------------------------------------------------------------------------------------------- */

static void prepare(kept_storage *storage, const kept_command *command) {
  const uint8_t groups = kept_groups(command->group);
  storage->saving = command->saving;
  storage->group = command->group;
  storage->next = storage->stored;
  kept_objects_copy(&storage->next, command->saving ? command->in_force : &storage->factory, groups);
  storage->next_groups = (uint8_t)(command->saving ? storage->groups | groups : storage->groups & ~groups);
}

static void adopt(kept_storage *storage) {
  storage->stored = storage->next;
  storage->groups = storage->next_groups;
  storage->report = (kept_report){.source = storage->next_groups != 0 ? KEPT_STORED : KEPT_DEFAULTS,
                                  .sequence = storage->store.last_sequence};
  storage->answer = OD_OK;
}

/* The result is for a requester with the same command and values: another client may have given up meanwhile. */
static bool is_answered(const kept_storage *storage, const kept_command *command) {
  if (storage->progress != KEPT_ANSWERED || storage->saving != command->saving || storage->group != command->group) {
    return false;
  }
  const kept_objects *wanted = command->saving ? command->in_force : &storage->factory;
  return storage->answer != OD_OK || kept_objects_are_same(&storage->stored, wanted, kept_groups(command->group));
}

/* The newest set in flash already has the requested contents, so there is nothing to write. A set that was found
 * damaged, or is of another version, is always replaced. */
static bool is_stored(const kept_storage *storage, const kept_command *command) {
  const uint8_t groups = kept_groups(command->group);
  if (storage->report.source != KEPT_STORED && storage->report.source != KEPT_DEFAULTS) {
    return false;
  }
  if (!command->saving) {
    return (storage->groups & groups) == 0;
  }
  return (storage->groups & groups) == groups && kept_objects_are_same(&storage->stored, command->in_force, groups);
}

od_abort kept_storage_command(kept_storage *storage, const kept_command *command) {
  if (storage->progress == KEPT_SAVING) {
    return OD_PENDING;
  }
  if (is_answered(storage, command)) {
    storage->progress = KEPT_IDLE;
    return storage->answer;
  }
  if (command->powered) {
    return OD_DEVICE_STATE;
  }
  if (is_stored(storage, command)) {
    return OD_OK;
  }
  prepare(storage, command);
  storage->progress = KEPT_SAVING;
  atomic_store_explicit(&storage->work, storage->has_flash ? KEPT_WORK_ASKED : KEPT_WORK_DONE, memory_order_release);
  return OD_PENDING;
}

bool kept_storage_tick(kept_storage *storage) {
  if (storage->progress == KEPT_ANSWERED) {
    storage->progress = KEPT_IDLE; /* nobody has called in this tick */
  }
  const uint32_t work = atomic_load_explicit(&storage->work, memory_order_acquire);
  if (storage->progress != KEPT_SAVING || (work != KEPT_WORK_DONE && work != KEPT_WORK_FAILED)) {
    return false;
  }
  storage->progress = KEPT_ANSWERED;
  storage->answer = OD_HARDWARE;
  if (work == KEPT_WORK_DONE) {
    adopt(storage);
  }
  return storage->answer == OD_OK;
}

/* --- background ------------------------------------------------------------------------------------------------- */

/* `next` does not change while it is being saved. */
static uint32_t begin(kept_storage *storage) {
  const uint32_t count = kept_objects_to_rows(&storage->next, storage->next_groups, storage->rows, KEPT_MOST_ROWS);
  return parameter_store_begin(&storage->store, storage->schema_hash, storage->rows, count) ? KEPT_WORK_BEGUN
                                                                                            : KEPT_WORK_FAILED;
}

static uint32_t go_on(kept_storage *storage) {
  parameter_store_step(&storage->store);
  switch (parameter_store_progress(&storage->store)) {
    case PARAMETER_STORE_BUSY:
      return KEPT_WORK_BEGUN;
    case PARAMETER_STORE_SAVED:
      return KEPT_WORK_DONE;
    default:
      return KEPT_WORK_FAILED;
  }
}

void kept_storage_background(kept_storage *storage) {
  const uint32_t work = atomic_load_explicit(&storage->work, memory_order_acquire);
  if (work == KEPT_WORK_ASKED) {
    atomic_store_explicit(&storage->work, begin(storage), memory_order_release);
  } else if (work == KEPT_WORK_BEGUN) {
    atomic_store_explicit(&storage->work, go_on(storage), memory_order_release);
  }
}
