/* SPDX-License-Identifier: Apache-2.0 */
/* Monitors of one axis that need many ticks anyway: drift of the sensors against each other, standstill, direction,
 * reduced speed. They run in the deferred task, so they cost the tick nothing.
 *
 * After each tick the gyro is added up; every SLOW_MONITOR_TICKS the sum and the angle are judged, and what is found
 * holds until the next judgement. It counts in the tick after it: latency at most SLOW_MONITOR_TICKS + 1 ticks more
 * than that of the monitor itself. The caller staggers the axes. Cost: about 25 instructions, 110 with a judgement. */
#ifndef TRACKSERVO_PROTECTION_SLOW_MONITORS_H
#define TRACKSERVO_PROTECTION_SLOW_MONITORS_H

#include "protection/axis_protection.h"
#include "protection/sensor_drift.h"
#include "protection/standstill_monitor.h"

enum { SLOW_MONITOR_TICKS = 4 };

/* Of the commands, besides what protection_inputs has. */
typedef struct {
  bool standing; /* nobody commands the axis to move */
  bool reduced;  /* 2062: the reduced speed limit applies */
} slow_commands;

typedef struct {
  angle_turn32 angle; /* at the last judgement */
  bool angle_known;
  bool spoiled;         /* in one of the ticks a sensor was broken or missing */
  float gyro_sum_rad_s; /* of the ticks since then */
  sensor_drift drift;
  standstill_monitor standstill;
  float reduced_s;
  float torque_sum_nm; /* commanded, of the ticks since the last judgement */
  int strong_windows;  /* with a strong torque towards the set-point, counted without a break */
  float against_rad;   /* path against the set-point */
  float pushed_rad;    /* the part of it in spite of a strong torque */
  fault_set found;     /* by the last judgement */
} slow_monitors;

/* Adds a tick; `found` are the faults that protection has found in it, `torque_nm` was commanded in it. Call after each
 * tick. */
void slow_monitors_add(slow_monitors *monitors, const axis_protection *protection, fault_set found, float torque_nm);

/* Renews `found`. Call after every SLOW_MONITOR_TICKS-th tick, with its inputs. */
void slow_monitors_judge(slow_monitors *monitors, const protection_limits *limits, const protection_motor *motor,
                         const axis_protection *protection, const protection_inputs *in, const slow_commands *commands,
                         float dt_s);

#endif
