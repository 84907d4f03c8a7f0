/* The set-point handshake of profile position mode: one active set-point, one waiting.
 *
 * Standard: CiA 402-2 / IEC 61800-7-201 clause 7.2.3 (controlword bits 4 new set-point, 5 change immediately,
 * 6 relative; statusword bit 12 set-point acknowledge). A rising edge of bit 4 takes 607A: at once when bit 5 is set or
 * no set-point is active, otherwise after the active one. A third set-point is dropped. Relative set-points count from
 * the previous target. */
#ifndef TRACKSERVO_DRIVE_SETPOINT_QUEUE_H
#define TRACKSERVO_DRIVE_SETPOINT_QUEUE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
  int32_t target; /* of the active set-point, or of the last one; 1e-7 rad */
  int32_t next;
  bool under_way;
  bool waiting;
  bool acknowledged; /* statusword bit 12 */
  bool edge_before;  /* bit 4 of the last controlword */
} setpoint_queue;

/* No set-point is active; relative set-points count from `position`. `bit_before` is bit 4 of the controlword in the
 * previous tick: a bit that was set already must fall before it counts. */
void setpoint_queue_reset(setpoint_queue *queue, int32_t position, bool bit_before);

/* One tick. `target` is 607A. Returns whether a set-point became active in this tick. */
bool setpoint_queue_step(setpoint_queue *queue, uint16_t controlword, int32_t target);

/* One tick of another mode: monitors bit 4, so that a bit that is still set when pp begins is no edge. */
void setpoint_queue_idle(setpoint_queue *queue, uint16_t controlword);

/* The active set-point has been reached. Returns whether the waiting one is active now. */
bool setpoint_queue_finish(setpoint_queue *queue);

#endif
