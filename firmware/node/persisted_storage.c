/* SPDX-License-Identifier: Apache-2.0 */
#include "node/persisted_storage.h"

#include <string.h>

/* Two SDO channels may have turns (canopen_services.c). */
enum { ANSWER_MS = 2 };

static uint8_t at_most_u8(uint32_t count) { return count < UINT8_MAX ? (uint8_t)count : UINT8_MAX; }

static uint16_t at_most_u16(uint32_t count) { return count < UINT16_MAX ? (uint16_t)count : UINT16_MAX; }

/* --- start ------------------------------------------------------------------------------------------------------ */

/* Into `next`, so that nothing of a refused set remains. */
static bool take(persisted_storage *storage, uint32_t n, const object_dictionary *dictionary,
                 persisted_rows_report *rows) {
  if (!parameter_store_load(&storage->store, n, storage->rows, PERSISTED_MAX_ROWS)) {
    return false;
  }
  storage->next = storage->factory;
  return persisted_objects_from_rows(&storage->next, storage->rows, storage->store.found[n].rows, rows) &&
         persisted_objects_are_good(&storage->next, dictionary);
}

static bool has_objects(uint8_t groups) { return (groups & (PERSISTED_COMMUNICATION | PERSISTED_APPLICATION)) != 0; }

uint64_t persisted_storage_access_hash(const persisted_storage *storage) {
  return storage->stored.access_hash[0] | (uint64_t)storage->stored.access_hash[1] << 32;
}

static persisted_source source_of(const persisted_storage *storage, const parameter_record *record) {
  const persisted_report *report = &storage->report;
  if (report->damaged + report->unfinished + report->refused > 0) {
    return record != NULL ? PERSISTED_OLDER : PERSISTED_DEFAULTS_BY_FAULT;
  }
  if (record == NULL || !has_objects(storage->groups)) {
    return PERSISTED_DEFAULTS;
  }
  return record->schema_hash == storage->schema_hash ? PERSISTED_STORED : PERSISTED_MIGRATED;
}

static const parameter_record *take_newest_good(persisted_storage *storage, const object_dictionary *dictionary) {
  /* Bound: PARAMETER_STORE_MAX_RECORDS; at the start, not in the tick. */
  for (uint32_t n = 0; n < storage->store.count; ++n) {
    const parameter_record *record = &storage->store.found[n];
    persisted_rows_report rows = {.groups = 0};
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

void persisted_storage_start(persisted_storage *storage, const object_dictionary *dictionary,
                             const persisted_objects *factory, const hal_flash *flash, uint32_t schema_hash) {
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

static void prepare_word(persisted_storage *storage, uint64_t hash) {
  storage->next.access_hash[0] = (uint32_t)hash;
  storage->next.access_hash[1] = (uint32_t)(hash >> 32);
  storage->next_groups =
      (uint8_t)(hash != 0 ? storage->groups | PERSISTED_ACCESS : storage->groups & ~PERSISTED_ACCESS);
}

static void prepare(persisted_storage *storage, const persisted_command *command) {
  const uint8_t groups = retained_groups(command->group);
  storage->saving = command->saving;
  storage->group = command->group;
  storage->next = storage->stored;
  if (command->group == 0) {
    prepare_word(storage, command->access_hash);
    return;
  }
  persisted_objects_copy(&storage->next, command->saving ? command->in_force : &storage->factory, groups);
  storage->next_groups = (uint8_t)(command->saving ? storage->groups | groups : storage->groups & ~groups);
}

static void adopt(persisted_storage *storage) {
  storage->stored = storage->next;
  storage->groups = storage->next_groups;
  storage->report =
      (persisted_report){.source = has_objects(storage->next_groups) ? PERSISTED_STORED : PERSISTED_DEFAULTS,
                         .sequence = storage->store.last_sequence};
  storage->answer = OD_OK;
}

/* The result is for a requester with the same command and values: another client may have given up meanwhile. */
static bool is_answered(const persisted_storage *storage, const persisted_command *command) {
  if (storage->progress != PERSISTED_ANSWERED || storage->saving != command->saving ||
      storage->group != command->group) {
    return false;
  }
  if (command->group == 0) {
    return storage->answer != OD_OK || persisted_storage_access_hash(storage) == command->access_hash;
  }
  const persisted_objects *wanted = command->saving ? command->in_force : &storage->factory;
  return storage->answer != OD_OK ||
         persisted_objects_are_same(&storage->stored, wanted, retained_groups(command->group));
}

/* The newest set in flash already has the requested contents, so there is nothing to write. A set that was found
 * damaged, or is of another version, is always replaced. */
static bool is_stored(const persisted_storage *storage, const persisted_command *command) {
  const uint8_t groups = retained_groups(command->group);
  if (storage->report.source != PERSISTED_STORED && storage->report.source != PERSISTED_DEFAULTS) {
    return false;
  }
  if (command->group == 0) {
    return persisted_storage_access_hash(storage) == command->access_hash;
  }
  if (!command->saving) {
    return (storage->groups & groups) == 0;
  }
  return (storage->groups & groups) == groups &&
         persisted_objects_are_same(&storage->stored, command->in_force, groups);
}

od_abort persisted_storage_command(persisted_storage *storage, const persisted_command *command) {
  if (storage->progress == PERSISTED_SAVING) {
    return OD_PENDING;
  }
  if (is_answered(storage, command)) {
    storage->progress = PERSISTED_IDLE;
    return storage->answer;
  }
  if (command->powered) {
    return OD_DEVICE_STATE;
  }
  if (is_stored(storage, command)) {
    return OD_OK;
  }
  prepare(storage, command);
  storage->progress = PERSISTED_SAVING;
  atomic_store_explicit(&storage->work, storage->has_flash ? PERSISTED_WORK_REQUESTED : PERSISTED_WORK_DONE,
                        memory_order_release);
  return OD_PENDING;
}

bool persisted_storage_tick(persisted_storage *storage) {
  if (storage->progress == PERSISTED_ANSWERED && ++storage->answered_ms >= ANSWER_MS) {
    storage->progress = PERSISTED_IDLE; /* nobody has called */
  }
  const uint32_t work = atomic_load_explicit(&storage->work, memory_order_acquire);
  if (storage->progress != PERSISTED_SAVING || (work != PERSISTED_WORK_DONE && work != PERSISTED_WORK_FAILED)) {
    return false;
  }
  storage->progress = PERSISTED_ANSWERED;
  storage->answered_ms = 0;
  storage->answer = OD_HARDWARE;
  if (work == PERSISTED_WORK_DONE) {
    adopt(storage);
  }
  return storage->answer == OD_OK;
}

/* --- background ------------------------------------------------------------------------------------------------- */

/* `next` does not change while it is being saved. */
static uint32_t begin(persisted_storage *storage) {
  const uint32_t count =
      persisted_objects_to_rows(&storage->next, storage->next_groups, storage->rows, PERSISTED_MAX_ROWS);
  return parameter_store_begin(&storage->store, storage->schema_hash, storage->rows, count) ? PERSISTED_WORK_BEGUN
                                                                                            : PERSISTED_WORK_FAILED;
}

static uint32_t go_on(persisted_storage *storage) {
  parameter_store_step(&storage->store);
  switch (parameter_store_progress(&storage->store)) {
    case PARAMETER_STORE_BUSY:
      return PERSISTED_WORK_BEGUN;
    case PARAMETER_STORE_SAVED:
      return PERSISTED_WORK_DONE;
    default:
      return PERSISTED_WORK_FAILED;
  }
}

void persisted_storage_background(persisted_storage *storage) {
  const uint32_t work = atomic_load_explicit(&storage->work, memory_order_acquire);
  if (work == PERSISTED_WORK_REQUESTED) {
    atomic_store_explicit(&storage->work, begin(storage), memory_order_release);
  } else if (work == PERSISTED_WORK_BEGUN) {
    atomic_store_explicit(&storage->work, go_on(storage), memory_order_release);
  }
}
