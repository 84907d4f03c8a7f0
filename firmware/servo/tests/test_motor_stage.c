/* SPDX-License-Identifier: Apache-2.0 */
/* The motor stage: the hand-over between tick and PWM periods, and the duty of each period. */
#include "servo/motor_stage.h"

#include <string.h>

#include "servo/servo_axis.h"
#include "support/check.h"
#include "support/random.h"

enum { LATENCY = SERVO_TICK_LATENCY_PERIODS };

void setUp(void) {}
void tearDown(void) {}

static motor_command command_of(float current_a) {
  motor_command command = {.setpoint = {.on = true, .current_a = current_a}};
  TEST_ASSERT_EQUAL(CONTROL_OK, current_loop_design(&command.params, 1.2f, 3e-3f, 2.5f, 6283.0f, SERVO_PWM_PERIOD_S));
  return command;
}

static void hand_over(motor_stage *stage, const motor_command *command) {
  motor_stage_hand_over(stage, command->setpoint, &command->params);
}

/* A stage that follows this command from period LATENCY on. */
static void start(motor_stage *stage, const motor_command *command) {
  motor_stage_reset(stage);
  hand_over(stage, command);
}

static void test_a_new_stage_gives_no_duty(void) {
  motor_stage stage;
  motor_stage_reset(&stage);
  CHECK_SAME("duty", 0.0, motor_stage_step(&stage, 5, 1.0f, 48.0f));
}

static void test_the_voltage_of_a_tick_is_the_mean_of_its_periods_also_of_the_first_ones(void) {
  motor_stage stage;
  const motor_command command = command_of(2.0f);
  memset(&stage, 0x5A, sizeof stage);
  start(&stage, &command);
  uint32_t period = 12; /* the stage begins within a tick */
  for (int tick = 0; tick < 3; ++tick) {
    double sum_v = 0.0;
    int count = 0;
    for (; period < 20; ++period) {
      sum_v += (double)stage.state.voltage_v;
      ++count;
      (void)motor_stage_step(&stage, period, 0.5f, 48.0f);
    }
    motor_stage ended = stage;
    (void)motor_stage_step(&ended, 0, 0.75f, 48.0f);
    CHECK_NEAR("V", sum_v / count, atomic_load(&ended.tick_voltage_v), 1e-5);
    CHECK_SAME("A", 0.75, atomic_load(&ended.tick_current_a));
    period = 0;
  }
}

static void test_a_command_counts_from_the_third_period_on(void) {
  motor_stage stage;
  const motor_command command = command_of(1.0f);
  start(&stage, &command);
  CHECK_SAME("duty in period 0", 0.0, motor_stage_step(&stage, 0, 0.0f, 48.0f));
  CHECK_SAME("duty in period 1", 0.0, motor_stage_step(&stage, 1, 0.0f, 48.0f));
  TEST_ASSERT_TRUE(motor_stage_step(&stage, 2, 0.0f, 48.0f) > 0.0f);
}

static void test_a_command_that_is_late_is_taken_as_soon_as_it_is_there(void) {
  motor_stage stage;
  motor_stage_reset(&stage);
  const motor_command command = command_of(-1.0f);
  CHECK_SAME("duty in period 2", 0.0, motor_stage_step(&stage, 2, 0.0f, 48.0f));
  hand_over(&stage, &command);
  TEST_ASSERT_TRUE(motor_stage_step(&stage, 3, 0.0f, 48.0f) < 0.0f);
}

/* Two stages with one command in force; one gets another command and must not show it before period LATENCY. */
static void expect_unchanged_before_its_period(const motor_command *first, const motor_command *second) {
  motor_stage stage, alone;
  start(&stage, first);
  start(&alone, first);
  (void)motor_stage_step(&stage, LATENCY, 0.0f, 48.0f);
  (void)motor_stage_step(&alone, LATENCY, 0.0f, 48.0f);
  hand_over(&stage, second);
  for (uint32_t period = 0; period < LATENCY; ++period) {
    CHECK_SAME("duty", motor_stage_step(&alone, 3, 0.1f, 48.0f), motor_stage_step(&stage, period, 0.1f, 48.0f));
  }
  const float duty = motor_stage_step(&alone, 3, 0.1f, 48.0f);
  TEST_ASSERT_TRUE(motor_stage_step(&stage, LATENCY, 0.1f, 48.0f) != duty);
}

static void test_set_point_mode_and_gains_change_together_and_not_before_their_period(void) {
  const motor_command first = command_of(1.0f);
  const motor_command second = command_of(-9.0f);
  expect_unchanged_before_its_period(&first, &second);
  motor_command soft = first;
  soft.params.pi.proportional_gain *= 0.5f;
  expect_unchanged_before_its_period(&first, &soft);
  motor_command off = first;
  off.setpoint.on = false;
  expect_unchanged_before_its_period(&first, &off);
}

static void test_of_two_commands_before_their_period_the_second_counts(void) {
  motor_stage stage;
  const motor_command first = command_of(5.0f);
  const motor_command second = command_of(-5.0f);
  start(&stage, &first);
  hand_over(&stage, &second);
  TEST_ASSERT_TRUE(motor_stage_step(&stage, LATENCY, 0.0f, 48.0f) < 0.0f);
}

static void test_off_is_duty_0_and_forgets_the_integral(void) {
  motor_stage stage;
  const motor_command on = command_of(5.0f);
  motor_command off = on;
  off.setpoint.on = false;
  start(&stage, &on);
  const float first = motor_stage_step(&stage, LATENCY, 0.0f, 48.0f);
  for (int i = 0; i < 50; ++i) {
    (void)motor_stage_step(&stage, 3, 0.0f, 48.0f);
  }
  hand_over(&stage, &off);
  CHECK_SAME("duty when off", 0.0, motor_stage_step(&stage, LATENCY, 0.0f, 48.0f));
  CHECK_SAME("V when off", 0.0, stage.state.voltage_v);
  hand_over(&stage, &on);
  CHECK_SAME("duty when on again", first, motor_stage_step(&stage, LATENCY, 0.0f, 48.0f));
}

static void test_it_reports_the_voltage_and_that_the_bus_could_not_give_it(void) {
  motor_stage stage;
  const motor_command command = command_of(16.0f);
  start(&stage, &command);
  (void)motor_stage_step(&stage, LATENCY, 0.0f, 12.0f);
  TEST_ASSERT_TRUE(stage.limited);
  CHECK_NEAR("V", 0.98 * 12.0, stage.state.voltage_v, 1e-5);
  motor_stage_reset(&stage);
  TEST_ASSERT_FALSE(stage.limited);
  CHECK_SAME("V", 0.0, stage.state.voltage_v);
}

/* The voltage that a period computes is applied in the next one; period 0 closes the tick. */
static void test_it_reports_the_mean_voltage_of_a_tick_and_the_current_at_its_end(void) {
  motor_stage stage;
  const motor_command command = command_of(0.2f);
  start(&stage, &command);
  CHECK_SAME("V at first", 0.0, stage.tick_voltage_v);
  double sum_v = 0.0;
  for (uint32_t period = 0; period < SERVO_PWM_PER_TICK; ++period) {
    sum_v += (double)stage.state.voltage_v;
    (void)motor_stage_step(&stage, period, 0.1f, 48.0f);
  }
  (void)motor_stage_step(&stage, 0, 0.3f, 48.0f);
  CHECK_NEAR("V", sum_v / SERVO_PWM_PER_TICK, stage.tick_voltage_v, 1e-6);
  TEST_ASSERT_TRUE(stage.tick_voltage_v > 1.0f);
  CHECK_SAME("A", 0.3f, stage.tick_current_a);
  motor_stage_reset(&stage);
  CHECK_SAME("V after a reset", 0.0, stage.tick_voltage_v);
  CHECK_SAME("A after a reset", 0.0, stage.tick_current_a);
}

static void test_the_duty_carries_the_back_emf_of_a_turning_motor(void) {
  motor_stage stage;
  motor_command command = command_of(0.0f);
  command.setpoint.joint_rate_rad_s = 0.4f;
  start(&stage, &command);
  CHECK_NEAR("duty", 2.5 * 0.4 / 50.0, motor_stage_step(&stage, LATENCY, 0.0f, 50.0f), 1e-6);
}

static void test_an_implausible_current_or_voltage_gives_no_duty_and_leaves_nothing_behind(void) {
  const float bad[][2] = {{NAN, 48.0f}, {INFINITY, 48.0f}, {-1e38f, 48.0f}, {1.01e5f, 48.0f},
                          {1.0f, NAN},  {1.0f, INFINITY},  {1.0f, 1e38f},   {1.0f, -1e38f}};
  const motor_command command = command_of(1.0f);
  for (unsigned i = 0; i < sizeof bad / sizeof bad[0]; ++i) {
    motor_stage stage, untouched;
    start(&stage, &command);
    start(&untouched, &command);
    CHECK_SAME("duty", 0.0, motor_stage_step(&stage, LATENCY, bad[i][0], bad[i][1]));
    const float duty = motor_stage_step(&stage, 3, 0.5f, 48.0f);
    CHECK_SAME("next duty", motor_stage_step(&untouched, 3, 0.5f, 48.0f), duty);
    TEST_ASSERT_TRUE(duty > 0.0f);
  }
}

static float any_float(random_source *source) {
  const uint32_t word = (uint32_t)random_bits(source);
  float value;
  memcpy(&value, &word, sizeof value);
  return value;
}

static void test_no_sample_whatever_makes_a_duty_beyond_its_limit(void) {
  random_source source = {23};
  motor_stage stage;
  const motor_command command = command_of(3.0f);
  start(&stage, &command);
  for (int i = 0; i < 100000; ++i) {
    CHECK_AT_MOST("duty", 0.98f, fabsf(motor_stage_step(&stage, LATENCY, any_float(&source), any_float(&source))));
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_new_stage_gives_no_duty);
  RUN_TEST(test_the_voltage_of_a_tick_is_the_mean_of_its_periods_also_of_the_first_ones);
  RUN_TEST(test_a_command_counts_from_the_third_period_on);
  RUN_TEST(test_a_command_that_is_late_is_taken_as_soon_as_it_is_there);
  RUN_TEST(test_set_point_mode_and_gains_change_together_and_not_before_their_period);
  RUN_TEST(test_of_two_commands_before_their_period_the_second_counts);
  RUN_TEST(test_off_is_duty_0_and_forgets_the_integral);
  RUN_TEST(test_it_reports_the_voltage_and_that_the_bus_could_not_give_it);
  RUN_TEST(test_it_reports_the_mean_voltage_of_a_tick_and_the_current_at_its_end);
  RUN_TEST(test_the_duty_carries_the_back_emf_of_a_turning_motor);
  RUN_TEST(test_an_implausible_current_or_voltage_gives_no_duty_and_leaves_nothing_behind);
  RUN_TEST(test_no_sample_whatever_makes_a_duty_beyond_its_limit);
  return UNITY_END();
}
