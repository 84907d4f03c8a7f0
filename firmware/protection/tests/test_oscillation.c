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
  RUN_TEST(test_new_gains_need_less_evidence);
  RUN_TEST(test_what_a_gust_of_any_frequency_does_is_no_oscillation);
  RUN_TEST(test_an_open_loop_does_not_oscillate);
  RUN_TEST(test_a_decaying_oscillation_is_left_to_decay);
  RUN_TEST(test_a_set_point_explains_the_torque_that_follows_it);
  RUN_TEST(test_fast_torque_swings_are_reported_before_they_count);
  RUN_TEST(test_new_gains_that_are_unstable_are_seen_before_the_axis_is_fast_with_and_without_a_load);
  RUN_TEST(test_healthy_gains_may_overshoot_after_a_step);
  return UNITY_END();
}
