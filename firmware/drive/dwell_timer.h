/* SPDX-License-Identifier: Apache-2.0 */
/* A condition that is true only after it has held for a time: the windows of CiA 402.
 *
 * Standard: CiA 402-2 / IEC 61800-7-201 objects 6065/6066 (following error), 6067/6068 (position window), 606D/606E
 * (velocity window), 606F/6070 (velocity threshold). One timer per condition, stepped once per tick. Time 0 means at
 * once. */
#ifndef TRACKSERVO_DRIVE_DWELL_TIMER_H
#define TRACKSERVO_DRIVE_DWELL_TIMER_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
  float held_ms;
} dwell_timer;

/* Returns true once `condition` has been true in every tick for more than `time_ms`. */
static inline bool dwell_timer_step(dwell_timer *timer, bool condition, uint16_t time_ms, float dt_s) {
  const float longest_ms = 66000.0f; /* above every time_ms */
  if (!condition) {
    timer->held_ms = 0.0f;
    return false;
  }
  const bool held = timer->held_ms >= (float)time_ms;
  if (timer->held_ms < longest_ms) {
    timer->held_ms += dt_s * 1000.0f;
  }
  return held;
}

#endif
