/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/exposure_clock.h"

enum { US_PER_STAMP = 10, SMALLEST_JUMP = CAMERA_TIMES_PER_TICK / 2 };

/* Of stamps, in the direction in which they are nearer. */
static int32_t difference(uint32_t later, uint32_t earlier) { return (int16_t)(uint16_t)(later - earlier); }

void exposure_clock_reset(exposure_clock *self) { *self = (exposure_clock){.since_jump = EXPOSURE_CLOCK_FORGETS}; }

void exposure_clock_set(exposure_clock *self, uint32_t time_us, uint32_t at_us) { self->offset_us = time_us - at_us; }

void exposure_clock_tick(exposure_clock *self, uint32_t next_tick_us) {
  const uint16_t stamp = (uint16_t)((next_tick_us + self->offset_us) / US_PER_STAMP);
  const uint16_t expected = (uint16_t)(self->stamp + CAMERA_TIMES_PER_TICK);
  const int32_t jump = difference(stamp, expected);
  if (jump >= SMALLEST_JUMP || jump <= -SMALLEST_JUMP) {
    self->old_minus_new = (uint16_t)(expected - stamp);
    self->since_jump = 0;
  } else if (self->since_jump < EXPOSURE_CLOCK_FORGETS) {
    self->since_jump = (uint16_t)(self->since_jump + CAMERA_TIMES_PER_TICK);
  }
  self->stamp = stamp;
  self->next_tick_us = next_tick_us;
}

int32_t exposure_clock_age(const exposure_clock *self, uint16_t stamp) {
  const int32_t age = difference(self->stamp, stamp);
  const int32_t since = self->since_jump;
  if (since >= EXPOSURE_CLOCK_FORGETS) {
    return age;
  }
  const int32_t old_age = difference((uint32_t)self->stamp + self->old_minus_new, stamp);
  const bool before = old_age >= since && old_age < EXPOSURE_CLOCK_FORGETS;
  const bool after = age >= 0 && age <= since;
  if (before && after) {
    return CAMERA_AGE_AMBIGUOUS;
  }
  return before ? old_age : age;
}
