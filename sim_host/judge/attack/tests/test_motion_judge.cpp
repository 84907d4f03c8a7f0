// SPDX-License-Identifier: Apache-2.0
// The judge sees what it must see: contacts with end stops and axes that run away.
#include <algorithm>
#include <climits>
#include <cmath>
#include <cstdio>

#include "judge/attack/attack_run.hpp"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

const sim::NodeSetup& setup() {
  static const sim::NodeSetup made(sim::load_plant("sim_host/plants/tracker.toml"));
  return made;
}

// An axis without torque that is pushed from outside; the upper end stop of pitch is at 95 degrees.
sim::Harm harm_of_a_push(double from_deg, double push_nm, int ticks, std::size_t axis = sim::kPitch) {
  sim::DrivenNode node(setup(), 1, {0.0, from_deg * sim::kRadPerDeg});
  sim::MotionJudge judge(setup());
  node.machine().broken().axis[axis].push_nm = push_nm;
  for (int i = 0; i < ticks; ++i) {
    node.tick();
    judge.look(node, i * sim::kTick_s);
  }
  return judge.harm();
}

void test_a_push_into_the_end_stop_is_a_hard_contact() {
  const sim::Harm harm = harm_of_a_push(85.0, 30.0, 1000);
  const sim::EndStopContacts& contacts = harm.axis[sim::kPitch].contacts;
  std::printf("%.1f deg/s, %.0f Nm, %.2f J\n", contacts.speed_rad_s / sim::kRadPerDeg, contacts.torque_nm,
              contacts.energy_j);
  TEST_ASSERT_TRUE(harm.hits_hard());
  TEST_ASSERT_EQUAL(0, harm.axis[sim::kAzimuth].contacts.count);
  TEST_ASSERT_TRUE(contacts.torque_nm > 30.0);
  // v sqrt(J k), less what the stop's damping takes; 2.5 kg m2 and 50000 Nm/rad.
  TEST_ASSERT_DOUBLE_WITHIN(0.5 * contacts.torque_nm, contacts.torque_nm, contacts.speed_rad_s * 354.0);
  TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.5 * 2.5 * contacts.speed_rad_s * contacts.speed_rad_s, contacts.energy_j);
}

void test_a_slow_contact_does_no_harm() {
  const sim::Harm harm = harm_of_a_push(94.99, 20.0, 300);
  TEST_ASSERT_TRUE(harm.axis[sim::kPitch].contacts.count > 0);
  TEST_ASSERT_FALSE(harm.hits_hard());
  TEST_ASSERT_FALSE(harm.runs_away());
}

void test_an_axis_beyond_its_speed_limit_runs_away() {
  const sim::Harm harm = harm_of_a_push(0.0, 200.0, 150);
  TEST_ASSERT_EQUAL(sim::Runaway::kTooFast, harm.axis[sim::kPitch].runaway);
}

void test_an_axis_that_turns_on_without_a_command_runs_away() {
  const sim::Harm harm = harm_of_a_push(0.0, 15.0, 4000, sim::kAzimuth);
  TEST_ASSERT_EQUAL(sim::Runaway::kNotStopped, harm.axis[sim::kAzimuth].runaway);
  TEST_ASSERT_TRUE(harm.axis[sim::kAzimuth].runaway_time_s >= sim::kStopTime_s);
}

constexpr int kStill = 3100;  // ticks until standstill is demanded

// Azimuth enabled in csv at set-point 0; then it gets a torque limit in thousandths, and a push of some ticks, and may
// lose its power some ticks later.
sim::AxisHarm harm_while_enabled(int limit, double push_nm, int push_ticks, int powered_ticks = INT_MAX) {
  sim::DrivenNode node(setup(), 1, {0.0, 0.0});
  sim::MotionJudge judge(setup());
  node.enable(DRIVE_CYCLIC_VELOCITY);
  for (int i = 0; i < kStill + 500; ++i) {
    if (i == kStill) {
      node.write(sim::kAzimuth, 0x6072, 0, limit);
    }
    if (i - kStill == powered_ticks) {
      node.write(sim::kAzimuth, 0x6040, 0, 0);
    }
    const bool pushed = i > kStill && i <= kStill + push_ticks;
    node.machine().broken().axis[sim::kAzimuth].push_nm = pushed ? push_nm : 0.0;
    node.set_rate(sim::kAzimuth, 0.0);
    node.tick();
    judge.look(node, i * sim::kTick_s);
  }
  const sim::AxisHarm& harm = judge.harm().axis[sim::kAzimuth];
  std::printf("limit %d, %.0f Nm for %d ms: %.2f rad/s, fault %d\n", limit, push_nm, push_ticks, harm.max_rate_rad_s,
              static_cast<int>(node.axis(sim::kAzimuth).drive.fault));
  return harm;
}

void test_wind_may_turn_an_axis_that_may_not_use_its_torque() {
  const sim::AxisHarm harm = harm_while_enabled(0, 25.0, 150);
  TEST_ASSERT_TRUE(harm.max_rate_rad_s > 2.0 * sim::kTurning_rad_s);
  TEST_ASSERT_EQUAL(sim::Runaway::kNone, harm.runaway);
}

// The master cuts its power while it turns slower than 0.1 rad/s.
void test_wind_may_turn_such_an_axis_without_power_too() {
  const sim::AxisHarm harm = harm_while_enabled(0, 25.0, 400, 20);
  TEST_ASSERT_TRUE(harm.max_rate_rad_s > 2.0 * sim::kTurning_rad_s);
  TEST_ASSERT_EQUAL(sim::Runaway::kNone, harm.runaway);
}

void test_an_axis_that_is_pushed_harder_than_its_motor_runs_away() {
  TEST_ASSERT_EQUAL(sim::Runaway::kNotStopped, harm_while_enabled(1000, 70.0, 150).runaway);
}

void test_a_short_push_is_no_runaway() {
  const sim::AxisHarm harm = harm_while_enabled(1000, 70.0, 50);
  TEST_ASSERT_TRUE(harm.max_rate_rad_s > sim::kTurning_rad_s);
  TEST_ASSERT_EQUAL(sim::Runaway::kNone, harm.runaway);
}

// 1 rad/s for a tick, then disable operation with 1 rad/s2: the axis turns for as long as the ramp lasts.
void test_a_stop_in_the_tick_after_a_set_point_may_take_its_time() {
  sim::DrivenNode node(setup(), 1, {0.0, 0.0});
  sim::MotionJudge judge(setup());
  node.write(sim::kAzimuth, 0x6084, 0, 1'000'000);
  node.write(sim::kAzimuth, 0x60C2, 1, 1);
  node.enable(DRIVE_CYCLIC_VELOCITY);
  for (int i = 0; i < kStill + 1500; ++i) {
    node.set_rate(sim::kAzimuth, i == kStill ? -1.0 : 0.0);
    if (i == kStill + 1) {
      node.write(sim::kAzimuth, 0x6040, 0, 7);
    }
    node.tick();
    judge.look(node, i * sim::kTick_s);
  }
  const sim::AxisHarm& harm = judge.harm().axis[sim::kAzimuth];
  std::printf("%.2f rad/s\n", harm.max_rate_rad_s);
  TEST_ASSERT_TRUE(harm.max_rate_rad_s > 2.0 * sim::kTurning_rad_s);
  TEST_ASSERT_EQUAL(sim::Runaway::kNone, harm.runaway);
}

// Each half period is short, but they add up. Without torque the axis swings as an unstable loop would swing it.
void test_an_axis_that_swings_runs_away() {
  sim::DrivenNode node(setup(), 1, {0.0, 0.0});
  sim::MotionJudge judge(setup());
  for (int i = 0; i < kStill + 2000; ++i) {
    node.machine().broken().axis[sim::kAzimuth].push_nm = i < kStill ? 0.0 : (i / 100) % 2 == 0 ? 40.0 : -40.0;
    node.tick();
    judge.look(node, i * sim::kTick_s);
  }
  TEST_ASSERT_EQUAL(sim::Runaway::kNotStopped, judge.harm().axis[sim::kAzimuth].runaway);
}

// Profile velocity with 60FF = 0. A fault of the firmware: the ramp goes to a rate that nobody has asked for.
sim::Runaway creep(double rate_rad_s) {
  sim::DrivenNode node(setup(), 1, {0.0, 0.0});
  sim::MotionJudge judge(setup());
  node.enable(DRIVE_PROFILE_VELOCITY);
  for (int i = 0; i < kStill + 1500; ++i) {
    profile_ramp& ramp = node.node().axis[sim::kAzimuth].drive.motion.next.ramp;
    ramp.rate_rad_s = static_cast<float>(std::min(rate_rad_s, 1e-3 * i));
    node.tick();
    judge.look(node, i * sim::kTick_s);
  }
  const sim::AxisHarm& harm = judge.harm().axis[sim::kAzimuth];
  std::printf("%.2f rad/s at most; runaway %d\n", harm.max_rate_rad_s, static_cast<int>(harm.runaway));
  TEST_ASSERT_DOUBLE_WITHIN(0.05, rate_rad_s, harm.max_rate_rad_s);
  return harm.runaway;
}

void test_an_axis_with_a_set_point_that_nobody_has_written_runs_away() {
  TEST_ASSERT_EQUAL(sim::Runaway::kNotStopped, creep(0.3));
  TEST_ASSERT_EQUAL(sim::Runaway::kNone, creep(0.0));
}

// Profile velocity: full speed, then 60FF = 0 with a deceleration of 0.05 rad/s2. The ramp is the rest of a motion.
void test_a_slow_ramp_to_standstill_is_no_runaway() {
  sim::DrivenNode node(setup(), 1, {0.0, 0.0});
  sim::MotionJudge judge(setup());
  node.write(sim::kAzimuth, 0x6084, 0, 50'000);
  node.write(sim::kAzimuth, 0x60FF, 0, 600'000);
  node.enable(DRIVE_PROFILE_VELOCITY);
  for (int i = 0; i < 8000; ++i) {
    if (i == 2000) {
      node.write(sim::kAzimuth, 0x60FF, 0, 0);
    }
    node.tick();
    judge.look(node, i * sim::kTick_s);
  }
  TEST_ASSERT_TRUE(std::abs(node.machine().truth().joint_rate_rad_s[sim::kAzimuth]) > 2.0 * sim::kTurning_rad_s);
  TEST_ASSERT_EQUAL(sim::Runaway::kNone, judge.harm().axis[sim::kAzimuth].runaway);
}

constexpr int kFrameTicks = 20;
constexpr double kStart_rad = -1.3;  // of which the encoder knows the turn

// A frame of a target that is about 5 mrad ahead of the azimuth, no frozen picture, or of no target.
void send_frame(sim::DrivenNode& node, int counter, bool found) {
  node.write(sim::kAzimuth, 0x3070, 1, 4600 + 400 * (counter % 3));
  node.write(sim::kAzimuth, 0x3070, 3, 2000);  // 20 ms old
  node.write(sim::kAzimuth, 0x3070, 4, found ? 100 : 0);
  node.write(sim::kAzimuth, 0x3070, 5, counter % 256);
}

// A fault of the firmware: the tracking loop of the azimuth goes on as if it had just seen a target.
void keep_target(sim::DrivenNode& node) {
  target_tracker_state& tracker = node.node().tracking.joints.axis[sim::kAzimuth];
  tracker.locked = true;
  tracker.ticks_since_frame = 0;
  tracker.error_rad = 0.0F;
  tracker.target_rate_rad_s = 0.3F;
  tracker.target_acceleration_rad_s2 = 0.0F;
}

struct Tracked {
  sim::AxisHarm harm;
  double rate_rad_s;  // at the end
};

// Azimuth in mode -1: frames with a target for some ticks, then frames without one; or the firmware keeps the target.
// The picture counts as right: a target that stays ahead of the axis proves nothing.
Tracked track(int seen_ticks, bool keeps_target, int ticks, target_loss at_loss = TARGET_LOSS_STAND) {
  sim::DrivenNode node(setup(), 1, {kStart_rad, 0.0});
  sim::MotionJudge judge(setup());
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    node.write_real(axis, 0x2011, 5, 0.5);
    node.write(axis, 0x2011, 6, at_loss);
    node.write(axis, 0x2070, 1, 1);
  }
  node.enable({DRIVE_TRACKING, DRIVE_CYCLIC_VELOCITY});
  for (int i = 0; i < ticks; ++i) {
    if (i % kFrameTicks == 0) {
      send_frame(node, i / kFrameTicks + 1, i < seen_ticks);
    }
    if (keeps_target && i >= seen_ticks) {
      keep_target(node);
    }
    node.node().tracking.orientation.verdict = PICTURE_RIGHT;
    node.set_rate(sim::kPitch, 0.0);
    node.tick();
    judge.look(node, i * sim::kTick_s);
  }
  const Tracked result{judge.harm().axis[sim::kAzimuth],
                       std::abs(node.machine().truth().joint_rate_rad_s[sim::kAzimuth])};
  std::printf("target for %d ms: %.2f rad/s at most, %.3f rad/s at the end; runaway %d after %.3f s\n", seen_ticks,
              result.harm.max_rate_rad_s, result.rate_rad_s, static_cast<int>(result.harm.runaway),
              result.harm.runaway_time_s);
  return result;
}

void test_a_target_lets_an_axis_turn_for_as_long_as_it_is_seen() {
  const Tracked result = track(4000, false, 4000);
  TEST_ASSERT_TRUE(result.rate_rad_s > 2.0 * sim::kTurning_rad_s);
  TEST_ASSERT_EQUAL(sim::Runaway::kNone, result.harm.runaway);
}

void test_an_axis_that_has_lost_its_target_stands() {
  const Tracked result = track(1500, false, 6500);
  TEST_ASSERT_TRUE(result.harm.max_rate_rad_s > 2.0 * sim::kTurning_rad_s);
  TEST_ASSERT_TRUE(result.rate_rad_s < 0.01);
  TEST_ASSERT_EQUAL(sim::Runaway::kNone, result.harm.runaway);
}

// At 0.3 rad/s, for longer than kStopTime_s.
void test_an_axis_that_has_lost_its_target_may_return() {
  const Tracked result = track(4000, false, 8000, TARGET_LOSS_RETURN);
  TEST_ASSERT_TRUE(result.rate_rad_s > 2.0 * sim::kTurning_rad_s);
  TEST_ASSERT_EQUAL(sim::Runaway::kNone, result.harm.runaway);
}

void test_an_axis_that_follows_a_target_that_no_frame_shows_runs_away() {
  const Tracked result = track(0, true, kStill + 500);
  TEST_ASSERT_EQUAL(sim::Runaway::kNotStopped, result.harm.runaway);
  TEST_ASSERT_TRUE(result.harm.runaway_time_s >= sim::kStopTime_s && result.harm.runaway_time_s < kStill * 1e-3 + 0.3);
}

// 0.5 s is permitted.
void test_an_axis_that_follows_a_lost_target_for_too_long_runs_away() {
  const Tracked result = track(1000, true, 5500);
  TEST_ASSERT_EQUAL(sim::Runaway::kNotStopped, result.harm.runaway);
  TEST_ASSERT_TRUE(result.harm.runaway_time_s >= 0.9 + 0.5 + sim::kStopTime_s && result.harm.runaway_time_s < 5.2);
}

void test_an_axis_that_is_pushed_in_mode_minus_1_without_a_target_runs_away() {
  sim::DrivenNode node(setup(), 1, {0.0, 0.0});
  sim::MotionJudge judge(setup());
  node.enable(DRIVE_TRACKING);
  for (int i = 0; i < kStill + 300; ++i) {
    node.machine().broken().axis[sim::kAzimuth].push_nm = i > kStill ? 70.0 : 0.0;
    node.tick();
    judge.look(node, i * sim::kTick_s);
  }
  TEST_ASSERT_EQUAL(sim::Runaway::kNotStopped, judge.harm().axis[sim::kAzimuth].runaway);
}

void test_equal_seeds_give_equal_runs() {
  const sim::AttackBench bench(setup().plant);
  sim::EventLog one;
  sim::EventLog two;
  const sim::AttackResult first = sim::run_attack(bench, 7, &one);
  const sim::AttackResult second = sim::run_attack(bench, 7, &two);
  const sim::AttackResult without_log = sim::run_attack(bench, 7);
  TEST_ASSERT_EQUAL_STRING(one.text().c_str(), two.text().c_str());
  TEST_ASSERT_TRUE(first.writes > 20 && one.text().find("SDO 6040:0 Azimuth Controlword = 0xF") != std::string::npos);
  TEST_ASSERT_EQUAL_DOUBLE(first.harm.axis[0].max_rate_rad_s, second.harm.axis[0].max_rate_rad_s);
  TEST_ASSERT_EQUAL_DOUBLE(first.harm.axis[0].max_rate_rad_s, without_log.harm.axis[0].max_rate_rad_s);
  TEST_ASSERT_EQUAL(first.writes, without_log.writes);
}

void test_tracking_seeds_follow_targets() {
  const sim::AttackBench bench(setup().plant);
  int seeds = 0;
  int following = 0;
  for (std::uint64_t seed = 1; seeds < 5; ++seed) {
    sim::EventLog log;
    if (sim::run_attack(bench, seed, &log).theme == sim::Theme::kTracking) {
      seeds++;
      TEST_ASSERT_TRUE(log.text().find(": camera\n") != std::string::npos);
      following += log.text().find("tracking state 2") != std::string::npos ? 1 : 0;
    }
  }
  TEST_ASSERT_TRUE(following >= 4);
}

void test_everything_that_a_master_can_write_is_attacked() {
  const sim::AttackBench bench(setup().plant);
  std::printf("%zu objects\n", bench.objects().count());
  TEST_ASSERT_TRUE(bench.objects().count() > 300);
  for (std::size_t group = 0; group < sim::kObjectGroups; ++group) {
    TEST_ASSERT_FALSE(bench.objects().group(static_cast<sim::ObjectGroup>(group)).empty());
    for (const sim::WritableObject& object : bench.objects().group(static_cast<sim::ObjectGroup>(group))) {
      TEST_ASSERT_TRUE(object.index != 0x3040);  // nothing is unlocked
    }
  }
  const std::vector<sim::WritableObject>& tracking = bench.objects().group(sim::ObjectGroup::kTracking);
  for (const int index : {0x2011, 0x2811, 0x3070, 0x3071, 0x3073, 0x3074, 0x3075}) {
    TEST_ASSERT_TRUE(std::any_of(tracking.begin(), tracking.end(),
                                 [index](const sim::WritableObject& one) { return one.index == index; }));
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_push_into_the_end_stop_is_a_hard_contact);
  RUN_TEST(test_a_slow_contact_does_no_harm);
  RUN_TEST(test_an_axis_beyond_its_speed_limit_runs_away);
  RUN_TEST(test_an_axis_that_turns_on_without_a_command_runs_away);
  RUN_TEST(test_wind_may_turn_an_axis_that_may_not_use_its_torque);
  RUN_TEST(test_wind_may_turn_such_an_axis_without_power_too);
  RUN_TEST(test_an_axis_that_is_pushed_harder_than_its_motor_runs_away);
  RUN_TEST(test_a_stop_in_the_tick_after_a_set_point_may_take_its_time);
  RUN_TEST(test_an_axis_that_swings_runs_away);
  RUN_TEST(test_an_axis_with_a_set_point_that_nobody_has_written_runs_away);
  RUN_TEST(test_a_slow_ramp_to_standstill_is_no_runaway);
  RUN_TEST(test_a_short_push_is_no_runaway);
  RUN_TEST(test_a_target_lets_an_axis_turn_for_as_long_as_it_is_seen);
  RUN_TEST(test_an_axis_that_has_lost_its_target_stands);
  RUN_TEST(test_an_axis_that_has_lost_its_target_may_return);
  RUN_TEST(test_an_axis_that_follows_a_target_that_no_frame_shows_runs_away);
  RUN_TEST(test_an_axis_that_follows_a_lost_target_for_too_long_runs_away);
  RUN_TEST(test_an_axis_that_is_pushed_in_mode_minus_1_without_a_target_runs_away);
  RUN_TEST(test_tracking_seeds_follow_targets);
  RUN_TEST(test_equal_seeds_give_equal_runs);
  RUN_TEST(test_everything_that_a_master_can_write_is_attacked);
  return UNITY_END();
}
