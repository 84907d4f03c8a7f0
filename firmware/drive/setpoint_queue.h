/* SPDX-License-Identifier: Apache-2.0 */
/* The set-point handshake of profile position mode: one active set-point, one waiting.
 *
 * Standard: CiA 402-2 / IEC 61800-7-201 clause 7.2.3 (controlword bits 4 new set-point, 5 change immediately,
 * 6 relative; statusword bit 12 set-point acknowledge) and object 60F2. A rising edge of bit 4 takes 607A: at once when
 * bit 5 is set or no set-point is active, otherwise after the active one. A third set-point is dropped.
 *
 *     relative    607A counts from the target before, the demand (6062) or the actual position (6064): 60F2 bits 0, 1
 *     absolute    within a limited travel 607A is the position. Without one it is the direction within the range 607B,
 *                 and 60F2 bits 6, 7 choose the way: as on a straight line, down, up, or the shorter one
 *
 * A target beyond the travel becomes its end (statusword bit 11), and relative set-points count from there. */
#ifndef TRACKSERVO_DRIVE_SETPOINT_QUEUE_H
#define TRACKSERVO_DRIVE_SETPOINT_QUEUE_H

#include <stdbool.h>
#include <stdint.h>

#include "drive/drive_travel.h"
#include "drive/drive_units.h"

/* 60F2: the supported options. */
enum {
  SETPOINT_FROM_TARGET = 0x00,
  SETPOINT_FROM_DEMAND = 0x01,
  SETPOINT_FROM_ACTUAL = 0x02,
  SETPOINT_RELATIVE_TO = 0x03,
  SETPOINT_STRAIGHT = 0x00,
  SETPOINT_DOWN = 0x40,
  SETPOINT_UP = 0x80,
  SETPOINT_SHORTER = 0xC0,
  SETPOINT_WAY = 0xC0
};

/* A target keeps whole counts, which a count of 2^-32 turn cannot: a thousand relative moves add up exactly. */
typedef struct {
  drive_angle origin; /* whole ranges */
  int64_t counts;     /* from there, 1e-7 rad */
  drive_angle angle;  /* of the target */
  bool limited;       /* the end of the travel, in place of a target beyond it */
} setpoint_target;

typedef struct {
  setpoint_target target; /* of the active set-point, or of the last one */
  setpoint_target next;
  bool under_way;
  bool waiting;
  bool acknowledged; /* statusword bit 12 */
  bool edge_before;  /* bit 4 of the last controlword */
} setpoint_queue;

/* What the objects say in a tick. */
typedef struct {
  uint16_t controlword;
  int32_t target;  /* 607A */
  uint16_t option; /* 60F2 */
  drive_angle demand;
  drive_angle actual;
  bool wraps; /* no travel is limited */
} setpoint_order;

/* Returns whether 60F2 may have this value: a dictionary refuses others. */
bool setpoint_option_supported(uint16_t option);

/* Forgets all set-points; relative ones count from `position`. `bit_before` is bit 4 of the controlword in the
 * previous tick: a bit that was set already must fall before it counts. */
void setpoint_queue_reset(setpoint_queue *queue, drive_angle position, bool bit_before);

/* Computes one tick of pp. Returns whether a set-point became active in this tick. */
bool setpoint_queue_step(setpoint_queue *queue, const setpoint_order *order);

/* Keeps the targets within the travel. Call it in each tick of pp: the travel may have changed. */
void setpoint_queue_limit(setpoint_queue *queue, const drive_travel *travel);

/* Computes one tick of another mode: monitors bit 4, so that a bit that is still set when pp begins is no edge. */
void setpoint_queue_idle(setpoint_queue *queue, uint16_t controlword);

/* Ends the active set-point, which has been reached. Returns whether the waiting one is active now. */
bool setpoint_queue_finish(setpoint_queue *queue);

#endif
