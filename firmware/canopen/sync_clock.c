/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/sync_clock.h"

enum { TICK_US = 1000, WINDOW_TICKS = 2000, MAX_TICKS = 10000, LONGEST_PERIOD_US = 1000000, JITTER_US = 3000 };
enum { PER_MILLE = 7, ENOUGH = 2 };

void sync_clock_reset(sync_clock *clock) { *clock = (sync_clock){.open = false}; }

static void begin(sync_clock *clock) {
  clock->open = true;
  clock->ticks = 0;
  clock->interval = 0;
  clock->syncs = 0;
}

static bool judge(sync_clock *clock, uint32_t period_us) {
  const uint32_t elapsed_us = clock->ticks * TICK_US;
  const uint32_t expected_us = clock->syncs * period_us;
  const uint32_t error_us = elapsed_us > expected_us ? elapsed_us - expected_us : expected_us - elapsed_us;
  const bool deviates = error_us > expected_us / 1000u * PER_MILLE + JITTER_US;
  const bool was_off = clock->off;
  clock->deviating = deviates ? clock->deviating + (clock->deviating < ENOUGH ? 1 : 0) : 0;
  clock->off = clock->deviating >= ENOUGH;
  return clock->off != was_off;
}

bool sync_clock_hear(sync_clock *clock, uint32_t period_us) {
  if (period_us == 0 || period_us > LONGEST_PERIOD_US) {
    return false;
  }
  const uint32_t interval_us = clock->interval * TICK_US;
  const bool regular = interval_us + TICK_US >= period_us / 2u && interval_us <= period_us + period_us / 2u + TICK_US;
  if (!clock->open || !regular) {
    begin(clock);
    return false;
  }
  clock->interval = 0;
  clock->syncs++;
  if (clock->ticks < WINDOW_TICKS) {
    return false;
  }
  const bool changed = judge(clock, period_us);
  begin(clock);
  return changed;
}

void sync_clock_tick(sync_clock *clock) {
  clock->ticks += clock->ticks < MAX_TICKS ? 1u : 0u;
  clock->interval += clock->interval < MAX_TICKS ? 1u : 0u;
}
