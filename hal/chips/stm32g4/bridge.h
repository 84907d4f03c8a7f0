/* SPDX-License-Identifier: Apache-2.0 */
/* The power bridges: two legs each, complementary with dead time, centre-aligned at 20 kHz, all timers in phase.
 *
 *     leg 1 is high for (1 + duty) / 2 of the period, leg 2 for (1 - duty) / 2
 *
 * A period begins where the timers update, in the middle of the time in which both legs are high. There the ADC samples
 * and new duties take effect. A driver's fault input switches its bridge off by hardware. */
#ifndef TRACKSERVO_STM32G4_BRIDGE_H
#define TRACKSERVO_STM32G4_BRIDGE_H

#include <stdbool.h>
#include <stdint.h>

/* Timer counts of half a period: 170 MHz / (2 * 4250) = 20 kHz. */
enum { BRIDGE_COUNTS = 4250 };

/* Returns the counts for which leg 1 is high, of BRIDGE_COUNTS; leg 2 is high for the rest. duty -1 .. 1; anything
 * else, and NaN, counts as 0. */
static inline uint32_t bridge_first_leg(float duty) {
  const float half = 0.5f * (float)BRIDGE_COUNTS;
  const bool in_range = duty >= -1.0f && duty <= 1.0f; /* a NaN is not */
  return (uint32_t)(half + (in_range ? duty : 0.0f) * half + 0.5f);
}

/* Starts the timers; outputs are off, duties are 0. */
void bridge_start(void);

/* Sets the duty, as for bridge_first_leg, from the next period on. */
void bridge_set_duty(int axis, float duty);

/* Switches the bridge. On: the gates follow the duty, unless the driver's fault is still present. */
void bridge_power(int axis, bool on);

/* Returns whether the driver's fault input, or `bridge_trip`, has switched the bridge off; true until it is switched
 * off by command while the input is good. */
bool bridge_fault(int axis);

/* Switches the bridge off at once, as by a fault. Any interrupt may call it. */
void bridge_trip(int axis);

/* Handles the break interrupt of the axis' timer. Returns whether channel B of STO alone has switched the bridge off.
 * */
bool bridge_break_interrupt(int axis);

#endif
