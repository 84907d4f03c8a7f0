/* SPDX-License-Identifier: Apache-2.0 */
#include "sensors/thermistor.h"

#define COLDEST_CELSIUS (-20.0f)
#define STEP_CELSIUS 10.0f

enum { POINTS = 15 };

/* Counts at -20, -10 .. 120 degree Celsius. */
static const int counts_at[POINTS] = {3628, 3368, 3038, 2654, 2249, 1854, 1497, 1191,
                                      941,  741,  584,  462,  368,  295,  238};

float thermistor_celsius(int counts) {
  if (counts >= counts_at[0]) {
    return COLDEST_CELSIUS;
  }
  int hotter = 1;
  /* Bound: POINTS of the table: each round goes one on. */
  while (hotter < POINTS - 1 && counts < counts_at[hotter]) {
    ++hotter;
  }
  const float rest = counts < counts_at[hotter]
                         ? 0.0f
                         : (float)(counts - counts_at[hotter]) / (float)(counts_at[hotter - 1] - counts_at[hotter]);
  return COLDEST_CELSIUS + STEP_CELSIUS * ((float)hotter - rest);
}
