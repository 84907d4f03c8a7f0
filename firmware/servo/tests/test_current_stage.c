/* The hand-over between the tick and the current loop's interrupt. */
#include "servo/current_stage.h"

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

static servo_current_command command_of(float reference_a) {
  servo_current_command command = {.on = true, .reference_a = reference_a};
  TEST_ASSERT_EQUAL(CONTROL_OK, current_loop_design(&command.params, 1.2f, 3e-3f, 2.5f, 6283.0f, SERVO_PWM_PERIOD_S));
  return command;
}

static void test_a_new_stage_gives_no_duty(void) {
  current_stage stage;
  current_stage_reset(&stage);
  CHECK_SAME("duty", 0.0, current_stage_step(&stage, 5, 1.0f, 48.0f));
}

static void test_a_command_counts_from_the_third_period_on(void) {
  current_stage stage;
  current_stage_reset(&stage);
  const servo_current_command command = command_of(1.0f);
  current_stage_hand_over(&stage, &command);
  CHECK_SAME("duty in period 0", 0.0, current_stage_step(&stage, 0, 0.0f, 48.0f));
  CHECK_SAME("duty in period 1", 0.0, current_stage_step(&stage, 1, 0.0f, 48.0f));
  TEST_ASSERT_TRUE(current_stage_step(&stage, 2, 0.0f, 48.0f) > 0.0f);
}

static void test_a_command_that_is_late_is_taken_as_soon_as_it_is_there(void) {
  current_stage stage;
  current_stage_reset(&stage);
  const servo_current_command command = command_of(-1.0f);
  CHECK_SAME("duty in period 2", 0.0, current_stage_step(&stage, 2, 0.0f, 48.0f));
  current_stage_hand_over(&stage, &command);
  TEST_ASSERT_TRUE(current_stage_step(&stage, 3, 0.0f, 48.0f) < 0.0f);
}

static void test_what_the_tick_prepares_does_not_disturb_what_is_in_force(void) {
  current_stage stage, alone;
  current_stage_reset(&stage);
  current_stage_reset(&alone);
  const servo_current_command first = command_of(1.0f);
  const servo_current_command second = command_of(-9.0f);
  current_stage_hand_over(&stage, &first);
  current_stage_hand_over(&alone, &first);
  (void)current_stage_step(&stage, 2, 0.0f, 48.0f);
  (void)current_stage_step(&alone, 2, 0.0f, 48.0f);
  current_stage_hand_over(&stage, &second);
  for (uint32_t period = 0; period < SERVO_TICK_LATENCY_PERIODS; ++period) {
    CHECK_SAME("duty", current_stage_step(&alone, 3, 0.1f, 48.0f), current_stage_step(&stage, period, 0.1f, 48.0f));
  }
  TEST_ASSERT_TRUE(current_stage_step(&stage, 2, 0.1f, 48.0f) < 0.0f);
}

static void test_off_is_duty_0_and_forgets_the_integral(void) {
  current_stage stage;
  current_stage_reset(&stage);
  const servo_current_command on = command_of(5.0f);
  servo_current_command off = on;
  off.on = false;
  current_stage_hand_over(&stage, &on);
  const float first = current_stage_step(&stage, 2, 0.0f, 48.0f);
  for (int i = 0; i < 50; ++i) {
    (void)current_stage_step(&stage, 3, 0.0f, 48.0f);
  }
  current_stage_hand_over(&stage, &off);
  CHECK_SAME("duty when off", 0.0, current_stage_step(&stage, 2, 0.0f, 48.0f));
  current_stage_hand_over(&stage, &on);
  CHECK_SAME("duty when on again", first, current_stage_step(&stage, 2, 0.0f, 48.0f));
}

static void test_limited_reports_that_the_bus_could_not_give_the_voltage(void) {
  current_stage stage;
  current_stage_reset(&stage);
  const servo_current_command command = command_of(16.0f);
  current_stage_hand_over(&stage, &command);
  (void)current_stage_step(&stage, 2, 0.0f, 12.0f);
  TEST_ASSERT_TRUE(stage.limited);
  current_stage_reset(&stage);
  TEST_ASSERT_FALSE(stage.limited);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_new_stage_gives_no_duty);
  RUN_TEST(test_a_command_counts_from_the_third_period_on);
  RUN_TEST(test_a_command_that_is_late_is_taken_as_soon_as_it_is_there);
  RUN_TEST(test_what_the_tick_prepares_does_not_disturb_what_is_in_force);
  RUN_TEST(test_off_is_duty_0_and_forgets_the_integral);
  RUN_TEST(test_limited_reports_that_the_bus_could_not_give_the_voltage);
  return UNITY_END();
}
