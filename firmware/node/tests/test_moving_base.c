/* SPDX-License-Identifier: Apache-2.0 */
/* The base's rates in the whole node: messages in one PDO, and what an axis does with them. The azimuth feeds back its
 * encoder alone and stands at set-point 0: it turns against what is added to its rate. */
#include "support/node_bench.h"

#include "support/check.h"

enum { PV = 3, MESSAGE_ID = 0x400 + NODE_ID };
enum { MESSAGE = 0x3076, SETTING = 0x3077, USE = 1, SCALE, DELAY, LARGEST, BANDWIDTH, TIMEOUT };
enum { REPORT = 0x3078, STATE = 1, TAKEN, DROPPED, LAST_DROP, ADDED_AZIMUTH, ADDED_PITCH };
enum { OFF, AWAITED, IN_USE, STALE, OF_FIXED_BASE };
enum { EVERY_MS = 10, FIXED_BASE = 27 };

#define COUNT_RAD_S 2e-5

static uint8_t counter;

/* RPDO3 becomes that of the base: 3076:1 to :4. */
static void map_base(void) {
  SET(0x1402, 1, 0x80000000u | MESSAGE_ID);
  SET(0x1602, 0, 0);
  SET(0x1602, 1, 0x30760110);
  SET(0x1602, 2, 0x30760210);
  SET(0x1602, 3, 0x30760310);
  SET(0x1602, 4, 0x30760408);
  SET(0x1602, 0, 4);
  SET(0x1402, 1, MESSAGE_ID);
}

static void declare_the_base(uint32_t shift, float window_rad) {
  SET(0x3040, 1, 0x6E65706F);
  SET_FLOAT(0x2060 + shift, FIXED_BASE, window_rad);
}

static void declare_that_the_base_moves(uint32_t shift) { declare_the_base(shift, 0.0f); }

void setUp(void) {
  counter = 0;
  node_bench_start();
  map_base();
  SET(0x6007, 0, 0); /* this master is silent but for its messages */
  SET(0x6807, 0, 0);
  SET(0x2050, 1, 0);
  SET(0x2070, 1, 1);
  nmt(0x01);
}

void tearDown(void) {}

static void send_rates(double x_rad_s, double y_rad_s, double z_rad_s) {
  const int16_t x = (int16_t)lround(x_rad_s / COUNT_RAD_S);
  const int16_t y = (int16_t)lround(y_rad_s / COUNT_RAD_S);
  const int16_t z = (int16_t)lround(z_rad_s / COUNT_RAD_S);
  give(MESSAGE_ID, 7,
       (const uint8_t[]){(uint8_t)x, (uint8_t)((uint16_t)x >> 8), (uint8_t)y, (uint8_t)((uint16_t)y >> 8), (uint8_t)z,
                         (uint8_t)((uint16_t)z >> 8), ++counter});
}

static void send_for(unsigned duration_ms, double x_rad_s, double y_rad_s, double z_rad_s) {
  for (unsigned ms = 0; ms < duration_ms; ms += EVERY_MS) {
    send_rates(x_rad_s, y_rad_s, z_rad_s);
    wait_ms(EVERY_MS);
  }
}

static void yaw_for(unsigned duration_ms, double z_rad_s) { send_for(duration_ms, 0.0, 0.0, z_rad_s); }

static unsigned state_of_rates(void) { return (unsigned)get(REPORT, STATE) & 0xFF; }

static double azimuth_rad_s(void) { return machine.axis[0].rate_rad_s; }

static double pitch_rad_s(void) { return machine.axis[1].rate_rad_s; }

static void test_as_delivered_messages_are_counted_and_move_nothing(void) {
  declare_that_the_base_moves(0);
  declare_that_the_base_moves(PITCH);
  enable(0, PV);
  yaw_for(500, 0.1);
  TEST_ASSERT_EQUAL(OFF, state_of_rates());
  TEST_ASSERT_EQUAL(50, get(REPORT, TAKEN));
  CHECK_NEAR("rad/s", 0.0, azimuth_rad_s(), 1e-4);
}

static void test_an_axis_without_a_gyro_turns_against_the_base(void) {
  declare_that_the_base_moves(0);
  declare_that_the_base_moves(PITCH);
  SET(SETTING, USE, 1);
  wait_ms(10);
  TEST_ASSERT_EQUAL(AWAITED, state_of_rates());
  enable(0, PV);
  yaw_for(1000, 0.1);
  TEST_ASSERT_EQUAL(IN_USE, state_of_rates());
  CHECK_NEAR("rad/s", -0.1, azimuth_rad_s(), 1e-3);
  CHECK_NEAR("rad/s", 0.1, get_float(REPORT, ADDED_AZIMUTH), 1e-5);
  CHECK_SAME("rad/s", 0.0, get_float(REPORT, ADDED_PITCH)); /* its gyro sees it */
  CHECK_NEAR("friction feedforward, rad/s", 0.1, node.board.app.axis[0].signals.rates.base_rate_rad_s, 1e-5);
}

static void test_what_is_added_changes_in_even_steps(void) {
  declare_that_the_base_moves(0);
  declare_that_the_base_moves(PITCH);
  SET(SETTING, USE, 1);
  enable(0, PV);
  double last_rad_s = 0.0;
  double largest_rad_s = 0.0;
  for (unsigned ms = 0; ms < 2000; ++ms) {
    if (ms % EVERY_MS == 0) {
      send_rates(0.0, 0.0, 0.1 * sin(6.283185 * 0.5e-3 * ms));
    }
    wait_ms(1);
    const double now_rad_s = (double)node.board.app.axis[0].speed.carried_rad_s;
    largest_rad_s = ms > 200 ? fmax(largest_rad_s, fabs(now_rad_s - last_rad_s)) : 0.0;
    last_rad_s = now_rad_s;
  }
  LOG_VALUE("largest step in a ms, rad/s", largest_rad_s);
  CHECK_AT_MOST("rad/s", 2.0 * 0.1 * 3.1416e-3, largest_rad_s); /* twice what the sine does in a ms */
}

/* 0.1 rad/s in 128 ms, from the first ms to the last one, as it comes and as it goes. */
static void test_rates_that_are_switched_on_or_off_come_and_go_evenly(void) {
  declare_that_the_base_moves(0);
  declare_that_the_base_moves(PITCH);
  enable(0, PV);
  yaw_for(200, 0.1);
  for (uint32_t use = 1; use < 2; --use) {
    double last_rad_s = (double)node.board.app.axis[0].speed.carried_rad_s;
    double largest_rad_s = 0.0;
    SET(SETTING, USE, use);
    for (unsigned ms = 0; ms < 200; ++ms) {
      if (ms % EVERY_MS == 0) {
        send_rates(0.0, 0.0, 0.1);
      }
      wait_ms(1);
      const double now_rad_s = (double)node.board.app.axis[0].speed.carried_rad_s;
      largest_rad_s = fmax(largest_rad_s, fabs(now_rad_s - last_rad_s));
      last_rad_s = now_rad_s;
    }
    CHECK_NEAR("in the end, rad/s", use != 0 ? 0.1 : 0.0, last_rad_s, 1e-5);
    CHECK_NEAR("largest step in a ms, rad/s", 0.1 / 128.0, largest_rad_s, 1e-5);
  }
}

static void test_when_messages_end_the_axis_comes_to_rest(void) {
  declare_that_the_base_moves(0);
  declare_that_the_base_moves(PITCH);
  SET(SETTING, USE, 1);
  enable(0, PV);
  yaw_for(500, 0.1);
  wait_ms(80);
  TEST_ASSERT_EQUAL(IN_USE, state_of_rates());
  wait_ms(30);
  TEST_ASSERT_EQUAL(STALE, state_of_rates());
  wait_ms(400);
  CHECK_NEAR("rad/s", 0.0, azimuth_rad_s(), 1e-3);
  CHECK_NEAR("rad/s", 0.0, node.board.app.axis[0].speed.carried_rad_s, 1e-8);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  yaw_for(500, 0.1);
  TEST_ASSERT_EQUAL(IN_USE, state_of_rates());
  CHECK_NEAR("rad/s", -0.1, azimuth_rad_s(), 1e-3);
  SET(SETTING, USE, 0);
  wait_ms(400);
  TEST_ASSERT_EQUAL(OFF, state_of_rates());
  CHECK_NEAR("rad/s", 0.0, azimuth_rad_s(), 1e-3);
}

static void test_an_axis_whose_base_is_declared_fixed_uses_no_rates(void) {
  declare_that_the_base_moves(PITCH);
  SET(SETTING, USE, 1);
  enable(0, PV);
  yaw_for(500, 0.1);
  TEST_ASSERT_EQUAL(OF_FIXED_BASE, state_of_rates());
  CHECK_NEAR("rad/s", 0.0, azimuth_rad_s(), 1e-4);
  command(0, 0); /* guarded values change while the axes are off */
  declare_that_the_base_moves(0);
  declare_the_base(PITCH, 0.005f);
  enable(0, PV);
  yaw_for(500, 0.1);
  TEST_ASSERT_EQUAL(OF_FIXED_BASE, state_of_rates()); /* the pitch's; the azimuth goes on */
  CHECK_NEAR("rad/s", -0.1, azimuth_rad_s(), 1e-3);
}

/* Azimuth 30 degrees to the left, line of sight 45 degrees up; neither axis has a gyro. */
static void test_each_axis_takes_its_part_of_each_rate_where_it_looks(void) {
  const double psi = 0.5235988;
  static const double rates[3][3] = {{0.1, 0.0, 0.0}, {0.0, 0.1, 0.0}, {0.0, 0.0, 0.1}};
  for (int i = 0; i < 3; ++i) {
    rigid_machine_init(&machine);
    machine.axis[0].turns = 1.0 / 12.0;
    machine.axis[1].turns = 1.0 / 8.0;
    TEST_ASSERT_TRUE(rigid_machine_start_node(&machine, &node, NODE_ID, (can_sender){node_bench_send, NULL}, NULL));
    wait_ms(8);
    map_base();
    for (uint32_t shift = 0; shift <= PITCH; shift += PITCH) {
      SET(0x6007 + shift, 0, 0);
      SET(0x2050 + shift, 1, 0);
      SET(0x2070 + shift, 1, 1);
      declare_that_the_base_moves(shift);
    }
    nmt(0x01);
    SET(SETTING, USE, 1);
    enable(0, PV);
    enable(PITCH, PV);
    send_for(300, rates[i][0], rates[i][1], rates[i][2]);
    const double ahead = cos(psi) * rates[i][0] + sin(psi) * rates[i][1];
    const double left = cos(psi) * rates[i][1] - sin(psi) * rates[i][0];
    CHECK_NEAR("azimuth, rad/s", -(rates[i][2] - ahead), azimuth_rad_s(), 0.006); /* it has turned a little by then */
    CHECK_NEAR("pitch, rad/s", left, pitch_rad_s(), 0.006);
  }
}

static void test_an_axis_that_is_told_to_halt_stops_its_joint(void) {
  declare_that_the_base_moves(0);
  declare_that_the_base_moves(PITCH);
  SET(SETTING, USE, 1);
  enable(0, PV);
  yaw_for(500, 0.1);
  CHECK_NEAR("rad/s", -0.1, azimuth_rad_s(), 1e-3);
  command(0, 0x010F);
  yaw_for(500, 0.1);
  CHECK_NEAR("rad/s", 0.0, azimuth_rad_s(), 1e-3);
  yaw_for(2000, 0.1);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  command(0, 0x000F);
  yaw_for(500, 0.1);
  CHECK_NEAR("rad/s", -0.1, azimuth_rad_s(), 1e-3);
}

static void test_where_a_position_is_held_the_joint_stands(void) {
  declare_that_the_base_moves(0);
  declare_that_the_base_moves(PITCH);
  SET(SETTING, USE, 1);
  enable(0, 1);
  const double before = machine.axis[0].turns;
  yaw_for(1500, 0.1);
  TEST_ASSERT_EQUAL(IN_USE, state_of_rates());
  CHECK_NEAR("rad", 0.0, 6.283185307 * (machine.axis[0].turns - before), 2e-4);
}

/* A second after its last word, although messages come (6007). */
static void test_a_sensor_is_not_the_master(void) {
  declare_that_the_base_moves(0);
  declare_that_the_base_moves(PITCH);
  SET(SETTING, USE, 1);
  SET(0x1402, 5, 200); /* and its messages are monitored */
  SET(0x6007, 0, 3);
  enable(0, PV);
  SET(0x60FF, 0, 100000);
  yaw_for(900, 0.0);
  CHECK_NEAR("rad/s", 0.1, azimuth_rad_s(), 1e-3);
  yaw_for(1500, 0.0);
  CHECK_NEAR("rad/s", 0.0, azimuth_rad_s(), 1e-3);
}

static void test_a_new_scale_forgets_what_has_been_measured(void) {
  SET(SETTING, USE, 1);
  declare_that_the_base_moves(0);
  declare_that_the_base_moves(PITCH);
  yaw_for(100, 0.1);
  TEST_ASSERT_EQUAL(IN_USE, state_of_rates());
  SET_FLOAT(SETTING, SCALE, 1e-5f);
  wait_ms(8);
  TEST_ASSERT_EQUAL(AWAITED, state_of_rates());
}

static void test_a_message_that_another_one_replaces_is_counted(void) {
  const uint32_t before = get(REPORT, TAKEN);
  send_rates(0.0, 0.0, 0.1);
  send_rates(0.0, 0.0, 0.2);
  wait_ms(8);
  TEST_ASSERT_EQUAL(before + 1, get(REPORT, TAKEN));
  TEST_ASSERT_EQUAL(1, get(REPORT, DROPPED));
  TEST_ASSERT_EQUAL(4, get(REPORT, LAST_DROP) & 0xFF);
}

static void test_messages_that_do_not_count_are_counted_with_a_reason(void) {
  declare_that_the_base_moves(0);
  declare_that_the_base_moves(PITCH);
  SET(SETTING, USE, 1);
  enable(0, PV);
  yaw_for(200, 0.05);
  const uint32_t taken = get(REPORT, TAKEN);
  TEST_ASSERT_EQUAL(0, get(REPORT, DROPPED));
  send_rates(0.0, 0.0, 0.6);
  wait_ms(EVERY_MS);
  TEST_ASSERT_EQUAL(1, get(REPORT, DROPPED));
  TEST_ASSERT_EQUAL(2, get(REPORT, LAST_DROP) & 0xFF);
  --counter;
  send_rates(0.0, 0.0, 0.05);
  wait_ms(EVERY_MS);
  TEST_ASSERT_EQUAL(2, get(REPORT, DROPPED));
  TEST_ASSERT_EQUAL(1, get(REPORT, LAST_DROP) & 0xFF);
  TEST_ASSERT_EQUAL(taken, get(REPORT, TAKEN));
  CHECK_NEAR("rad/s", 0.05, get_float(REPORT, ADDED_AZIMUTH), 1e-5);
}

static void test_only_a_reset_of_the_node_forgets_the_messages(void) {
  declare_that_the_base_moves(0);
  declare_that_the_base_moves(PITCH);
  SET(SETTING, USE, 1);
  yaw_for(100, 0.05);
  send_rates(0.0, 0.0, 0.6);
  wait_ms(EVERY_MS);
  const uint32_t taken = get(REPORT, TAKEN);
  nmt(0x82);
  wait_ms(100);
  TEST_ASSERT_EQUAL(taken, get(REPORT, TAKEN));
  nmt(0x81);
  wait_ms(100);
  TEST_ASSERT_EQUAL(0, get(REPORT, TAKEN));
  TEST_ASSERT_EQUAL(0, get(REPORT, DROPPED));
  TEST_ASSERT_EQUAL(0, get(REPORT, LAST_DROP) & 0xFF);
  TEST_ASSERT_EQUAL(OFF, state_of_rates()); /* 3077:1 has not been stored */
  SET(SETTING, USE, 1);
  wait_ms(10);
  TEST_ASSERT_EQUAL(AWAITED, state_of_rates()); /* none since the reset */
}

static void test_settings_are_kept_in_range(void) {
  TEST_ASSERT_EQUAL_HEX32(0x06090031, set(SETTING, USE, 2));
  TEST_ASSERT_EQUAL_HEX32(0x06090031, set_float(SETTING, SCALE, 2e-3f));
  TEST_ASSERT_EQUAL_HEX32(0x06090031, set(SETTING, DELAY, 5001));
  TEST_ASSERT_EQUAL_HEX32(0x06090031, set_float(SETTING, LARGEST, 11.0f));
  TEST_ASSERT_EQUAL_HEX32(0x06090032, set_float(SETTING, BANDWIDTH, 0.5f));
  TEST_ASSERT_EQUAL_HEX32(0x06090032, set(SETTING, TIMEOUT, 9));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_as_delivered_messages_are_counted_and_move_nothing);
  RUN_TEST(test_an_axis_without_a_gyro_turns_against_the_base);
  RUN_TEST(test_what_is_added_changes_in_even_steps);
  RUN_TEST(test_rates_that_are_switched_on_or_off_come_and_go_evenly);
  RUN_TEST(test_when_messages_end_the_axis_comes_to_rest);
  RUN_TEST(test_an_axis_whose_base_is_declared_fixed_uses_no_rates);
  RUN_TEST(test_messages_that_do_not_count_are_counted_with_a_reason);
  RUN_TEST(test_only_a_reset_of_the_node_forgets_the_messages);
  RUN_TEST(test_settings_are_kept_in_range);
  RUN_TEST(test_each_axis_takes_its_part_of_each_rate_where_it_looks);
  RUN_TEST(test_an_axis_that_is_told_to_halt_stops_its_joint);
  RUN_TEST(test_where_a_position_is_held_the_joint_stands);
  RUN_TEST(test_a_sensor_is_not_the_master);
  RUN_TEST(test_a_new_scale_forgets_what_has_been_measured);
  RUN_TEST(test_a_message_that_another_one_replaces_is_counted);
  return UNITY_END();
}
