/* SPDX-License-Identifier: Apache-2.0 */
/* Verdicts on a picture, from a line of sight whose motion is given: it stands for 0.3 s, then both components run at
 * 0.1 rad/s, one of them later. The target moves at a constant rate. */
#include "servo/picture_check.h"

#include "support/check.h"

#define PI 3.141592653589793

static picture_check check;

void setUp(void) { picture_check_reset(&check); }
void tearDown(void) {}

typedef struct {
  double roll_deg; /* of the picture */
  bool mirrored;   /* its x */
  double x_rad_s;  /* of the line of sight, from 0.3 s on */
  double y_rad_s;  /* likewise, from 0.4 s on */
  int period_ms;
  int age_ms;
} film;

static const film kRight = {.x_rad_s = 0.1, .y_rad_s = -0.06, .period_ms = 20, .age_ms = 30};

static double along(double rate_rad_s, int ms, int from_ms) {
  return ms > from_ms ? 1e-3 * rate_rad_s * (ms - from_ms) : 0.0;
}

static image_vector sight(const film *of, int ms) {
  return (image_vector){.x = (float)along(of->x_rad_s, ms, 300), .y = (float)along(of->y_rad_s, ms, 400)};
}

static image_vector seen(const film *of, int ms) {
  const image_vector at = sight(of, ms);
  const double x = (of->mirrored ? -1.0 : 1.0) * (0.004 + 1e-5 * ms - (double)at.x);
  const double y = -0.002 + 2e-5 * ms - (double)at.y;
  const double c = cos(of->roll_deg * PI / 180.0), s = sin(of->roll_deg * PI / 180.0);
  return (image_vector){.x = (float)(c * x - s * y), .y = (float)(s * x + c * y)};
}

static image_vector minus(image_vector a, image_vector b) { return (image_vector){.x = a.x - b.x, .y = a.y - b.y}; }

/* Returns the ms in which the verdict was first not 0; -1: never. */
static int show(const film *of, int from_ms, int to_ms) {
  int judged = -1;
  for (int ms = from_ms; ms < to_ms; ++ms) {
    picture_check_tick(&check, minus(sight(of, ms), sight(of, ms - 1)), false);
    if (ms >= of->age_ms && (ms - of->age_ms) % of->period_ms == 0) {
      const int then = ms - of->age_ms;
      picture_check_take(&check, seen(of, then), minus(sight(of, ms), sight(of, then)), of->age_ms);
    }
    judged = judged < 0 && check.verdict != PICTURE_NOT_JUDGED ? ms : judged;
  }
  return judged;
}

static picture_verdict verdict_on(film of, int *judged_ms) {
  picture_check_reset(&check);
  *judged_ms = show(&of, 0, 900);
  return check.verdict;
}

/* 300 ms at rest, 40 ms until 0.2 mrad off the straight line are reached, and the age. */
static void test_a_right_picture_is_known_soon_after_the_line_of_sight_has_moved(void) {
  int judged_ms = 0;
  TEST_ASSERT_EQUAL_INT(PICTURE_RIGHT, verdict_on(kRight, &judged_ms));
  CHECK_NEAR("judged, ms", 370, judged_ms, 30);
  TEST_ASSERT_FALSE(check.doubted);
  TEST_ASSERT_EQUAL(0, check.doubted_ticks);
  TEST_ASSERT_TRUE(check.complete);
  film of = kRight;
  of.y_rad_s = 0.0;
  TEST_ASSERT_EQUAL_INT(PICTURE_RIGHT, verdict_on(of, &judged_ms));
  TEST_ASSERT_FALSE(check.complete); /* a mirror is not excluded */
}

static void test_a_turned_picture_warns_from_45_degrees_and_is_wrong_from_60(void) {
  static const struct {
    double roll_deg;
    picture_verdict verdict;
  } cases[] = {{43.0, PICTURE_RIGHT},       {-43.0, PICTURE_RIGHT},     {47.0, PICTURE_TURNED},
               {-58.0, PICTURE_TURNED},     {62.0, PICTURE_WRONG_ROLL}, {-62.0, PICTURE_WRONG_ROLL},
               {120.0, PICTURE_WRONG_ROLL}, {180.0, PICTURE_WRONG_ROLL}};
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    film of = kRight;
    of.roll_deg = cases[i].roll_deg;
    int judged_ms = 0;
    TEST_ASSERT_EQUAL_INT(cases[i].verdict, verdict_on(of, &judged_ms));
    CHECK_NEAR("missing, rad", 0.0, remainder((double)check.roll_rad + of.roll_deg * PI / 180.0, 2.0 * PI), 0.02);
    TEST_ASSERT_EQUAL(cases[i].verdict == PICTURE_WRONG_ROLL, picture_check_is_wrong(&check));
  }
}

/* Along one direction at first; that the other one is wrong shows when it moves. */
static void test_a_mirrored_picture_is_wrong_in_whichever_direction_moves_first(void) {
  film of = kRight;
  of.mirrored = true;
  int judged_ms = 0;
  TEST_ASSERT_TRUE(verdict_on(of, &judged_ms) >= PICTURE_WRONG_ROLL);
  of.x_rad_s = 0.0; /* what moves is right */
  TEST_ASSERT_EQUAL_INT(PICTURE_RIGHT, verdict_on(of, &judged_ms));
  TEST_ASSERT_FALSE(check.complete);
  of.mirrored = false;
  of.roll_deg = 180.0; /* what moves is wrong */
  TEST_ASSERT_EQUAL_INT(PICTURE_WRONG_ROLL, verdict_on(of, &judged_ms));
  of = kRight;
  of.mirrored = true;
  of.x_rad_s = 0.03; /* both, the right one more */
  of.y_rad_s = 0.1;
  TEST_ASSERT_EQUAL_INT(PICTURE_MIRRORED, verdict_on(of, &judged_ms));
}

/* A wrong picture needs 1 mrad off the straight line, and two findings at least: at 10 Hz, too. */
static void test_few_pictures_are_enough(void) {
  film of = kRight;
  of.period_ms = 100;
  of.roll_deg = 180.0;
  int judged_ms = 0;
  TEST_ASSERT_EQUAL_INT(PICTURE_WRONG_ROLL, verdict_on(of, &judged_ms));
  of.period_ms = 2;
  TEST_ASSERT_EQUAL_INT(PICTURE_WRONG_ROLL, verdict_on(of, &judged_ms));
  CHECK_NEAR("judged, ms", 430, judged_ms, 30);
  of.x_rad_s = 0.005;
  of.y_rad_s = 0.0;
  TEST_ASSERT_EQUAL_INT(PICTURE_NOT_JUDGED, verdict_on(of, &judged_ms));
}

/* 0.2 mrad off the straight line: noise alone must not prove a picture. */
static void test_a_picture_of_too_little_motion_is_not_judged(void) {
  film of = kRight;
  of.y_rad_s = 0.0;
  int judged_ms = 0;
  of.x_rad_s = 0.005;
  TEST_ASSERT_EQUAL_INT(PICTURE_NOT_JUDGED, verdict_on(of, &judged_ms));
  of.x_rad_s = 0.0065;
  TEST_ASSERT_EQUAL_INT(PICTURE_RIGHT, verdict_on(of, &judged_ms));
}

static void test_a_verdict_of_wrong_stays_until_it_is_reset(void) {
  film of = kRight;
  of.roll_deg = 180.0;
  int judged_ms = 0;
  TEST_ASSERT_EQUAL_INT(PICTURE_WRONG_ROLL, verdict_on(of, &judged_ms));
  (void)show(&kRight, 0, 900);
  TEST_ASSERT_EQUAL_INT(PICTURE_WRONG_ROLL, check.verdict);
  picture_check_reset(&check);
  (void)show(&kRight, 0, 900);
  TEST_ASSERT_EQUAL_INT(PICTURE_RIGHT, check.verdict);
}

/* Whenever a wrong film ends, the right one after it is judged as if it were the first. */
static void test_a_reset_leaves_nothing_of_before(void) {
  int first_ms = 0;
  TEST_ASSERT_EQUAL_INT(PICTURE_RIGHT, verdict_on(kRight, &first_ms));
  film wrong = kRight;
  wrong.roll_deg = 180.0;
  picture_check_reset(&check);
  const int first_wrong_ms = show(&wrong, 0, 900);
  for (int cut_ms = 1; cut_ms < 900; cut_ms += 7) {
    picture_check_reset(&check);
    (void)show(&wrong, 0, cut_ms);
    picture_check_reset(&check);
    TEST_ASSERT_EQUAL_INT(PICTURE_NOT_JUDGED, check.verdict);
    CHECK_SAME("roll, rad", 0.0, check.roll_rad);
    TEST_ASSERT_EQUAL_INT(first_ms, show(&kRight, 0, 900));
    TEST_ASSERT_TRUE(check.complete);
    picture_check_reset(&check);
    (void)show(&wrong, 0, cut_ms);
    picture_check_reset(&check);
    TEST_ASSERT_EQUAL_INT(first_wrong_ms, show(&wrong, 0, 900));
  }
}

/* A picture that was right in both directions is not judged again. */
static void test_a_complete_verdict_stays(void) {
  (void)show(&kRight, 0, 900);
  TEST_ASSERT_TRUE(check.complete);
  film of = kRight;
  of.roll_deg = 180.0;
  (void)show(&of, 0, 900);
  TEST_ASSERT_EQUAL_INT(PICTURE_RIGHT, check.verdict);
}

/* Along one axis at a constant rate, which shows nothing. 50 Hz; the error changes by `error_rad_s`. Returns the ms of
 * the verdict. */
static int hold_along(bool vertical, double rate_rad_s, double error_rad_s) {
  picture_check_reset(&check);
  for (int ms = 0; ms < 5000; ++ms) {
    const float step_rad = (float)(1e-3 * rate_rad_s);
    const image_vector moved = {.x = vertical ? 0.0f : step_rad, .y = vertical ? step_rad : 0.0f};
    picture_check_tick(&check, moved, false);
    if (ms % 20 == 0) {
      const image_vector error = {.x = (float)(0.01 + 1e-3 * error_rad_s * ms)};
      picture_check_take(&check, error, (image_vector){0}, 0);
    }
    if (check.verdict != PICTURE_NOT_JUDGED) {
      return ms;
    }
  }
  return -1;
}

/* 0.15 rad at 0.1 rad/s: 1.5 s. One that came nearer is not stopped. */
static void test_a_picture_that_does_not_answer_stops_the_axes(void) {
  for (int vertical = 0; vertical <= 1; ++vertical) {
    CHECK_NEAR("stopped, ms", 1530, hold_along(vertical != 0, 0.1, 0.04), 30);
    TEST_ASSERT_EQUAL_INT(PICTURE_NO_ANSWER, check.verdict);
    TEST_ASSERT_TRUE(picture_check_is_wrong(&check));
    CHECK_NEAR("stopped, ms", 1530, hold_along(vertical != 0, -0.1, 0.0), 30);
    TEST_ASSERT_EQUAL_INT(-1, hold_along(vertical != 0, 0.1, -0.001));
  }
}

/* The target of the last camera came no nearer. Without a picture of the next one nothing says so of it. */
static void test_after_a_reset_the_limit_stays_until_there_is_a_picture(void) {
  (void)hold_along(false, 0.02, 0.0);
  TEST_ASSERT_EQUAL_INT(PICTURE_NOT_JUDGED, check.verdict);
  picture_check_reset(&check);
  const float limit_rad_s = check.rate_limit_rad_s;
  for (int ms = 0; ms < 2 * PICTURE_VARIES_TICKS; ++ms) {
    picture_check_tick(&check, (image_vector){0}, false);
    CHECK_SAME("limit, rad/s", limit_rad_s, check.rate_limit_rad_s);
  }
}

/* Away at 0.1 rad/s for 1 s; then it follows for 0.1 s; then away again, for 1.5 s from there. */
static void test_what_the_axes_have_moved_counts_from_the_last_time_that_the_target_was_followed(void) {
  int stopped_ms = 0;
  for (int ms = 0; ms < 5000 && stopped_ms == 0; ++ms) {
    picture_check_tick(&check, (image_vector){.x = 1e-4f}, ms >= 990 && ms < 1090);
    if (ms % 20 == 0) {
      picture_check_take(&check, (image_vector){.x = 0.01f}, (image_vector){0}, 0);
    }
    stopped_ms = check.verdict != PICTURE_NOT_JUDGED ? ms : 0;
  }
  TEST_ASSERT_EQUAL_INT(PICTURE_NO_ANSWER, check.verdict);
  CHECK_NEAR("stopped, ms", 1080 + 1500, stopped_ms, 30);
}

/* Half of it before the third picture; of more than 40 ms between two pictures, up to 100, it has the less the more. */
static void test_the_limit_is_lower_for_a_slow_camera(void) {
  static const struct {
    int period_ms;
    double limit_rad_s;
  } rows[] = {{18, 0.1}, {40, 0.1}, {50, 0.08}, {80, 0.05}, {100, 0.04}, {200, 0.04}};
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    picture_check_reset(&check);
    CHECK_NEAR("before the first, rad/s", 0.02, check.rate_limit_rad_s, 1e-7);
    for (int picture = 1; picture <= 4; ++picture) {
      for (int ms = 0; ms < rows[i].period_ms; ++ms) {
        picture_check_tick(&check, (image_vector){0}, false);
      }
      picture_check_take(&check, (image_vector){.x = 0.01f - 1e-4f * (float)picture}, (image_vector){0}, 0);
      CHECK_NEAR("limit, rad/s", (picture < 3 ? 0.5 : 1.0) * rows[i].limit_rad_s, check.full_limit_rad_s, 1e-7);
    }
  }
}

/* 17 ms after the one before, by their exposures, it does not count; 18 ms after it does. */
static void test_pictures_that_follow_each_other_too_soon_do_not_count(void) {
  for (int ms = 0; ms < 100; ++ms) {
    picture_check_tick(&check, (image_vector){0}, false);
    picture_check_take(&check, (image_vector){.x = 0.01f}, (image_vector){0}, 0);
    TEST_ASSERT_EQUAL_INT((ms + 1) / PICTURE_SPACING_TICKS, check.pictures.count);
  }
}

/* Round in circles of 0.05 rad at 0.04 rad/s, with a target that is nearer than at first: 0.15 rad more way than
 * distance, which is 0.1 rad at most. */
static void test_a_picture_after_which_the_axes_go_round_in_circles_stops_them(void) {
  int stopped_ms = 0;
  for (int ms = 0; ms < 10000 && stopped_ms == 0; ++ms) {
    const double angle_rad = 0.8e-3 * ms;
    const image_vector moved = {.x = (float)(0.04e-3 * cos(angle_rad)), .y = (float)(0.04e-3 * sin(angle_rad))};
    picture_check_tick(&check, moved, false);
    if (ms % 20 == 0) {
      const float off_rad = ms == 0 ? 0.05f : 0.01f;
      picture_check_take(&check, (image_vector){.x = off_rad}, (image_vector){0}, 0);
    }
    stopped_ms = check.verdict != PICTURE_NOT_JUDGED ? ms : 0;
  }
  TEST_ASSERT_EQUAL_INT(PICTURE_NO_ANSWER, check.verdict);
  TEST_ASSERT_TRUE(stopped_ms > 3750 && stopped_ms < 6500);
}

/* Held at the limit, in ms after the first picture, for which the axes wait for 150 ms; the limit begins anew after the
 * last ms in which the target has been followed. */
static void test_the_limit_varies_while_it_holds(void) {
  for (int ms = 0; ms < 150; ++ms) {
    picture_check_tick(&check, (image_vector){0}, false);
  }
  for (int round = 0; round < 2; ++round) {
    for (int ms = 0; ms < 2000; ++ms) {
      picture_check_tick(&check, (image_vector){0}, false);
      if (ms % 20 == 0) {
        picture_check_take(&check, (image_vector){.x = 0.01f}, (image_vector){0}, 0);
      }
      const int held_ms = ms + round;
      if (ms > 200) {
        const bool slower = held_ms / PICTURE_VARIES_TICKS % 2 == 1;
        CHECK_NEAR("limit, rad/s", slower ? 0.025 : 0.1, check.rate_limit_rad_s, 1e-6);
      }
    }
    picture_check_tick(&check, (image_vector){0}, true);
  }
}

/* Followed without the limit for 1.5 s in one piece. */
static void test_a_target_that_is_followed_proves_its_picture(void) {
  for (int interrupted = 0; interrupted < 3; ++interrupted) {
    for (int ms = 0; ms < PICTURE_PROVEN_TICKS - 1; ++ms) {
      picture_check_tick(&check, (image_vector){0}, true);
    }
    TEST_ASSERT_EQUAL_INT(PICTURE_NOT_JUDGED, check.verdict);
    if (interrupted == 0) {
      picture_check_tick(&check, (image_vector){0}, false);
    } else if (interrupted == 1) {
      picture_check_reset(&check);
    }
  }
  picture_check_tick(&check, (image_vector){0}, true);
  TEST_ASSERT_EQUAL_INT(PICTURE_RIGHT, check.verdict);
}

/* Away at 0.1 rad/s for 5 s, and it comes no nearer: a fast target, because its picture is known to be right. */
static void test_a_picture_that_was_right_needs_no_answer(void) {
  for (int ms = 0; ms < PICTURE_PROVEN_TICKS; ++ms) {
    picture_check_tick(&check, (image_vector){0}, true);
  }
  for (int ms = 0; ms < 5000; ++ms) {
    picture_check_tick(&check, (image_vector){.x = 1e-4f}, false);
    if (ms % 20 == 0) {
      picture_check_take(&check, (image_vector){.x = 0.01f}, (image_vector){0}, 0);
    }
  }
  TEST_ASSERT_EQUAL_INT(PICTURE_RIGHT, check.verdict);
}

/* A target that stands is seen for 0.2 s; without it the axis returns by 0.18 rad in 3 s, and sees it again. What the
 * axis did meanwhile says nothing about the picture. */
static void test_a_return_without_the_target_is_no_way_round_it(void) {
  picture_check_reset(&check);
  const image_vector error_rad = {.x = 0.01f};
  for (int ms = 0; ms < 200; ++ms) {
    picture_check_tick(&check, (image_vector){0}, false);
    if (ms % 20 == 0) {
      picture_check_take(&check, error_rad, (image_vector){0}, 0);
    }
  }
  for (int ms = 0; ms < 3000; ++ms) {
    picture_check_tick(&check, (image_vector){.x = 6e-5f}, false);
  }
  picture_check_take(&check, error_rad, (image_vector){0}, 0);
  TEST_ASSERT_EQUAL_INT(PICTURE_NOT_JUDGED, check.verdict);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_right_picture_is_known_soon_after_the_line_of_sight_has_moved);
  RUN_TEST(test_a_turned_picture_warns_from_45_degrees_and_is_wrong_from_60);
  RUN_TEST(test_a_mirrored_picture_is_wrong_in_whichever_direction_moves_first);
  RUN_TEST(test_few_pictures_are_enough);
  RUN_TEST(test_a_picture_of_too_little_motion_is_not_judged);
  RUN_TEST(test_a_verdict_of_wrong_stays_until_it_is_reset);
  RUN_TEST(test_a_reset_leaves_nothing_of_before);
  RUN_TEST(test_a_complete_verdict_stays);
  RUN_TEST(test_a_picture_that_does_not_answer_stops_the_axes);
  RUN_TEST(test_what_the_axes_have_moved_counts_from_the_last_time_that_the_target_was_followed);
  RUN_TEST(test_the_limit_is_lower_for_a_slow_camera);
  RUN_TEST(test_pictures_that_follow_each_other_too_soon_do_not_count);
  RUN_TEST(test_a_picture_after_which_the_axes_go_round_in_circles_stops_them);
  RUN_TEST(test_the_limit_varies_while_it_holds);
  RUN_TEST(test_after_a_reset_the_limit_stays_until_there_is_a_picture);
  RUN_TEST(test_a_target_that_is_followed_proves_its_picture);
  RUN_TEST(test_a_picture_that_was_right_needs_no_answer);
  RUN_TEST(test_a_return_without_the_target_is_no_way_round_it);
  return UNITY_END();
}
