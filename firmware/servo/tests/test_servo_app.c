/* SPDX-License-Identifier: Apache-2.0 */
/* Both axes together: what the pitch's angle makes of the azimuth. */
#include "servo/servo_app.h"

#include "support/servo_bench.h"

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

#define DEG (3.141592653589793 / 180.0)

static angle_turn32 turn32(double angle_rad) {
  return (angle_turn32)(int64_t)llround(angle_rad * 4294967296.0 / 6.283185307179586);
}

static servo_axis_params azimuth(float largest_kg_m2, float min_kg_m2, gyro_mounting gyro) {
  servo_axis_params params = bench_at_rest().params;
  params.plant_inertia_kg_m2 = largest_kg_m2;
  params.min_inertia_kg_m2 = min_kg_m2;
  params.gyro = gyro;
  params.tracker.estimator_rad_s = 4.0f;
  return params;
}

static void test_the_share_of_the_inertia_is_that_of_j0_and_j1(void) {
  const servo_axis_params params = azimuth(6.0f, 3.0f, GYRO_ON_AXIS);
  for (double pitch = -100.0; pitch <= 180.0; pitch += 2.5) {
    const double cosine = cos(pitch * DEG);
    const speed_loop_pose pose = servo_azimuth_pose(&params, rotation_cosine(turn32(pitch * DEG)));
    CHECK_NEAR("share", (3.0 + 3.0 * cosine * cosine) / 6.0, pose.inertia_share, 2e-7);
    CHECK_SAME("gyro", 1.0, pose.gyro_share);
  }
}

static void test_a_gyro_on_the_line_of_sight_measures_the_cosine_of_the_pitch(void) {
  const servo_axis_params params = azimuth(6.0f, 3.0f, GYRO_ON_LINE_OF_SIGHT);
  for (double pitch = -100.0; pitch <= 180.0; pitch += 2.5) {
    CHECK_NEAR("gyro", cos(pitch * DEG), servo_azimuth_pose(&params, rotation_cosine(turn32(pitch * DEG))).gyro_share,
               2e-7);
  }
}

/* Never a gain of zero, never one above the parameters. */
static void test_an_inertia_that_makes_no_sense_changes_little_or_nothing(void) {
  const servo_axis_params growing = azimuth(3.0f, 6.0f, GYRO_ON_AXIS);
  CHECK_SAME("grows", 1.0, servo_azimuth_pose(&growing, rotation_cosine(turn32(90.0 * DEG))).inertia_share);
  const servo_axis_params vanishing = azimuth(1e5f, 1e-9f, GYRO_ON_AXIS);
  CHECK_NEAR("vanishes", 1e-3, servo_azimuth_pose(&vanishing, rotation_cosine(turn32(90.0 * DEG))).inertia_share, 1e-6);
}

/* --- in the tick -------------------------------------------------------------------------------------------------- */

static servo_app app;
static servo_samples samples;
static servo_command command;

static void start_at(double pitch_deg) {
  servo_params params = {.axis = {azimuth(6.0f, 3.0f, GYRO_ON_AXIS), azimuth(2.5f, 1.0f, GYRO_ON_AXIS)}};
  samples = (servo_samples){.bus_voltage_v = 48.0f};
  command = (servo_command){0};
  samples.axis[SERVO_PITCH].sensors.joint_angle_turn32 = turn32(pitch_deg * DEG);
  servo_samples_complete(&samples);
  CHECK_STATUS(CONTROL_OK, servo_app_configure(&app, &params, &samples));
}

/* On the base, and on the azimuth stage; the parameters of both axes say so. */
static void test_a_gyro_below_its_joint_is_one_in_both_axes(void) {
  const gyro_mounting mountings[] = {GYRO_ON_AXIS, GYRO_BELOW_JOINT, GYRO_ON_LINE_OF_SIGHT};
  for (int i = 0; i < 3; ++i) {
    servo_params params = {.axis = {azimuth(6.0f, 3.0f, mountings[i]), azimuth(2.5f, 1.0f, mountings[i])}};
    samples = (servo_samples){.bus_voltage_v = 48.0f};
    servo_samples_complete(&samples);
    CHECK_STATUS(CONTROL_OK, servo_app_configure(&app, &params, &samples));
    TEST_ASSERT_EQUAL(mountings[i] == GYRO_BELOW_JOINT, app.axis[SERVO_PITCH].pose.gyro_below);
    servo_app_tick(&app, &command, &samples);
    for (int axis = 0; axis < SERVO_AXES; ++axis) {
      TEST_ASSERT_EQUAL(mountings[i] == GYRO_BELOW_JOINT, app.axis[axis].speed.pose.gyro_below);
      CHECK_SAME("of the joint's rate", mountings[i] == GYRO_BELOW_JOINT ? 1.0 : 0.0,
                 app.axis[axis].speed.gyro.of_joint);
    }
    app.params.axis[SERVO_PITCH].gyro = GYRO_BELOW_JOINT; /* other parameters, from the next tick on */
    servo_app_tick(&app, &command, &samples);
    TEST_ASSERT_TRUE(app.axis[SERVO_PITCH].pose.gyro_below);
  }
}

static double share_after(double pitch_deg) {
  samples.axis[SERVO_PITCH].sensors.joint_angle_turn32 = turn32(pitch_deg * DEG);
  servo_samples_complete(&samples);
  servo_app_tick(&app, &command, &samples);
  return (double)app.axis[SERVO_AZIMUTH].speed.pose.inertia_share;
}

static void test_the_azimuth_follows_from_its_first_tick_on_and_the_pitch_does_not(void) {
  start_at(60.0);
  CHECK_NEAR("at 60 deg", 0.625, share_after(60.0), 1e-6);
  CHECK_NEAR("at 60.5 deg", 0.5 + 0.5 * pow(cos(60.5 * DEG), 2.0), share_after(60.5), 1e-6);
  CHECK_SAME("the pitch itself", 1.0, app.axis[SERVO_PITCH].speed.pose.inertia_share);
}

static void test_one_wrong_angle_of_the_pitch_changes_the_share_by_a_step_at_most(void) {
  start_at(10.0);
  const double before = share_after(10.0);
  CHECK_NEAR("one wrong angle", before - 0.01, share_after(60.0), 1e-6);
  CHECK_NEAR("back", before, share_after(10.0), 1e-6);
  start_at(60.0);
  CHECK_NEAR("the other way", 0.625 + 0.01, share_after(10.0), 1e-6);
}

static void test_without_the_angle_of_the_pitch_the_share_stays(void) {
  start_at(45.0);
  const double before = share_after(45.0);
  samples.axis[SERVO_PITCH].sensors.encoder_failed = true;
  CHECK_SAME("encoder lost", before, share_after(0.0));
}

/* A gap in the azimuth's own samples resets its estimates, but not its pose. */
static void test_after_a_gap_the_azimuth_starts_with_the_share_of_its_pitch(void) {
  start_at(90.0);
  command.axis[SERVO_AZIMUTH].mode = SERVO_SPEED;
  CHECK_NEAR("closed", 0.5, share_after(90.0), 1e-6);
  samples.axis[SERVO_AZIMUTH].sensors.encoder_failed = true;
  (void)share_after(90.0);
  samples.axis[SERVO_AZIMUTH].sensors.encoder_failed = false;
  samples.axis[SERVO_AZIMUTH].sensors.joint_angle_turn32 = 1000000u;
  CHECK_NEAR("closed again", 0.5, share_after(90.0), 1e-6);
  CHECK_SAME("torque, Nm", 0.0, app.axis[SERVO_AZIMUTH].commanded_nm);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_share_of_the_inertia_is_that_of_j0_and_j1);
  RUN_TEST(test_a_gyro_on_the_line_of_sight_measures_the_cosine_of_the_pitch);
  RUN_TEST(test_a_gyro_below_its_joint_is_one_in_both_axes);
  RUN_TEST(test_an_inertia_that_makes_no_sense_changes_little_or_nothing);
  RUN_TEST(test_the_azimuth_follows_from_its_first_tick_on_and_the_pitch_does_not);
  RUN_TEST(test_one_wrong_angle_of_the_pitch_changes_the_share_by_a_step_at_most);
  RUN_TEST(test_without_the_angle_of_the_pitch_the_share_stays);
  RUN_TEST(test_after_a_gap_the_azimuth_starts_with_the_share_of_its_pitch);
  return UNITY_END();
}
