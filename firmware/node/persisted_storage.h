/* SPDX-License-Identifier: Apache-2.0 */
/* Storage of the persisted objects: the values after a reset, in RAM, and behind them the parameter store in flash.
 *
 *     0x1010, 0x1011 -> next set -> rows -> parameter_store, step by step in the background -> `stored`
 *
 * A command is answered when its set is in flash: until then it is pending and is called again in each tick. Without a
 * flash everything works the same, but is lost with the power. */
#ifndef TRACKSERVO_NODE_KEPT_STORAGE_H
#define TRACKSERVO_NODE_KEPT_STORAGE_H

#include "node/objects/persisted_objects.h"

/* 0x3031:1, origin of `stored`. */
typedef enum {
  PERSISTED_DEFAULTS = 0,         /* nothing is stored */
  PERSISTED_STORED = 1,           /* the newest set */
  PERSISTED_MIGRATED = 2,         /* the same, from a version with another dictionary: taken by index and sub-index */
  PERSISTED_OLDER = 3,            /* a set, but another one that is damaged, cut off or refused may be newer */
  PERSISTED_DEFAULTS_BY_FAULT = 4 /* every set found is damaged, cut off or refused */
} persisted_source;

/* 0x3031. */
typedef struct {
  uint8_t source;     /* persisted_source */
  uint32_t sequence;  /* of the stored parameter set, counts all saves; 0: none */
  uint8_t damaged;    /* sets with wrong contents, found at the start */
  uint8_t unfinished; /* saves that a loss of power cut off, found at the start */
  uint8_t refused;    /* complete sets whose values are beyond limits or do not fit together */
  uint16_t dropped;   /* of the set taken: values of objects that no longer exist */
  uint16_t missing;   /* of the set taken: unknown objects, which keep their defaults */
} persisted_report;

typedef enum { PERSISTED_IDLE, PERSISTED_SAVING, PERSISTED_ANSWERED } retained_progress;

/* Request to the background and its result. */
enum {
  PERSISTED_WORK_NONE,
  PERSISTED_WORK_REQUESTED,
  PERSISTED_WORK_BEGUN,
  PERSISTED_WORK_DONE,
  PERSISTED_WORK_FAILED
};

typedef struct {
  persisted_objects factory; /* values at the start of the node */
  persisted_objects stored;  /* values after a reset */
  uint8_t groups;            /* PERSISTED_*: the other group is at its defaults */
  persisted_report report;
  bool has_flash;
  parameter_store store;
  uint32_t schema_hash;
  /* The command in progress. */
  retained_progress progress;
  bool saving;
  uint8_t group;
  uint8_t answered_ms; /* how long the answer has waited for its client */
  od_abort answer;
  persisted_objects next;
  uint8_t next_groups;
  parameter_store_flag work; /* PERSISTED_WORK_* */
  parameter_row rows[PERSISTED_MAX_ROWS];
} persisted_storage;

/* Searches for the newest set that passes all checks. `factory` is in effect now; `flash`: two areas that exist longer
 * than the storage, or NULL. */
void persisted_storage_start(persisted_storage *storage, const object_dictionary *dictionary,
                             const persisted_objects *factory, const hal_flash *flash, uint32_t schema_hash);

typedef struct {
  bool saving;                       /* 0x1010, otherwise 0x1011 */
  uint8_t group;                     /* STORAGE_*; 0: only the hash of the owner's word (0x3040:4) */
  uint64_t access_hash;              /* of group 0 */
  bool powered;                      /* an axis has torque: nothing is started then, OD_DEVICE_STATE */
  const persisted_objects *in_force; /* values to be saved */
} persisted_command;

/* Returns the stored hash of the owner's word, or 0 if there is none. */
uint64_t persisted_storage_access_hash(const persisted_storage *storage);

/* Executes a command. Call again in the next tick after OD_PENDING. */
od_abort persisted_storage_command(persisted_storage *storage, const persisted_command *command);

/* Returns true while a command that has to write the flash goes on. */
static inline bool persisted_storage_writes(const persisted_storage *storage) {
  return storage->progress == PERSISTED_SAVING;
}

/* Completes commands. Call in each tick, after the commands. Returns true when `stored` has changed. */
bool persisted_storage_tick(persisted_storage *storage);

/* Makes the rows of a new set, or does at most one flash operation, which may take 25 ms. persisted_storage_tick and
 * _command may interrupt it. */
void persisted_storage_background(persisted_storage *storage);

#endif
