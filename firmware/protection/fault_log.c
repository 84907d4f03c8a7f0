/* SPDX-License-Identifier: Apache-2.0 */
#include "protection/fault_log.h"

#include <stddef.h>

void fault_log_clear(fault_log *log) { log->count = 0; }

void fault_log_sample_tick(fault_log *log, int axis, const fault_log_sample *sample) {
  fault_log_history *history = &log->history[axis];
  history->sample[history->next] = *sample;
  history->next = (uint8_t)((history->next + 1u) % FAULT_LOG_TICKS);
  history->count = (uint8_t)(history->count + (history->count < FAULT_LOG_TICKS ? 1u : 0u));
}

static void copy_history(const fault_log_history *history, fault_log_entry *entry) {
  entry->samples = history->count;
  const uint32_t oldest = history->next + 2u * FAULT_LOG_TICKS - history->count;
  /* Bound: FAULT_LOG_TICKS: it is not counted beyond. */
  for (uint32_t i = 0; i < history->count; ++i) {
    entry->before[i] = history->sample[(oldest + i) % FAULT_LOG_TICKS];
  }
}

void fault_log_write(fault_log *log, int source, fault_id fault, uint32_t tick) {
  fault_log_entry *entry = &log->entry[log->count % FAULT_LOG_ENTRIES];
  log->count++;
  entry->tick = tick;
  entry->fault = (uint8_t)fault;
  entry->source = (uint8_t)source;
  entry->samples = 0;
  if (source < SERVO_AXES) {
    copy_history(&log->history[source], entry);
  }
}

const fault_log_entry *fault_log_find(const fault_log *log, uint32_t age) {
  if (age >= FAULT_LOG_ENTRIES || age >= log->count) {
    return NULL;
  }
  return &log->entry[(log->count - 1u - age) % FAULT_LOG_ENTRIES];
}
