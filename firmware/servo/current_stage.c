#include "servo/current_stage.h"

void current_stage_reset(current_stage *stage) {
  stage->in_force = (servo_current_command){.on = false};
  stage->next = stage->in_force;
  atomic_store_explicit(&stage->handed_over, false, memory_order_relaxed);
  current_loop_reset(&stage->state);
  atomic_store_explicit(&stage->limited, false, memory_order_relaxed);
  atomic_store_explicit(&stage->voltage_v, 0.0f, memory_order_relaxed);
}

void current_stage_hand_over(current_stage *stage, const servo_current_command *command) {
  /* Withdraw a command that was not taken yet: the interrupt would see it partly replaced. */
  atomic_store_explicit(&stage->handed_over, false, memory_order_relaxed);
  atomic_signal_fence(memory_order_seq_cst);
  stage->next = *command;
  atomic_store_explicit(&stage->handed_over, true, memory_order_release);
}

float current_stage_step(current_stage *stage, uint32_t period, float current_a, float bus_voltage_v) {
  if (period >= SERVO_TICK_LATENCY_PERIODS && atomic_load_explicit(&stage->handed_over, memory_order_acquire)) {
    stage->in_force = stage->next;
    atomic_store_explicit(&stage->handed_over, false, memory_order_relaxed);
  }
  const float duty = servo_current_step(&stage->state, &stage->in_force, current_a, bus_voltage_v, SERVO_PWM_PERIOD_S);
  atomic_store_explicit(&stage->limited, stage->state.limited, memory_order_relaxed);
  atomic_store_explicit(&stage->voltage_v, stage->state.voltage_v, memory_order_relaxed);
  return duty;
}
