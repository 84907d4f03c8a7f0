/* SPDX-License-Identifier: Apache-2.0 */
/* Universal synchronous/asynchronous receiver transmitter: RM0440, the facts only. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_USART_H
#define TRACKSERVO_STM32G4_REGISTERS_USART_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t cr1;
  volatile uint32_t cr2;
  volatile uint32_t cr3;
  volatile uint32_t brr;
  volatile uint32_t gtpr;
  volatile uint32_t rtor;
  volatile uint32_t rqr;
  volatile uint32_t isr;
  volatile uint32_t icr;
  volatile uint32_t rdr;
  volatile uint32_t tdr;
  volatile uint32_t presc;
} usart1_registers;
REGISTER_AT(usart1_registers, presc, 0x2C);

#define USART1 ((usart1_registers *)0x40013800u)
#define USART3 ((usart1_registers *)0x40004800u)

#define USART1_CR1_UE FIELD(0, 1)
#define USART1_CR1_RE FIELD(2, 1)
#define USART1_CR1_TE FIELD(3, 1)

#define USART1_CR3_DMAR FIELD(6, 1)
#define USART1_CR3_OVRDIS FIELD(12, 1)

#define USART1_ISR_RESET 0x000000C0u /* TC, TXE */

#endif
