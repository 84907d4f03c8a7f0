/* SPDX-License-Identifier: Apache-2.0 */
/* What is known of the camera's target, and how an axis would follow it: from the block that tracks (node/tracking.h)
 * to the drive, which limits it as it limits every set-point. */
#ifndef TRACKSERVO_SERVO_SERVO_TARGET_H
#define TRACKSERVO_SERVO_SERVO_TARGET_H

#include <stdbool.h>

#include "control/speed_loop.h"

/* What an axis does when its target is lost (2011:6). */
typedef enum {
  TARGET_LOSS_STAND = 0,
  TARGET_LOSS_RETURN = 1 /* to where it began to track */
} target_loss;

typedef struct {
  bool known;                /* it was seen no longer than 2011:5 ago */
  float error_rad;           /* target minus line of sight, of this joint, now; as the last frame saw it */
  speed_reference reference; /* rate and acceleration that follow it; 0 while it is not known */
  float torque_nm;           /* beside what the speed loop gives for them */
  float proportional_per_s;  /* the part of the rate that the error makes, per rad of it */
  int frame_age_ticks;       /* since the last frame that showed it */
  target_loss at_loss;
} servo_target;

#endif
