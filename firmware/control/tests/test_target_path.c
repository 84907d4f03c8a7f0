/* SPDX-License-Identifier: Apache-2.0 */
/* Where a target will be, against the path itself in double; and what a camera sees of it. */
#include "control/target_path.h"

#include <math.h>

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

/* 20 m/s along y, level, closest at (100, 0, 50) after 3 s; seen by joints that look at it at first. */
static double along_m(double time_s) { return 20.0 * (time_s - 3.0); }
static double azimuth_rad(double time_s) { return atan2(along_m(time_s), 100.0); }
static double pitch_rad(double time_s) { return atan2(50.0, hypot(100.0, along_m(time_s))); }

static double rate(double (*angle)(double), double time_s) {
  return (angle(time_s + 1e-4) - angle(time_s - 1e-4)) / 2e-4;
}

static double rate_2(double (*angle)(double), double time_s) {
  return (rate(angle, time_s + 1e-3) - rate(angle, time_s - 1e-3)) / 2e-3;
}

/* Along the image axes of a line of sight on it, as line_of_sight.h has them. */
static pointing_target seen_at(double time_s) {
  const double sine = sin(pitch_rad(time_s));
  const double cosine = cos(pitch_rad(time_s));
  const double w = rate(azimuth_rad, time_s);
  return (pointing_target){.rate_rad_s = {.x = (float)(w * cosine), .y = (float)rate(pitch_rad, time_s)},
                           .acceleration_rad_s2 = {.x = (float)(rate_2(azimuth_rad, time_s) * cosine -
                                                                2.0 * w * rate(pitch_rad, time_s) * sine),
                                                   .y = (float)(rate_2(pitch_rad, time_s) + w * w * sine * cosine)}};
}

static void test_a_straight_path_is_that_of_the_target(void) {
  const pointing_target target = seen_at(0.0);
  const joint_vector joints = {.azimuth = (float)azimuth_rad(0.0), .pitch = (float)pitch_rad(0.0)};
  const target_path path = target_path_straight(joints, &target);
  for (double time_s = 0.0; time_s <= 8.0; time_s += 0.5) {
    const target_place place = target_path_at(&path, (float)time_s);
    CHECK_NEAR("azimuth, rad", azimuth_rad(time_s), place.azimuth.angle_rad, 2e-3);
    CHECK_NEAR("pitch, rad", pitch_rad(time_s), place.pitch.angle_rad, 2e-3);
    CHECK_NEAR("azimuth, rad/s", rate(azimuth_rad, time_s), place.azimuth.rate_rad_s, 1e-3);
    CHECK_NEAR("pitch, rad/s", rate(pitch_rad, time_s), place.pitch.rate_rad_s, 1e-3);
    CHECK_NEAR("azimuth, rad/s^2", rate_2(azimuth_rad, time_s), place.azimuth.acceleration_rad_s2, 1e-3);
    CHECK_NEAR("cosine", cos(pitch_rad(time_s)), place.horizontal, 2e-3);
  }
}

static void test_a_path_round_the_tracker_keeps_both_rates_for_more_than_a_turn(void) {
  const target_path path = target_path_round((joint_vector){4.9f, 0.5f}, (joint_vector){0.3f, -0.01f});
  const target_place place = target_path_at(&path, 30.0f);
  CHECK_NEAR("azimuth, rad", 13.9, place.azimuth.angle_rad, 1e-5);
  CHECK_NEAR("pitch, rad", 0.2, place.pitch.angle_rad, 1e-6);
  CHECK_NEAR("cosine", cos(0.2), place.horizontal, 1e-6);
  CHECK_SAME("rad/s", 0.3f, place.azimuth.rate_rad_s);
  CHECK_SAME("rad/s", -0.01f, place.pitch.rate_rad_s);
}

/* What the joints would have to do follows from what the camera sees (pointing_tracker.h). */
static void test_from_beside_it_the_camera_sees_where_the_target_is_and_how_it_moves(void) {
  const pointing_target target = seen_at(1.0);
  const joint_vector joints = {.azimuth = (float)azimuth_rad(1.0), .pitch = (float)pitch_rad(1.0)};
  const target_path path = target_path_straight(joints, &target);
  const target_place place = target_path_at(&path, 0.0f);
  const float aside_rad = 0.05f;
  const float below_rad = joints.pitch - 0.02f;
  const rotation pitch = rotation_of((angle_turn32)angle_integer(below_rad / ANGLE_RAD_PER_TURN32));
  const pointing_target seen = target_path_seen(&place, aside_rad, pitch);
  const line_of_sight_turn turn = line_of_sight_turn_to(pitch, seen.error);
  CHECK_NEAR("azimuth, rad", aside_rad, turn.error_rad.azimuth, 1e-6);
  CHECK_NEAR("pitch, rad", 0.02, turn.error_rad.pitch, 1e-6);
  const double x = (double)(turn.image.cosine * seen.rate_rad_s.x - turn.image.sine * seen.rate_rad_s.y);
  const double y = (double)(turn.image.sine * seen.rate_rad_s.x + turn.image.cosine * seen.rate_rad_s.y);
  CHECK_NEAR("azimuth, rad/s", rate(azimuth_rad, 1.0), x / cos(pitch_rad(1.0)), 1e-4);
  CHECK_NEAR("pitch, rad/s", rate(pitch_rad, 1.0), y, 1e-4);
  const pointing_target centred =
      target_path_seen(&place, 0.0f, rotation_of((angle_turn32)angle_integer(joints.pitch / ANGLE_RAD_PER_TURN32)));
  CHECK_NEAR("rad/s^2", target.acceleration_rad_s2.x, centred.acceleration_rad_s2.x, 1e-3);
}

/* A target 0.2 beside and 0.1 above the line of sight, at rest and far from the horizon. */
static void test_a_target_beside_the_line_of_sight_is_where_the_image_shows_it(void) {
  const pointing_target target = {.error = {0.2f, 0.1f}};
  const target_path path = target_path_straight((joint_vector){.azimuth = -2.0f, .pitch = 0.6f}, &target);
  const double ahead = cos(0.6) - 0.1 * sin(0.6);
  const double up = sin(0.6) + 0.1 * cos(0.6);
  CHECK_NEAR("direction", 1.0,
             path.place[0] * path.place[0] + path.place[1] * path.place[1] + path.place[2] * path.place[2], 1e-6);
  const target_place place = target_path_at(&path, 3.0f);
  CHECK_NEAR("azimuth, rad", -2.0 + atan2(0.2, ahead), place.azimuth.angle_rad, 1e-6);
  CHECK_NEAR("pitch, rad", atan2(up, hypot(ahead, 0.2)), place.pitch.angle_rad, 1e-6);
  CHECK_NEAR("cosine", hypot(ahead, 0.2) / sqrt(1.05), place.horizontal, 1e-6);
  CHECK_SAME("azimuth, rad/s", 0.0, place.azimuth.rate_rad_s);
  CHECK_SAME("pitch, rad/s", 0.0, place.pitch.rate_rad_s);
}

/* Turned into the image axes at the target, rate and acceleration give back those of the joints (pointing_tracker.h).
 */
static void test_what_the_camera_sees_gives_back_the_motion_of_the_joints(void) {
  static const float asides_rad[] = {-0.3f, 0.0f, 0.2f, 1.2f};
  static const float pitches_rad[] = {-0.2f, 0.5f, 1.3f};
  const target_place place = {.azimuth = {1.0f, 0.3f, -0.4f}, .pitch = {0.8f, -0.2f, 0.5f}};
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 3; ++k) {
      const rotation pitch = rotation_of((angle_turn32)angle_integer(pitches_rad[k] / ANGLE_RAD_PER_TURN32));
      const pointing_target seen = target_path_seen(&place, asides_rad[i], pitch);
      const line_of_sight_turn turn = line_of_sight_turn_to(pitch, seen.error);
      CHECK_NEAR("azimuth, rad", asides_rad[i], turn.error_rad.azimuth, 1e-6);
      CHECK_NEAR("pitch, rad", 0.8f - pitches_rad[k], turn.error_rad.pitch, 1e-6);
      const double c = (double)turn.image.cosine;
      const double s = (double)turn.image.sine;
      const double x = c * (double)seen.rate_rad_s.x - s * (double)seen.rate_rad_s.y;
      const double y = s * (double)seen.rate_rad_s.x + c * (double)seen.rate_rad_s.y;
      CHECK_NEAR("azimuth, rad/s", 0.3, x / cos(0.8), 1e-6);
      CHECK_NEAR("pitch, rad/s", -0.2, y, 1e-6);
      const double ax = c * (double)seen.acceleration_rad_s2.x - s * (double)seen.acceleration_rad_s2.y;
      const double ay = s * (double)seen.acceleration_rad_s2.x + c * (double)seen.acceleration_rad_s2.y;
      CHECK_NEAR("azimuth, rad/s^2", -0.4, ax / cos(0.8) + 2.0 * 0.3 * -0.2 * tan(0.8), 2e-6);
      CHECK_NEAR("pitch, rad/s^2", 0.5, ay - 0.09 * sin(0.8) * cos(0.8), 2e-6);
    }
  }
}

/* At the zenith the azimuth has no rate: nearer than 1e-4 of the range the horizontal distance counts as that. */
static void test_in_the_zenith_everything_stays_finite(void) {
  target_path path = {.place = {0.0f, 0.0f, 1.0f}, .per_s = {0.01f, 0.0f, 0.0f}};
  target_place place = target_path_at(&path, 0.0f);
  CHECK_NEAR("pitch, rad", 1.5707963 - 1e-4, place.pitch.angle_rad, 1e-6);
  CHECK_NEAR("cosine", 1e-4, place.horizontal, 1e-9);
  CHECK_SAME("azimuth, rad/s", 0.0, place.azimuth.rate_rad_s);
  CHECK_SAME("azimuth, rad/s^2", 0.0, place.azimuth.acceleration_rad_s2);
  CHECK_SAME("pitch, rad/s", 0.0, place.pitch.rate_rad_s);
  path = (target_path){.place = {0.5e-4f, 0.0f, 1.0f}, .per_s = {0.0f, 0.01f, 0.0f}};
  place = target_path_at(&path, 0.0f);
  CHECK_NEAR("azimuth, rad/s", 0.5e-4 * 0.01 / 1e-8, place.azimuth.rate_rad_s, 1e-3);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_straight_path_is_that_of_the_target);
  RUN_TEST(test_a_path_round_the_tracker_keeps_both_rates_for_more_than_a_turn);
  RUN_TEST(test_from_beside_it_the_camera_sees_where_the_target_is_and_how_it_moves);
  RUN_TEST(test_a_target_beside_the_line_of_sight_is_where_the_image_shows_it);
  RUN_TEST(test_what_the_camera_sees_gives_back_the_motion_of_the_joints);
  RUN_TEST(test_in_the_zenith_everything_stays_finite);
  return UNITY_END();
}
