/* SPDX-License-Identifier: Apache-2.0 */
/* The processor's own registers: ARMv7-M Architecture Reference Manual (DDI 0403E), sections B3.2 (SCB), B3.4 (NVIC),
 * B3.5 (MPU) and C1.8 (DWT). Compared with the crate `cortex-m`. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_CORE_H
#define TRACKSERVO_STM32G4_REGISTERS_CORE_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t iser[8];
  uint32_t reserved_20[24];
  volatile uint32_t icer[8];
  uint32_t reserved_a0[24];
  volatile uint32_t ispr[8];
  uint32_t reserved_120[24];
  volatile uint32_t icpr[8];
  uint32_t reserved_1a0[88];
  volatile uint8_t ipr[240]; /* by bytes; 4 bits are implemented, the upper ones */
} nvic_registers;
REGISTER_AT(nvic_registers, ipr, 0x300);

#define NVIC ((nvic_registers *)0xE000E100u)

typedef struct {
  volatile uint32_t icsr;
  volatile uint32_t vtor;
  volatile uint32_t aircr;
  volatile uint32_t scr;
  volatile uint32_t ccr;
  volatile uint32_t shpr[3];
  volatile uint32_t shcsr;
  volatile uint32_t cfsr;
  volatile uint32_t hfsr;
  volatile uint32_t dfsr;
  volatile uint32_t mmfar;
  volatile uint32_t bfar;
  volatile uint32_t afsr;
  uint32_t reserved_40[18];
  volatile uint32_t cpacr;
} scb_registers;
REGISTER_AT(scb_registers, cpacr, 0x84);

#define SCB ((scb_registers *)0xE000ED04u) /* behind CPUID */

#define SCB_CCR_DIV_0_TRP FIELD(4, 1)
#define SCB_SHCSR_MEMFAULTENA FIELD(16, 1)
#define SCB_SHCSR_BUSFAULTENA FIELD(17, 1)
#define SCB_SHCSR_USGFAULTENA FIELD(18, 1)
#define SCB_CFSR_DACCVIOL FIELD(1, 1)
#define SCB_CFSR_MSTKERR FIELD(4, 1)
#define SCB_CFSR_MLSPERR FIELD(5, 1)
#define SCB_ICSR_VECTACTIVE FIELD(0, 9)
#define SCB_ICSR_PENDSVSET FIELD(28, 1)
#define SCB_SHPR3_PENDSV FIELD(16, 8)
#define SCB_CPACR_CP10_CP11 FIELD(20, 4)

typedef struct {
  uint32_t reserved_0;
  volatile uint32_t ctrl;
  volatile uint32_t rnr;
  volatile uint32_t rbar;
  volatile uint32_t rasr;
} mpu_registers;
REGISTER_AT(mpu_registers, rasr, 0x10);

#define MPU ((mpu_registers *)0xE000ED90u)

#define MPU_CTRL_ENABLE FIELD(0, 1)
#define MPU_CTRL_PRIVDEFENA FIELD(2, 1)
#define MPU_RASR_ENABLE FIELD(0, 1)
#define MPU_RASR_SIZE FIELD(1, 5) /* of 2^(SIZE + 1) bytes */
#define MPU_RASR_AP FIELD(24, 3)
#define MPU_RASR_XN FIELD(28, 1)
enum { MPU_AP_NO_ACCESS = 0 };

typedef struct {
  volatile uint32_t ctrl;
  volatile uint32_t cyccnt;
} dwt_registers;

#define DWT ((dwt_registers *)0xE0001000u)
#define DWT_CTRL_CYCCNTENA FIELD(0, 1)

typedef struct {
  volatile uint32_t dhcsr;
  volatile uint32_t dcrsr;
  volatile uint32_t dcrdr;
  volatile uint32_t demcr;
} dcb_registers;

#define DCB ((dcb_registers *)0xE000EDF0u)
#define DCB_DEMCR_TRCENA FIELD(24, 1)

#endif
