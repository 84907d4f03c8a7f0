/* SPDX-License-Identifier: Apache-2.0 */
/* The values that the tick uses, and that must not change by themselves: of each axis its parameters as built, its
 * active gains and its limits, and the scales of the board.
 *
 * A complement copy of all is compared in slices, in the deferred task: a bit that flips is found within
 * GUARDED_SETS_CYCLE_MS. Whoever changes a set on purpose counts that in its `changes`. */
#ifndef TRACKSERVO_NODE_GUARDED_SETS_H
#define TRACKSERVO_NODE_GUARDED_SETS_H

#include "base/guarded_copy.h"
#include "node/objects/protection_objects.h"
#include "parameters/axis_tuning.h"
#include "servo/servo_app.h"

enum { GUARDED_SETS_WORDS_PER_MS = 16, GUARDED_SETS_CYCLE_MS = 24 };

/* Of one axis. */
typedef struct {
  const servo_axis_params *built;
  const axis_tuning *tuning;
  const protection_objects *objects;
  const protection_limits *limits;
} guarded_axis;

typedef struct {
  guarded_copy copy;
  guarded_axis axis[SERVO_AXES];
  uint32_t tuned[SERVO_AXES]; /* `changes` of what is sealed */
  uint32_t limited[SERVO_AXES];
  int scales;
  uint32_t damaged; /* bit n: block n, until it is sealed again */
} guarded_sets;

/* Adds all sets and takes their complements. Returns false when there is no room for them. */
bool guarded_sets_start(guarded_sets *sets, const guarded_axis axes[SERVO_AXES], const hal_scales *scales);

/* Renews the complement of the scales. Call after an intended change of them. */
void guarded_sets_take_scales(guarded_sets *sets);

/* Renews the complement of what was changed intentionally, and compares the next slice. Call each ms. Cost: about 170
 * instructions. */
void guarded_sets_step(guarded_sets *sets);

/* Returns whether a value that this axis uses has changed by itself. */
bool guarded_sets_damaged(const guarded_sets *sets, int axis);

#endif
