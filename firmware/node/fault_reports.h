/* SPDX-License-Identifier: Apache-2.0 */
/* Faults of an axis that are still to be reported to the bus and the fault log.
 *
 * An axis enters one fault and stays in it until the reset. Meanwhile others may occur, independent of the first or
 * caused by it. Each is reported once until the reset, however often it comes and goes in this time: a loose contact
 * must not flush the log. One report per tick, the worst fault first, so that the cost of a tick is bounded. */
#ifndef TRACKSERVO_NODE_FAULT_REPORTS_H
#define TRACKSERVO_NODE_FAULT_REPORTS_H

#include "protection/fault_table.h"

typedef struct {
  fault_set reported; /* since the axis entered its fault */
  fault_set waiting;  /* detected, not reported yet */
  fault_set active;   /* reported, not over */
} fault_reports;

typedef struct {
  fault_id over;     /* the code that no active fault has any more: send "no error"; FAULT_NONE: nothing to send */
  fault_id reported; /* to be reported now, after `over`, and logged; FAULT_NONE: nothing */
} fault_reports_item;

/* Returns what to report in this tick. `latched` is the fault that the axis is in, or FAULT_NONE; `found` has all
 * faults detected in this tick. Call every tick. */
fault_reports_item fault_reports_step(fault_reports *reports, fault_id latched, fault_set found);

#endif
