/* SPDX-License-Identifier: Apache-2.0 */
/* Safe torque off (STO), as far as the program is concerned: it diagnoses and reports. The torque is removed without
 * it:
 *
 *     channel A   gates the enable of both gate drivers, and the coils of both brakes, outside the chip
 *     channel B   second break input of both timers
 *
 * Each tick reads both channels and what the drivers' enables are behind the gate. Both channels high: torque is
 * permitted. A channel that is low for two ticks is STO: a test pulse of up to 1 ms is not (the input circuits suppress
 * it in front of the break input, docs/board.md). Channels that differ for longer than 100 ms, or an enable that
 * contradicts its command for 3 ticks, are a fault. It ends when both channels have been low together and both are high
 * again. */
#ifndef TRACKSERVO_STM32G4_SAFE_TORQUE_H
#define TRACKSERVO_STM32G4_SAFE_TORQUE_H

#include <stdbool.h>
#include <stdint.h>

#include "hal.h"

typedef enum { SAFE_TORQUE_ON = 0, SAFE_TORQUE_OFF, SAFE_TORQUE_FAULT } safe_torque_state;

typedef struct {
  bool channel_a; /* permits torque */
  bool channel_b;
  bool enable[HAL_AXES];    /* of the drivers, behind the gate of channel A */
  bool commanded[HAL_AXES]; /* the program enables the driver */
} safe_torque_inputs;

typedef struct {
  uint32_t off_ticks;    /* a channel has been low */
  uint32_t differ_ticks; /* the channels have differed */
  uint32_t wrong_ticks;  /* an enable has contradicted its command */
  bool faulty;           /* until both channels have been low */
  bool both_were_low;    /* since the fault */
} safe_torque;

/* Computes one tick. Call once per tick. */
safe_torque_state safe_torque_step(safe_torque *torque, const safe_torque_inputs *in);

#endif
