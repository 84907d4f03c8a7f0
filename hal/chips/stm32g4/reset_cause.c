/* SPDX-License-Identifier: Apache-2.0 */
#include "reset_cause.h"

#include "fault_record.h"
#include "registers/rcc.h"
#include "stack_guard.h"

/* BORRSTF is set by a power-on and by a dip of the supply. A word with its complement distinguishes them: RAM that lost
 * its supply holds arbitrary data, RAM whose supply dipped still holds both. */
#define SUPPLIED 0x53555050u

__attribute__((section(".noinit"))) static volatile struct {
  uint32_t supplied;
  uint32_t complement;
} memory;

static bool memory_knows_the_time_before(void) {
  const bool knows = memory.supplied == SUPPLIED && memory.complement == ~SUPPLIED;
  memory.supplied = SUPPLIED;
  memory.complement = ~SUPPLIED;
  return knows;
}

/* The pin's flag is set by every reset, so it is checked last. */
static hal_reset_cause cause_of(uint32_t flags, bool supplied_before) {
  if ((flags & RCC_CSR_IWDGRSTF) != 0) {
    return HAL_RESET_WATCHDOG;
  }
  if ((flags & RCC_CSR_SFTRSTF) != 0) {
    return HAL_RESET_SOFTWARE;
  }
  if ((flags & RCC_CSR_BORRSTF) != 0) {
    return supplied_before ? HAL_RESET_BROWN_OUT : HAL_RESET_POWER_ON;
  }
  if ((flags & (RCC_CSR_WWDGRSTF | RCC_CSR_LPWRRSTF | RCC_CSR_OBLRSTF)) != 0) {
    return HAL_RESET_OTHER;
  }
  return HAL_RESET_PIN;
}

hal_reset reset_cause_take(void) {
  fault_record record;
  hal_reset reset = {.cause = cause_of(RCC->csr, memory_knows_the_time_before())};
  if (fault_record_take(&record) && reset.cause != HAL_RESET_POWER_ON) {
    const bool stack_overflow = (record.configurable_fault_status & STACK_GUARD_WAS_HIT) != 0;
    reset.cause = stack_overflow ? HAL_RESET_STACK_OVERFLOW : HAL_RESET_FAULT;
    if (record.parity_error != 0) {
      reset.cause = HAL_RESET_RAM_PARITY;
    }
    reset.exception = (uint8_t)record.exception;
    reset.program_counter = record.program_counter;
  }
  RCC->csr |= RCC_CSR_RMVF;
  return reset;
}
