/* SPDX-License-Identifier: Apache-2.0 */
#include "node/guarded_sets.h"

enum { BUILT, ACTIVE, LIMITS, BLOCKS_PER_AXIS };

#define BYTES_PER_MS ((size_t)4 * GUARDED_SETS_WORDS_PER_MS)
#define MS_OF(bytes_) (((bytes_) + BYTES_PER_MS - 1u) / BYTES_PER_MS)

_Static_assert(sizeof(servo_axis_params) % 4 == 0 && sizeof(axis_parameters) % 4 == 0 &&
                   sizeof(protection_limits) % 4 == 0 && sizeof(hal_scales) % 4 == 0,
               "whole words are compared");
_Static_assert((size_t)SERVO_AXES *(MS_OF(sizeof(servo_axis_params)) + MS_OF(sizeof(axis_parameters)) +
                                    MS_OF(sizeof(protection_limits))) +
                       MS_OF(sizeof(hal_scales)) <=
                   GUARDED_SETS_CYCLE_MS,
               "the cycle is longer than stated");

static int block_of(int axis, int which) { return axis * BLOCKS_PER_AXIS + which; }

static void seal(guarded_sets *sets, int block) {
  guarded_copy_seal(&sets->copy, block);
  sets->damaged &= ~(1u << (unsigned)block);
}

bool guarded_sets_start(guarded_sets *sets, const guarded_axis axes[SERVO_AXES], const hal_scales *scales) {
  *sets = (guarded_sets){.damaged = 0};
  for (int i = 0; i < SERVO_AXES; ++i) {
    const guarded_axis *axis = &axes[i];
    sets->axis[i] = *axis;
    sets->tuned[i] = axis->tuning->changes;
    sets->limited[i] = axis->objects->changes;
    (void)guarded_copy_add(&sets->copy, axis->built, sizeof *axis->built);
    (void)guarded_copy_add(&sets->copy, &axis->tuning->active, sizeof axis->tuning->active);
    (void)guarded_copy_add(&sets->copy, axis->limits, sizeof *axis->limits);
  }
  sets->scales = guarded_copy_add(&sets->copy, scales, sizeof *scales);
  return sets->scales != GUARDED_NONE;
}

void guarded_sets_take_scales(guarded_sets *sets) {
  if (sets->copy.block_count > 0) {
    seal(sets, sets->scales);
  }
}

void guarded_sets_step(guarded_sets *sets) {
  for (int i = 0; i < SERVO_AXES && sets->copy.block_count > 0; ++i) {
    const guarded_axis *axis = &sets->axis[i];
    if (sets->tuned[i] != axis->tuning->changes) {
      sets->tuned[i] = axis->tuning->changes;
      seal(sets, block_of(i, BUILT));
      seal(sets, block_of(i, ACTIVE));
    }
    if (sets->limited[i] != axis->objects->changes) {
      sets->limited[i] = axis->objects->changes;
      seal(sets, block_of(i, LIMITS));
    }
  }
  const int found = guarded_copy_step(&sets->copy, GUARDED_SETS_WORDS_PER_MS);
  sets->damaged |= found == GUARDED_NONE ? 0u : 1u << (unsigned)found;
}

bool guarded_sets_damaged(const guarded_sets *sets, int axis) {
  const uint32_t own = ((1u << BLOCKS_PER_AXIS) - 1u) << (unsigned)block_of(axis, 0);
  const uint32_t shared = 1u << (unsigned)block_of(SERVO_AXES, 0);
  return (sets->damaged & (own | shared)) != 0;
}
