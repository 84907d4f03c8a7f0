/* The current loop of one axis in an interrupt of its own, more urgent than the tick.
 *
 *     tick: servo_axis_tick -> hand over ... interrupt, SERVO_TICK_LATENCY_PERIODS later: take -> current_loop -> duty
 *
 * There are two copies: the tick writes the one that is not in effect, so neither context reads a partly written one.
 * The new command takes effect in a fixed PWM period, however long the tick took (decision 0007). */
#ifndef TRACKSERVO_SERVO_CURRENT_STAGE_H
#define TRACKSERVO_SERVO_CURRENT_STAGE_H

#include <stdatomic.h>

#include "servo/servo_app.h"

/* PWM periods from the sampling of the tick until its set-points take effect. */
#define SERVO_TICK_LATENCY_PERIODS 2

typedef struct {
  servo_current_command in_force; /* the interrupt's */
  servo_current_command next;     /* the tick's */
  atomic_bool handed_over;        /* `next` waits to be taken */
  current_loop_state state;       /* the interrupt's */
  atomic_bool limited;            /* the bus could not supply the required voltage in the last period */
  _Atomic float voltage_v;        /* applied in the last period */
} current_stage;

/* Off. */
void current_stage_reset(current_stage *stage);

/* At the end of a tick, in a context that the interrupt may interrupt, never the reverse. */
void current_stage_hand_over(current_stage *stage, const servo_current_command *command);

/* The interrupt, `period` PWM periods (0 ..) after the one in which the tick sampled: the duty in [-1, 1]. A late
 * command is taken as soon as it arrives. */
float current_stage_step(current_stage *stage, uint32_t period, float current_a, float bus_voltage_v);

#endif
