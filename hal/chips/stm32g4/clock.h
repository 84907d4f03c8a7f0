/* SPDX-License-Identifier: Apache-2.0 */
/* System clock: 170 MHz from the 24 MHz crystal; HCLK, PCLK1 and PCLK2 alike. */
#ifndef TRACKSERVO_STM32G4_CLOCK_H
#define TRACKSERVO_STM32G4_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

#define CLOCK_HZ 170000000u
#define CLOCK_CYCLES_PER_US 170u

/* Starts the clock. Returns false when crystal or PLL did not start; the chip then runs on its 16 MHz oscillator. If
 * the crystal fails later, the clock security system raises an NMI, which is a fault. Takes about 2 ms. */
bool clock_start(void);

/* Enables the clocks of all peripherals that are used. */
void clock_enable_peripherals(void);

/* Starts the counter of processor cycles, which wraps after 25 s. */
void clock_start_cycle_counter(void);
uint32_t clock_cycles(void);

/* Waits at least this long; 0 .. 10 s. */
void clock_wait_us(uint32_t us);

#endif
