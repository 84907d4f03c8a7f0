/* SPDX-License-Identifier: Apache-2.0 */
/* The parameter pages: the last 20 KiB of bank 2, in pages of 2 KiB: two for node id and bit rate, then two areas of
 * four for the parameter store.
 *
 * Bank 2 is erased and programmed while the program runs from bank 1. An erase takes about 22 ms, a double word about
 * 85 us: for the background only. The caller's `waiting` is called during this time, for the watchdog. */
#ifndef TRACKSERVO_STM32G4_PARAMETER_FLASH_H
#define TRACKSERVO_STM32G4_PARAMETER_FLASH_H

#include "hal_flash.h"

typedef enum { PARAMETER_AREA_0, PARAMETER_AREA_1, BUS_SETTINGS_PIECE, PARAMETER_PIECES } parameter_piece;

/* Returns whether the option bytes give the flash two banks, and start the program from the first: otherwise the
 * numbers of the parameter pages are those of other pages, and nothing is erased or programmed. */
bool parameter_flash_has_its_banks(void);

/* Returns the access to a piece of the flash; `context` is passed to `waiting`. */
hal_flash parameter_flash(parameter_piece piece, void (*waiting)(void *context), void *context);

/* Returns true when the NMI reported two wrong bits in a double word of bank 2; `read` returns false then. */
bool parameter_flash_take_nmi(void);

#endif
