/* SPDX-License-Identifier: Apache-2.0 */
#include "control/line_of_sight.h"

#include <math.h>

#include "base/scalar.h"

control_status camera_mounting_check(const camera_mounting *mounting) {
  const scalar_range ranges[] = {
      {mounting->roll_rad, -SCALAR_PI, SCALAR_PI},
      {mounting->boresight.x, -0.5f, 0.5f},
      {mounting->boresight.y, -0.5f, 0.5f},
  };
  return scalar_check_ranges(ranges, 3);
}

camera_alignment camera_align(const camera_mounting *mounting) {
  const float size_rad = scalar_abs(mounting->roll_rad);
  const float sine = scalar_sin(scalar_min(size_rad, SCALAR_PI));
  return (camera_alignment){
      .roll = {.sine = mounting->roll_rad < 0.0f ? -sine : sine, .cosine = scalar_cos(scalar_min(size_rad, SCALAR_PI))},
      .boresight = mounting->boresight};
}

image_vector camera_error(const camera_alignment *alignment, image_vector measured) {
  const rotation roll = alignment->roll;
  return (image_vector){.x = roll.cosine * measured.x - roll.sine * measured.y - alignment->boresight.x,
                        .y = roll.sine * measured.x + roll.cosine * measured.y - alignment->boresight.y};
}

/* In the frame of the azimuth stage the target is at b + x c + y e = (forward, x, up). Its horizontal distance h
 * exceeds `forward` by little: q = h - forward without cancellation. The pitch error is the angle between two
 * directions of the plane through z, so it is exact where a difference of two pitch angles would lose its digits. */
static joint_vector errors_of(rotation pitch, image_vector error, float forward, float horizontal) {
  const float q = forward > 0.0f ? error.x * error.x / (horizontal + forward) : horizontal - forward;
  return (joint_vector){.azimuth = scalar_atan2(error.x, forward),
                        .pitch = scalar_atan2(error.y - q * pitch.sine, 1.0f + q * pitch.cosine)};
}

joint_vector line_of_sight_joint_errors(rotation pitch, image_vector error) {
  const float forward = pitch.cosine - error.y * pitch.sine;
  return errors_of(pitch, error, forward, sqrtf(forward * forward + error.x * error.x));
}

/* The turn along the great circle takes b to d / |d| and v to v - (b + d / |d|) (v d) / (|d| + b d). The image axis c
 * there is (-sin, cos, 0) of the azimuth's turn. */
line_of_sight_turn line_of_sight_turn_to(rotation pitch, image_vector error) {
  const float forward = pitch.cosine - error.y * pitch.sine;
  const float up = pitch.sine + error.y * pitch.cosine;
  const float horizontal = sqrtf(forward * forward + error.x * error.x);
  const float distance = sqrtf(horizontal * horizontal + up * up);
  const bool at_zenith = horizontal == 0.0f;
  const rotation azimuth = {.sine = at_zenith ? 0.0f : error.x / horizontal,
                            .cosine = at_zenith ? 1.0f : forward / horizontal};
  const float carried = azimuth.sine * pitch.cosine / (1.0f + distance);
  return (line_of_sight_turn){.error_rad = errors_of(pitch, error, forward, horizontal),
                              .pitch = {.sine = up / distance, .cosine = horizontal / distance},
                              .image = {.sine = -(azimuth.sine * pitch.sine + carried * error.y),
                                        .cosine = azimuth.cosine + carried * error.x}};
}

line_of_sight_rates line_of_sight_of_joints(rotation pitch, float stage_rad_s, float pitch_rad_s) {
  return (line_of_sight_rates){.rad_s = {.x = stage_rad_s * pitch.cosine, .y = pitch_rad_s},
                               .roll_rad_s = stage_rad_s * pitch.sine};
}

float pointing_azimuth_inertia_kg_m2(const pointing_inertia *inertia, rotation pitch) {
  return inertia->azimuth_kg_m2 + inertia->azimuth_swing_kg_m2 * pitch.cosine * pitch.cosine;
}

joint_vector pointing_torques_nm(const pointing_inertia *inertia, rotation pitch, joint_vector rate_rad_s,
                                 joint_vector acceleration_rad_s2) {
  const float swing_kg_m2 = 2.0f * inertia->azimuth_swing_kg_m2 * pitch.sine * pitch.cosine;
  return (joint_vector){.azimuth = pointing_azimuth_inertia_kg_m2(inertia, pitch) * acceleration_rad_s2.azimuth -
                                   swing_kg_m2 * rate_rad_s.azimuth * rate_rad_s.pitch,
                        .pitch = inertia->pitch_kg_m2 * acceleration_rad_s2.pitch +
                                 0.5f * swing_kg_m2 * rate_rad_s.azimuth * rate_rad_s.azimuth};
}
