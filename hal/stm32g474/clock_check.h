/* The system clock, which comes from the crystal, against the chip's other oscillator HSI16, in operation.
 *
 * MCO gives HSI16 / 16 to an input of TIM16 inside the chip; TIM16 captures every eighth edge, so 1360 counts of the
 * system clock lie between two captures. HSI16 is right to 1 % from 0 to 85 degrees (data sheet DS12288), so a
 * difference above 2.5 % is an error of one of the two. An error of the system clock is always found from 3.6 % on, and
 * from 1.5 % on where HSI16 is wrong the other way. */
#ifndef TRACKSERVO_STM32G474_CLOCK_CHECK_H
#define TRACKSERVO_STM32G474_CLOCK_CHECK_H

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
