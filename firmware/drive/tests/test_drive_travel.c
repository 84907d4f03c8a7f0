/* SPDX-License-Identifier: Apache-2.0 */
/* The travel that set-points may use: the limits in effect from 607D, 2060 and the motor, and the stops that keep
 * within
 * them. */
#include "drive/drive_travel.h"

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

static const float dt_s = 1e-3f;

static drive_objects objects_default(void) {
  drive_objects o = {0};
  o.torque.rated_mnm = 40000;
  o.torque.maximum = 1000;
  o.torque.positive_limit = 1000;
  o.torque.negative_limit = 1000;
  o.limit.maximum_velocity = 1000000;
  return o;
}

static const drive_machine machine = {.hard = {-10000000, 20000000},
                                      .margin = 50000,
                                      .overspeed_rad_s = 1.5f,
                                      .torque_nm = 40.0f,
                                      .deceleration_rad_s2 = 5.0f};

static drive_bounds bounds_of(const drive_objects *objects, const drive_machine *of) {
  drive_bounds bounds = {.rate_rad_s = 0.0f};
  drive_bounds_update(&bounds, objects, of);
  return bounds;
}

static void test_the_travel_ends_a_margin_within_the_hard_one_and_607d_narrows_it(void) {
  drive_objects o = objects_default();
  drive_bounds b = bounds_of(&o, &machine);
  TEST_ASSERT_EQUAL_INT32(-9950000, b.travel.minimum);
  TEST_ASSERT_EQUAL_INT32(19950000, b.travel.maximum);
  o.limit.position_minimum = -1000000;
  o.limit.position_maximum = 20000000; /* within the hard travel, in its margin */
  drive_bounds_update(&b, &o, &machine);
  TEST_ASSERT_EQUAL_INT32(-1000000, b.travel.minimum);
  TEST_ASSERT_EQUAL_INT32(19950000, b.travel.maximum);
}

static void test_a_contradiction_of_607d_leaves_the_last_travel(void) {
  drive_objects o = objects_default();
  o.limit.position_minimum = -1000000;
  o.limit.position_maximum = 1000000;
  drive_bounds b = bounds_of(&o, &machine);
  o.limit.position_minimum = 1000001;
  drive_bounds_update(&b, &o, &machine);
  TEST_ASSERT_EQUAL_INT32(-1000000, b.travel.minimum);
  o.limit.position_minimum = 1000000; /* equal: not limited by it */
  drive_bounds_update(&b, &o, &machine);
  TEST_ASSERT_EQUAL_INT32(-9950000, b.travel.minimum);
}

static void test_the_rate_is_607f_or_80_percent_of_the_over_speed(void) {
  drive_objects o = objects_default();
  CHECK_SAME("rad/s", 1.0, bounds_of(&o, &machine).rate_rad_s);
  o.limit.maximum_velocity = UINT32_MAX;
  CHECK_NEAR("rad/s", 1.2, bounds_of(&o, &machine).rate_rad_s, 1e-6);
  const drive_machine low = {.overspeed_rad_s = 0.5f};
  CHECK_NEAR("rad/s", 0.4, bounds_of(&o, &low).rate_rad_s, 1e-6);
  const drive_machine unknown = {.margin = 0};
  CHECK_NEAR("rad/s", 800.0, bounds_of(&o, &unknown).rate_rad_s, 1e-3);
}

static void test_62_percent_of_the_sure_deceleration_brake_and_the_torque_limits_take_from_it(void) {
  drive_objects o = objects_default();
  CHECK_NEAR("rad/s^2", 3.1, bounds_of(&o, &machine).braking_rad_s2, 1e-5);
  o.torque.negative_limit = 500;
  CHECK_NEAR("rad/s^2", 1.55, bounds_of(&o, &machine).braking_rad_s2, 1e-5);
  o.torque.maximum = 100;
  CHECK_NEAR("rad/s^2", 0.31, bounds_of(&o, &machine).braking_rad_s2, 1e-5);
  o.torque.positive_limit = 0;
  CHECK_NEAR("rad/s^2", 1e-3, bounds_of(&o, &machine).braking_rad_s2, 1e-6);
  const drive_machine unknown = {.margin = 0};
  CHECK_SAME("rad/s^2", 4300.0, bounds_of(&o, &unknown).braking_rad_s2);
  const drive_machine unknown_torque = {.deceleration_rad_s2 = 5.0f};
  CHECK_SAME("rad/s^2", 4300.0, bounds_of(&o, &unknown_torque).braking_rad_s2);
  const drive_machine unknown_braking = {.torque_nm = 40.0f};
  CHECK_SAME("rad/s^2", 4300.0, bounds_of(&o, &unknown_braking).braking_rad_s2);
}

static void test_slow_motion_and_an_unknown_position_narrow_the_bounds(void) {
  const drive_objects o = objects_default();
  drive_machine slow = machine;
  slow.slow = true;
  CHECK_NEAR("rad/s", 0.8 * 0.0872665, bounds_of(&o, &slow).rate_rad_s, 1e-6);
  drive_bounds b = bounds_of(&o, &slow);
  TEST_ASSERT_TRUE(drive_travel_is_limited(&b.travel));
  slow.position_unknown = true;
  b = bounds_of(&o, &slow);
  TEST_ASSERT_TRUE(b.position_unknown);
  TEST_ASSERT_FALSE(drive_travel_is_limited(&b.travel));
}

static void test_an_ordered_stop_is_no_more_gentle_than_protection_allows(void) {
  const drive_objects o = objects_default();
  drive_machine limited = machine;
  limited.stop_deceleration_rad_s2 = 1.0f;
  const drive_bounds b = bounds_of(&o, &limited);
  profile_limits stop = {.rate_rad_s = 1.0f, .deceleration_rad_s2 = 1e-6f, .jerk_rad_s3 = 1e-6f};
  profile_ramp ramp = {.rate_rad_s = 1.0f, .acceleration_rad_s2 = 20.0f};
  drive_stop_at_least(&b, &stop, &ramp);
  CHECK_SAME("rad/s^2", 1.0, stop.deceleration_rad_s2);
  CHECK_SAME("rad/s^3", 4.0, stop.jerk_rad_s3);
  CHECK_NEAR("rad/s^2", sqrt(2.0 * 0.05 * 4.0), ramp.acceleration_rad_s2, 1e-5); /* gains 0.05 rad/s */
  stop = (profile_limits){.rate_rad_s = 1.0f, .deceleration_rad_s2 = 3.0f, .jerk_rad_s3 = 50.0f};
  ramp = (profile_ramp){.rate_rad_s = 1.0f, .acceleration_rad_s2 = -20.0f}; /* brakes already */
  drive_stop_at_least(&b, &stop, &ramp);
  CHECK_SAME("rad/s^2", 3.0, stop.deceleration_rad_s2);
  CHECK_SAME("rad/s^3", 50.0, stop.jerk_rad_s3);
  CHECK_SAME("rad/s^2", -20.0, ramp.acceleration_rad_s2);
}

static void test_sides_and_rooms(void) {
  const drive_objects o = objects_default();
  const drive_bounds b = bounds_of(&o, &machine);
  CHECK_SAME("side", 0.0, drive_travel_side(&b, drive_angle_from_position(0)));
  CHECK_SAME("side", 1.0, drive_travel_side(&b, drive_angle_from_position(19950000)));
  CHECK_SAME("side", -1.0, drive_travel_side(&b, drive_angle_from_position(-9960000)));
  CHECK_NEAR("rad", 1.995, drive_travel_room_rad(&b, 0, 1.0f), 1e-6);
  CHECK_NEAR("rad", -0.995, drive_travel_room_rad(&b, 0, -1.0f), 1e-6);
  const drive_bounds unlimited = {.travel = {0, 0}};
  CHECK_SAME("side", 0.0, drive_travel_side(&unlimited, 5));
  TEST_ASSERT_EQUAL_INT32(7, drive_travel_clamp(&unlimited.travel, 7));
}

static void test_a_stop_that_would_lead_out_brakes_as_hard_as_it_must(void) {
  const drive_objects o = objects_default();
  const drive_bounds b = bounds_of(&o, &machine);
  const profile_limits gentle = {
      .rate_rad_s = 1.0f, .acceleration_rad_s2 = 1.0f, .deceleration_rad_s2 = 0.5f, .jerk_rad_s3 = 5.0f};
  const struct {
    double room_rad, rate_rad_s, deceleration_rad_s2; /* 0: unchanged */
  } cases[] = {{1.9, 1.0, 0.0}, {0.5, 1.0, 1.0},  {0.5, -1.0, 0.0}, {0.2, 1.0, 2.5},
               {0.1, 1.0, 3.1}, {-0.1, 1.0, 3.1}, {0.0, 0.0, 0.0},  {1e-3, 1e-3, 0.0}};
  for (unsigned k = 0; k < 2 * sizeof cases / sizeof cases[0]; ++k) {
    const unsigned i = k / 2;
    const double side = k % 2 == 0 ? 1.0 : -1.0; /* each case at both ends */
    profile_limits stop = gentle;
    const profile_ramp ramp = {.rate_rad_s = (float)(side * cases[i].rate_rad_s)};
    const double end = side > 0.0 ? 19950000.0 : -9950000.0;
    const drive_angle at = drive_angle_from_position((int32_t)(end - side * 1e7 * cases[i].room_rad));
    const bool changed = drive_stop_within(&b, &stop, &ramp, at);
    TEST_ASSERT_EQUAL_MESSAGE(cases[i].deceleration_rad_s2 != 0.0, changed, "case");
    CHECK_NEAR("rad/s^2", changed ? cases[i].deceleration_rad_s2 : 0.5, stop.deceleration_rad_s2, 0.01);
    if (changed && cases[i].room_rad >= 0.2) {
      CHECK_AT_MOST("travel, rad", cases[i].room_rad + 2e-3, side * (double)profile_stop_travel_rad(&ramp, &stop));
    }
  }
}

/* From any position and rate, the stop ends within the travel. */
static void test_a_rate_held_to_the_travel_can_be_stopped_in_it(void) {
  const drive_objects o = objects_default();
  const drive_bounds b = bounds_of(&o, &machine);
  for (int direction = -1; direction <= 1; direction += 2) {
    for (double room_rad = 2.0; room_rad > 1e-7; room_rad *= 0.7) {
      const double end = direction < 0 ? -9950000.0 : 19950000.0;
      const drive_angle at = drive_angle_from_position((int32_t)(end - direction * 1e7 * room_rad));
      for (float jerk = 1.0f; jerk < 1e5f; jerk *= 10.0f) {
        const profile_limits braking = {.deceleration_rad_s2 = 3.0f, .jerk_rad_s3 = jerk};
        const float rate_rad_s = drive_rate_within(&b, &braking, at, (float)direction * 5.0f, dt_s);
        TEST_ASSERT_TRUE((float)direction * rate_rad_s >= 0.0f);
        const profile_ramp ramp = {.rate_rad_s = rate_rad_s};
        CHECK_AT_MOST("travel, rad", room_rad * 1.001 + 1e-7,
                      direction * (double)profile_stop_travel_rad(&ramp, &braking));
        CHECK_SAME("inwards, rad/s", -direction * 0.125,
                   drive_rate_within(&b, &braking, at, (float)-direction * 0.125f, dt_s));
      }
    }
  }
  const profile_limits braking = {.deceleration_rad_s2 = 3.0f, .jerk_rad_s3 = 50.0f};
  const drive_angle outside = drive_angle_from_position(20000000);
  CHECK_SAME("outwards, rad/s", 0.0, drive_rate_within(&b, &braking, outside, 1.0f, dt_s));
  CHECK_SAME("inwards, rad/s", -0.5, drive_rate_within(&b, &braking, outside, -0.5f, dt_s));
  const drive_bounds none = {.rate_rad_s = 1.0f};
  CHECK_SAME("not limited, rad/s", 7.0, drive_rate_within(&none, &braking, outside, 7.0f, dt_s));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_travel_ends_a_margin_within_the_hard_one_and_607d_narrows_it);
  RUN_TEST(test_a_contradiction_of_607d_leaves_the_last_travel);
  RUN_TEST(test_the_rate_is_607f_or_80_percent_of_the_over_speed);
  RUN_TEST(test_62_percent_of_the_sure_deceleration_brake_and_the_torque_limits_take_from_it);
  RUN_TEST(test_slow_motion_and_an_unknown_position_narrow_the_bounds);
  RUN_TEST(test_an_ordered_stop_is_no_more_gentle_than_protection_allows);
  RUN_TEST(test_sides_and_rooms);
  RUN_TEST(test_a_stop_that_would_lead_out_brakes_as_hard_as_it_must);
  RUN_TEST(test_a_rate_held_to_the_travel_can_be_stopped_in_it);
  return UNITY_END();
}
