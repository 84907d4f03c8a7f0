/* SPDX-License-Identifier: Apache-2.0 */
/* When the line of sight will be back: predictions against what then happens to the tracking loop with joints that keep
 * their limits. Targets and joints are in double; the camera has 50 Hz, 20 ms and noise, and sees +-11 mrad. */
#include "control/target_return.h"

#include "base/scalar.h"
#include "control/pointing_tracker.h"
#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

#define DEG (3.141592653589793 / 180.0)
#define TURN_RAD 6.283185307179586
#define TURN32_PER_RAD (4294967296.0 / 6.283185307179586)

enum { FRAME_TICKS = 20, DELAY_TICKS = 20 };
static const double kTick_s = 1e-3;
static const double kFasterThanLimit_s = 15.0; /* before the closest approach it is followed */

static const float kRateLimit_rad_s = 1.0471976f;
static const double kLost_rad = 50e-6;
static const double kStepBand_s = 0.02; /* two steps of the prediction */
/* Half a picture, 6 mrad, is below 1 mrad when the estimator of 6 rad/s has had 0.29 s, after the first frame. */
static const double kCoastBand_s = 0.33;
static const target_return_limits kLimits = {.proportional_per_s = 30.0f,
                                             .rate_limit_rad_s = {1.0471976f, 1.0471976f},
                                             .acceleration_limit_rad_s2 = {5.0f, 5.0f}};

/* 20 m/s along y, level; closest at (x, 0, height) at time 0. */
typedef struct {
  double x_m;
  double height_m;
  double time_s;
  double angle_rad[2]; /* of the joints: azimuth, pitch */
  double rate_rad_s[2];
  image_vector seen[DELAY_TICKS + 1];
  bool visible[DELAY_TICKS + 1];
  int tick;
  random_source random;
  double acceleration_rad_s2; /* limit */
  pointing_tracker_params loop;
  pointing_tracker_state tracker;
  pointing_command out;
  double miss_rad;
} flight;

static flight flight_at(double elevation_rad, double height_m, double acceleration_rad_s2) {
  const float limit_rad_s2 = (float)acceleration_rad_s2;
  flight f = {.x_m = height_m / tan(elevation_rad),
              .height_m = height_m,
              .time_s = -kFasterThanLimit_s,
              .random = {3},
              .acceleration_rad_s2 = acceleration_rad_s2,
              .loop = {.proportional_per_s = 30.0f,
                       .estimator_rad_s = 6.0f,
                       .coast_s = 5.0f,
                       .rate_limit_rad_s = {kRateLimit_rad_s, kRateLimit_rad_s},
                       .braking_rad_s2 = {limit_rad_s2, limit_rad_s2}}};
  const double y_m = 20.0 * f.time_s;
  f.angle_rad[0] = atan2(y_m, f.x_m);
  f.angle_rad[1] = atan2(height_m, hypot(f.x_m, y_m));
  return f;
}

static void look(flight *f) {
  const double place[] = {f->x_m, 20.0 * f->time_s, f->height_m};
  const double ahead = cos(f->angle_rad[0]) * place[0] + sin(f->angle_rad[0]) * place[1];
  const double left = -sin(f->angle_rad[0]) * place[0] + cos(f->angle_rad[0]) * place[1];
  const double forward = cos(f->angle_rad[1]) * ahead + sin(f->angle_rad[1]) * place[2];
  const double up = -sin(f->angle_rad[1]) * ahead + cos(f->angle_rad[1]) * place[2];
  f->miss_rad = atan2(hypot(left, up), forward);
  const int slot = f->tick % (DELAY_TICKS + 1);
  f->visible[slot] = f->miss_rad < 11e-3;
  f->seen[slot] = (image_vector){(float)(left / forward + 2.3e-6 * random_normal(&f->random)),
                                 (float)(up / forward + 2.3e-6 * random_normal(&f->random))};
}

/* One tick of joints that follow their rates within the limits. */
static void fly(flight *f) {
  for (int i = 0; i < 2; ++i) {
    f->angle_rad[i] += f->rate_rad_s[i] * kTick_s;
  }
  look(f);
  const int slot = (f->tick + 1) % (DELAY_TICKS + 1);
  const pointing_frame frame = {.fresh = f->tick >= DELAY_TICKS && f->tick % FRAME_TICKS == 0,
                                .valid = f->visible[slot],
                                .age_ticks = DELAY_TICKS,
                                .error = f->seen[slot]};
  const rotation pitch = rotation_of((angle_turn32)(int64_t)llround(f->angle_rad[1] * TURN32_PER_RAD));
  const line_of_sight_rates los = line_of_sight_of_joints(pitch, (float)f->rate_rad_s[0], (float)f->rate_rad_s[1]);
  f->out = pointing_tracker_step(&f->tracker, &f->loop, &frame, &los, pitch, (float)kTick_s);
  pointing_tracker_prepare(&f->tracker, &f->loop, f->out.error_of_joints_rad, (float)kTick_s);
  const double wanted[] = {(double)f->out.rate_rad_s.azimuth, (double)f->out.rate_rad_s.pitch};
  for (int i = 0; i < 2; ++i) {
    const double step = f->acceleration_rad_s2 * kTick_s;
    f->rate_rad_s[i] += fmax(-step, fmin(step, wanted[i] - f->rate_rad_s[i]));
  }
  f->time_s += kTick_s;
  f->tick++;
}

static void begin(target_return *back, const flight *f) {
  const joint_vector joint_rad = {(float)f->angle_rad[0], (float)f->angle_rad[1]};
  const pointing_target target = pointing_tracker_target(&f->tracker);
  const target_return_start start = {.path = target_path_straight(joint_rad, &target),
                                     .joint_rad = joint_rad,
                                     .joint_rad_s = {(float)f->rate_rad_s[0], (float)f->rate_rad_s[1]}};
  target_return_limits limits = kLimits;
  limits.acceleration_limit_rad_s2 = f->loop.braking_rad_s2;
  target_return_begin(back, &limits, &start);
}

typedef struct {
  double limited_s;   /* the target was first too fast */
  double first_s;     /* when it was to be back, by the first prediction */
  double midway_s;    /* by the last one before half of the time had passed */
  double back_s;      /* when it was */
  double lost_from_s; /* first and last time with more than kLost_rad */
  double lost_to_s;
} passage;

static passage passage_of(double elevation_rad, double height_m, double acceleration_rad_s2) {
  flight f = flight_at(elevation_rad, height_m, acceleration_rad_s2);
  target_return back = {0};
  double times[100];
  double answers[100];
  int count = 0;
  double begun_s = 0.0;
  passage p = {.limited_s = (double)NAN, .back_s = (double)NAN, .lost_from_s = (double)NAN};
  while (f.time_s < 15.0) {
    fly(&f);
    const bool settled = f.time_s > 5.0 - kFasterThanLimit_s;
    if (settled && f.out.limited && isnan(p.limited_s)) {
      p.limited_s = f.time_s;
    }
    if (settled && f.miss_rad > kLost_rad) {
      p.lost_from_s = isnan(p.lost_from_s) ? f.time_s : p.lost_from_s;
      p.lost_to_s = f.time_s;
    }
    if (isnan(p.limited_s)) {
      continue;
    }
    if (!back.running && f.out.limited && count < 100) {
      begin(&back, &f);
      begun_s = f.time_s;
    }
    const bool ran = back.running;
    target_return_step(&back);
    if (ran && !back.running && back.found) {
      times[count] = f.time_s;
      answers[count++] = begun_s + (double)back.after_s;
    }
    const bool here = !f.out.limited && f.miss_rad <= (double)TARGET_RETURN_MISS_RAD;
    if (!here) {
      p.back_s = (double)NAN;
    } else if (isnan(p.back_s)) {
      p.back_s = f.time_s;
    }
  }
  TEST_ASSERT_TRUE(count > 0 && !isnan(p.back_s));
  p.first_s = answers[0];
  for (int i = 0; i < count && times[i] <= 0.5 * (p.limited_s + p.back_s); ++i) {
    p.midway_s = answers[i];
  }
  LOG_VALUE("lost from, s", p.lost_from_s);
  LOG_VALUE("lost for, s", p.lost_to_s - p.lost_from_s);
  LOG_VALUE("first prediction minus truth, s", p.first_s - p.back_s);
  LOG_VALUE("midway, s", p.midway_s - p.back_s);
  return p;
}

/* The time-optimal plan follows the target until it needs more than a limit, turns at the limits, and meets the target
 * with its rate. `optimal_s` is its time, of sim_host's optimal_lost_s. */
typedef struct {
  double elevation_rad;
  double height_m;
  double acceleration_rad_s2;
  double optimal_s;
} pass;

static void expect(const pass *flown, double band_s) {
  const passage p = passage_of(flown->elevation_rad, flown->height_m, flown->acceleration_rad_s2);
  CHECK_NEAR("back by the first prediction, s", p.back_s, p.first_s, band_s);
  CHECK_NEAR("back by the last one before half of the time, s", p.back_s, p.midway_s, band_s);
  CHECK_AT_MOST("lost / time-optimal", 1.1, (p.lost_to_s - p.lost_from_s) / flown->optimal_s);
}

static void test_at_88_degrees_the_return_is_predicted_and_time_optimal(void) {
  expect(&(pass){88.0 * DEG, 500.0, 5.0, 0.864}, kStepBand_s);
  expect(&(pass){88.0 * DEG, 500.0, 1.0, 1.146}, kStepBand_s);
}

static void test_at_150_m_the_return_is_predicted_and_time_optimal(void) {
  expect(&(pass){85.0 * DEG, 150.0, 5.0, 1.632}, kStepBand_s);
  expect(&(pass){85.0 * DEG, 150.0, 1.0, 2.338}, kStepBand_s);
}

/* The target leaves the picture for seconds, and comes back as far from its estimate as coasting erred. */
static void test_through_the_zenith_the_return_is_predicted_and_time_optimal(void) {
  expect(&(pass){90.0 * DEG, 500.0, 5.0, 3.208}, kCoastBand_s);
  expect(&(pass){90.0 * DEG, 500.0, 1.0, 4.048}, kCoastBand_s);
}

/* Straight ahead, at rest: there is nothing to wait for. */
static target_return_start at_rest(image_vector error) {
  const pointing_target target = {.error = error};
  return (target_return_start){.path = target_path_straight((joint_vector){0}, &target)};
}

static void run(target_return *back) {
  for (int i = 0; i < 2 * TARGET_RETURN_STEPS && back->running; ++i) {
    target_return_step(back);
  }
}

static void test_on_the_target_it_is_back_at_once(void) {
  target_return back = {0};
  const target_return_start start = at_rest((image_vector){0});
  target_return_begin(&back, &kLimits, &start);
  TEST_ASSERT_TRUE(back.running);
  run(&back);
  TEST_ASSERT_TRUE(back.found && back.steps == TARGET_RETURN_HELD_STEPS);
  CHECK_SAME("s", 0.0, back.after_s);
  target_return_begin(&back, &kLimits, &start); /* once more */
  run(&back);
  TEST_ASSERT_TRUE(back.found && back.steps == TARGET_RETURN_HELD_STEPS);
}

/* 0.5 rad beside the line of sight, without a limit of the acceleration: 0.444 s at the rate limit until 30 1/s times
 * the rest is less, then 0.118 s to 1 mrad. */
static void test_a_target_at_rest_takes_the_time_at_the_limit_and_that_of_the_loop(void) {
  target_return back = {0};
  target_return_limits limits = kLimits;
  limits.acceleration_limit_rad_s2 = (joint_vector){1e4f, 1e4f};
  const target_return_start aside = at_rest((image_vector){.x = (float)tan(0.5)});
  target_return_begin(&back, &limits, &aside);
  run(&back);
  TEST_ASSERT_TRUE(back.found);
  CHECK_NEAR("s", 0.562, back.after_s, 0.03);
  const target_return_start above = at_rest((image_vector){.y = (float)tan(0.5)});
  const float azimuth_s = back.after_s;
  target_return_begin(&back, &limits, &above);
  run(&back);
  CHECK_NEAR("the pitch takes as long", azimuth_s, back.after_s, 0.011);
}

static void test_a_target_that_is_always_faster_is_not_met_again(void) {
  target_return back = {0};
  const joint_vector joint_rad = {.pitch = 1.5f};
  const pointing_target target = {.rate_rad_s = {.x = 3.0f, .y = 4.0f}};
  const target_return_start start = {.path = target_path_straight(joint_rad, &target), .joint_rad = joint_rad};
  const target_return_limits slow = {.proportional_per_s = 30.0f, .rate_limit_rad_s = {1e-3f, 1e-3f}};
  target_return_begin(&back, &slow, &start);
  run(&back);
  TEST_ASSERT_FALSE(back.running || back.found);
  TEST_ASSERT_EQUAL_INT(TARGET_RETURN_STEPS, back.steps);
  target_return_step(&back); /* without a prediction that runs nothing happens */
  TEST_ASSERT_EQUAL_INT(TARGET_RETURN_STEPS, back.steps);
}

/* 0.2 rad/s to the left, from 280 degrees on: 1 rad/s and 1 rad/s^2 cover a turn in 6.44 s, and the loop needs 0.2 s
 * more to 1 mrad. */
static void test_by_turning_back_the_azimuth_meets_a_target_that_goes_round(void) {
  const target_return_limits limits = {.proportional_per_s = 30.0f,
                                       .rate_limit_rad_s = {1.0f, 1.0f},
                                       .acceleration_limit_rad_s2 = {1.0f, 1.0f},
                                       .azimuth_travel = {-4.88f, 4.88f}};
  target_return_start start = {.path = target_path_round((joint_vector){4.882f, 0.4f}, (joint_vector){.azimuth = 0.2f}),
                               .joint_rad = {4.88f, 0.4f},
                               .joint_rad_s = {.azimuth = 0.2f},
                               .direction = -1.0f};
  target_return back = {0};
  target_return_begin(&back, &limits, &start);
  run(&back);
  TEST_ASSERT_TRUE(back.found);
  CHECK_NEAR("s", TURN_RAD / 1.2 + 1.2, back.after_s, 0.2);
  CHECK_NEAR("a turn less, rad", 4.88 + 0.2 * (double)back.after_s - TURN_RAD, back.now.joint_rad.azimuth, 0.05);
  start.direction = 0.0f;
  target_return_begin(&back, &limits, &start);
  run(&back);
  TEST_ASSERT_FALSE(back.found); /* it stands at the end of the travel, until half a turn is shorter */
  start.path = target_path_round((joint_vector){4.88f, 0.4f}, (joint_vector){.azimuth = -0.2f});
  target_return_begin(&back, &limits, &start);
  run(&back);
  TEST_ASSERT_TRUE(back.found); /* a target that comes back is followed */
}

/* Without noise: the first step on the target is that whose rate needs no limit and whose miss is at most 1 mrad. */
static void test_it_is_back_at_the_first_of_twenty_steps_on_the_target(void) {
  target_return back = {0};
  const target_return_start aside = at_rest((image_vector){.x = (float)tan(0.1)});
  target_return_begin(&back, &kLimits, &aside);
  int first = -1;
  while (back.running) {
    const double miss_rad =
        fabs((double)atanf(aside.path.place[1] / aside.path.place[0]) - (double)back.now.joint_rad.azimuth);
    first = miss_rad > (double)TARGET_RETURN_MISS_RAD ? -1 : first < 0 ? back.steps : first;
    target_return_step(&back);
  }
  TEST_ASSERT_TRUE(back.found && first > 10);
  TEST_ASSERT_EQUAL_INT(first + TARGET_RETURN_HELD_STEPS, back.steps);
  CHECK_NEAR("s", 0.01 * first, back.after_s, 1e-6);
}

static void test_a_turn_in_one_direction_takes_the_longer_turn(void) {
  static const struct {
    const char *what;
    float difference_rad;
    float direction;
    double turn_rad;
  } rows[] = {
      {"the shorter turn", 1.0f, 0.0f, 1.0},
      {"the shorter turn", -3.0f, 0.0f, -3.0},
      {"the shorter turn, beyond half a turn", 4.0f, 0.0f, 4.0 - TURN_RAD},
      {"the shorter turn, beyond two turns", -14.0f, 0.0f, 2.0 * TURN_RAD - 14.0},
      {"forwards, and the target is ahead", 1.0f, 1.0f, 1.0},
      {"backwards, and the target is ahead", 1.0f, -1.0f, 1.0 - TURN_RAD},
      {"forwards, and the target is behind", -1.0f, 1.0f, TURN_RAD - 1.0},
      {"backwards, and the target is behind", -1.0f, -1.0f, -1.0},
      {"forwards, beyond half a turn", 4.0f, 1.0f, 4.0},
      {"backwards, beyond a turn", 7.0f, -1.0f, 7.0 - 2.0 * TURN_RAD},
      {"on the target", 0.0f, -1.0f, 0.0},
  };
  for (unsigned i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    CHECK_NEAR(rows[i].what, rows[i].turn_rad, target_return_error_rad(rows[i].difference_rad, rows[i].direction),
               2e-6);
  }
}

/* The time to 1 mrad of a target at rest 0.5 rad away, along one joint. */
static double time_to_s(const target_return_limits *limits, image_vector error) {
  target_return back = {0};
  const target_return_start start = at_rest(error);
  target_return_begin(&back, limits, &start);
  run(&back);
  TEST_ASSERT_TRUE(back.found);
  return (double)back.after_s;
}

static void test_each_joint_has_its_own_limits(void) {
  const image_vector aside = {.x = (float)tan(0.5)};
  const image_vector above = {.y = (float)tan(0.5)};
  target_return_limits limits = {
      .proportional_per_s = 30.0f, .rate_limit_rad_s = {1.0f, 0.5f}, .acceleration_limit_rad_s2 = {1e4f, 5e3f}};
  CHECK_NEAR("azimuth at 1 rad/s, s", 0.467 + 0.1, time_to_s(&limits, aside), 0.03);
  CHECK_NEAR("pitch at 0.5 rad/s, s", 0.967 + 0.09, time_to_s(&limits, above), 0.03);
  limits.rate_limit_rad_s = (joint_vector){10.0f, 20.0f};
  limits.acceleration_limit_rad_s2 = (joint_vector){2.0f, 0.5f};
  CHECK_NEAR("azimuth at 2 rad/s^2, s", 2.0 * sqrt(0.5 / 2.0), time_to_s(&limits, aside), 0.1);
  CHECK_NEAR("pitch at 0.5 rad/s^2, s", 2.0 * sqrt(0.5 / 0.5), time_to_s(&limits, above), 0.1);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_at_88_degrees_the_return_is_predicted_and_time_optimal);
  RUN_TEST(test_at_150_m_the_return_is_predicted_and_time_optimal);
  RUN_TEST(test_through_the_zenith_the_return_is_predicted_and_time_optimal);
  RUN_TEST(test_on_the_target_it_is_back_at_once);
  RUN_TEST(test_a_target_at_rest_takes_the_time_at_the_limit_and_that_of_the_loop);
  RUN_TEST(test_a_target_that_is_always_faster_is_not_met_again);
  RUN_TEST(test_by_turning_back_the_azimuth_meets_a_target_that_goes_round);
  RUN_TEST(test_it_is_back_at_the_first_of_twenty_steps_on_the_target);
  RUN_TEST(test_a_turn_in_one_direction_takes_the_longer_turn);
  RUN_TEST(test_each_joint_has_its_own_limits);
  return UNITY_END();
}
