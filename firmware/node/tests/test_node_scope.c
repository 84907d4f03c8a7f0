/* SPDX-License-Identifier: Apache-2.0 */
/* The scope over the bus: set up by 0x3000, read as the DOMAIN 0x3001. */
#include "support/node_bench.h"

#include "node/scope_signals.h"
#include "support/check.h"

enum { SCOPE = 0x3000, COMMAND = 1, STATE = 2, DIVIDER = 3, PRETRIGGER = 4, TRIGGER = 5, CHANNEL = 6, LEVEL = 7 };
enum { FRAMES = 8, CHANNELS = 9, FIRST_SIGNAL = 10, ARM = 1, STOP = 2, FORCE = 3 };
enum { HEADER = SCOPE_HEADER_BYTES + SCOPE_CHANNEL_BYTES, MAX_BYTES = 33000 };

static uint8_t stream[MAX_BYTES];

void setUp(void) { node_bench_start(); }
void tearDown(void) {}

/* Segmented upload of 0x3001; its length. */
static uint32_t read_stream(void) {
  const uint8_t *answer = ask((const uint8_t[]){0x40, 0x01, 0x30, 0, 0, 0, 0, 0});
  TEST_ASSERT_EQUAL_HEX8(0x41, answer[0]);
  const uint32_t size = u32_of(&answer[4]);
  TEST_ASSERT_TRUE(size <= MAX_BYTES);
  uint32_t got = 0;
  for (uint8_t toggle = 0; got < size; toggle ^= 0x10) {
    answer = ask((const uint8_t[]){(uint8_t)(0x60 | toggle), 0, 0, 0, 0, 0, 0, 0});
    const uint32_t length = 7u - (answer[0] >> 1 & 7u);
    TEST_ASSERT_EQUAL_HEX8(toggle, answer[0] & 0xF0);
    memcpy(&stream[got], &answer[1], length);
    got += length;
    TEST_ASSERT_EQUAL(got == size, answer[0] & 1);
  }
  return size;
}

static float sample(uint32_t frame) {
  const uint32_t bits = u32_of(&stream[HEADER + 4 * frame]);
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

/* One channel. */
static void record(uint32_t signal) {
  SET(SCOPE, CHANNELS, 1);
  SET(SCOPE, FIRST_SIGNAL, signal);
  SET(SCOPE, COMMAND, ARM);
}

/* Driven by the test through the machine or the node itself. */
static void test_every_signal_is_where_its_name_says(void) {
  static const char *const names[] = {".reference_rad_s", ".feedback_rad_s",      ".rate_rad_s", ".joint_rate_rad_s",
                                      ".base_rate_rad_s", ".torque_nm",           ".pi_nm",      ".disturbance_nm",
                                      ".friction_nm",     ".current_reference_a", ".current_a",  ".gyro_rad_s"};
  for (uint32_t axis = 0; axis < SERVO_AXES; ++axis) {
    servo_axis *servo = &node.board.app.axis[axis];
    servo_axis_samples *samples = &node.board.samples.axis[axis];
    const float *const places[] = {&servo->signals.reference.rate_rad_s,  &servo->signals.rates.feedback_rad_s,
                                   &servo->signals.rates.rate_rad_s,      &servo->signals.rates.joint_rate_rad_s,
                                   &servo->signals.rates.base_rate_rad_s, &servo->signals.torque.torque_nm,
                                   &servo->signals.torque.pi_nm,          &servo->signals.torque.disturbance_nm,
                                   &servo->signals.torque.friction_nm,    &servo->current_reference_a,
                                   &samples->sensors.mean_current_a,      &samples->sensors.gyro_rad_s};
    for (uint32_t i = 0; i < SCOPE_SIGNALS_PER_AXIS; ++i) {
      const uint32_t signal = axis * SCOPE_SIGNALS_PER_AXIS + i + 1;
      od_object object;
      TEST_ASSERT_EQUAL(OD_OK, od_find(servo_node_dictionary(&node), 0x3002, (uint8_t)signal, &object));
      char name[40] = {0};
      strcat(strcpy(name, axis == 0 ? "azimuth" : "pitch"), names[i]);
      TEST_ASSERT_EQUAL_STRING(name, od_get(&object).text);
      TEST_ASSERT_EQUAL_PTR(places[i], (const char *)&node + scope_signal_offset(signal));
    }
  }
}

static void test_a_capture_holds_what_the_axis_did(void) {
  enable(0, 3);
  SET(0x60FF, 0, 100000);
  SET(SCOPE, DIVIDER, 10);
  record(4); /* joint rate */
  wait_ms(300);
  SET(SCOPE, COMMAND, STOP);
  TEST_ASSERT_EQUAL(4, get(SCOPE, STATE));
  const uint32_t frames = get(SCOPE, FRAMES);
  TEST_ASSERT_TRUE(frames >= 30 && frames <= 31);
  TEST_ASSERT_EQUAL(HEADER + 4 * frames, read_stream());
  TEST_ASSERT_EQUAL_MEMORY("TSSC", stream, 4);
  TEST_ASSERT_EQUAL(1, u32_of(&stream[12])); /* channels */
  TEST_ASSERT_EQUAL(frames, u32_of(&stream[16]));
  TEST_ASSERT_EQUAL(10, u32_of(&stream[24])); /* ticks between frames */
  TEST_ASSERT_EQUAL(4, u32_of(&stream[SCOPE_HEADER_BYTES]));
  for (uint32_t i = 1; i < frames; ++i) {
    TEST_ASSERT_TRUE_MESSAGE(sample(i) >= sample(i - 1) - 1e-3f, "the axis does not speed up");
  }
  CHECK_NEAR("rad/s at the end", 0.1, sample(frames - 1), 0.001);
}

static void test_it_waits_for_its_trigger_and_keeps_what_was_before(void) {
  enable(PITCH, 3);
  SET(SCOPE, TRIGGER, SCOPE_RISING);
  SET_FLOAT(SCOPE, LEVEL, 0.05f);
  SET(SCOPE, PRETRIGGER, 20);
  record(16); /* pitch's joint rate */
  wait_ms(100);
  TEST_ASSERT_EQUAL(SCOPE_WAITING, get(SCOPE, STATE));
  SET(0x60FF + PITCH, 0, 100000);
  wait_ms(200);
  TEST_ASSERT_EQUAL(SCOPE_TRIGGERED, get(SCOPE, STATE));
  SET(SCOPE, COMMAND, STOP);
  (void)read_stream();
  const uint32_t trigger = u32_of(&stream[20]);
  TEST_ASSERT_TRUE(trigger >= 20);
  TEST_ASSERT_TRUE(sample(trigger) > 0.05f);
  TEST_ASSERT_TRUE(sample(trigger - 1) <= 0.05f);
}

static void test_a_fault_is_a_trigger(void) {
  SET(SCOPE, TRIGGER, SCOPE_FAULT);
  SET(SCOPE, PRETRIGGER, 5);
  record(1);
  wait_ms(50);
  machine.axis[1].health = HAL_TOO_HOT;
  wait_ms(3);
  TEST_ASSERT_EQUAL(SCOPE_TRIGGERED, get(SCOPE, STATE));
}

static void test_a_change_of_state_is_a_trigger(void) {
  SET(SCOPE, TRIGGER, SCOPE_STATE_CHANGE);
  record(1);
  wait_ms(50);
  TEST_ASSERT_EQUAL(SCOPE_WAITING, get(SCOPE, STATE));
  command(PITCH, 0x06);
  TEST_ASSERT_EQUAL(SCOPE_TRIGGERED, get(SCOPE, STATE));
}

static void test_it_can_be_triggered_by_hand(void) {
  SET(SCOPE, TRIGGER, SCOPE_ABOVE);
  SET_FLOAT(SCOPE, LEVEL, 1e6f);
  record(1);
  wait_ms(20);
  TEST_ASSERT_EQUAL(SCOPE_WAITING, get(SCOPE, STATE));
  SET(SCOPE, COMMAND, FORCE);
  wait_ms(2);
  TEST_ASSERT_EQUAL(SCOPE_TRIGGERED, get(SCOPE, STATE));
  SET(SCOPE, COMMAND, 0); /* nothing */
  TEST_ASSERT_EQUAL(SCOPE_TRIGGERED, get(SCOPE, STATE));
}

static void test_what_does_not_fit_is_refused_and_changes_nothing(void) {
  SET(SCOPE, CHANNELS, 2);
  SET(SCOPE, TRIGGER, SCOPE_ABOVE);
  SET(SCOPE, CHANNEL, 2); /* the third of two */
  TEST_ASSERT_EQUAL_HEX32(0x06040043, set(SCOPE, COMMAND, ARM));
  TEST_ASSERT_EQUAL(SCOPE_IDLE, get(SCOPE, STATE));
  SET(SCOPE, CHANNEL, 1);
  SET(SCOPE, PRETRIGGER, 4096);
  TEST_ASSERT_EQUAL_HEX32(0x06040043, set(SCOPE, COMMAND, ARM));
  SET(SCOPE, PRETRIGGER, 4000);
  SET(SCOPE, COMMAND, ARM);
  TEST_ASSERT_EQUAL(SCOPE_FILLING, get(SCOPE, STATE));
  TEST_ASSERT_EQUAL_HEX32(0x06090031, set(SCOPE, FIRST_SIGNAL, 25));
}

static void test_there_is_nothing_to_read_before_a_capture_is_done(void) {
  const uint8_t request[8] = {0x40, 0x01, 0x30};
  TEST_ASSERT_EQUAL_HEX32(0x08000024, u32_of(&ask(request)[4]));
  record(1);
  TEST_ASSERT_EQUAL_HEX32(0x08000024, u32_of(&ask(request)[4]));
}

static void test_a_capture_that_begins_anew_ends_the_reading_of_the_last_one(void) {
  record(1);
  wait_ms(20);
  SET(SCOPE, COMMAND, STOP);
  (void)ask((const uint8_t[]){0x40, 0x01, 0x30, 0, 0, 0, 0, 0});
  node.scope_setup.command = 0;
  const scope_config config = node.recorder.config;
  TEST_ASSERT_EQUAL(SCOPE_OK, scope_arm(&node.recorder, &config, 1e-3f));
  const uint8_t *answer = ask((const uint8_t[]){0x60, 0, 0, 0, 0, 0, 0, 0});
  TEST_ASSERT_EQUAL_HEX8(0x80, answer[0]);
  TEST_ASSERT_EQUAL_HEX32(0x08000024, u32_of(&answer[4]));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_every_signal_is_where_its_name_says);
  RUN_TEST(test_a_capture_holds_what_the_axis_did);
  RUN_TEST(test_it_waits_for_its_trigger_and_keeps_what_was_before);
  RUN_TEST(test_a_fault_is_a_trigger);
  RUN_TEST(test_a_change_of_state_is_a_trigger);
  RUN_TEST(test_it_can_be_triggered_by_hand);
  RUN_TEST(test_what_does_not_fit_is_refused_and_changes_nothing);
  RUN_TEST(test_there_is_nothing_to_read_before_a_capture_is_done);
  RUN_TEST(test_a_capture_that_begins_anew_ends_the_reading_of_the_last_one);
  return UNITY_END();
}
