/* SPDX-License-Identifier: Apache-2.0 */
/* The system clock, which comes from the crystal, against the chip's other oscillator HSI16, in operation.
 *
 * MCO gives HSI16 / 16 to an input of TIM16 inside the chip; TIM16 captures every eighth edge, so 1360 counts of the
 * system clock lie between two captures. HSI16 is right to 1 % while the chip has 0 to 85 degrees, and to 2 % from -40
 * degrees on (data sheet DS12288). A difference above 1.84 % is an error of one of the two: an error of the system
 * clock of 3 % is always found above 0 degrees, and no right clock is refused above about -30 degrees. */
#ifndef TRACKSERVO_STM32G4_CLOCK_CHECK_H
#define TRACKSERVO_STM32G4_CLOCK_CHECK_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
  uint32_t wrong;  /* consecutive measurements beyond the limit */
  uint32_t missed; /* consecutive measurements that interrupts have spoilt, or that never came */
  bool failed;
} clock_check;

void clock_check_start(void);

/* Measures the clock. Call from the background, every 100 ms; takes 25 us and the interrupts of that time. `failed`
 * becomes true after 3 wrong measurements, or 50 spoilt ones, until one is right. */
void clock_check_step(clock_check *check);

#endif
