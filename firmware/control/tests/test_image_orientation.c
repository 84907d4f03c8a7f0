/* SPDX-License-Identifier: Apache-2.0 */
/* The orientation of a picture, found from frames of a line of sight whose motion is known: turned, mirrored and scaled
 * pictures of targets at rest, at a constant rate, and of one that accelerates. */
#include "control/image_orientation.h"

#include "support/check.h"
#include "support/random.h"

#define PI 3.141592653589793
#define NOISE_RAD 2.3e-6
#define LEAST_RAD 1e-3f

static image_orientation pictures;

void setUp(void) { image_orientation_reset(&pictures); }
void tearDown(void) {}

typedef struct {
  double roll_rad; /* of the picture */
  double scale;
  bool mirrored;     /* its x */
  double to_x, to_y; /* the line of sight's acceleration, rad/s^2, which turns over after half of the pictures */
  double rate_rad_s; /* of the target, along both */
  double target_x;   /* its acceleration, rad/s^2 */
  double interval_s;
} film;

static film still(double roll_deg) {
  return (film){.roll_rad = roll_deg * PI / 180.0, .scale = 1.0, .to_x = 0.6, .to_y = -0.4, .interval_s = 0.02};
}

static double there_and_back(double acceleration, double t_s, double half_s) {
  const double late_s = t_s > half_s ? t_s - half_s : 0.0;
  return 0.5 * acceleration * (t_s * t_s - 2.0 * late_s * late_s);
}

static void show(const film *of, int count) {
  random_source random = {.state = 1};
  double before_x = 0.0, before_y = 0.0;
  for (int i = 0; i < count; ++i) {
    const double t_s = of->interval_s * i;
    const double half_s = 0.5 * of->interval_s * count;
    const double x = there_and_back(of->to_x, t_s, half_s);
    const double y = there_and_back(of->to_y, t_s, 0.6 * half_s);
    const double seen_x =
        (of->mirrored ? -1.0 : 1.0) * (0.005 + of->rate_rad_s * t_s + 0.5 * of->target_x * t_s * t_s - x);
    const double seen_y = -0.003 + of->rate_rad_s * t_s - y;
    const double c = of->scale * cos(of->roll_rad), s = of->scale * sin(of->roll_rad);
    const orientation_sample sample = {
        .interval_s = (float)of->interval_s,
        .moved = {.x = (float)(x - before_x), .y = (float)(y - before_y)},
        .error = {.x = (float)(c * seen_x - s * seen_y + NOISE_RAD * random_normal(&random)),
                  .y = (float)(s * seen_x + c * seen_y + NOISE_RAD * random_normal(&random))}};
    image_orientation_add(&pictures, &sample);
    before_x = x;
    before_y = y;
  }
}

static orientation_finding found_in(const film *of, int count) {
  image_orientation_reset(&pictures);
  show(of, count);
  return image_orientation_find(&pictures, LEAST_RAD);
}

/* Rolls all round, of targets at rest and at 5 deg/s: what is found turns the picture back. */
static void test_a_roll_is_found(void) {
  for (int deg = -175; deg <= 180; deg += 5) {
    film of = still(deg);
    of.rate_rad_s = deg % 2 == 0 ? 0.0 : 0.0873;
    const orientation_finding found = found_in(&of, ORIENTATION_SAMPLES);
    TEST_ASSERT_EQUAL_INT(ORIENTATION_TURNED, found.kind);
    TEST_ASSERT_TRUE(found.both);
    CHECK_NEAR("found", 0.0, remainder((double)found.roll_rad + of.roll_rad, 2.0 * PI), 5e-3);
    CHECK_NEAR("found", 1.0, found.scale, 5e-3);
  }
}

static void test_a_scale_is_found_up_to_three(void) {
  for (int i = 0; i < 4; ++i) {
    film of = still(20.0);
    of.scale = (double[]){0.5, 2.0, 0.3, 3.2}[i];
    const orientation_finding found = found_in(&of, ORIENTATION_SAMPLES);
    TEST_ASSERT_EQUAL_INT(i < 2 ? ORIENTATION_TURNED : ORIENTATION_UNCLEAR, found.kind);
    CHECK_NEAR("found", 1.0 / of.scale, found.scale, 0.01 / of.scale);
  }
}

/* Mirrored about each axis, and turned besides: the roll is that of the mirrored picture. */
static void test_a_mirrored_picture_is_found(void) {
  for (int deg = -150; deg <= 180; deg += 30) {
    film of = still(deg);
    of.mirrored = true;
    const orientation_finding found = found_in(&of, ORIENTATION_SAMPLES);
    TEST_ASSERT_EQUAL_INT(ORIENTATION_MIRRORED, found.kind);
    TEST_ASSERT_TRUE(found.both);
    /* e = R conj(flipped): conj(e) turned by the roll is the true error mirrored in y, half a turn from that in x */
    CHECK_NEAR("found", 0.0, remainder((double)found.roll_rad - of.roll_rad + PI, 2.0 * PI), 5e-3);
  }
}

/* One direction: half a turn is found, but what is across is not known. */
static void test_a_motion_along_one_direction_excludes_no_mirror(void) {
  film of = still(0.0);
  of.to_y = 0.0;
  orientation_finding found = found_in(&of, ORIENTATION_SAMPLES);
  TEST_ASSERT_EQUAL_INT(ORIENTATION_TURNED, found.kind);
  TEST_ASSERT_FALSE(found.both);
  CHECK_NEAR("found", 0.0, found.roll_rad, 5e-3);
  of.mirrored = true;
  found = found_in(&of, ORIENTATION_SAMPLES);
  TEST_ASSERT_EQUAL_INT(ORIENTATION_TURNED, found.kind);
  TEST_ASSERT_FALSE(found.both);
  CHECK_NEAR("found", PI, fabs((double)found.roll_rad), 5e-3);
}

/* A target that accelerates as much as the line of sight is no finding. */
static void test_a_target_that_accelerates_is_no_finding(void) {
  film of = still(0.0);
  of.to_y = 0.0;
  of.target_x = 0.6;
  TEST_ASSERT_EQUAL_INT(ORIENTATION_UNCLEAR, found_in(&of, ORIENTATION_SAMPLES).kind);
}

static void test_five_pictures_are_the_fewest(void) {
  film of = still(180.0);
  of.to_x = 5.0;
  TEST_ASSERT_EQUAL_INT(ORIENTATION_UNCLEAR, found_in(&of, ORIENTATION_FEWEST - 1).kind);
  const orientation_finding found = found_in(&of, ORIENTATION_FEWEST);
  TEST_ASSERT_EQUAL_INT(ORIENTATION_TURNED, found.kind);
  CHECK_NEAR("found", PI, fabs((double)found.roll_rad), 0.05);
}

/* How far the line of sight moved off its straight line, against the same in double. */
static void test_a_constant_rate_is_no_motion(void) {
  film of = still(0.0);
  of.to_x = 0.0;
  of.to_y = 0.0;
  CHECK_NEAR("found", 0.0, found_in(&of, ORIENTATION_SAMPLES).moved_rad, 1e-7);
  of.to_x = 0.6;
  of.interval_s = 0.04; /* the way is not the size of the pictures' number */
  double t[ORIENTATION_SAMPLES], s[ORIENTATION_SAMPLES], mt = 0, ms = 0, tt = 0, ts = 0, ss = 0;
  for (int i = 0; i < ORIENTATION_SAMPLES; ++i) {
    t[i] = of.interval_s * i;
    s[i] = there_and_back(of.to_x, t[i], 0.5 * of.interval_s * ORIENTATION_SAMPLES);
    mt += t[i] / ORIENTATION_SAMPLES;
    ms += s[i] / ORIENTATION_SAMPLES;
  }
  for (int i = 0; i < ORIENTATION_SAMPLES; ++i) {
    tt += (t[i] - mt) * (t[i] - mt);
    ts += (t[i] - mt) * (s[i] - ms);
    ss += (s[i] - ms) * (s[i] - ms);
  }
  CHECK_NEAR("found", sqrt((ss - ts * ts / tt) / ORIENTATION_SAMPLES), found_in(&of, ORIENTATION_SAMPLES).moved_rad,
             1e-5);
}

/* The ring keeps the newest pictures alone; of slow ones those of the last second: 10 pictures every 0.11 s. */
static void test_older_pictures_are_forgotten(void) {
  film of = still(180.0);
  show(&of, 17);
  of = still(0.0);
  show(&of, ORIENTATION_SAMPLES);
  CHECK_NEAR("found", 0.0, image_orientation_find(&pictures, LEAST_RAD).roll_rad, 5e-3);
  for (int newer = 9; newer <= 10; ++newer) {
    image_orientation_reset(&pictures);
    of = still(180.0);
    of.interval_s = 0.11;
    show(&of, 13);
    of.roll_rad = 0.0;
    show(&of, newer);
    const orientation_finding found = image_orientation_find(&pictures, LEAST_RAD);
    TEST_ASSERT_EQUAL_INT(newer < 10 ? ORIENTATION_UNCLEAR : ORIENTATION_TURNED, found.kind);
    CHECK_NEAR("found", 0.0, found.roll_rad, newer < 10 ? 4.0 : 5e-3);
  }
}

static void test_a_bad_picture_begins_anew(void) {
  const orientation_sample bad[] = {
      {.interval_s = 0.0f},
      {.interval_s = 0.51f},
      {.interval_s = 0.02f, .moved.x = NAN},
      {.interval_s = 0.02f, .moved.y = INFINITY},
      {.interval_s = 0.02f, .error.x = NAN},
      {.interval_s = 0.02f, .error.y = -101.0f},
  };
  const film of = still(90.0);
  for (size_t i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
    show(&of, ORIENTATION_SAMPLES);
    image_orientation_add(&pictures, &bad[i]);
    TEST_ASSERT_EQUAL_INT(0, pictures.count);
    TEST_ASSERT_EQUAL_INT(ORIENTATION_UNCLEAR, image_orientation_find(&pictures, LEAST_RAD).kind);
  }
}

/* Nothing moves: no division by zero. */
static void test_still_pictures_say_nothing(void) {
  const orientation_sample still_one = {.interval_s = 0.02f};
  for (int i = 0; i < ORIENTATION_SAMPLES; ++i) {
    image_orientation_add(&pictures, &still_one);
  }
  const orientation_finding found = image_orientation_find(&pictures, LEAST_RAD);
  TEST_ASSERT_EQUAL_INT(ORIENTATION_UNCLEAR, found.kind);
  TEST_ASSERT_FALSE(found.both);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_roll_is_found);
  RUN_TEST(test_a_scale_is_found_up_to_three);
  RUN_TEST(test_a_mirrored_picture_is_found);
  RUN_TEST(test_a_motion_along_one_direction_excludes_no_mirror);
  RUN_TEST(test_a_target_that_accelerates_is_no_finding);
  RUN_TEST(test_five_pictures_are_the_fewest);
  RUN_TEST(test_a_constant_rate_is_no_motion);
  RUN_TEST(test_older_pictures_are_forgotten);
  RUN_TEST(test_a_bad_picture_begins_anew);
  RUN_TEST(test_still_pictures_say_nothing);
  return UNITY_END();
}
