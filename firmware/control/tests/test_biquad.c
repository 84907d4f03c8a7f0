/* SPDX-License-Identifier: Apache-2.0 */
/* Filter sections against the analytic bilinear transfer functions, in double. */
#include "control/biquad.h"

#include <complex.h>

#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

static const float dt_s = 1e-3f;
static const double pi = 3.14159265358979323846;
#define imaginary ((double complex)I) /* I itself is a float */

/* The analogue variable of the bilinear transform for a frequency, as a multiple of the prewarped one. */
static double complex warped(double frequency_rad_s, double centre_rad_s) {
  return imaginary * tan(0.5 * frequency_rad_s * (double)dt_s) / tan(0.5 * centre_rad_s * (double)dt_s);
}

static double complex lowpass_response(double frequency_rad_s, double centre_rad_s, double damping) {
  const double complex s = warped(frequency_rad_s, centre_rad_s);
  return 1.0 / (s * s + 2.0 * damping * s + 1.0);
}

static double complex notch_response(double frequency_rad_s, double centre_rad_s, double width_rad_s, double depth) {
  const double complex s = warped(frequency_rad_s, centre_rad_s);
  /* The damping that places the -3 dB points `width` apart after the transform. */
  const double spread = 2.0 * tan(0.5 * width_rad_s * (double)dt_s) / sin(centre_rad_s * (double)dt_s);
  return (s * s + depth * spread * s + 1.0) / (s * s + spread * s + 1.0);
}

/* The response of the coefficients rounded to float. */
static double complex response_of(const biquad_params *p, double frequency_rad_s) {
  const double complex delay = cexp(-imaginary * frequency_rad_s * (double)dt_s);
  return ((double)p->b0 + (double)p->b1 * delay + (double)p->b2 * delay * delay) /
         (1.0 + (double)p->a1 * delay + (double)p->a2 * delay * delay);
}

/* The response measured by running the filter on a cosine, after its transient. */
static double complex measured_response(const biquad_params *params, double frequency_rad_s) {
  biquad_state state;
  biquad_reset(&state, params, 0.0f);
  const int settle = 4000;
  const int count = 20000;
  double complex sum = 0.0;
  for (int tick = 0; tick < settle + count; ++tick) {
    const double phase = frequency_rad_s * (double)dt_s * tick;
    const double output = (double)biquad_step(&state, params, (float)cos(phase));
    if (tick >= settle) {
      sum += output * cexp(-imaginary * phase) * 2.0 / count;
    }
  }
  return sum;
}

static void expect_response(const biquad_params *params, double complex expected, double frequency_rad_s,
                            double tolerance) {
  CHECK_NEAR("gain and phase of the coefficients", 0.0, cabs(response_of(params, frequency_rad_s) - expected),
             tolerance);
  CHECK_NEAR("gain", cabs(expected), biquad_gain(params, (float)frequency_rad_s * dt_s), tolerance + 1e-3);
}

static void test_pass_leaves_the_signal_as_it_is(void) {
  const biquad_params params = biquad_pass();
  CHECK_STATUS(CONTROL_OK, biquad_check(&params));
  biquad_state state;
  biquad_reset(&state, &params, 7.0f);
  const float signal[] = {7.0f, -3.0f, 0.25f, 1e6f};
  for (int i = 0; i < 4; ++i) {
    CHECK_SAME("output", signal[i], biquad_step(&state, &params, signal[i]));
  }
}

static void test_lowpass_has_the_analytic_gain_and_phase(void) {
  const double centres_hz[] = {5.0, 30.0, 120.0, 400.0};
  const double dampings[] = {0.1, 0.707, 2.0};
  const double multiples[] = {0.1, 0.5, 0.9, 1.0, 1.1, 1.24};
  for (int c = 0; c < 4; ++c) {
    for (int d = 0; d < 3; ++d) {
      const double centre = 2.0 * pi * centres_hz[c];
      biquad_params params;
      CHECK_STATUS(CONTROL_OK, biquad_design_lowpass(&params, (float)centre, (float)dampings[d], dt_s));
      CHECK_STATUS(CONTROL_OK, biquad_check(&params));
      for (int m = 0; m < 6; ++m) {
        const double frequency = multiples[m] * centre;
        /* The error of a1 and a2 (2e-7) is magnified towards z = 1 and z = -1, and by the resonance. */
        const double tolerance = 2e-6 + 2e-7 / pow(sin(centre * (double)dt_s) * dampings[d], 2.0);
        expect_response(&params, lowpass_response(frequency, centre, dampings[d]), frequency, tolerance);
      }
    }
  }
}

static void test_running_filters_do_what_their_coefficients_say(void) {
  biquad_params lowpass;
  biquad_params notch;
  const double frequencies_hz[] = {2.0, 25.0, 50.0, 75.0, 300.0};
  CHECK_STATUS(CONTROL_OK, biquad_design_lowpass(&lowpass, (float)(2.0 * pi * 50.0), 0.707f, dt_s));
  CHECK_STATUS(CONTROL_OK, biquad_design_notch(&notch, (float)(2.0 * pi * 50.0), (float)(2.0 * pi * 20.0), 0.1f, dt_s));
  for (int i = 0; i < 5; ++i) {
    const double frequency = 2.0 * pi * frequencies_hz[i];
    CHECK_NEAR("low-pass in operation", 0.0,
               cabs(measured_response(&lowpass, frequency) - lowpass_response(frequency, 2.0 * pi * 50.0, 0.707)),
               1e-4);
    CHECK_NEAR(
        "notch in operation", 0.0,
        cabs(measured_response(&notch, frequency) - notch_response(frequency, 2.0 * pi * 50.0, 2.0 * pi * 20.0, 0.1)),
        1e-4);
  }
}

static void test_lowpass_has_unity_gain_at_zero_over_its_whole_range(void) {
  for (int i = 0; i <= 200; ++i) {
    const double share = 1.001e-3 * pow(0.489 / 1.001e-3, i / 200.0); /* of the sampling rate */
    biquad_params params;
    CHECK_STATUS(CONTROL_OK, biquad_design_lowpass(&params, (float)(2.0 * pi * share / 1e-3), 0.7f, dt_s));
    CHECK_NEAR("gain at 0", 1.0, creal(response_of(&params, 0.0)), 1e-6);
  }
}

static void test_lowpass_keeps_its_frequency_down_to_a_thousandth_of_the_sampling_rate(void) {
  const double centre = 2.0 * pi * 1.001;
  biquad_params params;
  CHECK_STATUS(CONTROL_OK, biquad_design_lowpass(&params, (float)centre, 0.707f, dt_s));
  expect_response(&params, lowpass_response(centre, centre, 0.707), centre, 5e-3);
}

static void test_notch_has_the_analytic_gain_and_phase(void) {
  const double centres_hz[] = {20.0, 80.0, 250.0};
  const double widths[] = {0.1, 0.5, 1.0}; /* of the centre */
  const double depths[] = {0.0, 0.3, 1.0};
  const double multiples[] = {0.2, 0.7, 0.95, 1.0, 1.05, 1.5};
  for (int c = 0; c < 3; ++c) {
    for (int w = 0; w < 3; ++w) {
      for (int d = 0; d < 3; ++d) {
        const double centre = 2.0 * pi * centres_hz[c];
        const double width = widths[w] * centre;
        biquad_params params;
        CHECK_STATUS(CONTROL_OK, biquad_design_notch(&params, (float)centre, (float)width, (float)depths[d], dt_s));
        CHECK_STATUS(CONTROL_OK, biquad_check(&params));
        for (int m = 0; m < 6; ++m) {
          const double frequency = multiples[m] * centre;
          const double tolerance = 5e-6 + 4e-7 / (centre * (double)dt_s * width * (double)dt_s);
          expect_response(&params, notch_response(frequency, centre, width, depths[d]), frequency, tolerance);
        }
      }
    }
  }
}

static void test_notch_is_as_deep_and_as_wide_as_requested(void) {
  const double centres_hz[] = {40.0, 150.0, 250.0};
  for (int c = 0; c < 3; ++c) {
    const double centre = 2.0 * pi * centres_hz[c];
    const double width = 0.4 * centre;
    biquad_params params;
    CHECK_STATUS(CONTROL_OK, biquad_design_notch(&params, (float)centre, (float)width, 0.05f, dt_s));
    CHECK_NEAR("gain at the centre", 0.05, cabs(response_of(&params, centre)), 1e-4);
    CHECK_STATUS(CONTROL_OK, biquad_design_notch(&params, (float)centre, (float)width, 0.0f, dt_s));
    CHECK_NEAR("gain at the centre", 0.0, cabs(response_of(&params, centre)), 1e-4);
    double lower = 0.0;
    double upper = 0.0;
    for (int i = 3000; i < 19000; ++i) {
      const double frequency = 1e-4 * i * centre;
      const bool cut = cabs(response_of(&params, frequency)) < sqrt(0.5);
      if (cut && lower <= 0.0) {
        lower = frequency;
      }
      if (cut) {
        upper = frequency;
      }
    }
    CHECK_RELATIVE("-3 dB width", width, upper - lower, 2e-3);
  }
}

static void test_notch_has_unity_gain_at_zero(void) {
  biquad_params params;
  CHECK_STATUS(CONTROL_OK, biquad_design_notch(&params, (float)(2.0 * pi * 5.0), (float)(2.0 * pi * 1.0), 0.1f, dt_s));
  CHECK_NEAR("gain at 0", 1.0, creal(response_of(&params, 0.0)), 5e-4);
}

static void test_reset_starts_settled_without_a_transient(void) {
  biquad_params lowpass;
  biquad_params notch;
  CHECK_STATUS(CONTROL_OK, biquad_design_lowpass(&lowpass, 2.0f * 3.14159265f * 20.0f, 0.7f, dt_s));
  CHECK_STATUS(CONTROL_OK, biquad_design_notch(&notch, 2.0f * 3.14159265f * 60.0f, 120.0f, 0.2f, dt_s));
  const biquad_params *filters[] = {&lowpass, &notch};
  for (int i = 0; i < 2; ++i) {
    biquad_state state;
    biquad_reset(&state, filters[i], 3.0f);
    for (int tick = 0; tick < 1000; ++tick) {
      CHECK_NEAR("output at a constant input", 3.0, biquad_step(&state, filters[i], 3.0f), 3e-4);
    }
  }
}

static void test_any_filter_that_can_be_designed_is_stable(void) {
  random_source source = {6};
  for (int trial = 0; trial < random_cases(20000); ++trial) {
    biquad_params params = biquad_pass();
    const float frequency_rad_s = (float)random_decades(&source, 6.3, 3078.0);
    if (trial % 2 == 0) {
      const float damping = (float)random_uniform(&source, 0.1, 2.0);
      CHECK_STATUS(CONTROL_OK, biquad_design_lowpass(&params, frequency_rad_s, damping, dt_s));
    } else {
      const double widest = fmin(1.99 * (double)frequency_rad_s, 2750.0);
      const float width_rad_s = (float)random_decades(&source, 0.0101 * (double)frequency_rad_s, widest);
      const float depth = (float)random_uniform(&source, 0.0, 1.0);
      CHECK_STATUS(CONTROL_OK, biquad_design_notch(&params, frequency_rad_s, width_rad_s, depth, dt_s));
    }
    CHECK_STATUS(CONTROL_OK, biquad_check(&params));
  }
}

static void test_a_lightly_damped_filter_rings_down_after_an_impulse(void) {
  biquad_params params;
  CHECK_STATUS(CONTROL_OK, biquad_design_lowpass(&params, 2.0f * 3.14159265f * 100.0f, 0.1f, dt_s));
  biquad_state state;
  biquad_reset(&state, &params, 0.0f);
  float output = biquad_step(&state, &params, 1.0f);
  for (int tick = 0; tick < 500; ++tick) {
    output = biquad_step(&state, &params, 0.0f);
  }
  CHECK_AT_MOST("rest of the ringing", 1e-6, fabsf(output));
}

static void test_design_refuses_what_is_out_of_range_and_touches_nothing(void) {
  const biquad_params before = {0.5f, 0.25f, 0.125f, -0.5f, 0.25f};
  const float f = 300.0f;
  const struct {
    float frequency_rad_s, damping, dt_s;
    control_status answer;
  } lowpass[] = {
      {0.09f, 0.7f, 1e-3f, CONTROL_OUT_OF_RANGE},  {3085.0f, 0.7f, 1e-3f, CONTROL_OUT_OF_RANGE},
      {f, 0.09f, 1e-3f, CONTROL_OUT_OF_RANGE},     {f, 2.1f, 1e-3f, CONTROL_OUT_OF_RANGE},
      {NAN, 0.7f, 1e-3f, CONTROL_NOT_FINITE},      {f, NAN, 1e-3f, CONTROL_NOT_FINITE},
      {INFINITY, 0.7f, 1e-3f, CONTROL_NOT_FINITE}, {f, 0.7f, NAN, CONTROL_NOT_FINITE},
  };
  for (unsigned i = 0; i < sizeof lowpass / sizeof lowpass[0]; ++i) {
    biquad_params params = before;
    CHECK_STATUS(lowpass[i].answer,
                 biquad_design_lowpass(&params, lowpass[i].frequency_rad_s, lowpass[i].damping, lowpass[i].dt_s));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
  }
  const struct {
    float frequency_rad_s, width_rad_s, depth;
    control_status answer;
  } notch[] = {
      {0.09f, 0.05f, 0.1f, CONTROL_OUT_OF_RANGE}, {3085.0f, f, 0.1f, CONTROL_OUT_OF_RANGE},
      {f, 0.2f, 0.1f, CONTROL_OUT_OF_RANGE},      {f, 601.0f, 0.1f, CONTROL_OUT_OF_RANGE},
      {f, 100.0f, -0.01f, CONTROL_OUT_OF_RANGE},  {f, 100.0f, 1.01f, CONTROL_OUT_OF_RANGE},
      {NAN, 100.0f, 0.1f, CONTROL_NOT_FINITE},    {f, NAN, 0.1f, CONTROL_NOT_FINITE},
      {f, 100.0f, INFINITY, CONTROL_NOT_FINITE},  {2500.0f, 2900.0f, 0.1f, CONTROL_OUT_OF_RANGE},
  };
  for (unsigned i = 0; i < sizeof notch / sizeof notch[0]; ++i) {
    biquad_params params = before;
    CHECK_STATUS(notch[i].answer,
                 biquad_design_notch(&params, notch[i].frequency_rad_s, notch[i].width_rad_s, notch[i].depth, dt_s));
    TEST_ASSERT_EQUAL_MEMORY(&before, &params, sizeof params);
  }
}

static void test_check_refuses_unstable_and_senseless_coefficients_one_by_one(void) {
  const biquad_params good = {0.5f, 0.25f, 0.125f, -0.5f, 0.25f};
  CHECK_STATUS(CONTROL_OK, biquad_check(&good));
  for (int i = 0; i < 5; ++i) {
    biquad_params bad = good;
    float *const values[] = {&bad.b0, &bad.b1, &bad.b2, &bad.a1, &bad.a2};
    *values[i] = NAN;
    CHECK_STATUS(CONTROL_NOT_FINITE, biquad_check(&bad));
    *values[i] = -1001.0f;
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, biquad_check(&bad));
    *values[i] = 1001.0f;
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, biquad_check(&bad));
    for (int side = -1; i < 3 && side <= 1; side += 2) { /* the poles decide about the others */
      *values[i] = (float)side * 999.0f;
      CHECK_STATUS(CONTROL_OK, biquad_check(&bad));
    }
  }
  const biquad_params on_the_circle = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f};
  const biquad_params at_minus_one = {1.0f, 0.0f, 0.0f, 0.0f, -1.0f};
  const biquad_params integrator = {1.0f, 0.0f, 0.0f, -1.0f, 0.0f};
  const biquad_params real_pole_outside = {1.0f, 0.0f, 0.0f, 1.6f, 0.5f};
  CHECK_STATUS(CONTROL_INCONSISTENT, biquad_check(&on_the_circle));
  CHECK_STATUS(CONTROL_INCONSISTENT, biquad_check(&at_minus_one));
  CHECK_STATUS(CONTROL_INCONSISTENT, biquad_check(&integrator));
  CHECK_STATUS(CONTROL_INCONSISTENT, biquad_check(&real_pole_outside));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_pass_leaves_the_signal_as_it_is);
  RUN_TEST(test_lowpass_has_the_analytic_gain_and_phase);
  RUN_TEST(test_running_filters_do_what_their_coefficients_say);
  RUN_TEST(test_lowpass_has_unity_gain_at_zero_over_its_whole_range);
  RUN_TEST(test_lowpass_keeps_its_frequency_down_to_a_thousandth_of_the_sampling_rate);
  RUN_TEST(test_notch_has_the_analytic_gain_and_phase);
  RUN_TEST(test_notch_is_as_deep_and_as_wide_as_requested);
  RUN_TEST(test_notch_has_unity_gain_at_zero);
  RUN_TEST(test_reset_starts_settled_without_a_transient);
  RUN_TEST(test_any_filter_that_can_be_designed_is_stable);
  RUN_TEST(test_a_lightly_damped_filter_rings_down_after_an_impulse);
  RUN_TEST(test_design_refuses_what_is_out_of_range_and_touches_nothing);
  RUN_TEST(test_check_refuses_unstable_and_senseless_coefficients_one_by_one);
  return UNITY_END();
}
