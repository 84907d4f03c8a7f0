/* SPDX-License-Identifier: Apache-2.0 */
/* The node's record of faults (0x3020), and the lock of the protection limits (0x3040, 0x2055, 0x2060). */
#include "node/servo_node_parts.h"
#include "support/node_bench.h"

#include "support/check.h"

enum { PROTECTION = 0x2060, OVERSPEED = 1, TRAVEL_MINIMUM = 9, TRAVEL_MAXIMUM, UNDER_VOLTAGE = 15, OVER_VOLTAGE };
enum { BOARD = 0x3060, STOPPING_MARGIN = 17, WAITING, MOTOR = 0x2055, CURRENT_LIMIT = 6, SOFT_TRAVEL = 0x607D };
enum { LOG = 0x3020, LOG_COUNT = 1, LOG_COMMAND, NEWEST, ACCESS = 0x3040, WORD = 1, LEFT_S, PP = 1, PV = 3, CST = 10 };
enum { HEADER = 8, SAMPLE = (int)sizeof(fault_log_sample), EMCY = 0x080 + NODE_ID };

enum { HOME_OFFSET = 0x607C, CLIENT_B = 0x6A0, DELAY_S = 6, PARAMETER_SET = 0x2070, GAINS = 0x2000, SCALES = 0x3060 };

#define OPEN 0x6E65706Fu
#define BAD_VALUE 0x06090030u
#define LOAD_WORD 0x64616F6Cu
#define DEVICE_STATE 0x08000022u
#define NO_DATA 0x08000024u

static uint8_t entry[HEADER + FAULT_LOG_TICKS * SAMPLE];

void setUp(void) { node_bench_start(); }
void tearDown(void) {}

/* Segmented upload; its length, or 0 when there is no such entry. */
static uint32_t read_entry(uint8_t sub) {
  const uint8_t *answer = ask((const uint8_t[]){0x40, 0x20, 0x30, sub, 0, 0, 0, 0});
  if (answer[0] == 0x80) {
    TEST_ASSERT_EQUAL_HEX32(NO_DATA, u32_of(&answer[4]));
    return 0;
  }
  const uint32_t size = u32_of(&answer[4]);
  TEST_ASSERT_TRUE(size <= sizeof entry);
  uint32_t got = 0;
  for (uint8_t toggle = 0; got < size; toggle ^= 0x10) {
    answer = ask((const uint8_t[]){(uint8_t)(0x60 | toggle), 0, 0, 0, 0, 0, 0, 0});
    const uint32_t length = 7u - (answer[0] >> 1 & 7u);
    memcpy(&entry[got], &answer[1], length);
    got += length;
  }
  return size;
}

static fault_log_sample sample(uint32_t n) {
  fault_log_sample s;
  memcpy(&s, &entry[HEADER + n * (uint32_t)SAMPLE], sizeof s);
  return s;
}

/* --- the lock
 * ------------------------------------------------------------------------------------------------------- */

static void test_limits_are_written_only_while_the_lock_is_open(void) {
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_float(PROTECTION, OVERSPEED, 2.0f));
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_float(MOTOR, CURRENT_LIMIT, 20.0f));
  TEST_ASSERT_EQUAL(0, get(ACCESS, LEFT_S) & 0xFFFF);
  SET(ACCESS, WORD, OPEN);
  TEST_ASSERT_EQUAL(60, get(ACCESS, LEFT_S) & 0xFFFF);
  SET_FLOAT(PROTECTION, OVERSPEED, 2.0f);
  SET_FLOAT(MOTOR, CURRENT_LIMIT, 20.0f);
  CHECK_SAME("rad/s", 2.0, get_float(PROTECTION, OVERSPEED));
  SET(ACCESS, WORD, 0);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_float(PROTECTION, OVERSPEED, 3.0f));
  SET(ACCESS, WORD, OPEN);
  TEST_ASSERT_EQUAL_HEX32(BAD_VALUE, set(ACCESS, WORD, OPEN + 1));
  TEST_ASSERT_EQUAL(1, get(ACCESS, DELAY_S) & 0xFFFF);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_float(PROTECTION, OVERSPEED, 3.0f));
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(ACCESS, WORD, OPEN));
  wait_ms(1000);
  SET(ACCESS, WORD, OPEN);
  SET(ACCESS, WORD, 0);
  CHECK_SAME("rad/s", 2.0, get_float(PROTECTION, OVERSPEED));
  CHECK_SAME("the other axis", 1.5, get_float(PROTECTION + PITCH, OVERSPEED));
}

/* The second channel, 1201: a write with the object's size; the abort code, or 0. */
static uint32_t set_by_b(uint32_t index, uint8_t sub, uint32_t value) {
  sent_count = 0;
  give(CLIENT_B, 8,
       (const uint8_t[]){0x22, (uint8_t)index, (uint8_t)(index >> 8), sub, (uint8_t)value, (uint8_t)(value >> 8),
                         (uint8_t)(value >> 16), (uint8_t)(value >> 24)});
  wait_ms(1);
  const can_frame *answer = last_sent(CLIENT_B + 1);
  TEST_ASSERT_NOT_NULL(answer);
  return answer->data[0] == 0x80 ? u32_of(&answer->data[4]) : 0;
}

static void open_second_channel(void) {
  SET(0x1201, 1, CLIENT_B);
  SET(0x1201, 2, CLIENT_B + 1);
}

static uint32_t bits_of(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits;
}

static void test_the_lock_is_open_only_for_the_channel_that_opened_it(void) {
  open_second_channel();
  SET(ACCESS, WORD, OPEN);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_by_b(PROTECTION, OVERSPEED, bits_of(2.0f)));
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_by_b(MOTOR, CURRENT_LIMIT, bits_of(20.0f)));
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_by_b(SCALES, 1, bits_of(20.0f)));
  TEST_ASSERT_EQUAL_HEX32(0, set_by_b(ACCESS, WORD, 0)); /* locks its own */
  SET_FLOAT(PROTECTION, OVERSPEED, 2.0f);
  SET(ACCESS, WORD, 0);
  TEST_ASSERT_EQUAL_HEX32(0, set_by_b(ACCESS, WORD, OPEN));
  TEST_ASSERT_EQUAL_HEX32(0, set_by_b(PROTECTION, OVERSPEED, bits_of(2.5f)));
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_float(PROTECTION, OVERSPEED, 3.0f));
  TEST_ASSERT_EQUAL(0, get(ACCESS, LEFT_S) & 0xFFFF);
}

static void test_a_channel_that_was_off_is_locked(void) {
  open_second_channel();
  TEST_ASSERT_EQUAL_HEX32(0, set_by_b(ACCESS, WORD, OPEN));
  SET(0x1201, 1, 0x80000000u | CLIENT_B);
  SET(0x1201, 1, CLIENT_B);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_by_b(PROTECTION, OVERSPEED, bits_of(2.0f)));
}

static void test_a_wrong_word_delays_its_channel_only(void) {
  open_second_channel();
  TEST_ASSERT_EQUAL_HEX32(BAD_VALUE, set_by_b(ACCESS, WORD, 1));
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_by_b(ACCESS, WORD, OPEN));
  SET(ACCESS, WORD, OPEN);
  nmt(129); /* a reset does not end the delay */
  wait_ms(100);
  open_second_channel();
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_by_b(ACCESS, WORD, OPEN));
  wait_ms(1000);
  TEST_ASSERT_EQUAL_HEX32(0, set_by_b(ACCESS, WORD, OPEN));
}

static void test_a_reset_and_bus_off_close_the_lock(void) {
  for (int i = 0; i < 3; ++i) {
    SET(ACCESS, WORD, OPEN);
    if (i < 2) {
      nmt(i == 0 ? 129 : 130);
    } else {
      servo_node_bus_off(&node);
    }
    wait_ms(100);
    TEST_ASSERT_EQUAL(0, get(ACCESS, LEFT_S) & 0xFFFF);
    TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_float(PROTECTION, OVERSPEED, 3.0f));
  }
}

/* What is open for one client or was staged meanwhile must not come into force by another's command. */
static void test_apply_and_undo_of_motor_data_need_the_lock(void) {
  open_second_channel();
  SET(ACCESS, WORD, OPEN);
  SET_FLOAT(MOTOR, CURRENT_LIMIT, 20.0f);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_by_b(PARAMETER_SET, 1, 1));
  SET(PARAMETER_SET, 1, 1);
  SET(ACCESS, WORD, 0);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(PARAMETER_SET, 1, 3)); /* undo */
  CHECK_SAME("A", 20.0, (double)node.board.app.params.axis[0].current_limit_a);
  SET_FLOAT(GAINS, 1, 700.0f);
  SET(PARAMETER_SET, 1, 1); /* a set with the same motor data needs none */
  SET(PARAMETER_SET, 1, 3);
  SET(ACCESS, WORD, OPEN);
  SET_FLOAT(MOTOR, CURRENT_LIMIT, 16.0f);
  SET(PARAMETER_SET, 1, 1);
}

/* Gains of either axis that 2070:1 = 4 has put into force without the check of stability. */
static void test_gains_without_a_check_are_stored_only_while_the_lock_is_open(void) {
  const uint32_t save = 0x65766173;
  for (int axis = 0; axis < SERVO_AXES; ++axis) {
    const uint32_t shift = axis == 0 ? 0 : PITCH;
    node_bench_start();
    SET_FLOAT(GAINS + shift, 1, 20000.0f);
    TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(PARAMETER_SET + shift, 1, 4));
    SET(ACCESS, WORD, OPEN);
    SET(PARAMETER_SET + shift, 1, 4);
    CHECK_SAME("gain", 20000.0, (double)node.board.app.params.axis[axis].speed.pi.proportional_gain);
    SET(ACCESS, WORD, 0);
    TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(0x1010, 1, save));
    TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(0x1010, 3, save));
    SET(0x1010, 2, save);
    SET(ACCESS, WORD, OPEN);
    SET(0x1010, 3, save);
  }
}

static void test_loading_the_defaults_needs_the_lock_when_guarded_values_differ(void) {
  SET(0x1011, 1, LOAD_WORD);
  SET(ACCESS, WORD, OPEN);
  SET_FLOAT(PROTECTION, OVERSPEED, 1.0f);
  SET(ACCESS, WORD, 0);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(0x1011, 1, LOAD_WORD));
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(0x1011, 3, LOAD_WORD));
  SET(0x1011, 2, LOAD_WORD);
  (void)servo_node_save(&node, 1); /* also while a save is under way, which the client has given up */
  TEST_ASSERT_EQUAL_HEX32(OD_DEVICE_STATE, servo_node_restore(&node, 1));
  wait_ms(500);
  SET(ACCESS, WORD, OPEN);
  SET(0x1011, 1, LOAD_WORD);
}

/* The smallest change: the last bit of an integer or of a real number. */
static void test_a_guarded_value_of_any_kind_and_axis_keeps_the_defaults_from_being_loaded(void) {
  static const struct {
    uint32_t index;
    uint8_t sub;
  } guarded[] = {{PROTECTION, OVERSPEED}, {PROTECTION + PITCH, OVERSPEED}, {HOME_OFFSET, 0}, {HOME_OFFSET + PITCH, 0},
                 {MOTOR, CURRENT_LIMIT},  {MOTOR + PITCH, CURRENT_LIMIT},  {SCALES, 1}};
  for (size_t i = 0; i < sizeof guarded / sizeof guarded[0]; ++i) {
    const uint32_t before = get(guarded[i].index, guarded[i].sub);
    for (uint32_t change = 0; change <= 1; ++change) {
      SET(ACCESS, WORD, OPEN);
      SET(guarded[i].index, guarded[i].sub, before + (change ^ 1u));
      SET(PARAMETER_SET + (guarded[i].index & PITCH), 1, 1);
      SET(ACCESS, WORD, 0);
      TEST_ASSERT_EQUAL_HEX32(change == 0 ? DEVICE_STATE : 0, set(0x1011, 1, LOAD_WORD));
    }
  }
}

static void test_nothing_guarded_changes_while_an_axis_has_torque(void) {
  SET(ACCESS, WORD, OPEN);
  SET_FLOAT(MOTOR, CURRENT_LIMIT, 20.0f); /* staged */
  enable(PITCH, PV);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_float(PROTECTION, OVERSPEED, 2.0f));
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_float(MOTOR, CURRENT_LIMIT, 21.0f));
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(PARAMETER_SET, 1, 1));
  SET_FLOAT(GAINS + PITCH, 1, 700.0f); /* gains may */
  SET(PARAMETER_SET + PITCH, 1, 1);
  command(PITCH, 0);
  SET_FLOAT(PROTECTION, OVERSPEED, 2.0f);
  SET(PARAMETER_SET, 1, 1);
}

static void test_the_lock_closes_by_itself_after_a_minute(void) {
  SET(ACCESS, WORD, OPEN);
  wait_ms(30000);
  TEST_ASSERT_EQUAL(30, get(ACCESS, LEFT_S) & 0xFFFF);
  SET_FLOAT(PROTECTION, OVERSPEED, 2.0f);
  wait_ms(30000);
  TEST_ASSERT_EQUAL(0, get(ACCESS, LEFT_S) & 0xFFFF);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_float(PROTECTION, OVERSPEED, 3.0f));
}

static void test_a_limit_out_of_range_is_refused(void) {
  SET(ACCESS, WORD, OPEN);
  TEST_ASSERT_EQUAL_HEX32(0x06090031, set_float(PROTECTION, OVERSPEED, 2000.0f));
  TEST_ASSERT_EQUAL_HEX32(0x06090031, set_float(PROTECTION, STOPPING_MARGIN, 11.0f));
  TEST_ASSERT_EQUAL_HEX32(0x06010002, set_float(PROTECTION, WAITING, 0.0f)); /* read only */
}

/* A supply of 24 V instead of 48 V, in the order that contradicts the old pair; the same with another travel. */
static void test_limits_are_written_in_any_order_and_only_whole_sets_are_in_force(void) {
  const protection_limits *in_force = &node.axis[0].monitor.limits;
  SET(ACCESS, WORD, OPEN);
  SET_FLOAT(PROTECTION, OVER_VOLTAGE, 30.0f);
  CHECK_SAME("V read back", 30.0, get_float(PROTECTION, OVER_VOLTAGE));
  CHECK_SAME("V in force", 60.0, in_force->over_voltage_v);
  TEST_ASSERT_EQUAL(PROTECTION_VOLTAGES, get(PROTECTION, WAITING) & 0xFF);
  SET_FLOAT(PROTECTION, UNDER_VOLTAGE, 18.0f);
  CHECK_SAME("V in force", 30.0, in_force->over_voltage_v);
  CHECK_SAME("V in force", 18.0, in_force->under_voltage_v);
  TEST_ASSERT_EQUAL(0, get(PROTECTION, WAITING) & 0xFF);

  SET_FLOAT(PROTECTION, TRAVEL_MAXIMUM, 1.0f);
  SET_FLOAT(PROTECTION, TRAVEL_MINIMUM, -1.0f);
  SET_FLOAT(PROTECTION, TRAVEL_MINIMUM, 2.0f); /* above the old maximum */
  CHECK_SAME("rad in force", -1.0, in_force->minimum_rad);
  TEST_ASSERT_EQUAL(PROTECTION_TRAVEL, get(PROTECTION, WAITING) & 0xFF);
  SET_FLOAT(PROTECTION, OVERSPEED, 1.25f); /* the rest of the set waits with it */
  CHECK_SAME("rad/s in force", 1.5, in_force->overspeed_rad_s);
  SET_FLOAT(PROTECTION, TRAVEL_MAXIMUM, 3.0f);
  CHECK_SAME("rad in force", 2.0, in_force->minimum_rad);
  CHECK_SAME("rad in force", 3.0, in_force->maximum_rad);
  CHECK_SAME("rad/s in force", 1.25, in_force->overspeed_rad_s);
  SET_FLOAT(PROTECTION, STOPPING_MARGIN, 0.5f); /* twice this leaves nothing */
  TEST_ASSERT_EQUAL(PROTECTION_TRAVEL, get(PROTECTION, WAITING) & 0xFF);
  SET_FLOAT(PROTECTION, STOPPING_MARGIN, 0.01f);
  CHECK_SAME("rad in force", 0.01f, in_force->stopping_margin_rad);
}

/* Every order of four writes, from one consistent set to another. */
static void test_any_order_of_writes_ends_in_the_set_that_was_written(void) {
  static const uint8_t subs[] = {TRAVEL_MINIMUM, TRAVEL_MAXIMUM, UNDER_VOLTAGE, OVER_VOLTAGE};
  static const float sets[][4] = {
      {-1.0f, 1.0f, 36.0f, 60.0f}, {2.0f, 3.0f, 18.0f, 30.0f}, {-4.0f, -2.0f, 61.0f, 80.0f}, {0.0f, 0.0f, 5.0f, 17.0f}};
  const protection_limits *in_force = &node.axis[1].monitor.limits;
  for (unsigned to = 1; to <= 4; ++to) {
    for (unsigned order = 0; order < 24; ++order) {
      unsigned left[] = {0, 1, 2, 3};
      for (unsigned from = 0; from < 4; ++from) {
        SET(ACCESS, WORD, OPEN);
        SET_FLOAT(PROTECTION + PITCH, subs[from], sets[(to - 1) % 4][from]);
      }
      unsigned code = order;
      for (unsigned n = 4; n > 0; --n) {
        const unsigned pick = code % n;
        code /= n;
        SET_FLOAT(PROTECTION + PITCH, subs[left[pick]], sets[to % 4][left[pick]]);
        left[pick] = left[n - 1];
        TEST_ASSERT_EQUAL(CONTROL_OK, protection_check(in_force));
      }
      TEST_ASSERT_EQUAL(0, get(PROTECTION + PITCH, WAITING) & 0xFF);
      TEST_ASSERT_EQUAL_FLOAT(sets[to % 4][0], in_force->minimum_rad);
      TEST_ASSERT_EQUAL_FLOAT(sets[to % 4][1], in_force->maximum_rad);
      TEST_ASSERT_EQUAL_FLOAT(sets[to % 4][2], in_force->under_voltage_v);
      TEST_ASSERT_EQUAL_FLOAT(sets[to % 4][3], in_force->over_voltage_v);
    }
  }
}

static void test_limits_that_wait_are_not_stored_and_a_reset_forgets_them(void) {
  const uint32_t save = 0x65766173;
  SET(ACCESS, WORD, OPEN);
  SET_FLOAT(PROTECTION, OVER_VOLTAGE, 30.0f);
  TEST_ASSERT_EQUAL_HEX32(0x06040043, set(0x1010, 1, save));
  TEST_ASSERT_EQUAL_HEX32(0x06040043, set(0x1010, 3, save));
  SET(0x1010, 2, save); /* the communication has no limits */
  nmt(0x81);
  wait_ms(100); /* in pieces */
  TEST_ASSERT_EQUAL(0, get(PROTECTION, WAITING) & 0xFF);
  CHECK_SAME("V", 60.0, get_float(PROTECTION, OVER_VOLTAGE));
}

static void test_a_contradiction_of_607d_leaves_the_last_one_in_force(void) {
  const drive_travel *in_force = &node.axis[0].drive.motion.bounds.travel;
  enable(0, PV);
  SET(SOFT_TRAVEL, 1, (uint32_t)-1000000);
  SET(SOFT_TRAVEL, 2, 1000000);
  wait_ms(2);
  SET(SOFT_TRAVEL, 1, 2000000);
  wait_ms(2);
  TEST_ASSERT_EQUAL(PROTECTION_SOFT_TRAVEL, get(PROTECTION, WAITING) & 0xFF);
  TEST_ASSERT_EQUAL_INT32(-1000000, in_force->minimum);
  TEST_ASSERT_EQUAL_INT32(1000000, in_force->maximum);
  TEST_ASSERT_EQUAL_HEX32(0x06040043, set(0x1010, 1, 0x65766173));
  SET(SOFT_TRAVEL, 2, 3000000);
  wait_ms(2);
  TEST_ASSERT_EQUAL(0, get(PROTECTION, WAITING) & 0xFF);
  TEST_ASSERT_EQUAL_INT32(2000000, in_force->minimum);
  TEST_ASSERT_EQUAL_INT32(3000000, in_force->maximum);
  command(0, 0x00); /* switching off does not clear it */
  SET(SOFT_TRAVEL, 1, 4000000);
  enable(0, PV);
  TEST_ASSERT_EQUAL_INT32(2000000, in_force->minimum);
}

/* --- the board's scales --- */

static void test_scales_of_the_board_are_written_unlocked_and_off_and_reach_the_sensors(void) {
  CHECK_SAME("A at first", 25.0, machine.scales.current_full_scale_a[0]);
  CHECK_SAME("V at first", 66.0, machine.scales.voltage_full_scale_v);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_float(BOARD, 1, 10.0f));
  SET(ACCESS, WORD, OPEN);
  SET_FLOAT(BOARD, 1, 10.0f);
  SET_FLOAT(BOARD, 4, 6.5f);
  SET_FLOAT(BOARD, 5, 100.0f);
  CHECK_SAME("A", 10.0, machine.scales.current_full_scale_a[0]);
  CHECK_SAME("A of the other axis", 25.0, machine.scales.current_full_scale_a[1]);
  CHECK_SAME("A of the other axis", 6.5, machine.scales.over_current_a[1]);
  CHECK_SAME("V", 100.0, machine.scales.voltage_full_scale_v);
  TEST_ASSERT_EQUAL_HEX32(0x06090031, set_float(BOARD, 1, 1001.0f));
  TEST_ASSERT_EQUAL_HEX32(0x06090032, set_float(BOARD, 5, 4.0f));
  enable(PITCH, PV); /* the scale of a flowing current does not change */
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set_float(BOARD, 1, 20.0f));
  command(PITCH, 0x00);
  nmt(0x81);
  wait_ms(100);
  CHECK_SAME("A after a reset", 25.0, machine.scales.current_full_scale_a[0]);
  CHECK_SAME("A after a reset", 25.0, get_float(BOARD, 1));
}

static void test_scales_beyond_their_ranges_are_no_scales(void) {
  const hal_scales good = {.current_full_scale_a = {0.1f, 1000.0f}, /* the ends of the ranges */
                           .over_current_a = {0.05f, 1000.0f},
                           .voltage_full_scale_v = 5.0f};
  hal_scales scales = good;
  float *const values[] = {&scales.current_full_scale_a[0], &scales.current_full_scale_a[1], &scales.over_current_a[0],
                           &scales.over_current_a[1], &scales.voltage_full_scale_v};
  TEST_ASSERT_EQUAL(CONTROL_OK, board_objects_check(&scales));
  for (uint32_t i = 0; i < sizeof values / sizeof values[0]; ++i) { /* one value alone */
    const float beyond[] = {i == 4 ? 4.9f : i < 2 ? 0.09f : 0.04f, 1001.0f};
    for (int end = 0; end < 2; ++end) {
      *values[i] = beyond[end];
      TEST_ASSERT_EQUAL(CONTROL_OUT_OF_RANGE, board_objects_check(&scales));
      scales = good;
    }
  }
}

/* --- the log
 * -------------------------------------------------------------------------------------------------------- */

static void test_a_fault_leaves_what_the_axis_did_before_it(void) {
  machine.axis[1].load_nm = 4.0;
  enable(PITCH, PV);
  SET(0x60FF + PITCH, 0, 100000);
  wait_ms(500);
  const uint32_t before = get(0x3010, 1);
  wait_ms(10);
  machine.axis[1].health = HAL_POWER_STAGE;
  wait_ms(3);
  TEST_ASSERT_EQUAL(1, get(LOG, LOG_COUNT));
  TEST_ASSERT_EQUAL(HEADER + FAULT_LOG_TICKS * SAMPLE, read_entry(NEWEST));
  TEST_ASSERT_TRUE(u32_of(entry) >= before + 9 && u32_of(entry) <= before + 12);
  TEST_ASSERT_EQUAL(FAULT_POWER_STAGE, entry[4]);
  TEST_ASSERT_EQUAL(1, entry[5]); /* pitch */
  TEST_ASSERT_EQUAL(FAULT_LOG_TICKS, entry[6]);
  TEST_ASSERT_EQUAL(FAULT_LOG_SIGNALS, entry[7]);
  for (uint32_t n = 0; n < FAULT_LOG_TICKS; ++n) {
    CHECK_NEAR("rad/s", 0.1, sample(n).joint_rate_rad_s, 0.002);
    CHECK_NEAR("V", 48.0, sample(n).bus_voltage_v, 1e-3);
    CHECK_NEAR("A", 1.6, sample(n).current_a, 0.3);
    CHECK_NEAR("Nm", 4.0, sample(n).torque_nm, 0.8);
    CHECK_NEAR("rad/s, gyro", 0.1, sample(n).gyro_rad_s, 0.002);
    CHECK_NEAR("rad/s, wanted", 0.1, sample(n).reference_rad_s, 1e-6);
    CHECK_NEAR("rad/s, of the loop", 0.1, sample(n).rate_rad_s, 0.002);
  }
  TEST_ASSERT_TRUE(sample(15).joint_angle_rad > sample(0).joint_angle_rad);
}

static void test_the_last_eight_faults_are_kept_until_they_are_cleared(void) {
  for (int i = 0; i < 9; ++i) {
    servo_node_report(&node, i < 8 ? FAULT_WATCHDOG_RESET : FAULT_BROWN_OUT_RESET, (uint8_t)i, false);
    wait_ms(20);
  }
  TEST_ASSERT_EQUAL(9, get(LOG, LOG_COUNT));
  TEST_ASSERT_TRUE(read_entry(NEWEST) > 0);
  TEST_ASSERT_EQUAL(FAULT_BROWN_OUT_RESET, entry[4]);
  TEST_ASSERT_TRUE(read_entry(NEWEST + 7) > 0);
  TEST_ASSERT_EQUAL(FAULT_WATCHDOG_RESET, entry[4]);
  SET(LOG, LOG_COMMAND, 1);
  TEST_ASSERT_EQUAL(0, get(LOG, LOG_COMMAND) & 0xFF);
  TEST_ASSERT_EQUAL(0, get(LOG, LOG_COUNT));
  TEST_ASSERT_EQUAL(0, read_entry(NEWEST));
}

static void test_there_is_no_entry_before_a_fault(void) {
  TEST_ASSERT_EQUAL(0, get(LOG, LOG_COUNT));
  TEST_ASSERT_EQUAL(0, read_entry(NEWEST));
  SET(LOG, LOG_COMMAND, 0);
}

static void test_an_entry_that_is_forgotten_while_it_is_read_ends_the_reading(void) {
  servo_node_report(&node, FAULT_WATCHDOG_RESET, 0, false);
  wait_ms(1);
  (void)ask((const uint8_t[]){0x40, 0x20, 0x30, NEWEST, 0, 0, 0, 0});
  fault_log_clear(&node.log);
  const uint8_t *answer = ask((const uint8_t[]){0x60, 0, 0, 0, 0, 0, 0, 0});
  TEST_ASSERT_EQUAL_HEX8(0x80, answer[0]);
  TEST_ASSERT_EQUAL_HEX32(NO_DATA, u32_of(&answer[4]));
}

/* --- several at once
 * ---------------------------------------------------------------------------------------------- */

/* Emergencies sent since the log was emptied; code and detail of the n-th (0: first), 0 when there was none. */
static uint32_t reported(uint32_t n, uint8_t *detail) {
  for (uint32_t i = 0; i < sent_count; ++i) {
    if (sent[i].id == EMCY && n-- == 0) {
      *detail = sent[i].data[3];
      return u32_of(sent[i].data) & 0xFFFF;
    }
  }
  return 0;
}

static void expect_reported(uint32_t n, uint32_t code, uint8_t detail) {
  uint8_t reported_detail = 0;
  TEST_ASSERT_EQUAL_HEX32(code, reported(n, &reported_detail));
  TEST_ASSERT_EQUAL(detail, reported_detail);
}

static void test_a_fault_that_comes_while_the_axis_is_in_another_is_reported_logged_and_over_when_it_is_gone(void) {
  enable(0, PV);
  machine.axis[0].health = HAL_POWER_STAGE;
  wait_ms(5);
  sent_count = 0;
  machine.axis[0].encoder_failed = true;
  wait_ms(20);
  expect_reported(0, 0x7320, FAULT_ENCODER_LOST);
  expect_reported(1, 0, 0); /* once */
  TEST_ASSERT_EQUAL(2, get(LOG, LOG_COUNT));
  TEST_ASSERT_TRUE(read_entry(NEWEST) > 0);
  TEST_ASSERT_EQUAL(FAULT_ENCODER_LOST, entry[4]);
  TEST_ASSERT_EQUAL(0, entry[5]);
  TEST_ASSERT_EQUAL_HEX32(0x5410, get(0x603F, 0) & 0xFFFF); /* the fault that the axis is in */
  sent_count = 0;
  machine.axis[0].encoder_failed = false;
  wait_ms(5);
  const can_frame *over = last_sent(EMCY);
  TEST_ASSERT_NOT_NULL(over);
  TEST_ASSERT_EQUAL_HEX32(0, u32_of(over->data) & 0xFFFF);
  TEST_ASSERT_EQUAL(1, over->data[4]);
  TEST_ASSERT_NOT_EQUAL(0, over->data[2]); /* the power stage is still faulty */
  sent_count = 0;
  machine.axis[0].encoder_failed = true; /* a loose contact */
  wait_ms(5);
  TEST_ASSERT_NULL(last_sent(EMCY));
  machine.axis[0].encoder_failed = false;
  machine.axis[0].health = HAL_GOOD;
  wait_ms(5);
  command(0, 0x00);
  command(0, 0x80);
  wait_ms(5);
  TEST_ASSERT_EQUAL_HEX32(0, get(0x1001, 0) & 0xFF);
  TEST_ASSERT_EQUAL(2, get(LOG, LOG_COUNT));
}

static void test_a_following_error_while_the_axis_is_in_another_fault_is_reported(void) {
  SET(0x6065, 0, 20000);
  SET(0x6066, 0, 0);
  enable(0, 1); /* pp */
  SET(0x607A, 0, 5000000);
  command(0, 0x1F);
  wait_ms(100);
  machine.axis[0].health = HAL_TOO_HOT; /* it brakes by its loops, which cannot follow the step of the load */
  wait_ms(2);
  TEST_ASSERT_EQUAL_HEX32(0x4310, get(0x603F, 0) & 0xFFFF);
  sent_count = 0;
  machine.axis[0].load_nm = 60.0;
  wait_ms(60);
  expect_reported(0, 0x8611, FAULT_FOLLOWING_ERROR);
}

/* The encoder is well: a gyro of 5,000 rad/s is a fault of its own, beside the one that the axis is in. */
static void test_an_implausible_sample_is_reported_while_the_axis_is_in_another_fault(void) {
  enable(0, PV);
  machine.axis[0].health = HAL_POWER_STAGE;
  wait_ms(5);
  sent_count = 0;
  machine.axis[0].gyro_error_rad_s = 5000.0f;
  wait_ms(30);
  bool reported = false;
  for (uint32_t i = 0; i < sent_count; ++i) {
    reported = reported || (sent[i % NODE_LOG].id == EMCY && (u32_of(sent[i % NODE_LOG].data) & 0xFFFF) == 0x7300);
  }
  TEST_ASSERT_TRUE(reported);
}

/* With a crossover of 1 rad/s, the base's rate that the wrong readings left would drive the axis for seconds. The fault
 * is reset as soon as it may be. */
static void test_what_a_broken_gyro_said_of_the_base_ends_with_its_fault(void) {
  static const struct {
    float error_rad_s;
    uint16_t code;
  } rows[] = {{100.0f, 0x7310}, {0.5f, 0x7302}, {-2.0f, 0x7302}, {0.018f, 0x7302}};
  for (unsigned row = 0; row < 4; ++row) {
    node_bench_start();
    SET(0x3040, 1, 0x6E65706F); /* "open" */
    SET_FLOAT(0x2050, 2, 1.0f);
    SET(0x2070, 1, 4);
    enable(0, PV);
    machine.axis[0].gyro_error_rad_s = rows[row].error_rad_s;
    wait_ms(2500); /* the shorted motor brakes for 2 s */
    TEST_ASSERT_TRUE(is_in_fault(0));
    TEST_ASSERT_EQUAL_HEX32(rows[row].code, get(0x603F, 0) & 0xFFFF);
    machine.axis[0].rate_rad_s = 0.0;
    machine.axis[0].gyro_error_rad_s = 0.0f;
    command(0, 0x00);
    for (int tries = 0; is_in_fault(0) && tries < 50; ++tries) {
      command(0, 0x80);
      command(0, 0x00);
    }
    const double before_turns = machine.axis[0].turns;
    enable(0, PV);
    wait_ms(1000);
    TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
    CHECK_NEAR("turns", before_turns, machine.axis[0].turns, 1e-4);
  }
}

/* On a base that turns: a fault of the bus changes nothing of what is known of it. */
static void test_the_rate_of_the_base_survives_other_faults(void) {
  SET(0x3040, 1, 0x6E65706F); /* "open" */
  SET_FLOAT(0x2060, 2, 0.5f);
  SET_FLOAT(0x2060, 27, 0.0f);
  enable(0, PV);
  machine.axis[0].gyro_error_rad_s = 0.05f;
  wait_ms(1000);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  machine.axis[0].health = HAL_POWER_STAGE;
  wait_ms(20);
  machine.axis[0].gyro_missing = true; /* one reading */
  wait_ms(1);
  machine.axis[0].gyro_missing = false;
  wait_ms(4);
  CHECK_NEAR("rad/s", 0.05, node.board.app.axis[0].speed.rate_fusion.base_rate_rad_s, 1e-3);
}

static void test_faults_of_one_code_are_each_reported_and_over_together(void) {
  enable(0, PV);
  wait_ms(20);
  machine.axis[0].gyro_missing = true;
  wait_ms(20);
  sent_count = 0;
  machine.axis[0].gyro_missing = false;
  machine.axis[0].gyro_error_rad_s = 100.0f; /* saturated: 7310, too */
  wait_ms(20);
  expect_reported(0, 0x7310, FAULT_GYRO_SATURATED);
  machine.axis[0].gyro_error_rad_s = 0.0f;
  wait_ms(200);
  TEST_ASSERT_NOT_EQUAL(0, get(0x1001, 0) & 0xFF);
  command(0, 0x00);
  command(0, 0x80);
  wait_ms(10);
  TEST_ASSERT_EQUAL_HEX32(0, get(0x1001, 0) & 0xFF);
}

/* 2070:1 = 4 takes a gain that makes the loop swing from limit to limit, which the check refuses. The gain of 500
 * before it is proven after 10 s; until then that of the start is. */
/* Half a second at most. While the axis may shake, nothing counts against its current sensor; what has shaken does not
 * count against the gains that are in force then. */
static void wait_until_gains_are_taken_back(const servo_node_axis *axis, float shaking_gain) {
  const float *gain = &axis->tuning.active.speed_loop.proportional_nm_s_rad;
  bool shook = false;
  for (int ms = 0; ms < 500 && *gain == shaking_gain; ++ms) {
    wait_ms(1);
    shook = shook || axis->monitor.may_shake;
    TEST_ASSERT_TRUE(!axis->monitor.may_shake || axis->monitor.state.mismatch_ticks == 0);
  }
  TEST_ASSERT_TRUE(shook);
  TEST_ASSERT_NOT_EQUAL(shaking_gain, *gain);
  oscillation none;
  oscillation_reset(&none);
  TEST_ASSERT_EQUAL_MEMORY(&none, &axis->monitor.swings, sizeof none);
}

static void test_gains_that_shake_an_axis_are_taken_back_reported_and_logged(void) {
  for (int axis = 0; axis < SERVO_AXES; ++axis) {
    const uint32_t shift = axis == 0 ? 0 : PITCH;
    node_bench_start();
    SET(ACCESS, WORD, OPEN);
    SET(0x6007 + shift, 0, 0);
    SET_FLOAT(GAINS + shift, 1, 500.0f);
    SET(PARAMETER_SET + shift, 1, 1);
    enable(shift, PV);
    SET(0x60FF + shift, 0, 50000);
    wait_ms(axis == 0 ? 10100 : 9700);
    SET_FLOAT(GAINS + shift, 1, 20000.0f);
    SET(PARAMETER_SET + shift, 1, 4);
    sent_count = 0;
    wait_until_gains_are_taken_back(&node.axis[axis], node.board.app.params.axis[axis].speed.pi.proportional_gain);
    wait_ms(100);
    expect_reported(0, 0x6320, FAULT_GAINS_TAKEN_BACK);
    TEST_ASSERT_EQUAL(axis + 1, sent[0].data[4]);
    expect_reported(1, 0, 0); /* over at once: it is a report, and the axis goes on */
    expect_reported(2, 0, 0);
    CHECK_SAME("in force", axis == 0 ? 500.0 : 720.0, node.board.app.params.axis[axis].speed.pi.proportional_gain);
    CHECK_NEAR("rad/s", 0.05, machine.axis[axis].rate_rad_s, 1e-3);
    TEST_ASSERT_TRUE(read_entry(NEWEST) > 0);
    TEST_ASSERT_EQUAL(FAULT_GAINS_TAKEN_BACK, entry[4]);
    TEST_ASSERT_EQUAL(axis, entry[5]);
  }
}

/* The set before is that of another motor: its 16 A must not come back without the lock. */
static void test_gains_that_shake_stop_the_axis_when_its_motor_data_have_changed_too(void) {
  SET(ACCESS, WORD, OPEN);
  SET(0x6007, 0, 0);
  SET_FLOAT(0x2055, 6, 15.0f);
  SET(PARAMETER_SET, 1, 1);
  enable(0, PV);
  SET(0x60FF, 0, 50000);
  wait_ms(1000);
  SET_FLOAT(GAINS, 1, 20000.0f);
  SET(PARAMETER_SET, 1, 4);
  sent_count = 0;
  wait_ms(1000);
  expect_reported(0, 0x8480, FAULT_OSCILLATION);
  CHECK_SAME("A", 15.0, node.axis[0].tuning.active.motor.current_limit_a);
}

/* --- reports of the board
 * --------------------------------------------------------------------------------------------- */

static void test_a_fault_of_the_board_that_lasts_stays_in_the_register(void) {
  sent_count = 0;
  servo_node_report(&node, FAULT_IMAGE_DAMAGED, 42, true);
  wait_ms(20);
  const can_frame *reported = last_sent(EMCY);
  TEST_ASSERT_NOT_NULL(reported);
  TEST_ASSERT_EQUAL_HEX32(0x5520, u32_of(reported->data) & 0xFFFF);
  TEST_ASSERT_EQUAL(42, reported->data[3]);
  TEST_ASSERT_NOT_EQUAL(0, get(0x1001, 0) & 0xFF);
}

static void test_a_fault_of_the_board_is_logged_as_its_own_without_samples(void) {
  wait_ms(20);
  servo_node_report(&node, FAULT_WATCHDOG_RESET, 4, false);
  TEST_ASSERT_EQUAL(HEADER, read_entry(NEWEST));
  TEST_ASSERT_EQUAL(FAULT_WATCHDOG_RESET, entry[4]);
  TEST_ASSERT_EQUAL(FAULT_LOG_BOARD, entry[5]);
  TEST_ASSERT_EQUAL(0, entry[6]);
  TEST_ASSERT_EQUAL(FAULT_LOG_SIGNALS, entry[7]);
}

static void test_what_the_board_reports_of_an_axis_is_its_fault(void) {
  static const struct {
    hal_health health;
    fault_id fault;
  } reports[] = {{HAL_NOT_READY, FAULT_SELF_TEST},
                 {HAL_OVER_CURRENT, FAULT_OVER_CURRENT_TRIP},
                 {HAL_POWER_STAGE, FAULT_POWER_STAGE},
                 {HAL_TOO_HOT, FAULT_OVER_TEMPERATURE},
                 {HAL_TIMING_LOST, FAULT_TICK_LATE},
                 {HAL_IMAGE_DAMAGED, FAULT_IMAGE_DAMAGED},
                 {HAL_SAFE_TORQUE_OFF, FAULT_SAFE_TORQUE_OFF},
                 {HAL_SAFE_TORQUE_FAULT, FAULT_SAFE_TORQUE_FAULT},
                 {HAL_CLOCK_WRONG, FAULT_CLOCK}};
  for (uint32_t i = 0; i < sizeof reports / sizeof reports[0]; ++i) {
    node_bench_start();
    enable(0, PV);
    machine.axis[0].health = reports[i].health;
    wait_ms(3);
    TEST_ASSERT_EQUAL(reports[i].fault, node.axis[0].drive.fault);
    TEST_ASSERT_EQUAL(FAULT_NONE, node.axis[1].drive.fault);
  }
}

static void test_bus_off_stops_both_axes(void) {
  enable(PITCH, PV);
  enable(0, PV);
  SET(0x60FF, 0, 100000);
  wait_ms(500);
  servo_node_bus_off(&node);
  wait_ms(500);
  CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 0.005);
  TEST_ASSERT_EQUAL_HEX32(0x8140, get(0x603F, 0) & 0xFFFF);
  TEST_ASSERT_EQUAL_HEX32(0x8140, get(0x603F + PITCH, 0) & 0xFFFF);
}

/* --- the motor as a witness, after a fault --- */

/* Turns against a load long enough to narrow the range of the winding's resistance. */
static void turn_azimuth(void) {
  machine.axis[0].load_nm = 12.0;
  enable(0, PV);
  SET(0x60FF, 0, 200000);
  wait_ms(1000);
  TEST_ASSERT_EQUAL(FAULT_NONE, node.axis[0].drive.fault);
  TEST_ASSERT_TRUE(node.axis[0].monitor.state.witness.known);
}

static void reset_fault_of_azimuth(uint32_t after_ms) {
  machine.axis[0].encoder_failed = machine.axis[0].gyro_missing = false;
  machine.axis[0].health = HAL_GOOD;
  machine.axis[0].current_error_a = 0.0f;
  machine.axis[0].load_nm = machine.axis[0].rate_rad_s = 0.0; /* it stands */
  wait_ms(after_ms);
  command(0, 0x00);
  command(0, 0x80);
  TEST_ASSERT_EQUAL(FAULT_NONE, node.axis[0].drive.fault);
}

static void test_an_offset_that_a_broken_converter_shows_after_its_fault_is_forgotten_with_the_reset(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    node_bench_start();
    wait_ms(100);
    turn_azimuth();
    machine.axis[0].health = HAL_POWER_STAGE;
    wait_ms(1);
    machine.axis[0].current_error_a = (float)sign * 0.45f; /* below 2060:13: no fault of its own */
    wait_ms(200);
    TEST_ASSERT_TRUE(is_in_fault(0));
    reset_fault_of_azimuth(5);
    CHECK_NEAR("A", 0.0, node.axis[0].monitor.state.witness.zero_a, 1e-3);
    turn_azimuth();
  }
}

/* 0.3 A is legal (2060:13): an axis that is switched on again must not take it for a contradiction. */
static void test_the_offset_of_a_converter_is_measured_while_its_axis_is_in_fault(void) {
  machine.axis[0].current_error_a = 0.3f;
  wait_ms(100);
  turn_azimuth();
  machine.axis[0].health = HAL_POWER_STAGE;
  wait_ms(200);
  CHECK_NEAR("A", 0.3, node.axis[0].monitor.state.witness.zero_a, 1e-3);
  CHECK_SAME("A", 0.0, motor_witness_zero_error_a(&node.axis[0].monitor.state.witness));
}

static void test_the_motor_is_learned_anew_after_a_fault_of_what_the_witness_compares(void) {
  node_bench_start();
  wait_ms(100);
  turn_azimuth();
  machine.axis[0].encoder_failed = true;
  wait_ms(2500);
  reset_fault_of_azimuth(30);
  TEST_ASSERT_FALSE(node.axis[0].monitor.state.witness.known);
  turn_azimuth();
  machine.axis[0].gyro_missing = true; /* it compares encoder, current and voltage only */
  wait_ms(1000);
  TEST_ASSERT_TRUE(is_in_fault(0));
  reset_fault_of_azimuth(30);
  TEST_ASSERT_TRUE(node.axis[0].monitor.state.witness.known);
}

static float learned_width(int axis) {
  const motor_interval *r = &node.axis[axis].monitor.state.witness.resistance;
  return r->high - r->low;
}

/* All axes read one bus voltage: what a broken converter taught the axis that did not stop must go, too. */
static void test_after_a_fault_of_the_bus_voltage_every_motor_is_learned_anew(void) {
  node_bench_start();
  wait_ms(100);
  turn_azimuth();
  CHECK_AT_MOST("share of R, learned", 0.5, learned_width(0));
  enable(PITCH, CST);
  for (int ms = 0; ms < 60; ++ms) {
    SET(0x6071 + PITCH, 0, ms % 2 == 0 ? 100 : (uint16_t)-100);
    atomic_store(&node.board.motor[1].tick_current_a, 0.0f);
    atomic_store(&node.board.motor[1].tick_voltage_v, 12.0f);
  }
  TEST_ASSERT_TRUE(is_in_fault(PITCH));
  TEST_ASSERT_FALSE(is_in_fault(0));
  wait_ms(10);
  CHECK_AT_LEAST("share of R, unknown", 0.7, learned_width(0));
}

/* --- the current sensor, and the slow monitors --- */

/* 3.2 A in a ms take 9.6 V in a winding of 3 mH: more than 2060:12. A converter that shows no change of the current
 * with this voltage is broken. */
static void test_the_voltage_that_changes_a_current_is_no_fault_where_the_current_follows(void) {
  for (int row = 0; row < 2; ++row) {
    node_bench_start();
    enable(0, CST);
    for (int ms = 0; ms < 60; ++ms) {
      motor_stage *motor = &node.board.motor[0];
      const float before_a = machine.axis[0].current_a;
      SET(0x6071, 0, ms % 2 == 0 ? 100 : (uint16_t)-100);
      const float now_a = machine.axis[0].current_a;
      atomic_store(&motor->tick_voltage_v, atomic_load(&motor->tick_voltage_v) + 3e-3f * (now_a - before_a) / 1e-3f);
      atomic_store(&motor->tick_current_a, row == 0 ? now_a : 0.0f);
    }
    TEST_ASSERT_EQUAL(row == 0 ? FAULT_NONE : FAULT_MOTOR_CONTRADICTS, node.axis[0].drive.fault);
  }
}

/* What was half counted before it: that the motor disagrees with its current. */
static void test_a_reset_of_the_node_leaves_no_fault_half_counted(void) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    node.axis[i].monitor.state.mismatch_ticks = 40;
    node.axis[i].monitor.state.heating_a2 = 2.0f;
  }
  nmt(0x81);
  wait_ms(1);
  for (int i = 0; i < SERVO_AXES; ++i) {
    TEST_ASSERT_EQUAL(0, node.axis[i].monitor.state.mismatch_ticks);
    CHECK_NEAR("A^2: a winding stays warm", 2.0, node.axis[i].monitor.state.heating_a2, 0.01);
  }
}

/* Held by something at its angle; the loop asks for more and more torque. 2060:8 is half a second. */
static void test_an_axis_that_is_blocked_at_its_torque_limit_stalls(void) {
  SET(0x6007, 0, 0);
  enable(0, PV);
  SET(0x60FF, 0, 20000);
  const double turns = machine.axis[0].turns;
  int limited_ms = 0;
  for (int ms = 0; ms < 3000 && node.axis[0].drive.fault == FAULT_NONE; ++ms) {
    machine.axis[0].turns = turns;
    machine.axis[0].rate_rad_s = 0.0;
    wait_ms(1);
    limited_ms += node.board.app.axis[0].commanded_nm > 39.9f ? 1 : 0;
  }
  TEST_ASSERT_EQUAL(FAULT_STALL, node.axis[0].drive.fault);
  TEST_ASSERT_INT_WITHIN(5, 500, limited_ms);
}

/* PP: it holds where it was enabled, or where a move has ended, until a load that grows to 40.6 Nm is more than its 40.
 * 2060:29 is 10 mrad; the base does not turn. */
static void test_an_axis_that_leaves_the_position_that_it_holds_is_a_fault(void) {
  const uint8_t fixed_base = 27, standstill = 29;
  static const int32_t targets[] = {0, 500000};
  for (unsigned i = 0; i < sizeof targets / sizeof targets[0]; ++i) {
    node_bench_start();
    SET(ACCESS, WORD, OPEN);
    SET_FLOAT(PROTECTION, fixed_base, 1.0f);
    SET_FLOAT(PROTECTION, standstill, 0.01f);
    SET(0x6007, 0, 0);
    enable(0, PP);
    if (targets[i] != 0) {
      SET(0x607A, 0, (uint32_t)targets[i]);
      command(0, 0x1F);
    }
    wait_ms(4000); /* no move of its own is a fault */
    TEST_ASSERT_EQUAL(FAULT_NONE, node.axis[0].drive.fault);
    CHECK_NEAR("rad", 1e-7 * targets[i], 6.283185307 * machine.axis[0].turns, 1e-3);
    const double turns = machine.axis[0].turns;
    for (int ms = 0; ms < 2000 && node.axis[0].drive.fault == FAULT_NONE; ++ms) {
      machine.axis[0].load_nm = fmin(0.1 * ms, 40.6);
      wait_ms(1);
    }
    TEST_ASSERT_EQUAL(FAULT_STANDSTILL_LEFT, node.axis[0].drive.fault);
    CHECK_NEAR("away, rad", -0.02, 6.283185307 * (machine.axis[0].turns - turns), 0.01);
  }
}

/* 6072 is 30 % of the motor's 40 Nm; a load pushes the axis against its set-point. Up to half of the motor's torque,
 * the axis may be weaker than its load; what is more must not fail to hold it. */
static void test_a_load_that_is_stronger_than_the_limited_torque_is_no_runaway(void) {
  static const struct {
    uint16_t maximum_permille;
    double load_nm;
    fault_id fault;
  } rows[] = {{300, 25.0, FAULT_SPEED_ERROR}, {700, 45.0, FAULT_RUNAWAY}};
  for (unsigned i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    node_bench_start();
    SET(ACCESS, WORD, OPEN);
    SET_FLOAT(PROTECTION, OVERSPEED, 100.0f);
    SET(0x6007, 0, 0);
    SET(0x6072, 0, rows[i].maximum_permille);
    enable(0, PV);
    machine.axis[0].load_nm = rows[i].load_nm;
    for (int ms = 0; ms < 1000 && node.axis[0].drive.fault == FAULT_NONE; ++ms) {
      wait_ms(1);
    }
    TEST_ASSERT_EQUAL(rows[i].fault, node.axis[0].drive.fault);
  }
}

/* 2060:26 = 1: the contact of the brake says that it stays engaged, or it is not read. */
static void test_a_brake_that_does_not_open_is_a_fault_where_its_contact_is_used(void) {
  for (int used = 0; used <= 1; ++used) {
    const uint8_t feedback = 26;
    node_bench_start();
    SET(ACCESS, WORD, OPEN);
    SET_FLOAT(PROTECTION, feedback, (float)used);
    wait_ms(8);
    SET(0x6060, 0, PV);
    command(0, 0x06);
    command(0, 0x07);
    command(0, 0x0F);
    wait_ms(500);
    TEST_ASSERT_EQUAL(used != 0 ? FAULT_HOLDING_BRAKE : FAULT_NONE, node.axis[0].drive.fault);
  }
}

/* 60E0 20 %, 60E1 100 %: an oscillation is one of the 40 Nm that are left to one side. */
static void test_oscillations_are_judged_by_the_larger_torque_limit_in_force(void) {
  enable(0, PV);
  SET(0x60E0, 0, 200);
  SET(0x60E1, 0, 1000);
  wait_ms(2);
  CHECK_NEAR("Nm", 40.0, node.axis[0].monitor.torque_nm, 0.01);
  SET(0x60E0, 0, 500);
  SET(0x60E1, 0, 200);
  wait_ms(2);
  CHECK_NEAR("Nm", 20.0, node.axis[0].monitor.torque_nm, 0.01);
  SET(0x60E0, 0, 10); /* a tenth at least: below it nothing shakes */
  SET(0x60E1, 0, 10);
  wait_ms(2);
  CHECK_NEAR("Nm", 4.0, node.axis[0].monitor.torque_nm, 0.01);
}

/* Each axis once in 4 ms, 2 ms after the other one: both at once would take too much of the ms. Both are too fast for
 * the reduced speed from the same ms on. */
static void test_the_slow_monitors_of_the_axes_judge_in_turn(void) {
  int found_ms[SERVO_AXES] = {0, 0};
  for (int axis = 0; axis < SERVO_AXES; ++axis) {
    enable(axis == 0 ? 0 : PITCH, PV);
    SET(axis == 0 ? 0x60FF : 0x60FF + PITCH, 0, 500000);
  }
  SET(0x2062, 0, 1);
  SET(0x2062 + PITCH, 0, 1);
  for (int ms = 1; ms < 2000; ++ms) {
    wait_ms(1);
    for (int axis = 0; axis < SERVO_AXES; ++axis) {
      const bool found = node.axis[axis].drive.fault == FAULT_REDUCED_SPEED;
      found_ms[axis] = found && found_ms[axis] == 0 ? ms : found_ms[axis];
    }
  }
  TEST_ASSERT_TRUE(found_ms[0] > 0 && found_ms[1] > 0);
  TEST_ASSERT_EQUAL(2, (found_ms[1] - found_ms[0] + 2000) % 4);
}

/* --- values that change by themselves --- */

/* ms until the axis has the fault, at most 60; 0: not found. */
static int found_after(int axis) {
  for (int ms = 1; ms <= 60; ++ms) {
    wait_ms(1);
    if (node.axis[axis].drive.fault == FAULT_ACTIVE_SET) {
      return ms;
    }
  }
  return 0;
}

static void flip(void *data, uint32_t bit) { ((uint8_t *)data)[bit / 8u] ^= (uint8_t)(1u << bit % 8u); }

static void test_a_bit_that_flips_in_a_set_in_use_is_found_until_the_set_is_loaded_again(void) {
  void *const sets[] = {&node.board.app.params.axis[0], &node.axis[0].tuning.active, &node.axis[0].monitor.limits};
  const uint32_t sizes[] = {sizeof(servo_axis_params), sizeof(axis_parameters), sizeof(protection_limits)};
  for (uint32_t i = 0; i < 3; ++i) {
    for (uint32_t bit = i; bit < 8u * sizes[i]; bit += 97u) {
      node_bench_start();
      enable(PITCH, PV);
      flip(sets[i], bit);
      const int ms = found_after(0);
      TEST_ASSERT_TRUE(ms > 0 && ms <= GUARDED_SETS_CYCLE_MS + 2);
      TEST_ASSERT_EQUAL(FAULT_NONE, node.axis[1].drive.fault);
    }
  }
  nmt(0x81);
  wait_ms(100);
  command(0, 0x00);
  command(0, 0x80);
  TEST_ASSERT_EQUAL(FAULT_NONE, node.axis[0].drive.fault);
  TEST_ASSERT_EQUAL(0, found_after(0));
}

/* Between the start and the first ms. */
static void test_a_bit_that_flips_before_the_first_tick_is_found(void) {
  const can_sender sender = {node_bench_send, NULL};
  void *const sets[] = {&node.board.app.params.axis[0], &node.axis[0].tuning.active, &node.axis[0].monitor.limits};
  for (uint32_t i = 0; i < 3; ++i) {
    TEST_ASSERT_TRUE(rigid_machine_start_node(&machine, &node, NODE_ID, sender, NULL));
    flip(sets[i], 7);
    TEST_ASSERT_TRUE(found_after(0) > 0);
  }
}

static void test_a_bit_of_the_scales_stops_both_axes(void) {
  flip(&node.scales, 40);
  TEST_ASSERT_TRUE(found_after(0) > 0);
  TEST_ASSERT_EQUAL(FAULT_ACTIVE_SET, node.axis[1].drive.fault);
}

static void test_a_bit_of_a_set_stops_the_axis_whose_set_it_is(void) {
  void *const sets[] = {&node.board.app.params.axis[1], &node.axis[1].tuning.active, &node.axis[1].monitor.limits};
  for (uint32_t i = 0; i < 3; ++i) {
    node_bench_start();
    flip(sets[i], 7);
    TEST_ASSERT_TRUE(found_after(1) > 0);
    TEST_ASSERT_EQUAL(FAULT_NONE, node.axis[0].drive.fault);
  }
}

/* As a stored set does that is loaded; in each ms, so that every part of the cycle meets it. */
static void test_the_sets_of_both_axes_may_change_in_one_ms(void) {
  for (int ms = 0; ms < 2 * GUARDED_SETS_CYCLE_MS; ++ms) {
    for (int i = 0; i < SERVO_AXES; ++i) {
      flip(&node.axis[i].tuning.active, 0);
      node.axis[i].tuning.changes++;
    }
    wait_ms(1);
    TEST_ASSERT_EQUAL(FAULT_NONE, node.axis[0].drive.fault);
    TEST_ASSERT_EQUAL(FAULT_NONE, node.axis[1].drive.fault);
  }
}

/* Both axes one after the other, and once more. */
static void test_gains_limits_and_scales_that_are_written_are_no_fault(void) {
  for (int round = 0; round < 2; ++round) {
    const float share = round == 0 ? 1.0f : 0.9f;
    SET(ACCESS, WORD, OPEN);
    SET_FLOAT(BOARD, 1, share * 20.0f);
    for (uint16_t shift = 0; shift <= 0x800; shift += 0x800) {
      SET_FLOAT(PROTECTION + shift, OVERSPEED, share * 2.0f);
      SET_FLOAT(0x2000 + shift, 1, share * 600.0f);
      SET(0x2070 + shift, 1, 1);
      SET(0x2070 + shift, 1, 3);
    }
    wait_ms(GUARDED_SETS_CYCLE_MS + 50);
    TEST_ASSERT_EQUAL(FAULT_NONE, node.axis[0].drive.fault);
    TEST_ASSERT_EQUAL(FAULT_NONE, node.axis[1].drive.fault);
  }
}

/* Limits and gains are other ones than at the start; they are guarded as those were. */
static void test_a_bit_of_a_set_that_was_written_is_found_too(void) {
  void *const sets[] = {&node.board.app.params.axis[0], &node.axis[0].tuning.active, &node.axis[0].monitor.limits};
  for (uint32_t i = 0; i < 3; ++i) {
    node_bench_start();
    SET(ACCESS, WORD, OPEN);
    SET_FLOAT(PROTECTION, OVERSPEED, 1.9f);
    SET_FLOAT(GAINS, 1, 600.0f);
    SET(PARAMETER_SET, 1, 1);
    wait_ms(GUARDED_SETS_CYCLE_MS + 2);
    TEST_ASSERT_EQUAL(FAULT_NONE, node.axis[0].drive.fault);
    flip(sets[i], 7);
    TEST_ASSERT_TRUE(found_after(0) > 0);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_limits_are_written_only_while_the_lock_is_open);
  RUN_TEST(test_the_lock_is_open_only_for_the_channel_that_opened_it);
  RUN_TEST(test_a_channel_that_was_off_is_locked);
  RUN_TEST(test_a_wrong_word_delays_its_channel_only);
  RUN_TEST(test_a_reset_and_bus_off_close_the_lock);
  RUN_TEST(test_apply_and_undo_of_motor_data_need_the_lock);
  RUN_TEST(test_gains_without_a_check_are_stored_only_while_the_lock_is_open);
  RUN_TEST(test_loading_the_defaults_needs_the_lock_when_guarded_values_differ);
  RUN_TEST(test_a_guarded_value_of_any_kind_and_axis_keeps_the_defaults_from_being_loaded);
  RUN_TEST(test_nothing_guarded_changes_while_an_axis_has_torque);
  RUN_TEST(test_the_lock_closes_by_itself_after_a_minute);
  RUN_TEST(test_a_limit_out_of_range_is_refused);
  RUN_TEST(test_limits_are_written_in_any_order_and_only_whole_sets_are_in_force);
  RUN_TEST(test_any_order_of_writes_ends_in_the_set_that_was_written);
  RUN_TEST(test_limits_that_wait_are_not_stored_and_a_reset_forgets_them);
  RUN_TEST(test_a_contradiction_of_607d_leaves_the_last_one_in_force);
  RUN_TEST(test_scales_of_the_board_are_written_unlocked_and_off_and_reach_the_sensors);
  RUN_TEST(test_scales_beyond_their_ranges_are_no_scales);
  RUN_TEST(test_a_fault_leaves_what_the_axis_did_before_it);
  RUN_TEST(test_the_last_eight_faults_are_kept_until_they_are_cleared);
  RUN_TEST(test_there_is_no_entry_before_a_fault);
  RUN_TEST(test_an_entry_that_is_forgotten_while_it_is_read_ends_the_reading);
  RUN_TEST(test_a_fault_that_comes_while_the_axis_is_in_another_is_reported_logged_and_over_when_it_is_gone);
  RUN_TEST(test_a_following_error_while_the_axis_is_in_another_fault_is_reported);
  RUN_TEST(test_an_implausible_sample_is_reported_while_the_axis_is_in_another_fault);
  RUN_TEST(test_what_a_broken_gyro_said_of_the_base_ends_with_its_fault);
  RUN_TEST(test_the_rate_of_the_base_survives_other_faults);
  RUN_TEST(test_faults_of_one_code_are_each_reported_and_over_together);
  RUN_TEST(test_gains_that_shake_an_axis_are_taken_back_reported_and_logged);
  RUN_TEST(test_gains_that_shake_stop_the_axis_when_its_motor_data_have_changed_too);
  RUN_TEST(test_a_fault_of_the_board_is_logged_as_its_own_without_samples);
  RUN_TEST(test_a_fault_of_the_board_that_lasts_stays_in_the_register);
  RUN_TEST(test_what_the_board_reports_of_an_axis_is_its_fault);
  RUN_TEST(test_bus_off_stops_both_axes);
  RUN_TEST(test_an_offset_that_a_broken_converter_shows_after_its_fault_is_forgotten_with_the_reset);
  RUN_TEST(test_the_offset_of_a_converter_is_measured_while_its_axis_is_in_fault);
  RUN_TEST(test_the_motor_is_learned_anew_after_a_fault_of_what_the_witness_compares);
  RUN_TEST(test_after_a_fault_of_the_bus_voltage_every_motor_is_learned_anew);
  RUN_TEST(test_the_voltage_that_changes_a_current_is_no_fault_where_the_current_follows);
  RUN_TEST(test_a_reset_of_the_node_leaves_no_fault_half_counted);
  RUN_TEST(test_an_axis_that_is_blocked_at_its_torque_limit_stalls);
  RUN_TEST(test_an_axis_that_leaves_the_position_that_it_holds_is_a_fault);
  RUN_TEST(test_a_load_that_is_stronger_than_the_limited_torque_is_no_runaway);
  RUN_TEST(test_a_brake_that_does_not_open_is_a_fault_where_its_contact_is_used);
  RUN_TEST(test_oscillations_are_judged_by_the_larger_torque_limit_in_force);
  RUN_TEST(test_the_slow_monitors_of_the_axes_judge_in_turn);
  RUN_TEST(test_a_bit_that_flips_in_a_set_in_use_is_found_until_the_set_is_loaded_again);
  RUN_TEST(test_a_bit_that_flips_before_the_first_tick_is_found);
  RUN_TEST(test_a_bit_of_the_scales_stops_both_axes);
  RUN_TEST(test_a_bit_of_a_set_stops_the_axis_whose_set_it_is);
  RUN_TEST(test_the_sets_of_both_axes_may_change_in_one_ms);
  RUN_TEST(test_gains_limits_and_scales_that_are_written_are_no_fault);
  RUN_TEST(test_a_bit_of_a_set_that_was_written_is_found_too);
  return UNITY_END();
}
