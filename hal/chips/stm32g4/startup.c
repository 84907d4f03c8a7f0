/* SPDX-License-Identifier: Apache-2.0 */
/* From reset to main: outputs off, FPU on, stack guarded, RAM tested, hot code copied, variables initialised for C.
 * Faults: outputs off, the cause recorded, and the watchdog resets. */
#include <stdint.h>

#include "fault_record.h"
#include "hot_code.h"
#include "interrupts.h"
#include "parameter_flash.h"
#include "pins.h"
#include "ram_parity.h"
#include "ram_test.h"
#include "registers/core.h"
#include "registers/iwdg.h"
#include "registers/rcc.h"
#include "stack_guard.h"

/* From the linker script; only their addresses are meaningful. */
extern uint32_t stack_top[];
extern uint32_t stack_limit[];
extern uint32_t stack_guard[];
extern uint32_t data_image[];
extern uint32_t data_start[];
extern uint32_t data_end[];
extern uint32_t bss_start[];
extern uint32_t bss_end[];
extern const uint32_t image_start[];

int main(void);
void reset_handler(void);
void start_image(void);
void fault_handler(void);
void handle_fault(const uint32_t *frame);
void nmi_handler(void);

enum { FULL_ACCESS = 0xF, FRAME_PROGRAM_COUNTER = 6 };
_Static_assert(RAM_TEST_STACK_BYTES == 64 * sizeof(uint32_t), "as the reset handler clears it");

static void initialise_variables(void) {
  const uint32_t *from = data_image;
  /* Bound: the data section, whose size the linker knows. */
  for (uint32_t *to = data_start; (uintptr_t)to < (uintptr_t)data_end; ++to) {
    *to = *from++;
  }
  /* Bound: the bss section, likewise. */
  for (uint32_t *to = bss_start; (uintptr_t)to < (uintptr_t)bss_end; ++to) {
    *to = 0;
  }
}

/* The RAM test cannot clear the part of the stack that it uses; with parity, all of it must have been written. */
__attribute__((naked)) void reset_handler(void) {
  __asm volatile(
      "ldr r0, =stack_top\n"
      "movs r1, #0\n"
      "movs r2, #64\n"
      "1: subs r0, #4\n"
      "str r1, [r0]\n"
      "subs r2, #1\n"
      "bne 1b\n"
      "b start_image\n");
}

void start_image(void) {
  safe_outputs();
  field_set(&SCB->cpacr, SCB_CPACR_CP10_CP11, FULL_ACCESS);
  __asm volatile("dsb\n isb" ::: "memory");
  SCB->vtor = (uint32_t)(uintptr_t)image_start;
  SCB->shcsr |= SCB_SHCSR_MEMFAULTENA | SCB_SHCSR_BUSFAULTENA | SCB_SHCSR_USGFAULTENA;
  SCB->ccr |= SCB_CCR_DIV_0_TRP;
  stack_guard_start((uint32_t)(uintptr_t)stack_guard);
  ram_parity_connect();
  ram_test_run();
  hot_code_load();
  initialise_variables();
  (void)main();
  /* Bound: for ever: main does not return; after a fault the watchdog, which is started before, resets. */
  for (;;) { /* main does not return */
  }
}

/* The stack may be the cause: the handler uses a new one, and receives the address of the old one. */
__attribute__((naked)) void fault_handler(void) {
  __asm volatile(
      "mov r0, sp\n"
      "ldr r1, =stack_top\n"
      "mov sp, r1\n"
      "b handle_fault\n");
}

/* Ends in the reset by the watchdog, which is started here if it does not run yet. */
void handle_fault(const uint32_t *frame) {
  safe_outputs();
  const uintptr_t frame_end = (uintptr_t)(frame + FRAME_PROGRAM_COUNTER + 1);
  const bool readable = (uintptr_t)frame >= (uintptr_t)stack_limit && frame_end <= (uintptr_t)stack_top;
  const fault_record record = {.exception = field_get(SCB->icsr, SCB_ICSR_VECTACTIVE),
                               .program_counter = readable ? frame[FRAME_PROGRAM_COUNTER] : 0,
                               .configurable_fault_status = SCB->cfsr,
                               .hard_fault_status = SCB->hfsr,
                               .parity_error = ram_parity_has_failed() ? 1 : 0};
  fault_record_write(&record);
  IWDG->kr = IWDG_KEY_START;
  /* Bound: for ever: main does not return; after a fault the watchdog, which is started before, resets. */
  for (;;) {
  }
}

/* Parameter memory that lost power while it was written may be unreadable: its reader handles that. Everything else,
 * such as a crystal that stopped, is a fault. */
__attribute__((naked)) void nmi_handler(void) {
  __asm volatile(
      "push {r4, lr}\n"
      "bl parameter_flash_take_nmi\n"
      "cmp r0, #0\n"
      "pop {r4, lr}\n"
      "beq fault_handler\n"
      "bx lr\n");
}

typedef void (*vector)(void);

enum { CORE_EXCEPTIONS = 15 }; /* reset is the first of them */

/* Read by the processor only. */
typedef struct {
  uint32_t *initial_stack;           /* cppcheck-suppress unusedStructMember */
  vector core[CORE_EXCEPTIONS];      /* cppcheck-suppress unusedStructMember */
  vector interrupt[INTERRUPT_COUNT]; /* cppcheck-suppress unusedStructMember */
} vector_table;

/* Every unexpected exception is a fault. */
#define FAULT fault_handler
#define FAULTS_4 FAULT, FAULT, FAULT, FAULT
#define FAULTS_10 FAULT, FAULT, FAULTS_4, FAULTS_4
__attribute__((section(".vectors"), used)) static const vector_table vectors = {
    .initial_stack = stack_top,
    .core = {reset_handler, nmi_handler, FAULTS_10, FAULT, /* 14 */ pendsv_exception, FAULT},
    .interrupt = {/*  0 */ FAULTS_10,
                  FAULTS_4,
                  FAULTS_4,
                  /* 18 */ adc1_2_interrupt,
                  FAULT,
                  FAULT,
                  /* 21 */ fdcan1_it0_interrupt,
                  FAULT,
                  FAULT,
                  /* 24 */ tim1_brk_interrupt,
                  FAULTS_10,
                  FAULTS_4,
                  FAULTS_4,
                  /* 43 */ tim8_brk_interrupt,
                  FAULTS_10,
                  /* 54 */ tim6_dac_interrupt,
                  /* 55 */ pre_tick_interrupt,
                  FAULTS_10,
                  FAULTS_10,
                  FAULTS_10,
                  FAULTS_10,
                  FAULT,
                  FAULT,
                  FAULT,
                  /* 99 */ FAULT,
                  FAULT,
                  FAULT}};
_Static_assert(offsetof(vector_table, interrupt) == 0x40, "ARMv7-M: 16 words before the interrupts");
