/* SPDX-License-Identifier: Apache-2.0 */
/* Both axes hold a target: the camera's mounting, the torques, what frames count, and a pass with ideal joints. The
 * reference values are in double, from rotation matrices and finite differences. */
#include "servo/pointing.h"

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

#define DEG (3.141592653589793 / 180.0)
#define TURN32_PER_RAD (4294967296.0 / 6.283185307179586)

enum { FRAME_TICKS = 20, DELAY_TICKS = 20 };
static const double kTick_s = 1e-3;

static angle_turn32 turn32(double angle_rad) { return (angle_turn32)(int64_t)llround(angle_rad * TURN32_PER_RAD); }

static const camera_mounting kMounting = {.roll_rad = 0.3f, .boresight = {2e-3f, -1e-3f}};

static pointing_params good_params(void) {
  return (pointing_params){.tracker = {.proportional_per_s = 20.0f,
                                       .estimator_rad_s = 6.0f,
                                       .coast_s = 0.5f,
                                       .rate_limit_rad_s = {1.5f, 1.5f}},
                           .inertia = {.azimuth_kg_m2 = 3.0f, .azimuth_swing_kg_m2 = 3.0f, .pitch_kg_m2 = 2.5f},
                           .fed_forward_kg_m2 = {6.0f, 2.5f}};
}

static pointing configured(void) {
  pointing p;
  const pointing_params params = good_params();
  CHECK_STATUS(CONTROL_OK, pointing_configure(&p, &params));
  return p;
}

/* What a pinhole camera with this mounting measures of a target in the direction of other joint angles; its picture is
 * turned by the roll, and the boresight is the point at which the target is to be held. */
static image_vector seen(double azimuth_rad, double pitch_rad, double target_azimuth_rad, double target_pitch_rad) {
  const double d[] = {cos(target_pitch_rad) * cos(target_azimuth_rad), cos(target_pitch_rad) * sin(target_azimuth_rad),
                      sin(target_pitch_rad)};
  const double ahead = cos(azimuth_rad) * d[0] + sin(azimuth_rad) * d[1];
  const double left = -sin(azimuth_rad) * d[0] + cos(azimuth_rad) * d[1];
  const double forward = cos(pitch_rad) * ahead + sin(pitch_rad) * d[2];
  const double up = -sin(pitch_rad) * ahead + cos(pitch_rad) * d[2];
  const double x = left / forward + (double)kMounting.boresight.x;
  const double y = up / forward + (double)kMounting.boresight.y;
  const double roll = (double)kMounting.roll_rad;
  return (image_vector){(float)(cos(roll) * x + sin(roll) * y), (float)(-sin(roll) * x + cos(roll) * y)};
}

static image_vector aligned(image_vector measured) {
  const camera_alignment alignment = camera_align(&kMounting);
  return camera_error(&alignment, measured);
}

static void test_a_turned_camera_with_a_boresight_offset_gives_the_errors_of_the_joints(void) {
  pointing p = configured();
  const double pitch_rad = 80.0 * DEG;
  const pointing_motion rest = {.pitch = rotation_of(turn32(pitch_rad))};
  const pointing_frame frame = {
      .fresh = true, .valid = true, .error = aligned(seen(0.0, pitch_rad, 10e-3, pitch_rad + 2e-3))};
  const pointing_output out = pointing_step(&p, &frame, &rest, SERVO_TICK_S);
  TEST_ASSERT_TRUE(out.locked);
  CHECK_NEAR("azimuth, rad", 10e-3, out.error_of_joints_rad.azimuth, 1e-8);
  CHECK_NEAR("pitch, rad", 2e-3, out.error_of_joints_rad.pitch, 1e-8);
  CHECK_NEAR("rate of the azimuth, rad/s", 20.0 * 10e-3, out.reference[SERVO_AZIMUTH].rate_rad_s, 1e-6);
  CHECK_NEAR("rate of the pitch, rad/s", 20.0 * 2e-3, out.reference[SERVO_PITCH].rate_rad_s, 1e-6);
}

/* Follows a level path at 20 m/s, 500 m up, with joints that turn as commanded. */
typedef struct {
  pointing pointing;
  double x_m;
  double azimuth_rad, pitch_rad;
  double azimuth_rad_s, pitch_rad_s;
  image_vector pipeline[DELAY_TICKS + 1];
  int tick;
  pointing_output out;
} pass;

static pass pass_at(double elevation_rad) {
  pass p = {.pointing = configured(), .x_m = 500.0 / tan(elevation_rad)};
  p.azimuth_rad = atan2(-400.0, p.x_m);
  p.pitch_rad = atan2(500.0, hypot(p.x_m, 400.0));
  return p;
}

/* Returns the true angle between line of sight and target. */
static double track(pass *p) {
  const double y_m = -400.0 + 20.0 * (double)p->tick * kTick_s;
  const double target_azimuth_rad = atan2(y_m, p->x_m);
  const double target_pitch_rad = atan2(500.0, hypot(p->x_m, y_m));
  p->azimuth_rad += p->azimuth_rad_s * kTick_s;
  p->pitch_rad += p->pitch_rad_s * kTick_s;
  p->pipeline[p->tick % (DELAY_TICKS + 1)] = seen(p->azimuth_rad, p->pitch_rad, target_azimuth_rad, target_pitch_rad);
  const pointing_frame frame = {.fresh = p->tick % FRAME_TICKS == 0,
                                .valid = true,
                                .age_ticks = DELAY_TICKS,
                                .error = aligned(p->pipeline[(p->tick + 1) % (DELAY_TICKS + 1)])};
  const pointing_motion motion = {.pitch = rotation_of(turn32(p->pitch_rad)),
                                  .inertial_rad_s = {(float)p->azimuth_rad_s, (float)p->pitch_rad_s}};
  p->out = pointing_step(&p->pointing, &frame, &motion, SERVO_TICK_S);
  p->azimuth_rad_s = (double)p->out.reference[SERVO_AZIMUTH].rate_rad_s;
  p->pitch_rad_s = (double)p->out.reference[SERVO_PITCH].rate_rad_s;
  ++p->tick;
  return hypot((target_azimuth_rad - p->azimuth_rad) * cos(target_pitch_rad), target_pitch_rad - p->pitch_rad);
}

static double inertia_at(double pitch_rad) { return 3.0 + 3.0 * cos(pitch_rad) * cos(pitch_rad); }

static void test_a_pass_at_85_degrees_is_followed_through_a_turned_camera(void) {
  pass p = pass_at(85.0 * DEG);
  double square = 0.0;
  int count = 0;
  for (int i = 0; i < 40000; ++i) {
    const double error_rad = track(&p);
    if (i >= 10000) {
      square += error_rad * error_rad;
      ++count;
    }
  }
  const double rms_rad = sqrt(square / (double)count);
  LOG_VALUE("error of the pass, rms, rad", rms_rad);
  CHECK_AT_MOST("error, rad", 2e-6, rms_rad);
}

/* The torque of command and speed loop, against the change of angular momentum over 20 ms. */
static void test_the_torques_are_those_of_the_turning_masses(void) {
  pass p = pass_at(80.0 * DEG);
  double worst_nm = 0.0;
  double largest_nm = 0.0;
  for (int i = 0; i < 35000; i += FRAME_TICKS) {
    const double momentum_then = inertia_at(p.pitch_rad) * p.azimuth_rad_s;
    for (int k = 0; k < FRAME_TICKS; ++k) {
      (void)track(&p);
    }
    if (i < 12000) {
      continue;
    }
    const double change_nm = (inertia_at(p.pitch_rad) * p.azimuth_rad_s - momentum_then) / (FRAME_TICKS * kTick_s);
    const double given_nm = (double)p.out.torque_nm[SERVO_AZIMUTH] +
                            inertia_at(p.pitch_rad) * (double)p.out.reference[SERVO_AZIMUTH].acceleration_rad_s2;
    worst_nm = fmax(worst_nm, fabs(given_nm - change_nm));
    largest_nm = fmax(largest_nm, fabs(change_nm));
    const double centrifugal_nm = 1.5 * sin(2.0 * p.pitch_rad) * p.azimuth_rad_s * p.azimuth_rad_s;
    const double given_to_pitch_nm = (double)p.out.torque_nm[SERVO_PITCH];
    CHECK_NEAR("torque added to the pitch, Nm", centrifugal_nm, given_to_pitch_nm, 1e-4);
  }
  LOG_VALUE("largest torque of the azimuth, Nm", largest_nm);
  LOG_VALUE("largest difference, Nm", worst_nm);
  CHECK_AT_LEAST("torque, Nm", 0.05, largest_nm);
  CHECK_AT_MOST("difference, Nm", 0.1 * largest_nm, worst_nm);
}

/* What the speed loops feed forward of the inertia is left out: a share of the azimuth's, which is at most that of
 * pitch 0, as the loop follows it; and the pitch's. */
static void test_the_torques_are_what_the_speed_loops_do_not_feed_forward(void) {
  static const struct {
    const char *what;
    double swing_kg_m2;
    double fed_forward_kg_m2[2];
  } rows[] = {
      {"all", 3.0, {6.0, 2.5}},
      {"nothing", 3.0, {0.0, 0.0}},
      {"a half and a fifth", 3.0, {3.0, 0.5}},
      {"an inertia that grows with the pitch", -1.0, {2.0, 2.5}},
  };
  for (unsigned i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    pointing p;
    pointing_params params = good_params();
    params.inertia.azimuth_swing_kg_m2 = (float)rows[i].swing_kg_m2;
    params.fed_forward_kg_m2 = (joint_vector){(float)rows[i].fed_forward_kg_m2[0], (float)rows[i].fed_forward_kg_m2[1]};
    CHECK_STATUS(CONTROL_OK, pointing_configure(&p, &params));
    const double pitch_rad = 0.6;
    const pointing_motion motion = {.pitch = rotation_of(turn32(pitch_rad))};
    const pointing_frame none = {.fresh = false};
    const pointing_target target = {.rate_rad_s = {0.3f, -0.2f}, .acceleration_rad_s2 = {0.5f, -0.7f}};
    pointing_tracker_assume(&p.tracker, &target);
    const pointing_output out = pointing_step(&p, &none, &motion, SERVO_TICK_S);
    TEST_ASSERT_TRUE(out.locked && !out.limited);
    const double rate[] = {(double)out.reference[0].rate_rad_s, (double)out.reference[1].rate_rad_s};
    const double acceleration[] = {(double)out.reference[0].acceleration_rad_s2,
                                   (double)out.reference[1].acceleration_rad_s2};
    const double swing = rows[i].swing_kg_m2;
    const double inertia = 3.0 + swing * cos(pitch_rad) * cos(pitch_rad);
    const double followed = fmin(inertia, 3.0 + swing) * rows[i].fed_forward_kg_m2[0] / (3.0 + swing);
    CHECK_NEAR(rows[i].what, (inertia - followed) * acceleration[0] - swing * sin(2.0 * pitch_rad) * rate[0] * rate[1],
               out.torque_nm[SERVO_AZIMUTH], 1e-5);
    CHECK_NEAR(
        rows[i].what,
        (2.5 - rows[i].fed_forward_kg_m2[1]) * acceleration[1] + 0.5 * swing * sin(2.0 * pitch_rad) * rate[0] * rate[0],
        out.torque_nm[SERVO_PITCH], 1e-5);
  }
}

static void test_a_frame_from_before_the_reset_does_not_count(void) {
  pointing p = configured();
  const pointing_motion rest = {.pitch = rotation_of(turn32(0.5))};
  const pointing_frame none = {.fresh = false};
  const pointing_frame frame = {.fresh = true, .valid = true, .age_ticks = 5, .error = {1e-3f, 1e-3f}};
  for (int i = 0; i < 4; ++i) {
    TEST_ASSERT_FALSE(pointing_step(&p, &none, &rest, SERVO_TICK_S).locked);
  }
  TEST_ASSERT_FALSE(pointing_step(&p, &frame, &rest, SERVO_TICK_S).locked);
  TEST_ASSERT_TRUE(pointing_step(&p, &frame, &rest, SERVO_TICK_S).locked);
  for (int i = 0; i < 3 * TARGET_TRACKER_HISTORY; ++i) {
    (void)pointing_step(&p, &none, &rest, SERVO_TICK_S);
  }
  TEST_ASSERT_TRUE(p.known_ticks == TARGET_TRACKER_HISTORY);
  pointing_reset(&p);
  const pointing_output out = pointing_step(&p, &frame, &rest, SERVO_TICK_S);
  TEST_ASSERT_FALSE(out.locked);
  for (int i = 0; i < SERVO_AXES; ++i) {
    CHECK_SAME("rate", 0.0, out.reference[i].rate_rad_s);
    CHECK_SAME("torque", 0.0, out.torque_nm[i]);
  }
}

static void test_it_reads_the_samples_of_its_axes(void) {
  servo_samples samples = {0};
  samples.axis[SERVO_PITCH].sensors.joint_angle_turn32 = turn32(0.5);
  servo_samples_complete(&samples);
  static servo_app app;
  app.axis[SERVO_AZIMUTH].signals.rates.rate_rad_s = 0.25f;
  app.axis[SERVO_PITCH].signals.rates.rate_rad_s = -0.5f;
  const pointing_motion motion = pointing_motion_of(&app, &samples);
  CHECK_NEAR("sine", sin(0.5), motion.pitch.sine, 1e-6);
  CHECK_NEAR("cosine", cos(0.5), motion.pitch.cosine, 1e-6);
  CHECK_SAME("azimuth", 0.25, motion.inertial_rad_s.azimuth);
  CHECK_SAME("pitch", -0.5, motion.inertial_rad_s.pitch);
}

static void test_parameters_out_of_range_are_refused_and_change_nothing(void) {
  pointing p = configured();
  pointing_params bad = good_params();
  const struct {
    float *value;
    float low, high; /* just beyond the range */
  } cases[] = {
      {&bad.tracker.estimator_rad_s, 0.0f, 51.0f},     {&bad.inertia.azimuth_kg_m2, 0.0f, 1.01e5f},
      {&bad.inertia.azimuth_swing_kg_m2, -3.0f, 1e5f}, /* at pitch 0: none is left; more than 1e5 */
      {&bad.inertia.pitch_kg_m2, 0.0f, 1.01e5f},       {&bad.fed_forward_kg_m2.azimuth, -0.1f, 1.01e5f},
      {&bad.fed_forward_kg_m2.pitch, -0.1f, 1.01e5f},
  };
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    const float good = *cases[i].value;
    const float wrong[] = {cases[i].low, cases[i].high, NAN};
    for (int w = 0; w < 3; ++w) {
      *cases[i].value = wrong[w];
      CHECK_STATUS(w < 2 ? CONTROL_OUT_OF_RANGE : CONTROL_NOT_FINITE, pointing_configure(&p, &bad));
      CHECK_SAME("inertia", 3.0, p.params.inertia.azimuth_kg_m2);
    }
    *cases[i].value = good;
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_turned_camera_with_a_boresight_offset_gives_the_errors_of_the_joints);
  RUN_TEST(test_a_pass_at_85_degrees_is_followed_through_a_turned_camera);
  RUN_TEST(test_the_torques_are_those_of_the_turning_masses);
  RUN_TEST(test_the_torques_are_what_the_speed_loops_do_not_feed_forward);
  RUN_TEST(test_a_frame_from_before_the_reset_does_not_count);
  RUN_TEST(test_it_reads_the_samples_of_its_axes);
  RUN_TEST(test_parameters_out_of_range_are_refused_and_change_nothing);
  return UNITY_END();
}
