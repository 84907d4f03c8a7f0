/* SPDX-License-Identifier: Apache-2.0 */
/* The pins of the board, whose pins.c has the function of each in one table; docs/board.md shows it. */
#ifndef TRACKSERVO_STM32G4_PINS_H
#define TRACKSERVO_STM32G4_PINS_H

#include <stdbool.h>

#include "safe_torque.h"

/* Configures all pins of the table. Outputs start low. */
void pins_start(void);

/* Switches the outputs off: the timers of all bridges without main output enable, the drivers' enables low, the brakes
 * without current. Needs no RAM except a little stack, no clock except the one after reset, and no initialisation: a
 * reset and every fault call it first. */
void safe_outputs(void);

void pins_light_led(bool on);

/* Set the coil of a holding brake, and read what the brake's contact reports. */
void pins_release_brake(int axis, bool release);
bool pins_brake_is_released(int axis);

/* Reads both channels of STO and the enables of the drivers. */
safe_torque_inputs pins_read_safe_torque(void);

/* Reads the button that restores node id and bit rate. Call it a few microseconds after pins_start at the earliest. */
bool pins_button_is_held(void);

#endif
