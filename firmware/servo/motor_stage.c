/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/motor_stage.h"

#include "base/scalar.h"
#include "servo/servo_axis.h"

static void report(motor_stage *stage) {
  atomic_store_explicit(&stage->limited, stage->state.limited, memory_order_relaxed);
}

void motor_stage_reset(motor_stage *stage) {
  stage->in_force = (motor_command){.setpoint = {.on = false}};
  stage->next = stage->in_force;
  atomic_store_explicit(&stage->handed_over, false, memory_order_relaxed);
  current_loop_reset(&stage->state);
  stage->voltage_sum_v = 0.0f;
  stage->voltage_count = 0;
  atomic_store_explicit(&stage->tick_voltage_v, 0.0f, memory_order_relaxed);
  atomic_store_explicit(&stage->tick_current_a, 0.0f, memory_order_relaxed);
  report(stage);
}

/* Before the loop computes the next voltage: what it computed in the last period is applied in this one. */
static void sum_up(motor_stage *stage, uint32_t period, float current_a) {
  if (period == 0 && stage->voltage_count > 0) {
    atomic_store_explicit(&stage->tick_voltage_v, stage->voltage_sum_v / (float)stage->voltage_count,
                          memory_order_relaxed);
    atomic_store_explicit(&stage->tick_current_a, current_a, memory_order_relaxed);
    stage->voltage_sum_v = 0.0f;
    stage->voltage_count = 0;
  }
  stage->voltage_sum_v += stage->state.voltage_v;
  stage->voltage_count++;
}

void motor_stage_hand_over(motor_stage *stage, motor_setpoint setpoint, const current_loop_params *params) {
  /* A command that was not taken yet is withdrawn first: a PWM period could find it half replaced. */
  atomic_store_explicit(&stage->handed_over, false, memory_order_relaxed);
  atomic_signal_fence(memory_order_seq_cst);
  stage->next.setpoint = setpoint;
  stage->next.params = *params;
  atomic_store_explicit(&stage->handed_over, true, memory_order_release);
}

static float step_current(current_loop_state *state, const motor_command *command, float current_a,
                          float bus_voltage_v) {
  const bool plausible =
      scalar_within(current_a, SERVO_PLAUSIBLE_CURRENT_A) && scalar_within(bus_voltage_v, SERVO_PLAUSIBLE_VOLTAGE_V);
  const motor_setpoint *setpoint = &command->setpoint;
  if (!setpoint->on || !plausible) {
    current_loop_reset(state);
    return 0.0f;
  }
  return current_loop_step(state, &command->params, setpoint->current_a, current_a, setpoint->joint_rate_rad_s,
                           bus_voltage_v, SERVO_PWM_PERIOD_S);
}

float motor_stage_step(motor_stage *stage, uint32_t period, float current_a, float bus_voltage_v) {
  if (period >= SERVO_TICK_LATENCY_PERIODS && atomic_load_explicit(&stage->handed_over, memory_order_acquire)) {
    stage->in_force = stage->next;
    atomic_store_explicit(&stage->handed_over, false, memory_order_relaxed);
  }
  sum_up(stage, period, current_a);
  const float duty = step_current(&stage->state, &stage->in_force, current_a, bus_voltage_v);
  report(stage);
  return duty;
}
