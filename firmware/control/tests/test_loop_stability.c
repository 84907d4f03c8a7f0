/* SPDX-License-Identifier: Apache-2.0 */
/* Stability of the loops: against limits known from theory, and sets that shook a simulated axis. */
#include "control/loop_stability.h"

#include <complex.h>
#include <math.h>

#include "support/check.h"
#include "support/random.h"

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

static void expect_refused(const loop_stability_input *in) {
  const loop_stability state = judge(in);
  TEST_ASSERT_EQUAL(LOOP_REFUSED, state.verdict);
}

static void test_the_shipped_gains_are_stable(void) {
  loop_stability_input in = azimuth();
  const loop_stability state = judge(&in);
  TEST_ASSERT_EQUAL(LOOP_STABLE, state.verdict);
  TEST_ASSERT_TRUE(state.distance > LOOP_LEAST_DISTANCE_OF_FIXED_GAINS);
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
  expect_refused(&in);
  in = azimuth();
  in.speed.pi.integral_gain = 1e8f;
  expect_refused(&in);
  for (float hz = 5.0f; hz < 30.0f; hz += 15.0f) {
    in = azimuth();
    TEST_ASSERT_EQUAL(CONTROL_OK, biquad_design_lowpass(&in.speed.lowpass, RAD_PER_TURN * hz, 0.7f, DT_S));
    expect_refused(&in);
  }
  in = azimuth();
  in.speed.observer.inertia_kg_m2 = 60.0f;
  expect_refused(&in);
  in = azimuth();
  in.speed.rate_estimator.window_ticks = 16;
  expect_refused(&in);
}

static void test_outer_loops_are_refused_by_their_name(void) {
  loop_stability_input in = azimuth();
  in.position_per_s = 1000.0f;
  expect_refused(&in);
  in = azimuth();
  in.tracker.kind = TRACKER_PI;
  in.tracker.proportional_per_s = 90.0f;
  expect_refused(&in);
}

/* Without the way from the set-point to the torque no outer loop controls anything: the innermost of them is named. */
static void test_of_several_bad_loops_the_innermost_is_named(void) {
  loop_stability_input in = azimuth();
  in.speed.pi.integral_gain = 0.0f;
  in.speed.pi.setpoint_weight = 0.0f;
  expect_refused(&in);
}

/* An integral alone around the integral of the rate is never stable; without its gains the tracker does nothing. */
static void test_a_tracker_is_judged_by_the_gains_of_its_kind(void) {
  loop_stability_input in = azimuth();
  in.tracker = (target_tracker_params){.kind = TRACKER_PI, .integral_per_s2 = 4.0f};
  expect_refused(&in);
  in.tracker.kind = TRACKER_PREDICTIVE;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
  in.tracker = (target_tracker_params){.kind = TRACKER_PI};
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
}

/* However small it is: an integral alone holds the rate with ki / (J s + b), and a position loop faster than b / J =
 * 1.33/s around it is never stable. */
static void test_the_least_integral_gain_is_one(void) {
  loop_stability_input in = azimuth();
  in.speed.observer_on = false;
  in.speed.pi.proportional_gain = 0.0f;
  in.speed.pi.integral_gain = 0.05f;
  in.plant.min_inertia_kg_m2 = 6.0f;
  in.plant.stiffness_nm_rad = 0.0f;
  in.tracker.proportional_per_s = 0.0f;
  in.position_per_s = 0.002f;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
  in.position_per_s = 10.0f;
  expect_refused(&in);
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
  expect_refused(&in);
  in.speed.pi.proportional_gain = 0.6f * limit;
  const loop_stability state = judge(&in);
  TEST_ASSERT_EQUAL(LOOP_STABLE, state.verdict);
  TEST_ASSERT_TRUE(state.distance <= 0.4f && state.distance > 0.3f);
}

/* Two roots at 0.01 rad/s: the curve turns before the lowest frequency that is looked at otherwise. */
static void test_a_tracker_that_is_very_slow_is_stable(void) {
  loop_stability_input in = azimuth();
  in.tracker = (target_tracker_params){.kind = TRACKER_PI, .proportional_per_s = 0.02f, .integral_per_s2 = 1e-4f};
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
  in.position_per_s = 0.01f;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
}

static void test_a_speed_loop_that_is_very_slow_is_stable(void) {
  loop_stability_input in = azimuth();
  in.speed.observer_on = false;
  in.speed.pi.proportional_gain = 0.1f;
  in.speed.pi.integral_gain = 6e-4f;
  in.plant.viscous_nm_s_rad = 0.02f;
  in.plant.stiffness_nm_rad = 0.0f;
  in.plant.min_inertia_kg_m2 = 6.0f;
  in.position_per_s = 1e-4f;
  in.tracker.proportional_per_s = 0.0f;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
}

static void test_a_narrow_notch_is_not_overlooked(void) {
  loop_stability_input in = azimuth();
  in.plant.min_inertia_kg_m2 = 6.0f;
  TEST_ASSERT_EQUAL(CONTROL_OK,
                    biquad_design_notch(&in.speed.notch, RAD_PER_TURN * 20.0f, RAD_PER_TURN * 0.05f, 0.0f, DT_S));
  expect_refused(&in);
}

/* --- the distance to -1, computed from the blocks themselves ------------------------------------------------------ */

typedef double complex wave;

static wave exactly(const biquad_params *p, wave q) {
  return ((double)p->b0 + (double)p->b1 * q + (double)p->b2 * q * q) /
         (1.0 + (double)p->a1 * q + (double)p->a2 * q * q);
}

/* The least-squares slope of the last N angles, each the sum of the mean rates before it. */
static wave fitted(int n, wave q) {
  wave sum = 0.0;
  for (int age = 0; age < n; ++age) {
    sum += 12.0 * (0.5 * (n - 1) - age) / (n * (n * n - 1.0)) * cpow(q, age);
  }
  return sum / (1.0 - q);
}

/* Rates that a torque of one tick leaves on an inertia of 1, tick by tick: `delay` ticks late, sampled at the end of a
 * tick or averaged over it. */
static wave pushed(double delay, bool mean, wave q) {
  const int whole = (int)delay;
  const double part = delay - whole;
  const double before = mean ? 0.5 * (1.0 - part) * (1.0 - part) : 1.0 - part;
  const double after = mean ? 1.0 - 0.5 * part * part : 1.0;
  return cpow(q, whole + 1) * (before + (after - before) * q + (1.0 - after) * q * q);
}

typedef struct {
  wave speed, position, tracking;
} open_loops;

static open_loops opened(const loop_stability_input *in, double inertia, bool sliding, double omega) {
  const speed_loop_params *p = &in->speed;
  const loop_plant *plant = &in->plant;
  const double dt = (double)in->dt_s;
  const wave q = cos(omega) - (wave)I * sin(omega);
  const wave s = 2.0 / dt * (1.0 - q) / (1.0 + q);
  const double k = sliding ? 0.0 : (double)plant->stiffness_nm_rad / inertia;
  const double share = in->gains_follow ? inertia / (double)plant->inertia_kg_m2 : 1.0;
  const double c = ((double)plant->viscous_nm_s_rad + (sliding ? 0.0 : (double)plant->damping_nm_s_rad)) / inertia;
  const wave seal = s * s / (s * s + fmax(c, 1e-3) * s + k);
  const wave machine = dt / inertia / (1.0 - q) * seal;
  const wave angle_rate = machine * pushed((double)plant->encoder_delay_s / dt, true, q);
  const wave encoder = angle_rate * fitted(p->rate_estimator.window_ticks, q);
  const wave gyro = machine * pushed((double)plant->gyro_delay_s / dt, false, q);
  const double step = (double)p->rate_fusion.crossover_rad_s * dt;
  const wave low = step / (1.0 + step) / (1.0 - q / (1.0 + step));
  const wave fused = p->rate_fusion.source == RATE_FROM_ENCODER ? encoder
                     : p->rate_fusion.source == RATE_FROM_GYRO  ? gyro
                                                                : low * gyro + (1.0 - low) * encoder;
  const wave integral = share * (double)p->pi.integral_gain * dt * q / (1.0 - q);
  wave feedback = share * (double)p->pi.proportional_gain + integral;
  wave reference = share * (double)(p->pi.setpoint_weight * p->pi.proportional_gain) + integral;
  if (p->observer_on) {
    const double blend = 1.0 - exp(-(double)p->observer.bandwidth_rad_s * dt);
    const wave lag = blend / (1.0 - (1.0 - blend) * q);
    const wave explained =
        share * (double)p->observer.inertia_kg_m2 * (1.0 - q) / dt + (double)p->observer.viscous_nm_s_rad * q;
    feedback = (feedback + lag * explained) / (1.0 - lag * q);
    reference = reference / (1.0 - lag * q);
  }
  const wave sum = dt / (1.0 - q); /* of rates */
  open_loops l;
  l.speed = feedback * fused * exactly(&p->notch, q) * exactly(&p->lowpass, q);
  l.position = l.speed + (double)in->position_per_s * sum * angle_rate * reference;
  const target_tracker_params *t = &in->tracker;
  l.tracking = t->kind == TRACKER_PREDICTIVE
                   ? l.speed + (double)t->proportional_per_s * sum * fused * reference
                   : l.speed + ((double)t->proportional_per_s + (double)t->integral_per_s2 * sum) * cpow(q, 36) * sum *
                                   angle_rate * reference;
  return l;
}

static double nearest(const loop_stability_input *in) {
  double least = 1.0;
  for (int point = 0; point < LOOP_OPERATING_POINTS; ++point) {
    const double inertia = (double)(point < 2 ? in->plant.inertia_kg_m2 : in->plant.min_inertia_kg_m2);
    const bool sliding = point % 2 == 0 || in->plant.stiffness_nm_rad == 0.0f;
    for (double omega = 1e-4; omega < 3.1415; omega *= 1.004) {
      const open_loops l = opened(in, inertia, sliding, omega);
      least = fmin(least, fmin(cabs(1.0 + l.speed), fmin(cabs(1.0 + l.position), cabs(1.0 + l.tracking))));
    }
  }
  return least;
}

/* `tolerance`: the block looks at frequencies 6 % apart, and may pass over the nearest one. */
static void expect_distance_within(const char *what, const loop_stability_input *in, double tolerance) {
  const loop_stability state = judge(in);
  TEST_ASSERT_EQUAL_MESSAGE(LOOP_STABLE, state.verdict, what);
  CHECK_NEAR(what, nearest(in), state.distance, tolerance);
}

static void expect_distance(const char *what, const loop_stability_input *in) {
  expect_distance_within(what, in, 1.5e-3);
}

/* How often the loops were evaluated between two frequencies, in one operating point. */
static int looks_between(const loop_stability_input *in, int point, double from, double to) {
  loop_stability state;
  loop_stability_start(&state);
  int looks = 0;
  float last = 0.0f;
  while (loop_stability_step(&state, in, 1) == LOOP_RUNNING && state.point <= point) {
    looks += state.point == point && state.omega != last && (double)state.omega >= from && (double)state.omega <= to;
    last = state.omega;
  }
  TEST_ASSERT_TRUE_MESSAGE(state.verdict != LOOP_REFUSED || state.point > point, "refused");
  return looks;
}

/* Steps of a quarter of its width in the band, on both sides of its centre. Far from it they are longer. */
static void expect_a_close_look(const char *what, const loop_stability_input *in, int point, double centre,
                                double width) {
  const int before = looks_between(in, point, centre - 0.75 * width, centre);
  const int behind = looks_between(in, point, centre, centre + 0.75 * width);
  TEST_ASSERT_TRUE_MESSAGE(before >= 2 && before <= 12, what);
  TEST_ASSERT_TRUE_MESSAGE(behind >= 3 && behind <= 12, what);
}

/* The gain at which the tracking loop begins to oscillate, around the closed speed loop and the delay of the camera:
 * where its open loop, for a gain of 1, is real and negative. */
static double tracking_limit(const loop_stability_input *in) {
  double limit = 1e9;
  for (int point = 0; point < LOOP_OPERATING_POINTS; ++point) {
    const double inertia = (double)(point < 2 ? in->plant.inertia_kg_m2 : in->plant.min_inertia_kg_m2);
    wave before = 0.0;
    for (double omega = 1e-3; omega < 3.0; omega *= 1.002) {
      const open_loops l = opened(in, inertia, point % 2 == 0, omega);
      const wave outer = (l.tracking - l.speed) / (1.0 + l.speed);
      if (creal(outer) < 0.0 && cimag(before) * cimag(outer) < 0.0) {
        limit = fmin(limit, 1.0 / cabs(outer));
      }
      before = outer;
    }
  }
  return limit;
}

static void test_the_tracking_loop_is_stable_up_to_the_gain_of_its_delay(void) {
  if (random_cases(1) == 0) {
    return; /* an emulated core computes double in software */
  }
  loop_stability_input in = azimuth();
  in.tracker = (target_tracker_params){.kind = TRACKER_PI, .proportional_per_s = 1.0f};
  const double limit = tracking_limit(&in);
  LOG_VALUE("limit, 1/s", limit);
  in.tracker.proportional_per_s = (float)(0.97 * limit);
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
  in.tracker.proportional_per_s = (float)(1.02 * limit);
  expect_refused(&in);
}

static double turn_between(loop_complex from, loop_complex to) {
  return fabs(atan2((double)from.re * (double)to.im - (double)from.im * (double)to.re,
                    (double)from.re * (double)to.re + (double)from.im * (double)to.im));
}

/* Sets of any gains and delays, most of them refused: up to the verdict no curve turns further in a step, and no step
 * is more than twice as long as the one before. */
static void test_no_step_turns_a_curve_by_more_than_its_limit(void) {
  random_source source = {5};
  double largest = 0.0;
  int stable = 0;
  for (int set = 0; set < random_cases(200); ++set) {
    loop_stability_input in = azimuth();
    in.speed.pi.proportional_gain *= (float)random_decades(&source, 0.1, 2.0);
    in.speed.pi.integral_gain *= (float)random_decades(&source, 0.01, 2.0);
    in.speed.observer.bandwidth_rad_s = (float)random_decades(&source, 5.0, 250.0);
    in.position_per_s = (float)random_decades(&source, 0.01, 60.0);
    in.plant.stiffness_nm_rad = (float)random_decades(&source, 1e3, 1e6);
    in.plant.damping_nm_s_rad = (float)random_decades(&source, 1.0, 1e3);
    in.plant.encoder_delay_s = (float)random_uniform(&source, 1e-4, 2e-3);
    in.tracker.kind = set % 2 == 0 ? TRACKER_PI : TRACKER_PREDICTIVE;
    in.tracker.proportional_per_s = (float)random_decades(&source, 0.01, 60.0);
    in.tracker.integral_per_s2 = (float)random_decades(&source, 0.01, 60.0);
    loop_stability state;
    loop_stability_start(&state);
    (void)loop_stability_step(&state, &in, 1);
    while (state.verdict == LOOP_RUNNING) {
      const loop_stability before = state;
      (void)loop_stability_step(&state, &in, 1);
      TEST_ASSERT_TRUE_MESSAGE(state.omega == 0.0f || state.step <= 2.0f * before.step, "a step grew too much");
      for (int i = 0;
           state.verdict == LOOP_RUNNING && before.evaluations > 0 && state.omega > before.omega && i < LOOP_COUNT;
           ++i) {
        largest = fmax(largest, turn_between(before.last[i], state.last[i]));
      }
    }
    stable += state.verdict == LOOP_STABLE ? 1 : 0;
  }
  LOG_VALUE("stable sets", stable);
  LOG_VALUE("largest turn, rad", largest);
  CHECK_AT_MOST("largest turn, rad", (double)LOOP_PHASE_STEP + 1e-6, largest);
}

static void test_narrow_bands_are_looked_at_closely(void) {
  loop_stability_input in = azimuth();
  in.plant.stiffness_nm_rad = 27000.0f;
  in.plant.damping_nm_s_rad = 0.5f;
  in.plant.viscous_nm_s_rad = 0.1f;
  expect_a_close_look("spring", &in, 1, sqrt(27000.0 / 6.0) * 1e-3, 0.6 / 6.0 * 1e-3);
  expect_a_close_look("spring of the smallest inertia", &in, 3, sqrt(27000.0 / 3.0) * 1e-3, 0.6 / 3.0 * 1e-3);
  TEST_ASSERT_EQUAL(0, looks_between(&in, 0, sqrt(27000.0 / 6.0) * 1e-3, sqrt(27000.0 / 6.0) * 1e-3 + 1e-4));
  in = azimuth();
  in.speed.pi.proportional_gain = 400.0f;
  in.speed.observer.bandwidth_rad_s = 60.0f;
  TEST_ASSERT_EQUAL(CONTROL_OK,
                    biquad_design_notch(&in.speed.notch, RAD_PER_TURN * 100.0f, RAD_PER_TURN * 1.0f, 0.5f, DT_S));
  expect_a_close_look("notch", &in, 0, 0.62831853, 0.0062831853);
  in.speed.notch = biquad_pass();
  TEST_ASSERT_EQUAL(CONTROL_OK, biquad_design_lowpass(&in.speed.lowpass, RAD_PER_TURN * 200.0f, 0.1f, DT_S));
  CHECK_NEAR("resonance of the low-pass", 7.0, looks_between(&in, 0, 1.2566 - 0.19, 1.2566), 2.0);
}

/* They are the time of the answer: the deferred task looks at 12 frequencies in a tick. */
static void test_the_shipped_gains_have_their_answer_after_about_1030_frequencies(void) {
  loop_stability_input in = azimuth();
  loop_stability state;
  loop_stability_start(&state);
  int looks = 1;
  int begins = 0; /* at frequency 0, of each operating point */
  while (loop_stability_step(&state, &in, 1) == LOOP_RUNNING) {
    ++looks;
    begins += state.evaluations == 1 && state.omega == 0.0f ? 1 : 0;
  }
  CHECK_NEAR("frequencies", 1030.0, looks, 15.0);
  TEST_ASSERT_EQUAL(LOOP_OPERATING_POINTS, begins);
}

static void test_the_distance_to_instability_is_that_of_the_blocks(void) {
  loop_stability_input in = azimuth();
  expect_distance("shipped", &in);
  if (random_cases(1) == 0) {
    return; /* an emulated core computes double in software */
  }
  in.speed.observer.viscous_nm_s_rad = 40.0f;
  in.plant.encoder_delay_s = 1.3e-3f;
  in.speed.pi.proportional_gain = 300.0f;
  in.speed.observer.bandwidth_rad_s = 60.0f;
  expect_distance("viscous observer, late encoder", &in);
  in = azimuth();
  in.speed.rate_fusion.source = RATE_FROM_ENCODER;
  expect_distance("encoder", &in);
  in.speed.rate_estimator.window_ticks = 4;
  in.speed.pi.proportional_gain = 300.0f;
  in.speed.observer.bandwidth_rad_s = 60.0f;
  expect_distance("encoder, four angles", &in);
  in = azimuth();
  in.speed.rate_fusion.source = RATE_FROM_GYRO;
  in.speed.observer.bandwidth_rad_s = 100.0f;
  expect_distance("gyro", &in);
  in.plant.gyro_delay_s = 2.6e-3f;
  in.speed.pi.proportional_gain = 400.0f;
  in.speed.observer.bandwidth_rad_s = 50.0f;
  expect_distance("late gyro", &in);
  in = azimuth();
  in.tracker = (target_tracker_params){.kind = TRACKER_PI, .proportional_per_s = 9.0f, .integral_per_s2 = 12.0f};
  expect_distance("tracking with PI", &in);
  in.tracker.integral_per_s2 = 0.0f;
  expect_distance("tracking with P", &in);
  in = azimuth();
  in.speed.pi.integral_gain = 0.0f;
  expect_distance("no integral", &in);
  in.speed.observer_on = false;
  in.position_per_s = 40.0f;
  expect_distance("neither integral nor observer", &in);
  in.plant.stiffness_nm_rad = 0.0f;
  expect_distance("no bristles", &in);
  in = azimuth();
  in.position_per_s = 60.0f;
  expect_distance("fast position loop", &in);
  in.tracker.proportional_per_s = 60.0f;
  in.position_per_s = 1.0f;
  expect_distance("fast predictive tracking", &in);
  in = azimuth();
  in.plant.damping_nm_s_rad = 1.0f;
  in.plant.viscous_nm_s_rad = 0.05f;
  expect_distance("a seal that hardly damps", &in);
  in = azimuth();
  in.speed.pi.proportional_gain = 400.0f;
  in.speed.pi.integral_gain = 4000.0f;
  in.speed.observer.bandwidth_rad_s = 60.0f;
  in.tracker = (target_tracker_params){.kind = TRACKER_PI, .proportional_per_s = 12.0f, .integral_per_s2 = 40.0f};
  expect_distance_within("tracking with PI, the slowest loop", &in, 6e-3);
  in.tracker.integral_per_s2 = 0.0f;
  expect_distance_within("tracking with P, the slowest loop", &in, 6e-3);
  TEST_ASSERT_EQUAL(CONTROL_OK, biquad_design_lowpass(&in.speed.lowpass, RAD_PER_TURN * 150.0f, 0.7f, DT_S));
  TEST_ASSERT_EQUAL(CONTROL_OK,
                    biquad_design_notch(&in.speed.notch, RAD_PER_TURN * 90.0f, RAD_PER_TURN * 10.0f, 0.1f, DT_S));
  expect_distance("filters", &in);
}

/* The smallest |1 + L| up to the frequency at which it is refused, of all three loops there. */
static void expect_distance_of_refused(const char *what, const loop_stability_input *in) {
  loop_stability state;
  loop_stability_start(&state);
  double least = 1.0;
  float last = 0.0f;
  do {
    (void)loop_stability_step(&state, in, 1);
    if (state.omega > 1e-3f && state.omega != last) {
      const double inertia = (double)(state.point < 2 ? in->plant.inertia_kg_m2 : in->plant.min_inertia_kg_m2);
      const open_loops l = opened(in, inertia, state.point % 2 == 0, (double)state.omega);
      least = fmin(least, fmin(cabs(1.0 + l.speed), fmin(cabs(1.0 + l.position), cabs(1.0 + l.tracking))));
      last = state.omega;
    }
  } while (state.verdict == LOOP_RUNNING);
  TEST_ASSERT_EQUAL_MESSAGE(LOOP_REFUSED, state.verdict, what);
  CHECK_NEAR(what, least, state.distance, 2e-4);
}

static void test_a_set_that_is_refused_has_the_distance_of_its_nearest_loop(void) {
  if (random_cases(1) == 0) {
    return; /* an emulated core computes double in software */
  }
  static const struct {
    const char *nearest;
    float times, position_per_s, tracking_per_s;
  } rows[] = {{"speed", 3.7f, 15.0f, 45.0f}, {"position", 2.2f, 256.0f, 20.0f}, {"tracking", 2.86f, 50.0f, 67.0f}};
  for (unsigned i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    loop_stability_input in = azimuth();
    in.speed.pi.proportional_gain *= rows[i].times;
    in.position_per_s = rows[i].position_per_s;
    in.tracker.proportional_per_s = rows[i].tracking_per_s;
    expect_distance_of_refused(rows[i].nearest, &in);
  }
}

/* 35 degrees of phase margin with half the inertia: too little is left for a seal that is four times as stiff. */
static void test_gains_that_follow_the_inertia_keep_their_distance(void) {
  loop_stability_input in = azimuth();
  expect_distance("gains that stay", &in);
  const float fixed = judge(&in).distance;
  in.gains_follow = true;
  expect_distance("gains that follow", &in);
  const float following = judge(&in).distance;
  in.plant.min_inertia_kg_m2 = in.plant.inertia_kg_m2;
  const float largest = judge(&in).distance;
  LOG_VALUE("fixed", fixed);
  LOG_VALUE("following", following);
  LOG_VALUE("at the largest inertia", largest);
  CHECK_AT_MOST("fixed", 0.75 * (double)largest, fixed);
  CHECK_AT_LEAST("following", 0.97 * (double)largest, following);
}

/* A tenth of the inertia: fixed gains are ten times too large for it. */
static void test_gains_that_follow_are_not_refused_for_the_gains_of_another_inertia(void) {
  loop_stability_input in = azimuth();
  in.plant.min_inertia_kg_m2 = 0.6f;
  expect_refused(&in);
  in.gains_follow = true;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
}

/* Near the zenith the encoder replaces a gyro on the line of sight; its slope over 16 angles is too late. */
static void test_where_the_gyro_vanishes_the_encoder_alone_must_be_stable(void) {
  loop_stability_input in = azimuth();
  in.gains_follow = true;
  in.speed.rate_fusion.source = RATE_FROM_GYRO;
  in.speed.observer.bandwidth_rad_s = 100.0f;
  in.speed.rate_estimator.window_ticks = 16;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
  in.gyro_vanishes = true;
  expect_refused(&in);
  in.speed.rate_estimator.window_ticks = 2;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
}

/* Likewise at every pitch, when the gyro does not see the joint. */
static void test_with_the_gyro_below_the_joint_the_encoder_alone_must_be_stable(void) {
  for (rate_source source = RATE_FROM_GYRO; source <= RATE_FUSED; ++source) {
    loop_stability_input in = azimuth();
    in.speed.rate_fusion.source = source;
    in.speed.rate_fusion.crossover_rad_s = 2000.0f;
    in.speed.observer.bandwidth_rad_s = 100.0f;
    in.speed.rate_estimator.window_ticks = 16;
    TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
    in.gyro_below = true;
    expect_refused(&in);
    in.speed.rate_estimator.window_ticks = 2;
    TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
  }
}

static void test_loops_without_any_gain_hold_nothing_and_are_refused(void) {
  loop_stability_input in = azimuth();
  in.speed.observer_on = false;
  in.speed.pi.proportional_gain = 0.0f;
  in.speed.pi.integral_gain = 0.0f;
  loop_stability state;
  loop_stability_start(&state);
  TEST_ASSERT_EQUAL(LOOP_REFUSED, loop_stability_step(&state, &in, 1)); /* at frequency 0 */
  TEST_ASSERT_EQUAL(1, state.evaluations);                              /* the work of a slice is bounded */
}

/* The bristles of a stiff seal that hardly damps, around a P controller with a delay: only the smallest inertia is
 * unstable, and no curve comes near -1. What is left is the number of turns. */
static void test_the_last_operating_point_is_judged_by_its_turns(void) {
  loop_stability_input in = azimuth();
  in.speed.observer_on = false;
  in.speed.pi.proportional_gain = 155.0f;
  in.speed.pi.integral_gain = 0.0f;
  in.position_per_s = 5.0f;
  in.tracker.proportional_per_s = 0.3f;
  in.plant.min_inertia_kg_m2 = 0.65f;
  in.plant.stiffness_nm_rad = 1.45e6f;
  in.plant.damping_nm_s_rad = 30.0f;
  in.plant.viscous_nm_s_rad = 0.2f;
  in.plant.encoder_delay_s = 9e-4f;
  const loop_stability state = judge(&in);
  TEST_ASSERT_EQUAL(LOOP_REFUSED, state.verdict);
  TEST_ASSERT_EQUAL(LOOP_OPERATING_POINTS - 1, state.point);
  CHECK_AT_LEAST("distance", 0.5, state.distance);
  CHECK_AT_MOST("frequencies: its last one ends it", 662, state.evaluations);
  in.plant.damping_nm_s_rad = 300.0f;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
}

static void test_a_verdict_is_final(void) {
  loop_stability_input in = azimuth();
  for (int i = 0; i < 2; ++i) {
    const loop_stability said = judge(&in);
    TEST_ASSERT_EQUAL(i == 0 ? LOOP_STABLE : LOOP_REFUSED, said.verdict);
    if (i == 0) {
      CHECK_NEAR("last frequency, rad per tick", 3.14159265, said.omega, 1e-6);
    }
    loop_stability later = said;
    TEST_ASSERT_EQUAL(said.verdict, loop_stability_step(&later, &in, 4000));
    TEST_ASSERT_EQUAL(said.evaluations, later.evaluations);
    CHECK_SAME("frequency", said.omega, later.omega);
    in.speed.pi.proportional_gain *= 10.0f;
  }
}

/* A gyro without delay around an inertia, 1 + L = (1 + (k - 1) q) / (1 - q) of k = Kp dt / J: nearest at half the
 * tick's rate, 1 - k / 2 away. */
static void test_the_last_frequency_counts(void) {
  loop_stability_input in = azimuth();
  in.speed.observer_on = false;
  in.speed.rate_fusion.source = RATE_FROM_GYRO;
  in.speed.pi.integral_gain = 0.0f;
  in.position_per_s = 0.01f;
  in.tracker.proportional_per_s = 0.0f;
  in.plant = (loop_plant){.inertia_kg_m2 = 6.0f, .min_inertia_kg_m2 = 6.0f};
  const float limit = 2.0f * (1.0f - LOOP_LEAST_DISTANCE) * 6.0f / DT_S;
  in.speed.pi.proportional_gain = 0.99999f * limit;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge(&in).verdict);
  in.speed.pi.proportional_gain = 1.00001f * limit;
  const loop_stability state = judge(&in);
  TEST_ASSERT_EQUAL(LOOP_REFUSED, state.verdict);
  TEST_ASSERT_EQUAL(0, state.point);
  CHECK_NEAR("frequency, rad per tick", 3.14159265, state.omega, 1e-6);
}

/* The smallest damping that the block assumes keeps the bands of seal and steps finite. */
static void test_a_machine_without_any_damping_has_an_answer(void) {
  loop_stability_input in = azimuth();
  in.plant.viscous_nm_s_rad = 0.0f;
  in.plant.damping_nm_s_rad = 0.0f;
  expect_distance("no damping", &in);
}

/* At frequency 0 each curve begins on the positive axis, and its turns count from there. None is nearer to -1 than
 * without feedback yet. */
static void test_every_curve_begins_on_the_positive_axis(void) {
  const loop_stability_input in = azimuth();
  loop_stability state;
  loop_stability_start(&state);
  TEST_ASSERT_EQUAL(LOOP_RUNNING, loop_stability_step(&state, &in, 1));
  for (int i = 0; i < LOOP_COUNT; ++i) {
    CHECK_AT_LEAST("real part", 1e-12, state.last[i].re);
    CHECK_SAME("imaginary part", 0.0, state.last[i].im);
    CHECK_SAME("turned, rad", 0.0, state.phase[i]);
  }
  CHECK_SAME("distance", 1.0, state.distance);
}

/* What the position loop adds to the speed loop, at each frequency: (1 - q) (1 + L of position) / (1 + L of speed). */
static void expect_the_ratio_of_the_loops(const char *what, const loop_stability_input *in) {
  loop_stability state;
  loop_stability_start(&state);
  double largest = 0.0;
  while (loop_stability_step(&state, in, 1) == LOOP_RUNNING) {
    if (state.omega < 2e-3f) {
      continue;
    }
    const double inertia = (double)(state.point < 2 ? in->plant.inertia_kg_m2 : in->plant.min_inertia_kg_m2);
    const bool sliding = state.point % 2 == 0 || in->plant.stiffness_nm_rad == 0.0f;
    const open_loops l = opened(in, inertia, sliding, (double)state.omega);
    const wave rest = 1.0 - cos((double)state.omega) + (wave)I * sin((double)state.omega);
    const wave expected = rest * (1.0 + l.position) / (1.0 + l.speed);
    const wave speed = (double)state.last[LOOP_SPEED].re + (wave)I * (double)state.last[LOOP_SPEED].im;
    const wave position = (double)state.last[LOOP_POSITION].re + (wave)I * (double)state.last[LOOP_POSITION].im;
    largest = fmax(largest, cabs(position / speed - expected) / cabs(expected));
  }
  LOG_VALUE(what, largest);
  CHECK_AT_MOST(what, 5e-5, largest);
}

static void test_the_ratio_of_the_loops_is_that_of_the_blocks(void) {
  if (random_cases(1) == 0) {
    return; /* an emulated core computes double in software */
  }
  loop_stability_input in = azimuth();
  expect_the_ratio_of_the_loops("shipped: largest relative difference", &in);
  in.plant.viscous_nm_s_rad = 0.05f;
  in.speed.pi.proportional_gain = 200.0f;
  in.speed.pi.integral_gain = 800.0f;
  in.speed.observer_on = false;
  in.position_per_s = 4.0f;
  expect_the_ratio_of_the_loops("slow, hardly damped: largest relative difference", &in);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_shipped_gains_are_stable);
  RUN_TEST(test_every_source_of_the_rate_can_be_stable);
  RUN_TEST(test_gains_that_shook_the_axis_are_refused);
  RUN_TEST(test_outer_loops_are_refused_by_their_name);
  RUN_TEST(test_of_several_bad_loops_the_innermost_is_named);
  RUN_TEST(test_a_tracker_is_judged_by_the_gains_of_its_kind);
  RUN_TEST(test_the_least_integral_gain_is_one);
  RUN_TEST(test_the_limit_of_a_gain_is_that_of_its_polynomial);
  RUN_TEST(test_a_tracker_that_is_very_slow_is_stable);
  RUN_TEST(test_a_speed_loop_that_is_very_slow_is_stable);
  RUN_TEST(test_a_narrow_notch_is_not_overlooked);
  RUN_TEST(test_the_tracking_loop_is_stable_up_to_the_gain_of_its_delay);
  RUN_TEST(test_no_step_turns_a_curve_by_more_than_its_limit);
  RUN_TEST(test_narrow_bands_are_looked_at_closely);
  RUN_TEST(test_the_shipped_gains_have_their_answer_after_about_1030_frequencies);
  RUN_TEST(test_the_distance_to_instability_is_that_of_the_blocks);
  RUN_TEST(test_a_set_that_is_refused_has_the_distance_of_its_nearest_loop);
  RUN_TEST(test_gains_that_follow_the_inertia_keep_their_distance);
  RUN_TEST(test_gains_that_follow_are_not_refused_for_the_gains_of_another_inertia);
  RUN_TEST(test_where_the_gyro_vanishes_the_encoder_alone_must_be_stable);
  RUN_TEST(test_with_the_gyro_below_the_joint_the_encoder_alone_must_be_stable);
  RUN_TEST(test_loops_without_any_gain_hold_nothing_and_are_refused);
  RUN_TEST(test_the_last_operating_point_is_judged_by_its_turns);
  RUN_TEST(test_a_verdict_is_final);
  RUN_TEST(test_the_last_frequency_counts);
  RUN_TEST(test_a_machine_without_any_damping_has_an_answer);
  RUN_TEST(test_every_curve_begins_on_the_positive_axis);
  RUN_TEST(test_the_ratio_of_the_loops_is_that_of_the_blocks);
  return UNITY_END();
}
