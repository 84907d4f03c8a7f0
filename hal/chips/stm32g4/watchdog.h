/* SPDX-License-Identifier: Apache-2.0 */
/* The independent watchdog: 20 ms, on the chip's own 32 kHz oscillator; a refresh within the first 5 ms also resets. */
#ifndef TRACKSERVO_STM32G4_WATCHDOG_H
#define TRACKSERVO_STM32G4_WATCHDOG_H

#include <stdbool.h>

/* Starts the watchdog, which cannot be stopped again. Returns false when its registers were not updated in time; it
 * then runs with a longer time. */
bool watchdog_start(void);

void watchdog_refresh(void);

#endif
