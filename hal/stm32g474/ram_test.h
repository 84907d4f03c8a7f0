/* March C- over RAM that nothing uses yet: finds stuck bits, cells that do not change, coupled words and wrong
 * addresses. Source: A. J. van de Goor, Using March Tests to Test SRAMs, IEEE Design & Test of Computers 10 (1993).
 *
 *     up (w0); up (r0, w1); up (r1, w0); down (r0, w1); down (r1, w0); up (r0)
 *
 * It goes by words, 0 is a word of zeros and 1 one of ones: bits of the same word that disturb each other can hide. */
#ifndef TRACKSERVO_STM32G474_RAM_TEST_H
#define TRACKSERVO_STM32G474_RAM_TEST_H

#include <stdbool.h>

/* Before variables are initialised: all of the RAM but .noinit and the top of the stack, which is in use. 85 ms at the
 * 16 MHz after a reset. Leaves zeros. */
void ram_test_run(void);

/* Whether it has run and found nothing. */
bool ram_test_passed(void);

#endif
