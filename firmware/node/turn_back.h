/* SPDX-License-Identifier: Apache-2.0 */
/* At the end of its travel the azimuth turns back by one revolution and meets the target with the other joint angle
 * (docs/decisions/tracking.md).
 *
 *     begins     when the target is TURN_BACK_BEYOND_RAD outside of the travel and cable_wrap.h knows an angle that
 * lasts longer meanwhile  the camera's frames do not count; the target is taken to go on: round the tracker when it has
 * been followed for more than half a turn, which no straight path is; else straight ahead in space ends
 * TURN_BACK_NEAR_RAD before the target: the tracking loop goes on from where it is expected
 *
 * All of it is computed between two ticks. */
#ifndef TRACKSERVO_NODE_TURN_BACK_H
#define TRACKSERVO_NODE_TURN_BACK_H

#include <stdbool.h>

#include "control/target_return.h"
#include "servo/pointing.h"

#define TURN_BACK_BEYOND_RAD 1e-3f
#define TURN_BACK_NEAR_RAD 0.05f

typedef struct {
  uint32_t at;            /* tick */
  joint_vector angle_rad; /* of joints that would look at the target */
} target_mark;

typedef struct {
  bool follows;         /* a target is known, and was in the last tick */
  float joint_rad;      /* of the azimuth, in the last tick with a target */
  float acquired_rad;   /* where the azimuth looked at it first */
  target_mark marks[2]; /* older and newer one; their distance is TURN_BACK_MARK_TICKS */
  target_mark now;
  bool running;
  target_path path; /* of the turn */
  uint32_t begun;
  float direction;
  pointing_output expected; /* what both axes do meanwhile; all 0 otherwise */
  float absence_s;          /* for so long it may not have been seen when the turn has ended; 0 otherwise */
} turn_back;

enum { TURN_BACK_MARK_TICKS = 512 };

/* What the azimuth may and does. */
typedef struct {
  bool allowed;
  bool seen; /* a target is known by its frames */
  uint32_t tick;
  joint_vector joint_rad;
  joint_vector error_rad; /* of the joints, to the target */
  const target_return_limits *limits;
} turn_back_inputs;

void turn_back_reset(turn_back *self);

/* Returns whether the target is where the azimuth cannot point with its present turn. */
bool turn_back_is_outside(const turn_back *self, const joint_travel *travel);

/* Computes one tick, with the line of sight that both axes track. */
void turn_back_step(turn_back *self, pointing *line_of_sight, const pointing_motion *motion,
                    const turn_back_inputs *inputs);

#endif
