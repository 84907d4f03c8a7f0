/* SPDX-License-Identifier: Apache-2.0 */
/* The time until both axes are back on a target: a target at rest, and predictions that run one step in each tick. */
#include "node/return_prediction.h"

#include <string.h>

#include "support/check.h"

static return_prediction prediction;
static pointing line_of_sight;
static pointing_motion motion;
static pointing_output target;
static turn_back turn;
static joint_vector joint_rad;
static target_return_limits limits;

void setUp(void) {
  memset(&prediction, 0, sizeof prediction);
  memset(&line_of_sight, 0, sizeof line_of_sight);
  memset(&turn, 0, sizeof turn);
  motion = (pointing_motion){0};
  target = (pointing_output){.locked = true};
  joint_rad = (joint_vector){0};
  limits = (target_return_limits){
      .proportional_per_s = 30.0f, .rate_limit_rad_s = {1.0f, 0.5f}, .acceleration_limit_rad_s2 = {1e4f, 1e4f}};
}

void tearDown(void) {}

static uint16_t step(uint32_t tick) {
  const return_prediction_inputs inputs = {
      .line_of_sight = &line_of_sight, .motion = &motion, .target = &target, .turn = &turn, .joint_rad = joint_rad};
  return return_prediction_step(&prediction, &limits, &inputs, tick);
}

/* 0.5 rad beside the line of sight, at rest: the azimuth is back after 0.467 s at its limit, and 0.1 s of the loop. */
static void show_target_aside(void) {
  const pointing_target aside = {.error = {.x = tanf(0.5f)}};
  pointing_tracker_assume(&line_of_sight.tracker, &aside);
  target.limited = true;
  target.error_rad.x = 0.5f;
}

static void test_on_the_target_there_is_nothing_to_wait_for(void) {
  TEST_ASSERT_EQUAL(0, step(5));
  CHECK_SAME("absence, s", 0.0, return_prediction_absence_s(&prediction));
  target.error_rad = (image_vector){1e-3f, -1e-3f};
  TEST_ASSERT_EQUAL(0, step(6));
}

static void test_the_axes_are_late_beside_the_target_or_faster_than_a_limit(void) {
  static const struct {
    const char *what;
    pointing_output target;
    uint16_t back_in_ms;
  } rows[] = {
      {"1.1 mrad beside it", {.locked = true, .error_rad = {1.1e-3f, 0.0f}}, RETURN_UNKNOWN},
      {"1.1 mrad above it", {.locked = true, .error_rad = {0.0f, -1.1e-3f}}, RETURN_UNKNOWN},
      {"limited", {.locked = true, .limited = true}, RETURN_UNKNOWN},
      {"azimuth at its limit", {.locked = true, .reference = {{.rate_rad_s = 1.0f}, {.rate_rad_s = 0.0f}}}, 0},
      {"azimuth", {.locked = true, .reference = {{.rate_rad_s = -1.01f}, {.rate_rad_s = 0.0f}}}, RETURN_UNKNOWN},
      {"pitch at its limit", {.locked = true, .reference = {{.rate_rad_s = 0.0f}, {.rate_rad_s = -0.5f}}}, 0},
      {"pitch", {.locked = true, .reference = {{.rate_rad_s = 0.0f}, {.rate_rad_s = 0.51f}}}, RETURN_UNKNOWN},
      {"no target", {.locked = false, .limited = true, .error_rad = {0.5f, 0.0f}}, 0},
  };
  for (unsigned i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    setUp();
    target = rows[i].target;
    TEST_ASSERT_EQUAL_MESSAGE(rows[i].back_in_ms, step(1), rows[i].what);
    TEST_ASSERT_EQUAL_MESSAGE(rows[i].back_in_ms != 0, prediction.late, rows[i].what);
  }
}

/* A prediction of 57 steps and 20 on the target has its answer in the 77th tick; the next one begins at once. */
static void test_the_time_counts_down_to_the_return(void) {
  show_target_aside();
  uint32_t tick = 1000;
  while (step(tick) == RETURN_UNKNOWN) {
    CHECK_SAME("absence while nothing is known, s", 0.0, return_prediction_absence_s(&prediction));
    TEST_ASSERT_TRUE(++tick < 1100);
  }
  TEST_ASSERT_INT_WITHIN(4, 1000 + 76, (int)tick);
  const uint32_t back_at = prediction.back_at;
  TEST_ASSERT_INT_WITHIN(30, 1000 + 567, (int)back_at);
  CHECK_NEAR("absence, s", 1e-3 * (back_at - 1000), return_prediction_absence_s(&prediction), 1e-6);
  target.limited = false; /* no further prediction */
  TEST_ASSERT_EQUAL(back_at - tick - 1, step(tick + 1));
  TEST_ASSERT_EQUAL(back_at - tick - 100, step(tick + 100));
  TEST_ASSERT_EQUAL(2, step(back_at - 2));
  TEST_ASSERT_EQUAL(1, step(back_at - 1));
  TEST_ASSERT_EQUAL(1, step(back_at)); /* not yet within 1 mrad */
  TEST_ASSERT_EQUAL(1, step(back_at + 50));
  target.error_rad.x = 0.0f;
  TEST_ASSERT_EQUAL(0, step(back_at + 51));
  CHECK_SAME("absence, s", 0.0, return_prediction_absence_s(&prediction));
}

static void test_a_later_prediction_replaces_the_one_before_and_the_absence_goes_on(void) {
  show_target_aside();
  uint32_t tick = 1000;
  while (step(tick) == RETURN_UNKNOWN) {
    ++tick;
  }
  const uint32_t first = prediction.back_at;
  for (int i = 0; i < 70; ++i) { /* the answer before counts until the next one is found */
    ++tick;
    TEST_ASSERT_EQUAL(first - tick, step(tick));
  }
  while (tick < 1200) { /* the target has not come nearer */
    (void)step(++tick);
  }
  TEST_ASSERT_INT_WITHIN(4, 77, (int)(prediction.back_at - first));
  TEST_ASSERT_EQUAL(1000, prediction.since);
  CHECK_NEAR("absence, s", 1e-3 * (prediction.back_at - 1000), return_prediction_absence_s(&prediction), 1e-6);
}

static void test_a_prediction_without_a_return_leaves_the_time_unknown(void) {
  show_target_aside();
  for (uint32_t tick = 0; tick < 100; ++tick) {
    (void)step(tick);
  }
  TEST_ASSERT_TRUE(prediction.known);
  turn.running = true; /* round the tracker, faster than the azimuth may turn */
  turn.path = target_path_round((joint_vector){0}, (joint_vector){.azimuth = 2.0f});
  for (uint32_t tick = 100; tick < 2000; ++tick) {
    (void)step(tick);
  }
  TEST_ASSERT_EQUAL(RETURN_UNKNOWN, step(2000));
  CHECK_SAME("absence, s", 0.0, return_prediction_absence_s(&prediction));
}

static void test_a_target_that_is_reached_ends_the_prediction_and_the_next_one_begins_anew(void) {
  show_target_aside();
  for (uint32_t tick = 0; tick < 10; ++tick) {
    (void)step(tick);
  }
  target = (pointing_output){.locked = true};
  TEST_ASSERT_EQUAL(0, step(10));
  show_target_aside();
  (void)step(500);
  TEST_ASSERT_EQUAL(500, prediction.begun);
  TEST_ASSERT_EQUAL(500, prediction.since);
  TEST_ASSERT_EQUAL(1, prediction.ahead.steps);
}

/* While the azimuth turns back the path is that of the turn, since its begin, in its direction. In the first step, of
 * 10 ms, the joints change their rates by what they can. */
static void test_during_a_turn_back_the_target_goes_on_along_its_path(void) {
  show_target_aside();
  turn.running = true;
  turn.path = target_path_round((joint_vector){.azimuth = 0.2f}, (joint_vector){.azimuth = 0.1f});
  turn.begun = 500;
  turn.direction = -1.0f;
  limits.acceleration_limit_rad_s2 = (joint_vector){1.0f, 1.0f};
  motion.inertial_rad_s = (joint_vector){-0.7f, 0.2f};
  joint_rad = (joint_vector){.azimuth = 3.0f, .pitch = 0.4f};
  (void)step(1500);
  CHECK_NEAR("azimuth, rad", 3.0, prediction.ahead.now.joint_rad.azimuth, 0.02); /* after a step */
  CHECK_NEAR("pitch, rad", 0.4, prediction.ahead.now.joint_rad.pitch, 0.02);
  CHECK_NEAR("path, s", 1.0, prediction.ahead.now.path_s, 1e-6);
  TEST_ASSERT_TRUE(prediction.ahead.now.path.round);
  CHECK_SAME("direction", -1.0, prediction.ahead.now.direction);
  CHECK_NEAR("azimuth, rad/s", -0.71, prediction.ahead.now.joint_rad_s.azimuth, 1e-6);
  CHECK_NEAR("pitch, rad/s", 0.19, prediction.ahead.now.joint_rad_s.pitch, 1e-6);
  turn.running = false;
  setUp();
  show_target_aside();
  motion.inertial_rad_s = (joint_vector){-0.7f, 0.2f};
  joint_rad = (joint_vector){.azimuth = -2.0f, .pitch = 0.3f};
  (void)step(1500);
  CHECK_NEAR("azimuth, rad", -2.0, prediction.ahead.now.joint_rad.azimuth, 0.02);
  CHECK_NEAR("pitch, rad", 0.3, prediction.ahead.now.joint_rad.pitch, 0.02);
  TEST_ASSERT_FALSE(prediction.ahead.now.path.round);
  CHECK_SAME("path, s", 0.0, prediction.ahead.now.path_s);
  CHECK_SAME("direction", 0.0, prediction.ahead.now.direction);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_on_the_target_there_is_nothing_to_wait_for);
  RUN_TEST(test_the_axes_are_late_beside_the_target_or_faster_than_a_limit);
  RUN_TEST(test_the_time_counts_down_to_the_return);
  RUN_TEST(test_a_later_prediction_replaces_the_one_before_and_the_absence_goes_on);
  RUN_TEST(test_a_prediction_without_a_return_leaves_the_time_unknown);
  RUN_TEST(test_a_target_that_is_reached_ends_the_prediction_and_the_next_one_begins_anew);
  RUN_TEST(test_during_a_turn_back_the_target_goes_on_along_its_path);
  return UNITY_END();
}
