/* SPDX-License-Identifier: Apache-2.0 */
/* What the probes share: a log of words that the test reads, and the core's registers. */
#ifndef TRACKSERVO_TARGET_PROBES_PROBE_H
#define TRACKSERVO_TARGET_PROBES_PROBE_H

#include <stdint.h>

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define NVIC_ISER0 REGISTER(0xE000E100u)
#define NVIC_ISPR0 REGISTER(0xE000E200u)
#define NVIC_IPR(n) (*(volatile uint8_t *)(0xE000E400u + (n)))
#define SCB_ICSR REGISTER(0xE000ED04u)
#define SCB_SHCSR REGISTER(0xE000ED24u)
#define SCB_CFSR REGISTER(0xE000ED28u)
#define SCB_HFSR REGISTER(0xE000ED2Cu)
#define SCB_MMFAR REGISTER(0xE000ED34u)
#define SCB_BFAR REGISTER(0xE000ED38u)
#define SCB_CPACR REGISTER(0xE000ED88u)
#define MPU_CTRL REGISTER(0xE000ED94u)
#define MPU_RBAR REGISTER(0xE000ED9Cu)
#define MPU_RASR REGISTER(0xE000EDA0u)
#define SCB_SHPR(n) (*(volatile uint8_t *)(0xE000ED14u + (n))) /* n: exception, 4 .. 15 */

enum { LOG_LENGTH = 64 };
__attribute__((section(".log"), used)) static volatile struct {
  uint32_t count;
  uint32_t word[LOG_LENGTH];
} probe_log;

static inline void note(uint32_t word) {
  if (probe_log.count < LOG_LENGTH) {
    probe_log.word[probe_log.count] = word;
  }
  probe_log.count = probe_log.count + 1;
}

static inline uint32_t ipsr(void) {
  uint32_t value;
  __asm volatile("mrs %0, ipsr" : "=r"(value));
  return value;
}

static inline void end_of_probe(void) {
  note(0xE0Du);
  for (;;) {
    __asm volatile("wfi");
  }
}

/* The first 32 vectors: a vector that a probe does not define ends it with the exception's number. */
void start(void);
void nmi(void);
void hard_fault(void);
void mem_manage(void);
void bus_fault(void);
void usage_fault(void);
void svcall(void);
void pend_sv(void);
void systick(void);
void irq0(void);
void irq1(void);
void irq2(void);
void irq3(void);

void unexpected(void); /* every handler that the probe does not have: see probe.ld */
void unexpected(void) {
  note(0xBAD00000u | ipsr());
  end_of_probe();
}

__attribute__((section(".vectors"), used)) static const void *const vectors[32] = {
    (void *)0x20000F00u,
    (void *)start,
    (void *)nmi,
    (void *)hard_fault,
    (void *)mem_manage,
    (void *)bus_fault,
    (void *)usage_fault,
    0,
    0,
    0,
    0,
    (void *)svcall,
    0,
    0,
    (void *)pend_sv,
    (void *)systick,
    (void *)irq0,
    (void *)irq1,
    (void *)irq2,
    (void *)irq3,
};

#endif
