/* SPDX-License-Identifier: Apache-2.0 */
/* Inputs and outputs of an axis in the last tick, for recording over the bus: 0x2101 (pitch 0x2901).
 *
 * All values are of one tick and are sent together in the next one, so three TPDOs of 8 bytes carry every tick:
 *
 *     joint angle, joint rate | inertial rate, torque | number, kind, run, reference
 *
 * A receiver knows that the first two belong to a tick when they came, once each and in this order, between the third
 * of the previous tick and the third of this one. They are what sim_host/design/commissioning/acquisition.cpp
 * records. */
#ifndef TRACKSERVO_NODE_RECORDED_TICK_H
#define TRACKSERVO_NODE_RECORDED_TICK_H

#include "canopen/object_dictionary.h"
#include "node/experiment_objects.h"
#include "servo/servo_board.h"

typedef struct {
  uint16_t number; /* of the tick, wraps */
  uint8_t kind;    /* stimulus_kind of the experiment that gave the set-point, 0: none */
  uint8_t run;     /* experiments started so far, wraps */
  uint32_t joint_angle_turn32;
  float joint_rate_rad_s;
  float inertial_rate_rad_s; /* the gyro's; NaN in a tick without */
  float torque_nm;           /* torque constant times the mean current since the last tick */
  float reference;           /* rad/s; N m where torque is the set-point; rad (-pi .. pi) in hysteresis loops */
} recorded_tick;

extern const od_table recorded_tick_table;

/* Records a tick. Call after its control. `stimulated`: the experiment gave the set-point. */
void recorded_tick_take(recorded_tick *recorded, const servo_board *board, int axis, const experiment_objects *objects,
                        bool stimulated, uint32_t tick);

#endif
