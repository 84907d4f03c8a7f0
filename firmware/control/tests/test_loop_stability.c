/* Stability of the loops: against limits known from theory, and sets that shook a simulated axis. */
#include "control/loop_stability.h"

#include "unity.h"

#define DT_S 0.001f
#define RAD_PER_TURN 6.2831853f

void setUp(void) {}
void tearDown(void) {}

/* The shipped azimuth. */
static loop_stability_input azimuth(void) {
  loop_stability_input in = {
      .speed = {.rate_estimator = {.window_ticks = 2},
                .rate_fusion = {.source = RATE_FUSED, .crossover_rad_s = 62.8f},
                .pi = {.proportional_gain = 765.0f, .integral_gain = 24385.0f, .setpoint_weight = 0.7f},
                .observer_on = true,
                .observer = {.inertia_kg_m2 = 6.0f, .bandwidth_rad_s = 220.0f}},
      .position_per_s = 10.0f,
      .tracker = {.kind = TRACKER_PREDICTIVE, .proportional_per_s = 20.0f},
      .plant = {.inertia_kg_m2 = 6.0f,
                .min_inertia_kg_m2 = 3.0f,
                .viscous_nm_s_rad = 8.0f,
                .stiffness_nm_rad = 30000.0f,
                .damping_nm_s_rad = 300.0f,
                .encoder_delay_s = 3.5e-4f,
                .gyro_delay_s = 8e-4f},
      .dt_s = DT_S,
  };
  in.speed.notch = biquad_pass();
  in.speed.lowpass = biquad_pass();
  return in;
}

static loop_stability judge(const loop_stability_input *in) {
  loop_stability state;
  loop_stability_start(&state);
  int slices = 0;
  while (loop_stability_step(&state, in, 12) == LOOP_RUNNING) {
    TEST_ASSERT_TRUE(++slices < 1000);
  }
  return state;
}

static void expect_refused(const loop_stability_input *in, loop_name loop) {
  const loop_stability state = judge(in);
  TEST_ASSERT_EQUAL(LOOP_REFUSED, state.verdict);
  TEST_ASSERT_EQUAL(loop, state.worst);
}

static void test_the_shipped_gains_are_stable(void) {
  loop_stability_input in = azimuth();
  const loop_stability state = judge(&in);
  TEST_ASSERT_EQUAL(LOOP_STABLE, state.verdict);
  TEST_ASSERT_TRUE(state.distance > LOOP_LEAST_DISTANCE_AT_LEAST_INERTIA);
  in.tracker.kind = TRACKER_PI;
  in.tracker.proportional_per_s = 5.0f;
  in.tracker.integral_per_s2 = 6.0f;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
}

static void test_every_source_of_the_rate_can_be_stable(void) {
  loop_stability_input in = azimuth();
  in.speed.rate_fusion.source = RATE_FROM_ENCODER;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
  in.speed.rate_fusion.source = RATE_FROM_GYRO;
  in.speed.observer.bandwidth_rad_s = 100.0f;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
}

static void test_gains_that_shook_the_axis_are_refused(void) {
  loop_stability_input in = azimuth();
  in.speed.pi.proportional_gain *= 10.0f;
  expect_refused(&in, LOOP_SPEED);
  in = azimuth();
  in.speed.pi.integral_gain = 1e8f;
  expect_refused(&in, LOOP_SPEED);
  for (float hz = 5.0f; hz < 30.0f; hz += 15.0f) {
    in = azimuth();
    TEST_ASSERT_EQUAL(CONTROL_OK, biquad_design_lowpass(&in.speed.lowpass, RAD_PER_TURN * hz, 0.7f, DT_S));
    expect_refused(&in, LOOP_SPEED);
  }
  in = azimuth();
  in.speed.observer.inertia_kg_m2 = 60.0f;
  expect_refused(&in, LOOP_SPEED);
  in = azimuth();
  in.speed.rate_estimator.window_ticks = 16;
  expect_refused(&in, LOOP_SPEED);
}

static void test_outer_loops_are_refused_by_their_name(void) {
  loop_stability_input in = azimuth();
  in.position_per_s = 1000.0f;
  expect_refused(&in, LOOP_POSITION);
  in = azimuth();
  in.tracker.kind = TRACKER_PI;
  in.tracker.proportional_per_s = 90.0f;
  expect_refused(&in, LOOP_TRACKING);
}

/* Kp alone on an inertia: sampled, with a delay of half a tick after the hold, the limit is known from the polynomial
 * z^3 - z^2 + k (z^2 / 8 + 6 z / 8 + 1 / 8) of k = Kp dt / J. */
static void test_the_limit_of_a_gain_is_that_of_its_polynomial(void) {
  loop_stability_input in = azimuth();
  in.speed.observer_on = false;
  in.speed.rate_fusion.source = RATE_FROM_ENCODER;
  in.speed.pi.integral_gain = 0.0f;
  in.speed.pi.setpoint_weight = 1.0f;
  in.tracker.proportional_per_s = 0.0f;
  in.position_per_s = 0.01f;
  in.plant.min_inertia_kg_m2 = 6.0f;
  in.plant.viscous_nm_s_rad = 0.0f;
  in.plant.stiffness_nm_rad = 0.0f;
  in.plant.damping_nm_s_rad = 0.0f;
  in.plant.encoder_delay_s = 0.5e-3f;
  /* On the unit circle at z = e^jw with cos w = x: 8 (z^2 - z^3) / (z^2 + 6 z + 1) = 8 (z - z^2) / (z + 6 + 1 / z). It
   * is real where Im (z - z^2) = 0: x = 0.5, so k = 8 / 7. */
  const float limit = 8.0f / 7.0f * 6.0f / DT_S;
  in.speed.pi.proportional_gain = 1.01f * limit;
  expect_refused(&in, LOOP_SPEED);
  in.speed.pi.proportional_gain = 0.6f * limit;
  const loop_stability state = judge(&in);
  TEST_ASSERT_EQUAL(LOOP_STABLE, state.verdict);
  TEST_ASSERT_TRUE(state.distance <= 0.4f && state.distance > 0.3f);
}

static void test_a_narrow_notch_is_not_overlooked(void) {
  loop_stability_input in = azimuth();
  in.plant.min_inertia_kg_m2 = 6.0f;
  TEST_ASSERT_EQUAL(CONTROL_OK,
                    biquad_design_notch(&in.speed.notch, RAD_PER_TURN * 20.0f, RAD_PER_TURN * 0.05f, 0.0f, DT_S));
  expect_refused(&in, LOOP_SPEED);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_shipped_gains_are_stable);
  RUN_TEST(test_every_source_of_the_rate_can_be_stable);
  RUN_TEST(test_gains_that_shook_the_axis_are_refused);
  RUN_TEST(test_outer_loops_are_refused_by_their_name);
  RUN_TEST(test_the_limit_of_a_gain_is_that_of_its_polynomial);
  RUN_TEST(test_a_narrow_notch_is_not_overlooked);
  return UNITY_END();
}
