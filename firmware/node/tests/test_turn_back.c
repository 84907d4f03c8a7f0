/* SPDX-License-Identifier: Apache-2.0 */
/* Turning back by one revolution at the end of the travel, by itself: joints that do what is expected of them at once,
 * and a target that is given as what has been estimated of it. */
#include "node/turn_back.h"

#include <string.h>

#include "base/scalar.h"
#include "support/check.h"

#define TURN_RAD 6.283185307179586

static turn_back turn;
static pointing line_of_sight;
static pointing_motion motion;
static target_return_limits limits;
static joint_vector joint_rad;
static uint32_t tick;

void setUp(void) {
  memset(&line_of_sight, 0, sizeof line_of_sight);
  motion = (pointing_motion){0};
  turn_back_reset(&turn);
  limits = (target_return_limits){.proportional_per_s = 30.0f,
                                  .rate_limit_rad_s = {1.0f, 0.5f},
                                  .acceleration_limit_rad_s2 = {1.0f, 1.0f},
                                  .azimuth_travel = {-4.0f, 4.0f}};
  joint_rad = (joint_vector){0};
  tick = 1000;
}

void tearDown(void) {}

/* One tick with the target at these joint angles. */
static void step(bool allowed, bool seen, joint_vector target_rad) {
  const turn_back_inputs inputs = {
      .allowed = allowed,
      .seen = seen,
      .tick = tick,
      .joint_rad = joint_rad,
      .error_rad = {target_rad.azimuth - joint_rad.azimuth, target_rad.pitch - joint_rad.pitch},
      .limits = &limits};
  motion.pitch = rotation_of((angle_turn32)angle_integer(joint_rad.pitch / ANGLE_RAD_PER_TURN32));
  turn_back_step(&turn, &line_of_sight, &motion, &inputs);
  ++tick;
}

/* The joints follow the target from `from_rad` on, as far as the azimuth may, until it is past the end of the travel or
 * time is over. Returns where the target is. */
static double follow(bool allowed, double from_rad, double rate_rad_s, int ticks) {
  double azimuth_rad = from_rad;
  for (int i = 0; i < ticks && !turn.running; ++i) {
    azimuth_rad = from_rad + 1e-3 * rate_rad_s * (double)i;
    joint_rad.azimuth = joint_travel_clamp(&limits.azimuth_travel, (float)azimuth_rad);
    joint_rad.pitch = 0.3f;
    const pointing_target estimated = {.error = {.x = ((float)azimuth_rad - joint_rad.azimuth) * cosf(0.3f)},
                                       .rate_rad_s = {.x = (float)rate_rad_s * cosf(0.3f)}};
    pointing_tracker_assume(&line_of_sight.tracker, &estimated);
    step(allowed, true, (joint_vector){(float)azimuth_rad, 0.3f});
  }
  return azimuth_rad;
}

static void test_it_begins_a_milliradian_outside_of_the_travel(void) {
  for (int side = -1; side <= 1; side += 2) {
    setUp();
    const double end_rad = follow(true, side * 3.7, side * 0.2, 3000);
    TEST_ASSERT_TRUE(turn.running);
    CHECK_NEAR("rad", side * 4.001, end_rad, 3e-4);
    CHECK_SAME("direction", -side, turn.direction);
    TEST_ASSERT_TRUE(turn_back_is_outside(&turn, &limits.azimuth_travel));
    TEST_ASSERT_EQUAL(tick - 1, turn.begun);
    TEST_ASSERT_FALSE(turn.path.round); /* followed for less than half a turn */
    TEST_ASSERT_TRUE(turn.expected.locked && turn.expected.limited);
    CHECK_NEAR("azimuth at its limit, rad/s", -side * 1.0, turn.expected.reference[SERVO_AZIMUTH].rate_rad_s, 1e-6);
    CHECK_NEAR("the longer turn, rad", side * (4.001 - TURN_RAD - 4.0), turn.expected.error_of_joints_rad.azimuth,
               1e-3);
    CHECK_NEAR("across, rad", side * (4.001 - TURN_RAD - 4.0) * cos(0.3), turn.expected.error_rad.x, 1e-2);
  }
}

/* The ticks wrap after 49.7 days, here between the two marks that give the target's rate. */
static void test_it_begins_as_early_when_the_ticks_wrap(void) {
  tick = UINT32_MAX - TURN_BACK_MARK_TICKS / 2;
  const double end_rad = follow(true, 4.0 - 0.2e-3 * 1.5 * TURN_BACK_MARK_TICKS, 0.2, 3000);
  TEST_ASSERT_TRUE(turn.running);
  CHECK_NEAR("rad", 4.001, end_rad, 3e-4);
}

static void test_it_does_not_begin_where_nothing_is_gained(void) {
  static const struct {
    const char *what;
    bool allowed;
    double from_rad;
    double rate_rad_s;
    bool outside;
  } rows[] = {
      {"not allowed", false, 3.7, 0.2, true},
      {"stays within the travel", true, 3.0, 0.2, false},
      {"comes back from outside", true, 4.9, -0.2, true},
      {"a rate is not known yet", true, 4.1, 0.2, true},
  };
  for (unsigned i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    setUp();
    const bool short_time = i == 3;
    (void)follow(rows[i].allowed, rows[i].from_rad, rows[i].rate_rad_s, short_time ? TURN_BACK_MARK_TICKS : 3000);
    TEST_ASSERT_FALSE_MESSAGE(turn.running, rows[i].what);
    TEST_ASSERT_EQUAL_MESSAGE(rows[i].outside, turn_back_is_outside(&turn, &limits.azimuth_travel), rows[i].what);
    TEST_ASSERT_FALSE_MESSAGE(turn.expected.locked, rows[i].what);
  }
  setUp();
  (void)follow(true, 4.1, 0.2, TURN_BACK_MARK_TICKS + 1);
  TEST_ASSERT_TRUE(turn.running); /* the second mark gives the rate */
}

/* 4 s after the target was acquired it becomes known that the azimuth is a turn further, where the target is outside.
 */
static void test_a_turn_that_is_found_is_no_motion_of_the_target(void) {
  const double end_rad = follow(true, 3.7 - TURN_RAD, 0.2, 4000);
  TEST_ASSERT_FALSE(turn.running);
  (void)follow(true, end_rad + TURN_RAD, 0.2, 1);
  TEST_ASSERT_TRUE(turn.running);
  TEST_ASSERT_FALSE(turn.path.round);
  const target_mark *marks = turn.marks;
  const double passed_s = 1e-3 * (double)(turn.now.at - marks[0].at);
  CHECK_NEAR("rad/s", 0.2, (double)(turn.now.angle_rad.azimuth - marks[0].angle_rad.azimuth) / passed_s, 1e-3);
}

static void test_without_another_angle_within_the_travel_it_stays(void) {
  limits.azimuth_travel = (joint_travel){-1.0f, 4.0f};
  (void)follow(true, 3.7, 0.2, 3000);
  TEST_ASSERT_FALSE(turn.running);
}

/* By half a turn it is known that the target goes round the tracker: then both joints are expected to keep their mean
 * rates. */
static void test_after_half_a_turn_the_target_is_taken_to_go_round(void) {
  static const double from_rad[] = {4.0 - 3.10, 4.0 - 3.18};
  for (int i = 0; i < 2; ++i) {
    setUp();
    (void)follow(true, from_rad[i], 0.3, 12000);
    TEST_ASSERT_TRUE(turn.running);
    TEST_ASSERT_EQUAL(i == 1, turn.path.round);
  }
  CHECK_NEAR("azimuth, rad/s", 0.3, turn.path.rate_rad_s.azimuth, 1e-3);
  CHECK_NEAR("pitch, rad/s", 0.0, turn.path.rate_rad_s.pitch, 1e-3);
  CHECK_NEAR("azimuth, rad", 4.001, turn.path.angle_rad.azimuth, 3e-4);
  CHECK_NEAR("pitch, rad", 0.3, turn.path.angle_rad.pitch, 1e-6);
}

/* The rates are means over one to two intervals of marks, so an older rate is forgotten. */
static void test_the_rate_is_that_of_the_last_second(void) {
  (void)follow(true, 0.5, 0.1, 1000);
  (void)follow(true, 0.6, 0.6, 12000);
  TEST_ASSERT_TRUE(turn.running && turn.path.round);
  CHECK_NEAR("azimuth, rad/s", 0.6, turn.path.rate_rad_s.azimuth, 1e-3);
}

/* Both joints do what is expected. 1 rad/s against 0.3 rad/s of the target: 4.83 s, but for the braking at the end. */
static void test_it_ends_before_the_target_and_the_loop_goes_on_from_there(void) {
  (void)follow(true, 0.5, 0.3, 13000);
  TEST_ASSERT_TRUE(turn.running && turn.path.round);
  joint_rad.pitch = 0.25f; /* a pitch that must follow as well */
  line_of_sight.tracker.along[0].locked = line_of_sight.tracker.along[1].locked = true;
  int ticks = 0;
  while (turn.running && ticks < 20000) {
    joint_rad.azimuth += turn.expected.reference[SERVO_AZIMUTH].rate_rad_s * 1e-3f;
    joint_rad.pitch += turn.expected.reference[SERVO_PITCH].rate_rad_s * 1e-3f;
    line_of_sight.tracker.along[0].ticks_since_frame = ++ticks;
    step(true, false, (joint_vector){0});
    if (turn.running) {
      TEST_ASSERT_FALSE(line_of_sight.tracker.along[0].locked || line_of_sight.tracker.along[1].locked);
      TEST_ASSERT_EQUAL(-1, line_of_sight.known_ticks);
    }
  }
  CHECK_NEAR("s", TURN_RAD / 1.3, 1e-3 * ticks, 0.5);
  const double target_rad = 4.001 + 0.3 * 1e-3 * ticks - TURN_RAD;
  CHECK_NEAR("distance, rad", (double)TURN_BACK_NEAR_RAD, fabs(target_rad - (double)joint_rad.azimuth), 5e-3);
  CHECK_NEAR("pitch, rad", 0.3, joint_rad.pitch, 1e-4);
  CHECK_NEAR("absence, s", 1e-3 * ticks, turn.absence_s, 1e-6);
  TEST_ASSERT_FALSE(turn.expected.locked || turn.follows);
  TEST_ASSERT_TRUE(line_of_sight.tracker.along[0].locked && line_of_sight.tracker.along[1].locked);
  const pointing_target expected = pointing_tracker_target(&line_of_sight.tracker);
  CHECK_NEAR("across, rad", (target_rad - (double)joint_rad.azimuth) * cos(0.3), expected.error.x, 1e-3);
  CHECK_NEAR("rate across, rad/s", 0.3 * cos(0.3), expected.rate_rad_s.x, 3e-3);
  line_of_sight.tracker.along[0].ticks_since_frame = 7;
  step(true, true, (joint_vector){(float)target_rad, 0.3f});
  CHECK_NEAR("it may still be absent, s", 1e-3 * ticks, turn.absence_s, 1e-6);
  line_of_sight.tracker.along[0].ticks_since_frame = 0;
  step(true, true, (joint_vector){(float)target_rad, 0.3f});
  CHECK_SAME("seen again, s", 0.0, turn.absence_s);
}

/* At 1 rad/s^2 it can stop from 0.63 rad/s in 0.2 rad. */
static void test_the_pitch_approaches_as_fast_as_it_can_brake(void) {
  for (int side = -1; side <= 1; side += 2) {
    setUp();
    limits.rate_limit_rad_s.pitch = 10.0f;
    (void)follow(true, 3.7, 0.2, 3000);
    TEST_ASSERT_TRUE(turn.running);
    joint_rad.pitch = 0.3f - 0.2f * (float)side;
    step(true, false, (joint_vector){0});
    CHECK_NEAR("rad/s", side * 0.63, turn.expected.reference[SERVO_PITCH].rate_rad_s, 0.02);
  }
}

static void test_a_turn_ends_when_it_is_no_longer_allowed_and_a_lost_target_is_forgotten(void) {
  (void)follow(true, 3.7, 0.2, 3000);
  TEST_ASSERT_TRUE(turn.running);
  step(true, false, (joint_vector){0});
  TEST_ASSERT_TRUE(turn.running);
  step(false, false, (joint_vector){0});
  TEST_ASSERT_FALSE(turn.running || turn.follows || turn.expected.locked);
  setUp();
  (void)follow(true, 3.0, 0.2, 100);
  TEST_ASSERT_TRUE(turn.follows);
  CHECK_NEAR("acquired, rad", 3.0, turn.acquired_rad, 1e-6);
  step(true, false, (joint_vector){0});
  TEST_ASSERT_FALSE(turn.follows);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_it_begins_a_milliradian_outside_of_the_travel);
  RUN_TEST(test_it_begins_as_early_when_the_ticks_wrap);
  RUN_TEST(test_it_does_not_begin_where_nothing_is_gained);
  RUN_TEST(test_a_turn_that_is_found_is_no_motion_of_the_target);
  RUN_TEST(test_without_another_angle_within_the_travel_it_stays);
  RUN_TEST(test_after_half_a_turn_the_target_is_taken_to_go_round);
  RUN_TEST(test_the_rate_is_that_of_the_last_second);
  RUN_TEST(test_it_ends_before_the_target_and_the_loop_goes_on_from_there);
  RUN_TEST(test_the_pitch_approaches_as_fast_as_it_can_brake);
  RUN_TEST(test_a_turn_ends_when_it_is_no_longer_allowed_and_a_lost_target_is_forgotten);
  return UNITY_END();
}
