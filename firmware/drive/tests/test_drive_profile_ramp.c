/* SPDX-License-Identifier: Apache-2.0 */
/* Ramps alone: limits under thousands of random replans, exact arrival, shortest time. */
#include "drive/profile_ramp.h"

#include "drive/drive_units.h"
#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

static const float dt_s = 1e-3f;
static const double rad_per_unit = 6.283185307179586 / 4294967296.0;

static profile_limits limits_of(double rate, double acceleration, double deceleration, double jerk) {
  return (profile_limits){(float)rate, (float)acceleration, (float)deceleration, (float)jerk};
}

static profile_limits random_limits(random_source *random, bool even) {
  profile_limits limits = limits_of(random_decades(random, 0.01, 10.0), random_decades(random, 0.1, 100.0),
                                    random_decades(random, 0.1, 100.0), random_decades(random, 1.0, 4000.0));
  if (even) {
    limits.deceleration_rad_s2 = limits.acceleration_rad_s2;
  }
  return limits;
}

/* A demand as drive_motion keeps it, with the conditions of every tick. */
typedef struct {
  profile_ramp ramp;
  profile_limits limits;
  drive_angle demand;
  double rest;
  double worst_jerk; /* excess over the limit, relative, without the rounding of the acceleration */
  double worst_rate; /* relative to the limit */
  double worst_acceleration;
  double worst_sum; /* rate change against mean acceleration, rad/s */
  double worst_mean_jerk;
  double last_mean;
} bench;

static void look(bench *b, const profile_ramp *before, const profile_motion *motion) {
  const double rounding =
      1.2e-7 * fmax(fabs((double)before->acceleration_rad_s2), fabs((double)b->ramp.acceleration_rad_s2));
  const double jerk = (double)b->limits.jerk_rad_s3 * 1e-3;
  const double step = fabs((double)b->ramp.acceleration_rad_s2 - (double)before->acceleration_rad_s2);
  b->worst_jerk = fmax(b->worst_jerk, (step - rounding) / jerk);
  b->worst_mean_jerk =
      fmax(b->worst_mean_jerk, (fabs((double)motion->mean_acceleration_rad_s2 - b->last_mean) - rounding) / jerk);
  b->last_mean = (double)motion->mean_acceleration_rad_s2;
  b->worst_rate = fmax(b->worst_rate, fabs((double)b->ramp.rate_rad_s) / (double)b->limits.rate_rad_s);
  const bool speeds_up = b->ramp.acceleration_rad_s2 * b->ramp.rate_rad_s >= 0.0f;
  const double limit = (double)(speeds_up ? b->limits.acceleration_rad_s2 : b->limits.deceleration_rad_s2);
  const bool judged = fabs((double)b->ramp.rate_rad_s) > 1e-6 * (double)b->limits.rate_rad_s;
  b->worst_acceleration = fmax(b->worst_acceleration, judged ? fabs((double)b->ramp.acceleration_rad_s2) / limit : 0.0);
  const double gained = (double)b->ramp.rate_rad_s + (double)b->ramp.rate_rest_rad_s -
                        ((double)before->rate_rad_s + (double)before->rate_rest_rad_s);
  b->worst_sum =
      fmax(b->worst_sum, fabs(gained - (double)motion->mean_acceleration_rad_s2 * 1e-3) / (double)b->limits.rate_rad_s);
  TEST_ASSERT_TRUE(isfinite(motion->travel_rad) && isfinite(motion->mean_acceleration_rad_s2));
}

static void move(bench *b, double travel_rad) {
  const double units = travel_rad / rad_per_unit + b->rest;
  b->demand += llrint(units);
  b->rest = units - rint(units);
}

static bool go(bench *b, drive_angle target) {
  const profile_ramp before = b->ramp;
  const float distance_rad = (float)(((double)(target - b->demand) - b->rest) * rad_per_unit);
  const profile_motion motion = profile_towards_distance(&b->ramp, &b->limits, distance_rad, dt_s);
  look(b, &before, &motion);
  move(b, (double)motion.travel_rad);
  return motion.arrived;
}

static bool run(bench *b, float rate_rad_s) {
  const profile_ramp before = b->ramp;
  const profile_motion motion = profile_towards_rate(&b->ramp, &b->limits, rate_rad_s, dt_s);
  look(b, &before, &motion);
  move(b, (double)motion.travel_rad);
  return motion.arrived;
}

static void check_limits(const bench *b) {
  CHECK_AT_MOST("jerk / limit", 1.0 + 2e-4, b->worst_jerk);
  CHECK_AT_MOST("jerk of the mean acceleration / limit", 1.0 + 1e-3, b->worst_mean_jerk);
  CHECK_AT_MOST("rate / limit", 1.0 + 1e-6, b->worst_rate);
  CHECK_AT_MOST("acceleration / limit", 1.0 + 1e-5, b->worst_acceleration);
  CHECK_AT_MOST("rate change less mean acceleration, of the rate limit", 1e-6, b->worst_sum);
}

static drive_angle angle_of(double rad) { return llrint(rad / rad_per_unit); }

/* The shortest time for a distance from rest to rest, acceleration and deceleration equal. */
static double shortest_s(double distance, double rate, double acceleration, double jerk) {
  double low = 0.0;
  double high = rate;
  double ramp_s = 0.0;
  for (int i = 0; i < 200; ++i) {
    const double peak = i == 0 ? rate : 0.5 * (low + high);
    ramp_s =
        peak * jerk < acceleration * acceleration ? 2.0 * sqrt(peak / jerk) : peak / acceleration + acceleration / jerk;
    if (i == 0 && rate * ramp_s <= distance) {
      return 2.0 * ramp_s + (distance - rate * ramp_s) / rate;
    }
    *(peak * ramp_s < distance ? &low : &high) = peak;
  }
  return 2.0 * ramp_s;
}

static void test_a_move_from_rest_arrives_exactly_in_the_shortest_time_without_overshoot(void) {
  random_source random = {.state = 1};
  double worst_overshoot = 0.0;
  double worst_excess = 0.0;
  double mean_late_s = 0.0;
  double earliest_s = 0.0;
  for (int trial = 0; trial < random_cases(1500); ++trial) {
    const double distance = random_decades(&random, 1e-7, 20.0);
    const double sign = trial % 2 == 0 ? 1.0 : -1.0;
    bench b = {.limits = random_limits(&random, true)};
    b.limits.rate_rad_s = fmaxf(b.limits.rate_rad_s, (float)distance / 30.0f);
    const drive_angle target = angle_of(sign * distance);
    double ticks = 1.0;
    while (!go(&b, target)) {
      worst_overshoot = fmax(worst_overshoot, sign * (double)(b.demand - target) * rad_per_unit - 1e-7 * distance);
      ticks += 1.0;
      TEST_ASSERT_TRUE(ticks < 1e6);
    }
    TEST_ASSERT_TRUE(b.demand == target);
    TEST_ASSERT_TRUE(profile_at_rest(&b.ramp));
    check_limits(&b);
    const double best_s = shortest_s(distance, (double)b.limits.rate_rad_s, (double)b.limits.acceleration_rad_s2,
                                     (double)b.limits.jerk_rad_s3);
    worst_excess = fmax(worst_excess, (ticks * 1e-3 - 0.002 - best_s) / best_s);
    mean_late_s += (ticks * 1e-3 - best_s) / random_cases(1500);
    earliest_s = fmax(earliest_s, best_s - ticks * 1e-3);
  }
  LOG_VALUE("overshoot beyond 1e-7 of the distance, rad", worst_overshoot);
  LOG_VALUE("time beyond the shortest and two ticks, fraction", worst_excess);
  CHECK_AT_MOST("later than the shortest time, mean, s", 1.2e-3, mean_late_s);
  CHECK_AT_MOST("overshoot beyond 1e-7 of the distance, rad", 1e-8, worst_overshoot);
  CHECK_AT_MOST("time beyond the shortest and two ticks, fraction", 0.01, worst_excess);
  CHECK_AT_MOST("earlier than the shortest time: the limits were not kept", 1e-4, earliest_s);
}

static void test_moves_with_unequal_deceleration_keep_each_limit_and_do_not_overshoot(void) {
  random_source random = {.state = 2};
  for (int trial = 0; trial < random_cases(1000); ++trial) {
    bench b = {.limits = random_limits(&random, false)};
    const double distance = random_decades(&random, 1e-6, 20.0);
    b.limits.rate_rad_s = fmaxf(b.limits.rate_rad_s, (float)distance / 30.0f);
    const drive_angle target = angle_of(distance);
    int ticks = 0;
    while (!go(&b, target)) {
      TEST_ASSERT_TRUE(++ticks < 1000000);
      CHECK_AT_MOST("overshoot, rad", 1e-8 + 2e-7 * distance, (double)(b.demand - target) * rad_per_unit);
    }
    TEST_ASSERT_TRUE(b.demand == target);
    check_limits(&b);
  }
}

static void test_targets_that_change_at_any_time_never_break_a_limit_and_the_last_one_is_reached(void) {
  random_source random = {.state = 3};
  int replans = 0;
  bench worst = {0};
  for (int trial = 0; trial < random_cases(300); ++trial) {
    bench b = {.limits = random_limits(&random, trial % 2 == 0)};
    drive_angle target = 0;
    for (int replan = 0; replan < 30; ++replan, ++replans) {
      const int ticks = (int)random_decades(&random, 1.0, 500.0);
      const bool by_rate = random_bits(&random) % 4 == 0;
      const float rate = (float)random_uniform(&random, -1.0, 1.0) * b.limits.rate_rad_s;
      target = b.demand + angle_of(random_uniform(&random, -1.0, 1.0) * random_decades(&random, 1e-6, 5.0));
      for (int i = 0; i < ticks; ++i) {
        (void)(by_rate ? run(&b, rate) : go(&b, target));
      }
    }
    int ticks = 0;
    while (!go(&b, target)) {
      TEST_ASSERT_TRUE(++ticks < 1000000);
    }
    TEST_ASSERT_TRUE(b.demand == target);
    check_limits(&b);
    worst.worst_jerk = fmax(worst.worst_jerk, b.worst_jerk);
    worst.worst_mean_jerk = fmax(worst.worst_mean_jerk, b.worst_mean_jerk);
    worst.worst_rate = fmax(worst.worst_rate, b.worst_rate);
    worst.worst_acceleration = fmax(worst.worst_acceleration, b.worst_acceleration);
  }
  LOG_VALUE("replans", replans);
  LOG_VALUE("jerk / limit - 1", worst.worst_jerk - 1.0);
  LOG_VALUE("jerk of the mean acceleration / limit - 1", worst.worst_mean_jerk - 1.0);
  LOG_VALUE("rate / limit - 1", worst.worst_rate - 1.0);
  LOG_VALUE("acceleration / limit - 1", worst.worst_acceleration - 1.0);
}

static void test_a_ramp_arrives_exactly_at_its_rate_in_the_shortest_time_without_overshoot(void) {
  random_source random = {.state = 4};
  for (int trial = 0; trial < random_cases(2000); ++trial) {
    bench b = {.limits = random_limits(&random, true)};
    const double rate = random_uniform(&random, 0.001, 1.0) * (double)b.limits.rate_rad_s;
    const float target = (float)(trial % 2 == 0 ? rate : -rate);
    int ticks = 1;
    while (!run(&b, target)) {
      CHECK_AT_MOST("rate / target", 1.0 + 1e-6, (double)b.ramp.rate_rad_s / (double)target);
      TEST_ASSERT_TRUE(++ticks < 1000000);
    }
    CHECK_SAME("rate", target, b.ramp.rate_rad_s);
    CHECK_SAME("acceleration", 0.0, b.ramp.acceleration_rad_s2);
    const double a = (double)b.limits.acceleration_rad_s2;
    const double j = (double)b.limits.jerk_rad_s3;
    const double best_s = rate * j < a * a ? 2.0 * sqrt(rate / j) : rate / a + a / j;
    CHECK_NEAR("time, s", best_s, ticks * 1e-3, 0.002 + 1e-3 * best_s);
    check_limits(&b);
  }
}

/* An acceleration that is 1e-7 off is 6 counts off after a second at 1 rad/s^2: the limit is held to its last bit. */
static void test_the_acceleration_between_its_ramps_is_its_limit_exactly(void) {
  random_source random = {.state = 8};
  for (int trial = 0; trial < random_cases(500); ++trial) {
    bench b = {.limits = random_limits(&random, true)};
    b.limits.jerk_rad_s3 = 30.0f * b.limits.acceleration_rad_s2;
    const float target = (trial % 2 == 0 ? 0.5f : -0.5f) * b.limits.acceleration_rad_s2; /* half a second */
    b.limits.rate_rad_s = 1000.0f;
    for (int i = 0; i < 300; ++i) {
      (void)run(&b, target);
      if (i > 40) {
        CHECK_SAME("acceleration", b.limits.acceleration_rad_s2, fabs((double)b.ramp.acceleration_rad_s2));
      }
    }
  }
}

static void test_a_start_from_rest_has_its_own_acceleration_however_weak_the_brakes_are(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    bench b = {.limits = limits_of(10.0, 2.5, 1.0, 4000.0)};
    (void)run(&b, (float)sign * 10.0f);
    CHECK_SAME("acceleration after a tick", sign * 2.5, b.ramp.acceleration_rad_s2);
    while (b.ramp.acceleration_rad_s2 != 0.0f) {
      TEST_ASSERT_TRUE((float)sign * b.ramp.rate_rad_s < 11.0f);
      (void)run(&b, (float)sign * 10.0f);
    }
    (void)run(&b, 0.0f);
    CHECK_SAME("braking after a tick", -sign * 1.0, b.ramp.acceleration_rad_s2);
    for (int i = 0; i < 500; ++i) {
      (void)run(&b, 0.0f);
    }
    (void)run(&b, (float)sign * 10.0f);
    CHECK_SAME("acceleration again after a tick", sign * 2.5, b.ramp.acceleration_rad_s2);
  }
}

/* From 2 to 1 rad/s and back, with weak acceleration: each change has its own limit. */
static void test_a_lower_rate_is_approached_with_the_deceleration(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    bench b = {.limits = limits_of(2.0, 0.5, 5.0, 500.0)};
    while (!run(&b, (float)sign * 2.0f)) {
    }
    double hardest_rad_s2 = 0.0;
    while (!run(&b, (float)sign * 1.0f)) {
      hardest_rad_s2 = fmax(hardest_rad_s2, -sign * (double)b.ramp.acceleration_rad_s2);
    }
    CHECK_NEAR("deceleration, rad/s^2", 5.0, hardest_rad_s2, 1e-5);
    check_limits(&b);
  }
}

static void test_a_reversal_with_weak_acceleration_stops_first(void) {
  bench b = {.limits = limits_of(1.0, 0.5, 5.0, 50.0)};
  while (!run(&b, 1.0f)) {
  }
  while (!run(&b, -1.0f)) {
    CHECK_AT_LEAST("acceleration", -5.0 * (1.0 + 1e-6), b.ramp.acceleration_rad_s2);
    if (b.ramp.rate_rad_s < 0.0f) {
      CHECK_AT_LEAST("acceleration away from standstill", -0.5 * (1.0 + 1e-6), b.ramp.acceleration_rad_s2);
    }
  }
  CHECK_SAME("rate", -1.0, b.ramp.rate_rad_s);
}

/* Brakes of 0.5 rad/s^2: it passes 0 with them, without a pause. */
static void test_a_reversal_with_weak_brakes_does_not_stop(void) {
  bench b = {.limits = limits_of(1.0, 5.0, 0.5, 50.0)};
  while (!run(&b, 1.0f)) {
  }
  for (int ticks = 0; b.ramp.rate_rad_s >= 0.0f; ++ticks) {
    TEST_ASSERT_TRUE(ticks < 3000);
    (void)run(&b, -1.0f);
  }
  CHECK_AT_MOST("acceleration at 0, rad/s^2", -0.5 * (1.0 - 1e-6), b.ramp.acceleration_rad_s2);
}

/* From 1e-6 rad/s it stands within the tick: that is not yet the other rate. */
static void test_a_reversal_has_not_arrived_when_it_stands(void) {
  const profile_limits limits = limits_of(1.0, 0.5, 5.0, 50.0);
  for (int sign = -1; sign <= 1; sign += 2) {
    const float wanted_rad_s = (float)-sign;
    profile_ramp ramp = {.rate_rad_s = (float)sign * 1e-6f};
    TEST_ASSERT_FALSE(profile_towards_rate(&ramp, &limits, wanted_rad_s, dt_s).arrived);
    TEST_ASSERT_TRUE(profile_at_rest(&ramp));
    ramp = (profile_ramp){.rate_rad_s = (float)sign * 1e-6f};
    const float room_rad = 5.0f * wanted_rad_s;
    TEST_ASSERT_FALSE(profile_towards_rate_within(&ramp, &limits, &limits, wanted_rad_s, room_rad, dt_s).arrived);
    TEST_ASSERT_TRUE(profile_at_rest(&ramp));
  }
}

static void test_a_target_inside_the_braking_distance_is_passed_once_and_come_back_to(void) {
  bench b = {.limits = limits_of(1.0, 2.0, 2.0, 40.0)};
  while (!run(&b, 1.0f)) {
  }
  const drive_angle target = b.demand + angle_of(0.1); /* the stop takes 0.275 rad */
  const double stop_rad = (double)profile_stop_travel_rad(&b.ramp, &b.limits);
  CHECK_NEAR("way to stand still, rad", 0.5 * 1.0 * (1.0 / 2.0 + 2.0 / 40.0), stop_rad, 1e-6);
  double farthest_rad = 0.0;
  while (!go(&b, target)) {
    farthest_rad = fmax(farthest_rad, (double)(b.demand - target) * rad_per_unit);
  }
  TEST_ASSERT_TRUE(b.demand == target);
  CHECK_AT_MOST("farthest beyond the target", 0.175 + 1e-5, farthest_rad);
  check_limits(&b);
}

/* Whether the first stop of a move begins too early or too late: it leaves more than 1e-9 rad and 4e-7 of the distance,
 * and twice as much by rounding. */
static bool stops_at_the_wrong_time(const profile_limits *limits, double distance) {
  profile_ramp ramp = {.rate_rad_s = 0.0f};
  double ahead_rad = distance;
  for (int ticks = 0; ticks < 1000000; ++ticks) {
    const float before_rad = (float)ahead_rad;
    const profile_motion motion = profile_towards_distance(&ramp, limits, before_rad, dt_s);
    ahead_rad -= (double)motion.travel_rad;
    if (motion.stops || motion.arrived) {
      const double stop_rad = (double)motion.travel_rad + (double)profile_stop_travel_rad(&ramp, limits);
      return !motion.arrived && fabs((double)before_rad - stop_rad) > 2.0 * (1e-9 + 4e-7 * fabs((double)before_rad));
    }
  }
  return true; /* never */
}

static void test_a_stop_ends_at_the_target_from_the_tick_in_which_it_begins(void) {
  static const struct {
    double hardest_rad_s2;
    double nearest_rad;
    double farthest_rad;
    double low_rad_s3;
    double high_rad_s3;
  } kinds[] = {{8.0, 1e-6, 0.01, 1000.0, 4300.0},
               {50.0, 1e-4, 1.0, 1.0, 1000.0},
               {50.0, 1e-4, 1.0, 0.01, 1.0}}; /* the acceleration takes seconds */
  random_source random = {.state = 9};
  const int trials = 3 * random_cases(1000);
  int wrong = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const int k = trial % 3;
    const double distance = random_decades(&random, kinds[k].nearest_rad, kinds[k].farthest_rad);
    profile_limits limits =
        limits_of(random_decades(&random, 0.01, 10.0), random_decades(&random, 0.1, kinds[k].hardest_rad_s2),
                  random_decades(&random, 0.1, kinds[k].hardest_rad_s2),
                  random_decades(&random, kinds[k].low_rad_s3, kinds[k].high_rad_s3));
    limits.rate_rad_s = fmaxf(limits.rate_rad_s, (float)distance / 10.0f);
    wrong += stops_at_the_wrong_time(&limits, trial % 2 == 0 ? distance : -distance) ? 1 : 0;
  }
  CHECK_AT_MOST("share of stops at the wrong time", 1e-3, (double)wrong / trials);
}

/* Moves of some ticks, in which several pieces meet within one: the search for the time has corners there. */
static void test_short_moves_of_short_pieces_stop_in_time(void) {
  random_source random = {.state = 11};
  const int trials = 2000; /* also in a short test: fewer could not tell 0.7 % from 1.2 % */
  int wrong = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const double acceleration = random_decades(&random, 0.1, 4.0);
    const double rate = acceleration * random_decades(&random, 3e-4, 3e-3);
    const double distance = rate * random_decades(&random, 1e-3, 5e-3);
    const profile_limits limits =
        limits_of(rate, acceleration, random_decades(&random, 0.1, 4.0), random_decades(&random, 1500.0, 4300.0));
    wrong += stops_at_the_wrong_time(&limits, trial % 2 == 0 ? distance : -distance) ? 1 : 0;
  }
  CHECK_AT_MOST("share of stops at the wrong time", 0.01, (double)wrong / trials);
}

/* At v = a^2 / 2j the jerk alone ends the stop: after a / j, and a^3 / 6j^2. */
static void test_the_last_piece_of_a_stop_has_its_distance(void) {
  random_source random = {.state = 10};
  for (int trial = 0; trial < random_cases(20000); ++trial) {
    const double sign = trial % 2 == 0 ? 1.0 : -1.0;
    const profile_limits limits = limits_of(10.0, 50.0, 150.0, random_decades(&random, 0.1, 4000.0));
    const double j = (double)limits.jerk_rad_s3;
    const double a = (double)(float)random_decades(&random, 1e-3, 50.0);
    const profile_ramp ramp = {.rate_rad_s = (float)(sign * a * a / (2.0 * j)),
                               .acceleration_rad_s2 = (float)(-sign * a)};
    CHECK_RELATIVE("way to stand still, rad", sign * a * a * a / (6.0 * j * j), profile_stop_travel_rad(&ramp, &limits),
                   1e-6);
  }
}

/* At 0.5 rad/s, with the target where it is: it stands only after it has come back. */
static void test_a_target_that_is_passed_at_speed_is_not_reached(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    bench b = {.limits = limits_of(1.0, 2.0, 2.0, 40.0), .ramp = {.rate_rad_s = (float)sign * 0.5f}};
    TEST_ASSERT_FALSE(go(&b, 0));
    CHECK_NEAR("travel of the first tick, rad", sign * 0.5e-3, (double)b.demand * rad_per_unit, 1e-6);
    int ticks = 1;
    while (!go(&b, 0)) {
      TEST_ASSERT_TRUE(++ticks < 10000);
    }
    CHECK_AT_LEAST("time, s", 0.5, ticks * 1e-3);
    TEST_ASSERT_TRUE(b.demand == 0 && profile_at_rest(&b.ramp));
  }
}

/* 2^-12 rad/s with 1024 rad/s^3 take two pieces of 2^-11 s: a tick of 2^-10 s. All exact in binary. */
static void test_a_ramp_that_ends_with_the_tick_has_arrived(void) {
  const profile_limits limits = limits_of(1.0, 2.0, 2.0, 1024.0);
  for (int sign = -1; sign <= 1; sign += 2) {
    const float wanted_rad_s = (float)sign * 0x1p-12f;
    profile_ramp ramp = {.rate_rad_s = 0.0f};
    const profile_motion motion = profile_towards_rate(&ramp, &limits, wanted_rad_s, 0x1p-10f);
    TEST_ASSERT_TRUE(motion.arrived);
    CHECK_SAME("rate, rad/s", wanted_rad_s, ramp.rate_rad_s);
    CHECK_SAME("mean acceleration, rad/s^2", sign * 0.25, motion.mean_acceleration_rad_s2);
  }
}

/* At 1e-4 rad/s, with -1 rad/s^2: 4000 rad/s^3 let it swing to -2.5e-5 rad/s. From there it brakes, so it stands after
 * 0.41 ms, with 0.32 rad/s^2 at most; 0.01 rad/s^2 would take 2 ms more. */
static void test_a_swing_through_standstill_ends_with_the_deceleration(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    profile_ramp ramp = {.rate_rad_s = (float)sign * 1e-4f, .acceleration_rad_s2 = (float)-sign};
    const profile_limits hard = limits_of(1.0, 0.01, 10.0, 4000.0);
    TEST_ASSERT_TRUE(profile_towards_rate(&ramp, &hard, 0.0f, dt_s).arrived);
    ramp = (profile_ramp){.rate_rad_s = (float)sign * 1e-4f, .acceleration_rad_s2 = (float)-sign};
    const profile_limits weak = limits_of(1.0, 10.0, 0.01, 4000.0);
    TEST_ASSERT_FALSE(profile_towards_rate(&ramp, &weak, 0.0f, dt_s).arrived);
    CHECK_NEAR("braking, rad/s^2", sign * 0.01, ramp.acceleration_rad_s2, 1e-8);
  }
}

static void test_limits_that_shrink_under_way_are_entered_with_the_jerk_limit(void) {
  bench b = {.limits = limits_of(5.0, 10.0, 10.0, 100.0)};
  for (int i = 0; i < 300; ++i) {
    (void)run(&b, 5.0f);
  }
  b.limits = limits_of(0.5, 1.0, 1.0, 100.0);
  const drive_angle target = b.demand + angle_of(20.0);
  int ticks = 0;
  b.worst_jerk = 0.0;
  while (!go(&b, target)) {
    TEST_ASSERT_TRUE(++ticks < 100000);
    if (ticks > 4000) {
      CHECK_AT_MOST("rate", 0.5 * (1.0 + 1e-6), b.ramp.rate_rad_s);
    }
  }
  CHECK_AT_MOST("jerk / limit", 1.0 + 1e-4, b.worst_jerk);
}

/* From 10 to 1 rad/s^2 on the way to 5 rad/s: it takes 90 ms. */
static void test_a_weaker_acceleration_is_entered_with_the_jerk_limit(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    bench b = {.limits = limits_of(5.0, 10.0, 10.0, 100.0)};
    for (int i = 0; i < 200; ++i) {
      (void)run(&b, (float)sign * 5.0f);
    }
    CHECK_NEAR("acceleration, rad/s^2", sign * 10.0, b.ramp.acceleration_rad_s2, 1e-5);
    b.limits.acceleration_rad_s2 = 1.0f;
    b.worst_jerk = 0.0;
    for (int i = 0; i < 89; ++i) {
      (void)run(&b, (float)sign * 5.0f);
    }
    CHECK_NEAR("after 89 ms, rad/s^2", sign * 1.1, b.ramp.acceleration_rad_s2, 1e-4);
    for (int i = 0; i < 100; ++i) {
      (void)run(&b, (float)sign * 5.0f);
    }
    CHECK_NEAR("after 189 ms, rad/s^2", sign * 1.0, b.ramp.acceleration_rad_s2, 1e-6);
    CHECK_AT_MOST("jerk / limit", 1.0 + 1e-4, b.worst_jerk);
  }
}

static void test_a_rate_is_held_back_before_the_end_of_the_room(void) {
  random_source random = {.state = 5};
  for (int trial = 0; trial < random_cases(500); ++trial) {
    bench b = {.limits = random_limits(&random, trial % 3 == 0)};
    const double sign = trial % 2 == 0 ? 1.0 : -1.0;
    const drive_angle end = angle_of(sign * random_decades(&random, 1e-3, 2.0));
    const float rate = (float)sign * b.limits.rate_rad_s;
    int still = 0;
    for (int i = 0; i < 200000 && still < 10; ++i) {
      const profile_ramp before = b.ramp;
      const float room_rad = (float)((double)(end - b.demand) * rad_per_unit);
      const profile_motion motion = profile_towards_rate_within(&b.ramp, &b.limits, &b.limits, rate, room_rad, dt_s);
      look(&b, &before, &motion);
      move(&b, (double)motion.travel_rad);
      CHECK_AT_MOST("beyond the end, rad", 5e-7, sign * (double)(b.demand - end) * rad_per_unit);
      still += fabs((double)(end - b.demand)) * rad_per_unit < 1e-6 && profile_at_rest(&b.ramp) ? 1 : 0;
    }
    TEST_ASSERT_EQUAL_INT(10, still);
    check_limits(&b);
  }
}

static void test_room_that_is_behind_stops_and_room_enough_changes_nothing(void) {
  profile_ramp ramp = {0};
  const profile_limits limits = limits_of(1.0, 2.0, 2.0, 40.0);
  for (int i = 0; i < 100; ++i) {
    (void)profile_towards_rate_within(&ramp, &limits, &limits, 1.0f, -0.1f, dt_s);
    TEST_ASSERT_TRUE(profile_at_rest(&ramp));
  }
  profile_ramp free_ramp = {0};
  bool arrived = false;
  for (int i = 0; i < 2000; ++i) {
    arrived = profile_towards_rate_within(&ramp, &limits, &limits, 1.0f, 100.0f, dt_s).arrived;
    (void)profile_towards_rate(&free_ramp, &limits, 1.0f, dt_s);
    CHECK_SAME("rate", free_ramp.rate_rad_s, ramp.rate_rad_s);
  }
  TEST_ASSERT_TRUE(arrived);
}

static void test_limits_are_refused_outside_their_ranges(void) {
  const profile_limits good = limits_of(1.0, 1.0, 1.0, 1.0);
  CHECK_STATUS(CONTROL_OK, profile_limits_check(&good));
  for (int field = 0; field < 4; ++field) {
    float fields[4] = {1.0f, 1.0f, 1.0f, 1.0f};
    fields[field] = 0.0f;
    const profile_limits zero = {fields[0], fields[1], fields[2], fields[3]};
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, profile_limits_check(&zero));
    fields[field] = 4300.0f;
    const profile_limits highest = {fields[0], fields[1], fields[2], fields[3]};
    CHECK_STATUS(CONTROL_OK, profile_limits_check(&highest));
    fields[field] = 4300.05f;
    const profile_limits higher = {fields[0], fields[1], fields[2], fields[3]};
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, profile_limits_check(&higher));
    fields[field] = NAN;
    const profile_limits nan = {fields[0], fields[1], fields[2], fields[3]};
    CHECK_STATUS(CONTROL_NOT_FINITE, profile_limits_check(&nan));
  }
}

static void test_the_most_extreme_limits_give_no_nan(void) {
  random_source random = {.state = 6};
  for (int trial = 0; trial < random_cases(2000); ++trial) {
    bench b = {.limits = limits_of(random_decades(&random, 1e-6, 4294.0), random_decades(&random, 1e-6, 4294.0),
                                   random_decades(&random, 1e-6, 4294.0), random_decades(&random, 1e-6, 4294.0))};
    for (int i = 0; i < 50; ++i) {
      (void)go(&b, angle_of(random_uniform(&random, -200.0, 200.0)));
      (void)run(&b, (float)random_uniform(&random, -1.0, 1.0) * b.limits.rate_rad_s);
      TEST_ASSERT_TRUE(isfinite(b.ramp.rate_rad_s) && isfinite(b.ramp.acceleration_rad_s2));
    }
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_move_from_rest_arrives_exactly_in_the_shortest_time_without_overshoot);
  RUN_TEST(test_moves_with_unequal_deceleration_keep_each_limit_and_do_not_overshoot);
  RUN_TEST(test_targets_that_change_at_any_time_never_break_a_limit_and_the_last_one_is_reached);
  RUN_TEST(test_a_ramp_arrives_exactly_at_its_rate_in_the_shortest_time_without_overshoot);
  RUN_TEST(test_the_acceleration_between_its_ramps_is_its_limit_exactly);
  RUN_TEST(test_a_start_from_rest_has_its_own_acceleration_however_weak_the_brakes_are);
  RUN_TEST(test_a_lower_rate_is_approached_with_the_deceleration);
  RUN_TEST(test_a_reversal_with_weak_acceleration_stops_first);
  RUN_TEST(test_a_reversal_with_weak_brakes_does_not_stop);
  RUN_TEST(test_a_reversal_has_not_arrived_when_it_stands);
  RUN_TEST(test_a_target_inside_the_braking_distance_is_passed_once_and_come_back_to);
  RUN_TEST(test_a_stop_ends_at_the_target_from_the_tick_in_which_it_begins);
  RUN_TEST(test_short_moves_of_short_pieces_stop_in_time);
  RUN_TEST(test_the_last_piece_of_a_stop_has_its_distance);
  RUN_TEST(test_a_target_that_is_passed_at_speed_is_not_reached);
  RUN_TEST(test_a_ramp_that_ends_with_the_tick_has_arrived);
  RUN_TEST(test_a_swing_through_standstill_ends_with_the_deceleration);
  RUN_TEST(test_limits_that_shrink_under_way_are_entered_with_the_jerk_limit);
  RUN_TEST(test_a_weaker_acceleration_is_entered_with_the_jerk_limit);
  RUN_TEST(test_a_rate_is_held_back_before_the_end_of_the_room);
  RUN_TEST(test_room_that_is_behind_stops_and_room_enough_changes_nothing);
  RUN_TEST(test_limits_are_refused_outside_their_ranges);
  RUN_TEST(test_the_most_extreme_limits_give_no_nan);
  return UNITY_END();
}
