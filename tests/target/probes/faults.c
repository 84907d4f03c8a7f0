/* SPDX-License-Identifier: Apache-2.0 */
/* A bus fault with its own handler, an undefined instruction without one, and the state after each. */
#include "probe.h"

static void skip(uint32_t *frame, uint32_t bytes) { frame[6] += bytes; }

__attribute__((used)) static void bus_fault_with(uint32_t *frame) {
  note(0xB0);
  note(SCB_CFSR);
  note(SCB_BFAR);
  SCB_CFSR = 0xFFFFFFFFu;
  skip(frame, 2);
}

__attribute__((used)) static void hard_fault_with(uint32_t *frame) {
  note(0xF0);
  note(SCB_CFSR);
  note(SCB_HFSR);
  if (SCB_CFSR != 0) { /* an SVC would return after itself */
    skip(frame, 2);
  }
  SCB_CFSR = 0xFFFFFFFFu;
  SCB_HFSR = 0xFFFFFFFFu;
}

__attribute__((used)) static void svcall_with(uint32_t *frame) {
  note(0x50);
  note(((const uint8_t *)frame[6])[-2]); /* the SVC's number */
}

__attribute__((naked)) void bus_fault(void) { __asm volatile("mov r0, sp\n b bus_fault_with"); }
__attribute__((naked)) void hard_fault(void) { __asm volatile("mov r0, sp\n b hard_fault_with"); }
__attribute__((naked)) void svcall(void) { __asm volatile("mov r0, sp\n b svcall_with"); }

void irq0(void) { __asm volatile("svc 9"); } /* of a lower priority than this: escalates */

void start(void) {
  probe_log.count = 0;
  __asm volatile("svc 7");
  SCB_SHCSR = 1u << 17;
  __asm volatile("ldr r1, [%0]" ::"r"(0x30000000u) : "r1"); /* nothing there: two bytes of code */
  __asm volatile("udf 1");                                  /* UsageFault is not enabled: escalates */
  SCB_SHPR(11) = 0xF0;
  NVIC_IPR(0) = 0x40;
  NVIC_ISER0 = 1;
  NVIC_ISPR0 = 1;
  __asm volatile("isb");
  note(0x99);
  end_of_probe();
}
