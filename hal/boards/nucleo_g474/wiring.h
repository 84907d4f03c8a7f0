/* SPDX-License-Identifier: Apache-2.0 */
/* What this board has; the drivers of the chip size their tables by it. wiring.c has the tables. */
#ifndef TRACKSERVO_NUCLEO_G474_WIRING_H
#define TRACKSERVO_NUCLEO_G474_WIRING_H

/* Azimuth and pitch. */
enum { BOARD_AXES = 2 };

#endif
