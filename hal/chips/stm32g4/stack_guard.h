/* SPDX-License-Identifier: Apache-2.0 */
/* The stack lies at the bottom of the RAM. The 32 KiB below it, where no memory is, may not be accessed: a stack
 * overflow, by the program or by an interrupt's entry, causes a MemManage fault at once, before any data is lost.
 *
 * It is the only such region, so every data access that the MPU refuses is reported as a stack overflow. */
#ifndef TRACKSERVO_STM32G4_STACK_GUARD_H
#define TRACKSERVO_STM32G4_STACK_GUARD_H

#include "registers/core.h"

enum { STACK_GUARD_SIZE_32_KIB = 14 };

#define STACK_GUARD_WAS_HIT (SCB_CFSR_DACCVIOL | SCB_CFSR_MSTKERR | SCB_CFSR_MLSPERR) /* of CFSR */

/* Guards the stack. `below_stack` is the region's lowest address, a multiple of 32 KiB. Everything else stays as
 * without an MPU. */
static inline void stack_guard_start(uint32_t below_stack) {
  MPU->rnr = 0;
  MPU->rbar = below_stack;
  MPU->rasr = MPU_RASR_XN | FIELD_VALUE(MPU_RASR_AP, MPU_AP_NO_ACCESS) |
              FIELD_VALUE(MPU_RASR_SIZE, STACK_GUARD_SIZE_32_KIB) | MPU_RASR_ENABLE;
  MPU->ctrl = MPU_CTRL_PRIVDEFENA | MPU_CTRL_ENABLE;
  __asm volatile("dsb\n isb" ::: "memory");
}

#endif
