/* SPDX-License-Identifier: Apache-2.0 */
/* When the holding brake of one axis is released: while torque stands, and at no other time.
 *
 *     loop closes -> coil on -> release time -> the axis may move
 *     stop has ended, and the torque will end -> coil off, torque held -> engage time -> torque off
 *     torque off, or motor shorted -> coil off at once
 *
 * A spring engages the brake when its coil has no current. An axis without a brake has times of 0; its output still
 * follows the torque. Once per tick. */
#ifndef TRACKSERVO_DRIVE_HOLDING_BRAKE_H
#define TRACKSERVO_DRIVE_HOLDING_BRAKE_H

#include <stdbool.h>

typedef struct {
  float release_s;    /* from coil on to open, 0 .. 10 */
  float engage_s;     /* from coil off to closed, 0 .. 10 */
  bool feedback_used; /* a contact reports the position */
} holding_brake_times;

typedef struct {
  bool coil_on;
  float since_s; /* the coil changed; limited */
  bool opened;   /* coil on for the release time: the axis may move */
  bool failed;   /* the contact contradicts the coil */
} holding_brake;

/* How much longer than its time the brake may take before its contact counts as wrong. */
#define HOLDING_BRAKE_TOLERANCE_S 0.1f

/* Computes one tick. `hold`: torque stands and shall go on standing. `contact_open`: what the contact reports. */
void holding_brake_step(holding_brake *brake, const holding_brake_times *times, bool hold, bool contact_open,
                        float dt_s);

/* Returns whether the coil has been off for the engage time: the torque may end. */
static inline bool holding_brake_has_engaged(const holding_brake *brake, const holding_brake_times *times) {
  return !brake->coil_on && brake->since_s >= times->engage_s;
}

#endif
