/* SPDX-License-Identifier: Apache-2.0 */
/* A region without access below the RAM: which accesses are refused inside it, below it, and with the MPU off. */
#include "probe.h"

static void report(uint32_t *frame, uint32_t what, uint32_t address) {
  const uint32_t bytes_of_load = 2;
  note(what);
  note(SCB_CFSR);
  note(address);
  SCB_CFSR = 0xFFFFFFFFu;
  frame[6] += bytes_of_load;
}

__attribute__((used)) static void mem_manage_with(uint32_t *frame) { report(frame, 0xA0, SCB_MMFAR); }
__attribute__((used)) static void bus_fault_with(uint32_t *frame) { report(frame, 0xB0, SCB_BFAR); }

__attribute__((naked)) void mem_manage(void) { __asm volatile("mov r0, sp\n b mem_manage_with"); }
__attribute__((naked)) void bus_fault(void) { __asm volatile("mov r0, sp\n b bus_fault_with"); }

static void load(uint32_t address) { __asm volatile("ldr r1, [%0]" ::"l"(address) : "r1", "memory"); }

void start(void) {
  probe_log.count = 0;
  SCB_SHCSR = 3u << 16;
  MPU_RBAR = 0x1FFF8000u;
  MPU_RASR = 14u << 1 | 1u; /* 32 KiB */
  MPU_CTRL = 5;
  __asm volatile("dsb\n isb");
  load(0x1FFFFFF0u);
  load(0x1FFF7FF0u);
  MPU_CTRL = 0;
  __asm volatile("dsb\n isb");
  load(0x1FFFFFF0u);
  end_of_probe();
}
