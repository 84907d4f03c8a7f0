/* SPDX-License-Identifier: Apache-2.0 */
/* The set-point handshake of pp: bits 4 to 6 of the controlword and 60F2 in, targets out. */
#include "drive/setpoint_queue.h"

#include "drive/drive_state.h"
#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

enum {
  new_setpoint = DRIVE_CONTROL_NEW_SETPOINT,
  now_bit = DRIVE_CONTROL_CHANGE_IMMEDIATELY,
  relative = DRIVE_CONTROL_RELATIVE
};

static const drive_angle turn = INT64_C(1) << 32;
static const drive_travel one_rad = {-10000000, 10000000};

static bool step(setpoint_queue *queue, uint16_t controlword, int32_t target) {
  const setpoint_order order = {
      .controlword = controlword, .target = target, .demand = queue->target.angle, .wraps = false};
  return setpoint_queue_step(queue, &order);
}

static setpoint_queue queue_at(int32_t position) {
  setpoint_queue queue;
  setpoint_queue_reset(&queue, drive_angle_from_position(position), true);
  (void)step(&queue, 0x0F, 0);
  return queue;
}

static void check_target(int64_t counts, const setpoint_queue *queue) {
  TEST_ASSERT_EQUAL_INT64(counts, queue->target.counts);
  TEST_ASSERT_EQUAL_INT64(queue->target.origin + drive_angle_from_position(counts), queue->target.angle);
}

static void test_a_set_point_is_taken_on_the_rising_edge_and_acknowledged_until_bit_4_falls(void) {
  setpoint_queue queue = queue_at(5);
  TEST_ASSERT_FALSE(queue.acknowledged);
  TEST_ASSERT_TRUE(step(&queue, 0x0F | new_setpoint, 100));
  TEST_ASSERT_TRUE(queue.acknowledged && queue.under_way);
  TEST_ASSERT_FALSE(step(&queue, 0x0F | new_setpoint, 200)); /* no edge */
  check_target(100, &queue);
  TEST_ASSERT_TRUE(queue.acknowledged);
  (void)step(&queue, 0x0F, 200);
  TEST_ASSERT_FALSE(queue.acknowledged);
}

static void test_a_second_set_point_waits_and_a_third_is_dropped(void) {
  setpoint_queue queue = queue_at(0);
  (void)step(&queue, new_setpoint, 100);
  (void)step(&queue, 0, 0);
  TEST_ASSERT_FALSE(step(&queue, new_setpoint, 200));
  (void)step(&queue, 0, 0);
  TEST_ASSERT_TRUE(queue.acknowledged); /* no room for another */
  (void)step(&queue, new_setpoint, 300);
  check_target(100, &queue);
  TEST_ASSERT_TRUE(setpoint_queue_finish(&queue));
  check_target(200, &queue);
  (void)step(&queue, 0, 0);
  TEST_ASSERT_FALSE(queue.acknowledged);
  TEST_ASSERT_FALSE(setpoint_queue_finish(&queue));
  TEST_ASSERT_FALSE(queue.under_way);
  check_target(200, &queue);
}

static void test_a_change_immediately_replaces_what_is_under_way_and_what_waits(void) {
  setpoint_queue queue = queue_at(0);
  (void)step(&queue, new_setpoint, 100);
  (void)step(&queue, 0, 0);
  (void)step(&queue, new_setpoint, 200);
  (void)step(&queue, 0, 0);
  TEST_ASSERT_TRUE(step(&queue, new_setpoint | now_bit, 300));
  check_target(300, &queue);
  TEST_ASSERT_FALSE(setpoint_queue_finish(&queue));
}

static void test_relative_set_points_count_from_the_target_before_them(void) {
  setpoint_queue queue = queue_at(1000);
  (void)step(&queue, new_setpoint | relative, 10);
  check_target(1010, &queue);
  (void)step(&queue, 0, 0);
  (void)step(&queue, new_setpoint | relative, 5);
  (void)step(&queue, 0, 0);
  (void)setpoint_queue_finish(&queue);
  check_target(1015, &queue);
  (void)step(&queue, new_setpoint | relative | now_bit, INT32_MAX);
  check_target(1015 + (int64_t)INT32_MAX, &queue);
}

/* The one that waits has never been a target. */
static void test_a_relative_change_immediately_counts_from_what_is_under_way(void) {
  setpoint_queue queue = queue_at(0);
  (void)step(&queue, new_setpoint, 100);
  (void)step(&queue, 0, 0);
  (void)step(&queue, new_setpoint, 200);
  (void)step(&queue, 0, 0);
  TEST_ASSERT_TRUE(step(&queue, new_setpoint | relative | now_bit, 10));
  check_target(110, &queue);
  TEST_ASSERT_FALSE(queue.waiting);
}

static void test_a_thousand_relative_set_points_add_up_to_the_count(void) {
  setpoint_queue queue = queue_at(7);
  for (int i = 0; i < 1000; ++i) {
    (void)step(&queue, new_setpoint | relative | now_bit, 31415927);
    (void)step(&queue, 0, 0);
  }
  check_target(7 + INT64_C(31415927000), &queue); /* 500 turns */
}

static void test_relative_set_points_without_end_stay_far_away_and_defined(void) {
  for (int side = -1; side <= 1; side += 2) {
    setpoint_queue queue = queue_at(0);
    queue.target.counts = side * (INT64_C(1) << 55);
    (void)step(&queue, new_setpoint | relative | now_bit, side < 0 ? INT32_MIN : INT32_MAX);
    check_target(side * (INT64_C(1) << 55), &queue);
  }
}

static void test_60f2_chooses_what_relative_set_points_count_from(void) {
  static const struct {
    uint16_t option;
    int64_t expected;
  } cases[] = {{SETPOINT_FROM_TARGET, 1010}, {SETPOINT_FROM_DEMAND, 510}, {SETPOINT_FROM_ACTUAL, 460}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    setpoint_queue queue = queue_at(1000);
    const setpoint_order order = {.controlword = new_setpoint | relative | now_bit,
                                  .target = 10,
                                  .option = cases[i].option,
                                  .demand = drive_angle_from_position(500),
                                  .actual = drive_angle_from_position(450)};
    TEST_ASSERT_TRUE(setpoint_queue_step(&queue, &order));
    check_target(cases[i].expected, &queue);
  }
}

static void test_a_target_beyond_the_travel_is_its_end_and_the_next_counts_from_there(void) {
  setpoint_queue queue = queue_at(9000000);
  (void)step(&queue, new_setpoint | relative, 5000000);
  setpoint_queue_limit(&queue, &one_rad);
  check_target(10000000, &queue);
  TEST_ASSERT_TRUE(queue.target.limited);
  (void)setpoint_queue_finish(&queue);
  (void)step(&queue, 0, 0);
  (void)step(&queue, new_setpoint | relative, -2000000);
  setpoint_queue_limit(&queue, &one_rad);
  check_target(8000000, &queue);
  TEST_ASSERT_FALSE(queue.target.limited);
}

static void test_a_travel_that_shrinks_takes_both_targets_along_and_gives_none_back(void) {
  static const drive_travel narrow = {-1000, 1000};
  setpoint_queue queue = queue_at(0);
  (void)step(&queue, new_setpoint, 9000000);
  (void)step(&queue, 0, 0);
  (void)step(&queue, new_setpoint, -9000000);
  setpoint_queue_limit(&queue, &one_rad);
  TEST_ASSERT_FALSE(queue.target.limited || queue.next.limited);
  setpoint_queue_limit(&queue, &narrow);
  setpoint_queue_limit(&queue, &one_rad);
  check_target(1000, &queue);
  (void)setpoint_queue_finish(&queue);
  check_target(-1000, &queue);
  TEST_ASSERT_TRUE(queue.target.limited);
}

static void test_a_target_in_another_range_is_beyond_any_travel(void) {
  for (int side = -1; side <= 1; side += 2) {
    setpoint_queue queue = queue_at(0);
    queue.target.origin = side * DRIVE_RANGE;
    setpoint_queue_limit(&queue, &one_rad);
    TEST_ASSERT_EQUAL_INT64(0, queue.target.origin);
    check_target(side * 10000000, &queue);
  }
}

/* From `from` turns with 607A = `target` turns: how many turns the axis has to make, by 60F2. */
static void test_absolute_set_points_go_the_way_of_60f2(void) {
  static const struct {
    double from;
    double target;
    uint16_t option;
    double way;
  } cases[] = {{30.0, -30.0, SETPOINT_STRAIGHT, -60.0}, {30.0, -30.0, SETPOINT_SHORTER, 4.0},
               {30.0, -30.0, SETPOINT_UP, 4.0},         {30.0, -30.0, SETPOINT_DOWN, -60.0},
               {10.0, 11.0, SETPOINT_UP, 1.0},          {10.0, 11.0, SETPOINT_DOWN, -63.0},
               {10.0, 9.0, SETPOINT_UP, 63.0},          {10.0, 9.0, SETPOINT_DOWN, -1.0},
               {10.0, 10.0, SETPOINT_UP, 0.0},          {10.0, 10.0, SETPOINT_DOWN, 0.0},
               {1000.0, -23.0, SETPOINT_STRAIGHT, 1.0}, {-1000.0, 25.0, SETPOINT_STRAIGHT, 1.0},
               {31.0, 33.0, SETPOINT_STRAIGHT, -62.0},  {31.0, 33.0, SETPOINT_SHORTER, 2.0},
               {1000.0, 25.0, SETPOINT_SHORTER, -15.0}, {96.0, 31.0, SETPOINT_SHORTER, -1.0}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    const drive_angle from = (drive_angle)cases[i].from * turn;
    setpoint_queue queue;
    setpoint_queue_reset(&queue, from, false);
    const setpoint_order order = {.controlword = new_setpoint,
                                  .target = (int32_t)lrint(cases[i].target * 62831853.0718),
                                  .option = cases[i].option,
                                  .demand = from,
                                  .actual = from,
                                  .wraps = true};
    TEST_ASSERT_TRUE(setpoint_queue_step(&queue, &order));
    CHECK_NEAR("way, turns", cases[i].way, (double)(queue.target.angle - from) / (double)turn, 1e-8);
  }
}

/* The one under way ends 4 turns up, in the next range: the waiting one goes on from there. */
static void test_a_waiting_absolute_set_point_goes_on_from_the_target_before_it(void) {
  setpoint_queue queue;
  setpoint_queue_reset(&queue, 30 * turn, false);
  const setpoint_order up = {.controlword = new_setpoint | relative, .target = 251327412, .demand = 30 * turn};
  const setpoint_order none = {.controlword = 0};
  const setpoint_order next = {
      .controlword = new_setpoint, .target = -1884955592, .demand = 30 * turn, .actual = 30 * turn, .wraps = true};
  (void)setpoint_queue_step(&queue, &up);
  (void)setpoint_queue_step(&queue, &none);
  (void)setpoint_queue_step(&queue, &next);
  (void)setpoint_queue_finish(&queue);
  CHECK_NEAR("target, turns", 34.0, (double)queue.target.angle / (double)turn, 1e-7);
}

static void test_a_bit_4_that_was_set_before_the_mode_is_not_an_edge(void) {
  setpoint_queue queue;
  setpoint_queue_reset(&queue, 0, true);
  TEST_ASSERT_FALSE(step(&queue, new_setpoint, 100));
  TEST_ASSERT_FALSE(queue.acknowledged);
  setpoint_queue_idle(&queue, 0x0F);
  setpoint_queue_reset(&queue, 0, queue.edge_before);
  TEST_ASSERT_TRUE(step(&queue, new_setpoint, 100));
  TEST_ASSERT_TRUE(queue.acknowledged);
  setpoint_queue_idle(&queue, new_setpoint);
  setpoint_queue_reset(&queue, 0, queue.edge_before);
  TEST_ASSERT_FALSE(step(&queue, new_setpoint, 100));
}

static void test_60f2_takes_three_bases_and_four_ways(void) {
  for (unsigned option = 0; option <= UINT16_MAX; ++option) {
    const bool good = (option & 0x3F) <= 2 && option <= 0xFF;
    TEST_ASSERT_EQUAL(good, setpoint_option_supported((uint16_t)option));
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_set_point_is_taken_on_the_rising_edge_and_acknowledged_until_bit_4_falls);
  RUN_TEST(test_a_second_set_point_waits_and_a_third_is_dropped);
  RUN_TEST(test_a_change_immediately_replaces_what_is_under_way_and_what_waits);
  RUN_TEST(test_relative_set_points_count_from_the_target_before_them);
  RUN_TEST(test_a_relative_change_immediately_counts_from_what_is_under_way);
  RUN_TEST(test_a_thousand_relative_set_points_add_up_to_the_count);
  RUN_TEST(test_relative_set_points_without_end_stay_far_away_and_defined);
  RUN_TEST(test_60f2_chooses_what_relative_set_points_count_from);
  RUN_TEST(test_a_target_beyond_the_travel_is_its_end_and_the_next_counts_from_there);
  RUN_TEST(test_a_travel_that_shrinks_takes_both_targets_along_and_gives_none_back);
  RUN_TEST(test_a_target_in_another_range_is_beyond_any_travel);
  RUN_TEST(test_absolute_set_points_go_the_way_of_60f2);
  RUN_TEST(test_a_waiting_absolute_set_point_goes_on_from_the_target_before_it);
  RUN_TEST(test_a_bit_4_that_was_set_before_the_mode_is_not_an_edge);
  RUN_TEST(test_60f2_takes_three_bases_and_four_ways);
  return UNITY_END();
}
