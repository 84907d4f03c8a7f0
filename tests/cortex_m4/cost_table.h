/* SPDX-License-Identifier: Apache-2.0 */
/* Instructions of each run of a part: the median, the maximum, and the limit. */
#ifndef TRACKSERVO_TESTS_CORTEX_M4_COST_TABLE_H
#define TRACKSERVO_TESTS_CORTEX_M4_COST_TABLE_H

#include <stdbool.h>
#include <stdint.h>

enum { COST_BINS = 16384 };

typedef struct {
  const char *name;
  int limit;                /* 0: none */
  int bound;                /* a higher count is a regression; 0: same as the limit */
  uint32_t runs[COST_BINS]; /* by instructions; the last one also counts everything beyond */
  uint32_t count;
  int worst;
} cost_row;

void cost_row_add(cost_row *row, int instructions);

void cost_table_head(void);

/* False when it never ran, or the worst is beyond its bound. */
bool cost_row_print(const cost_row *row);

#endif
