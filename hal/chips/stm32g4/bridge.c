/* SPDX-License-Identifier: Apache-2.0 */
#include "bridge.h"

#include <stdint.h>

#include "connections.h"

/* The timers count up and down once a period. */
enum { HALF_PERIOD = BRIDGE_COUNTS, DEAD_TIME_0_5_US = 85, BREAK_FILTER_8_CLOCKS = 3, LOCK_DEAD_TIME_AND_BREAK = 1 };

static volatile bool faulty[HAL_AXES];

static void start_timer(tim1_registers *timer) {
  timer->cr1 = FIELD_VALUE(TIM1_CR1_CMS, TIM1_CMS_CENTRE_1) | TIM1_CR1_ARPE;
  timer->ccmr1_output = FIELD_VALUE(TIM1_CCMR1_OUTPUT_OC1M, TIM1_OCM_PWM_1) | TIM1_CCMR1_OUTPUT_OC1PE |
                        FIELD_VALUE(TIM1_CCMR1_OUTPUT_OC2M, TIM1_OCM_PWM_1) | TIM1_CCMR1_OUTPUT_OC2PE;
  timer->ccer = TIM1_CCER_CC1E | TIM1_CCER_CC1NE | TIM1_CCER_CC2E | TIM1_CCER_CC2NE;
  timer->psc = 0;
  timer->arr = HALF_PERIOD;
  timer->rcr = 1; /* one update per period, of the two that up-down counting would give */
  timer->ccr1 = HALF_PERIOD / 2;
  timer->ccr2 = HALF_PERIOD / 2;
  timer->af1 = TIM1_AF1_BKINE;
  timer->af2 = TIM1_AF2_BK2INE;
  /* Off state: outputs driven low, not left open. The fault input and channel B of STO are low active: BKP and BK2P
   * stay 0. Channel B has no filter (BK2F = 0), so it needs no clock (RM0440: asynchronous). */
  timer->bdtr = FIELD_VALUE(TIM1_BDTR_DTG, DEAD_TIME_0_5_US) | TIM1_BDTR_OSSI | TIM1_BDTR_OSSR | TIM1_BDTR_BKE |
                FIELD_VALUE(TIM1_BDTR_BKF, BREAK_FILTER_8_CLOCKS) | TIM1_BDTR_BK2E |
                FIELD_VALUE(TIM1_BDTR_LOCK, LOCK_DEAD_TIME_AND_BREAK);
  timer->egr = TIM1_EGR_UG; /* loads the preloaded values */
  timer->sr = 0;
  timer->dier = TIM1_DIER_BIE;
}

void bridge_start(void) {
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    start_timer(board_bridges[axis].timer);
  }
  /* TIM1 triggers TIM8 when it starts, and the ADC when it updates. */
  for (int axis = 1; axis < BOARD_AXES; ++axis) {
    board_bridges[axis].timer->smcr =
        FIELD_VALUE(TIM1_SMCR_TS, TIM8_TS_TIM1) | FIELD_VALUE(TIM1_SMCR_SMS, TIM1_SMS_TRIGGER);
  }
  TIM1->cr2 = FIELD_VALUE(TIM1_CR2_MMS, TIM1_MMS_ENABLE) | FIELD_VALUE(TIM1_CR2_MMS2, TIM1_MMS2_UPDATE);
  TIM1->cr1 |= TIM1_CR1_CEN;
}

void bridge_set_duty(int axis, float duty) {
  const uint32_t leg_1 = bridge_first_leg(duty);
  board_bridges[axis].timer->ccr1 = leg_1;
  board_bridges[axis].timer->ccr2 = HALF_PERIOD - leg_1;
}

static void switch_off(const bridge_connection *bridge) {
  bridge->timer->bdtr &= ~TIM1_BDTR_MOE;
  bridge->enable_port->bsrr = GPIO_CLEAR(bridge->enable_pin);
}

#define BREAK_FLAGS (TIM1_SR_BIF | TIM1_SR_B2IF)

/* A flag returns at once while its input is active. */
static void forget_fault_if_gone(int axis) {
  tim1_registers *timer = board_bridges[axis].timer;
  timer->sr = ~BREAK_FLAGS;
  if ((timer->sr & BREAK_FLAGS) == 0) {
    faulty[axis] = false;
    timer->dier |= TIM1_DIER_BIE;
  }
}

void bridge_power(int axis, bool on) {
  const bridge_connection *bridge = &board_bridges[axis];
  if (!on) {
    switch_off(bridge);
    if (faulty[axis]) {
      forget_fault_if_gone(axis);
    }
  } else if (!faulty[axis]) {
    bridge->enable_port->bsrr = GPIO_SET(bridge->enable_pin);
    bridge->timer->bdtr |= TIM1_BDTR_MOE;
    if (faulty[axis]) { /* since the check */
      switch_off(bridge);
    }
  }
}

bool bridge_fault(int axis) { return faulty[axis]; }

void bridge_trip(int axis) {
  switch_off(&board_bridges[axis]);
  faulty[axis] = true;
}

/* The interrupt is disabled until the fault was reported and is gone; otherwise it would repeat without end. */
bool bridge_break_interrupt(int axis) {
  tim1_registers *timer = board_bridges[axis].timer;
  bridge_trip(axis);
  timer->dier &= ~TIM1_DIER_BIE;
  const bool by_sto = (timer->sr & (TIM1_SR_BIF | TIM1_SR_B2IF)) == TIM1_SR_B2IF;
  timer->sr = ~BREAK_FLAGS;
  return by_sto;
}
