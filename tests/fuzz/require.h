/* SPDX-License-Identifier: Apache-2.0 */
/* A condition that no fuzzer input may violate. */
#ifndef TRACKSERVO_TESTS_FUZZ_REQUIRE_H
#define TRACKSERVO_TESTS_FUZZ_REQUIRE_H

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "canopen/object_dictionary.h"

/* Harness code, not the fuzzed code: its branches must not count as coverage. */
#define UNCOUNTED __attribute__((no_sanitize("coverage", "address", "undefined")))

static inline void require(bool good) {
  if (!good) {
    abort();
  }
}

/* Every value that the bus can write is within its limits. */
UNCOUNTED static inline void require_values_within_limits(const object_dictionary *dictionary) {
  for (uint32_t i = 0; i < dictionary->count; i++) {
    const od_part *part = &dictionary->parts[i];
    for (uint32_t row = 0; row < part->table.count; row++) {
      const od_object object = {part, &part->table.entries[row]};
      const od_entry *entry = object.entry;
      if (entry->access != OD_RW && entry->access != OD_WO) {
        continue;
      }
      const od_number value = od_get(&object);
      if (entry->type == OD_REAL32) {
        require(isfinite(value.f) && value.f >= entry->low.f && value.f <= entry->high.f);
      } else if (entry->type != OD_VISIBLE_STRING && entry->type != OD_DOMAIN && entry->type != OD_UNSIGNED64) {
        require(value.i >= entry->low.i && value.i <= entry->high.i);
      }
    }
  }
}

/* Object n of the dictionary, counted over all its parts and modulo their number. */
UNCOUNTED static inline od_object nth_object(const object_dictionary *dictionary, uint32_t n) {
  uint32_t total = 0;
  for (uint32_t i = 0; i < dictionary->count; i++) {
    total += dictionary->parts[i].table.count;
  }
  uint32_t left = n % total;
  uint32_t part = 0;
  while (left >= dictionary->parts[part].table.count) {
    left -= dictionary->parts[part].table.count;
    part++;
  }
  return (od_object){&dictionary->parts[part], &dictionary->parts[part].table.entries[left]};
}

#endif
