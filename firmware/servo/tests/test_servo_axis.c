/* SPDX-License-Identifier: Apache-2.0 */
/* The servo axis: torque mode, limits and torque offset from outside, and its reaction to implausible inputs. */
#include "servo/servo_axis.h"

#include <string.h>

#include "servo/servo_timing.h"
#include "support/check.h"
#include "support/random.h"
#include "support/servo_bench.h"

void setUp(void) {}
void tearDown(void) {}

static void test_torque_mode_gives_the_requested_torque_within_the_limits(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command){.mode = SERVO_TORQUE, .torque_nm = 3.0f};
  ticks(&b, 100);
  CHECK_SAME("torque, Nm", 3.0, b.axis.commanded_nm);
  CHECK_NEAR("rate, rad/s", 3.0 / 20.0 * 0.1, b.rate_rad_s, 1e-6);
  TEST_ASSERT_FALSE(b.axis.signals.torque.limited);
  b.command.torque_nm = -80.0f;
  tick(&b);
  CHECK_SAME("at the current limit, Nm", -50.0, b.axis.commanded_nm);
  TEST_ASSERT_TRUE(b.axis.signals.torque.limited);
  b.command.torque_nm = 80.0f;
  tick(&b);
  CHECK_SAME("at the current limit, Nm", 50.0, b.axis.commanded_nm);
  TEST_ASSERT_TRUE(b.axis.signals.torque.limited);
  b.command.torque_nm = -80.0f;
  b.command.torque_limited = true;
  b.command.limits = (torque_limits){-7.0f, 9.0f};
  tick(&b);
  CHECK_SAME("at the limit from outside, Nm", -7.0, b.axis.commanded_nm);
  b.command.limits = (torque_limits){5.0f, -5.0f}; /* implausible: no torque at all, not a reversed one */
  tick(&b);
  CHECK_SAME("torque, Nm", 0.0, b.axis.commanded_nm);
}

/* Whatever the gains, the filters and the limits from outside are. */
static void test_a_protective_stop_gives_exactly_its_torque_within_the_current_limit(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command){.mode = SERVO_SPEED, .speed = {.rate_rad_s = 5.0f}, .torque_nm = 8.0f};
  tick(&b);
  TEST_ASSERT_TRUE(b.axis.signals.torque.limited);
  b.command = (servo_axis_command){.mode = SERVO_PROTECTIVE_STOP,
                                   .torque_nm = -30.0f,
                                   .torque_limited = true,
                                   .limits = {-1.0f, 1.0f},
                                   .speed = {.rate_rad_s = 5.0f}};
  b.params.speed.pi.proportional_gain = 0.0f;
  ticks(&b, 3);
  CHECK_SAME("torque, Nm", -30.0, b.axis.commanded_nm);
  CHECK_SAME("current, A", (double)(-30.0f / b.params.torque_constant_nm_a), b.axis.current_reference_a);
  CHECK_SAME("from outside, Nm", 0.0, b.axis.added_nm); /* nothing of the loop before it is left */
  TEST_ASSERT_FALSE(b.axis.signals.torque.limited);
  b.command.torque_nm = 1e6f;
  tick(&b);
  CHECK_SAME("torque, Nm", 50.0, b.axis.commanded_nm);
  TEST_ASSERT_TRUE(servo_mode_drives(b.axis.mode));
  TEST_ASSERT_FALSE(servo_mode_closes(b.axis.mode));
  b.command = (servo_axis_command){.mode = SERVO_SPEED}; /* closes the loop anew */
  tick(&b);
  CHECK_NEAR("torque, Nm", 0.0, b.axis.commanded_nm, 10.0);
}

static void test_a_speed_loop_takes_over_from_torque_mode_without_a_step(void) {
  bench b = bench_at_rest();
  b.load_nm = 6.0;
  b.rate_rad_s = 0.2;
  b.command = (servo_axis_command){.mode = SERVO_TORQUE, .torque_nm = 6.0f};
  ticks(&b, 500);
  CHECK_NEAR("rate, rad/s", 0.2, b.rate_rad_s, 1e-6);
  b.worst_step_nm = 0.0;
  b.command.mode = SERVO_SPEED;
  b.command.torque_nm = 0.0f;
  b.command.speed.rate_rad_s = b.axis.signals.rates.rate_rad_s;
  ticks(&b, 200);
  LOG_VALUE("largest step of the torque, Nm of 6", b.worst_step_nm);
  CHECK_AT_MOST("largest step of the torque, Nm", 0.05, b.worst_step_nm);
  CHECK_NEAR("torque, Nm", 6.0, b.axis.commanded_nm, 0.05);
}

/* No plausible input makes it; a flipped bit in the RAM can. */
static void test_a_state_that_is_no_number_switches_the_axis_off(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command){.mode = SERVO_SPEED, .speed = {.rate_rad_s = 0.1f}};
  ticks(&b, 100);
  b.axis.speed.pi.integral = NAN;
  servo_axis_tick(&b.axis, &b.params, &b.command, &b.samples, dt_s);
  TEST_ASSERT_EQUAL_INT(SERVO_OFF, b.axis.mode);
  TEST_ASSERT_TRUE(b.axis.implausible);
  CHECK_SAME("torque, Nm", 0.0, b.axis.commanded_nm);
  CHECK_SAME("current, A", 0.0, b.axis.current_reference_a);
}

static void test_other_gains_beside_a_torque_offset_make_no_step(void) {
  bench b = bench_at_rest();
  b.load_nm = 12.0;
  b.command = (servo_axis_command){.mode = SERVO_SPEED, .speed = {.rate_rad_s = 0.1f}, .torque_nm = 8.0f};
  ticks(&b, 2000);
  servo_axis_params next = b.params;
  next.speed.pi.proportional_gain = 900.0f;
  next.speed.pi.integral_gain = 9000.0f;
  next.speed.observer.bandwidth_rad_s = 120.0f;
  b.worst_step_nm = 0.0;
  servo_axis_retune(&b.axis, &b.params, &next, dt_s);
  ticks(&b, 5);
  CHECK_AT_MOST("largest step of the torque, Nm of 12", 0.1, b.worst_step_nm);
  b.command.speed.rate_rad_s = 0.11f; /* 9 Nm more, at first */
  tick(&b);
  bench same = b;
  next.speed.pi.proportional_gain = 1200.0f;
  servo_axis_retune(&b.axis, &b.params, &next, dt_s);
  tick(&b);
  tick(&same);
  CHECK_NEAR("torque with the old gain, Nm", (double)same.axis.commanded_nm, b.axis.commanded_nm, 0.5);
}

static void test_speed_and_position_loops_keep_the_torque_limits_from_outside(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command){
      .mode = SERVO_SPEED, .speed = {.rate_rad_s = 0.5f}, .torque_limited = true, .limits = {-2.0f, 4.0f}};
  ticks(&b, 300);
  CHECK_SAME("torque, Nm", 4.0, b.axis.commanded_nm);
  TEST_ASSERT_TRUE(b.axis.signals.torque.limited);
  b.command.mode = SERVO_OFF;
  ticks(&b, 1);
  TEST_ASSERT_FALSE(b.axis.signals.torque.limited);
  CHECK_SAME("shown while off, Nm", 0.0, b.axis.signals.torque.torque_nm);
  b.command.mode = SERVO_POSITION;
  b.command.position = (angle_turn32)-200000000;
  b.command.speed.rate_rad_s = 0.0f;
  ticks(&b, 50);
  CHECK_SAME("torque, Nm", -2.0, b.axis.commanded_nm);
}

/* 5 rad/s in either direction are far more than the motor can: it gives all that it may, the offset with it. */
static void test_a_torque_offset_takes_nothing_from_the_limits(void) {
  for (int side = -1; side <= 1; side += 2) {
    for (int limited = 0; limited <= 1; ++limited) {
      bench b = bench_at_rest();
      b.command = (servo_axis_command){.mode = SERVO_SPEED,
                                       .speed = {.rate_rad_s = 5.0f * (float)side},
                                       .torque_nm = 8.0f,
                                       .torque_limited = limited != 0,
                                       .limits = {-20.0f, 30.0f}};
      ticks(&b, 3);
      const double within_nm = side < 0 ? -20.0 : 30.0;
      CHECK_SAME("torque, Nm", limited != 0 ? within_nm : side * 50.0, b.axis.commanded_nm);
    }
  }
}

/* Then what is added to it cannot act. */
static void test_a_torque_offset_beyond_the_limits_is_told(void) {
  for (int side = -1; side <= 1; side += 2) {
    bench b = bench_at_rest();
    b.params.speed.pi.proportional_gain = 0.0f;
    b.params.speed.pi.integral_gain = 0.0f;
    b.params.speed.observer_on = false;
    b.command = (servo_axis_command){.mode = SERVO_SPEED, .torque_nm = 49.0f * (float)side};
    tick(&b);
    TEST_ASSERT_FALSE(b.axis.signals.torque.limited);
    b.command.torque_nm = 51.0f * (float)side;
    tick(&b);
    TEST_ASSERT_TRUE(b.axis.signals.torque.limited);
  }
}

static void test_a_torque_offset_carries_a_load_and_is_counted_once(void) {
  bench b = bench_at_rest();
  b.load_nm = 8.0;
  b.command = (servo_axis_command){.mode = SERVO_SPEED, .torque_nm = 8.0f};
  double worst_rad_s = 0.0;
  for (int i = 0; i < 1000; ++i) {
    tick(&b);
    worst_rad_s = fmax(worst_rad_s, fabs(b.rate_rad_s));
  }
  LOG_VALUE("largest rate with the load fed forward, rad/s", worst_rad_s);
  CHECK_AT_MOST("rate, rad/s", 1e-5, worst_rad_s);
  CHECK_NEAR("torque, Nm", 8.0, b.axis.commanded_nm, 0.01);
  CHECK_NEAR("load that the observer still sees, Nm", 0.0, b.axis.signals.torque.disturbance_nm, 0.01);
}

/* Of a jump by 1 mrad/s, in percent, with gains of little damping (0.3). */
static double overshoot(float model_rad_s) {
  bench b = bench_at_rest();
  b.params.speed.pi.proportional_gain = 360.0f;
  b.params.speed.pi.integral_gain = 18000.0f;
  b.params.speed.observer_on = false;
  CHECK_STATUS(CONTROL_OK, setpoint_model_design(&b.params.speed.setpoint_model, model_rad_s, dt_s));
  b.command = (servo_axis_command){.mode = SERVO_SPEED, .speed = {.rate_rad_s = 1e-3f}};
  double highest_rad_s = 0.0;
  for (int i = 0; i < 500; ++i) {
    tick(&b);
    highest_rad_s = fmax(highest_rad_s, b.rate_rad_s);
  }
  CHECK_NEAR("rate, rad/s", 1e-3, b.rate_rad_s, 2e-5);
  return 100.0 * (highest_rad_s / 1e-3 - 1.0);
}

static void test_with_a_setpoint_model_a_jump_hardly_overshoots_whatever_the_gains(void) {
  CHECK_AT_LEAST("overshoot without a model, %", 30.0, overshoot(0.0f));
  CHECK_AT_MOST("overshoot with a model, %", 4.0, overshoot(400.0f));
}

static void test_the_setpoint_model_begins_at_the_rate_at_which_the_loop_is_closed(void) {
  bench b = bench_at_rest();
  CHECK_STATUS(CONTROL_OK, setpoint_model_design(&b.params.speed.setpoint_model, 400.0f, dt_s));
  b.rate_rad_s = 0.01;
  ticks(&b, 5);
  b.command = (servo_axis_command){.mode = SERVO_SPEED};
  tick(&b);
  CHECK_NEAR("set-point, rad/s", 0.01, b.axis.signals.reference.rate_rad_s, 1e-5);
  b.command.mode = SERVO_TORQUE;
  b.rate_rad_s = 0.02;
  ticks(&b, 5);
  b.command.mode = SERVO_SPEED;
  tick(&b);
  CHECK_NEAR("set-point after a torque mode, rad/s", 0.02, b.axis.signals.reference.rate_rad_s, 1e-3);
  ticks(&b, 100);
  CHECK_NEAR("set-point, rad/s", 0.0, b.axis.signals.reference.rate_rad_s, 1e-9);
}

static void test_position_mode_passes_the_acceleration_on(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command){.mode = SERVO_POSITION, .speed = {.acceleration_rad_s2 = 0.1f}};
  tick(&b);
  CHECK_NEAR("torque of the acceleration, Nm", 2.0, b.axis.signals.torque.acceleration_nm, 1e-6);
}

/* The pitch has moved, and the azimuth has less inertia there; the gyro's share is the same. */
static void test_a_pose_with_three_quarters_of_the_inertia_gets_three_quarters_of_the_torque(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command){.mode = SERVO_SPEED, .speed = {.acceleration_rad_s2 = 0.1f}};
  tick(&b);
  CHECK_NEAR("torque of the acceleration, Nm", 2.0, b.axis.signals.torque.acceleration_nm, 1e-6);
  b.axis.pose.inertia_share = 0.75f;
  tick(&b);
  CHECK_NEAR("torque of the acceleration, Nm", 1.5, b.axis.signals.torque.acceleration_nm, 1e-6);
}

/* A gyro on the line of sight, while the pitch moves: it measures the share of the azimuth's rate that its axis has. */
static void test_a_gyro_that_measures_a_share_of_the_rate_shows_the_rate(void) {
  bench b = bench_at_rest();
  b.params.speed.rate_fusion.source = RATE_FROM_GYRO;
  const servo_axis_samples samples = {.sensors = {.gyro_valid = true, .gyro_rad_s = 0.05f}};
  const float shares[] = {1.0f, 0.5f, 0.8f};
  for (unsigned i = 0; i < sizeof shares / sizeof *shares; ++i) {
    b.axis.pose.gyro_share = shares[i];
    servo_axis_tick(&b.axis, &b.params, &b.command, &samples, dt_s);
    CHECK_NEAR("rate, rad/s", 0.05 / (double)shares[i], b.axis.signals.rates.rate_rad_s, 1e-6);
  }
}

static void test_a_loop_that_is_closed_again_knows_nothing_of_before(void) {
  bench used = bench_at_rest();
  used.load_nm = 20.0;
  used.command = (servo_axis_command){.mode = SERVO_SPEED, .speed = {.rate_rad_s = 0.3f}};
  ticks(&used, 400);
  TEST_ASSERT_TRUE(fabsf(used.axis.speed.pi.integral) > 0.1f);
  used.command.mode = SERVO_OFF;
  tick(&used);
  used.rate_rad_s = used.load_nm = 0.0;
  ticks(&used, 10);
  bench fresh = bench_at_rest();
  servo_axis_reset(&fresh.axis, &fresh.params, used.samples.sensors.joint_angle_turn32, dt_s);
  fresh.turns = used.turns;
  fresh.command = used.command = (servo_axis_command){.mode = SERVO_SPEED};
  for (int i = 0; i < 50; ++i) {
    tick(&used);
    tick(&fresh);
    CHECK_SAME("torque, Nm", fresh.axis.commanded_nm, used.axis.commanded_nm);
  }
}

/* It drifts in the wind; its set-point is its actual rate. */
static void test_closing_the_loop_on_a_turning_axis_gives_no_kick(void) {
  for (int fused = 0; fused <= 1; ++fused) {
    bench b = bench_at_rest();
    b.params.speed.rate_fusion.source = fused ? RATE_FUSED : RATE_FROM_ENCODER;
    b.params.speed.pi.setpoint_weight = fused ? 0.8f : 1.0f;
    b.rate_rad_s = -0.03;
    b.command = (servo_axis_command){.mode = SERVO_OFF};
    double worst_nm = 0.0;
    for (int i = 0; i < 400; ++i) {
      b.samples.sensors.gyro_valid = true;
      b.samples.sensors.gyro_rad_s = (float)b.rate_rad_s;
      b.command.mode = i < 100 ? SERVO_OFF : SERVO_SPEED;
      b.command.speed.rate_rad_s = -0.03f;
      tick(&b);
      worst_nm = fmax(worst_nm, fabs((double)b.axis.commanded_nm));
    }
    LOG_VALUE("largest torque, Nm", worst_nm);
    CHECK_AT_MOST("largest torque, Nm", 0.05, worst_nm);
  }
}

static void test_the_observer_counts_what_a_limited_motor_gives_not_what_was_requested(void) {
  bench b = bench_at_rest();
  b.motor_limit_nm = 5.0;
  b.command = (servo_axis_command){.mode = SERVO_SPEED, .speed = {.rate_rad_s = 1.0f}};
  double worst_nm = 0.0;
  for (int i = 0; i < 500; ++i) {
    tick(&b);
    worst_nm = fmax(worst_nm, fabs((double)b.axis.speed.observer.estimate_nm));
  }
  LOG_VALUE("largest load seen where there is none, Nm", worst_nm);
  CHECK_AT_MOST("load seen, Nm", 0.5, worst_nm);
}

/* --- nonsense --- */

typedef struct {
  const char *what;
  servo_axis_command command;
  servo_axis_samples samples;
} nonsense;

static servo_axis_samples gyro_at(float rate_rad_s) {
  return (servo_axis_samples){.sensors = {.gyro_rad_s = rate_rad_s, .gyro_valid = true}};
}

#define AT_SPEED                                        \
  {                                                     \
    .mode = SERVO_SPEED, .speed = {.rate_rad_s = 0.1f } \
  }

static const nonsense every_nonsense[] = {
    {.what = "rate NaN", .command = {.mode = SERVO_SPEED, .speed = {.rate_rad_s = NAN}}},
    {.what = "rate 1e35", .command = {.mode = SERVO_SPEED, .speed = {.rate_rad_s = 1e35f}}},
    {.what = "rate beyond", .command = {.mode = SERVO_SPEED, .speed = {.rate_rad_s = -1001.0f}}},
    {.what = "acceleration NaN", .command = {.mode = SERVO_SPEED, .speed = {.acceleration_rad_s2 = NAN}}},
    {.what = "acceleration 1e38", .command = {.mode = SERVO_SPEED, .speed = {.acceleration_rad_s2 = 1e38f}}},
    {.what = "torque NaN", .command = {.mode = SERVO_TORQUE, .torque_nm = NAN}},
    {.what = "torque 1e38", .command = {.mode = SERVO_SPEED, .torque_nm = 1e38f}},
    {.what = "limit infinite", .command = {.mode = SERVO_SPEED, .torque_limited = true, .limits = {-1.0f, INFINITY}}},
    {.what = "limit NaN", .command = {.mode = SERVO_SPEED, .torque_limited = true, .limits = {NAN, 1.0f}}},
    {.what = "rate limit NaN", .command = {.mode = SERVO_POSITION, .rate_limit_rad_s = NAN}},
    {.what = "rate limit negative", .command = {.mode = SERVO_POSITION, .rate_limit_rad_s = -1.0f}},
    {.what = "mode unknown", .command = {.mode = (servo_mode)(SERVO_PROTECTIVE_STOP + 1)}},
    {.what = "mode negative", .command = {.mode = (servo_mode)-1}},
    {.what = "current NaN", .command = AT_SPEED, .samples = {.sensors = {.mean_current_a = NAN}}},
    {.what = "current 1e38", .command = AT_SPEED, .samples = {.sensors = {.mean_current_a = -1e38f}}},
    {.what = "gyro NaN", .command = AT_SPEED, .samples = {.sensors = {.gyro_rad_s = NAN, .gyro_valid = true}}},
    {.what = "gyro infinite",
     .command = AT_SPEED,
     .samples = {.sensors = {.gyro_rad_s = -INFINITY, .gyro_valid = true}}},
    {.what = "gyro 1e38", .command = AT_SPEED, .samples = {.sensors = {.gyro_rad_s = 1e38f, .gyro_valid = true}}},
};

static bench turning_with_gyro(void) {
  bench b = bench_at_rest();
  b.params.speed.rate_fusion.source = RATE_FUSED;
  b.command = (servo_axis_command)AT_SPEED;
  for (int i = 0; i < 300; ++i) {
    b.samples.sensors = gyro_at((float)b.rate_rad_s).sensors;
    tick(&b);
  }
  return b;
}

static void test_one_tick_of_nonsense_takes_the_torque_away_and_leaves_nothing_behind(void) {
  for (unsigned i = 0; i < sizeof every_nonsense / sizeof every_nonsense[0]; ++i) {
    bench b = turning_with_gyro();
    servo_axis_samples samples = every_nonsense[i].samples;
    samples.sensors.joint_angle_turn32 = b.samples.sensors.joint_angle_turn32;
    servo_axis_tick(&b.axis, &b.params, &every_nonsense[i].command, &samples, dt_s);
    TEST_ASSERT_EQUAL_INT_MESSAGE(SERVO_OFF, b.axis.mode, every_nonsense[i].what);
    TEST_ASSERT_TRUE_MESSAGE(b.axis.implausible, every_nonsense[i].what);
    CHECK_SAME("torque", 0.0, b.axis.commanded_nm);
    CHECK_SAME("current", 0.0, b.axis.current_reference_a);
    for (int t = 0; t < 1000; ++t) {
      b.samples.sensors = gyro_at((float)b.rate_rad_s).sensors;
      tick(&b);
    }
    CHECK_NEAR(every_nonsense[i].what, 0.1, b.rate_rad_s, 1e-3);
  }
}

static void test_an_encoder_that_jumps_takes_the_torque_away_in_the_same_tick(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command)AT_SPEED;
  ticks(&b, 300);
  b.turns += 0.4;
  tick(&b);
  TEST_ASSERT_EQUAL_INT(SERVO_OFF, b.axis.mode);
  TEST_ASSERT_TRUE(b.axis.implausible);
  CHECK_SAME("torque", 0.0, b.axis.commanded_nm);
  b.worst_step_nm = 0.0;
  ticks(&b, 1000); /* continues from the present encoder angle */
  CHECK_NEAR("rate, rad/s", 0.1, b.rate_rad_s, 1e-3);
}

static void test_an_encoder_without_an_answer_takes_the_torque_away_until_it_answers(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command){.mode = SERVO_TORQUE, .torque_nm = 2.0f};
  ticks(&b, 10);
  CHECK_SAME("torque, Nm", 2.0, b.axis.commanded_nm);
  servo_axis_samples samples = b.samples;
  samples.sensors.encoder_failed = true;
  servo_axis_tick(&b.axis, &b.params, &b.command, &samples, dt_s);
  CHECK_SAME("torque without an encoder, Nm", 0.0, b.axis.commanded_nm);
  TEST_ASSERT_EQUAL(SERVO_OFF, b.axis.mode);
  TEST_ASSERT_TRUE(b.axis.implausible);
  tick(&b);
  TEST_ASSERT_FALSE(b.axis.implausible);
  CHECK_SAME("torque with it again, Nm", 2.0, b.axis.commanded_nm);
}

static void test_the_position_loop_asks_for_no_more_than_the_commands_rate_limit(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command){.mode = SERVO_POSITION, .position = 400000000u, .rate_limit_rad_s = 0.05f};
  tick(&b);
  CHECK_SAME("set-point, rad/s", 0.05f, b.axis.signals.reference.rate_rad_s);
  b.command.position = (angle_turn32)-400000000;
  tick(&b);
  CHECK_SAME("set-point, rad/s", -0.05f, b.axis.signals.reference.rate_rad_s);
  b.command.rate_limit_rad_s = 0.0f;
  tick(&b);
  CHECK_AT_LEAST("without it, rad/s", 0.5, fabsf(b.axis.signals.reference.rate_rad_s));
}

/* The base turns with 0.05 rad/s, as its own gyros say. What is held is the angle of the joint. */
static void test_a_position_is_held_on_a_base_that_turns(void) {
  bench b = bench_at_rest();
  b.axis.speed.carried_rad_s = 0.05f;
  b.command = (servo_axis_command){.mode = SERVO_POSITION};
  ticks(&b, 1000);
  CHECK_NEAR("rate with the base's, rad/s", 0.05, b.axis.signals.rates.rate_rad_s, 1e-5);
  CHECK_AT_MOST("joint, rad", 1e-6, fabs(b.turns * 6.283185307179586));
}

static void test_a_gyro_in_an_unknown_place_is_refused(void) {
  servo_axis_params params = bench_at_rest().params;
  params.tracker.estimator_rad_s = 4.0f;
  const gyro_mounting unknown[] = {(gyro_mounting)-1, (gyro_mounting)(GYRO_BELOW_JOINT + 1)};
  for (int i = 0; i < 2; ++i) {
    params.gyro = GYRO_BELOW_JOINT;
    CHECK_STATUS(CONTROL_OK, servo_axis_check(&params, dt_s, SERVO_PWM_PERIOD_S));
    params.gyro = unknown[i];
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, servo_axis_check(&params, dt_s, SERVO_PWM_PERIOD_S));
  }
}

static void test_a_gyro_that_says_it_is_not_valid_may_hold_anything(void) {
  bench b = turning_with_gyro();
  for (int i = 0; i < 300; ++i) {
    b.samples.sensors.gyro_rad_s = NAN;
    b.samples.sensors.gyro_valid = false;
    tick(&b);
  }
  TEST_ASSERT_FALSE(b.axis.implausible);
  CHECK_NEAR("rate, rad/s", 0.1, b.rate_rad_s, 1e-3);
}

static void test_a_sum_that_is_not_a_number_takes_the_torque_away(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command)AT_SPEED;
  ticks(&b, 300);
  b.axis.speed.pi.integral = NAN; /* with an unknown mode */
  tick(&b);
  TEST_ASSERT_EQUAL_INT(SERVO_OFF, b.axis.mode);
  TEST_ASSERT_TRUE(b.axis.implausible);
  CHECK_SAME("torque", 0.0, b.axis.commanded_nm);
  ticks(&b, 1000);
  CHECK_NEAR("rate, rad/s", 0.1, b.rate_rad_s, 1e-3);
}

/* Arbitrary bits, or a number at the edge of the plausible range, each with equal probability. */
static float any_float(random_source *source) {
  const float edges[] = {SERVO_PLAUSIBLE_RATE_RAD_S, SERVO_PLAUSIBLE_ACCELERATION_RAD_S2, SERVO_PLAUSIBLE_TORQUE_NM,
                         SERVO_PLAUSIBLE_CURRENT_A, 0.0f};
  const uint64_t bits = random_bits(source);
  if ((bits & 1) == 0) {
    return ((bits & 2) == 0 ? 1.0f : -1.0f) * edges[(bits >> 8) % 5];
  }
  const uint32_t word = (uint32_t)(bits >> 32);
  float value;
  memcpy(&value, &word, sizeof value);
  return value;
}

static void test_no_input_whatever_makes_a_torque_or_a_current_beyond_its_limit(void) {
  random_source source = {17};
  bench b = bench_at_rest();
  b.params.speed.rate_fusion.source = RATE_FUSED;
  int closed = 0;
  for (int i = 0; i < 200000; ++i) {
    const servo_axis_command command = {
        .mode = (servo_mode)(random_bits(&source) % 6),
        .speed = {any_float(&source), any_float(&source)},
        .position = (angle_turn32)random_bits(&source),
        .torque_nm = any_float(&source),
        .torque_limited = random_bits(&source) % 2 == 0,
        .limits = {any_float(&source), any_float(&source)},
    };
    const servo_axis_samples samples = {
        .sensors = {.joint_angle_turn32 = (uint32_t)random_bits(&source),
                    .gyro_valid = random_bits(&source) % 2 == 0,
                    .gyro_rad_s = any_float(&source),
                    .mean_current_a = any_float(&source)},
    };
    servo_axis_tick(&b.axis, &b.params, &command, &samples, dt_s);
    CHECK_AT_MOST("torque, Nm", 50.0, fabsf(b.axis.commanded_nm));
    CHECK_AT_MOST("current, A", 20.0, fabsf(b.axis.current_reference_a));
    closed += b.axis.mode != SERVO_OFF;
  }
  LOG_VALUE("ticks with a loop closed, of 200000", closed);
  TEST_ASSERT_TRUE(closed > 1000);
  b.samples = (servo_axis_samples){0};
  b.command = (servo_axis_command){.mode = SERVO_OFF};
  tick(&b);
  b.command = (servo_axis_command)AT_SPEED;
  b.params.speed.rate_fusion.source = RATE_FROM_ENCODER;
  ticks(&b, 1000);
  CHECK_NEAR("rate afterwards, rad/s", 0.1, b.rate_rad_s, 1e-3);
}

static void test_other_parameters_begin_nothing_while_the_loops_are_open(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command){.mode = SERVO_OFF};
  ticks(&b, 5);
  const speed_loop_state before = b.axis.speed;
  const servo_axis_params next = b.params;
  servo_axis_replace(&b.axis, &b.params, &next, 4.0f, dt_s);
  CHECK_SAME("integral, Nm", before.pi.integral, b.axis.speed.pi.integral);
  b.command = (servo_axis_command){.mode = SERVO_SPEED};
  tick(&b);
  servo_axis_replace(&b.axis, &b.params, &next, 4.0f, dt_s);
  CHECK_SAME("integral of a closed loop, Nm", 4.0, b.axis.speed.pi.integral);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_torque_mode_gives_the_requested_torque_within_the_limits);
  RUN_TEST(test_a_protective_stop_gives_exactly_its_torque_within_the_current_limit);
  RUN_TEST(test_a_speed_loop_takes_over_from_torque_mode_without_a_step);
  RUN_TEST(test_a_state_that_is_no_number_switches_the_axis_off);
  RUN_TEST(test_other_gains_beside_a_torque_offset_make_no_step);
  RUN_TEST(test_speed_and_position_loops_keep_the_torque_limits_from_outside);
  RUN_TEST(test_a_torque_offset_takes_nothing_from_the_limits);
  RUN_TEST(test_a_torque_offset_beyond_the_limits_is_told);
  RUN_TEST(test_a_torque_offset_carries_a_load_and_is_counted_once);
  RUN_TEST(test_with_a_setpoint_model_a_jump_hardly_overshoots_whatever_the_gains);
  RUN_TEST(test_the_setpoint_model_begins_at_the_rate_at_which_the_loop_is_closed);
  RUN_TEST(test_position_mode_passes_the_acceleration_on);
  RUN_TEST(test_a_pose_with_three_quarters_of_the_inertia_gets_three_quarters_of_the_torque);
  RUN_TEST(test_a_gyro_that_measures_a_share_of_the_rate_shows_the_rate);
  RUN_TEST(test_a_loop_that_is_closed_again_knows_nothing_of_before);
  RUN_TEST(test_closing_the_loop_on_a_turning_axis_gives_no_kick);
  RUN_TEST(test_the_observer_counts_what_a_limited_motor_gives_not_what_was_requested);
  RUN_TEST(test_one_tick_of_nonsense_takes_the_torque_away_and_leaves_nothing_behind);
  RUN_TEST(test_an_encoder_that_jumps_takes_the_torque_away_in_the_same_tick);
  RUN_TEST(test_an_encoder_without_an_answer_takes_the_torque_away_until_it_answers);
  RUN_TEST(test_the_position_loop_asks_for_no_more_than_the_commands_rate_limit);
  RUN_TEST(test_a_position_is_held_on_a_base_that_turns);
  RUN_TEST(test_a_gyro_in_an_unknown_place_is_refused);
  RUN_TEST(test_a_gyro_that_says_it_is_not_valid_may_hold_anything);
  RUN_TEST(test_a_sum_that_is_not_a_number_takes_the_torque_away);
  RUN_TEST(test_no_input_whatever_makes_a_torque_or_a_current_beyond_its_limit);
  RUN_TEST(test_other_parameters_begin_nothing_while_the_loops_are_open);
  return UNITY_END();
}
