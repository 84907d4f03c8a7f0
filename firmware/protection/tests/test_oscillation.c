/* SPDX-License-Identifier: Apache-2.0 */
/* The oscillation monitor on an axis of one inertia: which motions are oscillations, and which are not. */
#include <math.h>
#include <stdio.h>

#include "protection/oscillation.h"
#include "unity.h"

#define DT_S 0.001f
#define TURN_RAD 6.2831853f

void setUp(void) {}
void tearDown(void) {}

static const oscillation_params kPlant = {.inertia_kg_m2 = 6.0f, .friction_nm = 6.0f, .torque_nm = 40.0f};

/* Of a sine: the torque that the motor gives, the one that comes from outside, and what they do to the axis. */
typedef struct {
  float hz;
  float motor_nm;
  float outside_nm;
  float growth_per_s;
} sine;

/* The tick in which it is seen, or -1. */
static int seen_after(oscillation_params plant, sine s, bool closed, int ticks) {
  oscillation state;
  oscillation_reset(&state);
  float rate_rad_s = 0.0f;
  float last_nm = 0.0f;
  for (int tick = 0; tick < ticks; ++tick) {
    const float time_s = (float)tick * DT_S;
    const float size = expf(s.growth_per_s * time_s);
    const float now = cosf(TURN_RAD * s.hz * time_s);
    const float motor_nm = size * s.motor_nm * now;
    const float outside_nm = size * s.outside_nm * now;
    rate_rad_s += (0.5f * (motor_nm + last_nm) + outside_nm) / plant.inertia_kg_m2 * DT_S;
    const oscillation_inputs in = {
        .closed = closed, .reference_known = true, .rate_rad_s = rate_rad_s, .loop_nm = motor_nm};
    last_nm = motor_nm;
    if (oscillation_step(&state, &plant, &in, DT_S)) {
      return tick;
    }
  }
  return -1;
}

static void test_an_oscillation_that_the_motor_sustains_is_seen_within_half_a_second(void) {
  const float frequencies_hz[] = {4.0f, 8.0f, 15.0f, 30.0f, 60.0f, 125.0f, 250.0f};
  for (unsigned i = 0; i < sizeof frequencies_hz / sizeof frequencies_hz[0]; ++i) {
    const sine s = {.hz = frequencies_hz[i], .motor_nm = 35.0f};
    const int tick = seen_after(kPlant, s, true, 1000);
    TEST_ASSERT_TRUE_MESSAGE(tick >= 0 && tick <= 500, "not within half a second");
  }
}

/* Without friction the torque of the motor is all that may explain a swing, and it is counted whole. */
static void test_an_oscillation_is_seen_where_no_friction_explains_a_part_of_it(void) {
  oscillation_params plant = kPlant;
  plant.friction_nm = 0.0f;
  for (float hz = 4.0f; hz < 20.0f; hz *= 2.0f) {
    const sine s = {.hz = hz, .motor_nm = 35.0f};
    const int tick = seen_after(plant, s, true, 1000);
    TEST_ASSERT_TRUE_MESSAGE(tick >= 0 && tick <= 600, "not seen");
  }
}

/* A triangle of the rate, and a torque that follows it: each swing is made by the motor, and takes `ticks`. */
static bool triangle_is_seen(int ticks) {
  oscillation state;
  oscillation_reset(&state);
  oscillation_params plant = kPlant;
  plant.friction_nm = 0.0f;
  const float slope_rad_s2 = 0.5f;
  float rate_rad_s = 0.0f;
  float last_nm = 0.0f;
  for (int tick = 0; tick < 12 * ticks; ++tick) {
    const float motor_nm = plant.inertia_kg_m2 * (tick / ticks % 2 == 0 ? slope_rad_s2 : -slope_rad_s2);
    const oscillation_inputs in = {.closed = true, .rate_rad_s = rate_rad_s, .loop_nm = motor_nm};
    if (oscillation_step(&state, &plant, &in, DT_S)) {
      return true;
    }
    rate_rad_s += 0.5f * (motor_nm + last_nm) / plant.inertia_kg_m2 * DT_S;
    last_nm = motor_nm;
  }
  return false;
}

static void test_swings_of_600_ticks_and_more_are_no_oscillation(void) {
  TEST_ASSERT_TRUE(triangle_is_seen(300));
  TEST_ASSERT_TRUE(triangle_is_seen(599));
  TEST_ASSERT_FALSE(triangle_is_seen(600));
  TEST_ASSERT_FALSE(triangle_is_seen(1000));
}

/* Ticks until a triangle of the rate is seen, or -1. It begins after a rest in which a static load grows slowly;
 * a stimulus may alternate with it. */
typedef struct {
  int ticks; /* of a swing */
  bool suspect;
  bool known;         /* the set-point, from outside */
  float rest_nm;      /* of the load, by the end of the rest */
  float added_nm;     /* a stimulus that alternates as fast */
  float ripple_rad_s; /* the wind's during the rest: too small to be a swing */
  bool backwards;     /* the first swing */
  int pulse_at;       /* tick of a stimulus of 1 Nm during the rest; 0: none */
} slow_swings;

static int slow_swings_seen_after(slow_swings s) {
  enum { REST_TICKS = 2000 };
  oscillation state;
  oscillation_reset(&state);
  oscillation_params plant = kPlant;
  plant.suspect = s.suspect;
  const float slope_rad_s2 = 0.2f;
  float rate_rad_s = 0.0f;
  float load_nm = 0.0f;
  const float first = s.backwards ? -1.0f : 1.0f;
  for (int tick = -REST_TICKS; tick < 3000; ++tick) {
    const float side = tick < 0 ? 0.0f : tick / s.ticks % 2 == 0 ? first : -first;
    rate_rad_s = tick < 0 ? s.ripple_rad_s * sinf(TURN_RAD * (float)tick / 250.0f) : rate_rad_s;
    load_nm += tick < 0 ? s.rest_nm / (float)REST_TICKS : 0.0f;
    const oscillation_inputs in = {.closed = true,
                                   .reference_known = s.known,
                                   .rate_rad_s = rate_rad_s,
                                   .loop_nm = load_nm + side * plant.inertia_kg_m2 * slope_rad_s2,
                                   .added_nm = tick < 0 && tick == s.pulse_at ? 1.0f : side * s.added_nm};
    if (oscillation_step(&state, &plant, &in, DT_S)) {
      return tick;
    }
    rate_rad_s += side * slope_rad_s2 * DT_S;
  }
  return -1;
}

/* The second swing counts at 70 % of the first; together they last 300 ticks. */
static void test_two_slow_swings_of_new_gains_suffice(void) {
  TEST_ASSERT_INT_WITHIN(3, 340, slow_swings_seen_after((slow_swings){.ticks = 200, .suspect = true, .known = true}));
  TEST_ASSERT_INT_WITHIN(3, 510, slow_swings_seen_after((slow_swings){.ticks = 300, .suspect = true, .known = true}));
  TEST_ASSERT_INT_WITHIN(3, 300, slow_swings_seen_after((slow_swings){.ticks = 150, .suspect = true, .known = true}));
  TEST_ASSERT_INT_WITHIN(3, 740, slow_swings_seen_after((slow_swings){.ticks = 200, .known = true}));
}

static void test_two_slow_swings_do_not_suffice_while_camera_or_stimulus_may_make_them(void) {
  TEST_ASSERT_INT_WITHIN(3, 740, slow_swings_seen_after((slow_swings){.ticks = 200, .suspect = true}));
  TEST_ASSERT_INT_WITHIN(
      3, 740, slow_swings_seen_after((slow_swings){.ticks = 200, .suspect = true, .known = true, .added_nm = 1.0f}));
}

/* A stimulus of 1 Nm fades by 1 % in a tick, and counts above 2 % of the motor's torque: for 22 ticks more. The swings
 * begin behind tick 0. If it counts a tick longer than that, the second one is seen when it has ended. */
static void test_two_slow_swings_suffice_once_a_stimulus_has_faded(void) {
  slow_swings s = {.ticks = 200, .suspect = true, .known = true, .pulse_at = -22};
  TEST_ASSERT_INT_WITHIN(3, 340, slow_swings_seen_after(s));
  s.pulse_at = -21;
  TEST_ASSERT_INT_WITHIN(3, 400, slow_swings_seen_after(s));
}

/* The slow mean of the torque lags a load that grows; that must not explain a swing that comes later. Nor does the time
 * of the rest belong to the swing. */
static void test_what_happened_at_rest_explains_no_swing(void) {
  for (int side = -1; side <= 1; side += 2) {
    for (int row = 0; row < 3; ++row) {
      const slow_swings s = {.ticks = 200,
                             .suspect = true,
                             .known = true,
                             .rest_nm = 12.0f * (float)side,
                             .ripple_rad_s = row == 0 ? 0.0f : 0.002f,
                             .backwards = row == 2};
      TEST_ASSERT_INT_WITHIN(row == 0 ? 5 : 15, 340, slow_swings_seen_after(s));
    }
  }
}

static void test_new_gains_need_less_evidence(void) {
  oscillation_params plant = kPlant;
  plant.suspect = true;
  const sine slow = {.hz = 3.0f, .motor_nm = 30.0f};
  const sine growing = {.hz = 8.0f, .motor_nm = 4.0f, .growth_per_s = 20.0f};
  TEST_ASSERT_TRUE(seen_after(plant, slow, true, 1000) < seen_after(kPlant, slow, true, 1000));
  TEST_ASSERT_TRUE(seen_after(plant, growing, true, 300) >= 0);
  const sine fast = {.hz = 125.0f, .motor_nm = 35.0f};
  TEST_ASSERT_TRUE(seen_after(plant, fast, true, 1000) < seen_after(kPlant, fast, true, 1000));
}

/* With |S| = 2 the motor gives as much as comes from outside. The friction that may explain a part is small here. */
static void test_what_a_gust_of_any_frequency_does_is_no_oscillation(void) {
  oscillation_params plant = kPlant;
  plant.friction_nm = 1.0f;
  for (int suspect = 0; suspect < 2; ++suspect) {
    plant.suspect = suspect != 0;
    for (float hz = 1.0f; hz < 20.0f; hz *= 1.3f) {
      const sine resisted = {.hz = hz, .motor_nm = -18.0f, .outside_nm = 20.0f};
      const sine amplified = {.hz = hz, .motor_nm = 15.0f, .outside_nm = 15.0f};
      TEST_ASSERT_EQUAL(-1, seen_after(plant, resisted, true, 3000));
      if (hz > 5.0f || suspect == 0) { /* a slow gust is not much more than what friction may explain */
        TEST_ASSERT_EQUAL(-1, seen_after(plant, amplified, true, 3000));
      }
    }
  }
}

/* --- the limits of the header, one by one ------------------------------------------------------------------------- */

/* A triangle of the rate. The motor makes a share of each swing, the rest comes from outside. */
typedef struct {
  float size_rad_s;
  float ratio; /* of a swing to the one before */
  float share;
  float friction_nm;
  float load_nm; /* static */
  bool suspect;
} swings;

enum { SWING_TICKS = 100, LOAD_TICKS = 1500 };

/* Ticks after the begin of the first swing, or -1. */
static int swings_seen_after(swings s) {
  oscillation state;
  oscillation_reset(&state);
  oscillation_params plant = kPlant;
  plant.friction_nm = s.friction_nm;
  plant.suspect = s.suspect;
  for (int tick = 0; tick < LOAD_TICKS; ++tick) {
    const oscillation_inputs in = {.closed = true, .loop_nm = s.load_nm};
    TEST_ASSERT_FALSE(oscillation_step(&state, &plant, &in, DT_S));
  }
  float rate_rad_s = 0.0f;
  float size_rad_s = s.size_rad_s;
  for (int tick = 0; tick < 40 * SWING_TICKS; ++tick) {
    size_rad_s *= tick > 0 && tick % SWING_TICKS == 0 ? s.ratio : 1.0f;
    const float slope_rad_s2 = (tick / SWING_TICKS % 2 == 0 ? size_rad_s : -size_rad_s) / ((float)SWING_TICKS * DT_S);
    rate_rad_s += slope_rad_s2 * DT_S;
    const oscillation_inputs in = {
        .closed = true, .rate_rad_s = rate_rad_s, .loop_nm = s.load_nm + s.share * plant.inertia_kg_m2 * slope_rad_s2};
    if (oscillation_step(&state, &plant, &in, DT_S)) {
      return tick + 1;
    }
  }
  return -1;
}

/* Ticks of the same swings, 100 each: the fourth one counts as soon as it is large enough. */
static void expect_swings(const char *what, int ticks, swings s) {
  TEST_ASSERT_INT_WITHIN_MESSAGE(ticks < 0 ? 0 : 1, ticks, swings_seen_after(s), what);
}

static void test_a_swing_of_1_degree_per_second_counts_and_a_smaller_one_does_not(void) {
  expect_swings("0.0174 rad/s", -1, (swings){.size_rad_s = 0.0174f, .ratio = 1.0f, .share = 1.0f});
  expect_swings("0.0176 rad/s", 400, (swings){.size_rad_s = 0.0176f, .ratio = 1.0f, .share = 1.0f});
  expect_swings("0.02 rad/s", 388, (swings){.size_rad_s = 0.02f, .ratio = 1.0f, .share = 1.0f});
}

/* 1 / (1 - share) is what the loop makes of the excitation. The mean of the torque takes some swings to settle. */
static void test_a_swing_counts_when_it_is_more_than_2_5_times_its_excitation(void) {
  expect_swings("60 % by the motor", -1, (swings){.size_rad_s = 0.2f, .ratio = 1.0f, .share = 0.6f});
  expect_swings("65 % by the motor", 671, (swings){.size_rad_s = 0.2f, .ratio = 1.0f, .share = 0.65f});
  expect_swings("70 % by the motor", 471, (swings){.size_rad_s = 0.2f, .ratio = 1.0f, .share = 0.7f});
}

/* Half of 1.2 Nm s comes from outside: friction may explain its torque times 0.1 s of it. */
static void test_friction_explains_a_part_of_each_swing(void) {
  expect_swings("1.3 Nm", -1, (swings){.size_rad_s = 0.2f, .ratio = 1.0f, .share = 0.5f, .friction_nm = 1.3f});
  expect_swings("1.5 Nm", 871, (swings){.size_rad_s = 0.2f, .ratio = 1.0f, .share = 0.5f, .friction_nm = 1.5f});
  expect_swings("2 Nm", 471, (swings){.size_rad_s = 0.2f, .ratio = 1.0f, .share = 0.5f, .friction_nm = 2.0f});
  expect_swings("3 Nm", 370, (swings){.size_rad_s = 0.2f, .ratio = 1.0f, .share = 0.5f, .friction_nm = 3.0f});
}

static void test_swings_that_decay_to_70_percent_do_not_count(void) {
  expect_swings("70 %", -1, (swings){.size_rad_s = 4.0f, .ratio = 0.7f, .share = 1.0f});
  expect_swings("71 %", 399, (swings){.size_rad_s = 4.0f, .ratio = 0.71f, .share = 1.0f});
  expect_swings("76 %", 393, (swings){.size_rad_s = 4.0f, .ratio = 0.76f, .share = 1.0f});
}

/* The third one counts as soon as it is larger than the second by half. */
static void test_new_gains_may_not_let_swings_grow_by_half(void) {
  for (int suspect = 0; suspect <= 1; ++suspect) {
    const bool is_new = suspect != 0;
    expect_swings("48 % more", 348, (swings){.size_rad_s = 0.02f, .ratio = 1.48f, .share = 1.0f, .suspect = is_new});
    expect_swings("60 % more", is_new ? 294 : 344,
                  (swings){.size_rad_s = 0.02f, .ratio = 1.6f, .share = 1.0f, .suspect = is_new});
  }
}

/* The rate error rises to 0.1 rad/s, then ripples below it; the motor makes all of it. The tick, or -1. */
static int ripple_seen_after(float ripple_rad_s) {
  enum { RISE_TICKS = 100, RIPPLE_TICKS = 50 };
  oscillation state;
  oscillation_reset(&state);
  oscillation_params plant = kPlant;
  plant.friction_nm = 0.0f;
  float rate_rad_s = 0.0f;
  for (int tick = 0; tick < 2000; ++tick) {
    const bool falls = (tick - RISE_TICKS) / RIPPLE_TICKS % 2 == 0;
    const float rippled_rad_s = (falls ? -ripple_rad_s : ripple_rad_s) / (float)RIPPLE_TICKS;
    const float step_rad_s = tick < RISE_TICKS ? 0.1f / (float)RISE_TICKS : rippled_rad_s;
    rate_rad_s -= step_rad_s;
    const oscillation_inputs in = {
        .closed = true, .rate_rad_s = rate_rad_s, .loop_nm = -plant.inertia_kg_m2 * step_rad_s / DT_S};
    if (oscillation_step(&state, &plant, &in, DT_S)) {
      return tick;
    }
  }
  return -1;
}

static void test_a_swing_turns_when_30_percent_of_it_are_taken_back(void) {
  TEST_ASSERT_EQUAL(-1, ripple_seen_after(0.028f));
  TEST_ASSERT_TRUE(ripple_seen_after(0.032f) > 0);
}

static void test_a_static_load_explains_nothing(void) {
  expect_swings("10 Nm", 370, (swings){.size_rad_s = 0.2f, .ratio = 1.0f, .share = 1.0f, .load_nm = 10.0f});
}

/* A square wave of the torque, with one of what is added from outside. */
static int square_seen_after(bool suspect, int ticks, float nm, float added_nm) {
  oscillation state;
  oscillation_reset(&state);
  oscillation_params plant = kPlant;
  plant.suspect = suspect;
  for (int tick = 0; tick < 3000; ++tick) {
    const float side = tick / ticks % 2 == 0 ? 1.0f : -1.0f;
    const oscillation_inputs in = {.closed = true, .loop_nm = side * nm, .added_nm = side * added_nm};
    if (oscillation_step(&state, &plant, &in, DT_S)) {
      return tick;
    }
  }
  return -1;
}

/* 16 of the smallest size, or 48 for a proven set: peak to peak half of the motor's 40 Nm counts as one. */
static void test_torque_swings_count_by_their_size(void) {
  TEST_ASSERT_EQUAL(-1, square_seen_after(true, 4, 9.9f, 0.0f));
  TEST_ASSERT_EQUAL(17 * 4, square_seen_after(true, 4, 10.1f, 0.0f));
  TEST_ASSERT_EQUAL(9 * 4, square_seen_after(true, 4, 20.0f, 0.0f));
  TEST_ASSERT_EQUAL(5 * 4, square_seen_after(true, 4, 40.0f, 0.0f));
  TEST_ASSERT_EQUAL(-1, square_seen_after(false, 4, 9.9f, 0.0f));
  TEST_ASSERT_EQUAL(49 * 4, square_seen_after(false, 4, 10.1f, 0.0f));
  TEST_ASSERT_EQUAL(25 * 4, square_seen_after(false, 4, 20.0f, 0.0f));
  TEST_ASSERT_EQUAL(13 * 4, square_seen_after(false, 4, 40.0f, 0.0f));
}

/* Of 40 Nm peak to peak in 8 ticks; in each the torque goes back by `dip_nm` for a tick. */
static int dips_seen_after(float dip_nm) {
  oscillation state;
  oscillation_reset(&state);
  oscillation_params plant = kPlant;
  plant.suspect = true;
  for (int tick = 0; tick < 1000; ++tick) {
    const float side = tick / 8 % 2 == 0 ? 1.0f : -1.0f;
    const float share_nm[] = {0.0f, 0.0f, -dip_nm, 20.0f, 20.0f, 20.0f, 20.0f, 20.0f};
    const oscillation_inputs in = {.closed = true, .loop_nm = side * share_nm[tick % 8]};
    if (oscillation_step(&state, &plant, &in, DT_S)) {
      return tick;
    }
  }
  return -1;
}

/* A quarter of the motor's 40 Nm. */
static void test_a_torque_that_goes_back_by_less_than_a_quarter_of_the_motors_has_not_turned(void) {
  TEST_ASSERT_TRUE(dips_seen_after(9.5f) > 0);
  TEST_ASSERT_EQUAL(-1, dips_seen_after(10.5f));
}

/* Its acceleration explains torque, not its rate: at 1 Hz and 0.02 rad/s, 0.75 Nm. */
static void test_a_slow_motion_of_the_set_point_explains_no_fast_torque(void) {
  oscillation state;
  oscillation_reset(&state);
  oscillation_params plant = kPlant;
  plant.suspect = true;
  int ticks = 0;
  for (bool seen = false; !seen && ticks < 3000; ++ticks) {
    const float rate_rad_s = 0.02f * sinf(TURN_RAD * (float)ticks * DT_S);
    const oscillation_inputs in = {.closed = true,
                                   .reference_rad_s = rate_rad_s,
                                   .rate_rad_s = rate_rad_s,
                                   .loop_nm = ticks / 4 % 2 == 0 ? 20.0f : -20.0f};
    seen = oscillation_step(&state, &plant, &in, DT_S);
  }
  TEST_ASSERT_EQUAL(9 * 4 + 1, ticks);
}

static void test_torque_swings_of_20_ticks_and_more_do_not_count(void) {
  TEST_ASSERT_EQUAL(9 * 19, square_seen_after(true, 19, 20.0f, 0.0f));
  TEST_ASSERT_EQUAL(-1, square_seen_after(true, 20, 20.0f, 0.0f));
  TEST_ASSERT_EQUAL(-1, square_seen_after(true, 60, 20.0f, 0.0f));
}

static void test_a_torque_from_outside_explains_swings_of_twice_its_size(void) {
  TEST_ASSERT_EQUAL(9 * 4, square_seen_after(true, 4, 20.0f, 9.9f));
  TEST_ASSERT_EQUAL(-1, square_seen_after(true, 4, 20.0f, 10.6f));
}

/* Added from outside for a single tick, in either direction. It fades with 0.1 s: it explains swings of 40 Nm as long
 * as twice of what is left is more. The first swing after that counts, and three more of them are enough. */
static void test_a_torque_that_was_added_explains_the_swings_of_the_next_ticks(void) {
  for (int side = -1; side <= 1; side += 2) {
    oscillation state;
    oscillation_reset(&state);
    oscillation_params plant = kPlant;
    plant.suspect = true;
    int seen = -1;
    for (int tick = 0; tick < 1000 && seen < 0; ++tick) {
      const oscillation_inputs in = {.closed = true,
                                     .loop_nm = tick / 4 % 2 == 0 ? 20.0f : -20.0f,
                                     .added_nm = tick == 2 ? 39.0f * (float)side : 0.0f};
      seen = oscillation_step(&state, &plant, &in, DT_S) ? tick : -1;
    }
    TEST_ASSERT_INT_WITHIN(4, 2 + 66 + 9 * 4, seen);
  }
}

/* From rest, the motor makes `share` of the motion that its constant torque drives away from the set-point. */
static int away_after(bool suspect, float nm, float share, float feedforward_nm, float step_rad_s, bool known) {
  oscillation state;
  oscillation_reset(&state);
  oscillation_params plant = kPlant;
  plant.friction_nm = 0.0f;
  plant.suspect = suspect;
  float rate_rad_s = 0.0f;
  float last_nm = 0.0f;
  for (int tick = 0; tick < 200; ++tick) {
    const oscillation_inputs in = {.closed = true,
                                   .reference_rad_s = -step_rad_s,
                                   .reference_known = known,
                                   .rate_rad_s = rate_rad_s,
                                   .loop_nm = nm,
                                   .feedforward_nm = feedforward_nm};
    if (oscillation_step(&state, &plant, &in, DT_S)) {
      return tick;
    }
    rate_rad_s += 0.5f * (nm + last_nm) / share / plant.inertia_kg_m2 * DT_S;
    last_nm = nm;
  }
  return -1;
}

static void test_at_rest_12_percent_of_the_torque_in_the_wrong_direction_is_too_much(void) {
  TEST_ASSERT_EQUAL(-1, away_after(true, 4.8f, 1.0f, 0.0f, 0.0f, true));
  TEST_ASSERT_INT_WITHIN(2, 22, away_after(true, 5.3f, 1.0f, 0.0f, 0.0f, true));
  TEST_ASSERT_EQUAL(-1, away_after(true, 6.0f, 1.0f, 0.0f, 0.0f, false)); /* in tracking 15 percent */
  TEST_ASSERT_INT_WITHIN(2, 18, away_after(true, 6.6f, 1.0f, 0.0f, 0.0f, false));
  TEST_ASSERT_INT_WITHIN(1, 11, away_after(true, 12.0f, 1.0f, 0.0f, 0.0f, true));
  /* 60 percent, in one tick: the first in which the axis is faster than 1 degree per second */
  TEST_ASSERT_EQUAL(5, away_after(true, 24.7f, 1.0f, 0.0f, 0.0f, true));
  TEST_ASSERT_EQUAL(5 + 1, away_after(true, 23.9f, 1.0f, 0.0f, 0.0f, true));
  TEST_ASSERT_EQUAL(-1, away_after(false, 12.0f, 1.0f, 0.0f, 0.0f, true)); /* a proven set may */
  TEST_ASSERT_INT_WITHIN(1, 11, away_after(true, 12.0f, 1.0f, 5.0f, 0.0f, true));
  TEST_ASSERT_EQUAL(-1, away_after(true, 12.0f, 1.0f, 7.5f, 0.0f, true));  /* most of it follows from the set-point */
  TEST_ASSERT_EQUAL(-1, away_after(true, 12.0f, 0.55f, 0.0f, 0.0f, true)); /* a gust makes the rest */
  TEST_ASSERT_INT_WITHIN(1, 8, away_after(true, 12.0f, 0.65f, 0.0f, 0.0f, true));
}

static void test_after_a_step_of_the_set_point_60_percent_in_the_wrong_direction_are_too_much(void) {
  TEST_ASSERT_EQUAL(-1, away_after(true, 25.0f, 1.0f, 0.0f, 0.03f, true));
  TEST_ASSERT_INT_WITHIN(1, 13, away_after(true, 26.0f, 1.0f, 0.0f, 0.03f, true));
  TEST_ASSERT_INT_WITHIN(1, 11, away_after(true, 35.0f, 1.0f, 0.0f, 0.03f, true));
}

/* It has moved at its set-point since: the step fades with 0.2 s. 12 Nm is a quarter of the motor's torque. */
static void test_a_second_after_a_step_of_the_set_point_15_percent_are_too_much_again(void) {
  const int settled_ticks[] = {200, 1200};
  for (int i = 0; i < 2; ++i) {
    oscillation state;
    oscillation_reset(&state);
    oscillation_params plant = kPlant;
    plant.friction_nm = 0.0f;
    plant.suspect = true;
    float rate_rad_s = -0.1f;
    float last_nm = 0.0f;
    bool seen = false;
    for (int tick = 0; tick < settled_ticks[i] + 16; ++tick) {
      const float nm = tick < settled_ticks[i] ? 0.0f : 12.0f;
      const oscillation_inputs in = {.closed = true, .reference_rad_s = -0.1f, .rate_rad_s = rate_rad_s, .loop_nm = nm};
      seen = oscillation_step(&state, &plant, &in, DT_S) || seen;
      rate_rad_s += 0.5f * (nm + last_nm) / plant.inertia_kg_m2 * DT_S;
      last_nm = nm;
    }
    TEST_ASSERT_EQUAL(i == 1, seen);
  }
}

static void test_an_open_loop_does_not_oscillate(void) {
  const sine s = {.hz = 15.0f, .motor_nm = 35.0f};
  TEST_ASSERT_EQUAL(-1, seen_after(kPlant, s, false, 1000));
}

static void test_a_loop_that_opens_begins_anew(void) {
  oscillation state;
  oscillation_reset(&state);
  oscillation_params plant = kPlant;
  plant.suspect = true;
  int closed = 0;
  bool seen = false;
  for (int tick = 0; !seen && tick < 3000; ++tick) { /* 30 ticks of it, then the loop is open for one */
    const oscillation_inputs in = {.closed = tick != 30, .loop_nm = tick / 4 % 2 == 0 ? 20.0f : -20.0f};
    closed = in.closed ? closed + 1 : 0;
    seen = oscillation_step(&state, &plant, &in, DT_S);
  }
  TEST_ASSERT_INT_WITHIN(4, 9 * 4, closed);
}

static void test_a_decaying_oscillation_is_left_to_decay(void) {
  const sine s = {.hz = 5.0f, .motor_nm = 35.0f, .growth_per_s = -8.0f};
  TEST_ASSERT_EQUAL(-1, seen_after(kPlant, s, true, 3000));
}

/* A chirp on the set-point, and the torque that follows it. */
static void test_a_set_point_explains_the_torque_that_follows_it(void) {
  oscillation state;
  oscillation_reset(&state);
  for (int tick = 0; tick < 3000; ++tick) {
    const float phase_rad = TURN_RAD * 40.0f * (float)tick * DT_S;
    const oscillation_inputs in = {.closed = true,
                                   .reference_rad_s = 0.02f * sinf(phase_rad),
                                   .rate_rad_s = 0.02f * sinf(phase_rad),
                                   .loop_nm = 6.0f * 0.02f * TURN_RAD * 40.0f * cosf(phase_rad)};
    TEST_ASSERT_FALSE(oscillation_step(&state, &kPlant, &in, DT_S));
  }
}

static void test_fast_torque_swings_are_reported_before_they_count(void) {
  oscillation state;
  oscillation_reset(&state);
  oscillation_params plant = kPlant;
  plant.suspect = true;
  bool reported = false;
  for (int tick = 0; tick < 100; ++tick) {
    const oscillation_inputs in = {.closed = true, .loop_nm = tick / 2 % 2 == 0 ? 35.0f : -35.0f};
    if (oscillation_step(&state, &plant, &in, DT_S)) {
      TEST_ASSERT_TRUE(reported);
      return;
    }
    reported = oscillation_may_begin(&state);
  }
  TEST_FAIL_MESSAGE("not seen");
}

enum { LONGEST_DELAY = 64 };

/* A proportional loop around the inertia, whose rate is some ticks old. It holds a static load without an error. */
typedef struct {
  float gain_nm_s_rad;
  int delay_ticks;
  float load_nm;
  float step_rad_s; /* of the set-point */
  float kick_rad_s; /* of the rate, in the tick in which the loop gets its gain */
} loop;

typedef struct {
  int tick; /* after the kick or step; -1: not seen */
  float peak_rad_s;
} sighting;

static sighting seen_in(oscillation_params plant, loop l, int ticks) {
  oscillation state;
  oscillation_reset(&state);
  float rates_rad_s[LONGEST_DELAY] = {0};
  float rate_rad_s = 0.0f;
  float last_nm = 0.0f;
  sighting s = {.tick = -1};
  for (int tick = -1500; tick < ticks; ++tick) {
    rate_rad_s += tick == 0 ? l.kick_rad_s : 0.0f;
    const unsigned now = (unsigned)(tick + 1500);
    rates_rad_s[now % LONGEST_DELAY] = rate_rad_s;
    const float old_rad_s = rates_rad_s[(now - (unsigned)l.delay_ticks) % LONGEST_DELAY];
    const float reference_rad_s = tick >= 0 ? l.step_rad_s : 0.0f;
    const float wanted_nm = l.load_nm + (tick >= 0 ? l.gain_nm_s_rad * (reference_rad_s - old_rad_s) : 0.0f);
    const float loop_nm = fminf(fmaxf(wanted_nm, -plant.torque_nm), plant.torque_nm);
    const oscillation_inputs in = {
        .closed = true, .reference_rad_s = reference_rad_s, .rate_rad_s = rate_rad_s, .loop_nm = loop_nm};
    if (oscillation_step(&state, &plant, &in, DT_S)) {
      s.tick = tick;
      return s;
    }
    rate_rad_s += (0.5f * (loop_nm + last_nm) - l.load_nm) / plant.inertia_kg_m2 * DT_S;
    last_nm = loop_nm;
    s.peak_rad_s = fmaxf(s.peak_rad_s, fabsf(rate_rad_s));
  }
  return s;
}

/* J / delay times pi / 2 is the gain at which the loop begins to oscillate. */
static float limit_gain(int delay_ticks) { return 6.0f * 1.5708f / ((float)delay_ticks * DT_S); }

static void test_new_gains_that_are_unstable_are_seen_before_the_axis_is_fast_with_and_without_a_load(void) {
  oscillation_params plant = kPlant;
  plant.suspect = true;
  plant.friction_nm = 1.0f;
  static const float loads_nm[] = {0.0f, 15.0f, -15.0f};
  static const float kicks_rad_s[] = {0.002f, -0.002f};
  for (unsigned load = 0; load < 3; ++load) {
    for (unsigned kick = 0; kick < 2; ++kick) {
      for (int delay = 10; delay <= 40; delay += 10) {
        for (float factor = 1.5f; factor < 7.0f; factor *= 2.0f) {
          const loop l = {factor * limit_gain(delay), delay, loads_nm[load], 0.0f, kicks_rad_s[kick]};
          const sighting s = seen_in(plant, l, 2000);
          char text[120];
          (void)snprintf(text, sizeof text, "delay %d ms, %.1f times the limit, load %.0f: tick %d, peak %.4f rad/s",
                         delay, (double)factor, (double)l.load_nm, s.tick, (double)s.peak_rad_s);
          TEST_ASSERT_TRUE_MESSAGE(s.tick >= 0 && s.tick <= 10 * delay, text);
          TEST_ASSERT_TRUE_MESSAGE(s.peak_rad_s <= 0.035f, text); /* 2 deg/s */
        }
      }
    }
  }
}

static void test_healthy_gains_may_overshoot_after_a_step(void) {
  oscillation_params plant = kPlant;
  plant.suspect = true;
  plant.friction_nm = 1.0f;
  static const float steps_rad_s[] = {0.02f, 0.1f, -0.1f, 0.3f, -1.0f};
  for (unsigned step = 0; step < 5; ++step) {
    for (int delay = 5; delay <= 40; delay += 5) {
      for (float factor = 0.2f; factor < 0.5f; factor += 0.1f) {
        const loop l = {factor * limit_gain(delay), delay, 0.0f, steps_rad_s[step], 0.0f};
        const sighting s = seen_in(plant, l, 3000);
        char text[120];
        (void)snprintf(text, sizeof text, "delay %d ms, %.1f of the limit, step %.2f: tick %d", delay, (double)factor,
                       (double)l.step_rad_s, s.tick);
        TEST_ASSERT_EQUAL_INT_MESSAGE(-1, s.tick, text);
      }
    }
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_an_oscillation_that_the_motor_sustains_is_seen_within_half_a_second);
  RUN_TEST(test_an_oscillation_is_seen_where_no_friction_explains_a_part_of_it);
  RUN_TEST(test_swings_of_600_ticks_and_more_are_no_oscillation);
  RUN_TEST(test_two_slow_swings_of_new_gains_suffice);
  RUN_TEST(test_two_slow_swings_do_not_suffice_while_camera_or_stimulus_may_make_them);
  RUN_TEST(test_two_slow_swings_suffice_once_a_stimulus_has_faded);
  RUN_TEST(test_what_happened_at_rest_explains_no_swing);
  RUN_TEST(test_new_gains_need_less_evidence);
  RUN_TEST(test_what_a_gust_of_any_frequency_does_is_no_oscillation);
  RUN_TEST(test_a_swing_of_1_degree_per_second_counts_and_a_smaller_one_does_not);
  RUN_TEST(test_a_swing_counts_when_it_is_more_than_2_5_times_its_excitation);
  RUN_TEST(test_friction_explains_a_part_of_each_swing);
  RUN_TEST(test_swings_that_decay_to_70_percent_do_not_count);
  RUN_TEST(test_new_gains_may_not_let_swings_grow_by_half);
  RUN_TEST(test_a_swing_turns_when_30_percent_of_it_are_taken_back);
  RUN_TEST(test_a_static_load_explains_nothing);
  RUN_TEST(test_torque_swings_count_by_their_size);
  RUN_TEST(test_a_torque_that_goes_back_by_less_than_a_quarter_of_the_motors_has_not_turned);
  RUN_TEST(test_a_slow_motion_of_the_set_point_explains_no_fast_torque);
  RUN_TEST(test_torque_swings_of_20_ticks_and_more_do_not_count);
  RUN_TEST(test_a_torque_from_outside_explains_swings_of_twice_its_size);
  RUN_TEST(test_a_torque_that_was_added_explains_the_swings_of_the_next_ticks);
  RUN_TEST(test_at_rest_12_percent_of_the_torque_in_the_wrong_direction_is_too_much);
  RUN_TEST(test_after_a_step_of_the_set_point_60_percent_in_the_wrong_direction_are_too_much);
  RUN_TEST(test_a_second_after_a_step_of_the_set_point_15_percent_are_too_much_again);
  RUN_TEST(test_an_open_loop_does_not_oscillate);
  RUN_TEST(test_a_loop_that_opens_begins_anew);
  RUN_TEST(test_a_decaying_oscillation_is_left_to_decay);
  RUN_TEST(test_a_set_point_explains_the_torque_that_follows_it);
  RUN_TEST(test_fast_torque_swings_are_reported_before_they_count);
  RUN_TEST(test_new_gains_that_are_unstable_are_seen_before_the_axis_is_fast_with_and_without_a_load);
  RUN_TEST(test_healthy_gains_may_overshoot_after_a_step);
  return UNITY_END();
}
