/* SPDX-License-Identifier: Apache-2.0 */
/* Instructions that the emulated core has executed, to the last one.
 *
 * With QEMU's `-icount shift=10` each instruction takes 2^10 ns, in which the SysTick counter of this machine's 25 MHz
 * counts 25.6 times. It wraps after 655,000 instructions, more than any difference taken here. */
#ifndef TRACKSERVO_TESTS_CORTEX_M4_INSTRUCTION_COUNT_H
#define TRACKSERVO_TESTS_CORTEX_M4_INSTRUCTION_COUNT_H

#include <stdbool.h>
#include <stdint.h>

/* Call it once, before everything else. Returns false when a thousand instructions are not counted as a thousand:
 * -icount is
 * missing. */
bool instruction_count_start(void);

/* A time stamp for instruction_count_since(). */
uint32_t instruction_count_now(void);

/* Instructions between the two calls: 0 when there are none. */
int instruction_count_since(uint32_t start);

#endif
