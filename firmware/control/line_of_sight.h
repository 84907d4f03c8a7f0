/* SPDX-License-Identifier: Apache-2.0 */
/* Geometry of the line of sight on an azimuth stage that carries a pitch joint.
 *
 * Frames: the base has x forward, y to the left, z up. The azimuth psi turns the stage about z, the pitch theta raises
 * the line of sight b; both are 0 forward. The camera looks along b. Its image axes are
 *
 *     c (cross-elevation): horizontal, the direction in which the azimuth grows
 *     e (elevation):       up, the direction in which the pitch grows
 *
 * An image error is the tangent of the angle, in rad: a target in direction d has x = (d c) / (d b), y = (d e) / (d b).
 * So a pinhole camera's pixels are proportional to it over the whole image.
 *
 * Everything is exact up to rounding, up to the zenith and beyond it. The usual approximation, cross-elevation divided
 * by cos(theta), errs by 2 degrees at 3 mrad and 89 degrees. */
#ifndef TRACKSERVO_CONTROL_LINE_OF_SIGHT_H
#define TRACKSERVO_CONTROL_LINE_OF_SIGHT_H

#include "base/rotation.h"
#include "base/status.h"

/* In the image, or rates along its axes. */
typedef struct {
  float x; /* cross-elevation */
  float y; /* elevation */
} image_vector;

/* Of both joints. */
typedef struct {
  float azimuth;
  float pitch;
} joint_vector;

/* How the camera sits on the line of sight. */
typedef struct {
  float roll_rad;         /* of its sensor about the line of sight, counter-clockwise in the image; -pi .. pi */
  image_vector boresight; /* image point, in the image axes above, at which the target is to be held; -0.5 .. 0.5 */
} camera_mounting;

/* The same, as a frame needs it. */
typedef struct {
  rotation roll;
  image_vector boresight;
} camera_alignment;

/* Returns CONTROL_OK, or why these values are refused. */
control_status camera_mounting_check(const camera_mounting *mounting);

/* Precomputes the alignment from checked values. Call once when they change. */
camera_alignment camera_align(const camera_mounting *mounting);

/* Returns the error from the boresight along c and e, from what the sensor measured along its own rows and columns. */
image_vector camera_error(const camera_alignment *alignment, image_vector measured);

/* What brings the line of sight to a target. */
typedef struct {
  /* How far each joint must turn. Azimuth in [-pi, pi], pitch such that the target is reached without passing the
   * zenith; at a target in the zenith the azimuth stays. */
  joint_vector error_rad;
  rotation pitch; /* the pitch angle there; its cosine is not negative */
  rotation image; /* turns a vector that came along the great circle into components along the image axes there */
} line_of_sight_turn;

line_of_sight_turn line_of_sight_turn_to(rotation pitch, image_vector error);

/* Returns its error_rad alone. */
joint_vector line_of_sight_joint_errors(rotation pitch, image_vector error);

/* Rates of the image frame about its axes when the joints turn: about e (cross-elevation), about -c (elevation) and
 * about the line of sight (roll). */
typedef struct {
  image_vector rad_s;
  float roll_rad_s;
} line_of_sight_rates;

/* Returns the rates of the line of sight from the inertial rates of the stage about z and of the pitch body about the
 * pitch axis. */
line_of_sight_rates line_of_sight_of_joints(rotation pitch, float stage_rad_s, float pitch_rad_s);

/* Inertia of both axes, kg m^2: that of the azimuth is J0 + J1 cos^2(theta). */
typedef struct {
  float azimuth_kg_m2;       /* J0 */
  float azimuth_swing_kg_m2; /* J1, what the pitch body adds at pitch 0; may be negative */
  float pitch_kg_m2;
} pointing_inertia;

/* Returns the inertia of the azimuth at this pitch. */
float pointing_azimuth_inertia_kg_m2(const pointing_inertia *inertia, rotation pitch);

/* Returns the torques of both joints for these rates (rad/s) and accelerations (rad/s^2) of the joints on a base at
 * rest, without friction and gravity, from the Lagrangian  L = (J0 + J1 cos^2 theta) psi'^2 / 2 + Jp theta'^2 / 2:
 *
 *     azimuth  (J0 + J1 cos^2 theta) psi'' - J1 sin(2 theta) psi' theta'
 *     pitch    Jp theta'' + J1 sin(2 theta) psi'^2 / 2 */
joint_vector pointing_torques_nm(const pointing_inertia *inertia, rotation pitch, joint_vector rate_rad_s,
                                 joint_vector acceleration_rad_s2);

#endif
