/* SPDX-License-Identifier: Apache-2.0 */
#include "current_sense.h"

#include "clock.h"
#include "connections.h"
#include "registers/adc.h"

enum { COUNTS = 4096, REGULATOR_START_US = 20, MAX_WAIT_US = 1000 };

static bool wait_for(const volatile uint32_t *word, uint32_t mask, uint32_t wanted) {
  const uint32_t start = clock_cycles();
  /* Bound: MAX_WAIT_US, by the if in it. */
  while ((*word & mask) != wanted) {
    if (clock_cycles() - start > MAX_WAIT_US * CLOCK_CYCLES_PER_US) {
      return false;
    }
  }
  return true;
}

/* Bits of CR that act when set are written alone: the others read back as set. */
static bool calibrate(adc1_registers *adc) {
  adc->cr = 0; /* out of deep power-down */
  adc->cr = ADC1_CR_ADVREGEN;
  clock_wait_us(REGULATOR_START_US);
  adc->cr = ADC1_CR_ADVREGEN | ADC1_CR_ADCAL;
  return wait_for(&adc->cr, ADC1_CR_ADCAL, 0);
}

static bool enable(adc1_registers *adc) {
  adc->isr = ADC1_ISR_ADRDY;
  adc->cr = ADC1_CR_ADVREGEN | ADC1_CR_ADEN;
  return wait_for(&adc->isr, ADC1_ISR_ADRDY, ADC1_ISR_ADRDY);
}

/* Three bits for each of the inputs 0 to 9. */
static uint32_t sample_time(uint32_t input) { return ADC1_SMP_12_5_CYCLES << (3u * input); }

/* Rank 1 is the current, so that it is sampled at the trigger. */
static bool start_adc(adc1_registers *adc, const adc_connection *inputs) {
  if (!calibrate(adc)) {
    return false;
  }
  clock_wait_us(1); /* four ADC clocks between calibration and enabling */
  if (!enable(adc)) {
    return false;
  }
  adc->cfgr = ADC1_CFGR_JQDIS;
  adc->smpr1 = sample_time(inputs->current_input) | sample_time(inputs->second_input);
  adc->jsqr = FIELD_VALUE(ADC1_JSQR_JL, ADC1_JL_2_CONVERSIONS) |
              FIELD_VALUE(ADC1_JSQR_JEXTSEL, ADC1_JEXTSEL_TIM1_TRGO2) |
              FIELD_VALUE(ADC1_JSQR_JEXTEN, ADC1_JEXTEN_RISING) | FIELD_VALUE(ADC1_JSQR_JSQ1, inputs->current_input) |
              FIELD_VALUE(ADC1_JSQR_JSQ2, inputs->second_input);
  adc->cr = ADC1_CR_ADVREGEN | ADC1_CR_JADSTART;
  return true;
}

/* ADC clock 42.5 MHz; 12.5 cycles of sampling and 12.5 of conversion, twice: 1.2 us. */
bool current_sense_start(void) {
  ADC12_COMMON->ccr = FIELD_VALUE(ADC12_COMMON_CCR_CKMODE, ADC12_CKMODE_HCLK_4);
  return start_adc(ADC1, &board_adcs[0]) && start_adc(ADC2, &board_adcs[1]);
}

bool current_sense_wait(void) {
  const uint32_t max_wait_us = 200;
  const uint32_t start = clock_cycles();
  current_sense_acknowledge();
  /* Bound: 200 us, by the if in it. */
  while ((ADC1->isr & ADC2->isr & ADC1_ISR_JEOS) == 0) {
    if (clock_cycles() - start > max_wait_us * CLOCK_CYCLES_PER_US) {
      return false;
    }
  }
  current_sense_acknowledge();
  return true;
}

void current_sense_enable_interrupt(void) { ADC1->ier = ADC1_IER_JEOSIE; }

void current_sense_acknowledge(void) {
  ADC1->isr = ADC1_ISR_JEOS;
  ADC2->isr = ADC1_ISR_JEOS;
}

current_sense_sample current_sense_read(void) {
  return (current_sense_sample){
      .current_counts = {ADC1->jdr1, ADC2->jdr1}, .bus_counts = ADC1->jdr2, .heat_sink_counts = ADC2->jdr2};
}

/* The threshold counts from the middle of the range: the offset of a good sensor is small compared to it. */
current_sense_scales current_sense_scales_of(const hal_scales *scales) {
  const uint32_t max_counts = CURRENT_NOMINAL_OFFSET - CURRENT_RANGE_MARGIN;
  current_sense_scales of = {.volts_per_count = scales->voltage_full_scale_v * (1.0f / (float)COUNTS)};
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    of.amperes_per_count[axis] = scales->current_full_scale_a[axis] * (1.0f / (float)CURRENT_NOMINAL_OFFSET);
    const float limit_counts = scales->over_current_a[axis] / of.amperes_per_count[axis];
    const uint32_t counts = limit_counts < (float)max_counts ? (uint32_t)limit_counts : max_counts;
    of.lowest_counts[axis] = CURRENT_NOMINAL_OFFSET - counts;
    of.highest_counts[axis] = CURRENT_NOMINAL_OFFSET - 1 + counts;
  }
  return of;
}
