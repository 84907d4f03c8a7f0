/* SPDX-License-Identifier: Apache-2.0 */
/* The fault before the last reset: written by the fault handlers into RAM that a reset does not clear. */
#ifndef TRACKSERVO_STM32G4_FAULT_RECORD_H
#define TRACKSERVO_STM32G4_FAULT_RECORD_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
  uint32_t exception; /* number in the vector table: 2 NMI, 3 HardFault, 4 MemManage, 5 BusFault, 6 UsageFault .. */
  uint32_t program_counter;           /* 0 when the stack could not be read */
  uint32_t configurable_fault_status; /* CFSR */
  uint32_t hard_fault_status;         /* HFSR */
  uint32_t parity_error;              /* 1: of the RAM, see ram_parity.h */
} fault_record;

void fault_record_write(const fault_record *record);

/* Takes the record out. Returns false when there was none: no fault caused the last reset. */
bool fault_record_take(fault_record *record);

#endif
