/* The set-point handshake of profile position mode: one set-point under way, one waiting.
 *
 * Standard: CiA 402-2 / IEC 61800-7-201 clause 7.2.3 (controlword bits 4 new set-point, 5 change immediately,
 * 6 relative; statusword bit 12 set-point acknowledge). A rising edge of bit 4 takes 607A: at once when bit 5 is set
 * or nothing is under way, else after the one under way; a third waits for no one and is dropped. Relative set-points
 * count from the target before them. */
#ifndef TRACKSERVO_DRIVE_SETPOINT_QUEUE_H
#define TRACKSERVO_DRIVE_SETPOINT_QUEUE_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
  int32_t target; /* of the set-point under way, or the last one; 1e-7 rad */
  int32_t next;
  bool under_way;
  bool waiting;
  bool acknowledged; /* statusword bit 12 */
  bool edge_before;  /* bit 4 of the last controlword */
} setpoint_queue;

/* Nothing under way; relative set-points would count from `position`. `bit_before` is bit 4 of the controlword in the
 * tick before: a bit that was set already must fall before it counts. */
void setpoint_queue_reset(setpoint_queue *queue, int32_t position, bool bit_before);

/* One tick. `target` is 607A. Returns whether a set-point came under way in this tick. */
bool setpoint_queue_step(setpoint_queue *queue, uint16_t controlword, int32_t target);

/* One tick of another mode: bit 4 is watched, so that one that is held into pp is no edge. */
void setpoint_queue_idle(setpoint_queue *queue, uint16_t controlword);

/* The set-point under way is reached. Returns whether the waiting one is under way now. */
bool setpoint_queue_finish(setpoint_queue *queue);

#endif
