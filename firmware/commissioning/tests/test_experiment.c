/* SPDX-License-Identifier: Apache-2.0 */
/* Experiments on an ideal axis, which follows its commands: set-points, limits, and causes of the end. */
#include "commissioning/experiment.h"

#include <stddef.h>

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

static const float dt_s = 1e-3f;

typedef struct {
  experiment e;
  servo_axis_command command;
  double angle_rad;
  double rate_rad_s;
  double farthest_rad;
  int ticks;
} bench;

static angle_turn32 encoder(double rad) {
  return (angle_turn32)(uint64_t)llrint(rad / 6.283185307179586 * 4294967296.0);
}

static const double start_rad = 1.5;

static bench started(const stimulus_setup *setup, const experiment_limits *limits) {
  bench b = {.angle_rad = start_rad};
  CHECK_STATUS(CONTROL_OK, experiment_start(&b.e, setup, limits, encoder(start_rad)));
  return b;
}

/* One tick; the axis reaches the rate of the next one exactly, a torque does not move it. */
static bool tick(bench *b) {
  const double before_rad_s = b->rate_rad_s;
  const bool goes_on = experiment_step(&b->e, encoder(b->angle_rad), (float)b->rate_rad_s, &b->command, dt_s);
  if (goes_on && b->command.mode == SERVO_SPEED) {
    b->rate_rad_s = (double)b->command.speed.rate_rad_s + 1e-3 * (double)b->command.speed.acceleration_rad_s2;
  } else if (goes_on && b->command.mode == SERVO_POSITION) {
    b->angle_rad += (double)angle_difference_rad(b->command.position, encoder(b->angle_rad));
    b->rate_rad_s = (double)b->command.speed.rate_rad_s;
    b->ticks++;
    b->farthest_rad = fmax(b->farthest_rad, fabs(b->angle_rad - start_rad));
    return true;
  }
  b->angle_rad += 0.5e-3 * (before_rad_s + b->rate_rad_s);
  b->farthest_rad = fmax(b->farthest_rad, fabs(b->angle_rad - start_rad));
  b->ticks += goes_on;
  return goes_on;
}

static const stimulus_setup sweep = {.kind = STIMULUS_SWEEP,
                                     .low_rad_s = 0.01f,
                                     .speed_ratio = 2.0f,
                                     .count = 5,
                                     .dwell_s = 2.0f,
                                     .acceleration_rad_s2 = 0.5f};
static const stimulus_setup ramps = {.kind = STIMULUS_TORQUE_RAMPS, .count = 3, .dwell_s = 4.0f, .amplitude_nm = 5.0f};
static const stimulus_setup hysteresis = {
    .kind = STIMULUS_HYSTERESIS, .count = 3, .dwell_s = 2.0f, .amplitude_rad = 1e-3f};
static const stimulus_setup chirp = {.kind = STIMULUS_CHIRP,
                                     .low_rad_s = 0.02f,
                                     .count = 2,
                                     .dwell_s = 4.0f,
                                     .amplitude_nm = 3.0f,
                                     .low_hz = 5.0f,
                                     .high_hz = 50.0f,
                                     .acceleration_rad_s2 = 0.5f};
static const stimulus_setup breakaway = {
    .kind = STIMULUS_BREAKAWAY, .count = 6, .dwell_s = 4.0f, .amplitude_nm = 20.0f, .amplitude_rad = 1e-3f};
static const experiment_limits wide = {
    .travel_rad = 1.0f, .rate_rad_s = 0.5f, .torque_nm = 30.0f, .duration_s = 200.0f};

/* --- set-points --- */

static void test_a_sweep_dwells_at_each_speed_in_both_directions_and_ends_at_rest(void) {
  bench b = started(&sweep, &wide);
  double dwelt_s[5][2] = {{0}};
  while (tick(&b)) {
    const double magnitude_rad_s = fabs((double)b.command.speed.rate_rad_s);
    for (int i = 0; i < 5; ++i) {
      if (fabs(magnitude_rad_s - 0.01 * pow(2.0, i)) < 1e-6 && b.command.speed.acceleration_rad_s2 == 0.0f) {
        dwelt_s[i][b.command.speed.rate_rad_s > 0.0f] += 1e-3;
      }
    }
  }
  TEST_ASSERT_EQUAL_INT(EXPERIMENT_DONE, b.e.state);
  for (int i = 0; i < 5; ++i) {
    CHECK_NEAR("dwell forward, s", 2.0, dwelt_s[i][1], 0.01);
    CHECK_NEAR("dwell backward, s", 2.0, dwelt_s[i][0], 0.01);
  }
  CHECK_NEAR("rate at the end, rad/s", 0.0, b.rate_rad_s, 1e-6);
  CHECK_AT_MOST("duration, s", (double)stimulus_duration_s(&sweep), 1e-3 * b.ticks);
  CHECK_AT_MOST("farthest, rad", 0.9, b.farthest_rad);
}

static void test_a_sweep_turns_round_within_a_short_travel_and_still_dwells(void) {
  experiment_limits narrow = wide;
  narrow.travel_rad = 0.08f;
  bench b = started(&sweep, &narrow);
  double fast_s[2] = {0};
  int turns = 0;
  double last_rad_s = 0.0;
  while (tick(&b)) {
    if (fabs(fabs((double)b.command.speed.rate_rad_s) - 0.16) < 1e-6) {
      fast_s[b.command.speed.rate_rad_s > 0.0f] += 1e-3;
    }
    turns += b.rate_rad_s * last_rad_s < 0.0;
    last_rad_s = b.rate_rad_s;
    TEST_ASSERT_TRUE(b.ticks < 200000);
  }
  TEST_ASSERT_EQUAL_INT(EXPERIMENT_DONE, b.e.state);
  LOG_VALUE("turns", turns);
  CHECK_AT_LEAST("at the fastest speed forward, s", 2.0, fast_s[1]);
  CHECK_AT_LEAST("at the fastest speed backward, s", 2.0, fast_s[0]);
  CHECK_AT_MOST("farthest, rad", 0.9 * 0.08 + 1e-5, b.farthest_rad);
  CHECK_NEAR("rate at the end, rad/s", 0.0, b.rate_rad_s, 1e-6);
}

static void test_torque_ramps_are_triangles_of_the_amplitude(void) {
  bench b = started(&ramps, &wide);
  double highest_nm = 0.0;
  double lowest_nm = 0.0;
  double steepest_nm = 0.0;
  double last_nm = 0.0;
  while (tick(&b)) {
    const double torque_nm = (double)b.command.torque_nm;
    TEST_ASSERT_EQUAL_INT(SERVO_TORQUE, b.command.mode);
    highest_nm = fmax(highest_nm, torque_nm);
    lowest_nm = fmin(lowest_nm, torque_nm);
    steepest_nm = fmax(steepest_nm, fabs(torque_nm - last_nm));
    last_nm = torque_nm;
  }
  CHECK_NEAR("highest, Nm", 5.0, highest_nm, 0.006);
  CHECK_NEAR("lowest, Nm", -5.0, lowest_nm, 0.006);
  CHECK_NEAR("a tick's step, Nm", 0.005, steepest_nm, 1e-4);
  CHECK_NEAR("at the end, Nm", 0.0, last_nm, 0.006);
  CHECK_NEAR("duration, ticks", 12000, b.ticks, 30);
}

static void test_hysteresis_loops_are_triangles_of_position_around_the_start(void) {
  bench b = started(&hysteresis, &wide);
  double highest_rad = 0.0;
  double lowest_rad = 0.0;
  double last_rad = start_rad;
  while (tick(&b)) {
    highest_rad = fmax(highest_rad, b.angle_rad - start_rad);
    lowest_rad = fmin(lowest_rad, b.angle_rad - start_rad);
    const double rate_rad_s = (double)b.command.speed.rate_rad_s;
    CHECK_NEAR("rate fed forward, rad/s", 2e-3, fabs(rate_rad_s), 1e-6);
    if ((b.ticks + 10) % 500 > 20) { /* not at a turning point */
      CHECK_NEAR("moved by the rate, rad", 1e-3 * rate_rad_s, b.angle_rad - last_rad, 2e-8);
    }
    last_rad = b.angle_rad;
  }
  CHECK_NEAR("highest, rad", 1e-3, highest_rad, 5e-6);
  CHECK_NEAR("lowest, rad", -1e-3, lowest_rad, 5e-6);
  CHECK_NEAR("at the end, rad", start_rad, b.angle_rad, 5e-6);
}

static void test_a_chirp_rises_in_frequency_on_a_steady_speed_forth_and_back(void) {
  bench b = started(&chirp, &wide);
  int crossings[2] = {0};
  double peak_nm = 0.0;
  double last_nm = 0.0;
  double fastest_crossing_ticks = 1e9;
  int since = 0;
  while (tick(&b)) {
    const double torque_nm = (double)b.command.torque_nm;
    peak_nm = fmax(peak_nm, fabs(torque_nm));
    ++since;
    if (torque_nm * last_nm < 0.0) {
      crossings[b.command.speed.rate_rad_s > 0.0f]++;
      fastest_crossing_ticks = fmin(fastest_crossing_ticks, since);
      since = 0;
    }
    last_nm = torque_nm;
    if (torque_nm != 0.0) {
      CHECK_NEAR("speed below it, rad/s", 0.02, fabs((double)b.command.speed.rate_rad_s), 1e-7);
    }
  }
  CHECK_NEAR("peak, Nm", 3.0, peak_nm, 0.03);
  CHECK_NEAR("half periods forth: 2 x mean 27.5 Hz x 4 s, twice", 440, crossings[1], 8);
  CHECK_NEAR("half periods back", 440, crossings[0], 8);
  CHECK_NEAR("shortest half period, ticks", 10, fastest_crossing_ticks, 1);
  CHECK_NEAR("rate at the end, rad/s", 0.0, b.rate_rad_s, 1e-6);
}

/* The fit compares both directions: they get the same torques. */
static void test_each_leg_of_a_chirp_has_the_same_torques(void) {
  static float first_nm[4100];
  bench b = started(&chirp, &wide);
  int at = -1;
  int legs = 0;
  while (tick(&b)) {
    if (b.command.torque_nm == 0.0f) {
      at = at > 2000 ? -1 : at; /* the leg is over */
      continue;
    }
    legs += at < 0 ? 1 : 0;
    at += 1;
    TEST_ASSERT_TRUE(at < 4100);
    if (legs == 1) {
      first_nm[at] = b.command.torque_nm;
    } else {
      CHECK_SAME("torque, Nm", first_nm[at], b.command.torque_nm);
    }
  }
  TEST_ASSERT_EQUAL_INT(4, legs);
}

static void test_a_sweep_beyond_1_rad_s_is_as_fast_and_as_long_as_its_speeds_say(void) {
  stimulus_setup fast = sweep; /* 0.1, 0.3, 0.9, 2.7 rad/s */
  fast.low_rad_s = 0.1f;
  fast.speed_ratio = 3.0f;
  fast.count = 4;
  CHECK_NEAR("peak, rad/s", 2.7, stimulus_peak_rate_rad_s(&fast), 1e-6);
  CHECK_NEAR("duration, s", 2.0 * 4.0 * 2.0 + 4.0 * 4.0 / 0.5, stimulus_duration_s(&fast), 1e-4);
}

static void test_a_sweep_may_repeat_one_speed(void) {
  stimulus_setup same = sweep;
  same.speed_ratio = 1.0f;
  CHECK_STATUS(CONTROL_OK, experiment_check(&same, &wide));
  CHECK_SAME("peak, rad/s", same.low_rad_s, stimulus_peak_rate_rad_s(&same));
  same.speed_ratio = 0.99f;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, experiment_check(&same, &wide));
}

static void test_a_sweep_needs_no_torque_of_its_own(void) {
  experiment_limits weak = wide;
  weak.torque_nm = 1e-3f;
  CHECK_STATUS(CONTROL_OK, experiment_check(&sweep, &weak));
  CHECK_STATUS(CONTROL_INCONSISTENT, experiment_check(&chirp, &weak));
}

/* Sticks until 8 Nm forward and 6 Nm backward, then slides. */
static void test_breakaway_torques_are_found_for_each_direction(void) {
  bench b = started(&breakaway, &wide);
  while (tick(&b)) {
    if (b.command.mode == SERVO_TORQUE && (b.command.torque_nm > 8.0f || b.command.torque_nm < -6.0f)) {
      b.angle_rad += b.command.torque_nm > 0.0f ? 1.5e-3 : -1.5e-3;
    }
  }
  TEST_ASSERT_EQUAL_INT(EXPERIMENT_DONE, b.e.state);
  const breakaway_statistics *found = b.e.stimulus.breakaway;
  TEST_ASSERT_EQUAL_UINT32(3, found[0].count);
  TEST_ASSERT_EQUAL_UINT32(3, found[1].count);
  CHECK_NEAR("backward, Nm", 6.0, found[0].mean_nm, 0.015);
  CHECK_NEAR("forward, Nm", 8.0, found[1].mean_nm, 0.015);
  CHECK_NEAR("spread, Nm^2", 0.0, found[1].square_sum_nm2, 1e-4);
}

static void test_an_axis_that_does_not_break_away_counts_nothing(void) {
  bench b = started(&breakaway, &wide);
  while (tick(&b)) {
  }
  TEST_ASSERT_EQUAL_INT(EXPERIMENT_DONE, b.e.state);
  TEST_ASSERT_EQUAL_UINT32(0, b.e.stimulus.breakaway[0].count + b.e.stimulus.breakaway[1].count);
  CHECK_NEAR("duration, s", 6.0 * 4.0 + 7.0 * 0.5, 1e-3 * b.ticks, 0.03); /* a rest around each rise */
  CHECK_NEAR("announced, s", 6.0 * (4.0 + 0.5), stimulus_duration_s(&breakaway), 1e-5);
}

/* --- what ends it --- */

static void test_every_command_carries_the_torque_limit(void) {
  const stimulus_setup all[] = {sweep, ramps, hysteresis, chirp, breakaway};
  for (int i = 0; i < 5; ++i) {
    bench b = started(&all[i], &wide);
    for (int t = 0; t < 3000 && tick(&b); ++t) {
      TEST_ASSERT_TRUE(b.command.torque_limited);
      CHECK_SAME("upper limit, Nm", 30.0, b.command.limits.maximum_nm);
      CHECK_SAME("lower limit, Nm", -30.0, b.command.limits.minimum_nm);
    }
  }
}

static void test_leaving_the_travel_ends_it(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    bench b = started(&ramps, &wide);
    TEST_ASSERT_TRUE(tick(&b));
    b.angle_rad = start_rad + sign * 0.99;
    TEST_ASSERT_TRUE(tick(&b));
    b.angle_rad = start_rad + sign * 1.01;
    TEST_ASSERT_FALSE(tick(&b));
    TEST_ASSERT_EQUAL_INT(EXPERIMENT_LEFT_TRAVEL, b.e.state);
    b.angle_rad = start_rad;
    TEST_ASSERT_FALSE(tick(&b));
  }
}

static void test_travel_is_counted_over_the_wrap_of_the_encoder(void) {
  const experiment_limits far = {.travel_rad = 3.0f, .rate_rad_s = 0.5f, .torque_nm = 30.0f, .duration_s = 200.0f};
  bench b = started(&ramps, &far);
  for (int i = 0; i < 3; ++i) { /* in steps of less than half a turn */
    b.angle_rad = start_rad - 1.4 * i;
    const bool goes_on = tick(&b);
    TEST_ASSERT_EQUAL(1.4 * i < 3.0, goes_on);
  }
  b.angle_rad = start_rad - 4.2;
  TEST_ASSERT_FALSE(tick(&b));
  TEST_ASSERT_EQUAL_INT(EXPERIMENT_LEFT_TRAVEL, b.e.state);
}

static void test_being_too_fast_or_of_no_rate_at_all_ends_it(void) {
  const double rates_rad_s[] = {0.51, -0.51, (double)NAN, (double)INFINITY};
  for (int i = 0; i < 4; ++i) {
    bench b = started(&ramps, &wide);
    b.rate_rad_s = rates_rad_s[i];
    TEST_ASSERT_FALSE(experiment_step(&b.e, encoder(start_rad), (float)b.rate_rad_s, &b.command, dt_s));
    TEST_ASSERT_EQUAL_INT(EXPERIMENT_TOO_FAST, b.e.state);
  }
}

static void test_lasting_too_long_ends_it(void) {
  experiment_limits brief = wide;
  brief.duration_s = stimulus_duration_s(&sweep);
  bench b = started(&sweep, &brief);
  for (int i = 0; i < 100000 && tick(&b); ++i) {
    b.angle_rad = start_rad; /* never comes to the end of the travel */
    b.e.stimulus.time_s[0] = b.e.stimulus.time_s[1] = 0.0f;
  }
  TEST_ASSERT_EQUAL_INT(EXPERIMENT_TOO_LONG, b.e.state);
  CHECK_NEAR("ticks", 1e3 * (double)brief.duration_s, b.ticks, 2);
}

static void test_an_abort_ends_a_running_one_and_leaves_the_verdict_of_one_that_is_over(void) {
  bench b = started(&ramps, &wide);
  TEST_ASSERT_TRUE(tick(&b));
  experiment_abort(&b.e, EXPERIMENT_ABORTED);
  TEST_ASSERT_FALSE(tick(&b));
  TEST_ASSERT_EQUAL_INT(EXPERIMENT_ABORTED, b.e.state);
  experiment_abort(&b.e, EXPERIMENT_DRIVE_STOPPED);
  TEST_ASSERT_EQUAL_INT(EXPERIMENT_ABORTED, b.e.state);
}

static void test_progress_counts_up_to_100(void) {
  bench b = started(&ramps, &wide);
  int last = 0;
  while (tick(&b)) {
    const int percent = experiment_progress_percent(&b.e, dt_s);
    TEST_ASSERT_TRUE(percent >= last && percent <= 99);
    CHECK_NEAR("progress, %", fmin(b.ticks / 120.0, 99.0), percent, 1.0); /* 12 s */
    last = percent;
  }
  CHECK_AT_LEAST("just before the end, %", 98, last);
  TEST_ASSERT_EQUAL_INT(100, experiment_progress_percent(&b.e, dt_s));
}

/* --- what is refused --- */

typedef struct {
  const char *what;
  stimulus_setup setup;
  experiment_limits limits;
  control_status status;
} refusal;

static refusal changed(const char *what, stimulus_setup setup, control_status status) {
  return (refusal){what, setup, wide, status};
}

/* A float of the set-up or of the limits, at 0 or more. */
typedef struct {
  const char *what;
  const stimulus_setup *setup;
  size_t of_setup, of_limits; /* offset of the member in one of them; the other is NONE */
  float low, high;
} range_row;

enum { NONE = 1000 };

#define OF(member_) offsetof(stimulus_setup, member_), NONE
#define LIMIT(member_) NONE, offsetof(experiment_limits, member_)

static control_status status_with(const range_row *row, float value) {
  refusal r = changed(row->what, *row->setup, CONTROL_OK);
  r.setup.high_hz = row->of_setup == offsetof(stimulus_setup, low_hz) ? 400.0f : r.setup.high_hz;
  float *member = row->of_setup != NONE ? (float *)(void *)((char *)&r.setup + row->of_setup)
                                        : (float *)(void *)((char *)&r.limits + row->of_limits);
  *member = value;
  return experiment_check(&r.setup, &r.limits);
}

/* Within its range, a value may still not fit the limits. */
static bool in_range(control_status status) { return status == CONTROL_OK || status == CONTROL_INCONSISTENT; }

static void test_each_value_is_taken_within_its_range_and_refused_outside(void) {
  static const range_row rows[] = {
      {"dwell, sweep", &sweep, OF(dwell_s), 0.01f, 1000.0f},
      {"dwell, ramps", &ramps, OF(dwell_s), 0.01f, 1000.0f},
      {"dwell, hysteresis", &hysteresis, OF(dwell_s), 0.01f, 1000.0f},
      {"dwell, chirp", &chirp, OF(dwell_s), 0.01f, 1000.0f},
      {"dwell, break-away", &breakaway, OF(dwell_s), 0.01f, 1000.0f},
      {"speed, sweep", &sweep, OF(low_rad_s), 1e-6f, 100.0f},
      {"speed, chirp", &chirp, OF(low_rad_s), 1e-6f, 100.0f},
      {"acceleration, sweep", &sweep, OF(acceleration_rad_s2), 1e-4f, 1e4f},
      {"acceleration, chirp", &chirp, OF(acceleration_rad_s2), 1e-4f, 1e4f},
      {"ratio, sweep", &sweep, OF(speed_ratio), 1.0f, 10.0f},
      {"torque, ramps", &ramps, OF(amplitude_nm), 1e-6f, 1e4f},
      {"torque, chirp", &chirp, OF(amplitude_nm), 1e-6f, 1e4f},
      {"torque, break-away", &breakaway, OF(amplitude_nm), 1e-6f, 1e4f},
      {"angle, hysteresis", &hysteresis, OF(amplitude_rad), 1e-7f, 3.0f},
      {"angle, break-away", &breakaway, OF(amplitude_rad), 1e-7f, 3.0f},
      {"lower frequency, chirp", &chirp, OF(low_hz), 0.01f, 400.0f},
      {"higher frequency, chirp", &chirp, OF(high_hz), 5.0f, 400.0f}, /* not below the lower one */
      {"limit of the travel", &ramps, LIMIT(travel_rad), 1e-6f, 3.0f},
      {"limit of the rate", &ramps, LIMIT(rate_rad_s), 1e-6f, 100.0f},
      {"limit of the torque", &ramps, LIMIT(torque_nm), 1e-6f, 1e4f},
      {"limit of the duration", &ramps, LIMIT(duration_s), 1e-3f, 3600.0f},
  };
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    const range_row *row = &rows[i];
    TEST_ASSERT_TRUE_MESSAGE(in_range(status_with(row, row->low)), row->what);
    TEST_ASSERT_TRUE_MESSAGE(in_range(status_with(row, row->high)), row->what);
    TEST_ASSERT_EQUAL_INT_MESSAGE(CONTROL_OUT_OF_RANGE, status_with(row, nextafterf(row->low, -1.0f)), row->what);
    TEST_ASSERT_EQUAL_INT_MESSAGE(CONTROL_OUT_OF_RANGE, status_with(row, nextafterf(row->high, 1e30f)), row->what);
    TEST_ASSERT_EQUAL_INT_MESSAGE(CONTROL_NOT_FINITE, status_with(row, NAN), row->what);
  }
}

static void test_a_count_is_1_to_1000_and_a_kind_one_of_five(void) {
  static const stimulus_setup *const all[] = {&sweep, &ramps, &hysteresis, &chirp, &breakaway};
  for (int i = 0; i < 5; ++i) {
    const struct {
      uint32_t count;
      bool taken;
    } counts[] = {{0, false}, {1, true}, {1000, true}, {1001, false}};
    for (int k = 0; k < 4; ++k) {
      stimulus_setup setup = *all[i];
      setup.count = counts[k].count;
      TEST_ASSERT_EQUAL(counts[k].taken, in_range(experiment_check(&setup, &wide)));
    }
  }
  for (int kind = 0; kind <= 6; kind += 6) {
    stimulus_setup setup = sweep;
    setup.kind = (stimulus_kind)kind;
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, experiment_check(&setup, &wide));
  }
}

/* At its limit a motion fits, beyond it not; a refused one leaves the experiment as it was. */
static void test_what_does_not_fit_its_limits_is_refused(void) {
  refusal r[12];
  int n = 0;
  r[n] = changed("as strong as permitted", ramps, CONTROL_OK), r[n++].setup.amplitude_nm = 30.0f;
  r[n] = changed("too strong", ramps, CONTROL_INCONSISTENT), r[n++].setup.amplitude_nm = 30.1f;
  r[n] = changed("as far as permitted", hysteresis, CONTROL_OK), r[n].setup.dwell_s = 20.0f,
  r[n++].setup.amplitude_rad = 0.9f; /* 0.18 rad/s */
  r[n] = changed("too far", hysteresis, CONTROL_INCONSISTENT), r[n].setup.dwell_s = 20.0f,
  r[n++].setup.amplitude_rad = 0.91f;
  r[n] = changed("as long as permitted", ramps, CONTROL_OK), r[n++].setup.count = 50; /* 50 of 4 s in 200 s */
  r[n] = changed("too long", ramps, CONTROL_INCONSISTENT), r[n++].setup.count = 51;
  r[n] = changed("fast enough", sweep, CONTROL_OK), r[n++].setup.count = 6;                    /* 0.32 rad/s */
  r[n] = changed("fastest of the sweep", sweep, CONTROL_INCONSISTENT), r[n++].setup.count = 7; /* 0.64 rad/s */
  r[n] = changed("fastest of the loops", hysteresis, CONTROL_INCONSISTENT), r[n++].setup.amplitude_rad = 0.3f;
  /* Legs of 0.02 rad/s, and twice the way from 0 to it: 0.02 T + 0.0008 rad of 0.9 rad. */
  r[n] = changed("a leg fits", chirp, CONTROL_OK), r[n].setup.count = 1, r[n++].setup.dwell_s = 44.9f;
  r[n] = changed("a leg is too long", chirp, CONTROL_INCONSISTENT), r[n].setup.count = 1, r[n++].setup.dwell_s = 44.97f;
  r[n] = changed("what the kind does not use", ramps, CONTROL_OK);
  r[n].setup.low_rad_s = r[n].setup.speed_ratio = r[n].setup.amplitude_rad = r[n].setup.low_hz = r[n].setup.high_hz =
      NAN;
  r[n++].setup.acceleration_rad_s2 = 0.0f;
  for (int i = 0; i < n; ++i) {
    experiment e = {.state = EXPERIMENT_DONE};
    const control_status status = experiment_start(&e, &r[i].setup, &r[i].limits, 0u);
    TEST_ASSERT_EQUAL_INT_MESSAGE(r[i].status, status, r[i].what);
    TEST_ASSERT_EQUAL_INT_MESSAGE(status == CONTROL_OK ? EXPERIMENT_RUNNING : EXPERIMENT_DONE, e.state, r[i].what);
  }
}

static void test_a_stimulus_of_torque_has_no_peak_rate(void) {
  stimulus_setup with_a_speed = chirp;
  with_a_speed.kind = STIMULUS_TORQUE_RAMPS;
  with_a_speed.low_rad_s = 0.4f;
  CHECK_SAME("peak, rad/s", 0.0, stimulus_peak_rate_rad_s(&with_a_speed));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_sweep_dwells_at_each_speed_in_both_directions_and_ends_at_rest);
  RUN_TEST(test_a_sweep_turns_round_within_a_short_travel_and_still_dwells);
  RUN_TEST(test_torque_ramps_are_triangles_of_the_amplitude);
  RUN_TEST(test_hysteresis_loops_are_triangles_of_position_around_the_start);
  RUN_TEST(test_a_chirp_rises_in_frequency_on_a_steady_speed_forth_and_back);
  RUN_TEST(test_each_leg_of_a_chirp_has_the_same_torques);
  RUN_TEST(test_a_sweep_beyond_1_rad_s_is_as_fast_and_as_long_as_its_speeds_say);
  RUN_TEST(test_a_sweep_may_repeat_one_speed);
  RUN_TEST(test_a_sweep_needs_no_torque_of_its_own);
  RUN_TEST(test_breakaway_torques_are_found_for_each_direction);
  RUN_TEST(test_an_axis_that_does_not_break_away_counts_nothing);
  RUN_TEST(test_every_command_carries_the_torque_limit);
  RUN_TEST(test_leaving_the_travel_ends_it);
  RUN_TEST(test_travel_is_counted_over_the_wrap_of_the_encoder);
  RUN_TEST(test_being_too_fast_or_of_no_rate_at_all_ends_it);
  RUN_TEST(test_lasting_too_long_ends_it);
  RUN_TEST(test_an_abort_ends_a_running_one_and_leaves_the_verdict_of_one_that_is_over);
  RUN_TEST(test_progress_counts_up_to_100);
  RUN_TEST(test_each_value_is_taken_within_its_range_and_refused_outside);
  RUN_TEST(test_a_count_is_1_to_1000_and_a_kind_one_of_five);
  RUN_TEST(test_what_does_not_fit_its_limits_is_refused);
  RUN_TEST(test_a_stimulus_of_torque_has_no_peak_rate);
  return UNITY_END();
}
