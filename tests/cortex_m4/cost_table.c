/* SPDX-License-Identifier: Apache-2.0 */
#include "cortex_m4/cost_table.h"

#include <stdio.h>

void cost_row_add(cost_row *row, int instructions) {
  const int bin = instructions < 0 ? 0 : instructions < COST_BINS ? instructions : COST_BINS - 1;
  ++row->runs[bin];
  ++row->count;
  row->worst = instructions > row->worst ? instructions : row->worst;
}

static int median(const cost_row *row) {
  uint32_t seen = 0;
  for (int bin = 0; bin < COST_BINS; ++bin) {
    seen += row->runs[bin];
    if (2 * seen >= row->count) {
      return bin;
    }
  }
  return COST_BINS;
}

void cost_table_head(void) { printf("%-44s %8s %8s %8s %9s\n", "instructions", "typical", "worst", "limit", "runs"); }

bool cost_row_print(const cost_row *row) {
  char limit[12] = "";
  if (row->limit != 0) {
    (void)snprintf(limit, sizeof limit, "%d", row->limit);
  }
  printf("%-44s %8d %8d %8s %9lu\n", row->name, median(row), row->worst, limit, (unsigned long)row->count);
  const int bound = row->bound != 0 ? row->bound : row->limit;
  if (row->worst > bound) {
    printf("%s: more than %d\n", row->name, bound);
  }
  return row->count != 0 && row->worst <= bound;
}
