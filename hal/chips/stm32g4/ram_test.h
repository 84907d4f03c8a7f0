/* SPDX-License-Identifier: Apache-2.0 */
/* March C- over unused RAM: finds stuck bits, cells that do not change, coupled words and wrong addresses. Source: A.
 * J. van de Goor, Using March Tests to Test SRAMs, IEEE Design & Test of Computers 10 (1993).
 *
 *     up (w0); up (r0, w1); up (r1, w0); down (r0, w1); down (r1, w0); up (r0)
 *
 * It works on words; 0 is a word of zeros and 1 one of ones. Coupling between bits of the same word can stay
 * undetected. */
#ifndef TRACKSERVO_STM32G4_RAM_TEST_H
#define TRACKSERVO_STM32G4_RAM_TEST_H

#include <stdbool.h>

/* Top of the stack: used by the reset handler and this test itself, and not tested. */
enum { RAM_TEST_STACK_BYTES = 256 };

/* Run it before variables are initialised: it covers all of the RAM, CCM SRAM included, except .noinit and the top of
 * the stack. 113 ms at the 16 MHz after a reset. Leaves zeros. Writes each word before it reads it. */
void ram_test_run(void);

/* Returns whether it has run without an error. */
bool ram_test_passed(void);

#endif
