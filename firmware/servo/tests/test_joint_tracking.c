/* SPDX-License-Identifier: Apache-2.0 */
/* Each joint follows the target by its own loop, from frames with the errors of both. */
#include "servo/joint_tracking.h"

#include "support/check.h"

static joint_tracking joints;
static servo_app app;
static servo_target targets[SERVO_AXES];

/* Azimuth by the paper's loop, pitch by the predictive one. */
void setUp(void) {
  joint_tracking_reset(&joints);
  app = (servo_app){0};
  app.params.axis[SERVO_AZIMUTH].tracker = (target_tracker_params){.kind = TRACKER_PI,
                                                                   .proportional_per_s = 2.0f,
                                                                   .estimator_rad_s = 3.0f,
                                                                   .rate_limit_rad_s = 0.5f,
                                                                   .coast_s = 0.1f};
  app.params.axis[SERVO_PITCH].tracker = (target_tracker_params){.kind = TRACKER_PREDICTIVE,
                                                                 .proportional_per_s = 30.0f,
                                                                 .estimator_rad_s = 3.0f,
                                                                 .rate_limit_rad_s = 0.5f,
                                                                 .coast_s = 0.1f};
}
void tearDown(void) {}

static void step(joint_frame frame) { joint_tracking_step(&joints, &app, &frame, targets); }

static void test_each_joint_has_its_error_its_loop_and_its_gain(void) {
  step((joint_frame){.fresh = true, .valid = true, .error_rad = {.azimuth = 1e-3f, .pitch = -2e-3f}});
  TEST_ASSERT_TRUE(targets[SERVO_AZIMUTH].known && targets[SERVO_PITCH].known);
  CHECK_SAME("rad", 1e-3f, targets[SERVO_AZIMUTH].error_rad);
  CHECK_SAME("rad", -2e-3f, targets[SERVO_PITCH].error_rad);
  CHECK_NEAR("rad/s", 2e-3, targets[SERVO_AZIMUTH].reference.rate_rad_s, 1e-8);
  CHECK_NEAR("rad/s", -0.06, targets[SERVO_PITCH].reference.rate_rad_s, 1e-7);
  CHECK_SAME("1/s", 2.0, targets[SERVO_AZIMUTH].proportional_per_s);
  CHECK_SAME("1/s", 30.0, targets[SERVO_PITCH].proportional_per_s);
  for (int i = 0; i < SERVO_AXES; ++i) {
    CHECK_SAME("Nm", 0.0, targets[i].torque_nm);
    TEST_ASSERT_EQUAL(0, targets[i].frame_age_ticks);
  }
  step((joint_frame){0});
  TEST_ASSERT_EQUAL(1, targets[SERVO_PITCH].frame_age_ticks);
}

/* A pitch that turns at 0.1 rad/s has turned by 2 mrad since an exposure 20 ms ago. */
static void test_an_age_is_made_up_for_by_the_motion_since_the_exposure(void) {
  app.axis[SERVO_PITCH].signals.rates.rate_rad_s = 0.1f;
  for (int i = 0; i < TARGET_TRACKER_HISTORY; ++i) {
    step((joint_frame){0});
  }
  step((joint_frame){.fresh = true, .valid = true, .age_ticks = 20, .error_rad = {.pitch = 3e-3f}});
  CHECK_NEAR("rad", 1e-3, targets[SERVO_PITCH].error_rad, 1e-7);
}

/* The predictive loop takes a part of a frame that differs from what it expects; the error says all of it. */
static void test_the_error_is_that_of_the_last_frame(void) {
  for (int tick = 0; tick < 200; ++tick) {
    step((joint_frame){.fresh = tick % 20 == 0, .valid = true, .error_rad = {.pitch = 1e-3f}});
  }
  CHECK_NEAR("rad", 1e-3, targets[SERVO_PITCH].error_rad, 1e-6);
  step((joint_frame){.fresh = true, .valid = true, .error_rad = {.pitch = 2e-3f}});
  CHECK_NEAR("rad", 2e-3, targets[SERVO_PITCH].error_rad, 1e-6);
  TEST_ASSERT_TRUE(joints.axis[SERVO_PITCH].error_rad < 1.5e-3f);
}

/* While both axes track together, their motion is remembered, so that one may go on alone at once. */
static void test_motion_is_remembered_and_the_target_is_not(void) {
  step((joint_frame){.fresh = true, .valid = true, .error_rad = {.pitch = 1e-3f}});
  app.axis[SERVO_PITCH].signals.rates.rate_rad_s = 0.1f;
  for (int i = 0; i < TARGET_TRACKER_HISTORY; ++i) {
    joint_tracking_remember(&joints, &app);
  }
  step((joint_frame){0});
  TEST_ASSERT_FALSE(targets[SERVO_PITCH].known);
  step((joint_frame){.fresh = true, .valid = true, .age_ticks = 10, .error_rad = {.pitch = 3e-3f}});
  CHECK_NEAR("rad", 2e-3, targets[SERVO_PITCH].error_rad, 1e-7);
}

static void test_a_target_is_coasted_and_can_be_lost_on_purpose(void) {
  for (int way = 0; way < 2; ++way) {
    setUp();
    step((joint_frame){.fresh = true, .valid = true, .error_rad = {.azimuth = 1e-3f, .pitch = 1e-3f}});
    if (way == 0) {
      joint_tracking_lose(&joints);
    }
    int known_ticks = 0;
    for (int i = 0; i < 200; ++i) {
      step((joint_frame){0});
      known_ticks += targets[SERVO_PITCH].known ? 1 : 0;
    }
    TEST_ASSERT_INT_WITHIN(1, way == 0 ? 0 : 100, known_ticks); /* coast_s */
    CHECK_SAME("rad/s", 0.0, targets[SERVO_AZIMUTH].reference.rate_rad_s);
    CHECK_SAME("rad/s", 0.0, targets[SERVO_PITCH].reference.rate_rad_s);
  }
}

/* Within 0.02 rad/s of the rate at which it began, up to 600 ticks; not while the axis itself tracks. */
static void test_a_joint_is_steady_while_its_rate_stays(void) {
  const joint_steadiness *steady = &joints.steady[SERVO_PITCH];
  float *rate_rad_s = &app.axis[SERVO_PITCH].signals.rates.rate_rad_s;
  for (int side = -1; side <= 1; side += 2) {
    *rate_rad_s = 0.1f;
    step((joint_frame){0});
    TEST_ASSERT_EQUAL(0, steady->ticks);
    CHECK_SAME("rad/s", 0.1f, steady->rate_rad_s);
    *rate_rad_s = 0.1f + 0.019f * (float)side;
    for (int tick = 1; tick < JOINT_STEADY_TICKS + 2; ++tick) {
      step((joint_frame){0});
      TEST_ASSERT_EQUAL(tick < JOINT_STEADY_TICKS ? tick : JOINT_STEADY_TICKS, steady->ticks);
    }
    CHECK_SAME("where it began, rad/s", 0.1f, steady->rate_rad_s);
    *rate_rad_s = 0.1f + 0.021f * (float)side;
    step((joint_frame){0});
    TEST_ASSERT_EQUAL(0, steady->ticks);
    CHECK_SAME("rad/s", *rate_rad_s, steady->rate_rad_s);
  }
  CHECK_SAME("the other joint, rad/s", 0.0, joints.steady[SERVO_AZIMUTH].rate_rad_s);
  joints.tracks[SERVO_PITCH] = true;
  for (int tick = 0; tick < 10; ++tick) {
    step((joint_frame){0});
  }
  TEST_ASSERT_EQUAL(0, steady->ticks);
}

static void test_a_reset_leaves_no_axis_that_tracks_and_no_motion(void) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    joints.tracks[i] = true;
    joints.steady[i] = (joint_steadiness){.rate_rad_s = 0.1f, .ticks = 7};
    joints.axis[i].locked = true;
  }
  joint_tracking_reset(&joints);
  for (int i = 0; i < SERVO_AXES; ++i) {
    TEST_ASSERT_FALSE(joints.tracks[i]);
    CHECK_SAME("rad/s", 0.0, joints.steady[i].rate_rad_s);
    TEST_ASSERT_EQUAL(0, joints.steady[i].ticks);
    TEST_ASSERT_FALSE(joints.axis[i].locked);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_each_joint_has_its_error_its_loop_and_its_gain);
  RUN_TEST(test_an_age_is_made_up_for_by_the_motion_since_the_exposure);
  RUN_TEST(test_the_error_is_that_of_the_last_frame);
  RUN_TEST(test_motion_is_remembered_and_the_target_is_not);
  RUN_TEST(test_a_target_is_coasted_and_can_be_lost_on_purpose);
  RUN_TEST(test_a_joint_is_steady_while_its_rate_stays);
  RUN_TEST(test_a_reset_leaves_no_axis_that_tracks_and_no_motion);
  return UNITY_END();
}
