/* SPDX-License-Identifier: Apache-2.0 */
/* The LuGre block alone: closed forms of one tick, properties over thousands of random seals, refusals. */
#include "control/lugre.h"

#include "support/check.h"
#include "support/random.h"
#include "support/seals.h"

void setUp(void) {}
void tearDown(void) {}

static const double float_rounding = 5.96e-8; /* half a unit in the last place, relative */

static void test_lugre_holds_still_below_breakaway(void) {
  const lugre_params seal = stiff_seal();
  lugre_state state;
  lugre_reset(&state);
  for (int tick = 0; tick < 100; ++tick) { /* 0.1 mrad: half of the break-away deflection */
    (void)lugre_step(&state, &seal, 1e-3f, 1e-3f);
  }
  const float held_rad = state.deflection_rad;
  const float held_nm = seal.stiffness_nm_rad * held_rad;
  CHECK_AT_LEAST("torque held", 1.0, held_nm);
  CHECK_AT_MOST("torque held", 14.0, held_nm);
  for (int tick = 0; tick < 10000; ++tick) {
    CHECK_SAME("torque at standstill", held_nm, lugre_step(&state, &seal, 0.0f, 1e-3f));
  }
  CHECK_SAME("deflection", held_rad, state.deflection_rad);
}

static void test_lugre_is_a_spring_for_motion_far_below_breakaway(void) {
  lugre_params seal = stiff_seal();
  seal.damping_nm_s_rad = 0.0f;
  seal.positive.viscous_nm_s_rad = 0.0f;
  lugre_state state;
  lugre_reset(&state);
  float torque_nm = 0.0f;
  for (int tick = 0; tick < 100; ++tick) {
    torque_nm = lugre_step(&state, &seal, 1e-5f, 1e-3f);
  }
  /* 99.5 ticks of 10 nrad: the mean of the last tick. The bristles slip by about F/Ts = 0.5 % of it. */
  CHECK_RELATIVE("spring torque", 7.0e4 * 99.5e-8, torque_nm, 0.005);
}

static void test_lugre_starts_again_from_zero_after_reset(void) {
  const lugre_params seal = stiff_seal();
  lugre_state state = {.deflection_rad = 1e-4f};
  lugre_reset(&state);
  CHECK_SAME("deflection", 0.0, state.deflection_rad);
  CHECK_SAME("torque", 0.0, lugre_step(&state, &seal, 0.0f, 1e-3f));
}

/* One tick against the closed solution in double, for rate * dt from 1e-6 (spring) to 250 (sliding). The series and
 * the closed form of the block meet at 0.5; both sides are in the sweep. */
static void test_lugre_tick_is_the_exact_solution_for_any_length_of_tick(void) {
  lugre_params seal = stiff_even_seal();
  seal.damping_nm_s_rad = 0.9f; /* too small to be reduced below 44 rad/s: that has its own test */
  const float dt_s = 1e-3f;
  double worst = 0.0;
  for (int i = 0; i <= 4000; ++i) {
    const double wanted_x = pow(10.0, -6.0 + 8.4 * i / 4000.0);
    const float speed_rad_s = (float)(wanted_x * 10.0 / (7.0e4 * 1e-3));
    lugre_state state = {.deflection_rad = -1e-4f};
    const float torque_nm = lugre_step(&state, &seal, speed_rad_s, dt_s);

    const double v = (double)speed_rad_s;
    const double ratio = v / (double)seal.positive.stribeck_speed_rad_s;
    const double rate = 7.0e4 * v / (10.0 + 4.0 * exp(-ratio * ratio));
    const double x = rate * (double)dt_s;
    const double settled = v / rate;
    const double z0 = (double)-1e-4f;
    const double end = settled + (z0 - settled) * exp(-x);
    const double mean = settled - (z0 - settled) * expm1(-x) / x;
    const double expected_nm = 7.0e4 * mean + (double)0.9f * (end - z0) / (double)dt_s + (double)11.9f * v;
    CHECK_NEAR("deflection after the tick", end, state.deflection_rad, 2e-6 * 2e-4);
    worst = fmax(worst, fabs((double)torque_nm - expected_nm) / (14.0 + fabs(expected_nm)));
  }
  LOG_VALUE("largest torque error of one tick, relative", worst);
  CHECK_AT_MOST("torque error of one tick", 3e-7, worst);
}

static void test_lugre_reduces_s1_only_where_the_model_would_not_be_passive(void) {
  const lugre_params seal = stiff_even_seal(); /* limit: 4 g / s1 = 40 / 900 = 0.0444 rad/s */
  const float dt_s = 1e-7f;                    /* so short that the mean slope is the slope at the start */
  const float speeds_rad_s[] = {0.040f, 0.045f, 0.0889f, 4.0f};
  const double damping_nm_s_rad[] = {900.0, 40.0 / 0.045, 40.0 / 0.0889, 40.0 / 4.0};
  for (int i = 0; i < 4; ++i) {
    lugre_state state;
    lugre_reset(&state);
    const double v = (double)speeds_rad_s[i];
    const double spring_nm = 0.5 * 7.0e4 * v * 1e-7;
    const double expected_nm = spring_nm + (damping_nm_s_rad[i] + (double)11.9f) * v;
    CHECK_RELATIVE("first torque from rest", expected_nm, lugre_step(&state, &seal, speeds_rad_s[i], dt_s), 4e-3);
  }
}

static void test_lugre_stribeck_curve_runs_from_breakaway_to_coulomb(void) {
  const lugre_direction direction = seal_direction(10.0f, 14.0f, 0.003f, 11.9f);
  CHECK_NEAR("at rest", 14.0, lugre_stribeck_nm(&direction, 0.0f), 1e-6);
  CHECK_NEAR("at vs", 10.0 + 4.0 * exp(-1.0), lugre_stribeck_nm(&direction, 0.003f), 1e-5);
  CHECK_SAME("sign of speed", lugre_stribeck_nm(&direction, 0.002f), lugre_stribeck_nm(&direction, -0.002f));
  CHECK_SAME("fast", 10.0, lugre_stribeck_nm(&direction, 1e3f));
  CHECK_SAME("absurdly fast", 10.0, lugre_stribeck_nm(&direction, 3e38f));
  for (int i = 0; i <= 2000; ++i) {
    const double v = 2e-5 * i;
    const double ratio = v / (double)0.003f;
    CHECK_NEAR("eq. (3)", 10.0 + 4.0 * exp(-ratio * ratio), lugre_stribeck_nm(&direction, (float)v), 1e-5);
  }
}

static void test_lugre_steady_torque_follows_eq_5_in_each_direction(void) {
  const lugre_params seal = stiff_seal();
  CHECK_SAME("standstill", 0.0, lugre_steady_nm(&seal, 0.0f));
  CHECK_NEAR("forward", 10.0 + 4.0 * exp(-4.0 / 9.0) + (double)11.9f * 0.002, lugre_steady_nm(&seal, 0.002f), 2e-5);
  CHECK_NEAR("backward", -(8.5 + 4.5 * exp(-0.25)) - 10.5 * 0.002, lugre_steady_nm(&seal, -0.002f), 2e-5);
  CHECK_RELATIVE("fast", 10.0 + (double)11.9f * 5.0, lugre_steady_nm(&seal, 5.0f), 1e-6);
}

static void test_lugre_settles_on_the_steady_curve_at_every_speed_up_to_1000_rad_s(void) {
  const lugre_params seal = stiff_seal();
  random_source source = {3};
  for (int trial = 0; trial < 300; ++trial) {
    const double sign = random_uniform(&source, -1.0, 1.0) < 0.0 ? -1.0 : 1.0;
    const float speed_rad_s = (float)(sign * random_decades(&source, 1e-3, 1e3));
    const float dt_s = (float)random_decades(&source, 1e-5, 1e-2);
    lugre_state state;
    lugre_reset(&state);
    /* 30 bristle lengths (0.2 mrad) of travel, at least 5 ticks. */
    const int ticks = (int)(30.0 * 2e-4 / (fabs((double)speed_rad_s) * (double)dt_s)) + 5;
    float torque_nm = 0.0f;
    for (int tick = 0; tick < ticks; ++tick) {
      torque_nm = lugre_step(&state, &seal, speed_rad_s, dt_s);
    }
    /* A float z stops creeping when the change in a tick, the share x of the remainder, is below its last bit. */
    const double level_nm = (double)(speed_rad_s > 0.0f ? seal.positive : seal.negative).breakaway_nm;
    const double share = fmin(1.0, 7.0e4 * fabs((double)speed_rad_s) * (double)dt_s / level_nm);
    CHECK_RELATIVE("settled torque", lugre_steady_nm(&seal, speed_rad_s), torque_nm,
                   2e-6 + 2.0 * float_rounding / share);
  }
}

static lugre_direction random_direction(random_source *source, double stiffness_nm_rad) {
  const double highest_nm = fmin(stiffness_nm_rad, 1e4);
  const double breakaway_nm = random_decades(source, 1e-4, highest_nm);
  const double coulomb_nm = random_bits(source) % 2 == 0 ? random_uniform(source, 0.1, 1.0) * breakaway_nm
                                                         : random_decades(source, 1e-6, breakaway_nm);
  const double viscous_nm_s_rad = random_bits(source) % 4 == 0 ? 0.0 : random_decades(source, 1e-6, 1e4);
  return seal_direction((float)coulomb_nm, (float)breakaway_nm, (float)random_decades(source, 1e-6, 1e2),
                        (float)viscous_nm_s_rad);
}

/* Any seal that lugre_check accepts, over the whole of its ranges. */
static lugre_params random_seal(random_source *source) {
  for (;;) {
    const double stiffness_nm_rad = random_decades(source, 1e-3, 1e9);
    const double damping_nm_s_rad = random_bits(source) % 8 == 0 ? 0.0 : random_decades(source, 1e-6, 1e6);
    const lugre_direction positive = random_direction(source, stiffness_nm_rad);
    const lugre_direction negative = random_direction(source, stiffness_nm_rad);
    const lugre_params seal = seal_of((float)stiffness_nm_rad, (float)damping_nm_s_rad, positive, negative);
    if (lugre_check(&seal) == CONTROL_OK) {
      return seal;
    }
  }
}

/* A speed held for a while, then a jump: mostly within the seal's range, sometimes up to 1000 rad/s. */
static float next_speed(random_source *source, const lugre_params *seal, float speed_rad_s) {
  const uint64_t choice = random_bits(source) % 10;
  if (choice < 5) {
    return speed_rad_s;
  }
  if (choice == 5) {
    return 0.0f;
  }
  const double sign = random_bits(source) % 2 == 0 ? 1.0 : -1.0;
  const double around = (double)seal->positive.stribeck_speed_rad_s;
  const double magnitude = choice < 8 ? random_decades(source, 1e-3 * around, 1e1 * around)  //
                                      : random_decades(source, 1e-8, 1e3);
  return (float)(sign * fmin(magnitude, 1e3));
}

static double larger_breakaway(const lugre_params *seal) {
  return fmax((double)seal->positive.breakaway_nm, (double)seal->negative.breakaway_nm);
}

static void test_lugre_is_passive_bounded_and_finite_for_any_seal_speed_and_tick(void) {
  random_source source = {4};
  for (int trial = 0; trial < random_cases(5000); ++trial) {
    const lugre_params seal = random_seal(&source);
    const float dt_s = (float)random_decades(&source, 1e-5, 1e-2);
    const double stiffness = (double)seal.stiffness_nm_rad;
    const double highest_nm = larger_breakaway(&seal);
    const double largest_rad = highest_nm / stiffness;
    double work_j = 0.0;
    double slack_j = 0.0; /* effect of rounding to float on the sum */
    float speed_rad_s = 0.0f;
    lugre_state state;
    lugre_reset(&state);
    for (int tick = 0; tick < 200; ++tick) {
      speed_rad_s = next_speed(&source, &seal, speed_rad_s);
      const double viscous = (double)(speed_rad_s >= 0.0f ? seal.positive : seal.negative).viscous_nm_s_rad;
      const double v = (double)speed_rad_s;
      const double torque_nm = (double)lugre_step(&state, &seal, speed_rad_s, dt_s);
      const double z = (double)state.deflection_rad;
      TEST_ASSERT_TRUE_MESSAGE(isfinite(torque_nm) && isfinite(z), "a value is not finite");
      CHECK_AT_MOST("|z| over max(Ts)/s0", 1.0 + 1e-6, fabs(z) / largest_rad);
      work_j += torque_nm * v * (double)dt_s;
      /* Terms of the torque are below 10 Ts + s2 |v|; the stored energy is off by s0 z dz. */
      slack_j += 16.0 * float_rounding *
                 ((10.0 * highest_nm + viscous * fabs(v)) * fabs(v) * (double)dt_s + highest_nm * largest_rad);
      const double stored_j = 0.5 * stiffness * z * z;
      CHECK_AT_LEAST("work less stored energy", -slack_j, work_j - stored_j);
    }
  }
}

static void test_lugre_is_odd_when_both_directions_are_equal(void) {
  random_source source = {5};
  for (int trial = 0; trial < random_cases(2000); ++trial) {
    lugre_params seal = random_seal(&source);
    seal.negative = seal.positive;
    const float dt_s = (float)random_decades(&source, 1e-5, 1e-2);
    lugre_state forward;
    lugre_state backward;
    lugre_reset(&forward);
    lugre_reset(&backward);
    float speed_rad_s = 0.0f;
    for (int tick = 0; tick < 50; ++tick) {
      speed_rad_s = next_speed(&source, &seal, speed_rad_s);
      const float torque_nm = lugre_step(&forward, &seal, speed_rad_s, dt_s);
      CHECK_SAME("torque", -torque_nm, lugre_step(&backward, &seal, -speed_rad_s, dt_s));
      CHECK_SAME("deflection", -forward.deflection_rad, backward.deflection_rad);
    }
  }
}

static void test_lugre_uses_each_directions_own_parameters(void) {
  const lugre_params seal = stiff_seal();
  lugre_state state;
  lugre_reset(&state);
  for (int tick = 0; tick < 200; ++tick) {
    (void)lugre_step(&state, &seal, 0.05f, 1e-3f);
  }
  CHECK_RELATIVE("deflection forward", 10.0 / 7.0e4, state.deflection_rad, 1e-5);
  for (int tick = 0; tick < 200; ++tick) {
    (void)lugre_step(&state, &seal, -0.05f, 1e-3f);
  }
  CHECK_RELATIVE("deflection backward", -8.5 / 7.0e4, state.deflection_rad, 1e-5);
}

static void expect_refusals(float *value, lugre_params *seal, float low, float high) {
  const float good = *value;
  const float bad[] = {NAN, INFINITY, -INFINITY, low - 0.01f * fabsf(low) - 1e-30f, 1.01f * high};
  const control_status answers[] = {CONTROL_NOT_FINITE, CONTROL_NOT_FINITE, CONTROL_NOT_FINITE, CONTROL_OUT_OF_RANGE,
                                    CONTROL_OUT_OF_RANGE};
  for (int i = 0; i < 5; ++i) {
    *value = bad[i];
    CHECK_STATUS(answers[i], lugre_check(seal));
  }
  *value = good;
  CHECK_STATUS(CONTROL_OK, lugre_check(seal));
}

static void test_lugre_check_refuses_each_value_by_itself(void) {
  lugre_params seal = stiff_seal();
  expect_refusals(&seal.stiffness_nm_rad, &seal, 1e-3f, 1e9f);
  expect_refusals(&seal.damping_nm_s_rad, &seal, 0.0f, 1e6f);
  lugre_direction *directions[] = {&seal.positive, &seal.negative};
  for (int i = 0; i < 2; ++i) {
    expect_refusals(&directions[i]->coulomb_nm, &seal, 1e-6f, 1e4f);
    expect_refusals(&directions[i]->breakaway_nm, &seal, 1e-6f, 1e4f);
    expect_refusals(&directions[i]->stribeck_speed_rad_s, &seal, 1e-6f, 1e2f);
    expect_refusals(&directions[i]->viscous_nm_s_rad, &seal, 0.0f, 1e4f);
  }
}

static void test_lugre_check_refuses_breakaway_below_coulomb(void) {
  lugre_params seal = stiff_seal();
  seal.positive.breakaway_nm = nextafterf(seal.positive.coulomb_nm, 0.0f);
  CHECK_STATUS(CONTROL_INCONSISTENT, lugre_check(&seal));
  seal.positive.breakaway_nm = seal.positive.coulomb_nm; /* no Stribeck effect: allowed */
  CHECK_STATUS(CONTROL_OK, lugre_check(&seal));
  seal.negative.breakaway_nm = nextafterf(seal.negative.coulomb_nm, 0.0f);
  CHECK_STATUS(CONTROL_INCONSISTENT, lugre_check(&seal));
}

static void test_lugre_check_refuses_bristles_that_bend_by_more_than_a_radian(void) {
  lugre_params seal = stiff_seal();
  seal.stiffness_nm_rad = 14.0f; /* Ts of the positive direction: exactly 1 rad */
  CHECK_STATUS(CONTROL_OK, lugre_check(&seal));
  seal.stiffness_nm_rad = 13.99f;
  CHECK_STATUS(CONTROL_INCONSISTENT, lugre_check(&seal));
  seal.positive = seal_direction(5.0f, 5.0f, 0.01f, 0.0f);
  CHECK_STATUS(CONTROL_OK, lugre_check(&seal));
  seal.negative.breakaway_nm = 14.5f;
  CHECK_STATUS(CONTROL_INCONSISTENT, lugre_check(&seal));
}

static void test_lugre_check_accepts_the_ends_of_the_ranges(void) {
  const lugre_direction weakest = seal_direction(1e-6f, 1e-6f, 1e-6f, 0.0f);
  const lugre_direction strongest = seal_direction(1e4f, 1e4f, 1e2f, 1e4f);
  const lugre_params soft = seal_of(1e-3f, 0.0f, weakest, weakest);
  const lugre_params hard = seal_of(1e9f, 1e6f, strongest, weakest);
  CHECK_STATUS(CONTROL_OK, lugre_check(&soft));
  CHECK_STATUS(CONTROL_OK, lugre_check(&hard));
}

static void test_settled_bristles_are_those_of_long_sliding(void) {
  const lugre_params seal = stiff_seal();
  const float speeds_rad_s[] = {0.05f, -0.05f, 0.001f, -0.002f};
  for (int i = 0; i < 4; ++i) {
    lugre_state slid = {0};
    lugre_state settled = {1.0f};
    for (int tick = 0; tick < 5000; ++tick) {
      (void)lugre_step(&slid, &seal, speeds_rad_s[i], 1e-3f);
    }
    lugre_settle(&settled, &seal, speeds_rad_s[i]);
    CHECK_RELATIVE("deflection, rad", slid.deflection_rad, settled.deflection_rad, 1e-5);
  }
  lugre_state state = {1.0f};
  lugre_settle(&state, &seal, 0.0f);
  CHECK_SAME("relaxed, rad", 0.0, state.deflection_rad);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_lugre_holds_still_below_breakaway);
  RUN_TEST(test_lugre_is_a_spring_for_motion_far_below_breakaway);
  RUN_TEST(test_lugre_starts_again_from_zero_after_reset);
  RUN_TEST(test_lugre_tick_is_the_exact_solution_for_any_length_of_tick);
  RUN_TEST(test_lugre_reduces_s1_only_where_the_model_would_not_be_passive);
  RUN_TEST(test_lugre_stribeck_curve_runs_from_breakaway_to_coulomb);
  RUN_TEST(test_lugre_steady_torque_follows_eq_5_in_each_direction);
  RUN_TEST(test_lugre_settles_on_the_steady_curve_at_every_speed_up_to_1000_rad_s);
  RUN_TEST(test_lugre_is_passive_bounded_and_finite_for_any_seal_speed_and_tick);
  RUN_TEST(test_lugre_is_odd_when_both_directions_are_equal);
  RUN_TEST(test_lugre_uses_each_directions_own_parameters);
  RUN_TEST(test_lugre_check_refuses_each_value_by_itself);
  RUN_TEST(test_lugre_check_refuses_breakaway_below_coulomb);
  RUN_TEST(test_lugre_check_refuses_bristles_that_bend_by_more_than_a_radian);
  RUN_TEST(test_lugre_check_accepts_the_ends_of_the_ranges);
  RUN_TEST(test_settled_bristles_are_those_of_long_sliding);
  return UNITY_END();
}
