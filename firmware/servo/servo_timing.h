/* SPDX-License-Identifier: Apache-2.0 */
/* The clock of the servo, the same on every machine. */
#ifndef TRACKSERVO_SERVO_SERVO_TIMING_H
#define TRACKSERVO_SERVO_SERVO_TIMING_H

#define SERVO_TICK_S 0.001f
#define SERVO_TICKS_PER_S 1000u
#define SERVO_PWM_PERIOD_S 0.00005f
#define SERVO_PWM_PER_TICK 20

/* PWM periods between the tick's sampling and the first period that follows its set-points (decision 0007). */
#define SERVO_TICK_LATENCY_PERIODS 2

#endif
