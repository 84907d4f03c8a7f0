/* SPDX-License-Identifier: Apache-2.0 */
/* Monitors one axis once per tick: finds the active faults from the sensors and from the motor commands. It only
 * detects; the drive reacts as `fault_table` says.
 *
 * Sensors are checked in every state, motion only while the loops are closed. What a single tick can show is found in
 * the tick, on its samples and before the set-points are computed: the reaction is in the same tick. What needs many
 * ticks anyway is judged in the deferred task after it, and counts one tick later. docs/cost.md has the cost. */
#ifndef TRACKSERVO_PROTECTION_AXIS_PROTECTION_H
#define TRACKSERVO_PROTECTION_AXIS_PROTECTION_H

#include <stdbool.h>

#include "base/angle.h"
#include "base/refusal.h"
#include "base/status.h"
#include "protection/encoder_outliers.h"
#include "protection/fault_table.h"
#include "protection/motor_witness.h"
#include "protection/protection_limit_list.h"

#define PROTECTION_MEMBER(sub_, member_, low_, high_, default_, unit_, name_, help_) float member_;

/* Object 0x2060: overspeed_rad_s and so on, as protection_limit_list.h lists them with ranges and texts. */
typedef struct {
  PROTECTION_LIMITS(PROTECTION_MEMBER)
} protection_limits;

/* The motor parameters of the current loop. */
typedef struct {
  float resistance_ohm;
  float back_emf_v_s_rad;
  float current_limit_a;
  float torque_constant_nm_a;
  float time_constant_s; /* L / R */
} protection_motor;

typedef struct {
  bool angle_valid;
  angle_turn32 angle;
  bool gyro_valid;
  bool gyro_used; /* by the speed loop */
  float gyro_rad_s;
  float gyro_gain;     /* this times the reading, and ... */
  float gyro_of_joint; /* ... this part of the joint's rate, are the inertial rate about the axis */
  float position_rad;  /* counts turns */
  bool ends_known;     /* it can be compared with the travel */
  float mean_current_a;
  float tick_voltage_v; /* mean of the bridge in the last tick */
  float tick_current_a; /* at its end */
  float bus_voltage_v;
  /* of the last tick */
  bool powered;          /* the bridge was on: a loop was closed, or the motor was shorted */
  bool closed;           /* a loop was closed */
  bool speed_closed;     /* ... that controls the speed */
  bool limited;          /* the torque was at a limit */
  float torque_nm;       /* commanded */
  float reference_rad_s; /* less what the base carries the axis (3076): the sender's word must look like no motion */
  float rate_rad_s;      /* the one controlled, the same */
  float rate_delay_s;    /* of the encoder's share in it, beyond that of two angles (2050:3) */
} protection_inputs;

typedef struct {
  angle_turn32 last_angle;
  float last_step_rad;
  int angles_known; /* consecutive, counted up to 2 */
  float last_gyro_rad_s;
  float last_inertial_rad_s;
  float same_angle_s;
  float same_gyro_s;
  int gyro_missing_ticks;
  float difference_rad_s; /* gyro minus encoder, smoothed */
  int disagree_ticks;
  int overspeed_ticks;
  int saturated_ticks;
  float slow_rate_rad_s; /* the rate some ms ago */
  int runaway_ticks;
  float rate_before_rad_s; /* some ms before the first of them */
  float speed_error_s;
  float stall_s;
  float outside_rad; /* least distance beyond the travel since a loop was closed */
  float heating_a2;  /* mean square current of the last thermal time */
  int off_ticks;     /* since the bridge switched off, counted until its current has decayed */
  float offset_a;
  int offset_ticks;
  int mismatch_ticks; /* ticks with a mismatch minus ticks without, 0 or more */
  int over_current_ticks;
  int under_voltage_ticks;
  int over_voltage_ticks;
  float last_tick_current_a;
  int closed_ticks; /* counted up to 2 */
  motor_witness witness;
  float step_change_rad; /* of the position increment, to this tick */
  encoder_outliers outliers;
} axis_protection;

/* Pairs of limits that contradict each other, as bits. */
enum {
  PROTECTION_VOLTAGES = 1, /* under-voltage not below over-voltage */
  PROTECTION_TRAVEL = 2    /* minimum above maximum, or twice the stopping margin leaves no travel */
};

/* Returns whether 2060:9 and 2060:10 limit the travel. */
static inline bool protection_has_travel(const protection_limits *limits) {
  return limits->minimum_rad < limits->maximum_rad;
}

uint8_t protection_contradictions(const protection_limits *limits);

/* Returns why these limits may not take effect: the limit that is wrong and what would be right; status CONTROL_OK if
 * they may. A limit that another one bounds must be within the permitted range, not at its end. */
parameter_refusal protection_refusal(const protection_limits *limits);

/* Returns CONTROL_OK if these limits may take effect. */
control_status protection_check(const protection_limits *limits);

/* Returns the largest difference of gyro and encoder that FAULT_SENSORS_DISAGREE permits at this rate. What a moving
 * base turns across the line of sight, a gyro there shows `gyro_gain` times in the rate about the axis. */
float protection_sensor_difference_rad_s(const protection_limits *limits, float gyro_gain, float joint_rate_rad_s);

/* Restarts the counts of all faults; keeps what is known of the winding. */
void axis_protection_reset(axis_protection *protection);

/* Lets the comparison of encoder and gyro begin anew. Call it in each tick in which the gyro is certainly wrong. */
void axis_protection_forget_differences(axis_protection *protection);

/* Returns the faults that this tick shows. */
fault_set axis_protection_step(axis_protection *protection, const protection_limits *limits,
                               const protection_motor *motor, const protection_inputs *in, float dt_s);

/* Returns the faults that the motor shows, and updates what is known of its winding and how warm it is. Call after the
 * tick, in the deferred task and with the same inputs; the faults count from the next tick on. */
fault_set axis_protection_judge(axis_protection *protection, const protection_limits *limits,
                                const protection_motor *motor, const protection_inputs *in, float dt_s);

/* Returns whether the winding is near its limit: 90 % of the continuous current. */
bool axis_protection_warns(const axis_protection *protection, const protection_limits *limits);

#endif
