/* SPDX-License-Identifier: Apache-2.0 */
#include "node/fault_reports.h"

#include <stdbool.h>

static bool has_code(fault_set set, uint16_t code) {
  bool found = false;
  for (int i = 1; i < FAULT_COUNT; ++i) {
    found = found || ((set >> i & 1u) != 0 && fault_table[i].code == code);
  }
  return found;
}

/* An error on the bus is one source and one code: it ends when no fault with this code is left. */
static fault_id end_one(fault_reports *reports, fault_set present) {
  const fault_id gone = fault_worst(reports->active & ~present);
  if (gone == FAULT_NONE) {
    return FAULT_NONE;
  }
  reports->active &= ~fault_bit(gone);
  return has_code(reports->active, fault_table[gone].code) ? FAULT_NONE : gone;
}

/* The fault that the axis is in comes before those detected with it. */
static fault_id report_one(fault_reports *reports, fault_id latched) {
  const bool first = (reports->waiting & fault_bit(latched)) != 0;
  const fault_id next = first ? latched : fault_worst(reports->waiting);
  if (next == FAULT_NONE) {
    return FAULT_NONE;
  }
  reports->waiting &= ~fault_bit(next);
  reports->reported |= fault_bit(next);
  reports->active |= fault_bit(next);
  return next;
}

fault_reports_item fault_reports_step(fault_reports *reports, fault_id latched, fault_set found) {
  fault_set present = 0;
  if (latched == FAULT_NONE) {
    reports->reported = 0;
    reports->waiting = 0;
  } else {
    present = found | fault_bit(latched);
    reports->waiting |= present & ~reports->reported;
  }
  fault_reports_item item;
  item.over = end_one(reports, present);
  item.reported = report_one(reports, latched);
  return item;
}
