/* SPDX-License-Identifier: Apache-2.0 */
/* Tracking loop with a 50 Hz camera, a frame old, and an ideal line of sight: the rate commanded in a tick is the rate
 * of the next tick. */
#include "control/target_tracker.h"

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

enum { frame_ticks = 20, delay_ticks = 20 };
static const float dt_s = 1e-3f;

static target_tracker_params example(tracker_kind kind) {
  return (target_tracker_params){.kind = kind,
                                 .proportional_per_s = kind == TRACKER_PI ? 8.0f : 20.0f,
                                 .integral_per_s2 = kind == TRACKER_PI ? 4.0f : 0.0f,
                                 .estimator_rad_s = 15.0f,
                                 .rate_limit_rad_s = 1.0f,
                                 .coast_s = 0.5f};
}

typedef struct {
  target_tracker_params params;
  target_tracker_state state;
  int tick;
  double errors_rad[128]; /* what the camera would have seen, a ring */
  double los_rad;
  float los_rate_rad_s;
  speed_reference out;
  bool camera_on;
} bench;

static bench bench_with(tracker_kind kind) {
  bench b = {.params = example(kind), .camera_on = true};
  target_tracker_reset(&b.state);
  return b;
}

/* One tick towards a target that is at `target_rad` now. Returns the true error. */
static double track(bench *b, double target_rad) {
  b->los_rad += (double)b->los_rate_rad_s * 1e-3;
  const double error_rad = target_rad - b->los_rad;
  b->errors_rad[b->tick % 128] = error_rad;
  camera_frame frame = {.fresh = b->camera_on && b->tick >= delay_ticks && b->tick % frame_ticks == 0,
                        .valid = true,
                        .age_ticks = delay_ticks};
  if (frame.fresh) {
    frame.error_rad = (float)b->errors_rad[(b->tick - delay_ticks) % 128];
  }
  b->out = target_tracker_step(&b->state, &b->params, &frame, b->los_rate_rad_s, dt_s);
  b->los_rate_rad_s = b->out.rate_rad_s;
  ++b->tick;
  return error_rad;
}

static void test_the_pi_loop_is_a_sampled_pi_with_a_frame_of_delay(void) {
  /* By frames of T = 20 ms: the error of frame n - 1 arrives with frame n, and its rate is in effect for the next T. */
  bench b = bench_with(TRACKER_PI);
  const double target_rad = 1e-3;
  double los_rad = 0.0;
  double integral_rad_s = 0.0;
  double delayed_error_rad = 0.0;
  for (int tick = 0; tick < 4000; ++tick) {
    (void)track(&b, target_rad);
    if (tick % frame_ticks == 0) {
      CHECK_NEAR("line of sight", los_rad, b.los_rad, 1e-9);
      integral_rad_s += tick > frame_ticks ? 4.0 * delayed_error_rad * 0.02 : 0.0; /* the first frame acquires */
      const double rate_rad_s = 8.0 * delayed_error_rad + integral_rad_s;
      CHECK_NEAR("rate", rate_rad_s, b.out.rate_rad_s, 1e-8);
      CHECK_SAME("acceleration", 0.0, b.out.acceleration_rad_s2);
      delayed_error_rad = target_rad - los_rad;
      los_rad += rate_rad_s * 0.02;
    }
  }
}

static double closed_loop_gain(tracker_kind kind, double frequency_hz) {
  bench b = bench_with(kind);
  double cosine = 0.0;
  double sine = 0.0;
  const int settle = 10000;
  const int count = 10000;
  for (int tick = 0; tick < settle + count; ++tick) {
    const double phase = 6.283185307179586 * frequency_hz * 1e-3 * tick;
    (void)track(&b, 1e-3 * sin(phase));
    if (tick >= settle) {
      cosine += b.los_rad * cos(phase) * 2.0 / count;
      sine += b.los_rad * sin(phase) * 2.0 / count;
    }
  }
  return sqrt(cosine * cosine + sine * sine) / 1e-3;
}

static void test_the_pi_loop_has_a_bandwidth_of_about_2_hz(void) {
  double bandwidth_hz = 0.1;
  while (bandwidth_hz < 10.0 && closed_loop_gain(TRACKER_PI, bandwidth_hz) > sqrt(0.5)) {
    bandwidth_hz += 0.1;
  }
  LOG_VALUE("bandwidth of the PI tracking loop, Hz", bandwidth_hz);
  CHECK_NEAR("bandwidth", 2.0, bandwidth_hz, 0.5);
}

static void test_the_pi_loop_steps_to_the_target_with_little_overshoot(void) {
  bench b = bench_with(TRACKER_PI);
  double highest_rad = 0.0;
  int rise_ticks = 0;
  for (int tick = 0; tick < 6000; ++tick) {
    (void)track(&b, 1e-3);
    highest_rad = fmax(highest_rad, b.los_rad);
    rise_ticks += b.los_rad < 0.632e-3 ? 1 : 0;
  }
  LOG_VALUE("time to 63 %, ms", rise_ticks);
  CHECK_AT_LEAST("time to 63 % in ms: the first frame alone costs 20", 80.0, rise_ticks);
  CHECK_AT_MOST("time to 63 % in ms: 1/kp, two frames, a hold", 180.0, rise_ticks);
  CHECK_AT_MOST("highest", 1.2e-3, highest_rad);
  CHECK_NEAR("at last", 1e-3, b.los_rad, 5e-6); /* the integral leaves a tail of kp/ki = 2 s */
}

static void test_a_target_of_constant_rate_or_acceleration_is_followed_without_error(void) {
  const double accelerations_rad_s2[] = {0.0, 0.01, -0.01};
  for (int i = 0; i < 3; ++i) {
    bench b = bench_with(TRACKER_PREDICTIVE);
    double sum_rad = 0.0;
    double largest_rad = 0.0;
    for (int tick = 0; tick < 6000; ++tick) {
      const double t = 1e-3 * tick;
      const double error_rad = track(&b, 1e-3 + 5e-3 * t + 0.5 * accelerations_rad_s2[i] * t * t);
      if (tick >= 5000) {
        sum_rad += error_rad / 1000.0;
        largest_rad = fmax(largest_rad, fabs(error_rad));
      }
    }
    LOG_VALUE("mean error, nrad", 1e9 * sum_rad);
    /* The rate is held for a tick: a dt / (2 kp) = 250 nrad; the rest is rounding. */
    CHECK_NEAR("mean error", accelerations_rad_s2[i] * 1e-3 / (2.0 * 20.0), sum_rad, 1e-7);
    CHECK_AT_MOST("largest error", 5e-7, largest_rad);
    CHECK_NEAR("acceleration fed forward", accelerations_rad_s2[i], b.out.acceleration_rad_s2, 1e-4);
  }
}

/* The axis already follows by hand: the camera takes over at its rate. What the target has moved during the age of the
 * first frame is unknown: 2 mrad, which the predictive loop takes for an error of 0.04 rad/s. */
static void test_a_target_that_is_found_in_motion_is_followed_from_its_rate_on(void) {
  for (int kind = 0; kind < 2; ++kind) {
    bench b = bench_with(kind == 0 ? TRACKER_PI : TRACKER_PREDICTIVE);
    b.camera_on = false;
    b.los_rate_rad_s = 0.1f;
    for (int tick = 0; tick < 600; ++tick) {
      (void)track(&b, 1e-4 * (tick + 1));
      if (!b.state.locked) {
        b.los_rate_rad_s = 0.1f;
      } else {
        CHECK_NEAR("rate, rad/s", 0.1, b.out.rate_rad_s, kind == 0 ? 1e-3 : tick < 250 ? 0.041 : 0.02);
      }
      b.camera_on = tick >= 100;
    }
    TEST_ASSERT_TRUE(b.state.locked);
  }
}

static void test_the_delay_is_compensated_exactly_while_the_line_of_sight_moves(void) {
  /* The target is at rest; something other than the tracker moves the line of sight. Uncompensated, a frame of 20
   * mrad/s is 0.4 mrad off. */
  const int ages_ticks[] = {0, 1, 20, 127};
  for (int i = 0; i < 4; ++i) {
    target_tracker_params params = example(TRACKER_PREDICTIVE);
    target_tracker_state state;
    target_tracker_reset(&state);
    double seen_rad[1024];
    double los_rad = 0.0;
    for (int tick = 0; tick < 1024; ++tick) {
      const double rate_rad_s = tick < 160 ? 0.0 : 0.02 * sin(0.013 * (tick - 160));
      los_rad += (double)(float)rate_rad_s * 1e-3;
      seen_rad[tick] = 2e-3 - los_rad;
      camera_frame frame = {.fresh = tick >= 140 && tick % frame_ticks == 0, .valid = true, .age_ticks = ages_ticks[i]};
      frame.error_rad = frame.fresh ? (float)seen_rad[tick - ages_ticks[i]] : 0.0f;
      (void)target_tracker_step(&state, &params, &frame, (float)rate_rad_s, dt_s);
      if (tick >= 140) {
        CHECK_NEAR("error now", seen_rad[tick], state.error_rad, 2e-8);
      }
    }
  }
}

/* A frame that is 100 ms old says that a target which was taken to be at rest is 1 mrad ahead. The error, the rate and
 * the acceleration that it leaves are those of one motion: followed back to the exposure, it is alpha of that mrad. */
static void test_a_correction_is_carried_from_the_exposure_to_now(void) {
  const target_tracker_params params = example(TRACKER_PREDICTIVE);
  target_tracker_state state;
  target_tracker_reset(&state);
  camera_frame frame = {.fresh = true, .valid = true, .age_ticks = 100};
  (void)target_tracker_step(&state, &params, &frame, 0.0f, dt_s);
  frame.fresh = false;
  for (int tick = 1; tick < frame_ticks; ++tick) {
    (void)target_tracker_step(&state, &params, &frame, 0.0f, dt_s);
  }
  const target_tracker_gains gains = target_tracker_prepare_gains(&state, &params, dt_s);
  frame.fresh = true;
  frame.error_rad = 1e-3f;
  (void)target_tracker_step(&state, &params, &frame, 0.0f, dt_s);
  const double age_s = 0.1;
  const double acceleration_rad_s2 = (double)state.target_acceleration_rad_s2;
  const double rate_then_rad_s = (double)state.target_rate_rad_s - acceleration_rad_s2 * age_s;
  const double moved_rad = rate_then_rad_s * age_s + 0.5 * acceleration_rad_s2 * age_s * age_s;
  CHECK_AT_LEAST("moved by the acceleration alone, rad", 1e-5, 0.5 * acceleration_rad_s2 * age_s * age_s);
  CHECK_NEAR("error at the exposure, rad", 1e-3 * (double)gains.alpha, (double)state.error_rad - moved_rad, 1e-8);
}

/* The line of sight turns at 20 mrad/s, the target at 50 mrad/s and faster: what a frame says of the error now is its
 * own error, without what the line of sight has turned since the exposure, and with what a target of the given rate
 * has. The estimate, of which the frame has changed all three parts, has no part in it. */
static void test_what_a_frame_says_alone_is_its_error_and_the_motion_since(void) {
  const target_tracker_params params = example(TRACKER_PREDICTIVE);
  target_tracker_state state;
  target_tracker_reset(&state);
  for (int tick = 0; tick < 200; ++tick) {
    target_tracker_remember(&state, 0.02f);
  }
  state.ticks_since_frame = frame_ticks;
  target_tracker_assume(&state, 1e-3f, 0.05f, 0.3f);
  camera_frame frame = {.fresh = true, .valid = true, .age_ticks = 100, .error_rad = 5e-3f};
  for (int since = 0; since < 30; ++since) {
    (void)target_tracker_step(&state, &params, &frame, 0.02f, dt_s);
    frame.fresh = false;
    TEST_ASSERT_EQUAL(since, state.ticks_since_frame);
    const double since_s = 1e-3 * (100 + since);
    for (int i = -1; i <= 1; ++i) {
      CHECK_NEAR("error, rad", 5e-3 + (0.04 * i - 0.02) * since_s,
                 target_tracker_seen_rad(&state, 100, 0.04f * (float)i, dt_s), 2e-8);
    }
  }
}

/* A frame that is 100 ms old says that a target at rest is 1 mrad ahead, and is taken back in its tick. After 5 s
 * without one a frame counts in full, and what the estimate was before it is not known. */
static void test_a_frame_that_is_taken_back_leaves_the_estimate_before_it(void) {
  const target_tracker_params params = example(TRACKER_PREDICTIVE);
  target_tracker_state state;
  target_tracker_reset(&state);
  const camera_frame none = {.fresh = false};
  const camera_frame frame = {.fresh = true, .valid = true, .age_ticks = 100, .error_rad = 3e-3f};
  for (int tick = 0; tick < 200; ++tick) {
    target_tracker_remember(&state, 0.0f);
  }
  static const int gaps_ticks[] = {1, frame_ticks, 5000};
  for (int i = 0; i < 3; ++i) {
    target_tracker_assume(&state, 2e-3f, 0.0f, 0.0f);
    state.ticks_since_frame = gaps_ticks[i] - 1;
    target_tracker_state without = state;
    const target_tracker_gains gains = target_tracker_prepare_gains(&state, &params, dt_s);
    target_tracker_params patient = params;
    patient.coast_s = 10.0f;
    (void)target_tracker_step(&state, &patient, &frame, 0.0f, dt_s);
    (void)target_tracker_step(&without, &patient, &none, 0.0f, dt_s);
    TEST_ASSERT_EQUAL(0, state.ticks_since_frame);
    CHECK_NEAR("beyond the estimate, rad", i < 2 ? 1e-3 : 0.0, target_tracker_residual_rad(&state, &gains), 2e-8);
    target_tracker_take_back(&state, &gains, 100, dt_s);
    TEST_ASSERT_EQUAL(gaps_ticks[i], state.ticks_since_frame);
    CHECK_SAME("untaken, rad", 0.0, state.untaken_rad);
    if (i < 2) {
      CHECK_NEAR("error, rad", without.error_rad, state.error_rad, 1e-8);
      CHECK_NEAR("rate, rad/s", without.target_rate_rad_s, state.target_rate_rad_s, 1e-7);
      CHECK_NEAR("acceleration, rad/s^2", without.target_acceleration_rad_s2, state.target_acceleration_rad_s2, 1e-6);
    }
  }
}

static void test_without_frames_it_coasts_on_the_targets_rate_and_then_stops(void) {
  bench b = bench_with(TRACKER_PREDICTIVE);
  for (int tick = 0; tick < 3001; ++tick) { /* the last frame comes with tick 3000 */
    (void)track(&b, 5e-6 * tick);
  }
  b.camera_on = false;
  for (int tick = 3001; tick <= 3500; ++tick) {
    (void)track(&b, 5e-6 * tick);
    CHECK_NEAR("rate while coasting", 5e-3, b.out.rate_rad_s, 2e-5);
  }
  TEST_ASSERT_TRUE(b.state.locked);
  (void)track(&b, 5e-6 * 3501);
  TEST_ASSERT_FALSE(b.state.locked);
  CHECK_SAME("rate after the loss", 0.0, b.out.rate_rad_s);
  CHECK_SAME("acceleration after the loss", 0.0, b.out.acceleration_rad_s2);
  b.camera_on = true;
  for (int tick = 3502; tick < 8000; ++tick) {
    (void)track(&b, 5e-6 * tick);
  }
  CHECK_NEAR("error after it is found again", 0.0, 5e-6 * 7999 - b.los_rad, 5e-7);
}

static void test_the_pi_loop_stops_when_frames_stay_away_and_starts_again_from_the_rate_of_the_line_of_sight(void) {
  bench b = bench_with(TRACKER_PI);
  for (int tick = 0; tick < 3001; ++tick) {
    (void)track(&b, 5e-6 * tick);
  }
  CHECK_NEAR("rate while tracking", 5e-3, b.out.rate_rad_s, 1e-4);
  b.camera_on = false;
  for (int tick = 3001; tick <= 3501; ++tick) {
    (void)track(&b, 5e-6 * tick);
  }
  CHECK_SAME("rate after the loss", 0.0, b.out.rate_rad_s);
  const camera_frame frame = {.fresh = true, .valid = true, .age_ticks = 20, .error_rad = 1e-3f};
  const speed_reference out = target_tracker_step(&b.state, &b.params, &frame, 0.004f, dt_s);
  CHECK_NEAR("rate of the first frame", 0.004 + 8.0 * 1e-3, out.rate_rad_s, 1e-8);
}

static void test_a_gap_between_frames_adds_at_most_a_tenth_of_a_second_to_the_integral(void) {
  target_tracker_params params = example(TRACKER_PI);
  target_tracker_state state;
  target_tracker_reset(&state);
  const camera_frame frame = {.fresh = true, .valid = true, .age_ticks = 20, .error_rad = 1e-3f};
  const camera_frame none = {.fresh = false};
  (void)target_tracker_step(&state, &params, &frame, 0.0f, dt_s);
  for (int tick = 0; tick < 399; ++tick) {
    (void)target_tracker_step(&state, &params, &none, 0.0f, dt_s);
  }
  (void)target_tracker_step(&state, &params, &frame, 0.0f, dt_s);
  CHECK_NEAR("integral", 4.0 * 1e-3 * 0.1, state.integral_rad_s, 1e-9);
}

static void test_frames_that_cannot_be_used_are_as_if_they_never_came(void) {
  const camera_frame frames[] = {
      {.fresh = false, .valid = true, .age_ticks = 20, .error_rad = 1e-3f},
      {.fresh = true, .valid = false, .age_ticks = 20, .error_rad = 1e-3f},
      {.fresh = true, .valid = true, .age_ticks = -1, .error_rad = 1e-3f},
      {.fresh = true, .valid = true, .age_ticks = 128, .error_rad = 1e-3f},
      {.fresh = true, .valid = true, .age_ticks = 2147483647, .error_rad = 1e-3f},
      {.fresh = true, .valid = true, .age_ticks = 20, .error_rad = NAN},
      {.fresh = true, .valid = true, .age_ticks = 20, .error_rad = INFINITY},
      {.fresh = true, .valid = true, .age_ticks = 20, .error_rad = -1e30f},
      {.fresh = true, .valid = true, .age_ticks = 20, .error_rad = 3.2f},
  };
  for (int kind = 0; kind < 2; ++kind) {
    for (unsigned i = 0; i < sizeof frames / sizeof frames[0]; ++i) {
      bench disturbed = bench_with((tracker_kind)kind);
      CHECK_SAME("rate", 0.0,
                 target_tracker_step(&disturbed.state, &disturbed.params, &frames[i], 0.0f, dt_s).rate_rad_s);
      TEST_ASSERT_FALSE(disturbed.state.locked);
      bench undisturbed = bench_with((tracker_kind)kind);
      for (int tick = 0; tick < 110; ++tick) {
        (void)track(&undisturbed, 1e-3);
      }
      target_tracker_state copy = undisturbed.state;
      const camera_frame none = {.fresh = false};
      const float without =
          target_tracker_step(&undisturbed.state, &undisturbed.params, &none, 0.001f, dt_s).rate_rad_s;
      CHECK_SAME("rate", without, target_tracker_step(&copy, &undisturbed.params, &frames[i], 0.001f, dt_s).rate_rad_s);
    }
  }
}

/* The PI goes on from the rate at which the predictive loop had found the target. */
static void test_a_loop_that_becomes_pi_has_the_rate_of_the_line_of_sight(void) {
  target_tracker_params params = example(TRACKER_PREDICTIVE);
  target_tracker_state state;
  target_tracker_reset(&state);
  const camera_frame centred = {.fresh = true, .valid = true, .age_ticks = 0, .error_rad = 0.0f};
  (void)target_tracker_step(&state, &params, &centred, 0.1f, dt_s);
  params.kind = TRACKER_PI;
  const camera_frame none = {.fresh = false};
  CHECK_NEAR("rate, rad/s", 0.1, target_tracker_step(&state, &params, &none, 0.1f, dt_s).rate_rad_s, 1e-6);
}

static void test_the_rate_limit_holds_and_stops_the_acceleration_feedforward(void) {
  for (int kind = 0; kind < 2; ++kind) {
    for (int side = -1; side <= 1; side += 2) {
      bench b = bench_with((tracker_kind)kind);
      b.params.rate_limit_rad_s = 0.01f;
      for (int tick = 0; tick < 3000; ++tick) {
        (void)track(&b, side * 0.02e-3 * tick);
        CHECK_AT_MOST("rate", 0.01f, fabsf(b.out.rate_rad_s));
      }
      CHECK_SAME("rate", (float)side * 0.01f, b.out.rate_rad_s);
      CHECK_SAME("acceleration", 0.0, b.out.acceleration_rad_s2);
      CHECK_AT_MOST("integral", 0.01f, fabsf(b.state.integral_rad_s));
    }
  }
}

static void test_a_tracker_without_frames_for_weeks_still_counts(void) {
  bench b = bench_with(TRACKER_PREDICTIVE);
  b.camera_on = false;
  b.state.ticks_since_frame = 1000000;
  (void)track(&b, 0.0);
  TEST_ASSERT_EQUAL_INT(1000000, b.state.ticks_since_frame);
}

static void test_check_refuses_each_value_by_itself(void) {
  target_tracker_params params = example(TRACKER_PREDICTIVE);
  CHECK_STATUS(CONTROL_OK, target_tracker_check(&params));
  params.kind = (tracker_kind)2;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, target_tracker_check(&params));
  params.kind = (tracker_kind)-1;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, target_tracker_check(&params));
  params.kind = TRACKER_PI;
  float *const values[] = {&params.proportional_per_s, &params.integral_per_s2, &params.estimator_rad_s,
                           &params.rate_limit_rad_s, &params.coast_s};
  const float bad[][2] = {{-0.1f, 101.0f}, {-0.1f, 1001.0f}, {0.09f, 50.1f}, {0.9e-5f, 101.0f}, {-0.1f, 10.1f}};
  for (int i = 0; i < 5; ++i) {
    const float good = *values[i];
    *values[i] = NAN;
    CHECK_STATUS(CONTROL_NOT_FINITE, target_tracker_check(&params));
    *values[i] = bad[i][0];
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, target_tracker_check(&params));
    *values[i] = bad[i][1];
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, target_tracker_check(&params));
    *values[i] = good;
  }
}

/* Gains as they are prepared for the next tick, gains of another tick, which are wrong, and none. */
static target_tracker_gains prepared_for(int frame, const target_tracker_state *state,
                                         const target_tracker_params *params) {
  if (frame % 3 == 0) {
    return target_tracker_prepare_gains(state, params, dt_s);
  }
  const target_tracker_gains of_this_tick = {.ticks = state->ticks_since_frame, .alpha = 9.0f};
  return frame % 3 == 1 ? of_this_tick : (target_tracker_gains){0};
}

/* Two components share frames, the time since the last one, and its loss; each is a predictive tracker of its own. */
static void test_two_components_are_two_predictive_trackers_with_the_same_frames(void) {
  const target_tracker_params params = example(TRACKER_PREDICTIVE);
  target_tracker_state together[2];
  target_tracker_state alone[2];
  for (int i = 0; i < 2; ++i) {
    target_tracker_reset(&together[i]);
    target_tracker_reset(&alone[i]);
  }
  for (int tick = 0; tick < 4000; ++tick) {
    const float t_s = 1e-3f * (float)tick;
    const float los_rad_s[] = {0.02f * sinf(3.0f * t_s), -0.01f * cosf(5.0f * t_s)};
    float error_rad[] = {1e-3f + 2e-3f * sinf(2.0f * t_s), -3e-3f * cosf(t_s)};
    /* from 1 s on without a target, from 1.6 s on again; one frame of each component is beyond half a turn */
    camera_frame frame = {.fresh = tick % frame_ticks == 0, .valid = tick < 1000 || tick > 1600, .age_ticks = 20};
    error_rad[0] = tick == 2000 ? 3.2f : error_rad[0];
    error_rad[1] = tick == 2400 ? NAN : error_rad[1];
    const target_tracker_gains gains = prepared_for(tick / frame_ticks, &together[0], &params);
    target_tracker_step_components(together, &params, &gains, &frame, error_rad, los_rad_s, dt_s);
    for (int i = 0; i < 2; ++i) {
      frame.error_rad = tick == 2000 || tick == 2400 ? NAN : error_rad[i];
      (void)target_tracker_step(&alone[i], &params, &frame, los_rad_s[i], dt_s);
      TEST_ASSERT_EQUAL_INT(alone[i].locked, together[i].locked);
      if (alone[i].locked) {
        CHECK_SAME("error, rad", alone[i].error_rad, together[i].error_rad);
        CHECK_SAME("rate, rad/s", alone[i].target_rate_rad_s, together[i].target_rate_rad_s);
        CHECK_SAME("acceleration, rad/s^2", alone[i].target_acceleration_rad_s2,
                   together[i].target_acceleration_rad_s2);
      }
    }
    TEST_ASSERT_EQUAL_INT(tick < 980 + 501 || tick >= 1620, together[0].locked);
  }
}

/* Jerk / rate is 6 rho^2 - 2 w^2 with 2 rho = a w / w^2, where rho is at most w, and w counts as at most 1 rad/s. */
static void test_the_jerk_of_a_straight_path_follows_from_rate_and_acceleration(void) {
  static const struct {
    const char *what;
    float rate_rad_s[2];
    float acceleration_rad_s2[2];
    double jerk_per_rate_s2;
  } rows[] = {
      {"at the closest approach", {0.3f, 0.4f}, {0.0f, 0.0f}, -2.0 * 0.25},
      {"an acceleration across is none of the path", {0.3f, 0.4f}, {0.4f, -0.3f}, -2.0 * 0.25},
      {"approaching", {0.3f, 0.4f}, {0.06f, 0.08f}, 1.5 * 0.04 - 2.0 * 0.25},
      {"leaving", {0.3f, -0.4f}, {-0.06f, 0.08f}, 1.5 * 0.04 - 2.0 * 0.25},
      {"along one component", {0.0f, 0.5f}, {0.7f, 0.1f}, 1.5 * 0.04 - 2.0 * 0.25},
      {"far away, along the line of sight", {0.3f, 0.4f}, {0.3f, 0.4f}, 4.0 * 0.25},
      {"more acceleration than that is noise", {0.3f, 0.4f}, {3.0f, 4.0f}, 4.0 * 0.25},
      {"just below 1 rad/s", {0.99f, 0.0f}, {0.0f, 0.0f}, -2.0 * 0.9801},
      {"faster", {3.0f, 4.0f}, {0.0f, 0.0f}, -2.0},
      {"faster, far away", {3.0f, 4.0f}, {30.0f, 40.0f}, 4.0},
      {"at rest", {0.0f, 0.0f}, {3.0f, 4.0f}, 0.0},
  };
  for (unsigned r = 0; r < sizeof rows / sizeof rows[0]; ++r) {
    target_tracker_state components[2];
    for (int i = 0; i < 2; ++i) {
      target_tracker_reset(&components[i]);
      target_tracker_assume(&components[i], 1e-3f, rows[r].rate_rad_s[i], rows[r].acceleration_rad_s2[i]);
    }
    target_tracker_follow_straight_path(components, 0.5f);
    for (int i = 0; i < 2; ++i) {
      const double expected =
          (double)rows[r].acceleration_rad_s2[i] + 0.5 * rows[r].jerk_per_rate_s2 * (double)rows[r].rate_rad_s[i];
      CHECK_NEAR(rows[r].what, expected, components[i].target_acceleration_rad_s2, 1e-5);
      CHECK_SAME("rate, rad/s", rows[r].rate_rad_s[i], components[i].target_rate_rad_s);
      CHECK_SAME("error, rad", 1e-3f, components[i].error_rad);
    }
  }
}

static void test_a_target_is_acquired_where_it_is_now_not_where_it_was_seen(void) {
  const target_tracker_params params = example(TRACKER_PREDICTIVE);
  static const int ages_ticks[] = {0, 1, 20, 127};
  for (int i = 0; i < 4; ++i) {
    target_tracker_state state;
    target_tracker_reset(&state);
    for (int tick = 0; tick < 300; ++tick) {
      const camera_frame frame = {.fresh = tick == 299, .valid = true, .age_ticks = ages_ticks[i], .error_rad = 5e-3f};
      (void)target_tracker_step(&state, &params, &frame, 0.02f, dt_s);
    }
    CHECK_NEAR("error, rad", 5e-3 - 0.02e-3 * ages_ticks[i], state.error_rad, 1e-8);
    CHECK_SAME("rate, rad/s", 0.02f, state.target_rate_rad_s);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_pi_loop_is_a_sampled_pi_with_a_frame_of_delay);
  RUN_TEST(test_the_pi_loop_has_a_bandwidth_of_about_2_hz);
  RUN_TEST(test_the_pi_loop_steps_to_the_target_with_little_overshoot);
  RUN_TEST(test_a_target_of_constant_rate_or_acceleration_is_followed_without_error);
  RUN_TEST(test_a_target_that_is_found_in_motion_is_followed_from_its_rate_on);
  RUN_TEST(test_the_delay_is_compensated_exactly_while_the_line_of_sight_moves);
  RUN_TEST(test_a_correction_is_carried_from_the_exposure_to_now);
  RUN_TEST(test_what_a_frame_says_alone_is_its_error_and_the_motion_since);
  RUN_TEST(test_a_frame_that_is_taken_back_leaves_the_estimate_before_it);
  RUN_TEST(test_without_frames_it_coasts_on_the_targets_rate_and_then_stops);
  RUN_TEST(test_the_pi_loop_stops_when_frames_stay_away_and_starts_again_from_the_rate_of_the_line_of_sight);
  RUN_TEST(test_a_gap_between_frames_adds_at_most_a_tenth_of_a_second_to_the_integral);
  RUN_TEST(test_frames_that_cannot_be_used_are_as_if_they_never_came);
  RUN_TEST(test_a_loop_that_becomes_pi_has_the_rate_of_the_line_of_sight);
  RUN_TEST(test_the_rate_limit_holds_and_stops_the_acceleration_feedforward);
  RUN_TEST(test_a_tracker_without_frames_for_weeks_still_counts);
  RUN_TEST(test_two_components_are_two_predictive_trackers_with_the_same_frames);
  RUN_TEST(test_the_jerk_of_a_straight_path_follows_from_rate_and_acceleration);
  RUN_TEST(test_a_target_is_acquired_where_it_is_now_not_where_it_was_seen);
  RUN_TEST(test_check_refuses_each_value_by_itself);
  return UNITY_END();
}
