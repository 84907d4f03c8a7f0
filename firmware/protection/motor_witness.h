/* SPDX-License-Identifier: Apache-2.0 */
/* The motor as the third witness beside encoder and gyro: its back-EMF contradicts them when both err in the same way.
 *
 *     u - L di/dt = R i + Ke w        u, i: means of one tick; w: the joint rate that the encoder shows
 *
 * R (winding temperature, scale of the current sensor) and Ke are not exact. The block keeps an interval for each, as a
 * share of the motor data 2055:
 *
 *     R / R0 in [r.low, r.high],  Ke / K0 in [k.low, k.high]
 *
 * At the start they are as wide as 2060:22 says (R upwards by 10 % more: a warm winding). `motor_witness_learn` cuts
 * them to what the measured u, i and w permit, and widens them by the fastest drift of a winding's temperature: a fault
 * of both sensors that comes faster cannot hide in R. What the interval arithmetic assumes is that the sensors are
 * right while it learns, and that all other errors of u (dead time, offsets, noise) stay below
 *
 *     e = 2060:23 + 4 % of the back-EMF (torque ripple) + 2060:22 L |di/dt| (L has the tolerance of R and Ke)
 *         + Ke MOTOR_WITNESS_RATE_DELAY_S |dw/dt| (the rate of a tick comes from means of readings: it is late)
 *
 * The offset of the current sensor is measured while the bridge is off; before that, e is larger by R0 times 0.05 A.
 * Then a contradiction is certain:
 *
 *     u - L di/dt outside [min, max] of (R i + Ke w) -+ e  for MOTOR_WITNESS_TICKS
 *
 * The smallest error of the speed that it must find follows: dw = (2 e + (r.high - r.low) R0 |i|) / Ke + (k.high -
 * k.low) w. All signals pass one low-pass filter of MOTOR_WITNESS_SMOOTHING_S, for learning of four times as much.
 * Cost: about 90 instructions per axis in the tick, 100 in the deferred task. */
#ifndef TRACKSERVO_PROTECTION_MOTOR_WITNESS_H
#define TRACKSERVO_PROTECTION_MOTOR_WITNESS_H

#include <stdbool.h>

#define MOTOR_WITNESS_SMOOTHING_S 0.005f
#define MOTOR_WITNESS_RATE_DELAY_S 0.001f
enum { MOTOR_WITNESS_TICKS = 5 };

typedef struct {
  float resistance_ohm;
  float time_constant_s;  /* L / R */
  float back_emf_v_s_rad; /* not negative */
} motor_data;

typedef struct {
  float tolerance;        /* 2060:22; 0: nothing is compared */
  float back_emf_error_v; /* 2060:23 */
  float largest_zero_a;   /* 2060:13 */
  float largest_v;        /* 2060:14: beyond it and `tolerance` of R i, the monitor of the current sensor judges */
} motor_witness_limits;

typedef struct {
  bool driven;      /* the current loop ran in the whole last tick */
  bool idle;        /* the bridge is off, and its current has decayed */
  float voltage_v;  /* mean of the last tick */
  float current_a;  /* the same */
  float now_a;      /* at the end of it */
  float rate_rad_s; /* mean joint rate of the last tick */
} motor_witness_inputs;

typedef struct {
  float low;
  float high;
} motor_interval;

/* Smoothed. */
typedef struct {
  float voltage_v;   /* u - L di/dt */
  float inductive_v; /* L di/dt, with L as 2055 says */
  float current_a;
  float rate_rad_s;
  float acceleration_rad_s2;
} motor_signals;

typedef enum {
  MOTOR_AGREES = 0,
  MOTOR_CONTRADICTS, /* the motor turns differently from what the sensors show */
  MOTOR_WEAK         /* it gives less voltage for the speed than Ke says: its magnets, or 2055 is wrong */
} motor_verdict;

/* All zero: nothing seen yet, R, Ke and the offset unknown. */
typedef struct {
  bool known; /* the intervals have been set */
  bool running;
  int idle_ticks;  /* counted until the offset is known */
  int other_ticks; /* in a row with a current that is not this offset */
  float zero_a;    /* offset of the current */
  float now_a;
  motor_signals fast;  /* what is judged */
  motor_signals slow;  /* what is learned from */
  float unexplained_v; /* u - L di/dt outside the range of all permitted motors; signed, 0 within */
  motor_interval resistance;
  motor_interval back_emf;
  float resistance_ohm; /* the intervals are shares of these two */
  float back_emf_v_s_rad;
  int ticks; /* of the same verdict */
  motor_verdict verdict;
} motor_witness;

/* Returns how far the offset of the current may be off, A: 0 once the bridge has been off for some time. */
float motor_witness_zero_error_a(const motor_witness *witness);

/* Makes R and Ke as unknown as at the start: what was learned from a broken sensor must not outlive its repair. The
 * offset is measured all the time while the bridge is off, and anew where it has changed by more than its noise. */
static inline void motor_witness_forget_motor(motor_witness *witness) { witness->known = false; }

/* Makes R, Ke and the offset as unknown as at the start. */
void motor_witness_forget(motor_witness *witness);

/* Judges one tick. Returns MOTOR_AGREES also while nothing can be said. */
motor_verdict motor_witness_step(motor_witness *witness, const motor_witness_limits *limits, const motor_data *motor,
                                 const motor_witness_inputs *in, float dt_s);

/* Narrows and widens the intervals. Call after the tick. */
void motor_witness_learn(motor_witness *witness, const motor_witness_limits *limits, float dt_s);

/* Returns the largest error of the speed that can stay undetected with the present current and intervals, rad/s. */
float motor_witness_bound_rad_s(const motor_witness *witness, const motor_witness_limits *limits);

#endif
