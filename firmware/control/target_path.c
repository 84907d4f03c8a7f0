/* SPDX-License-Identifier: Apache-2.0 */
#include "control/target_path.h"

#include <math.h>

#include "base/scalar.h"

#define MIN_HORIZONTAL 1e-4f /* of the range; closer to the zenith the azimuth's rate has no meaning */

static float dot(image_vector a, image_vector b) { return a.x * b.x + a.y * b.y; }

/* Range rate / range; above the target's rate it may be noise of the acceleration. */
static float approach_of(const pointing_target *target) {
  const image_vector w = target->rate_rad_s;
  const float square = dot(w, w);
  const float limit = sqrtf(square);
  return square > 0.0f ? scalar_clamp(-0.5f * dot(target->acceleration_rad_s2, w) / square, -limit, limit) : 0.0f;
}

static rotation rotation_by(float angle_rad) {
  return rotation_of((angle_turn32)angle_integer(scalar_round(angle_rad / ANGLE_RAD_PER_TURN32)));
}

target_path target_path_straight(joint_vector joint_rad, const pointing_target *target) {
  const rotation pitch = rotation_by(joint_rad.pitch);
  const image_vector error = target->error;
  const image_vector w = target->rate_rad_s;
  const float rho = approach_of(target);
  const float size = sqrtf(1.0f + dot(error, error));
  const float place[] = {(pitch.cosine - error.y * pitch.sine) / size, error.x / size,
                         (pitch.sine + error.y * pitch.cosine) / size};
  const float across[] = {-w.y * pitch.sine, w.x, w.y * pitch.cosine};
  target_path path = {.angle_rad = joint_rad};
  for (int i = 0; i < 3; ++i) {
    path.place[i] = place[i];
    path.per_s[i] = across[i] + rho * place[i];
  }
  return path;
}

target_path target_path_round(joint_vector angle_rad, joint_vector rate_rad_s) {
  return (target_path){.round = true, .angle_rad = angle_rad, .rate_rad_s = rate_rad_s};
}

static target_place round_at(const target_path *path, float time_s) {
  const float pitch_rad = path->angle_rad.pitch + path->rate_rad_s.pitch * time_s;
  return (target_place){.azimuth = {.angle_rad = path->angle_rad.azimuth + path->rate_rad_s.azimuth * time_s,
                                    .rate_rad_s = path->rate_rad_s.azimuth},
                        .pitch = {.angle_rad = pitch_rad, .rate_rad_s = path->rate_rad_s.pitch},
                        .horizontal = rotation_by(pitch_rad).cosine};
}

target_place target_path_at(const target_path *path, float time_s) {
  if (path->round) {
    return round_at(path, time_s);
  }
  const float *v = path->per_s;
  float at[3];
  for (int i = 0; i < 3; ++i) {
    at[i] = path->place[i] + v[i] * time_s;
  }
  const float range = sqrtf(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]);
  const float horizontal = scalar_max(sqrtf(at[0] * at[0] + at[1] * at[1]), MIN_HORIZONTAL * range);
  const float outwards = (at[0] * v[0] + at[1] * v[1]) / horizontal;
  const float azimuth_rad_s = (at[0] * v[1] - at[1] * v[0]) / (horizontal * horizontal);
  return (target_place){.azimuth = {.angle_rad = path->angle_rad.azimuth + scalar_atan2(at[1], at[0]),
                                    .rate_rad_s = azimuth_rad_s,
                                    .acceleration_rad_s2 = -2.0f * azimuth_rad_s * outwards / horizontal},
                        .pitch = {.angle_rad = scalar_atan2(at[2], horizontal),
                                  .rate_rad_s = (v[2] * horizontal - at[2] * outwards) / (range * range)},
                        .horizontal = horizontal / range};
}

pointing_target target_path_seen(const target_place *place, float azimuth_error_rad, rotation pitch) {
  const rotation there = rotation_by(place->pitch.angle_rad);
  const rotation aside = rotation_by(azimuth_error_rad);
  const float ahead = there.cosine * aside.cosine;
  const float forward = ahead * pitch.cosine + there.sine * pitch.sine;
  const image_vector error = {.x = there.cosine * aside.sine / forward,
                              .y = (there.sine * pitch.cosine - ahead * pitch.sine) / forward};
  /* Of line_of_sight_turn_to, whose distance is 1 / forward; a second caller of it would cost 20 instructions in the
   * tick. */
  const float carried = aside.sine * pitch.cosine / (1.0f + 1.0f / forward);
  const rotation image = {.sine = -(aside.sine * pitch.sine + carried * error.y),
                          .cosine = aside.cosine + carried * error.x};
  const float w = place->azimuth.rate_rad_s;
  const image_vector rate = {.x = w * there.cosine, .y = place->pitch.rate_rad_s};
  const image_vector acceleration = {
      .x = there.cosine * place->azimuth.acceleration_rad_s2 - 2.0f * w * rate.y * there.sine,
      .y = place->pitch.acceleration_rad_s2 + w * w * there.sine * there.cosine};
  return (pointing_target){
      .error = error,
      .rate_rad_s = {image.cosine * rate.x + image.sine * rate.y, image.cosine * rate.y - image.sine * rate.x},
      .acceleration_rad_s2 = {image.cosine * acceleration.x + image.sine * acceleration.y,
                              image.cosine * acceleration.y - image.sine * acceleration.x}};
}
