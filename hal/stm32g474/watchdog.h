/* The independent watchdog: 20 ms, on the chip's own 32 kHz oscillator; a refresh within the first 5 ms resets, too. */
#ifndef TRACKSERVO_STM32G474_WATCHDOG_H
#define TRACKSERVO_STM32G474_WATCHDOG_H

#include <stdbool.h>

/* Cannot be stopped again. False: its registers were not taken in time; it runs with a longer time then. */
bool watchdog_start(void);

void watchdog_refresh(void);

#endif
