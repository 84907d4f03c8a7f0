/* SPDX-License-Identifier: Apache-2.0 */
/* Predictions of the target's return (control/target_return.h), one after the other while the target is too fast for
 * the axes, outside of their travel, or met again by a turn back. Between two of them, and after the last one, the time
 * counts down. */
#ifndef TRACKSERVO_NODE_RETURN_PREDICTION_H
#define TRACKSERVO_NODE_RETURN_PREDICTION_H

#include "control/target_return.h"
#include "node/turn_back.h"
#include "servo/pointing.h"

enum { RETURN_UNKNOWN = 0xFFFF };

typedef struct {
  target_return ahead; /* the prediction that runs */
  uint32_t begun;      /* its tick */
  uint32_t back_at;    /* tick of the return, by the last prediction with an answer */
  bool known;          /* there is one */
  bool late;           /* the target is not followed */
  uint32_t since;      /* tick */
} return_prediction;

/* What both axes track in this tick. */
typedef struct {
  const pointing *line_of_sight;
  const pointing_motion *motion;
  const pointing_output *target;
  const turn_back *turn;
  joint_vector joint_rad;
} return_prediction_inputs;

/* Ends the prediction and forgets its result. Call when the axes do not track together. */
void return_prediction_reset(return_prediction *self);

/* Computes one tick; a prediction takes one tick per step. Returns the time until the line of sight is back, in ms: 0
 * while the axes follow the target, RETURN_UNKNOWN before the first result and when it is not back within the time of a
 * prediction. */
uint16_t return_prediction_step(return_prediction *self, const target_return_limits *limits,
                                const return_prediction_inputs *inputs, uint32_t tick);

/* Returns the time from the first tick in which the target was not followed to its return, s; 0 if not known. */
float return_prediction_absence_s(const return_prediction *self);

#endif
