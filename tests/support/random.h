/* SPDX-License-Identifier: Apache-2.0 */
/* Seeded random numbers (splitmix64), the same on every machine: a failing seed can be run again. */
#ifndef TRACKSERVO_TESTS_SUPPORT_RANDOM_H
#define TRACKSERVO_TESTS_SUPPORT_RANDOM_H

#include <math.h>
#include <stdint.h>

#include "support/test_size.h"

/* Returns how many of `count` cases are tried: one in 25 in the small size. */
static inline int random_cases(int count) { return by_size(count / 25, count, count); }

typedef struct {
  uint64_t state;
} random_source;

static inline uint64_t random_bits(random_source *source) {
  source->state += 0x9E3779B97F4A7C15u;
  uint64_t x = source->state;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

static inline double random_uniform(random_source *source, double low, double high) {
  return low + (high - low) * (double)(random_bits(source) >> 11) / 9007199254740992.0;
}

/* Each decade equally likely; 0 < low < high. */
static inline double random_decades(random_source *source, double low, double high) {
  return exp(random_uniform(source, log(low), log(high)));
}

/* Mean 0, standard deviation 1 (Box-Muller). */
static inline double random_normal(random_source *source) {
  const double radius = sqrt(-2.0 * log(random_uniform(source, 1e-300, 1.0)));
  return radius * cos(6.283185307179586 * random_uniform(source, 0.0, 1.0));
}

#endif
