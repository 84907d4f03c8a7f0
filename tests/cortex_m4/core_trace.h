/* SPDX-License-Identifier: Apache-2.0 */
/* The inputs and outputs of the servo core as a sequence of 32-bit words, so that another machine can be checked for
 * the same bits.
 *
 * Its events are the calls of servo/servo_board.h: the parameters once, then ticks and PWM periods in their order. Each
 * part is listed once, in core_trace.c; the visitor decides whether it is written, read or compared. Floats are stored
 * as their bits, everything else as a number, so that each compiler may lay out its structs. Both machines are
 * little-endian. */
#ifndef TRACKSERVO_TESTS_CORTEX_M4_CORE_TRACE_H
#define TRACKSERVO_TESTS_CORTEX_M4_CORE_TRACE_H

#ifdef __cplusplus
extern "C" {
#endif

#include "servo/servo_board.h"

typedef enum { TRACE_END = 0, TRACE_CONFIGURE, TRACE_TICK, TRACE_PWM } trace_event;

/* Called for each word, with the expression that names it; its result replaces the word. */
typedef struct {
  uint32_t (*word)(void *context, const char *name, uint32_t value);
  void *context;
} trace_visitor;

/* One PWM period: the inputs of the motor stages. */
typedef struct {
  uint32_t number; /* since the tick's sampling */
  float current_a[SERVO_AXES];
  float bus_voltage_v;
} trace_period;

void trace_visit_event(const trace_visitor *visitor, trace_event *event);
void trace_visit_params(const trace_visitor *visitor, servo_params *params);
void trace_visit_command(const trace_visitor *visitor, servo_command *command);

/* What comes from the HAL. */
void trace_visit_samples(const trace_visitor *visitor, servo_samples *samples);
void trace_visit_period(const trace_visitor *visitor, trace_period *period);

/* Outputs: of a tick, the report of the motor stage and all signals and commands of an axis; of a period, the duty. */
void trace_visit_tick_results(const trace_visitor *visitor, servo_axis_samples *samples, servo_axis *axis);
void trace_visit_duty(const trace_visitor *visitor, float *duty);

#ifdef __cplusplus
}
#endif

#endif
