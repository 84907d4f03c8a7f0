/* SPDX-License-Identifier: Apache-2.0 */
/* How a target goes on while it is not followed: the angles of both joints that would point at it, over time.
 *
 *     straight    in space, at constant speed. In units of its range at the start, with w its angular rate, a its
 *                 angular acceleration and p its direction:
 *                 p(t) = p + (w + rho p) t,   rho = range rate / range = -(a w) / (2 w^2), at most |w|
 *     round       about the tracker: both joints keep their rates
 *
 * Angles are those of the joints; the azimuth is known but for whole turns. */
#ifndef TRACKSERVO_CONTROL_TARGET_PATH_H
#define TRACKSERVO_CONTROL_TARGET_PATH_H

#include <stdbool.h>

#include "control/pointing_tracker.h"

typedef struct {
  bool round;
  joint_vector angle_rad;  /* at the start: round, of both joints; straight, where the azimuth stage looks */
  joint_vector rate_rad_s; /* round */
  float place[3];          /* straight: forward, left, up in the azimuth stage at the start */
  float per_s[3];          /* its change */
} target_path;

typedef struct {
  float angle_rad;
  float rate_rad_s;
  float acceleration_rad_s2;
} joint_target;

typedef struct {
  joint_target azimuth;
  joint_target pitch;
  float horizontal; /* cosine of the elevation */
} target_place;

/* Returns the straight path of a target seen from joints at `joint_rad`; `target` along the image axes of their line of
 * sight. */
target_path target_path_straight(joint_vector joint_rad, const pointing_target *target);

target_path target_path_round(joint_vector angle_rad, joint_vector rate_rad_s);

/* Returns the place `time_s` after the start. */
target_place target_path_at(const target_path *path, float time_s);

/* Returns what a camera would see, as pointing_tracker_target, from joints whose azimuth is `azimuth_error_rad` away
 * from the target, within a quarter of a turn. */
pointing_target target_path_seen(const target_place *place, float azimuth_error_rad, rotation pitch);

#endif
