/* SPDX-License-Identifier: Apache-2.0 */
/* The last faults of the axes and the board, each with the samples of its axis in the ticks before it.
 *
 * Object 0x3020 (node/objects/fault_objects.c). In RAM: survives a reset of the node, but not a loss of power. */
#ifndef TRACKSERVO_PROTECTION_FAULT_LOG_H
#define TRACKSERVO_PROTECTION_FAULT_LOG_H

#include "protection/fault_table.h"
#include "servo/servo_app.h"

enum { FAULT_LOG_ENTRIES = 8, FAULT_LOG_TICKS = 16 };

/* Source of a fault: the number of an axis, or this for the board itself, which has no samples. */
enum { FAULT_LOG_BOARD = SERVO_AXES };

/* One tick of one axis. Only floats, so that it can be read as a table of them. */
typedef struct {
  float joint_angle_rad; /* -pi .. pi */
  float joint_rate_rad_s;
  float gyro_rad_s; /* NaN in a tick without */
  float reference_rad_s;
  float rate_rad_s;
  float torque_nm; /* commanded */
  float current_a;
  float bus_voltage_v;
} fault_log_sample;

enum { FAULT_LOG_SIGNALS = sizeof(fault_log_sample) / sizeof(float) };

typedef struct {
  uint32_t tick; /* 0x3010:1 when it was detected */
  uint8_t fault; /* fault_id */
  uint8_t source;
  uint8_t samples;                          /* valid ones, up to FAULT_LOG_TICKS */
  fault_log_sample before[FAULT_LOG_TICKS]; /* oldest first; the last is that of the tick that detected the fault */
} fault_log_entry;

/* The last ticks of an axis, in a ring. */
typedef struct {
  fault_log_sample sample[FAULT_LOG_TICKS];
  uint8_t next;
  uint8_t count;
} fault_log_history;

typedef struct {
  fault_log_entry entry[FAULT_LOG_ENTRIES];
  fault_log_history history[SERVO_AXES];
  uint32_t count; /* written since the log was cleared */
} fault_log;

/* Empties the log; the sampled ticks stay. */
void fault_log_clear(fault_log *log);

/* Samples a tick. Call once per tick and axis, before faults of that tick are written. */
void fault_log_sample_tick(fault_log *log, int axis, const fault_log_sample *sample);

/* Writes an entry; `source` is 0, 1 or FAULT_LOG_BOARD. Replaces the oldest entry when the log is full. */
void fault_log_write(fault_log *log, int source, fault_id fault, uint32_t tick);

/* Returns the entry written `age` (0: newest) entries ago, or NULL. */
const fault_log_entry *fault_log_find(const fault_log *log, uint32_t age);

#endif
