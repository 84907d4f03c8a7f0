/* SPDX-License-Identifier: Apache-2.0 */
/* The speed loop on an axis of 23.5 kg m^2 with the stiff seal: nothing is compensated twice, limits do not wind up. */
#include "control/speed_loop.h"

#include "support/check.h"
#include "support/seals.h"

void setUp(void) {}
void tearDown(void) {}

static const float dt_s = 1e-3f;
static const double inertia_kg_m2 = 23.5;
static const float one_degree_s = 0.0174532925f;
static const torque_limits wide = {-200.0f, 200.0f};

static speed_loop_params example(void) {
  return (speed_loop_params){
      .rate_estimator = {.window_ticks = 2},
      .rate_fusion = {.source = RATE_FROM_ENCODER, .crossover_rad_s = 60.0f},
      .notch = biquad_pass(),
      .lowpass = biquad_pass(),
      .pi = {.proportional_gain = 1410.0f,
             .integral_gain = 16920.0f,
             .setpoint_weight = 1.0f,
             .tracking_rate_per_s = 12.0f},
      .acceleration_inertia_kg_m2 = 23.5f,
      .observer_on = true,
      .observer = {.inertia_kg_m2 = 23.5f, .viscous_nm_s_rad = 0.0f, .bandwidth_rad_s = 60.0f, .limit_nm = 100.0f},
      .friction = {.model = FRICTION_LUGRE,
                   .gain = 1.0f,
                   .lead_limit_rad_s = 0.05f,
                   .sign_width_rad_s = 1e-3f,
                   .lugre = stiff_seal()},
  };
}

/* An axis in double, with a 32-bit encoder. */
typedef struct {
  speed_loop_params params;
  speed_loop_state state;
  lugre_params seal;
  lugre_state bristles;
  bool has_seal;
  double share; /* of the inertia that turns */
  double load_nm;
  double rate_rad_s;
  double angle_turns;
  double friction_nm; /* torque of the seal in the last tick */
  torque_limits limits;
  speed_loop_rates rates;    /* inputs of the last tick */
  speed_reference reference; /* and its command */
  float applied_nm;
  speed_loop_output out;
} bench;

static bench bench_at_rest(bool has_seal) {
  bench b = {.params = example(), .seal = stiff_seal(), .has_seal = has_seal, .share = 1.0, .limits = wide};
  CHECK_STATUS(CONTROL_OK, speed_loop_check(&b.params, dt_s));
  speed_loop_reset(&b.state, &b.params, 0u, dt_s);
  return b;
}

static void run_tick(bench *b, float reference_rad_s) {
  const double turns = b->angle_turns - floor(b->angle_turns);
  const speed_loop_samples samples = {.joint_angle = (angle_turn32)(uint64_t)(turns * 4294967296.0)};
  b->reference = (speed_reference){.rate_rad_s = reference_rad_s};
  b->applied_nm = b->out.torque_nm;
  b->rates = speed_loop_sense(&b->state, &b->params, &samples, dt_s);
  b->out = speed_loop_control(&b->state, &b->params, &b->rates, &b->reference, b->applied_nm, &b->limits, dt_s);
  b->friction_nm = b->has_seal ? (double)lugre_step(&b->bristles, &b->seal, (float)b->rate_rad_s, dt_s) : 0.0;
  b->rate_rad_s += 1e-3 * ((double)b->out.torque_nm - b->friction_nm - b->load_nm) / (b->share * inertia_kg_m2);
  b->angle_turns += b->rate_rad_s * 1e-3 / 6.283185307179586;
}

static void run_seconds(bench *b, float reference_rad_s, double seconds) {
  for (int tick = 0; tick < (int)lround(1e3 * seconds); ++tick) {
    run_tick(b, reference_rad_s);
  }
}

/* Steady sliding with feedforward of `gain`: the shares of the compensation of friction. */
static void expect_shares(float gain, bool observer_on, float reference_rad_s) {
  bench b = bench_at_rest(true);
  b.params.friction.gain = gain;
  b.params.observer_on = observer_on;
  run_seconds(&b, reference_rad_s, 4.0);
  const double friction_nm = (double)lugre_steady_nm(&b.seal, reference_rad_s);
  const double residual_nm = (1.0 - (double)gain) * friction_nm;
  const double band_nm = 0.03; /* 0.3 %: one count of the encoder is 1.5 urad/s, times kp + w J = 4 mNm, and hunts */
  CHECK_NEAR("rate", reference_rad_s, b.rate_rad_s, 2e-5);
  CHECK_NEAR("feedforward", (double)gain * friction_nm, b.out.friction_nm, band_nm);
  CHECK_NEAR("observer", observer_on ? residual_nm : 0.0, b.out.disturbance_nm, band_nm);
  CHECK_NEAR("PI", observer_on ? 0.0 : residual_nm, b.out.pi_nm, band_nm);
  CHECK_NEAR("friction compensated once in all", friction_nm, b.out.friction_nm + b.out.disturbance_nm + b.out.pi_nm,
             band_nm);
}

static void test_what_feedforward_explains_the_observer_does_not_compensate_again(void) {
  expect_shares(1.0f, true, one_degree_s);
  expect_shares(1.0f, true, -one_degree_s);
}

static void test_without_feedforward_the_observer_finds_all_the_friction(void) {
  expect_shares(0.0f, true, one_degree_s);
}

static void test_with_half_the_feedforward_the_observer_finds_the_other_half(void) {
  expect_shares(0.5f, true, one_degree_s);
  expect_shares(0.5f, true, -one_degree_s);
}

static void test_with_too_much_feedforward_the_observer_takes_the_excess_back(void) {
  expect_shares(1.3f, true, one_degree_s);
}

static void test_without_observer_the_integral_holds_the_residual(void) { expect_shares(0.5f, false, one_degree_s); }

static void test_a_load_is_found_by_the_observer_beside_exact_feedforward(void) {
  bench b = bench_at_rest(true);
  b.load_nm = 6.0;
  run_seconds(&b, one_degree_s, 4.0);
  CHECK_NEAR("observer", 6.0, b.out.disturbance_nm, 0.03);
  CHECK_NEAR("feedforward", lugre_steady_nm(&b.seal, one_degree_s), b.out.friction_nm, 0.03);
}

static void test_at_start_up_exact_feedforward_leaves_the_observer_less_than_half(void) {
  bench with = bench_at_rest(true);
  bench without = bench_at_rest(true);
  without.params.friction.model = FRICTION_NONE;
  double largest_with = 0.0;
  double largest_without = 0.0;
  for (int tick = 0; tick < 1000; ++tick) {
    run_tick(&with, one_degree_s);
    run_tick(&without, one_degree_s);
    largest_with = fmax(largest_with, fabs((double)with.out.disturbance_nm));
    largest_without = fmax(largest_without, fabs((double)without.out.disturbance_nm));
  }
  LOG_VALUE("largest estimate during start-up with feedforward, Nm", largest_with);
  LOG_VALUE("largest estimate during start-up without, Nm", largest_without);
  CHECK_AT_LEAST("without", 10.0, largest_without);
  CHECK_AT_MOST("with", 0.5 * largest_without, largest_with);
}

static void test_the_observer_sees_the_last_ticks_torque_less_the_last_ticks_feedforward(void) {
  const speed_loop_params params = example();
  speed_loop_state state;
  speed_loop_reset(&state, &params, 0u, dt_s);
  const speed_loop_rates still = {0};
  const speed_reference start = {.rate_rad_s = one_degree_s};
  const speed_loop_output first = speed_loop_control(&state, &params, &still, &start, 0.0f, &wide, dt_s);
  CHECK_AT_LEAST("feedforward of the first tick", 10.0, first.friction_nm);
  CHECK_SAME("estimate of the first tick", 0.0, first.disturbance_nm);
  const speed_loop_output second = speed_loop_control(&state, &params, &still, &start, first.friction_nm, &wide, dt_s);
  CHECK_SAME("estimate when only feedforward was applied", 0.0, second.disturbance_nm);
  const speed_loop_output third =
      speed_loop_control(&state, &params, &still, &start, second.friction_nm + 5.0f, &wide, dt_s);
  CHECK_NEAR("estimate of 5 Nm that moved nothing", 5.0 * (1.0 - exp(-0.06)), third.disturbance_nm, 1e-5);
}

static void test_the_command_is_the_sum_of_its_parts(void) {
  const speed_loop_params params = example();
  speed_loop_state state;
  speed_loop_reset(&state, &params, 0u, dt_s);
  const speed_loop_rates rates = {.joint_rate_rad_s = 0.01f, .rate_rad_s = 0.011f, .feedback_rad_s = 0.012f};
  const speed_reference reference = {.rate_rad_s = 0.02f, .acceleration_rad_s2 = 0.3f};
  const speed_loop_output out = speed_loop_control(&state, &params, &rates, &reference, 3.0f, &wide, dt_s);
  CHECK_RELATIVE("PI on the filtered rate", 1410.0 * 0.008, out.pi_nm, 1e-5);
  CHECK_RELATIVE("acceleration", 23.5 * 0.3, out.acceleration_nm, 1e-6);
  CHECK_AT_LEAST("friction", 5.0, out.friction_nm);
  CHECK_AT_MOST("observer: the axis moved faster than 3 Nm explain", -5.0, out.disturbance_nm);
  CHECK_NEAR("sum",
             (double)out.pi_nm + (double)out.acceleration_nm + (double)out.disturbance_nm + (double)out.friction_nm,
             out.torque_nm, 1e-5);
  TEST_ASSERT_FALSE(out.limited);
  CHECK_NEAR("integral after the tick", 1e-3 * 16920.0 * 0.008, state.pi.integral, 1e-5);
}

static void test_limits_are_kept_whatever_their_signs(void) {
  const torque_limits limits[] = {{-1.0f, 4.0f}, {2.0f, 8.0f}, {-8.0f, -2.0f}, {3.0f, 3.0f}, {0.0f, 0.0f}};
  for (int i = 0; i < 5; ++i) {
    for (int side = -1; side <= 1; side += 2) {
      bench b = bench_at_rest(true);
      b.limits = limits[i];
      for (int tick = 0; tick < 2000; ++tick) {
        run_tick(&b, (float)side * 0.5f);
        CHECK_AT_LEAST("torque", limits[i].minimum_nm, b.out.torque_nm);
        CHECK_AT_MOST("torque", limits[i].maximum_nm, b.out.torque_nm);
      }
      TEST_ASSERT_TRUE(b.out.limited);
      CHECK_SAME("torque", side > 0 ? limits[i].maximum_nm : limits[i].minimum_nm, b.out.torque_nm);
    }
  }
}

/* A hanging load of 5 Nm, with torque limits that differ or have the same sign. The axis needs long to reach the rate;
 * the integral must not cause overshoot afterwards. */
static void test_a_limited_axis_reaches_its_rate_without_running_past_it(void) {
  const double loads_nm[] = {0.0, 5.0, -5.0, 0.0};
  const torque_limits limits[] = {{-2.0f, 6.0f}, {3.0f, 9.0f}, {-9.0f, -3.0f}, {-6.0f, 2.0f}};
  for (int i = 0; i < 4; ++i) {
    for (int side = -1; side <= 1; side += 2) {
      bench b = bench_at_rest(false);
      b.params.friction.model = FRICTION_NONE;
      b.load_nm = loads_nm[i];
      b.limits = limits[i];
      run_seconds(&b, 0.0f, 2.0);
      const float rate_rad_s = 0.05f * (float)side;
      double highest = 0.0;
      for (int tick = 0; tick < 3000; ++tick) {
        run_tick(&b, rate_rad_s);
        highest = fmax(highest, side * b.rate_rad_s);
      }
      CHECK_AT_MOST("highest rate", 0.05 * 1.15, highest);
      CHECK_NEAR("rate", rate_rad_s, b.rate_rad_s, 2e-5);
      CHECK_NEAR("observer", loads_nm[i], b.out.disturbance_nm, 0.03);
      TEST_ASSERT_FALSE(b.out.limited);
    }
  }
}

/* What a bumpless change leaves in the integral would turn the axis for ever. */
static void test_without_integral_gain_an_axis_comes_to_rest_after_a_change_in_motion(void) {
  bench b = bench_at_rest(false);
  b.params.observer_on = false;
  b.params.friction.model = FRICTION_NONE;
  run_seconds(&b, 0.5f, 2.0);
  speed_loop_params p_only = b.params;
  p_only.pi.integral_gain = 0.0f;
  p_only.pi.setpoint_weight = 0.2f;
  speed_loop_retune(&b.state, &b.params, &p_only, &b.rates, &b.reference, b.applied_nm, dt_s);
  b.params = p_only;
  run_tick(&b, 0.5f);
  CHECK_NEAR("integral after the change, Nm", 1410.0 * 0.8 * 0.5, b.state.pi.integral, 10.0);
  run_seconds(&b, 0.0f, 1.0);
  CHECK_AT_MOST("rate after 1 s, rad/s", 0.005, fabs(b.rate_rad_s));
  run_seconds(&b, 0.0f, 1.0);
  CHECK_AT_MOST("rate after 2 s, rad/s", 5e-5, fabs(b.rate_rad_s));
}

static void test_after_reset_an_axis_at_rest_gets_no_torque_wherever_it_stands(void) {
  speed_loop_params params = example();
  CHECK_STATUS(CONTROL_OK, biquad_design_lowpass(&params.lowpass, 300.0f, 0.7f, dt_s));
  CHECK_STATUS(CONTROL_OK, biquad_design_notch(&params.notch, 300.0f, 60.0f, 0.1f, dt_s));
  const angle_turn32 angles[] = {0u, 0x12345678u, 0xFFFFFFFFu};
  for (int i = 0; i < 3; ++i) {
    speed_loop_state state;
    speed_loop_reset(&state, &params, 99u, dt_s);
    const speed_loop_rates fast = {.joint_rate_rad_s = 1.0f, .rate_rad_s = 1.0f, .feedback_rad_s = 1.0f};
    const speed_reference forward = {.rate_rad_s = 0.5f};
    (void)speed_loop_control(&state, &params, &fast, &forward, 10.0f, &wide, dt_s); /* a state to clear */
    speed_loop_reset(&state, &params, angles[i], dt_s);
    const speed_loop_samples samples = {.joint_angle = angles[i]};
    const speed_reference still = {0};
    for (int tick = 0; tick < 5; ++tick) {
      const speed_loop_rates rates = speed_loop_sense(&state, &params, &samples, dt_s);
      CHECK_SAME("torque", 0.0, speed_loop_control(&state, &params, &rates, &still, 0.0f, &wide, dt_s).torque_nm);
    }
  }
}

/* Sliding steadily, the parameters change; returns the torque step of the next tick. */
static double jump_at_change(const speed_loop_params *from, const speed_loop_params *to, bool retuned) {
  bench b = bench_at_rest(true);
  b.params = *from;
  b.load_nm = 3.0;
  run_seconds(&b, one_degree_s, 4.0);
  const double before_nm = (double)b.out.torque_nm;
  if (retuned) {
    speed_loop_retune(&b.state, from, to, &b.rates, &b.reference, b.applied_nm, dt_s);
  }
  b.params = *to;
  run_tick(&b, one_degree_s);
  const double jump_nm = fabs((double)b.out.torque_nm - before_nm);
  run_seconds(&b, one_degree_s, 3.0);
  CHECK_NEAR("rate after the change", one_degree_s, b.rate_rad_s, 2e-5);
  return jump_nm;
}

static void test_other_parameters_take_over_without_a_jump_of_the_torque(void) {
  speed_loop_params changed[4] = {example(), example(), example(), example()};
  changed[0].observer_on = false;
  changed[1].friction.gain = 0.3f;
  changed[2].observer.inertia_kg_m2 = 40.0f;
  changed[2].observer.bandwidth_rad_s = 150.0f;
  changed[3].friction.model = FRICTION_NONE;
  changed[3].pi.proportional_gain = 700.0f;
  const speed_loop_params usual = example();
  for (int i = 0; i < 4; ++i) {
    CHECK_STATUS(CONTROL_OK, speed_loop_check(&changed[i], dt_s));
    CHECK_AT_MOST("jump, retuned", 0.05, jump_at_change(&usual, &changed[i], true));
    CHECK_AT_MOST("jump, retuned back", 0.05, jump_at_change(&changed[i], &usual, true));
    if (i != 2) { /* an observer keeps its parameters until it is retuned */
      CHECK_AT_LEAST("jump, parameters only exchanged", 1.0, jump_at_change(&usual, &changed[i], false));
    }
  }
}

/* 20 ms after a reversal, while the bristles still bend. */
static void test_the_same_parameters_again_change_nothing_also_while_friction_builds_up(void) {
  bench b = bench_at_rest(true);
  b.load_nm = 3.0;
  run_seconds(&b, one_degree_s, 2.0);
  run_seconds(&b, -one_degree_s, 0.02);
  const speed_loop_state before = b.state;
  speed_loop_retune(&b.state, &b.params, &b.params, &b.rates, &b.reference, b.applied_nm, dt_s);
  CHECK_NEAR("observed, Nm", before.observer.estimate_nm, b.state.observer.estimate_nm, 1e-4);
  CHECK_NEAR("explained, Nm", before.explained_nm, b.state.explained_nm, 1e-4);
  CHECK_NEAR("integral, Nm", before.pi.integral, b.state.pi.integral, 1e-3);
}

/* The base turns back as fast as the joint turns forward, the line of sight is at rest: friction is still that of the
 * joint. */
static void test_friction_is_fed_forward_on_the_joint_rate_when_the_base_turns(void) {
  static const float joint_rad_s[] = {-0.04f, 0.3f}; /* below and above the limit of the lead */
  for (int i = 0; i < 2; ++i) {
    bench b = bench_at_rest(false);
    const speed_loop_rates rates = {.joint_rate_rad_s = joint_rad_s[i], .base_rate_rad_s = -joint_rad_s[i]};
    const speed_reference still = {0};
    speed_loop_output out = {0};
    for (int tick = 0; tick < 500; ++tick) {
      out = speed_loop_control(&b.state, &b.params, &rates, &still, out.torque_nm, &wide, dt_s);
    }
    CHECK_RELATIVE("friction, Nm", lugre_steady_nm(&b.params.friction.lugre, joint_rad_s[i]), out.friction_nm, 1e-4);
  }
}

/* Feedforward is switched off and on in steady sliding: the observer takes the difference in the same tick, the rate
 * does not change. */
static void test_friction_goes_from_feedforward_to_the_observer_and_back_without_an_error_of_the_rate(void) {
  speed_loop_params without = example();
  without.friction.model = FRICTION_NONE;
  const speed_loop_params with = example();
  bench b = bench_at_rest(true);
  run_seconds(&b, one_degree_s, 4.0);
  const double friction_nm = (double)lugre_steady_nm(&b.seal, one_degree_s);
  for (int change = 0; change < 4; ++change) {
    const speed_loop_params *to = change % 2 == 0 ? &without : &with;
    speed_loop_retune(&b.state, &b.params, to, &b.rates, &b.reference, b.applied_nm, dt_s);
    b.params = *to;
    double worst_rad_s = 0.0;
    for (int tick = 0; tick < 1000; ++tick) {
      run_tick(&b, one_degree_s);
      worst_rad_s = fmax(worst_rad_s, fabs(b.rate_rad_s - (double)one_degree_s));
    }
    CHECK_AT_MOST("error of the rate, rad/s", 2e-5, worst_rad_s);
    CHECK_NEAR("the observer's share, Nm", change % 2 == 0 ? friction_nm : 0.0, b.out.disturbance_nm, 0.05);
    CHECK_NEAR("the integral's, Nm", 0.0, b.state.pi.integral, 0.05);
  }
}

static void test_a_stiffer_model_takes_over_the_torque_that_the_bristles_hold(void) {
  bench b = bench_at_rest(true);
  run_seconds(&b, one_degree_s, 2.0);
  run_seconds(&b, 0.0f, 2.0);
  const float held_nm = b.out.friction_nm;
  CHECK_AT_LEAST("held by the bristles", 5.0, fabsf(held_nm));
  speed_loop_params stiffer = b.params;
  stiffer.friction.lugre.stiffness_nm_rad *= 4.0f;
  speed_loop_retune(&b.state, &b.params, &stiffer, &b.rates, &b.reference, b.applied_nm, dt_s);
  b.params = stiffer;
  run_tick(&b, 0.0f);
  CHECK_NEAR("held after the change", held_nm, b.out.friction_nm, 1e-4);
}

/* What others know of the base's rate makes up for what the sensors of a source lack: other sensors lack something
 * else, other gains do not. */
static void test_the_rate_of_the_base_is_carried_on_until_the_source_of_the_rate_changes(void) {
  bench b = bench_at_rest(false);
  b.state.carried_rad_s = 0.05f;
  run_tick(&b, 0.0f);
  speed_loop_params changed = b.params;
  changed.pi.proportional_gain *= 0.5f;
  speed_loop_retune(&b.state, &b.params, &changed, &b.rates, &b.reference, b.applied_nm, dt_s);
  CHECK_SAME("carried, rad/s", 0.05f, b.state.carried_rad_s);
  speed_loop_params fused = changed;
  fused.rate_fusion.source = RATE_FUSED;
  speed_loop_retune(&b.state, &changed, &fused, &b.rates, &b.reference, b.applied_nm, dt_s);
  CHECK_SAME("carried, rad/s", 0.0, b.state.carried_rad_s);
}

static void test_filters_that_are_switched_on_in_motion_start_settled(void) {
  bench b = bench_at_rest(true);
  run_seconds(&b, one_degree_s, 3.0);
  speed_loop_params filtered = b.params;
  CHECK_STATUS(CONTROL_OK, biquad_design_lowpass(&filtered.lowpass, 6.2831853f * 150.0f, 0.7f, dt_s));
  CHECK_STATUS(CONTROL_OK, biquad_design_notch(&filtered.notch, 6.2831853f * 200.0f, 60.0f, 0.1f, dt_s));
  const float before_nm = b.out.torque_nm;
  speed_loop_retune(&b.state, &b.params, &filtered, &b.rates, &b.reference, b.applied_nm, dt_s);
  b.params = filtered;
  for (int tick = 0; tick < 200; ++tick) {
    run_tick(&b, one_degree_s);
    CHECK_NEAR("torque", before_nm, b.out.torque_nm, 0.1);
  }
}

/* The filters still hold another rate than the axis has: they begin anew at its rate. */
static void test_a_restart_gives_the_holding_torque_whatever_the_filters_held(void) {
  speed_loop_params params = example();
  params.friction.model = FRICTION_NONE;
  params.rate_fusion.source = RATE_FROM_GYRO;
  CHECK_STATUS(CONTROL_OK, biquad_design_lowpass(&params.lowpass, 6.2831853f * 20.0f, 0.7f, dt_s));
  CHECK_STATUS(CONTROL_OK, biquad_design_notch(&params.notch, 6.2831853f * 50.0f, 60.0f, 0.1f, dt_s));
  speed_loop_state state;
  speed_loop_reset(&state, &params, 0u, dt_s);
  const speed_loop_samples samples = {.gyro_rad_s = 0.3f, .gyro_valid = true};
  const speed_loop_rates before = speed_loop_sense(&state, &params, &samples, dt_s);
  CHECK_AT_MOST("feedback of the filters", 0.1, before.feedback_rad_s);
  speed_loop_restart(&state, &params, &before, 7.0f, dt_s);
  const speed_loop_rates rates = speed_loop_sense(&state, &params, &samples, dt_s);
  CHECK_NEAR("feedback after the restart", 0.3, rates.feedback_rad_s, 1e-6);
  const speed_reference steady = {.rate_rad_s = 0.3f};
  const speed_loop_output out = speed_loop_control(&state, &params, &rates, &steady, 0.0f, &wide, dt_s);
  CHECK_NEAR("torque, Nm", 7.0, out.torque_nm, 1e-3);
}

static void test_a_reset_forgets_how_fast_the_base_turned(void) {
  speed_loop_params params = example();
  params.rate_fusion.source = RATE_FUSED;
  speed_loop_state state;
  speed_loop_reset(&state, &params, 0u, dt_s);
  const speed_loop_samples turning = {.gyro_rad_s = 0.5f, .gyro_valid = true};
  for (int tick = 0; tick < 500; ++tick) {
    (void)speed_loop_sense(&state, &params, &turning, dt_s);
  }
  speed_loop_reset(&state, &params, 0u, dt_s);
  const speed_loop_samples still = {.gyro_valid = true};
  const speed_loop_rates rates = speed_loop_sense(&state, &params, &still, dt_s);
  CHECK_SAME("base rate", 0.0, rates.base_rate_rad_s);
  CHECK_SAME("rate", 0.0, rates.rate_rad_s);
  CHECK_SAME("feedback", 0.0, rates.feedback_rad_s);
}

static void test_losing_the_gyro_makes_no_bump_in_the_feedback(void) {
  speed_loop_params params = example();
  params.rate_fusion.source = RATE_FUSED;
  speed_loop_state state;
  speed_loop_reset(&state, &params, 0u, dt_s);
  angle_turn32 angle = 0u;
  speed_loop_rates before = {0};
  for (int tick = 0; tick < 1000; ++tick) {
    angle += 13670u; /* 0.02 rad/s */
    const speed_loop_samples samples = {.joint_angle = angle, .gyro_rad_s = 0.05f, .gyro_valid = true};
    before = speed_loop_sense(&state, &params, &samples, dt_s);
  }
  CHECK_NEAR("inertial rate", 0.05, before.rate_rad_s, 1e-6);
  CHECK_NEAR("joint rate", 0.02, before.joint_rate_rad_s, 1e-5);
  CHECK_NEAR("base rate", 0.03, before.base_rate_rad_s, 1e-5);
  angle += 13670u;
  const speed_loop_samples lost = {.joint_angle = angle, .gyro_rad_s = NAN, .gyro_valid = false};
  const speed_loop_rates after = speed_loop_sense(&state, &params, &lost, dt_s);
  CHECK_NEAR("feedback", before.feedback_rad_s, after.feedback_rad_s, 1e-6);
}

static void test_the_filters_are_on_the_feedback_only(void) {
  speed_loop_params params = example();
  params.rate_fusion.source = RATE_FROM_GYRO;
  CHECK_STATUS(CONTROL_OK, biquad_design_notch(&params.notch, 6.2831853f * 50.0f, 6.2831853f * 20.0f, 0.0f, dt_s));
  CHECK_STATUS(CONTROL_OK, biquad_design_lowpass(&params.lowpass, 6.2831853f * 120.0f, 0.7f, dt_s));
  const double frequencies_hz[] = {50.0, 250.0, 2.0};
  const double lowest[] = {0.0, 0.0, 0.99};
  const double highest[] = {0.01, 0.16, 1.01}; /* at 250 Hz (tan 21.6 deg / tan 45 deg)^2 = 0.157 */
  for (int i = 0; i < 3; ++i) {
    speed_loop_state state;
    speed_loop_reset(&state, &params, 0u, dt_s);
    double raw = 0.0;
    double filtered = 0.0;
    for (int tick = 0; tick < 4000; ++tick) {
      const float gyro_rad_s = (float)sin(6.283185307179586e-3 * frequencies_hz[i] * tick + 0.4);
      const speed_loop_samples samples = {.gyro_rad_s = gyro_rad_s, .gyro_valid = true};
      const speed_loop_rates rates = speed_loop_sense(&state, &params, &samples, dt_s);
      CHECK_SAME("rate before the filters", gyro_rad_s, rates.rate_rad_s);
      if (tick >= 2000) {
        raw += (double)gyro_rad_s * (double)gyro_rad_s;
        filtered += (double)rates.feedback_rad_s * (double)rates.feedback_rad_s;
      }
    }
    CHECK_AT_LEAST("gain to the feedback", lowest[i], sqrt(filtered / raw));
    CHECK_AT_MOST("gain to the feedback", highest[i], sqrt(filtered / raw));
  }
}

/* Without friction everything is proportional to the inertia. */
static void test_a_share_of_the_inertia_moves_as_the_whole_by_that_share_of_the_torque(void) {
  bench whole = bench_at_rest(false);
  whole.params.friction.model = FRICTION_NONE;
  whole.params.pi.setpoint_weight = 0.7f;
  bench part = whole;
  part.share = 0.5;
  const speed_loop_pose pose = {.inertia_share = 0.5f, .gyro_share = 1.0f};
  speed_loop_follow(&part.state, &part.params, &pose, &part.rates, &part.reference, dt_s);
  speed_loop_close(&part.state, &part.params, &part.rates, dt_s);
  whole.load_nm = 4.0;
  part.load_nm = 2.0;
  double min_nm = 0.0;
  for (int tick = 0; tick < 1000; ++tick) {
    run_tick(&whole, tick < 500 ? 0.02f : -0.01f);
    run_tick(&part, tick < 500 ? 0.02f : -0.01f);
    CHECK_NEAR("rate, rad/s", whole.rate_rad_s, part.rate_rad_s, 1e-9);
    CHECK_NEAR("torque, Nm", 0.5 * (double)whole.out.torque_nm, part.out.torque_nm, 2e-3);
    min_nm = fmin(min_nm, (double)part.out.torque_nm);
  }
  CHECK_AT_MOST("the torque reverses, Nm", -5.0, min_nm);
}

/* The axis turns at 0.3 rad/s against a load, with a set-point weight that makes the proportional part large. */
static void test_gains_that_follow_the_inertia_make_no_step_of_the_torque(void) {
  bench b = bench_at_rest(false);
  b.params.friction.model = FRICTION_NONE;
  b.params.pi.setpoint_weight = 0.5f;
  b.load_nm = 8.0;
  run_seconds(&b, 0.3f, 3.0);
  const double before_nm = (double)b.out.torque_nm;
  double worst_nm = 0.0;
  for (int tick = 1; tick <= 400; ++tick) {
    const speed_loop_pose pose = {.inertia_share = 1.0f - 0.00125f * (float)tick, .gyro_share = 1.0f};
    speed_loop_follow(&b.state, &b.params, &pose, &b.rates, &b.reference, dt_s);
    b.share = (double)pose.inertia_share;
    run_tick(&b, 0.3f);
    worst_nm = fmax(worst_nm, fabs((double)b.out.torque_nm - before_nm));
  }
  CHECK_SAME("share", 0.5, b.state.pose.inertia_share);
  CHECK_AT_MOST("change of the torque, Nm", 0.02, worst_nm); /* of 106 Nm that the PI's proportional part has lost */
  for (int tick = 1; tick <= 400; ++tick) {                  /* and back */
    const speed_loop_pose pose = {.inertia_share = 0.5f + 0.00125f * (float)tick, .gyro_share = 1.0f};
    speed_loop_follow(&b.state, &b.params, &pose, &b.rates, &b.reference, dt_s);
    b.share = (double)pose.inertia_share;
    run_tick(&b, 0.3f);
    worst_nm = fmax(worst_nm, fabs((double)b.out.torque_nm - before_nm));
  }
  CHECK_AT_MOST("change of the torque, Nm", 0.02, worst_nm);
  CHECK_NEAR("rate, rad/s", 0.3, b.rate_rad_s, 1e-5);
}

static void test_a_retune_keeps_the_share_of_the_inertia(void) {
  bench b = bench_at_rest(false);
  b.params.friction.model = FRICTION_NONE;
  b.share = 0.5;
  const speed_loop_pose pose = {.inertia_share = 0.5f, .gyro_share = 1.0f};
  speed_loop_follow(&b.state, &b.params, &pose, &b.rates, &b.reference, dt_s);
  speed_loop_close(&b.state, &b.params, &b.rates, dt_s);
  b.load_nm = 5.0;
  run_seconds(&b, 0.1f, 2.0);
  const float momentum = b.state.observer.momentum_nm_s_rad;
  speed_loop_retune(&b.state, &b.params, &b.params, &b.rates, &b.reference, b.applied_nm, dt_s);
  CHECK_SAME("momentum of the observer", momentum, b.state.observer.momentum_nm_s_rad);
  run_tick(&b, 0.1f);
  CHECK_NEAR("torque, Nm", 5.0, b.out.torque_nm, 0.02);
  speed_loop_restart(&b.state, &b.params, &b.rates, 5.0f, dt_s);
  CHECK_SAME("momentum of the observer", momentum, b.state.observer.momentum_nm_s_rad);
  run_tick(&b, 0.1f);
  CHECK_NEAR("torque, Nm", 5.0 + 0.058 * 5.0, b.out.torque_nm, 0.02); /* the observer begins to find the load */
  speed_loop_reset(&b.state, &b.params, 0u, dt_s);
  CHECK_SAME("momentum of the observer, by itself", 2.0 * (double)momentum, b.state.observer.momentum_nm_s_rad);
}

/* The joint turns at 0.2 rad/s on a base that turns at 0.05 rad/s; the gyro measures a share of the sum. */
static speed_loop_rates seen_in(speed_loop_pose pose, float reading_rad_s) {
  speed_loop_params params = example();
  params.rate_fusion.source = RATE_FROM_GYRO;
  speed_loop_state state;
  speed_loop_reset(&state, &params, 0u, dt_s);
  speed_loop_follow(&state, &params, &pose, &(speed_loop_rates){0}, &(speed_reference){0}, dt_s);
  speed_loop_samples samples = {.gyro_rad_s = reading_rad_s, .gyro_valid = true};
  speed_loop_rates rates = {0};
  for (int tick = 1; tick < 5; ++tick) {
    samples.joint_angle = (angle_turn32)llround(0.2 * 1e-3 * tick / 6.283185307179586 * 4294967296.0);
    rates = speed_loop_sense(&state, &params, &samples, dt_s);
  }
  return rates;
}

static speed_loop_rates seen_with(float gyro_share, float reading_rad_s) {
  return seen_in((speed_loop_pose){.inertia_share = 1.0f, .gyro_share = gyro_share}, reading_rad_s);
}

static void test_a_gyro_below_the_joint_lacks_the_joints_rate(void) {
  const speed_loop_pose below = {.inertia_share = 1.0f, .gyro_share = 1.0f, .gyro_below = true};
  CHECK_NEAR("inertial rate, rad/s", 0.25, seen_in(below, 0.05f).rate_rad_s, 2e-6);
}

static void test_a_gyro_that_measures_a_share_gives_the_rate_about_the_axis(void) {
  const double shares[] = {1.0, 0.5, 0.1, -0.1, -0.7}; /* negative: beyond the zenith */
  for (int i = 0; i < 5; ++i) {
    const speed_loop_rates rates = seen_with((float)shares[i], (float)(0.25 * shares[i]));
    CHECK_NEAR("inertial rate, rad/s", 0.25, rates.rate_rad_s, 2e-6);
  }
}

/* What of the base it can still see fades out; the joint's own rate stays whole. */
static void test_near_the_zenith_the_encoder_replaces_a_gyro_on_the_line_of_sight(void) {
  CHECK_NEAR("half of the least share, rad/s", 0.2 + 0.25 * 0.05, seen_with(0.05f, 0.05f * 0.25f).rate_rad_s, 2e-6);
  CHECK_NEAR("in the zenith, rad/s", 0.2, seen_with(0.0f, 0.0f).rate_rad_s, 2e-6);
  CHECK_NEAR("with noise in the zenith, rad/s", 0.2, seen_with(0.0f, 1e-3f).rate_rad_s, 2e-6);
}

static void test_check_asks_every_part(void) {
  const speed_loop_params good = example();
  CHECK_STATUS(CONTROL_OK, speed_loop_check(&good, dt_s));
  speed_loop_params bad = good;
  bad.rate_estimator.window_ticks = 1;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, speed_loop_check(&bad, dt_s));
  bad = good;
  bad.rate_fusion.crossover_rad_s = NAN;
  CHECK_STATUS(CONTROL_NOT_FINITE, speed_loop_check(&bad, dt_s));
  bad = good;
  bad.notch.a2 = 1.0f;
  CHECK_STATUS(CONTROL_INCONSISTENT, speed_loop_check(&bad, dt_s));
  bad = good;
  bad.lowpass.a1 = -1.0f;
  CHECK_STATUS(CONTROL_INCONSISTENT, speed_loop_check(&bad, dt_s));
  bad = good;
  bad.pi.setpoint_weight = 1.1f;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, speed_loop_check(&bad, dt_s));
  bad = good;
  bad.acceleration_inertia_kg_m2 = -0.1f;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, speed_loop_check(&bad, dt_s));
  bad = good;
  bad.observer.bandwidth_rad_s = 1001.0f;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, speed_loop_check(&bad, dt_s));
  bad = good;
  bad.friction.lugre.negative.breakaway_nm = 1.0f;
  CHECK_STATUS(CONTROL_INCONSISTENT, speed_loop_check(&bad, dt_s));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_what_feedforward_explains_the_observer_does_not_compensate_again);
  RUN_TEST(test_without_feedforward_the_observer_finds_all_the_friction);
  RUN_TEST(test_with_half_the_feedforward_the_observer_finds_the_other_half);
  RUN_TEST(test_with_too_much_feedforward_the_observer_takes_the_excess_back);
  RUN_TEST(test_without_observer_the_integral_holds_the_residual);
  RUN_TEST(test_a_load_is_found_by_the_observer_beside_exact_feedforward);
  RUN_TEST(test_at_start_up_exact_feedforward_leaves_the_observer_less_than_half);
  RUN_TEST(test_the_observer_sees_the_last_ticks_torque_less_the_last_ticks_feedforward);
  RUN_TEST(test_the_command_is_the_sum_of_its_parts);
  RUN_TEST(test_limits_are_kept_whatever_their_signs);
  RUN_TEST(test_a_limited_axis_reaches_its_rate_without_running_past_it);
  RUN_TEST(test_without_integral_gain_an_axis_comes_to_rest_after_a_change_in_motion);
  RUN_TEST(test_after_reset_an_axis_at_rest_gets_no_torque_wherever_it_stands);
  RUN_TEST(test_other_parameters_take_over_without_a_jump_of_the_torque);
  RUN_TEST(test_the_same_parameters_again_change_nothing_also_while_friction_builds_up);
  RUN_TEST(test_friction_is_fed_forward_on_the_joint_rate_when_the_base_turns);
  RUN_TEST(test_friction_goes_from_feedforward_to_the_observer_and_back_without_an_error_of_the_rate);
  RUN_TEST(test_a_stiffer_model_takes_over_the_torque_that_the_bristles_hold);
  RUN_TEST(test_the_rate_of_the_base_is_carried_on_until_the_source_of_the_rate_changes);
  RUN_TEST(test_filters_that_are_switched_on_in_motion_start_settled);
  RUN_TEST(test_a_restart_gives_the_holding_torque_whatever_the_filters_held);
  RUN_TEST(test_a_reset_forgets_how_fast_the_base_turned);
  RUN_TEST(test_losing_the_gyro_makes_no_bump_in_the_feedback);
  RUN_TEST(test_the_filters_are_on_the_feedback_only);
  RUN_TEST(test_a_share_of_the_inertia_moves_as_the_whole_by_that_share_of_the_torque);
  RUN_TEST(test_gains_that_follow_the_inertia_make_no_step_of_the_torque);
  RUN_TEST(test_a_retune_keeps_the_share_of_the_inertia);
  RUN_TEST(test_a_gyro_below_the_joint_lacks_the_joints_rate);
  RUN_TEST(test_a_gyro_that_measures_a_share_gives_the_rate_about_the_axis);
  RUN_TEST(test_near_the_zenith_the_encoder_replaces_a_gyro_on_the_line_of_sight);
  RUN_TEST(test_check_asks_every_part);
  return UNITY_END();
}
