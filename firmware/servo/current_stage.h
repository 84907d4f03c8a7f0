/* The current loop of one axis in an interrupt of its own, more urgent than the tick.
 *
 *     tick: servo_axis_tick -> hand over ... interrupt, SERVO_TICK_LATENCY_PERIODS later: take -> current_loop -> duty
 *
 * Two copies: the tick writes the one that is not in force, so neither sees the other's half-done work, and the new
 * command counts from a fixed PWM period on, however long the tick took (decision 0007). */
#ifndef TRACKSERVO_SERVO_CURRENT_STAGE_H
#define TRACKSERVO_SERVO_CURRENT_STAGE_H

#include <stdatomic.h>

#include "servo/servo_app.h"

/* PWM periods that pass between the tick's sampling and its set-points being followed. */
#define SERVO_TICK_LATENCY_PERIODS 2

typedef struct {
  servo_current_command in_force; /* the interrupt's */
  servo_current_command next;     /* the tick's */
  atomic_bool handed_over;        /* `next` waits to be taken */
  current_loop_state state;       /* the interrupt's */
  atomic_bool limited;            /* the bus could not give the voltage wanted in the last period */
  _Atomic float voltage_v;        /* given in the last period */
} current_stage;

/* Off. */
void current_stage_reset(current_stage *stage);

/* At the end of a tick, in a context that the interrupt may interrupt but not the other way round. */
void current_stage_hand_over(current_stage *stage, const servo_current_command *command);

/* The interrupt, `period` PWM periods (0 ..) after the one in which the tick sampled: the duty in [-1, 1]. A command
 * that was not there in time is taken as soon as it is. */
float current_stage_step(current_stage *stage, uint32_t period, float current_a, float bus_voltage_v);

#endif
