/* SPDX-License-Identifier: Apache-2.0 */
/* The node's clock (1013, us) against which an image processor stamps its exposures, and the age of such a stamp.
 *
 *     1013 = machine's clock + offset_us          set by a time producer or a client
 *     stamp = 1013 / 10 modulo 2^16               16 bits in 10 us, 655 ms
 *
 * The machine's clock (hal_clock_us) is never set, so setting 1013 moves nothing that is tracked. When the stamps jump,
 * because 1013 was set by half a ms or more or because it wrapped, a stamp has two readings for a while. Before the
 * jump `old` was in force, since then `new`. A frame has the age whose exposure lies on its own side of the jump; if
 * both do, it has none. Cost: about 60 instructions for a stamp, 40 per ms. */
#ifndef TRACKSERVO_SERVO_EXPOSURE_CLOCK_H
#define TRACKSERVO_SERVO_EXPOSURE_CLOCK_H

#include <stdint.h>

#include "servo/camera_input.h"

typedef struct {
  uint32_t offset_us;     /* 1013 minus the machine's clock */
  uint32_t next_tick_us;  /* machine's clock at the tick that takes the next frame */
  uint16_t stamp;         /* of that tick */
  uint16_t old_minus_new; /* of the stamps at the last jump */
  uint16_t since_jump;    /* 10 us, up to EXPOSURE_CLOCK_FORGETS */
} exposure_clock;

enum { EXPOSURE_CLOCK_FORGETS = (CAMERA_LONGEST_AGE_TICKS + 1) * CAMERA_TIMES_PER_TICK };

/* Resets the clock for a machine that has just started: no jump, 1013 equals the machine's clock. */
void exposure_clock_reset(exposure_clock *self);

/* Sets 1013: it was `time_us` when the machine's clock was `at_us`. Frames use it from the next exposure_clock_tick
 * on. */
void exposure_clock_set(exposure_clock *self, uint32_t time_us, uint32_t at_us);

/* Call once per ms between two ticks; the next one begins when the machine's clock is `next_tick_us`. */
void exposure_clock_tick(exposure_clock *self, uint32_t next_tick_us);

/* Returns the age, at the next tick, of an exposure with this stamp, in 10 us: negative if it is later,
 * CAMERA_AGE_AMBIGUOUS around a jump of the clock. */
int32_t exposure_clock_age(const exposure_clock *self, uint16_t stamp);

#endif
