/* How many instructions a part took, each time that it ran: the median, the most, and what is asked. */
#ifndef TRACKSERVO_TESTS_CORTEX_M4_COST_TABLE_H
#define TRACKSERVO_TESTS_CORTEX_M4_COST_TABLE_H

#include <stdbool.h>
#include <stdint.h>

enum { COST_BINS = 16384 };

typedef struct {
  const char *name;
  int asked;                /* at most; 0: nothing is asked */
  int bound;                /* more than this is a step back; 0: what is asked */
  uint32_t runs[COST_BINS]; /* by instructions; the last counts what is beyond, too */
  uint32_t count;
  int worst;
} cost_row;

void cost_row_add(cost_row *row, int instructions);

void cost_table_head(void);

/* False when it never ran, or the worst is beyond its bound. */
bool cost_row_print(const cost_row *row);

#endif
