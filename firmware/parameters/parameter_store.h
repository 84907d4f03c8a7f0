/* SPDX-License-Identifier: Apache-2.0 */
/* A parameter set in flash that survives a loss of power at any time.
 *
 * Two areas of a few pages each hold a log of records, each at the beginning of a page:
 *
 *     magic, sequence | schema hash, rows | row .. | CRC-32, its complement | commit mark, sequence
 *
 * in double words, each programmed once, the commit mark last. A record is valid when mark, CRC and sequence are
 * correct; the one with the highest sequence is the newest. (Sequence numbers that wrap could not order three records.)
 *
 * A double word may be readable at one start and not, or with wrong bits, at another (decision 0033). So a page
 * that is neither blank nor part of a complete record may be a record that is newer than those found, unless its place
 * shows that it is older. It is reported until the next save, which is answered when the record in doubt is erased, or
 * has a lower number for certain.
 *
 * The first save after a start, and one that has no room behind the record in use, goes to the other area, which is
 * erased first. Others go behind the record in use. That record is never changed. So after a power failure at any time
 * there is the old set or the new one. Each page is erased once in two saves at most; once in (pages of an area / pages
 * of a record) times two saves when they follow each other without a start between.
 *
 * A save is done in steps of at most one flash operation, in a context of its own: the requester (the tick) may
 * interrupt the worker (the background), or both may be the same context. */
#ifndef TRACKSERVO_PARAMETERS_PARAMETER_STORE_H
#define TRACKSERVO_PARAMETERS_PARAMETER_STORE_H

#include "hal_flash.h"

#ifdef __cplusplus
extern "C++" {
#include <atomic>
}
typedef std::atomic<uint32_t> parameter_store_flag; /* same representation as in C; C++17 has no stdatomic.h */
#else
#include <stdatomic.h>
typedef _Atomic uint32_t parameter_store_flag;
#endif

enum {
  PARAMETER_STORE_AREAS = 2,
  PARAMETER_STORE_MAX_PAGES = 4, /* of an area */
  PARAMETER_STORE_MAX_RECORDS = PARAMETER_STORE_AREAS * PARAMETER_STORE_MAX_PAGES,
  PARAMETER_STORE_MAX_ROWS = 512,
  PARAMETER_STORE_FRAME_UNITS = 4 /* double words of a record besides its rows */
};

/* The highest sequence, far beyond the endurance of flash; a higher one is damaged. */
#define PARAMETER_STORE_MAX_SAVES UINT32_C(0x7FFFFFFF)

/* What the sequence grows by in a save in doubt: more than all saves that the flash endures. */
#define PARAMETER_STORE_DOUBT_STEP UINT32_C(0x10000)

/* One parameter, one double word: index << 16 | sub-index << 8 | od_type as on the bus, and the value's bytes, lowest
 * first, zeros above. Values of more than four bytes cannot be stored. */
typedef struct {
  uint32_t id;
  uint32_t value;
} parameter_row;

/* A complete record. */
typedef struct {
  uint32_t sequence;
  uint32_t schema_hash; /* of the dictionary that it was saved from */
  uint32_t rows;
  uint32_t area;
  uint32_t page; /* its first */
} parameter_record;

typedef enum {
  PARAMETER_STORE_IDLE,
  PARAMETER_STORE_BUSY,
  PARAMETER_STORE_SAVED,
  PARAMETER_STORE_FAILED /* the flash refused; the previous record is still valid */
} parameter_store_state;

/* Work in progress; owned by the worker while the store is busy. */
typedef struct {
  const parameter_row *rows;
  parameter_record record;
  uint32_t crc;
  uint32_t erase;     /* next page of its area to erase, before */
  uint32_t erase_end; /* the page after the last of them */
  uint32_t unit;      /* next double word to program */
  uint32_t rest;      /* next page to erase after it, of both areas */
  bool placed;
} parameter_save;

typedef struct {
  const hal_flash *areas; /* two, of the same size, with at most PARAMETER_STORE_MAX_PAGES pages */
  parameter_record found[PARAMETER_STORE_MAX_RECORDS]; /* complete ones, newest first */
  uint32_t count;
  uint32_t damaged;    /* records, possibly newer, whose contents are wrong or cannot be read at this start */
  uint32_t unfinished; /* records, possibly newer, without commit mark: the power failed during a save */
  bool in_doubt;       /* one of these, or a newer one was refused; until the next save */
  uint32_t last_sequence;
  parameter_record in_use; /* never changed; rows, area and page count if there is one */
  bool has_in_use;
  uint32_t free_page; /* behind the record in use: erased since the start, and blank; 0: none */
  parameter_save save;
  parameter_store_flag state; /* parameter_store_state */
} parameter_store;

/* Searches both areas (which must exist longer than the store); the newest complete record, if any, is the one in use.
 * For the start: reads all of both areas, and sums each record once. */
void parameter_store_open(parameter_store *store, const hal_flash areas[PARAMETER_STORE_AREAS]);

/* Reads the rows of found[n]. Returns false, and nothing usable in `rows`, when there is none, it has more than
 * `capacity` rows, or the data read differ from the saved data. */
bool parameter_store_load(const parameter_store *store, uint32_t n, parameter_row *rows, uint32_t capacity);

/* Protects found[n] from the next save, for a caller that refuses a newer record. */
void parameter_store_use(parameter_store *store, uint32_t n);

/* Starts a save; `rows` must not change until the store is no longer busy. Returns false when it is busy, a record with
 * that many rows does not fit into an area, or the sequence is exhausted. */
bool parameter_store_begin(parameter_store *store, uint32_t schema_hash, const parameter_row *rows, uint32_t count);

/* Does the next step, if there is one: at most one page erased or one double word programmed. */
void parameter_store_step(parameter_store *store);

/* Returns the state; SAVED and FAILED report the last save, until the next one begins. */
parameter_store_state parameter_store_progress(const parameter_store *store);

#endif
