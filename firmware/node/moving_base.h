/* SPDX-License-Identifier: Apache-2.0 */
/* The base's rates in the node: from the messages on the bus to what each axis adds to its rate.
 *
 * Every MOVING_BASE_TICKS an axis gets the rate of so many ticks later, and goes there in equal steps, so that messages
 * cause no steps of the torque. When they begin or end, or the axis
 * is ordered to stop, their share grows or falls within 128 ms. */
#ifndef TRACKSERVO_NODE_MOVING_BASE_H
#define TRACKSERVO_NODE_MOVING_BASE_H

#include <stdbool.h>

#include "node/objects/base_objects.h"
#include "servo/servo_app.h"

enum { MOVING_BASE_TICKS = 2 * SERVO_AXES };

typedef struct {
  base_objects objects; /* 0x3076 .. 0x3078 */
  base_rates rates;
  bool arrived;          /* a message waits */
  uint32_t arrived_tick; /* for the tick after this */
  uint32_t tick;         /* the last one */
  bool fixed[SERVO_AXES];
  float step_rad_s[SERVO_AXES]; /* per tick */
  float share[SERVO_AXES];      /* of the rates, 0 .. 1 */
} moving_base;

/* Of the part of the base's objects; its owner is the `moving_base`. */
extern const od_hooks moving_base_hooks;

/* Forgets all messages: a reset of the node. */
void moving_base_forget(moving_base *self);

/* Goes one step with both axes. Call once per ms, between two ticks. */
void moving_base_step(moving_base *self, servo_app *app, uint32_t tick);

typedef struct {
  int index;    /* SERVO_AZIMUTH or SERVO_PITCH */
  bool fixed;   /* it is declared that its base does not move */
  bool follows; /* its drive is in operation, and nothing has ordered it to stop */
} moving_base_axis;

/* Finds the next steps of an axis. Call for each axis every MOVING_BASE_TICKS. */
void moving_base_aim(moving_base *self, const servo_app *app, const servo_samples *samples,
                     const moving_base_axis *axis);

#endif
