/* SPDX-License-Identifier: Apache-2.0 */
/* One servo axis: from its sensor samples to the current set-point of its motor, once per 1 ms tick.
 *
 *     sense -> choose the set-point (speed or position) -> speed loop -> current set-point
 *
 * The motor stage (motor_stage.h) follows the set-point at the PWM rate. Two axes are two instances. An axis that is
 * off, braked by its shorted motor, or given implausible inputs commands no current.
 *
 * The bounds below define plausible: beyond every machine, and narrow enough that no sum in the loops can overflow.
 * NaN, infinity and 1e35 rad/s are refused before they reach a filter or an integral. */
#ifndef TRACKSERVO_SERVO_SERVO_AXIS_H
#define TRACKSERVO_SERVO_SERVO_AXIS_H

#include <stdbool.h>

#include "base/scalar.h"
#include "control/current_loop.h"
#include "control/position_loop.h"
#include "control/speed_loop.h"
#include "control/target_tracker.h"
#include "hal.h"
#include "servo/servo_target.h"

#define SERVO_PLAUSIBLE_RATE_RAD_S 1e3f
#define SERVO_PLAUSIBLE_ACCELERATION_RAD_S2 1e6f
#define SERVO_PLAUSIBLE_TORQUE_NM 1e8f
#define SERVO_PLAUSIBLE_CURRENT_A 1e5f
#define SERVO_PLAUSIBLE_VOLTAGE_V 1e4f

typedef enum {
  SERVO_OFF = 0,        /* no loop closed, the motor's terminals are open */
  SERVO_SPEED,          /* command.speed is the set-point */
  SERVO_POSITION,       /* command.position, with command.speed as feedforward */
  SERVO_TORQUE,         /* command.torque_nm is the torque; the speed loop follows, ready to take over */
  SERVO_BRAKE,          /* no loop closed, the motor's terminals are shorted: it brakes without any sensor */
  SERVO_PROTECTIVE_STOP /* only the current loop is closed: command.torque_nm, limited by nothing but current_limit_a */
} servo_mode;

/* What the axis' gyro turns with. */
typedef enum {
  GYRO_ON_AXIS = 0,      /* what the joint turns: the azimuth stage, or the line of sight (pitch) */
  GYRO_ON_LINE_OF_SIGHT, /* along the axis of the picture: the azimuth's measures cross-elevation */
  GYRO_BELOW_JOINT       /* what carries the joint, about its axis: the base (azimuth), the azimuth stage (pitch) */
} gyro_mounting;

typedef struct {
  speed_loop_params speed;
  position_loop_params position;
  target_tracker_params tracker; /* for joint_tracking.h and pointing.h */
  target_loss at_loss;
  current_loop_params current;
  float torque_constant_nm_a;   /* Kt, 1e-6 .. 1e4 */
  float resistance_ohm;         /* of the winding, from the design of the current loop; for protection */
  float current_limit_a;        /* 0 .. 1e4, both directions */
  float plant_inertia_kg_m2;    /* as identified, 1e-9 .. 1e5: the largest */
  float min_inertia_kg_m2;      /* 1e-9 .. 1e5; of the azimuth: at pitch 90 degrees, also beyond its travel */
  float plant_viscous_nm_s_rad; /* of its seal, for protection: 0 .. 1e4 */
  float plant_stiffness_nm_rad; /* 0 .. 1e9 */
  float plant_damping_nm_s_rad; /* 0 .. 1e6 */
  gyro_mounting gyro;
} servo_axis_params;

typedef struct {
  servo_mode mode;
  speed_reference speed;
  angle_turn32 position;
  float rate_limit_rad_s; /* SERVO_POSITION: limit of the loop's rate in both directions; 0: only its own limit */
  float torque_nm;      /* SERVO_TORQUE, SERVO_PROTECTIVE_STOP: the set-point; else added to the speed loop's torque */
  bool torque_limited;  /* `limits` apply, besides current_limit_a */
  torque_limits limits; /* minimum <= 0 <= maximum */
} servo_axis_command;

typedef struct {
  hal_axis_samples sensors; /* while the encoder has failed, the axis is off */
  bool motor_limited;       /* the bus voltage was too low for the current loop, see motor_stage.h */
  float tick_voltage_v;     /* mean over the last tick; for protection */
  float tick_current_a;     /* at its end, as motor_stage.h says */
} servo_axis_samples;

/* Internal signals of the last tick, for the scope, the bus and the tests. */
typedef struct {
  speed_loop_rates rates;
  speed_reference reference;
  speed_loop_output torque;
} servo_axis_signals;

typedef struct {
  servo_mode mode;
  speed_loop_pose pose; /* for the next tick, set by its owner; of an axis by itself: 1 and 1 */
  speed_loop_state speed;
  float commanded_nm;        /* torque command in effect */
  float added_nm;            /* its part that is not from the speed loop */
  float current_reference_a; /* set by the tick; the motor stage follows it */
  angle_turn32 last_angle;
  bool implausible; /* the last samples or command were implausible: the axis is off until the next good ones */
  servo_axis_signals signals;
} servo_axis;

control_status servo_axis_check(const servo_axis_params *params, float tick_s, float pwm_period_s);

/* Resets the axis: off, at rest, without estimates, with the pose of an axis by itself. */
void servo_axis_reset(servo_axis *axis, const servo_axis_params *params, angle_turn32 angle, float tick_s);

/* Computes one tick. An axis that is off continues sensing. The tick that changes its mode from off closes the loops
 * with no torque at the sensed rate. */
void servo_axis_tick(servo_axis *axis, const servo_axis_params *params, const servo_axis_command *command,
                     const servo_axis_samples *samples, float tick_s);

/* Changes the parameters between two ticks, without a torque step while a loop is closed. `next` must have passed
 * `servo_axis_check`. */
void servo_axis_retune(servo_axis *axis, servo_axis_params *in_force, const servo_axis_params *next, float tick_s);

/* Changes the parameters as servo_axis_retune, for a loop that makes the axis oscillate, whose torque and estimates are
 * useless. Closes the loop again at the present rate, with `holding_nm` as its torque at zero rate error. */
void servo_axis_replace(servo_axis *axis, servo_axis_params *in_force, const servo_axis_params *next, float holding_nm,
                        float tick_s);

/* Returns whether a mode closes the current loop and one above it. */
static inline bool servo_mode_closes(servo_mode mode) {
  return mode != SERVO_OFF && mode != SERVO_BRAKE && mode != SERVO_PROTECTIVE_STOP;
}

/* Returns whether a mode closes the current loop. */
static inline bool servo_mode_drives(servo_mode mode) { return mode != SERVO_OFF && mode != SERVO_BRAKE; }

#endif
