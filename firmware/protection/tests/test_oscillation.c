/* The oscillation monitor on an axis of one inertia: which motions are oscillations, and which are not. */
#include <math.h>

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
    const oscillation_inputs in = {.closed = closed, .rate_rad_s = rate_rad_s, .loop_nm = motor_nm};
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

static void test_an_open_loop_does_not_oscillate(void) {
  const sine s = {.hz = 15.0f, .motor_nm = 35.0f};
  TEST_ASSERT_EQUAL(-1, seen_after(kPlant, s, false, 1000));
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

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_an_oscillation_that_the_motor_sustains_is_seen_within_half_a_second);
  RUN_TEST(test_new_gains_need_less_evidence);
  RUN_TEST(test_what_a_gust_of_any_frequency_does_is_no_oscillation);
  RUN_TEST(test_an_open_loop_does_not_oscillate);
  RUN_TEST(test_a_decaying_oscillation_is_left_to_decay);
  RUN_TEST(test_a_set_point_explains_the_torque_that_follows_it);
  RUN_TEST(test_fast_torque_swings_are_reported_before_they_count);
  return UNITY_END();
}
