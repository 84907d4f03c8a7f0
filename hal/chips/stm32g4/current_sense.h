/* SPDX-License-Identifier: Apache-2.0 */
/* Motor currents, bus voltage and heat-sink temperature: ADC1 and ADC2, two injected conversions each. TIM1 starts them
 * at the beginning of every PWM period; they take 1.2 us.
 *
 *     current = (counts - offset) * full scale / 2048      bus voltage = counts * full scale / 4096
 *
 * Full scales are the board's (object 0x3060): its shunts, amplifiers and dividers. */
#ifndef TRACKSERVO_STM32G4_CURRENT_SENSE_H
#define TRACKSERVO_STM32G4_CURRENT_SENSE_H

#include <stdbool.h>
#include <stdint.h>

#include "hal.h"

enum { CURRENT_NOMINAL_OFFSET = 2048, CURRENT_MAX_OFFSET_ERROR = 100, CURRENT_RANGE_MARGIN = 32 };

typedef struct {
  uint32_t current_counts[HAL_AXES]; /* azimuth, pitch; 0 .. 4095 */
  uint32_t bus_counts;
  uint32_t heat_sink_counts;
} current_sense_sample;

/* Calibrates and enables the ADCs and arms the trigger. Returns false when an ADC does not answer. Takes about 0.2 ms.
 * */
bool current_sense_start(void);

/* Waits for the end of the next sequences, at most 200 us. Returns false when they did not come. Call it before the
 * interrupt is
 * enabled. */
bool current_sense_wait(void);

/* Enables the interrupt at the end of the sequences. */
void current_sense_enable_interrupt(void);

void current_sense_acknowledge(void);

current_sense_sample current_sense_read(void);

/* hal_scales in the form that the interrupt needs. */
typedef struct {
  float amperes_per_count[HAL_AXES];
  uint32_t lowest_counts[HAL_AXES]; /* maximum current of the bridge */
  uint32_t highest_counts[HAL_AXES];
  float volts_per_count;
} current_sense_scales;

current_sense_scales current_sense_scales_of(const hal_scales *scales);

/* Returns whether these counts mean more current than allowed or measurable, or a broken wire. */
static inline bool current_sense_is_over(const current_sense_scales *scales, int axis, uint32_t counts) {
  return counts < scales->lowest_counts[axis] || counts > scales->highest_counts[axis];
}

#endif
