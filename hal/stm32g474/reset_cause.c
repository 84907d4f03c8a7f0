#include "reset_cause.h"

#include "fault_record.h"
#include "registers/rcc.h"

/* The pin's flag comes with every reset, so it counts last. */
static hal_reset_cause cause_of(uint32_t flags) {
  if ((flags & RCC_CSR_IWDGRSTF) != 0) {
    return HAL_RESET_WATCHDOG;
  }
  if ((flags & RCC_CSR_SFTRSTF) != 0) {
    return HAL_RESET_SOFTWARE;
  }
  if ((flags & RCC_CSR_BORRSTF) != 0) {
    return HAL_RESET_POWER_ON;
  }
  if ((flags & (RCC_CSR_WWDGRSTF | RCC_CSR_LPWRRSTF | RCC_CSR_OBLRSTF)) != 0) {
    return HAL_RESET_OTHER;
  }
  return HAL_RESET_PIN;
}

hal_reset reset_cause_take(void) {
  fault_record record;
  hal_reset reset = {.cause = cause_of(RCC->csr)};
  if (fault_record_take(&record) && reset.cause != HAL_RESET_POWER_ON) {
    reset.cause = HAL_RESET_FAULT;
    reset.exception = (uint8_t)record.exception;
    reset.program_counter = record.program_counter;
  }
  RCC->csr |= RCC_CSR_RMVF;
  return reset;
}
