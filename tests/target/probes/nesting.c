/* SPDX-License-Identifier: Apache-2.0 */
/* Three interrupts of rising priority: each pends the next one and is preempted by it; then tail-chaining by equal
 * priority, and the masks. */
#include "probe.h"

void irq0(void) {
  note(0x10);
  NVIC_ISPR0 = 2;
  __asm volatile("dsb\n isb");
  note(0x1F);
}

void irq1(void) {
  note(0x20);
  NVIC_ISPR0 = 4;
  NVIC_ISPR0 = 8; /* same priority as this one: waits */
  __asm volatile("dsb\n isb");
  note(0x2F);
}

void irq2(void) { note(0x30 | (ipsr() == 18)); }

void irq3(void) { note(0x40); }

void start(void) {
  probe_log.count = 0;
  NVIC_IPR(0) = 0x30;
  NVIC_IPR(1) = 0x20;
  NVIC_IPR(2) = 0x10;
  NVIC_IPR(3) = 0x20;
  NVIC_ISER0 = 0xF;
  NVIC_ISPR0 = 1;
  __asm volatile("isb");
  note(0x01);
  __asm volatile("cpsid i");
  NVIC_ISPR0 = 8;
  __asm volatile("isb");
  note(0x02);
  __asm volatile("cpsie i\n isb");
  note(0x03);
  __asm volatile("msr basepri, %0\n isb" ::"r"(0x20));
  NVIC_ISPR0 = 8; /* masked: 0x20 is not below 0x20 */
  __asm volatile("isb");
  note(0x04);
  NVIC_ISPR0 = 4;
  __asm volatile("isb");
  note(0x05);
  __asm volatile("msr basepri, %0\n isb" ::"r"(0));
  note(0x06);
  end_of_probe();
}
