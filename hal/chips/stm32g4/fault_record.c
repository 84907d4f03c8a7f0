/* SPDX-License-Identifier: Apache-2.0 */
#include "fault_record.h"

/* RAM has arbitrary contents after power-on, so a word and its complement mark the record as valid. */
#define PRESENT 0x46415553u

typedef struct {
  uint32_t present;
  fault_record record;
  uint32_t check;
} retained_record;

__attribute__((section(".noinit"))) static volatile retained_record kept;

static uint32_t check_of(const fault_record *record) {
  return ~(PRESENT + record->exception + record->program_counter + record->configurable_fault_status +
           record->hard_fault_status + record->parity_error);
}

void fault_record_write(const fault_record *record) {
  kept.record.exception = record->exception;
  kept.record.program_counter = record->program_counter;
  kept.record.configurable_fault_status = record->configurable_fault_status;
  kept.record.hard_fault_status = record->hard_fault_status;
  kept.record.parity_error = record->parity_error;
  kept.check = check_of(record);
  kept.present = PRESENT;
}

bool fault_record_take(fault_record *record) {
  const bool present = kept.present == PRESENT;
  *record = (fault_record){.exception = kept.record.exception,
                           .program_counter = kept.record.program_counter,
                           .configurable_fault_status = kept.record.configurable_fault_status,
                           .hard_fault_status = kept.record.hard_fault_status,
                           .parity_error = kept.record.parity_error};
  kept.present = 0;
  return present && kept.check == check_of(record);
}
