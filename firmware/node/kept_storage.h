/* Where the kept objects are kept: what a reset comes back to, in RAM, and behind it the parameter store in flash.
 *
 *     0x1010, 0x1011 -> next set -> rows -> parameter_store, step by step in the background -> `stored`
 *
 * A command is answered when its set is in flash: until then it is pending, asked again in each tick. Without a flash
 * everything is the same, but gone with the power. */
#ifndef TRACKSERVO_NODE_KEPT_STORAGE_H
#define TRACKSERVO_NODE_KEPT_STORAGE_H

#include "node/objects/kept_objects.h"

/* 0x3031:1, what `stored` is made of. */
typedef enum {
  KEPT_DEFAULTS = 0,         /* nothing is stored */
  KEPT_STORED = 1,           /* the newest set */
  KEPT_MIGRATED = 2,         /* likewise, of a version with another dictionary: taken by index and sub-index */
  KEPT_OLDER = 3,            /* a set, but another that is damaged, cut off or refused may be newer */
  KEPT_DEFAULTS_BY_FAULT = 4 /* all that was found is damaged, cut off or refused */
} kept_source;

/* 0x3031. */
typedef struct {
  uint8_t source;     /* kept_source */
  uint32_t sequence;  /* of the stored set, counts all saves; 0: none */
  uint8_t damaged;    /* sets with wrong contents, found at the start */
  uint8_t unfinished; /* saves that a loss of power cut off, found at the start */
  uint8_t refused;    /* complete sets whose values are beyond limits or do not fit together */
  uint16_t dropped;   /* of the set taken: values of objects that are not there any more */
  uint16_t missing;   /* of the set taken: objects that it does not know, and that keep their defaults */
} kept_report;

typedef enum { KEPT_IDLE, KEPT_SAVING, KEPT_ANSWERED } kept_progress;

/* What the background is asked for, and how it went. */
enum { KEPT_WORK_NONE, KEPT_WORK_ASKED, KEPT_WORK_BEGUN, KEPT_WORK_DONE, KEPT_WORK_FAILED };

typedef struct {
  kept_objects factory; /* what the node was started with */
  kept_objects stored;  /* what a reset comes back to */
  uint8_t groups;       /* KEPT_*: the other one is at its defaults */
  kept_report report;
  bool has_flash;
  parameter_store store;
  uint32_t schema_hash;
  /* The command at hand. */
  kept_progress progress;
  bool saving;
  uint8_t group;
  od_abort answer;
  kept_objects next;
  uint8_t next_groups;
  parameter_store_flag work; /* KEPT_WORK_* */
  parameter_row rows[KEPT_MOST_ROWS];
} kept_storage;

/* Looks for the newest set that passes all checks. `factory` is in force now; `flash`: two areas that outlive the
 * storage, or NULL. */
void kept_storage_start(kept_storage *storage, const object_dictionary *dictionary, const kept_objects *factory,
                        const hal_flash *flash, uint32_t schema_hash);

typedef struct {
  bool saving;                  /* 0x1010, else 0x1011 */
  uint8_t group;                /* STORAGE_* */
  bool powered;                 /* an axis has torque: nothing is begun then, OD_DEVICE_STATE */
  const kept_objects *in_force; /* what would be saved */
} kept_command;

/* OD_PENDING: ask again in the next tick. */
od_abort kept_storage_command(kept_storage *storage, const kept_command *command);

/* In each tick, after commands were asked. True: `stored` has become another one. */
bool kept_storage_tick(kept_storage *storage);

/* Makes the rows of a new set, or does one operation of the flash at most, which may take 25 ms. kept_storage_tick and
 * _command may interrupt it. */
void kept_storage_background(kept_storage *storage);

#endif
