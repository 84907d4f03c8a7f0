/* SPDX-License-Identifier: Apache-2.0 */
/* An interrupt that uses the FPU between two instructions that do: nothing of the interrupted context may change. */
#include "probe.h"

static volatile float scratch;

void irq0(void) {
  scratch = scratch * 3.0f + 1.0f;
  __asm volatile(
      "vmov.f32 s0, #2.0\n vmov.f32 s1, #2.0\n vmov.f32 s2, #2.0\n vmov.f32 s15, #2.0\n vmrs r0, fpscr\n"
      "orr r0, #0xF0000000\n vmsr fpscr, r0" ::
          : "r0", "s0", "s1", "s2", "s15");
  uint32_t return_code;
  __asm volatile("mov %0, lr" : "=r"(return_code));
}

void irq1(void) { note(0x11); }

void start(void) {
  probe_log.count = 0;
  SCB_CPACR = 0xF00000;
  __asm volatile("dsb\n isb");
  NVIC_ISER0 = 3;
  NVIC_ISPR0 = 2; /* before the FPU was ever used: a short frame */
  __asm volatile("isb");
  uint32_t sum = 0;
  uint32_t flags = 0;
  __asm volatile(
      "vmov.f32 s0, #1.0\n vmov.f32 s15, #8.0\n vcmp.f32 s0, s15\n"
      "str %3, [%2]\n dsb\n isb\n"
      "vadd.f32 s0, s0, s15\n vcvt.s32.f32 s0, s0\n vmov %0, s0\n vmrs %1, fpscr\n"
      : "=&r"(sum), "=&r"(flags)
      : "r"(0xE000E200u), "r"(1u)
      : "s0", "s15", "memory");
  note(sum);         /* 9 */
  note(flags >> 28); /* 8: less than */
  end_of_probe();
}
