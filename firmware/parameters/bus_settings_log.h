/* SPDX-License-Identifier: Apache-2.0 */
/* Node id and bit rate in flash: a log of double words in two pages of its own; the newest entry is valid.
 *
 *     node id, index of the bit rate, sequence number (16 bits) | CRC-32 of these four bytes
 *
 * A save programs one double word (85 us on the board), the first one after a start two, so an LSS master has its
 * answer within 2 ms; a save by 0x1010 takes up to 140 ms. When a page is full, the other one is erased before the next
 * save. The page with the newest entry is never erased: after a power failure the flash has either the old settings or
 * the new ones. An entry that cannot be read at this start and may be newer is reported (`in_doubt`). The next save
 * then goes behind it, or erases it before the answer, which takes 22 ms (decision 0033). Requests (from the
 * tick's thread) and their execution
 * (`bus_settings_log_step`, in the background) may interrupt each other. */
#ifndef TRACKSERVO_PARAMETERS_BUS_SETTINGS_LOG_H
#define TRACKSERVO_PARAMETERS_BUS_SETTINGS_LOG_H

#include "canopen/bus_settings.h"
#include "hal_flash.h"
#include "parameters/parameter_store.h" /* of it: the flag */

enum { BUS_SETTINGS_LOG_PAGES = 2, BUS_SETTINGS_LOG_MAX_SAVES = 0xFFFE };

typedef enum { BUS_SETTINGS_IDLE, BUS_SETTINGS_REQUESTED, BUS_SETTINGS_SAVED, BUS_SETTINGS_FAILED } bus_settings_work;

typedef struct {
  const hal_flash *flash; /* BUS_SETTINGS_LOG_PAGES pages; NULL: kept in RAM only */
  bool found;             /* an entry in the flash */
  bool in_doubt;          /* an entry that cannot be read or is incomplete may be newer; until the next save */
  bool erase_rest;        /* the other page, in doubt, is erased before the next save is answered */
  bool entry_done;        /* of that save */
  bool trace_left;        /* in the page of the newest entry, that the other one is in doubt */
  bool needs_mark;        /* no entry since the start */
  bus_settings newest;    /* stored last; without an entry, the defaults given at the start */
  uint32_t newest_page;
  uint32_t newest_unit;
  uint32_t sequence; /* its number: grows by one per unit, whether the unit is used or not */
  uint32_t page;     /* place of the next entry */
  uint32_t unit;
  bool erase_failed; /* repeated when a save is requested */
  bus_settings wanted;
  parameter_store_flag work; /* bus_settings_work */
} bus_settings_log;

/* Reads both pages; `defaults` apply where nothing is stored. */
void bus_settings_log_open(bus_settings_log *log, const hal_flash *flash, const bus_settings *defaults);

/* Requests a save. Returns false when one is in progress. */
bool bus_settings_log_begin(bus_settings_log *log, const bus_settings *settings);

/* Returns SAVED or FAILED once after a save. */
bus_settings_work bus_settings_log_take_result(bus_settings_log *log);

/* Does at most one flash operation. Call in the background. Returns true when there was one to do. */
bool bus_settings_log_step(bus_settings_log *log);

#endif
