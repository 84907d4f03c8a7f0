/* SPDX-License-Identifier: Apache-2.0 */
/* The base's rates: what an axis must add to what its sensors see, and rates between two messages. */
#include "servo/base_rates.h"

#include <math.h>

#include "base/scalar.h"
#include "support/check.h"
#include "support/random.h"

#define TICK_S 1e-3
#define COUNT_RAD_S 2e-5

static base_rates rates;
static base_rates_params params;

void setUp(void) {
  base_rates_reset(&rates);
  params = (base_rates_params){
      .use = 1, .scale_rad_s = (float)COUNT_RAD_S, .largest_rad_s = 0.5f, .bandwidth_rad_s = 100.0f, .timeout_ms = 100};
}

void tearDown(void) {}

/* --- geometry ----------------------------------------------------------------------------------------------------- */

typedef struct {
  double x;
  double y;
  double z;
} vector;

static vector cross(vector a, vector b) {
  return (vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static double size_of(vector v) { return sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

static rotation turned(double rad) { return (rotation){.sine = (float)sin(rad), .cosine = (float)cos(rad)}; }

/* How fast the line of sight turns when the joints turn by these rates on a base with those. */
static double sight_rad_s(vector base, double psi, double theta, double azimuth_rad_s, double pitch_rad_s) {
  const vector sight = {cos(theta) * cos(psi), cos(theta) * sin(psi), sin(theta)};
  const vector pitch_axis = {sin(psi), -cos(psi), 0.0}; /* raises the line of sight */
  const vector rate = {base.x + pitch_rad_s * pitch_axis.x, base.y + pitch_rad_s * pitch_axis.y,
                       base.z + azimuth_rad_s};
  return size_of(cross(rate, sight));
}

/* An axis whose rate is controlled to 0 turns its joint against all that its sensors see and all that is added. */
static void check_that_the_sight_stands(rate_source source, gyro_mounting azimuth_gyro, gyro_mounting pitch_gyro,
                                        unsigned seed) {
  random_source random = {seed};
  for (int i = 0; i < 1000; ++i) {
    const vector base = {random_uniform(&random, -0.3, 0.3), random_uniform(&random, -0.3, 0.3),
                         random_uniform(&random, -0.3, 0.3)};
    const double psi = random_uniform(&random, -4.0, 4.0);
    const double theta = random_uniform(&random, -1.4, 1.4);
    servo_axis_params azimuth = {.gyro = azimuth_gyro};
    servo_axis_params pitch = {.gyro = pitch_gyro};
    azimuth.speed.rate_fusion.source = source;
    pitch.speed.rate_fusion.source = source;
    const base_vector given = {(float)base.x, (float)base.y, (float)base.z};
    const bool blind = source == RATE_FROM_ENCODER;
    const double ahead = cos(psi) * base.x + sin(psi) * base.y;
    const double left = cos(psi) * base.y - sin(psi) * base.x;
    double azimuth_seen = blind ? 0.0 : base.z;
    if (!blind && azimuth_gyro == GYRO_ON_LINE_OF_SIGHT) {
      azimuth_seen = base.z - tan(theta) * ahead;
    }
    const double pitch_seen = blind ? 0.0 : -left;
    const double azimuth_rad_s =
        -azimuth_seen - (double)base_rates_of_azimuth(&azimuth, given, turned(psi), turned(theta));
    const double pitch_rad_s = -pitch_seen - (double)base_rates_of_pitch(&pitch, given, turned(psi));
    CHECK_AT_MOST("sight, rad/s", 2e-6, sight_rad_s(base, psi, theta, azimuth_rad_s, pitch_rad_s));
  }
}

static void test_with_every_place_of_the_gyros_the_sight_stands(void) {
  check_that_the_sight_stands(RATE_FROM_ENCODER, GYRO_ON_AXIS, GYRO_ON_AXIS, 1);
  check_that_the_sight_stands(RATE_FROM_ENCODER, GYRO_ON_LINE_OF_SIGHT, GYRO_ON_AXIS, 2);
  check_that_the_sight_stands(RATE_FUSED, GYRO_ON_AXIS, GYRO_ON_AXIS, 3);
  check_that_the_sight_stands(RATE_FROM_GYRO, GYRO_ON_AXIS, GYRO_BELOW_JOINT, 4);
  check_that_the_sight_stands(RATE_FROM_GYRO, GYRO_BELOW_JOINT, GYRO_BELOW_JOINT, 5);
  check_that_the_sight_stands(RATE_FROM_GYRO, GYRO_ON_LINE_OF_SIGHT, GYRO_ON_AXIS, 6);
}

static void test_towards_the_zenith_nothing_grows_beyond_ten_times_the_base(void) {
  const servo_axis_params azimuth = {.gyro = GYRO_ON_AXIS, .speed.rate_fusion.source = RATE_FROM_GYRO};
  const base_vector rolls = {.x = 0.1f};
  for (int i = -1000; i <= 1000; ++i) {
    const double theta = 1.5707963 + 2e-4 * (double)i;
    const float added = base_rates_of_azimuth(&azimuth, rolls, turned(0.0), turned(theta));
    CHECK_AT_MOST("rad/s", 1.0, fabs((double)added));
  }
  const rotation zenith = {.sine = 1.0f, .cosine = 0.0f};
  CHECK_SAME("rad/s", 0.0, base_rates_of_azimuth(&azimuth, rolls, turned(0.0), zenith));
}

/* --- messages ----------------------------------------------------------------------------------------------------- */

static base_rates_drop give(double x_rad_s, double y_rad_s, double z_rad_s, uint32_t tick) {
  const base_rates_message message = {.x = (int16_t)lround(x_rad_s / COUNT_RAD_S),
                                      .y = (int16_t)lround(y_rad_s / COUNT_RAD_S),
                                      .z = (int16_t)lround(z_rad_s / COUNT_RAD_S),
                                      .counter = (uint8_t)(rates.counter + 1)};
  return base_rates_take(&rates, &params, &message, tick);
}

/* Largest error of x from 1 s to 4 s, of a base that rolls with 0.1 rad/s at this frequency. */
static double error_on_a_sine(double frequency_hz, unsigned every_ms, unsigned delay_ms) {
  const double w = 2.0 * (double)SCALAR_PI * frequency_hz;
  double worst_rad_s = 0.0;
  setUp();
  params.delay = (uint16_t)(100 * delay_ms);
  for (uint32_t tick = delay_ms; tick < 4000; ++tick) {
    if (tick % every_ms == 0) {
      TEST_ASSERT_EQUAL(BASE_RATES_TAKEN, give(0.1 * sin(w * TICK_S * (tick - delay_ms)), 0.0, 0.0, tick));
    }
    if (tick >= 1000) {
      const double error_rad_s = (double)base_rates_at(&rates, &params, tick).x - 0.1 * sin(w * TICK_S * tick);
      worst_rad_s = fmax(worst_rad_s, fabs(error_rad_s));
    }
  }
  return worst_rad_s;
}

static void test_a_sine_comes_out_with_the_square_of_its_share_of_the_bandwidth(void) {
  const double share = 2.0 * (double)SCALAR_PI * 0.5 / 100.0;
  CHECK_NEAR("0.5 Hz, each ms", 0.1 * share * share, error_on_a_sine(0.5, 1, 0), 3e-5);
  CHECK_AT_MOST("0.5 Hz, every 10 ms, of 0.1 rad/s", 5e-4, error_on_a_sine(0.5, 10, 0));
  CHECK_AT_MOST("0.5 Hz, every 10 ms, 5 ms old", 7e-4, error_on_a_sine(0.5, 10, 5));
}

static void test_a_constant_acceleration_of_the_base_is_followed_between_messages(void) {
  const double slope_rad_s2 = 0.2;
  params.delay = 500; /* 5 ms */
  for (uint32_t tick = 5; tick < 1500; ++tick) {
    const double now_s = TICK_S * tick;
    if (tick % 20 == 0) {
      const double then_rad_s = slope_rad_s2 * (now_s - 0.005);
      (void)give(then_rad_s, -then_rad_s, 0.1 + 0.5 * then_rad_s, tick);
    }
    if (tick > 500) {
      const base_vector at = base_rates_at(&rates, &params, tick);
      CHECK_NEAR("x, rad/s", slope_rad_s2 * now_s, at.x, 2.0 * COUNT_RAD_S);
      CHECK_NEAR("y, rad/s", -slope_rad_s2 * now_s, at.y, 2.0 * COUNT_RAD_S);
      CHECK_NEAR("z, rad/s", 0.1 + 0.5 * slope_rad_s2 * now_s, at.z, 2.0 * COUNT_RAD_S);
    }
  }
}

static void test_the_straight_line_ends_50_ms_after_the_measurement(void) {
  for (uint32_t tick = 0; tick <= 1000; tick += 10) {
    (void)give(0.2 * TICK_S * tick, 0.0, 0.0, tick);
  }
  CHECK_NEAR("rad/s", 0.2 * 1.04, base_rates_at(&rates, &params, 1040).x, 2.0 * COUNT_RAD_S);
  CHECK_NEAR("rad/s", 0.2 * 1.05, base_rates_at(&rates, &params, 1090).x, 2.0 * COUNT_RAD_S);
}

static void test_after_the_time_out_a_message_begins_anew(void) {
  for (uint32_t tick = 0; tick <= 1000; tick += 10) {
    (void)give(0.2 * TICK_S * tick, 0.0, 0.0, tick);
  }
  TEST_ASSERT_TRUE(base_rates_are_fresh(&rates, &params, 1100));
  TEST_ASSERT_FALSE(base_rates_are_fresh(&rates, &params, 1101));
  TEST_ASSERT_EQUAL(BASE_RATES_TAKEN, give(-0.1, 0.0, 0.0, 1500));
  CHECK_NEAR("rad/s", -0.1, base_rates_at(&rates, &params, 1530).x, 1e-6);
}

static void test_before_the_first_message_no_rates_are_fresh(void) {
  TEST_ASSERT_FALSE(base_rates_are_fresh(&rates, &params, 0));
  TEST_ASSERT_EQUAL(BASE_RATES_IMPOSSIBLE, give(0.51, 0.0, 0.0, 0));
  TEST_ASSERT_FALSE(base_rates_are_fresh(&rates, &params, 0));
  TEST_ASSERT_EQUAL(BASE_RATES_TAKEN, give(0.49, 0.0, 0.0, 0));
  TEST_ASSERT_TRUE(base_rates_are_fresh(&rates, &params, 0));
}

static void test_what_cannot_be_a_rate_does_not_count(void) {
  (void)give(0.1, 0.1, 0.1, 10);
  TEST_ASSERT_EQUAL(BASE_RATES_IMPOSSIBLE, give(0.51, 0.0, 0.0, 20));
  TEST_ASSERT_EQUAL(BASE_RATES_IMPOSSIBLE, give(0.0, -0.51, 0.0, 30));
  TEST_ASSERT_EQUAL(BASE_RATES_IMPOSSIBLE, give(0.0, 0.0, 0.51, 40));
  params.largest_rad_s = 10.0f;
  base_rates_message message = {.x = BASE_RATE_NOT_MEASURED, .counter = 100};
  TEST_ASSERT_EQUAL(BASE_RATES_NOT_MEASURED, base_rates_take(&rates, &params, &message, 50));
  message = (base_rates_message){.y = BASE_RATE_NOT_MEASURED, .counter = 101};
  TEST_ASSERT_EQUAL(BASE_RATES_NOT_MEASURED, base_rates_take(&rates, &params, &message, 60));
  message = (base_rates_message){.z = BASE_RATE_NOT_MEASURED, .counter = 102};
  TEST_ASSERT_EQUAL(BASE_RATES_NOT_MEASURED, base_rates_take(&rates, &params, &message, 70));
  CHECK_NEAR("rad/s", 0.1, base_rates_at(&rates, &params, 70).x, 1e-6);
}

static void test_a_sender_that_repeats_itself_is_not_believed(void) {
  const base_rates_message message = {.x = 1000, .counter = 0};
  TEST_ASSERT_EQUAL(BASE_RATES_TAKEN, base_rates_take(&rates, &params, &message, 10));
  TEST_ASSERT_EQUAL(BASE_RATES_REPEATED, base_rates_take(&rates, &params, &message, 20));
  TEST_ASSERT_TRUE(base_rates_are_fresh(&rates, &params, 110));
  TEST_ASSERT_FALSE(base_rates_are_fresh(&rates, &params, 111));
  base_rates_reset(&rates);
  TEST_ASSERT_EQUAL(BASE_RATES_TAKEN, base_rates_take(&rates, &params, &message, 130));
}

/* The sender ends with a jump from one limit to the other: its slope goes on for 50 ms. */
static void test_what_a_jump_leaves_stays_within_the_limit(void) {
  for (uint32_t tick = 0; tick <= 1000; tick += 10) {
    (void)give(-0.5, 0.5, 0.5, tick);
  }
  (void)give(0.5, -0.5, -0.5, 1010);
  for (uint32_t tick = 1010; tick < 1200; ++tick) {
    const base_vector at = base_rates_at(&rates, &params, tick);
    CHECK_AT_MOST("rad/s", 0.5, fmax(fabs((double)at.x), fmax(fabs((double)at.y), fabs((double)at.z))));
  }
  CHECK_NEAR("rad/s", 0.5, base_rates_at(&rates, &params, 1060).x, 1e-6);
}

static void test_messages_that_have_ended_stay_so_when_the_ticks_begin_anew(void) {
  (void)give(0.1, 0.0, 0.0, 10);
  base_rates_age(&rates, &params, 110);
  TEST_ASSERT_TRUE(base_rates_are_fresh(&rates, &params, 110));
  base_rates_age(&rates, &params, 111);
  TEST_ASSERT_FALSE(base_rates_are_fresh(&rates, &params, 10)); /* 2^32 ticks later */
  (void)give(0.1, 0.0, 0.0, 20);
  TEST_ASSERT_TRUE(base_rates_are_fresh(&rates, &params, 20));
}

static void test_two_messages_before_one_tick_are_the_newer_one(void) {
  (void)give(0.1, 0.0, 0.0, 10);
  (void)give(0.2, 0.0, 0.0, 10);
  CHECK_NEAR("rad/s", 0.2, base_rates_at(&rates, &params, 20).x, 1e-6);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_with_every_place_of_the_gyros_the_sight_stands);
  RUN_TEST(test_towards_the_zenith_nothing_grows_beyond_ten_times_the_base);
  RUN_TEST(test_a_sine_comes_out_with_the_square_of_its_share_of_the_bandwidth);
  RUN_TEST(test_a_constant_acceleration_of_the_base_is_followed_between_messages);
  RUN_TEST(test_the_straight_line_ends_50_ms_after_the_measurement);
  RUN_TEST(test_after_the_time_out_a_message_begins_anew);
  RUN_TEST(test_before_the_first_message_no_rates_are_fresh);
  RUN_TEST(test_what_cannot_be_a_rate_does_not_count);
  RUN_TEST(test_a_sender_that_repeats_itself_is_not_believed);
  RUN_TEST(test_two_messages_before_one_tick_are_the_newer_one);
  RUN_TEST(test_what_a_jump_leaves_stays_within_the_limit);
  RUN_TEST(test_messages_that_have_ended_stay_so_when_the_ticks_begin_anew);
  return UNITY_END();
}
