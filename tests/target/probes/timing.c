/* SPDX-License-Identifier: Apache-2.0 */
/* SysTick every 1,000 cycles from sleep, and the cost of known loops on the cycle counter. */
#include "probe.h"

#define DWT_CTRL REGISTER(0xE0001000u)
#define DWT_CYCCNT REGISTER(0xE0001004u)
#define DEMCR REGISTER(0xE000EDFCu)

static volatile uint32_t ticks;

void systick(void) { ticks = ticks + 1; }

__attribute__((noinline)) static uint32_t cycles_of_hundred_loops(void) {
  const uint32_t begin = DWT_CYCCNT;
  uint32_t n = 100;
  __asm volatile("1: subs %0, #1\n nop\n bne 1b" : "+r"(n));
  return DWT_CYCCNT - begin;
}

void start(void) {
  probe_log.count = 0;
  ticks = 0;
  DEMCR = 1u << 24;
  DWT_CTRL = DWT_CTRL | 1u;
  (void)cycles_of_hundred_loops();
  note(cycles_of_hundred_loops());
  REGISTER(0xE000E014u) = 999;
  REGISTER(0xE000E018u) = 0;
  REGISTER(0xE000E010u) = 7;
  const uint32_t begin = DWT_CYCCNT;
  while (ticks < 10) {
    __asm volatile("wfi");
  }
  note(DWT_CYCCNT - begin);
  REGISTER(0xE000E010u) = 0;
  end_of_probe();
}
