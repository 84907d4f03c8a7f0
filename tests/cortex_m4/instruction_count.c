/* SPDX-License-Identifier: Apache-2.0 */
#include "cortex_m4/instruction_count.h"

#include <stdio.h>

/* ARMv7-M B3.3 */
#define SYST_CSR ((volatile uint32_t *)0xE000E010u)
#define SYST_RVR ((volatile uint32_t *)0xE000E014u)
#define SYST_CVR ((volatile uint32_t *)0xE000E018u)

enum { SYST_MASK = 0xFFFFFF, COUNTS_PER_10_INSTRUCTIONS = 256 };

static int own_cost;

/* Not inlined, so that the code between the two readings besides the measured code is always the same. */
__attribute__((noinline)) uint32_t instruction_count_now(void) { return *SYST_CVR; }

__attribute__((noinline)) int instruction_count_since(uint32_t start) {
  const uint32_t counts = (start - *SYST_CVR) & SYST_MASK; /* it counts down */
  return (int)((10u * counts + COUNTS_PER_10_INSTRUCTIONS / 2) / COUNTS_PER_10_INSTRUCTIONS) - own_cost;
}

bool instruction_count_start(void) {
  *SYST_RVR = SYST_MASK;
  *SYST_CVR = 0;
  *SYST_CSR = 5; /* on, with the core's clock, without an interrupt */
  own_cost = instruction_count_since(instruction_count_now());
  const uint32_t start = instruction_count_now();
  __asm__ volatile(".rept 1000\n nop\n .endr");
  const int counted = instruction_count_since(start);
  if (counted != 1000) {
    printf("1000 instructions are counted as %d: QEMU needs -icount shift=10\n", counted);
    return false;
  }
  return true;
}
