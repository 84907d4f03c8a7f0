/* SPDX-License-Identifier: Apache-2.0 */
/* Friction feedforward on the bench: start-up, reversal, standstill, a blocked axis, a moving base. */
#include "control/friction_feedforward.h"

#include "support/check.h"
#include "support/random.h"
#include "support/seals.h"

void setUp(void) {}
void tearDown(void) {}

static const float dt_s = 1e-3f;
static const float degree = 0.0174532925f;

static friction_feedforward_params example(friction_model model) {
  return (friction_feedforward_params){
      .model = model, .gain = 1.0f, .lead_limit_rad_s = 0.05f, .sign_width_rad_s = 1e-3f, .lugre = stiff_seal()};
}

static friction_feedforward_input rates(float reference_rad_s, float base_rad_s, float joint_rad_s) {
  return (friction_feedforward_input){
      .reference_rad_s = reference_rad_s, .base_rate_rad_s = base_rad_s, .joint_rate_rad_s = joint_rad_s};
}

static void test_startup_is_compensated_in_the_tick_in_which_it_is_commanded(void) {
  const friction_feedforward_params params = example(FRICTION_LUGRE);
  friction_feedforward_state state;
  friction_feedforward_reset(&state);
  lugre_state seal;
  lugre_reset(&seal);
  for (int tick = 0; tick < 300; ++tick) { /* the joint has not moved yet: the encoder reads no motion */
    const friction_feedforward_input input = rates(1.0f * degree, 0.0f, 0.0f);
    const float torque_nm = friction_feedforward_step(&state, &params, &input, dt_s);
    CHECK_SAME("torque of the seal at the rate commanded", lugre_step(&seal, &params.lugre, 1.0f * degree, dt_s),
               torque_nm);
    if (tick == 0) {
      /* Half a tick of spring and the bristles' damping: more than Ts already. */
      CHECK_AT_LEAST("torque in the first tick", 14.0, torque_nm);
    }
    if (tick == 299) {
      CHECK_RELATIVE("torque when sliding", lugre_steady_nm(&params.lugre, 1.0f * degree), torque_nm, 1e-4);
    }
  }
}

static void test_a_slow_start_reaches_the_breakaway_torque_when_the_seal_would(void) {
  const friction_feedforward_params params = example(FRICTION_LUGRE);
  friction_feedforward_state state;
  friction_feedforward_reset(&state);
  const friction_feedforward_input input = rates(0.1f * degree, 0.0f, 0.0f);
  float torque_nm = friction_feedforward_step(&state, &params, &input, dt_s);
  /* 0.1 deg/s is 1.745e-3 rad/s: (s0 dt/2 + s1 + s2) v */
  CHECK_RELATIVE("first tick", (35.0 + 900.0 + 11.9) * 1.745e-3, torque_nm, 0.01);
  for (int tick = 1; tick < 1000; ++tick) {
    torque_nm = friction_feedforward_step(&state, &params, &input, dt_s);
  }
  CHECK_RELATIVE("sliding", lugre_steady_nm(&params.lugre, 0.1f * degree), torque_nm, 1e-4);
}

static void test_a_reversal_changes_the_torque_at_once_although_the_joint_still_coasts(void) {
  const friction_feedforward_params params = example(FRICTION_LUGRE);
  friction_feedforward_state state;
  friction_feedforward_reset(&state);
  friction_feedforward_input input = rates(1.0f * degree, 0.0f, 1.0f * degree);
  float before_nm = 0.0f;
  for (int tick = 0; tick < 200; ++tick) {
    before_nm = friction_feedforward_step(&state, &params, &input, dt_s);
  }
  input.reference_rad_s = -1.0f * degree; /* the joint keeps its old direction for a while */
  const float first_nm = friction_feedforward_step(&state, &params, &input, dt_s);
  CHECK_AT_MOST("change of torque in the first tick", -10.0, first_nm - before_nm);
  float torque_nm = first_nm;
  for (int tick = 0; tick < 30; ++tick) { /* 30 ms at 17 mrad/s: twice the bristles' length */
    torque_nm = friction_feedforward_step(&state, &params, &input, dt_s);
  }
  CHECK_AT_MOST("torque after 30 ms", -8.0, torque_nm);
}

static void test_encoder_noise_at_standstill_makes_no_torque_noise_at_all(void) {
  const friction_model models[] = {FRICTION_COULOMB, FRICTION_STEADY, FRICTION_LUGRE};
  random_source source = {11};
  for (int i = 0; i < 3; ++i) {
    const friction_feedforward_params params = example(models[i]);
    friction_feedforward_state state;
    friction_feedforward_reset(&state);
    friction_feedforward_input input = rates(0.002f, 0.0f, 0.002f);
    for (int tick = 0; tick < 100; ++tick) {
      (void)friction_feedforward_step(&state, &params, &input, dt_s);
    }
    input = rates(0.0f, 0.0f, 0.0f);
    const float held_nm = friction_feedforward_step(&state, &params, &input, dt_s);
    for (int tick = 0; tick < 5000; ++tick) {
      input.joint_rate_rad_s = 6e-3f * (float)random_normal(&source); /* sigma: a plain difference at 20 bits */
      CHECK_SAME("torque", held_nm, friction_feedforward_step(&state, &params, &input, dt_s));
    }
  }
}

static void test_gyro_noise_at_standstill_is_held_down_by_the_bristles(void) {
  /* The base rate is the one noisy rate that reaches the model. 20 urad/s of it (0.001 deg/s) is what a fibre-optic
   * gyro leaves after fusion. A plain sign(v) would jump between +-Tc = 10 Nm. */
  const friction_feedforward_params params = example(FRICTION_LUGRE);
  random_source source = {12};
  friction_feedforward_state state;
  friction_feedforward_reset(&state);
  double sum = 0.0;
  double largest = 0.0;
  float previous_nm = 0.0f;
  const int ticks = 20000;
  for (int tick = 0; tick < ticks; ++tick) {
    const float base_rad_s = 20e-6f * (float)random_normal(&source);
    const friction_feedforward_input input = rates(0.0f, base_rad_s, 0.0f);
    const float torque_nm = friction_feedforward_step(&state, &params, &input, dt_s);
    const double jump_nm = (double)(torque_nm - previous_nm);
    previous_nm = torque_nm;
    sum += jump_nm * jump_nm;
    largest = fmax(largest, fabs((double)torque_nm));
  }
  LOG_VALUE("rms jump of torque from tick to tick, Nm", sqrt(sum / ticks));
  LOG_VALUE("largest torque, Nm", largest);
  /* (s1 + s2 + s0 dt/2) sigma sqrt(2) = 27 mNm; the sum of the noise over the ticks wanders within a fraction of Tc. */
  CHECK_AT_MOST("rms jump", 0.03, sqrt(sum / ticks));
  CHECK_AT_MOST("largest torque", 1.0, largest);
}

static void test_a_blocked_axis_lets_the_model_run_ahead_by_the_lead_limit_only(void) {
  friction_feedforward_params params = example(FRICTION_LUGRE);
  params.lead_limit_rad_s = 1e-3f;
  const friction_feedforward_input ahead = rates(0.5f, 0.0f, 0.0f);
  const friction_feedforward_input behind = rates(-0.5f, 0.0f, 0.0f);
  const friction_feedforward_input pushed = rates(0.0f, 0.0f, 0.2f);
  const friction_feedforward_input within = rates(0.2005f, 0.0f, 0.2f);
  CHECK_NEAR("ahead", 1e-3, friction_feedforward_rate(&params, &ahead), 1e-9);
  CHECK_NEAR("behind", -1e-3, friction_feedforward_rate(&params, &behind), 1e-9);
  CHECK_NEAR("pushed by hand", 0.199, friction_feedforward_rate(&params, &pushed), 1e-7);
  CHECK_NEAR("within the limit", 0.2005, friction_feedforward_rate(&params, &within), 1e-7);

  friction_feedforward_state state;
  friction_feedforward_reset(&state);
  float torque_nm = 0.0f;
  for (int tick = 0; tick < 3000; ++tick) {
    torque_nm = friction_feedforward_step(&state, &params, &ahead, dt_s);
  }
  CHECK_RELATIVE("torque against the block", lugre_steady_nm(&params.lugre, 1e-3f), torque_nm, 1e-4);
}

static void test_on_a_moving_base_the_seal_feels_the_joint_rate(void) {
  const friction_feedforward_params params = example(FRICTION_STEADY);
  /* The axis is at rest in space, the base turns forward under it: the joint turns backward. */
  const friction_feedforward_input held = rates(0.0f, 0.02f, -0.02f);
  CHECK_NEAR("rate", -0.02, friction_feedforward_rate(&params, &held), 1e-9);
  friction_feedforward_state state;
  friction_feedforward_reset(&state);
  CHECK_RELATIVE("torque", lugre_steady_nm(&params.lugre, -0.02f),
                 friction_feedforward_step(&state, &params, &held, dt_s), 1e-6);
  /* It moves with the base: nothing turns in the seal. */
  const friction_feedforward_input carried = rates(0.02f, 0.02f, 0.0f);
  CHECK_SAME("torque", 0.0, friction_feedforward_step(&state, &params, &carried, dt_s));
}

static void test_the_gain_blends_every_model(void) {
  const friction_model models[] = {FRICTION_COULOMB, FRICTION_STEADY, FRICTION_LUGRE};
  const float gains[] = {0.0f, 0.5f, 1.5f};
  for (int m = 0; m < 3; ++m) {
    friction_feedforward_params whole = example(models[m]);
    friction_feedforward_state reference;
    friction_feedforward_reset(&reference);
    const friction_feedforward_input input = rates(0.004f, 0.0f, 0.003f);
    const float whole_nm = friction_feedforward_step(&reference, &whole, &input, dt_s);
    CHECK_AT_LEAST("whole torque", 1.0, whole_nm);
    for (int g = 0; g < 3; ++g) {
      friction_feedforward_params blended = whole;
      blended.gain = gains[g];
      friction_feedforward_state state;
      friction_feedforward_reset(&state);
      CHECK_SAME("share", gains[g] * whole_nm, friction_feedforward_step(&state, &blended, &input, dt_s));
    }
  }
}

static void test_no_model_gives_no_torque(void) {
  const friction_feedforward_params params = example(FRICTION_NONE);
  friction_feedforward_state state;
  friction_feedforward_reset(&state);
  const friction_feedforward_input input = rates(1.0f, 0.0f, 1.0f);
  CHECK_SAME("torque", 0.0, friction_feedforward_step(&state, &params, &input, dt_s));
}

static void test_the_cheap_models_follow_their_formulas_in_each_direction(void) {
  const friction_feedforward_params coulomb = example(FRICTION_COULOMB);
  const friction_feedforward_params steady = example(FRICTION_STEADY);
  const double speeds_rad_s[] = {-0.5, -0.02, -2e-3, -1e-3, -4e-4, 0.0, 2e-4, 1e-3, 5e-3, 0.3};
  for (int i = 0; i < 10; ++i) {
    const double v = speeds_rad_s[i];
    const double tc = v < 0.0 ? 8.5 : 10.0;
    const double ts = v < 0.0 ? 13.0 : 14.0;
    const double vs = v < 0.0 ? 0.004 : 0.003;
    const double viscous = v < 0.0 ? 10.5 : 11.9;
    const double sign = fmin(fmax(v / 1e-3, -1.0), 1.0);
    const double stribeck = tc + (ts - tc) * exp(-(v / vs) * (v / vs));
    friction_feedforward_state state;
    friction_feedforward_reset(&state);
    const friction_feedforward_input input = rates((float)v, 0.0f, (float)v);
    CHECK_NEAR("Coulomb", tc * sign + viscous * v, friction_feedforward_step(&state, &coulomb, &input, dt_s), 2e-5);
    CHECK_NEAR("eq. (5)", stribeck * sign + viscous * v, friction_feedforward_step(&state, &steady, &input, dt_s),
               2e-5);
  }
}

static void test_reset_forgets_the_bristles(void) {
  const friction_feedforward_params params = example(FRICTION_LUGRE);
  friction_feedforward_state state;
  friction_feedforward_reset(&state);
  const friction_feedforward_input moving = rates(0.01f, 0.0f, 0.01f);
  const friction_feedforward_input still = rates(0.0f, 0.0f, 0.0f);
  (void)friction_feedforward_step(&state, &params, &moving, dt_s);
  CHECK_AT_LEAST("held", 0.1, friction_feedforward_step(&state, &params, &still, dt_s));
  friction_feedforward_reset(&state);
  CHECK_SAME("after reset", 0.0, friction_feedforward_step(&state, &params, &still, dt_s));
}

static void test_check_refuses_each_value_by_itself(void) {
  friction_feedforward_params params = example(FRICTION_LUGRE);
  CHECK_STATUS(CONTROL_OK, friction_feedforward_check(&params));
  params.model = (friction_model)4;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, friction_feedforward_check(&params));
  params.model = (friction_model)-1;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, friction_feedforward_check(&params));
  params.model = FRICTION_NONE;
  CHECK_STATUS(CONTROL_OK, friction_feedforward_check(&params));
  float *const values[] = {&params.gain, &params.lead_limit_rad_s, &params.sign_width_rad_s};
  const float bad[][2] = {{-0.01f, 1.51f}, {0.9e-6f, 101.0f}, {0.9e-6f, 1.01f}};
  for (int i = 0; i < 3; ++i) {
    const float good = *values[i];
    *values[i] = NAN;
    CHECK_STATUS(CONTROL_NOT_FINITE, friction_feedforward_check(&params));
    *values[i] = bad[i][0];
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, friction_feedforward_check(&params));
    *values[i] = bad[i][1];
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, friction_feedforward_check(&params));
    *values[i] = good;
  }
  params.lugre.positive.breakaway_nm = 1.0f; /* the seal's own check is called */
  CHECK_STATUS(CONTROL_INCONSISTENT, friction_feedforward_check(&params));
}

static void test_other_parameters_keep_the_torque_that_the_bristles_hold(void) {
  const friction_feedforward_params from = example(FRICTION_LUGRE);
  friction_feedforward_params stiffer = from;
  stiffer.lugre.stiffness_nm_rad *= 4.0f;
  friction_feedforward_state state = {.lugre = {1e-4f}};
  friction_feedforward_retune(&state, &from, &stiffer, 0.02f);
  CHECK_RELATIVE("deflection, rad", 0.25e-4, state.lugre.deflection_rad, 1e-6);
}

static void test_bristles_that_were_not_modelled_start_as_sliding_leaves_them(void) {
  const friction_model before[] = {FRICTION_NONE, FRICTION_COULOMB, FRICTION_STEADY};
  const friction_feedforward_params to = example(FRICTION_LUGRE);
  const float sliding_rad_s[] = {1.0f * degree, -1.0f * degree};
  for (int m = 0; m < 3; ++m) {
    const friction_feedforward_params from = example(before[m]);
    for (int i = 0; i < 2; ++i) {
      friction_feedforward_state state = {.lugre = {5.0f}};
      friction_feedforward_retune(&state, &from, &to, sliding_rad_s[i]);
      const friction_feedforward_input input = rates(sliding_rad_s[i], 0.0f, sliding_rad_s[i]);
      const float torque_nm = friction_feedforward_step(&state, &to, &input, dt_s);
      CHECK_RELATIVE("torque in the first tick, Nm", lugre_steady_nm(&to.lugre, sliding_rad_s[i]), torque_nm, 1e-5);
    }
    friction_feedforward_state slow = {.lugre = {5.0f}};
    friction_feedforward_retune(&slow, &from, &to, 0.5f * to.lugre.positive.stribeck_speed_rad_s);
    CHECK_SAME("too slow to know the direction: relaxed", 0.0, slow.lugre.deflection_rad);
    /* 3 mrad/s forward, 4 mrad/s backward: each direction has its own Stribeck speed. */
    friction_feedforward_state backward = {.lugre = {5.0f}};
    friction_feedforward_retune(&backward, &from, &to, -3.5e-3f);
    CHECK_SAME("too slow backward: relaxed", 0.0, backward.lugre.deflection_rad);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_startup_is_compensated_in_the_tick_in_which_it_is_commanded);
  RUN_TEST(test_a_slow_start_reaches_the_breakaway_torque_when_the_seal_would);
  RUN_TEST(test_a_reversal_changes_the_torque_at_once_although_the_joint_still_coasts);
  RUN_TEST(test_encoder_noise_at_standstill_makes_no_torque_noise_at_all);
  RUN_TEST(test_gyro_noise_at_standstill_is_held_down_by_the_bristles);
  RUN_TEST(test_a_blocked_axis_lets_the_model_run_ahead_by_the_lead_limit_only);
  RUN_TEST(test_on_a_moving_base_the_seal_feels_the_joint_rate);
  RUN_TEST(test_the_gain_blends_every_model);
  RUN_TEST(test_no_model_gives_no_torque);
  RUN_TEST(test_the_cheap_models_follow_their_formulas_in_each_direction);
  RUN_TEST(test_reset_forgets_the_bristles);
  RUN_TEST(test_check_refuses_each_value_by_itself);
  RUN_TEST(test_other_parameters_keep_the_torque_that_the_bristles_hold);
  RUN_TEST(test_bristles_that_were_not_modelled_start_as_sliding_leaves_them);
  return UNITY_END();
}
