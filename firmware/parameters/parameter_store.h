/* A set of parameters in flash that no loss of power can destroy.
 *
 * Two areas of a few pages each hold a log of records, each at the beginning of a page:
 *
 *     magic, sequence | schema hash, rows | row .. | CRC-32, its complement | commit mark, sequence
 *
 * in double words, each programmed once, the commit mark last. A record counts when mark, CRC and sequence are right;
 * the one with the highest sequence is the newest (a circle would have no order for three numbers around it). A new
 * record goes behind the one in use while there are blank pages, else into the other area, which is erased first: the
 * one in use is never touched. So, whenever the power fails, there is the old set or the new one. Each page is erased
 * once in (pages of an area / pages of a record) times two saves.
 *
 * A save is done in steps, each one flash operation at most, in a context of its own: the one who asks (the tick) may
 * interrupt the one who works (the background), or both may be the same. */
#ifndef TRACKSERVO_PARAMETERS_PARAMETER_STORE_H
#define TRACKSERVO_PARAMETERS_PARAMETER_STORE_H

#include "hal_flash.h"

#ifdef __cplusplus
extern "C++" {
#include <atomic>
}
typedef std::atomic<uint32_t> parameter_store_flag; /* the same representation as C's; C++17 has no stdatomic.h */
#else
#include <stdatomic.h>
typedef _Atomic uint32_t parameter_store_flag;
#endif

enum {
  PARAMETER_STORE_AREAS = 2,
  PARAMETER_STORE_MOST_PAGES = 4, /* of an area */
  PARAMETER_STORE_MOST_RECORDS = PARAMETER_STORE_AREAS * PARAMETER_STORE_MOST_PAGES,
  PARAMETER_STORE_MOST_ROWS = 512,
  PARAMETER_STORE_FRAME_UNITS = 4 /* double words of a record besides its rows */
};

/* The highest sequence, which is far beyond what flash endures; a higher one is damaged. */
#define PARAMETER_STORE_MOST_SAVES UINT32_C(0x7FFFFFFF)

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
  PARAMETER_STORE_FAILED /* the flash refused; what was stored before still is */
} parameter_store_state;

/* The work at hand; the worker's while the store is busy. */
typedef struct {
  const parameter_row *rows;
  parameter_record record;
  uint32_t crc;
  uint32_t erase; /* next page to erase */
  uint32_t unit;  /* next double word to program */
  bool placed;
} parameter_save;

typedef struct {
  const hal_flash *areas; /* two, of the same size, of PARAMETER_STORE_MOST_PAGES at most */
  parameter_record found[PARAMETER_STORE_MOST_RECORDS]; /* complete ones, newest first */
  uint32_t count;
  uint32_t damaged;    /* records with a commit mark whose contents are wrong, or that cannot be read */
  uint32_t unfinished; /* records without commit mark: the power failed in a save */
  uint32_t last_sequence;
  parameter_record in_use; /* never touched; rows, area and page count if there is one */
  bool has_in_use;
  parameter_save save;
  parameter_store_flag state; /* parameter_store_state */
} parameter_store;

/* Looks through both areas (which must outlive the store); the newest complete record, if any, is the one in use. For
 * the start: reads all of both areas, and sums each record once. */
void parameter_store_open(parameter_store *store, const hal_flash areas[PARAMETER_STORE_AREAS]);

/* Reads the rows of found[n]. False, and nothing usable in `rows`: there is none, it has more than `capacity` rows, or
 * what was read is not what was saved. */
bool parameter_store_load(const parameter_store *store, uint32_t n, parameter_row *rows, uint32_t capacity);

/* found[n] is what the next save must not touch, for one who refuses a newer record. */
void parameter_store_use(parameter_store *store, uint32_t n);

/* Begins to save; `rows` must stay as they are until the store is no longer busy. False: it is busy, a record of so
 * many rows does not fit into an area, or the sequence is at its end. */
bool parameter_store_begin(parameter_store *store, uint32_t schema_hash, const parameter_row *rows, uint32_t count);

/* Does the next piece of work, if there is any: at most one page erased or one double word programmed. */
void parameter_store_step(parameter_store *store);

/* SAVED and FAILED tell of the last save, until the next one begins. */
parameter_store_state parameter_store_progress(const parameter_store *store);

#endif
