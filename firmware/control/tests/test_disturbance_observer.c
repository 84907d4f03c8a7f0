/* SPDX-License-Identifier: Apache-2.0 */
/* Disturbance observer on the discrete nominal plant J (v[k+1] - v[k]) / dt = u[k] - B v[k] - load. */
#include "control/disturbance_observer.h"

#include "base/scalar.h"
#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

static const float dt_s = 1e-3f;

static disturbance_observer_params example(void) {
  return (disturbance_observer_params){
      .inertia_kg_m2 = 23.5f, .viscous_nm_s_rad = 11.876f, .bandwidth_rad_s = 60.0f, .limit_nm = 100.0f};
}

/* The nominal plant, in double. */
static double moved(const disturbance_observer_params *p, double rate, double torque, double load) {
  return rate + 1e-3 * (torque - (double)p->viscous_nm_s_rad * rate - load) / (double)p->inertia_kg_m2;
}

static void test_a_step_of_load_is_found_along_an_exponential(void) {
  const float bandwidths_rad_s[] = {5.0f, 60.0f, 400.0f, 1000.0f};
  for (int i = 0; i < 4; ++i) {
    disturbance_observer_params params = example();
    params.bandwidth_rad_s = bandwidths_rad_s[i];
    disturbance_observer_state state;
    double rate = 0.02;
    disturbance_observer_reset(&state, &params, (float)rate, dt_s);
    double worst = 0.0;
    for (int tick = 1; tick <= 1000; ++tick) {
      const double torque = 3.0 * sin(0.02 * tick); /* the motor's torque meanwhile must not show */
      rate = moved(&params, rate, torque, 8.0);
      const double seen = (double)disturbance_observer_step(&state, &params, (float)rate, (float)torque);
      const double expected = 8.0 * (1.0 - exp(-(double)bandwidths_rad_s[i] * 1e-3 * tick));
      worst = fmax(worst, fabs(seen - expected));
    }
    LOG_VALUE("largest difference to the exponential, Nm of 8", worst);
    CHECK_AT_MOST("difference to the exponential", 2e-3, worst);
  }
}

static void test_no_load_leaves_the_estimate_at_zero_whatever_the_motor_does(void) {
  const disturbance_observer_params params = example();
  disturbance_observer_state state;
  random_source source = {8};
  double rate = 0.0;
  disturbance_observer_reset(&state, &params, 0.0f, dt_s);
  for (int tick = 0; tick < 5000; ++tick) {
    const double torque = random_uniform(&source, -50.0, 50.0);
    rate = moved(&params, rate, (double)(float)torque, 0.0);
    CHECK_NEAR("estimate", 0.0, disturbance_observer_step(&state, &params, (float)rate, (float)torque), 2e-3);
  }
}

/* The inertia shrinks by 0.1 % per tick, at a constant rate and load: the estimate does not see it. */
static void test_an_inertia_that_is_followed_leaves_the_estimate(void) {
  disturbance_observer_params params = example();
  disturbance_observer_state state;
  disturbance_observer_reset(&state, &params, 0.5f, dt_s);
  const float holding_nm = 8.0f + params.viscous_nm_s_rad * 0.5f;
  for (int tick = 0; tick < 1000; ++tick) {
    (void)disturbance_observer_step(&state, &params, 0.5f, holding_nm);
  }
  float inertia_kg_m2 = params.inertia_kg_m2;
  for (int tick = 0; tick < 500; ++tick) {
    inertia_kg_m2 -= 1e-3f * params.inertia_kg_m2;
    disturbance_observer_follow(&state, &params, inertia_kg_m2, 0.5f, dt_s);
    CHECK_NEAR("estimate, Nm", 8.0, disturbance_observer_step(&state, &params, 0.5f, holding_nm), 2e-3);
  }
  params.inertia_kg_m2 = inertia_kg_m2; /* now the observer is that of this inertia */
  double rate = 0.5;
  double seen_nm = 0.0;
  for (int tick = 0; tick < 200; ++tick) {
    rate = moved(&params, rate, (double)holding_nm + 5.0, 8.0);
    seen_nm = (double)disturbance_observer_step(&state, &params, (float)rate, holding_nm + 5.0f);
  }
  CHECK_NEAR("estimate while it accelerates, Nm", 8.0, seen_nm, 5e-3);
}

static void test_torque_that_is_already_explained_is_not_seen(void) {
  const disturbance_observer_params params = example();
  disturbance_observer_state state;
  double rate = 0.0;
  disturbance_observer_reset(&state, &params, 0.0f, dt_s);
  float estimate_nm = 0.0f;
  for (int tick = 0; tick < 1000; ++tick) { /* load 10, of which feedforward explains 7 and the motor gives all */
    rate = moved(&params, rate, 10.0, 10.0);
    estimate_nm = disturbance_observer_step(&state, &params, (float)rate, 10.0f - 7.0f);
  }
  CHECK_NEAR("estimate", 3.0, estimate_nm, 1e-3);
}

static void test_it_is_the_textbook_filter_for_any_torque_and_rate(void) {
  random_source source = {9};
  for (int trial = 0; trial < 200; ++trial) {
    const disturbance_observer_params params = {.inertia_kg_m2 = (float)random_decades(&source, 1e-6, 1e3),
                                                .viscous_nm_s_rad = (float)random_decades(&source, 1e-6, 1e2),
                                                .bandwidth_rad_s = (float)random_decades(&source, 0.01, 1000.0),
                                                .limit_nm = 1e4f};
    CHECK_STATUS(CONTROL_OK, disturbance_observer_check(&params, dt_s));
    const double inertia = (double)params.inertia_kg_m2;
    const double gap = -expm1(-(double)params.bandwidth_rad_s * (double)dt_s);
    disturbance_observer_state state;
    float previous_rad_s = (float)random_normal(&source);
    disturbance_observer_reset(&state, &params, previous_rad_s, dt_s);
    /* Q [u - (J s + B) v], with the derivative taken as a difference. */
    double textbook_nm = 0.0;
    for (int tick = 0; tick < 200; ++tick) {
      const float rate_rad_s = (float)random_normal(&source);
      const float torque_nm = (float)random_normal(&source);
      const double slope = ((double)rate_rad_s - (double)previous_rad_s) / (double)dt_s;
      textbook_nm += gap * ((double)torque_nm - (double)params.viscous_nm_s_rad * (double)previous_rad_s -
                            inertia * slope - textbook_nm);
      previous_rad_s = rate_rad_s;
      (void)disturbance_observer_step(&state, &params, rate_rad_s, torque_nm);
      /* Rounding of the terms, summed over the memory of the filter; 1 - exp(-w dt) itself is off by 1e-7. */
      const double scale = gap * inertia / (double)dt_s + (double)params.viscous_nm_s_rad + 1.0;
      CHECK_NEAR("estimate", textbook_nm, state.estimate_nm, 2e-5 * scale + 3e-7 / gap * fabs(textbook_nm));
    }
  }
}

static void test_reset_at_any_rate_starts_with_no_estimate(void) {
  disturbance_observer_params params = example();
  params.viscous_nm_s_rad = 0.0f;
  const float rates_rad_s[] = {0.0f, 0.01f, -3.0f, 100.0f};
  for (int i = 0; i < 4; ++i) {
    disturbance_observer_state state = {.prediction_nm = 55.0f, .estimate_nm = -3.0f};
    disturbance_observer_reset(&state, &params, rates_rad_s[i], dt_s);
    CHECK_SAME("estimate", 0.0, state.estimate_nm);
    for (int tick = 0; tick < 200; ++tick) { /* it coasts: no torque, no load */
      const float estimate_nm = disturbance_observer_step(&state, &params, rates_rad_s[i], 0.0f);
      /* w J v is 1.4e5 Nm at 100 rad/s; a float rounds it to 0.01. */
      CHECK_NEAR("estimate", 0.0, estimate_nm, 3e-7 * 60.0 * 23.5 * fabs((double)rates_rad_s[i]) / 0.06);
    }
  }
}

static void test_the_compensation_stays_within_its_limit_while_the_estimate_reports_the_truth(void) {
  disturbance_observer_params params = example();
  params.limit_nm = 5.0f;
  for (int side = -1; side <= 1; side += 2) {
    disturbance_observer_state state;
    double rate = 0.0;
    disturbance_observer_reset(&state, &params, 0.0f, dt_s);
    float compensation_nm = 0.0f;
    for (int tick = 0; tick < 500; ++tick) {
      rate = moved(&params, rate, 0.0, 20.0 * side);
      compensation_nm = disturbance_observer_step(&state, &params, (float)rate, 0.0f);
    }
    CHECK_SAME("compensation", 5.0 * side, compensation_nm);
    CHECK_NEAR("estimate", 20.0 * side, state.estimate_nm, 2e-3);
  }
}

/* A load that the drive cannot hold, then a small one: the observer gets the applied torque, so it must show the load
 * and nothing of the torque that the limit removed. */
static void test_a_saturated_drive_does_not_wind_it_up(void) {
  const disturbance_observer_params params = example();
  const double limits_nm[][2] = {{-5.0, 5.0}, {-2.0, 9.0}, {3.0, 9.0}, {-9.0, -3.0}};
  for (int i = 0; i < 4; ++i) {
    disturbance_observer_state state;
    double rate = 0.0;
    double compensation_nm = 0.0;
    disturbance_observer_reset(&state, &params, 0.0f, dt_s);
    for (int tick = 0; tick < 4000; ++tick) {
      const double load_nm = tick < 3000 ? 40.0 : 6.0;
      const double applied_nm = fmin(fmax(compensation_nm, limits_nm[i][0]), limits_nm[i][1]);
      rate = moved(&params, rate, applied_nm, load_nm);
      compensation_nm = (double)disturbance_observer_step(&state, &params, (float)rate, (float)applied_nm);
      CHECK_AT_MOST("estimate under saturation", 40.1, state.estimate_nm);
      CHECK_AT_LEAST("estimate under saturation", -0.1, state.estimate_nm);
      if (tick == 2999) {
        CHECK_NEAR("estimate of the large load", 40.0, state.estimate_nm, 0.05);
      }
      if (tick == 3000 + 115) { /* 7 time constants later: 34 exp(-7) = 0.03 Nm */
        CHECK_NEAR("estimate of the small load", 6.0, state.estimate_nm, 0.1);
      }
    }
  }
}

static void test_rate_noise_reaches_the_torque_by_w_j_and_no_more(void) {
  const disturbance_observer_params params = example();
  disturbance_observer_state state;
  random_source source = {10};
  disturbance_observer_reset(&state, &params, 0.0f, dt_s);
  double largest = 0.0;
  for (int tick = 0; tick < 20000; ++tick) {
    const float rate_rad_s = random_bits(&source) % 2 == 0 ? 1e-4f : -1e-4f;
    const float estimate_nm = disturbance_observer_step(&state, &params, rate_rad_s, 0.0f);
    largest = fmax(largest, fabs((double)estimate_nm));
  }
  /* d = w J (v - lowpass v): at most twice the amplitude, whatever the noise; a differentiator gives 2 J/dt = 4.7
   * Nm. */
  CHECK_AT_MOST("torque from noise", 2.0 * 60.0 * 23.5 * 1e-4, largest);
  CHECK_AT_LEAST("torque from noise", 0.5 * 60.0 * 23.5 * 1e-4, largest);
}

static void test_check_refuses_each_value_by_itself(void) {
  disturbance_observer_params params = example();
  CHECK_STATUS(CONTROL_OK, disturbance_observer_check(&params, dt_s));
  float *const values[] = {&params.inertia_kg_m2, &params.viscous_nm_s_rad, &params.bandwidth_rad_s, &params.limit_nm};
  const float bad[][2] = {{0.9e-9f, 1.1e5f}, {-1e-3f, 1.1e4f}, {0.009f, 1001.0f}, {-1e-3f, 1.1e4f}};
  for (int i = 0; i < 4; ++i) {
    const float good = *values[i];
    *values[i] = NAN;
    CHECK_STATUS(CONTROL_NOT_FINITE, disturbance_observer_check(&params, 1e-4f));
    *values[i] = bad[i][0];
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, disturbance_observer_check(&params, 1e-4f));
    *values[i] = bad[i][1];
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, disturbance_observer_check(&params, 1e-4f));
    *values[i] = good;
  }
  params.bandwidth_rad_s = 1000.0f;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, disturbance_observer_check(&params, 1.01e-3f));
  CHECK_STATUS(CONTROL_OK, disturbance_observer_check(&params, 1e-3f));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_step_of_load_is_found_along_an_exponential);
  RUN_TEST(test_no_load_leaves_the_estimate_at_zero_whatever_the_motor_does);
  RUN_TEST(test_an_inertia_that_is_followed_leaves_the_estimate);
  RUN_TEST(test_torque_that_is_already_explained_is_not_seen);
  RUN_TEST(test_it_is_the_textbook_filter_for_any_torque_and_rate);
  RUN_TEST(test_reset_at_any_rate_starts_with_no_estimate);
  RUN_TEST(test_the_compensation_stays_within_its_limit_while_the_estimate_reports_the_truth);
  RUN_TEST(test_a_saturated_drive_does_not_wind_it_up);
  RUN_TEST(test_rate_noise_reaches_the_torque_by_w_j_and_no_more);
  RUN_TEST(test_check_refuses_each_value_by_itself);
  return UNITY_END();
}
