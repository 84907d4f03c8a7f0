/* SPDX-License-Identifier: Apache-2.0 */
/* Texts of each fault for people: how it is detected, causes, what to check, remedies, how it is cleared.
 *
 * The other half of `fault_table`, row by row; faults.json and docs/faults.md are printed from both
 * (sim_host/commands/describe_node). Tools only: no image has these texts. */
#ifndef TRACKSERVO_PROTECTION_FAULT_TEXTS_H
#define TRACKSERVO_PROTECTION_FAULT_TEXTS_H

#include <stdbool.h>
#include <stdint.h>

#include "protection/fault_log.h"
#include "protection/fault_table.h"

/* Of the source in the EMCY's byte 4. */
typedef enum { FAULT_OF_AXIS, FAULT_OF_BOARD, FAULT_OF_STORE } fault_owner;

typedef struct {
  const char *name;
  fault_owner owner;
  bool reported_once; /* after a reset; it does not persist */
  const char *detection;
  const char *when;  /* it can be detected */
  const char *timer; /* object that adds to the latency, as "2060:5"; "" without */
  uint64_t limits;   /* bit n: 2060:n is relevant */
  const char *cause;
  const char *check;
  const char *cure;
  const char *clear;
} fault_text;

/* Returns the texts of a fault below FAULT_COUNT; FAULT_NONE has a name only. */
const fault_text *fault_text_of(fault_id fault);

typedef struct {
  const char *name; /* as in `fault_log_sample`, without the unit */
  const char *unit;
} fault_signal;

/* Columns of a fault log entry, in the order of `fault_log_sample`. */
extern const fault_signal fault_signals[FAULT_LOG_SIGNALS];

#endif
