/* SPDX-License-Identifier: Apache-2.0 */
/* Tracking with both axes: joints that follow their rates at once, a camera of 50 Hz that is 20 ms late, and targets in
 * space, all in double. What is left is the error of the estimator and of the geometry. */
#include "control/pointing_tracker.h"

#include <stdlib.h>

#include "base/scalar.h"
#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

#define DEG (3.141592653589793 / 180.0)
#define TURN32_PER_RAD (4294967296.0 / 6.283185307179586)

enum { FRAME_TICKS = 20, DELAY_TICKS = 20 };
static const double kDt_s = 1e-3;
static const rotation level = {.sine = 0.0f, .cosine = 1.0f};

typedef struct {
  double at[3];
} vector;

/* A straight, level path: `speed` along y, closest at (x, 0, height) at time 0. */
typedef struct {
  double speed_m_s;
  double x_m;
  double height_m;
} path;

typedef struct {
  pointing_tracker_params params;
  pointing_tracker_state state;
  double azimuth_rad;
  double pitch_rad;
  double azimuth_rad_s;
  double pitch_rad_s;
  image_vector seen[DELAY_TICKS + 1]; /* by the camera, a ring */
  int tick;
  double noise_rad;
  random_source random;
  bool camera_on;
  pointing_command out;
} bench;

static bench bench_at(double azimuth_rad, double pitch_rad) {
  return (bench){.params = {.proportional_per_s = 30.0f,
                            .estimator_rad_s = 6.0f,
                            .coast_s = 0.5f,
                            .rate_limit_rad_s = {1.5f, 1.5f}},
                 .azimuth_rad = azimuth_rad,
                 .pitch_rad = pitch_rad,
                 .random = {7},
                 .camera_on = true};
}

static vector place(const path *p, double time_s) { return (vector){{p->x_m, p->speed_m_s * time_s, p->height_m}}; }

static double azimuth_of(vector target) { return atan2(target.at[1], target.at[0]); }
static double pitch_of(vector target) { return atan2(target.at[2], hypot(target.at[0], target.at[1])); }

/* Tangents of the angles to the target along the image axes. */
static image_vector image_of(const bench *b, vector target) {
  const double ca = cos(b->azimuth_rad);
  const double sa = sin(b->azimuth_rad);
  const double cp = cos(b->pitch_rad);
  const double sp = sin(b->pitch_rad);
  const double ahead = ca * target.at[0] + sa * target.at[1];
  const double left = -sa * target.at[0] + ca * target.at[1];
  const double forward = cp * ahead + sp * target.at[2];
  return (image_vector){(float)(left / forward), (float)((-sp * ahead + cp * target.at[2]) / forward)};
}

/* One tick; returns the true angle between line of sight and target. */
static double track(bench *b, vector target) {
  b->azimuth_rad += b->azimuth_rad_s * kDt_s;
  b->pitch_rad += b->pitch_rad_s * kDt_s;
  const image_vector image = image_of(b, target);
  image_vector measured = image;
  measured.x += (float)(b->noise_rad * random_normal(&b->random));
  measured.y += (float)(b->noise_rad * random_normal(&b->random));
  b->seen[b->tick % (DELAY_TICKS + 1)] = measured;
  const bool fresh = b->camera_on && b->tick >= DELAY_TICKS && b->tick % FRAME_TICKS == 0;
  const pointing_frame frame = {
      .fresh = fresh, .valid = true, .age_ticks = DELAY_TICKS, .error = b->seen[(b->tick + 1) % (DELAY_TICKS + 1)]};
  const angle_turn32 pitch = (angle_turn32)(int64_t)llround(b->pitch_rad * TURN32_PER_RAD);
  const line_of_sight_rates los =
      line_of_sight_of_joints(rotation_of(pitch), (float)b->azimuth_rad_s, (float)b->pitch_rad_s);
  b->out = pointing_tracker_step(&b->state, &b->params, &frame, &los, rotation_of(pitch), (float)kDt_s);
  pointing_tracker_prepare(&b->state, &b->params, b->out.error_of_joints_rad, (float)kDt_s);
  b->azimuth_rad_s = (double)b->out.rate_rad_s.azimuth;
  b->pitch_rad_s = (double)b->out.rate_rad_s.pitch;
  ++b->tick;
  return hypot((double)image.x, (double)image.y);
}

/* RMS of the error of a pass, from `settle_s` after its begin on. */
static double pass_rms_rad(bench *b, const path *p, double from_s, double to_s, double settle_s) {
  double square = 0.0;
  int count = 0;
  const int ticks = (int)lround((to_s - from_s) / kDt_s);
  for (int i = 0; i < ticks; ++i) {
    const double error_rad = track(b, place(p, from_s + (double)i * kDt_s));
    if ((double)i * kDt_s >= settle_s) {
      square += error_rad * error_rad;
      ++count;
    }
  }
  return sqrt(square / (double)count);
}

/* 500 m up, 20 m/s. */
static path pass_at(double pitch_rad) { return (path){20.0, 500.0 / tan(pitch_rad), 500.0}; }

static bench start_of(const path *p, double time_s) {
  const vector first = place(p, time_s);
  return bench_at(azimuth_of(first) + 1e-3, pitch_of(first) - 1e-3);
}

static void test_straight_passes_up_to_85_degrees_leave_less_than_a_microradian(void) {
  static const double highest_deg[] = {10.0, 60.0, 80.0, 85.0};
  for (unsigned i = 0; i < sizeof highest_deg / sizeof highest_deg[0]; ++i) {
    const path p = pass_at(highest_deg[i] * DEG);
    bench b = start_of(&p, -20.0);
    const double rms_rad = pass_rms_rad(&b, &p, -20.0, 20.0, 10.0);
    LOG_VALUE("highest pitch, degrees", highest_deg[i]);
    LOG_VALUE("error of the pass, rms, rad", rms_rad);
    CHECK_AT_MOST("error, rad", 1e-6, rms_rad);
    TEST_ASSERT_TRUE(b.out.locked && !b.out.limited);
  }
}

/* 150 m up the target turns by 0.13 rad/s. An estimator of constant acceleration lags by jerk / bandwidth^3, 22 urad.
 */
static void test_the_jerk_of_a_straight_path_is_no_lag(void) {
  const path p = {20.0, 150.0 / tan(70.0 * DEG), 150.0};
  bench b = start_of(&p, -15.0);
  const double rms_rad = pass_rms_rad(&b, &p, -15.0, 15.0, 10.0);
  LOG_VALUE("error of the pass, rms, rad", rms_rad);
  CHECK_AT_MOST("error, rad", 5e-6, rms_rad);
}

static void test_it_coasts_along_a_straight_path(void) {
  const path p = {20.0, 150.0 / tan(70.0 * DEG), 150.0};
  bench b = start_of(&p, -15.0);
  b.params.coast_s = 3.0f;
  (void)pass_rms_rad(&b, &p, -15.0, -1.0, 10.0);
  b.camera_on = false;
  const double rms_rad = pass_rms_rad(&b, &p, -1.0, 1.0, 1.9);
  LOG_VALUE("error after 2 s without frames, rad", rms_rad);
  CHECK_AT_MOST("error, rad", 1e-3, rms_rad); /* the jerk alone is 4.7 mrad/s^3: 6 mrad */
}

/* The joints that point at a target on a straight path have these rates and accelerations, by central differences. */
static void test_rates_and_accelerations_are_those_of_joints_that_stay_on_the_target(void) {
  const path p = pass_at(80.0 * DEG);
  bench b = start_of(&p, -20.0);
  (void)pass_rms_rad(&b, &p, -20.0, -10.0, 5.0);
  double rate = 0.0;
  double azimuth = 0.0;
  double pitch = 0.0;
  double largest = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const double now_s = -10.0 + (double)i * kDt_s;
    (void)track(&b, place(&p, now_s));
    const vector before = place(&p, now_s - kDt_s);
    const vector here = place(&p, now_s);
    const vector after = place(&p, now_s + kDt_s);
    const double azimuth_rad_s2 = (azimuth_of(after) - 2.0 * azimuth_of(here) + azimuth_of(before)) / (kDt_s * kDt_s);
    const double pitch_rad_s2 = (pitch_of(after) - 2.0 * pitch_of(here) + pitch_of(before)) / (kDt_s * kDt_s);
    rate =
        fmax(rate, fabs((azimuth_of(after) - azimuth_of(before)) / (2.0 * kDt_s) - (double)b.out.rate_rad_s.azimuth));
    rate = fmax(rate, fabs((pitch_of(after) - pitch_of(before)) / (2.0 * kDt_s) - (double)b.out.rate_rad_s.pitch));
    azimuth = fmax(azimuth, fabs(azimuth_rad_s2 - (double)b.out.acceleration_rad_s2.azimuth));
    pitch = fmax(pitch, fabs(pitch_rad_s2 - (double)b.out.acceleration_rad_s2.pitch));
    largest = fmax(largest, fabs(azimuth_rad_s2));
    CHECK_AT_MOST("estimated error, rad", 1e-5, fabs((double)b.out.error_rad.x));
    CHECK_AT_MOST("estimated error, rad", 1e-5, fabs((double)b.out.error_rad.y));
  }
  LOG_VALUE("largest acceleration of the azimuth, rad/s^2", largest);
  CHECK_AT_LEAST("largest acceleration of the azimuth, rad/s^2", 0.02, largest);
  CHECK_AT_MOST("error of the rates, rad/s", 6e-5, rate);
  CHECK_AT_MOST("error of the azimuth's acceleration, rad/s^2", 6e-4, azimuth);
  CHECK_AT_MOST("error of the pitch's acceleration, rad/s^2", 6e-5, pitch);
}

static void test_centroid_noise_of_a_fifth_of_a_pixel_leaves_less_than_its_own_size(void) {
  const path p = pass_at(60.0 * DEG);
  bench b = start_of(&p, -20.0);
  b.noise_rad = 0.2 * 11.499e-6;
  const double rms_rad = pass_rms_rad(&b, &p, -20.0, 20.0, 10.0);
  LOG_VALUE("error with noise, both image axes, rms, rad", rms_rad);
  CHECK_AT_MOST("error, rad", 2.3e-6, rms_rad);
}

static void test_beyond_the_rate_limit_the_target_is_lost_for_a_while_and_caught_again(void) {
  const path p = pass_at(89.0 * DEG);
  bench b = start_of(&p, -20.0);
  (void)pass_rms_rad(&b, &p, -20.0, 0.0, 10.0);
  TEST_ASSERT_TRUE(b.out.limited);
  const double rms_rad = pass_rms_rad(&b, &p, 0.0, 20.0, 10.0);
  CHECK_AT_MOST("error 10 s later, rad", 1e-6, rms_rad);
}

static void test_through_the_zenith_every_output_stays_finite_and_within_its_limit(void) {
  const path p = {20.0, 1e-3, 500.0};
  bench b = start_of(&p, -10.0);
  for (int i = 0; i < 20000; ++i) {
    (void)track(&b, place(&p, -10.0 + (double)i * kDt_s));
    TEST_ASSERT_TRUE(scalar_within(b.out.rate_rad_s.azimuth, 1.5f) && scalar_within(b.out.rate_rad_s.pitch, 1.5f));
    TEST_ASSERT_TRUE(isfinite(b.out.acceleration_rad_s2.azimuth) && isfinite(b.out.acceleration_rad_s2.pitch));
    if (b.out.limited) { /* no feedforward for a motion that is not commanded */
      CHECK_SAME("acceleration of the azimuth", 0.0, b.out.acceleration_rad_s2.azimuth);
      CHECK_SAME("acceleration of the pitch", 0.0, b.out.acceleration_rad_s2.pitch);
    }
  }
}

/* The azimuth's feedforward is that of the secant up to 0.005, and fades with the cosine from there to the zenith. */
static void test_near_the_zenith_the_feedforward_of_the_azimuth_fades(void) {
  static const struct {
    double cosine;
    double factor;
  } cases[] = {{0.5, 2.0}, {0.01, 100.0}, {0.0051, 196.078}, {0.0049, 196.0}, {0.0025, 100.0}, {0.0005, 20.0}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    bench b = bench_at(0.0, acos(cases[i].cosine));
    const angle_turn32 pitch = (angle_turn32)(int64_t)llround(b.pitch_rad * TURN32_PER_RAD);
    const line_of_sight_rates los = {.rad_s = {.x = 1e-3f}};
    const pointing_frame centred = {.fresh = true, .valid = true};
    const pointing_command out =
        pointing_tracker_step(&b.state, &b.params, &centred, &los, rotation_of(pitch), (float)kDt_s);
    TEST_ASSERT_TRUE(out.locked && !out.limited);
    CHECK_NEAR("rate of the azimuth, rad/s", 1e-3 * cases[i].factor, out.rate_rad_s.azimuth, 2e-5);
    CHECK_NEAR("rate of the pitch, rad/s", 0.0, out.rate_rad_s.pitch, 1e-9);
    CHECK_NEAR("acceleration of the azimuth, rad/s^2", 0.0, out.acceleration_rad_s2.azimuth, 1e-9);
    const double azimuth_rad_s = 1e-3 * cases[i].factor; /* the pitch falls on a great circle */
    CHECK_NEAR("acceleration of the pitch, rad/s^2",
               -azimuth_rad_s * azimuth_rad_s * cases[i].cosine * sqrt(1.0 - cases[i].cosine * cases[i].cosine),
               out.acceleration_rad_s2.pitch, 1e-6);
  }
}

/* A frame that is old was taken on axes that have rolled since. */
static void test_a_frame_is_turned_by_what_the_image_has_rolled_since_its_exposure(void) {
  static const int ages[] = {0, 1, 20, 50, TARGET_TRACKER_HISTORY - 1};
  for (unsigned i = 0; i < sizeof ages / sizeof ages[0]; ++i) {
    bench b = bench_at(0.0, 0.0);
    const line_of_sight_rates los = {.roll_rad_s = 2.0f};
    const pointing_frame none = {.fresh = false};
    for (int tick = 0; tick < 300; ++tick) {
      (void)pointing_tracker_step(&b.state, &b.params, &none, &los, level, (float)kDt_s);
    }
    const pointing_frame frame = {.fresh = true, .valid = true, .age_ticks = ages[i], .error = {1e-3f, 0.0f}};
    const pointing_command out = pointing_tracker_step(&b.state, &b.params, &frame, &los, level, (float)kDt_s);
    const double rolled_rad = 2e-3 * (double)ages[i]; /* the image turns, and the target stays */
    CHECK_NEAR("x, rad", 1e-3 * cos(rolled_rad), out.error_rad.x, 1e-8);
    CHECK_NEAR("y, rad", -1e-3 * sin(rolled_rad), out.error_rad.y, 1e-8);
  }
}

/* Ages beyond the history are taken modulo its length, and a frame that is not fresh is not turned: both read nothing
 * outside the history. */
static void test_a_frame_of_any_age_is_turned_by_an_angle_of_the_history(void) {
  static const int ages[] = {-1, -20, -TARGET_TRACKER_HISTORY, TARGET_TRACKER_HISTORY, TARGET_TRACKER_HISTORY + 20};
  bench b = bench_at(0.0, 0.0);
  const line_of_sight_rates los = {.roll_rad_s = 2.0f};
  pointing_frame frame = {.fresh = false, .valid = true, .error = {1e-3f, 2e-3f}};
  for (int tick = 0; tick < 300; ++tick) {
    (void)pointing_tracker_step(&b.state, &b.params, &frame, &los, level, (float)kDt_s);
  }
  for (unsigned i = 0; i < sizeof ages / sizeof ages[0]; ++i) {
    frame.age_ticks = ages[i];
    frame.fresh = true;
    const image_vector old = pointing_tracker_frame_error(&b.state, &frame);
    frame.age_ticks = (ages[i] + 2 * TARGET_TRACKER_HISTORY) % TARGET_TRACKER_HISTORY;
    const image_vector same = pointing_tracker_frame_error(&b.state, &frame);
    CHECK_SAME("x, rad", same.x, old.x);
    CHECK_SAME("y, rad", same.y, old.y);
    frame.age_ticks = ages[i];
    frame.fresh = false;
    const image_vector as_given = pointing_tracker_frame_error(&b.state, &frame);
    CHECK_SAME("x, rad", 1e-3f, as_given.x);
    CHECK_SAME("y, rad", 2e-3f, as_given.y);
  }
}

/* Each joint has its own. */
static void test_the_rate_limits_are_those_of_the_joints(void) {
  bench b = bench_at(0.0, 0.0);
  b.params.rate_limit_rad_s = (joint_vector){0.4f, 0.2f};
  const line_of_sight_rates los = {.roll_rad_s = 0.0f};
  for (int side = -1; side <= 1; side += 2) {
    const pointing_frame far_x = {.fresh = true, .valid = true, .error = {(float)side * 0.3f, 0.0f}};
    const pointing_frame far_y = {.fresh = true, .valid = true, .error = {0.0f, (float)side * 0.3f}};
    pointing_tracker_reset(&b.state);
    pointing_command out = pointing_tracker_step(&b.state, &b.params, &far_x, &los, level, (float)kDt_s);
    CHECK_SAME("azimuth, rad/s", (float)side * 0.4f, out.rate_rad_s.azimuth);
    CHECK_NEAR("pitch, rad/s", 0.0, out.rate_rad_s.pitch, 1e-6);
    TEST_ASSERT_TRUE(out.limited);
    pointing_tracker_reset(&b.state);
    out = pointing_tracker_step(&b.state, &b.params, &far_y, &los, level, (float)kDt_s);
    CHECK_NEAR("azimuth, rad/s", 0.0, out.rate_rad_s.azimuth, 1e-6);
    CHECK_SAME("pitch, rad/s", (float)side * 0.2f, out.rate_rad_s.pitch);
    TEST_ASSERT_TRUE(out.limited);
  }
}

static void test_without_frames_it_coasts_and_then_stops(void) {
  const path p = pass_at(60.0 * DEG);
  bench b = start_of(&p, -20.0);
  (void)pass_rms_rad(&b, &p, -20.0, -5.0, 10.0);
  b.camera_on = false;
  const double rms_rad = pass_rms_rad(&b, &p, -5.0, -4.6, 0.0);
  CHECK_AT_MOST("error while it coasts, rad", 5e-6, rms_rad);
  TEST_ASSERT_TRUE(b.out.locked);
  (void)pass_rms_rad(&b, &p, -4.6, -4.4, 0.0);
  TEST_ASSERT_FALSE(b.out.locked);
  CHECK_SAME("rate of the azimuth", 0.0, b.out.rate_rad_s.azimuth);
  CHECK_SAME("rate of the pitch", 0.0, b.out.rate_rad_s.pitch);
}

static void test_bad_frames_change_nothing(void) {
  const path p = pass_at(60.0 * DEG);
  bench good = start_of(&p, -20.0);
  (void)pass_rms_rad(&good, &p, -20.0, -15.0, 4.0);
  const pointing_frame bad[] = {
      {.fresh = true, .valid = true, .age_ticks = -1, .error = {0.1f, 0.1f}},
      {.fresh = true, .valid = true, .age_ticks = TARGET_TRACKER_HISTORY, .error = {0.1f, 0.1f}},
      {.fresh = true, .valid = true, .age_ticks = 20, .error = {NAN, 0.0f}},
      {.fresh = true, .valid = true, .age_ticks = 20, .error = {0.0f, INFINITY}},
      {.fresh = true, .valid = false, .age_ticks = 20, .error = {0.1f, 0.1f}},
  };
  const angle_turn32 pitch = (angle_turn32)llround(good.pitch_rad * TURN32_PER_RAD);
  const line_of_sight_rates los = line_of_sight_of_joints(rotation_of(pitch), 0.01f, 0.01f);
  const pointing_frame none = {.fresh = false};
  pointing_tracker_state state = good.state;
  const pointing_command expected = pointing_tracker_step(&state, &good.params, &none, &los, rotation_of(pitch), 1e-3f);
  for (unsigned i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
    state = good.state;
    const pointing_command found =
        pointing_tracker_step(&state, &good.params, &bad[i], &los, rotation_of(pitch), 1e-3f);
    CHECK_SAME("azimuth", expected.rate_rad_s.azimuth, found.rate_rad_s.azimuth);
    CHECK_SAME("pitch", expected.rate_rad_s.pitch, found.rate_rad_s.pitch);
  }
}

static void test_parameters_out_of_range_are_refused(void) {
  const pointing_tracker_params good = bench_at(0.0, 0.0).params;
  CHECK_STATUS(CONTROL_OK, pointing_tracker_check(&good));
  pointing_tracker_params bad = good;
  bad.proportional_per_s = 101.0f;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, pointing_tracker_check(&bad));
  bad = good;
  bad.estimator_rad_s = 0.0f;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, pointing_tracker_check(&bad));
  bad = good;
  bad.rate_limit_rad_s.azimuth = 0.0f;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, pointing_tracker_check(&bad));
  bad = good;
  bad.rate_limit_rad_s.pitch = NAN;
  CHECK_STATUS(CONTROL_NOT_FINITE, pointing_tracker_check(&bad));
  bad = good;
  bad.braking_rad_s2.azimuth = -1.0f;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, pointing_tracker_check(&bad));
  bad = good;
  bad.braking_rad_s2.pitch = 1.1e4f;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, pointing_tracker_check(&bad));
}

/* The image has rolled before: what is assumed is along its axes of now, and moves on by itself. */
static void test_an_assumed_target_is_followed_like_one_that_was_seen(void) {
  bench b = bench_at(0.0, 0.0);
  const line_of_sight_rates rolls = {.roll_rad_s = 2.0f};
  const line_of_sight_rates rests = {.roll_rad_s = 0.0f};
  const pointing_frame none = {.fresh = false};
  for (int tick = 0; tick < 300; ++tick) {
    (void)pointing_tracker_step(&b.state, &b.params, &none, &rolls, level, (float)kDt_s);
  }
  TEST_ASSERT_FALSE(b.state.along[0].locked || b.state.along[1].locked);
  const pointing_target target = {
      .error = {1e-3f, -2e-3f}, .rate_rad_s = {0.03f, 0.01f}, .acceleration_rad_s2 = {-0.2f, 0.4f}};
  pointing_tracker_assume(&b.state, &target);
  const pointing_target known = pointing_tracker_target(&b.state);
  CHECK_NEAR("x, rad", 1e-3, known.error.x, 1e-9);
  CHECK_NEAR("y, rad", -2e-3, known.error.y, 1e-9);
  CHECK_NEAR("x, rad/s", 0.03, known.rate_rad_s.x, 1e-8);
  CHECK_NEAR("y, rad/s", 0.01, known.rate_rad_s.y, 1e-8);
  CHECK_NEAR("x, rad/s^2", -0.2, known.acceleration_rad_s2.x, 1e-7);
  CHECK_NEAR("y, rad/s^2", 0.4, known.acceleration_rad_s2.y, 1e-7);
  b.state.along[0].ticks_since_frame = b.state.along[1].ticks_since_frame = 0;
  pointing_command out = {0};
  for (int tick = 0; tick < 100; ++tick) {
    out = pointing_tracker_step(&b.state, &b.params, &none, &rests, level, (float)kDt_s);
  }
  TEST_ASSERT_TRUE(out.locked);
  CHECK_NEAR("x after 0.1 s, rad", 1e-3 + 0.03 * 0.1 - 0.5 * 0.2 * 0.01, out.error_rad.x, 1e-7);
  CHECK_NEAR("y after 0.1 s, rad", -2e-3 + 0.01 * 0.1 + 0.5 * 0.4 * 0.01, out.error_rad.y, 1e-7);
  pointing_tracker_lose(&b.state);
  TEST_ASSERT_FALSE(b.state.along[0].locked || b.state.along[1].locked);
  TEST_ASSERT_FALSE(pointing_tracker_step(&b.state, &b.params, &none, &rests, level, (float)kDt_s).locked);
}

/* 2 rad/s^2 of each joint: an error of 0.3 rad is approached at the rate from which it can still be braked; the
 * azimuth brakes less by what its own target slows down. */
static void test_far_from_the_target_each_joint_approaches_at_the_rate_from_which_it_can_brake(void) {
  for (int side = -1; side <= 1; side += 2) {
    bench b = bench_at(0.0, 0.0);
    b.params.proportional_per_s = 10.0f;
    b.params.rate_limit_rad_s = (joint_vector){5.0f, 5.0f};
    b.params.braking_rad_s2 = (joint_vector){2.0f, 1.0f};
    const line_of_sight_rates rests = {.roll_rad_s = 0.0f};
    const float error = (float)side * 0.3f;
    const pointing_frame frame = {.fresh = true, .valid = true, .error = {tanf(error), 0.0f}};
    const pointing_frame above = {.fresh = true, .valid = true, .error = {0.0f, tanf(error)}};
    pointing_tracker_prepare(&b.state, &b.params, (joint_vector){error, error}, (float)kDt_s);
    CHECK_SAME("nothing is known yet", 0.0, b.state.softer_per_s.azimuth);
    pointing_command out = pointing_tracker_step(&b.state, &b.params, &frame, &rests, level, (float)kDt_s);
    CHECK_NEAR("azimuth in the first tick, rad/s", (double)side * 3.0, out.rate_rad_s.azimuth, 1e-5);
    pointing_tracker_prepare(&b.state, &b.params, out.error_of_joints_rad, (float)kDt_s);
    out = pointing_tracker_step(&b.state, &b.params, &frame, &rests, level, (float)kDt_s);
    CHECK_NEAR("azimuth, rad/s", (double)side * sqrt(2.0 * 2.0 * (0.3 - 2.0 / 200.0)), out.rate_rad_s.azimuth, 1e-5);
    const float small = (float)side * 5e-3f; /* it can be braked from the rate of the loop */
    const pointing_frame near = {.fresh = true, .valid = true, .error = {tanf(small), 0.0f}};
    pointing_tracker_reset(&b.state);
    out = pointing_tracker_step(&b.state, &b.params, &near, &rests, level, (float)kDt_s);
    pointing_tracker_prepare(&b.state, &b.params, out.error_of_joints_rad, (float)kDt_s);
    out = pointing_tracker_step(&b.state, &b.params, &near, &rests, level, (float)kDt_s);
    CHECK_NEAR("azimuth near to the target, rad/s", (double)side * 0.05, out.rate_rad_s.azimuth, 1e-6);
    pointing_tracker_reset(&b.state);
    out = pointing_tracker_step(&b.state, &b.params, &above, &rests, level, (float)kDt_s);
    pointing_tracker_prepare(&b.state, &b.params, out.error_of_joints_rad, (float)kDt_s);
    out = pointing_tracker_step(&b.state, &b.params, &above, &rests, level, (float)kDt_s);
    CHECK_NEAR("pitch, rad/s", (double)side * sqrt(2.0 * 1.0 * (0.3 - 1.0 / 200.0)), out.rate_rad_s.pitch, 1e-5);
    const pointing_target turns = {.error = {tanf(error), 0.0f}, .acceleration_rad_s2 = {(float)side * -0.5f, 0.0f}};
    pointing_tracker_assume(&b.state, &turns);
    const pointing_frame none = {.fresh = false};
    out = pointing_tracker_step(&b.state, &b.params, &none, &rests, level, (float)kDt_s);
    pointing_tracker_prepare(&b.state, &b.params, out.error_of_joints_rad, (float)kDt_s);
    const double k = 10.0 - (double)b.state.softer_per_s.azimuth;
    const double e = fabs((double)out.error_of_joints_rad.azimuth);
    CHECK_NEAR("azimuth towards a target that slows down, 1/s", sqrt(2.0 * 1.5 * (e - 1.5 / 200.0)) / e, k, 5e-2);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_straight_passes_up_to_85_degrees_leave_less_than_a_microradian);
  RUN_TEST(test_the_jerk_of_a_straight_path_is_no_lag);
  RUN_TEST(test_it_coasts_along_a_straight_path);
  RUN_TEST(test_rates_and_accelerations_are_those_of_joints_that_stay_on_the_target);
  RUN_TEST(test_centroid_noise_of_a_fifth_of_a_pixel_leaves_less_than_its_own_size);
  RUN_TEST(test_beyond_the_rate_limit_the_target_is_lost_for_a_while_and_caught_again);
  RUN_TEST(test_through_the_zenith_every_output_stays_finite_and_within_its_limit);
  RUN_TEST(test_near_the_zenith_the_feedforward_of_the_azimuth_fades);
  RUN_TEST(test_a_frame_is_turned_by_what_the_image_has_rolled_since_its_exposure);
  RUN_TEST(test_a_frame_of_any_age_is_turned_by_an_angle_of_the_history);
  RUN_TEST(test_the_rate_limits_are_those_of_the_joints);
  RUN_TEST(test_without_frames_it_coasts_and_then_stops);
  RUN_TEST(test_bad_frames_change_nothing);
  RUN_TEST(test_parameters_out_of_range_are_refused);
  RUN_TEST(test_an_assumed_target_is_followed_like_one_that_was_seen);
  RUN_TEST(test_far_from_the_target_each_joint_approaches_at_the_rate_from_which_it_can_brake);
  return UNITY_END();
}
