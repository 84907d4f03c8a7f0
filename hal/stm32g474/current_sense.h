/* Motor currents, bus voltage and heat-sink temperature: ADC1 and ADC2, two injected conversions each, started by TIM1
 * at the beginning of every PWM period and done 1.2 us later.
 *
 *     current = (counts - offset) * 50 A / 4096      bus voltage = counts * 66 V / 4096 */
#ifndef TRACKSERVO_STM32G474_CURRENT_SENSE_H
#define TRACKSERVO_STM32G474_CURRENT_SENSE_H

#include <stdbool.h>
#include <stdint.h>

enum { CURRENT_NOMINAL_OFFSET = 2048, CURRENT_MOST_OFFSET_ERROR = 100, CURRENT_RANGE_MARGIN = 32 };

typedef struct {
  uint32_t current_counts[2]; /* azimuth, pitch; 0 .. 4095 */
  uint32_t bus_counts;
  uint32_t heat_sink_counts;
} current_sense_sample;

/* Calibrates, enables, arms the trigger. False: an ADC does not answer. Takes about 0.2 ms. */
bool current_sense_start(void);

/* Waits for the end of the next sequences, at most 200 us. False: they did not come. Before the interrupt is enabled.
 */
bool current_sense_wait(void);

/* The end of the sequences interrupts from now on. */
void current_sense_enable_interrupt(void);

void current_sense_acknowledge(void);

current_sense_sample current_sense_read(void);

float current_sense_amperes(uint32_t counts, float offset_counts);
float current_sense_bus_voltage_v(uint32_t counts);

/* The amplifier is at its end: more current than can be measured, or a broken wire. */
bool current_sense_saturated(uint32_t counts);

#endif
