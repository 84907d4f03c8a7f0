/* SPDX-License-Identifier: Apache-2.0 */
/* Why the chip restarted. */
#ifndef TRACKSERVO_STM32G4_RESET_CAUSE_H
#define TRACKSERVO_STM32G4_RESET_CAUSE_H

#include "hal_board.h"

/* Reads the flags of the reset and the record of a fault before it, and clears both: once per start. */
hal_reset reset_cause_take(void);

#endif
