// SPDX-License-Identifier: Apache-2.0
// Faults that encoder and gyro have in common, and others that no single sensor shows: each is detected, and speed and
// travel stay within the figures of docs/theory.md. The program prints the measured figures.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>

#include "bench.hpp"
#include "device/driven_node.hpp"
#include "machine/base/random.hpp"
#include "studies/random_plants/random_plant.hpp"
#include "support/test_size.h"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr double kLongest_s = 40.0;

const sim::NodeSetup& setup() {
  static const sim::NodeSetup tracker(sim::load_plant("sim_host/plants/tracker.toml"));
  return tracker;
}

struct Case {
  const char *name;
  fault_set expected;  // one of these
  double rate_rad_s;   // the set-point, from the start on
  double moves_s;      // at 20 deg/s before it, so that the motor is known
  std::function<void(sim::BrokenAxis&)> begin;
  double detection_s;  // from the fault on; the rest is what is promised of it
  double max_rad_s;
  double travel_rad;
  bool excites = false;  // with the fault it turns to and fro
};

struct Worst {
  int seen = 0;
  int runs = 0;
  fault_set faults = 0;
  double detection_s = 0;
  double speed_rad_s = 0;  // at the detection
  double max_rad_s = 0;    // from the fault to rest
  double travel_rad = 0;   // the same
  double wrong_rad = 0;    // from the fault to the detection
};

double rate(sim::DrivenNode& node, int axis) {
  return node.machine().truth().joint_rate_rad_s[static_cast<std::size_t>(axis)];
}

double angle(sim::DrivenNode& node, int axis) {
  return node.machine().truth().joint_angle_rad[static_cast<std::size_t>(axis)];
}

void ticks(sim::DrivenNode& node, double seconds) {
  for (int i = 0; i < static_cast<int>(std::lround(seconds * 1000.0)); ++i) {
    node.tick();
  }
}

void move(sim::DrivenNode& node, const Case& one) {
  const double back = one.rate_rad_s != 0.0 ? 1.0 : -1.0;
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    node.set_rate(axis, axis == sim::kAzimuth || one.moves_s == 0.0 ? 0.35 : 0.35 * back);
  }
  ticks(node, one.moves_s);
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    node.set_rate(axis, one.rate_rad_s);
  }
  ticks(node, 1.0);
}

void run(const Case& one, int axis, std::uint64_t seed, Worst *worst) {
  sim::DrivenNode node(setup(), seed, {0.2, 0.4});
  ticks(node, 0.1);
  node.enable(DRIVE_PROFILE_VELOCITY);
  move(node, one);
  TEST_ASSERT_EQUAL_MESSAGE(FAULT_NONE, node.axis(axis).drive.fault, one.name);
  one.begin(node.machine().broken().axis[static_cast<std::size_t>(axis)]);
  const double from_rad = angle(node, axis);
  double time_s = 0.0;
  double max_rad_s = 0.0;
  while (time_s < kLongest_s && node.axis(axis).drive.fault == FAULT_NONE) {
    if (one.excites) {
      node.set_rate(axis, std::fmod(time_s, 4.0) < 2.0 ? one.rate_rad_s : -one.rate_rad_s);
    }
    node.tick();
    time_s += sim::kTick_s;
    max_rad_s = std::max(max_rad_s, std::abs(rate(node, axis)));
  }
  const fault_id fault = node.axis(axis).drive.fault;
  ++worst->runs;
  if (fault == FAULT_NONE) {
    worst->max_rad_s = std::max(worst->max_rad_s, max_rad_s);
    return;
  }
  ++worst->seen;
  worst->faults |= fault_bit(fault);
  worst->detection_s = std::max(worst->detection_s, time_s);
  worst->speed_rad_s = std::max(worst->speed_rad_s, std::abs(rate(node, axis)));
  worst->wrong_rad = std::max(worst->wrong_rad, std::abs(angle(node, axis) - from_rad));
  for (int i = 0; i < 3000 && std::abs(rate(node, axis)) > 1e-3; ++i) {
    node.tick();
    max_rad_s = std::max(max_rad_s, std::abs(rate(node, axis)));
  }
  worst->max_rad_s = std::max(worst->max_rad_s, max_rad_s);
  worst->travel_rad = std::max(worst->travel_rad, std::abs(angle(node, axis) - from_rad));
}

std::string names(fault_set faults) {
  std::string text;
  for (int i = 1; i < FAULT_COUNT; ++i) {
    text += (faults >> i & 1U) != 0 ? fmt::format(" {}", i) : "";
  }
  return text;
}

void check(const Case& one) {
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    Worst of_axis;
    for (int seed = 1; seed <= by_size(1, 5, 40); ++seed) {
      run(one, axis, static_cast<std::uint64_t>(seed), &of_axis);
    }
    std::printf(
        "%-34s %s: %d of %d after %5.0f ms, %5.1f deg/s, at most %5.1f, %6.2f deg to detection, %6.2f to rest, "
        "faults%s\n",
        one.name, axis == sim::kAzimuth ? "azimuth" : "pitch  ", of_axis.seen, of_axis.runs, 1e3 * of_axis.detection_s,
        of_axis.speed_rad_s / sim::kRadPerDeg, of_axis.max_rad_s / sim::kRadPerDeg, of_axis.wrong_rad / sim::kRadPerDeg,
        of_axis.travel_rad / sim::kRadPerDeg, names(of_axis.faults).c_str());
    TEST_ASSERT_EQUAL_MESSAGE(of_axis.runs, of_axis.seen, one.name);
    TEST_ASSERT_EQUAL_HEX64_MESSAGE(0, of_axis.faults & ~one.expected, one.name);
    TEST_ASSERT_TRUE_MESSAGE(of_axis.detection_s <= one.detection_s, one.name);
    TEST_ASSERT_TRUE_MESSAGE(of_axis.max_rad_s <= one.max_rad_s, one.name);
    TEST_ASSERT_TRUE_MESSAGE(of_axis.travel_rad <= one.travel_rad, one.name);
  }
}

std::function<void(sim::BrokenAxis&)> show(double share) {
  return [share](sim::BrokenAxis& broken) { broken.sensors_show_share = share; };
}

void test_sensors_that_are_wrong_together_are_found_by_the_motor() {
  const fault_set motor = fault_bit(FAULT_MOTOR_CONTRADICTS);
  const fault_set moving = motor | fault_bit(FAULT_RUNAWAY) | fault_bit(FAULT_MOTOR_WEAK);
  const Case cases[] = {
      {"frozen, 0.003 deg/s", motor, 5.2e-5, 0.5, show(0.0), 0.45, 10.0 * sim::kRadPerDeg, 3.0 * sim::kRadPerDeg},
      {"frozen, 0.1 deg/s", motor, 1.7e-3, 0.5, show(0.0), 0.12, 32.0 * sim::kRadPerDeg, 12.0 * sim::kRadPerDeg},
      {"frozen, 1 deg/s", moving, 0.0175, 0.5, show(0.0), 0.06, 32.0 * sim::kRadPerDeg, 12.0 * sim::kRadPerDeg},
      {"frozen, 20 deg/s", moving, 0.35, 0.5, show(0.0), 0.05, 35.0 * sim::kRadPerDeg, 12.0 * sim::kRadPerDeg},
      {"half, 20 deg/s", motor, 0.35, 0.0, show(0.5), 0.12, 45.0 * sim::kRadPerDeg, 24.0 * sim::kRadPerDeg},
      {"half, 20 deg/s, motor known", motor, 0.35, 1.0, show(0.5), 0.12, 45.0 * sim::kRadPerDeg,
       24.0 * sim::kRadPerDeg},
      {"half, 40 deg/s", moving, 0.7, 0.0, show(0.5), 0.2, 86.0 * sim::kRadPerDeg, 40.0 * sim::kRadPerDeg},
  };
  for (const Case& one : cases) {
    check(one);
  }
}

// Until rest includes what the wind turns an axis without a brake.
void test_dead_sensors_at_rest_do_not_answer_the_test_torque() {
  const fault_set found = fault_bit(FAULT_NO_ANSWER) | fault_bit(FAULT_MOTOR_CONTRADICTS);
  for (const double before_s : {0.0, 0.5, 2.0}) {
    check({"frozen, set-point 0", found, 0.0, before_s, show(0.0), 0.6, 8.5 * sim::kRadPerDeg, 7.0 * sim::kRadPerDeg});
  }
}

// Two machines with the same noise and wind; one of them is not tested (2060:32 = 0). What the test torque does is
// their difference.
void test_an_axis_that_works_answers_the_test_torque_with_a_third_of_a_microradian() {
  sim::NodeSetup untested_setup = setup();
  for (protection_limits& limits : untested_setup.limits) {
    limits.proof_rad_s = 0.0F;
  }
  sim::DrivenNode tested(setup(), 1, {0.2, 0.4});
  sim::DrivenNode untested(untested_setup, 1, {0.2, 0.4});
  for (sim::DrivenNode *node : {&tested, &untested}) {
    ticks(*node, 0.1);
    node->enable(DRIVE_PROFILE_VELOCITY);
    ticks(*node, 2.0);
  }
  std::array<double, sim::kAxes> angle_square{};
  std::array<double, sim::kAxes> rate_square{};
  constexpr int kTicks = 50 * MOTION_PROOF_TICKS;
  for (int i = 0; i < kTicks; ++i) {
    tested.tick();
    untested.tick();
    for (int axis = 0; axis < sim::kAxes; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      angle_square[a] += std::pow(angle(tested, axis) - angle(untested, axis), 2.0) / kTicks;
      rate_square[a] += std::pow(rate(tested, axis) - rate(untested, axis), 2.0) / kTicks;
    }
  }
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const auto silence_rad_s = static_cast<double>(tested.axis(axis).monitor.limits.proof_rad_s);
    const double swing_rad = std::sqrt(2.0 * angle_square[a]);
    const double answer_rad_s = std::sqrt(2.0 * rate_square[a]);
    std::printf("test torque %.2f Nm, %s: silence below %.0f urad/s, answer %.0f urad/s, swing %.2f urad\n",
                static_cast<double>(tested.axis(axis).monitor.proof.amplitude_nm),
                axis == sim::kAzimuth ? "azimuth" : "pitch", 1e6 * silence_rad_s, 1e6 * answer_rad_s, 1e6 * swing_rad);
    TEST_ASSERT_TRUE(answer_rad_s > 1.7 * silence_rad_s);
    TEST_ASSERT_TRUE(swing_rad < 0.4e-6);
  }
}

void test_a_motor_with_half_its_torque_is_found_under_excitation() {
  const fault_set weak = fault_bit(FAULT_MOTOR_WEAK) | fault_bit(FAULT_MOTOR_CONTRADICTS);
  // It shows after a reversal: 40 seeds took up to 8.6 s, the start of the fifth half period.
  check({"motor x 0.5, +-40 deg/s", weak, 0.7, 0.5, [](sim::BrokenAxis& b) { b.motor_share = 0.5; }, 9.0,
         45.0 * sim::kRadPerDeg, 150.0 * sim::kRadPerDeg, true});
}

void test_a_slow_drift_of_either_sensor_is_found_at_rest() {
  const fault_set drift = fault_bit(FAULT_SENSORS_DRIFT) | fault_bit(FAULT_MOTOR_CONTRADICTS);
  check({"encoder creeps at 0.019 rad/s", drift, 0.0, 0.5, [](sim::BrokenAxis& b) { b.encoder_creep_rad_s = 0.019; },
         0.4, 2.0 * sim::kRadPerDeg, 1.0 * sim::kRadPerDeg});
  check({"gyro bias of 0.019 rad/s", drift, 0.0, 0.5, [](sim::BrokenAxis& b) { b.gyro_shift_rad_s = 0.019; }, 0.4,
         7.0 * sim::kRadPerDeg, 3.0 * sim::kRadPerDeg});
  check({"gyro bias of 0.0005 rad/s", fault_bit(FAULT_STANDSTILL_LEFT), 0.0, 0.0,
         [](sim::BrokenAxis& b) { b.gyro_shift_rad_s = 0.0005; }, 30.0, 1.0 * sim::kRadPerDeg, 1.0 * sim::kRadPerDeg});
}

// Both axes within half a turn, so that every start is in a known turn, and a base that is declared to move.
sim::NodeSetup moving_base() {
  sim::PlantConfig plant = sim::load_plant("sim_host/plants/tracker.toml");
  plant.axis[sim::kAzimuth].end_stops->lower_rad = -70.0 * sim::kRadPerDeg;
  plant.axis[sim::kAzimuth].end_stops->upper_rad = 70.0 * sim::kRadPerDeg;
  sim::NodeSetup made(plant);
  for (protection_limits& limits : made.limits) {
    limits.fixed_base_rad = 0.0F;  // 2060:27
  }
  return made;
}

constexpr double kDrift_rad_s = 0.019;  // just below 2060:2
constexpr double kRoom_rad = 0.06;      // from the start to the end of the hard travel

struct Drifted {
  double beyond_rad = -10.0;   // of the joint, farthest beyond the end of the hard travel
  double contact_rad_s = 0.0;  // fastest at the end stop
  double max_rad_s = 0.0;
  double moved_rad = 0.0;  // from the fault on, in the direction of the near end
  fault_set faults = 0;
};

// Close to one end of the travel, at set-point 0 and without a camera, until long after a drift would have ended it.
Drifted drift(const sim::NodeSetup& setup, int axis, double towards, std::int8_t mode, bool with_607d,
              const std::function<void(sim::BrokenAxis&, double)>& begin) {
  const auto i = static_cast<std::size_t>(axis);
  const double end_rad = static_cast<double>(towards > 0.0 ? setup.limits[i].maximum_rad : setup.limits[i].minimum_rad);
  const sim::EndStopConfig& stops = *setup.plant.axis[i].end_stops;
  std::array<double, sim::kAxes> start = {0.2, 0.4};
  start[i] = end_rad - towards * kRoom_rad;
  sim::DrivenNode node(setup, 1, start);
  ticks(node, 0.1);
  if (!with_607d) {
    node.write(axis, 0x607D, 1, 0);
    node.write(axis, 0x607D, 2, 0);
  }
  node.enable(mode);
  ticks(node, 0.5);
  begin(node.machine().broken().axis[i], towards);
  Drifted seen;
  const double from_rad = angle(node, axis);
  for (int tick = 0; tick < 10000; ++tick) {
    node.tick();
    const double joint_rad = angle(node, axis);
    seen.beyond_rad = std::max(seen.beyond_rad, towards * (joint_rad - end_rad));
    seen.max_rad_s = std::max(seen.max_rad_s, std::abs(rate(node, axis)));
    seen.moved_rad = towards * (joint_rad - from_rad);
    seen.faults |= node.axis(axis).drive.faults;
    if (joint_rad > stops.upper_rad || joint_rad < stops.lower_rad) {
      seen.contact_rad_s = std::max(seen.contact_rad_s, std::abs(rate(node, axis)));
    }
  }
  return seen;
}

void print_drift(const char *name, int axis, double towards, const Drifted& seen) {
  std::printf(
      "moving base, %-38s %s %+.0f: %6.2f deg moved, %6.2f mrad beyond the travel, contact %.2f deg/s, at most "
      "%.2f deg/s, faults%s\n",
      name, axis == sim::kAzimuth ? "azimuth" : "pitch  ", towards, seen.moved_rad / sim::kRadPerDeg,
      1e3 * seen.beyond_rad, seen.contact_rad_s / sim::kRadPerDeg, seen.max_rad_s / sim::kRadPerDeg,
      names(seen.faults).c_str());
}

// The loop holds what the gyro says; the encoder is right, so the drive stops the axis in its travel. It needs 607D for
// that no more than protection does.
void test_a_gyro_bias_on_a_moving_base_ends_in_the_travel() {
  const sim::NodeSetup setup = moving_base();
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    for (const double towards : {-1.0, 1.0}) {
      for (const bool with_607d : {false, true}) {
        const Drifted seen = drift(setup, axis, towards, DRIVE_PROFILE_VELOCITY, with_607d,
                                   [](sim::BrokenAxis& b, double side) { b.gyro_shift_rad_s = -side * kDrift_rad_s; });
        print_drift(with_607d ? "gyro bias" : "gyro bias, without 607D", axis, towards, seen);
        TEST_ASSERT_TRUE(seen.moved_rad > 0.5 * kRoom_rad);  // it drifts
        TEST_ASSERT_TRUE(seen.beyond_rad < 0.0);
        TEST_ASSERT_TRUE(seen.contact_rad_s == 0.0);
        TEST_ASSERT_TRUE(seen.max_rad_s < 1.3 * sim::kRadPerDeg);
      }
    }
  }
}

// The envelope reads the same encoder. Where the motor as a witness does not see it (fault 37), an axis whose position
// is held reaches its end stop, at the speed of the creep.
void test_a_creep_of_the_encoder_on_a_moving_base_ends_at_the_end_stop_at_its_own_speed() {
  const sim::NodeSetup setup = moving_base();
  int contacts = 0;
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    for (const double towards : {-1.0, 1.0}) {
      for (const std::int8_t mode : {DRIVE_PROFILE_VELOCITY, DRIVE_PROFILE_POSITION}) {
        const Drifted seen = drift(setup, axis, towards, mode, true, [](sim::BrokenAxis& b, double side) {
          b.encoder_creep_rad_s = -side * kDrift_rad_s;
        });
        print_drift(mode == DRIVE_PROFILE_VELOCITY ? "encoder creep, rate held" : "encoder creep, position held", axis,
                    towards, seen);
        contacts += seen.contact_rad_s > 0.0 ? 1 : 0;
        TEST_ASSERT_TRUE(mode == DRIVE_PROFILE_POSITION || std::abs(seen.moved_rad) < 0.5 * sim::kRadPerDeg);
        TEST_ASSERT_TRUE(seen.contact_rad_s < 1.3 * sim::kRadPerDeg);
        TEST_ASSERT_TRUE(seen.max_rad_s < 1.5 * sim::kRadPerDeg);
      }
    }
  }
  TEST_ASSERT_TRUE(contacts > 0);  // else docs/safety.md is too cautious
}

// After a creep the ends of the travel that protection knows are wrong by its length, at any speed.
void test_a_creep_of_the_encoder_moves_the_ends_of_the_travel_by_its_length() {
  constexpr double kCrept_rad = 0.057;   // three seconds
  constexpr double kBound_rad = 0.0115;  // of the envelope, docs/safety.md
  sim::NodeSetup setup = moving_base();
  for (sim::AxisConfig& axis : setup.plant.axis) {
    axis.end_stops->lower_rad -= 0.5;
    axis.end_stops->upper_rad += 0.5;
  }
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double end_rad = static_cast<double>(setup.limits[i].maximum_rad);
    std::array<double, sim::kAxes> start = {0.2, 0.4};
    start[i] = end_rad - 0.8;
    sim::DrivenNode node(setup, 1, start);
    ticks(node, 0.1);
    node.write(axis, 0x607D, 1, 0);
    node.write(axis, 0x607D, 2, 0);
    node.enable(DRIVE_PROFILE_VELOCITY);
    for (int tick = 0; tick < 3000; ++tick) {
      node.machine().broken().axis[i].encoder_shift_rad -= kCrept_rad / 3000.0;
      node.tick();
    }
    node.set_rate(axis, 1.2);
    double beyond_rad = -10.0;
    for (int tick = 0; tick < 4000; ++tick) {
      node.tick();
      beyond_rad = std::max(beyond_rad, angle(node, axis) - end_rad);
    }
    std::printf("moving base, 1.2 rad/s after a creep of %.0f mrad, axis %d: %.1f mrad beyond the travel, fault %d\n",
                1e3 * kCrept_rad, axis, 1e3 * beyond_rad, static_cast<int>(node.axis(axis).drive.fault));
    TEST_ASSERT_TRUE(beyond_rad > 0.5 * kCrept_rad);
    TEST_ASSERT_TRUE(beyond_rad < kCrept_rad + kBound_rad);
  }
}

void test_an_encoder_that_is_wrong_in_some_ticks_is_named() {
  const fault_set erratic = fault_bit(FAULT_ENCODER_ERRATIC);
  const auto stale = [](sim::BrokenAxis& b) { b.encoder_stale_share = 0.1; };
  const auto bit = [](sim::BrokenAxis& b) { b.encoder_bit_share = 0.1; };
  // The increment after an old reading is 0.7 mrad: beyond 2060:4 it is also a jump.
  check({"10 % stale, 20 deg/s", erratic | fault_bit(FAULT_ENCODER_JUMP), 0.35, 0.5, stale, 0.15,
         23.0 * sim::kRadPerDeg, 8.0 * sim::kRadPerDeg});
  check({"10 % stale, 2 deg/s", erratic, 0.035, 0.5, stale, 0.15, 5.0 * sim::kRadPerDeg, 2.0 * sim::kRadPerDeg});
  check({"bit 10 in 10 %, 20 deg/s", erratic, 0.35, 0.5, bit, 0.15, 23.0 * sim::kRadPerDeg, 8.0 * sim::kRadPerDeg});
  check({"bit 10 in 10 %, at rest", erratic, 0.0, 0.5, bit, 0.15, 3.0 * sim::kRadPerDeg, 1.0 * sim::kRadPerDeg});
}

// A torque limit (6072) of 2 Nm leaves the loops too little to hold against 15 Nm.
void test_an_axis_that_is_pushed_out_of_its_standstill_is_found() {
  sim::DrivenNode node(setup(), 1, {0.2, 0.4});
  node.enable(DRIVE_PROFILE_VELOCITY);
  ticks(node, 2.0);
  node.write(sim::kAzimuth, 0x6072, 0, 50);
  node.machine().broken().axis[sim::kAzimuth].push_nm = 15.0;
  const double from_rad = angle(node, sim::kAzimuth);
  for (int i = 0; i < 2000 && node.axis(sim::kAzimuth).drive.fault == FAULT_NONE; ++i) {
    node.tick();
  }
  TEST_ASSERT_EQUAL(FAULT_STANDSTILL_LEFT, node.axis(sim::kAzimuth).drive.fault);
  TEST_ASSERT_DOUBLE_WITHIN(1e-3, 0.01, std::abs(angle(node, sim::kAzimuth) - from_rad));
}

void test_reduced_speed_is_monitored_when_it_is_selected() {
  sim::DrivenNode node(setup(), 1, {0.2, 0.4});
  node.enable(DRIVE_PROFILE_VELOCITY);
  node.set_rate(sim::kAzimuth, 0.08);
  node.write(sim::kAzimuth, 0x2062, 0, 1);
  ticks(node, 2.0);
  TEST_ASSERT_EQUAL(FAULT_NONE, node.axis(sim::kAzimuth).drive.fault);
  node.set_rate(sim::kAzimuth, 0.12);
  node.set_rate(sim::kPitch, 0.12);  // not selected there
  ticks(node, 1.0);
  TEST_ASSERT_EQUAL(FAULT_REDUCED_SPEED, node.axis(sim::kAzimuth).drive.fault);
  TEST_ASSERT_EQUAL(FAULT_NONE, node.axis(sim::kPitch).drive.fault);
}

// Single bits of what the tick uses, drawn at random, at rest and at 20 deg/s.
void test_every_bit_that_flips_in_the_active_set_is_found_and_its_motion_bounded() {
  sim::SplitMix64 random(14);
  double max_rad_s = 0.0;
  int latest_ms = 0;
  for (int i = 0; i < by_size(20, 199, 1000); ++i) {
    const int axis = i % 2;
    const double wanted_rad_s = i % 4 < 2 ? 0.0 : 0.35;
    sim::DrivenNode node(setup(), static_cast<std::uint64_t>(i + 1), {0.2, 0.4});
    node.enable(DRIVE_PROFILE_VELOCITY);
    node.set_rate(axis, wanted_rad_s);
    ticks(node, 0.6);
    auto *bytes = reinterpret_cast<std::uint8_t *>(&node.node().board.app.params.axis[axis]);
    const auto bit = static_cast<std::size_t>(random() % (8 * sizeof(servo_axis_params)));
    bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] ^ 1U << bit % 8);
    int ms = 0;
    while (node.axis(axis).drive.fault == FAULT_NONE && ms < 100) {
      node.tick();
      ++ms;
      max_rad_s = std::max(max_rad_s, std::abs(rate(node, axis) - wanted_rad_s));
    }
    TEST_ASSERT_TRUE_MESSAGE(node.axis(axis).drive.fault != FAULT_NONE, fmt::format("bit {}", bit).c_str());
    latest_ms = std::max(latest_ms, ms);
    for (int n = 0; n < 10; ++n) {
      node.tick();
      max_rad_s = std::max(max_rad_s, std::abs(rate(node, axis)) - wanted_rad_s);
    }
  }
  std::printf("Found after at most %d ms, at most %.1f deg/s off\n", latest_ms, max_rad_s / sim::kRadPerDeg);
  TEST_ASSERT_LESS_OR_EQUAL(26, latest_ms);
  TEST_ASSERT_TRUE(max_rad_s < 12.0 * sim::kRadPerDeg);
}

// Machines whose numbers are all off by up to 30 %, with the gains, motor data and limits of the nominal one.
void test_no_monitor_trips_on_random_machines() {
  const sim::NodeSetup& nominal = setup();
  int tripped = 0;
  for (int n = 1; n <= by_size(3, 20, 1000); ++n) {
    const auto seed = static_cast<std::uint64_t>(n);
    sim::PlantConfig plant = sim::random_plant(nominal.plant, 0.3, seed).config;
    plant.supply = nominal.plant.supply;  // its limits are of the supply
    const sim::NodeSetup machine(plant, nominal.parameters, nominal.limits);
    sim::DrivenNode node(machine, seed, {0.2, 0.4});
    sim::SplitMix64 random(seed);
    ticks(node, 0.1);
    try {
      node.enable(DRIVE_PROFILE_VELOCITY);
    } catch (const std::exception& error) {
      std::printf("plant %d: %s\n", n, error.what());  // the fault of its axis is counted below
    }
    for (int part = 0; part < 12; ++part) {
      const double rate_rad_s = part % 3 == 2 ? 0.0 : std::pow(10.0, -3.0 + 3.0 * random.uniform());
      const double back = part % 6 < 3 ? 1.0 : -1.0;
      for (int axis = 0; axis < sim::kAxes; ++axis) {
        node.set_rate(axis, (axis == sim::kPitch ? 0.3 : 1.0) * back * rate_rad_s);
      }
      ticks(node, part % 3 == 2 ? 2.5 : 1.0);
    }
    for (int axis = 0; axis < sim::kAxes; ++axis) {
      const fault_id fault = node.axis(axis).drive.fault;
      tripped += fault == FAULT_NONE ? 0 : 1;
      if (fault != FAULT_NONE) {
        std::printf("plant %d, axis %d: fault %d\n", n, axis, static_cast<int>(fault));
      }
    }
  }
  std::printf("%d trips on random machines\n", tripped);
  TEST_ASSERT_EQUAL(0, tripped);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_sensors_that_are_wrong_together_are_found_by_the_motor);
  RUN_TEST(test_an_axis_that_works_answers_the_test_torque_with_a_third_of_a_microradian);
  RUN_TEST(test_dead_sensors_at_rest_do_not_answer_the_test_torque);
  RUN_TEST(test_a_motor_with_half_its_torque_is_found_under_excitation);
  RUN_TEST(test_a_slow_drift_of_either_sensor_is_found_at_rest);
  RUN_TEST(test_a_gyro_bias_on_a_moving_base_ends_in_the_travel);
  RUN_TEST(test_a_creep_of_the_encoder_on_a_moving_base_ends_at_the_end_stop_at_its_own_speed);
  RUN_TEST(test_a_creep_of_the_encoder_moves_the_ends_of_the_travel_by_its_length);
  RUN_TEST(test_an_encoder_that_is_wrong_in_some_ticks_is_named);
  RUN_TEST(test_an_axis_that_is_pushed_out_of_its_standstill_is_found);
  RUN_TEST(test_reduced_speed_is_monitored_when_it_is_selected);
  RUN_TEST(test_every_bit_that_flips_in_the_active_set_is_found_and_its_motion_bounded);
  RUN_TEST(test_no_monitor_trips_on_random_machines);
  return UNITY_END();
}
