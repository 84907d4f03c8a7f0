/* SPDX-License-Identifier: Apache-2.0 */
/* The interrupts that this board uses, and their priorities: 0 is the most urgent, a more urgent one interrupts a less
 * urgent one.
 *
 *     0  driver faults: TIM1 break, TIM8 break
 *     1  current loop: end of the injected sequence of ADC1, 20 kHz
 *     2  tick: TIM6 update, 1 kHz; pre-tick task: input that came before the tick, requested by the last PWM periods
 *     3  CAN: a frame was received, or the hardware has sent all its frames
 *     4  deferred task: PendSV, requested by every tick
 *        background: main, watchdog */
#ifndef TRACKSERVO_STM32G4_INTERRUPTS_H
#define TRACKSERVO_STM32G4_INTERRUPTS_H

#include "registers/core.h"

enum {
  ADC1_2_INTERRUPT = 18,
  FDCAN1_IT0_INTERRUPT = 21,
  TIM1_BRK_INTERRUPT = 24,
  TIM8_BRK_INTERRUPT = 43,
  TIM6_DAC_INTERRUPT = 54,
  TIM7_INTERRUPT = 55,
  INTERRUPT_COUNT = 102
};

/* The pre-tick task borrows the line of an unused timer. */
enum { PRE_TICK_INTERRUPT = TIM7_INTERRUPT };

enum {
  PRIORITY_DRIVER_FAULT = 0,
  PRIORITY_CURRENT_LOOP = 1,
  PRIORITY_TICK = 2,
  PRIORITY_CAN = 3,
  PRIORITY_SERVICE = 4
};

void adc1_2_interrupt(void);
void fdcan1_it0_interrupt(void);
void tim1_brk_interrupt(void);
void tim8_brk_interrupt(void);
void tim6_dac_interrupt(void);
void pre_tick_interrupt(void);
void pendsv_exception(void);

enum { UNIMPLEMENTED_PRIORITY_BITS = 4 };

/* Starts the deferred task, which runs when nothing more urgent is pending. */
static inline void service_start(void) {
  field_set(&SCB->shpr[2], SCB_SHPR3_PENDSV, PRIORITY_SERVICE << UNIMPLEMENTED_PRIORITY_BITS);
}
static inline void service_request(void) { SCB->icsr = SCB_ICSR_PENDSVSET; }

static inline void interrupt_request(uint32_t number) { NVIC->ispr[number / 32u] = 1u << (number % 32u); }

/* Clears what is pending, sets the priority, enables. */
static inline void interrupt_enable(uint32_t number, uint32_t priority) {
  const uint32_t word = number / 32u;
  const uint32_t bit = 1u << (number % 32u);
  NVIC->ipr[number] = (uint8_t)(priority << UNIMPLEMENTED_PRIORITY_BITS);
  NVIC->icpr[word] = bit;
  NVIC->iser[word] = bit;
}

#endif
