/* SPDX-License-Identifier: Apache-2.0 */
/* Current loop at 20 kHz on a winding that is discretised exactly: L di/dt = v - R i - Ke w, v held for a period. */
#include "control/current_loop.h"

#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

static const float dt_s = 50e-6f;
static const double resistance_ohm = 1.2;
static const double inductance_h = 3e-3;
static const double back_emf_v_s_rad = 2.5;
static const double bandwidth_rad_s = 3000.0; /* 480 Hz; w dt = 0.15 */

static current_loop_params designed(void) {
  current_loop_params params;
  CHECK_STATUS(CONTROL_OK, current_loop_design(&params, (float)resistance_ohm, (float)inductance_h,
                                               (float)back_emf_v_s_rad, (float)bandwidth_rad_s, dt_s));
  return params;
}

static double winding(double current_a, double voltage_v, double rate_rad_s) {
  const double decay = exp(-resistance_ohm / inductance_h * (double)dt_s);
  return decay * current_a + (1.0 - decay) / resistance_ohm * (voltage_v - back_emf_v_s_rad * rate_rad_s);
}

typedef struct {
  current_loop_params params;
  current_loop_state state;
  double current_a;
  float duty;
} bench;

static bench bench_at_rest(void) {
  bench b = {.params = designed(), .current_a = 0.0, .duty = 0.0f};
  current_loop_reset(&b.state);
  return b;
}

static void run_period(bench *b, float reference_a, double rate_rad_s, float bus_v) {
  b->duty = current_loop_step(&b->state, &b->params, reference_a, (float)b->current_a, (float)rate_rad_s, bus_v, dt_s);
  b->current_a = winding(b->current_a, (double)(b->duty * bus_v), rate_rad_s);
}

static void test_a_step_of_current_is_of_first_order_with_the_designed_bandwidth(void) {
  bench b = bench_at_rest();
  const double step = bandwidth_rad_s * (double)dt_s;
  double worst = 0.0;
  for (int period = 1; period <= 200; ++period) {
    run_period(&b, 2.0f, 0.0, 48.0f);
    const double held = 2.0 * (1.0 - pow(1.0 - step, period)); /* pole at 1 - w dt of the loop in steps */
    const double continuous = 2.0 * (1.0 - exp(-step * period));
    worst = fmax(worst, fabs(b.current_a - held) / 2.0);
    CHECK_NEAR("current against the continuous first order", continuous, b.current_a, 2.0 * 0.5 * step * 0.4);
    CHECK_AT_MOST("current", 2.0 * 1.01, b.current_a);
  }
  LOG_VALUE("largest difference to the first order in steps", worst);
  CHECK_AT_MOST("difference to the first order in steps", 0.01, worst); /* R dt / 2 L = 1 %: pole against zero */
  CHECK_NEAR("current at last", 2.0, b.current_a, 1e-4);
}

static void test_gains_are_bandwidth_times_l_and_r(void) {
  const current_loop_params params = designed();
  CHECK_RELATIVE("kp", 9.0, params.pi.proportional_gain, 1e-6);
  CHECK_RELATIVE("ki", 3600.0, params.pi.integral_gain, 1e-6);
  CHECK_RELATIVE("Ke", 2.5, params.back_emf_v_s_rad, 1e-6);
  CHECK_STATUS(CONTROL_OK, current_loop_check(&params, dt_s));
  CHECK_RELATIVE("anti-windup, 1/s", 400.0, params.pi.tracking_rate_per_s, 1e-6); /* R / L */
  current_loop_params fast;
  CHECK_STATUS(CONTROL_OK, current_loop_design(&fast, 100.0f, 3e-3f, 2.5f, (float)bandwidth_rad_s, dt_s));
  CHECK_RELATIVE("anti-windup, 1/s", 1e4, fast.pi.tracking_rate_per_s, 1e-6); /* half of it in a period */
}

static void test_the_back_emf_makes_no_current(void) {
  bench b = bench_at_rest();
  for (int period = 0; period < 400; ++period) {
    run_period(&b, 0.0f, period < 100 ? 0.0 : 4.0, 48.0f);
    CHECK_NEAR("current when the joint starts to turn", 0.0, b.current_a, 1e-5);
  }
  CHECK_NEAR("duty", 10.0 / 48.0, b.duty, 1e-5);
}

static void test_a_saturated_bus_gives_what_it_can_and_recovers_without_windup(void) {
  for (int side = -1; side <= 1; side += 2) {
    bench b = bench_at_rest();
    for (int period = 0; period < 4000; ++period) { /* 0.2 s at a current that 24 V cannot drive */
      run_period(&b, 60.0f * (float)side, 0.0, 24.0f);
      CHECK_AT_MOST("duty", 0.98 + 1e-6, fabs((double)b.duty));
    }
    CHECK_NEAR("current at the limit", side * 0.98 * 24.0 / resistance_ohm, b.current_a, 0.01);
    TEST_ASSERT_TRUE(b.state.limited);
    double undershoot_a = 0.0;
    for (int period = 0; period < 400; ++period) {
      run_period(&b, 5.0f * (float)side, 0.0, 24.0f);
      undershoot_a = fmax(undershoot_a, 5.0 - side * b.current_a);
    }
    TEST_ASSERT_FALSE(b.state.limited);
    CHECK_AT_MOST("undershoot of a step of 14.6 A", 0.5, undershoot_a);
    CHECK_NEAR("current after recovery", side * 5.0, b.current_a, 0.02);
  }
}

static void test_a_lost_bus_gives_no_duty_and_no_windup(void) {
  bench b = bench_at_rest();
  for (int period = 0; period < 400; ++period) {
    run_period(&b, 5.0f, 0.0, 48.0f);
  }
  for (int period = 0; period < 2000; ++period) {
    run_period(&b, 5.0f, 0.0, 0.99f);
    CHECK_SAME("duty", 0.0, b.duty);
    TEST_ASSERT_TRUE(b.state.limited);
  }
  CHECK_SAME("integral", 0.0, b.state.pi.integral);
  double highest_a = 0.0;
  for (int period = 0; period < 400; ++period) {
    run_period(&b, 5.0f, 0.0, 48.0f);
    highest_a = fmax(highest_a, b.current_a);
  }
  CHECK_AT_MOST("current after the return of the bus", 5.05, highest_a);
  CHECK_NEAR("current at last", 5.0, b.current_a, 1e-3);
  run_period(&b, 5.0f, 0.0, 0.0f);
  CHECK_SAME("duty without any bus", 0.0, b.duty);
  run_period(&b, 5.0f, 0.0, -48.0f);
  CHECK_SAME("duty at a negative bus", 0.0, b.duty);
  b.current_a = 0.0;
  run_period(&b, 5.0f, 0.0, 1.0f);
  CHECK_NEAR("duty from 1 V on", b.params.duty_limit, b.duty, 1e-6);
}

static void test_the_duty_limit_of_the_parameters_counts(void) {
  bench b = bench_at_rest();
  b.params.duty_limit = 0.3f;
  run_period(&b, 60.0f, 0.0, 24.0f);
  CHECK_NEAR("duty", 0.3, b.duty, 1e-6);
  run_period(&b, -60.0f, 0.0, 24.0f);
  CHECK_NEAR("duty", -0.3, b.duty, 1e-6);
}

static void test_reset_forgets_integral_and_limit(void) {
  const current_loop_params params = designed();
  current_loop_state state = {.pi = {.integral = 7.0f}, .limited = true};
  current_loop_reset(&state);
  TEST_ASSERT_FALSE(state.limited);
  CHECK_SAME("duty", 0.0, current_loop_step(&state, &params, 0.0f, 0.0f, 0.0f, 48.0f, dt_s));
}

static void test_any_design_that_is_accepted_settles(void) {
  random_source source = {14};
  for (int trial = 0; trial < random_cases(500); ++trial) {
    const double r = random_decades(&source, 1e-2, 1e2);
    const double l = r * random_decades(&source, 2e-4, 1e-1); /* electrical time from 4 periods up */
    const double w = random_decades(&source, 20.0, 15900.0);
    current_loop_params params;
    CHECK_STATUS(CONTROL_OK, current_loop_design(&params, (float)r, (float)l, 0.0f, (float)w, dt_s));
    current_loop_state state;
    current_loop_reset(&state);
    const double decay = exp(-r / l * (double)dt_s);
    double current_a = 0.0;
    double highest_a = 0.0;
    const float bus_v = 1e7f; /* never limits */
    const int periods = 40 + (int)(30.0 / (w * (double)dt_s));
    for (int period = 0; period < periods; ++period) {
      const float duty = current_loop_step(&state, &params, 1.0f, (float)current_a, 0.0f, bus_v, dt_s);
      current_a = decay * current_a + (1.0 - decay) / r * (double)(duty * bus_v);
      highest_a = fmax(highest_a, current_a);
    }
    CHECK_NEAR("current at last", 1.0, current_a, 0.03);
    CHECK_AT_MOST("highest current", 1.15, highest_a);
  }
}

static void test_design_refuses_each_value_by_itself_and_touches_nothing(void) {
  const float good[] = {1.2f, 3e-3f, 2.5f, 3000.0f, 50e-6f};
  const float bad[][2] = {{0.9e-4f, 1.01e3f}, {0.9e-7f, 10.1f}, {-0.1f, 1.01e3f}, {1.9f, 16100.0f}, {3e-8f, 3e-4f}};
  for (int i = 0; i < 5; ++i) {
    for (int b = 0; b < 3; ++b) {
      float v[5];
      for (int k = 0; k < 5; ++k) {
        v[k] = good[k];
      }
      v[i] = b == 2 ? NAN : bad[i][b];
      current_loop_params params = {.duty_limit = 0.123f};
      CHECK_STATUS(b == 2 ? CONTROL_NOT_FINITE : CONTROL_OUT_OF_RANGE,
                   current_loop_design(&params, v[0], v[1], v[2], v[3], v[4]));
      CHECK_SAME("untouched", 0.123f, params.duty_limit);
    }
  }
  current_loop_params params = {.duty_limit = 0.123f};
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, current_loop_design(&params, 1000.0f, 10.0f, 0.0f, 1.6e6f, 5e-7f));
  CHECK_SAME("untouched", 0.123f, params.duty_limit); /* kp would be 1.6e7 */
}

static void test_check_refuses_each_value_by_itself(void) {
  current_loop_params params = designed();
  float *const values[] = {&params.back_emf_v_s_rad, &params.duty_limit, &params.pi.proportional_gain};
  const float bad[][2] = {{-0.1f, 1.01e3f}, {0.009f, 1.01f}, {-1.0f, 1.01e6f}};
  for (int i = 0; i < 3; ++i) {
    const float good = *values[i];
    *values[i] = NAN;
    CHECK_STATUS(CONTROL_NOT_FINITE, current_loop_check(&params, dt_s));
    *values[i] = bad[i][0];
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, current_loop_check(&params, dt_s));
    *values[i] = bad[i][1];
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, current_loop_check(&params, dt_s));
    *values[i] = good;
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_step_of_current_is_of_first_order_with_the_designed_bandwidth);
  RUN_TEST(test_gains_are_bandwidth_times_l_and_r);
  RUN_TEST(test_the_back_emf_makes_no_current);
  RUN_TEST(test_a_saturated_bus_gives_what_it_can_and_recovers_without_windup);
  RUN_TEST(test_a_lost_bus_gives_no_duty_and_no_windup);
  RUN_TEST(test_the_duty_limit_of_the_parameters_counts);
  RUN_TEST(test_reset_forgets_integral_and_limit);
  RUN_TEST(test_any_design_that_is_accepted_settles);
  RUN_TEST(test_design_refuses_each_value_by_itself_and_touches_nothing);
  RUN_TEST(test_check_refuses_each_value_by_itself);
  return UNITY_END();
}
