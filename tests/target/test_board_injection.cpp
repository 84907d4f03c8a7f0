// SPDX-License-Identifier: Apache-2.0
// Faults of the board's parts in five motions, at random instants, on each axis: the time to the reaction, the reaction
// itself, the distance, what the other axis does, and that the axis can be enabled again after the repair.
// TESTS_SIZE=large takes 4 instants in each motion, 20 in all; otherwise each fault has one or two runs.
#include "board_motions.hpp"

using bench::BoardRig;
using bench::BoardRun;
using bench::Turning;
namespace sim = trackservo::sim;
namespace target = trackservo::target;
using Sto = target::BoardMachine::StoChannel;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr double kStep_s = 50e-6;      // of checking the outputs: a PWM period
constexpr double kPermitted_ms = 140;  // in which the channels of STO may differ, and the report
constexpr int kBraking_ms = 2200;      // of the shorted motor, and some

struct Harm {
  const char *name;
  void (*begin)(BoardRig& rig, int axis);
  void (*end)(BoardRig& rig, int axis);
  fault_set faults;   // one of them is reported first
  double max_ms;      // until it is reported; until the bridge is off when `cuts`
  bool cuts = false;  // the bridge goes off without waiting for a report
  bool on_each_axis = true;
  bool both_react = false;
  fault_id later = FAULT_NONE;  // also reported, after kPermitted_ms
};

void permit_torque(BoardRig& rig, bool permits) {
  rig.machine.set_sto(Sto::kA, permits);
  rig.machine.set_sto(Sto::kB, permits);
}

// A test of both channels: off and on again.
void test_channels(BoardRig& rig) {
  permit_torque(rig, false);
  rig.client.pass(20);
  permit_torque(rig, true);
}

// It counts as right after the next check.
void repair_clock(BoardRig& rig) {
  rig.machine.chip().rcc.set_hsi_error(0.0);
  rig.client.pass(200);
}

// Its filtered difference from the gyro has decayed, and its position is known again.
void end_garbage(BoardRig& rig, int axis) {
  rig.machine.encoder(axis).sends_garbage = false;
  rig.machine.encoder(axis).sends_noise = false;
  rig.client.pass(200);
  TEST_ASSERT_EQUAL_MESSAGE(0, rig.client.read(axis == 0 ? 0x2061 : 0x2861, 1).value_or(99), "restrictions");
  TEST_ASSERT_DOUBLE_WITHIN(1e-3, rig.truth().joint_angle_rad[static_cast<std::size_t>(axis)],
                            1e-7 * static_cast<std::int32_t>(rig.client.read(axis == 0 ? 0x6064 : 0x6864).value_or(0)));
}

const Harm kSensorHarms[] = {
    {"encoder: wire broken", [](BoardRig& rig, int axis) { rig.machine.encoder(axis).is_connected = false; },
     [](BoardRig& rig, int axis) { rig.machine.encoder(axis).is_connected = true; }, fault_bit(FAULT_ENCODER_LOST), 3},
    {"encoder: error bit", [](BoardRig& rig, int axis) { rig.machine.encoder(axis).has_error = true; },
     [](BoardRig& rig, int axis) { rig.machine.encoder(axis).has_error = false; }, fault_bit(FAULT_ENCODER_LOST), 3},
    {"encoder: wrong CRC", [](BoardRig& rig, int axis) { rig.machine.encoder(axis).flipped_bits = 4; },
     [](BoardRig& rig, int axis) { rig.machine.encoder(axis).flipped_bits = 0; }, fault_bit(FAULT_ENCODER_LOST), 3},
    {"encoder: garbage, right CRC", [](BoardRig& rig, int axis) { rig.machine.encoder(axis).sends_garbage = true; },
     end_garbage, fault_bit(FAULT_ENCODER_JUMP), 3},
    {"encoder: random bits", [](BoardRig& rig, int axis) { rig.machine.encoder(axis).sends_noise = true; }, end_garbage,
     fault_bit(FAULT_ENCODER_LOST) | fault_bit(FAULT_ENCODER_JUMP), 3},
    {"gyro: wire broken", [](BoardRig& rig, int axis) { rig.machine.gyro(axis).is_connected = false; },
     [](BoardRig& rig, int axis) { rig.machine.gyro(axis).is_connected = true; }, fault_bit(FAULT_GYRO_LOST), 10},
    {"gyro: wrong CRC", [](BoardRig& rig, int axis) { rig.machine.gyro(axis).breaks_crc = true; },
     [](BoardRig& rig, int axis) { rig.machine.gyro(axis).breaks_crc = false; }, fault_bit(FAULT_GYRO_LOST), 10},
};

const Harm kPowerHarms[] = {
    {"driver reports a fault", [](BoardRig& rig, int axis) { rig.machine.set_driver_fault(axis, true); },
     [](BoardRig& rig, int axis) { rig.machine.set_driver_fault(axis, false); }, fault_bit(FAULT_POWER_STAGE), 0.1,
     true},
    {"short circuit of the motor", [](BoardRig& rig, int axis) { rig.machine.set_short_current(axis, 30.0); },
     [](BoardRig& rig, int axis) { rig.machine.set_short_current(axis, 0.0); }, fault_bit(FAULT_OVER_CURRENT_TRIP), 0.1,
     true},
    {"current converter stuck", [](BoardRig& rig, int axis) { rig.machine.stick_current(axis, true); },
     [](BoardRig& rig, int axis) { rig.machine.stick_current(axis, false); },
     fault_bit(FAULT_CURRENT_SENSOR) | fault_bit(FAULT_MOTOR_CONTRADICTS), 100},
    {"bus voltage 61 V", [](BoardRig& rig, int) { rig.machine.set_bus_voltage(61.0); },
     [](BoardRig& rig, int) { rig.machine.set_bus_voltage(std::nullopt); }, fault_bit(FAULT_OVER_VOLTAGE), 5, false,
     false, true},
    {"bus voltage 35 V", [](BoardRig& rig, int) { rig.machine.set_bus_voltage(35.0); },
     [](BoardRig& rig, int) { rig.machine.set_bus_voltage(std::nullopt); }, fault_bit(FAULT_UNDER_VOLTAGE), 8, false,
     false, true},
    {"clock 3 % slow", [](BoardRig& rig, int) { rig.machine.chip().rcc.set_hsi_error(0.03); },
     [](BoardRig& rig, int) { repair_clock(rig); }, fault_bit(FAULT_CLOCK), 400, false, false, true},
    {"clock 3 % fast", [](BoardRig& rig, int) { rig.machine.chip().rcc.set_hsi_error(-0.03); },
     [](BoardRig& rig, int) { repair_clock(rig); }, fault_bit(FAULT_CLOCK), 400, false, false, true},
};

const Harm kSafeTorqueHarms[] = {
    {"STO, channel A", [](BoardRig& rig, int) { rig.machine.set_sto(Sto::kA, false); },
     [](BoardRig& rig, int) { test_channels(rig); }, fault_bit(FAULT_SAFE_TORQUE_OFF), 25, true, false, true,
     FAULT_SAFE_TORQUE_FAULT},
    {"STO, channel B", [](BoardRig& rig, int) { rig.machine.set_sto(Sto::kB, false); },
     [](BoardRig& rig, int) { test_channels(rig); }, fault_bit(FAULT_SAFE_TORQUE_OFF), 25, true, false, true,
     FAULT_SAFE_TORQUE_FAULT},
    {"STO, both channels", [](BoardRig& rig, int) { permit_torque(rig, false); },
     [](BoardRig& rig, int) { permit_torque(rig, true); }, fault_bit(FAULT_SAFE_TORQUE_OFF), 25, true, false, true},
    {"drivers' enable stuck off", [](BoardRig& rig, int axis) { rig.machine.stick_driver_enable(axis, false); },
     [](BoardRig& rig, int axis) {
       rig.machine.stick_driver_enable(axis, std::nullopt);
       test_channels(rig);
     },
     fault_bit(FAULT_SAFE_TORQUE_FAULT), 20, true, true, true},
};

const Harm kBrakeHarms[] = {
    {"brake's contact stuck closed", [](BoardRig& rig, int axis) { rig.machine.stick_brake_contact(axis, false); },
     [](BoardRig& rig, int axis) { rig.machine.stick_brake_contact(axis, std::nullopt); },
     fault_bit(FAULT_HOLDING_BRAKE), 600},
};

// Together, at standstill: nothing but the test torque tells. It takes two windows that begin after they died.
const Harm kDeadSensors = {"encoder and gyro: dead, with noise",
                           [](BoardRig& rig, int axis) {
                             rig.machine.encoder(axis).is_dead = true;
                             rig.machine.gyro(axis).is_dead = true;
                           },
                           [](BoardRig& rig, int axis) {
                             rig.machine.encoder(axis).is_dead = false;
                             rig.machine.gyro(axis).is_dead = false;
                           },
                           fault_bit(FAULT_NO_ANSWER), 3.0 * MOTION_PROOF_TICKS + 10.0};

std::vector<std::size_t> harmed_axes(const Harm& harm, int axis) {
  return harm.both_react ? std::vector<std::size_t>{0, 1} : std::vector<std::size_t>{static_cast<std::size_t>(axis)};
}

bool is_off(BoardRig& rig, const std::vector<std::size_t>& axes) {
  return std::none_of(axes.begin(), axes.end(),
                      [&rig](std::size_t axis) { return rig.machine.is_bridge_on(static_cast<int>(axis)); });
}

// How long the reaction takes [ms].
double expect_reaction_in_time(BoardRig& rig, Turning& turning, const Harm& harm, int axis, const std::string& what) {
  const double begin_s = rig.machine.time_s();
  const auto passed_ms = [&rig, begin_s] { return 1e3 * (rig.machine.time_s() - begin_s); };
  const auto is_in_time = [&] { return passed_ms() < harm.max_ms + 0.5e3 * kStep_s; };  // in whole steps
  harm.begin(rig, axis);
  while (harm.cuts && !is_off(rig, harmed_axes(harm, axis)) && is_in_time()) {
    rig.machine.run(kStep_s);
  }
  while (!harm.cuts && bench::first_fault(rig, axis) == FAULT_NONE && is_in_time()) {
    turning.pass(1);
  }
  const double reaction_ms = passed_ms();
  TEST_ASSERT_TRUE_MESSAGE(is_in_time(), fmt::format("{}: {:.2f} ms", what, reaction_ms).c_str());
  return reaction_ms;
}

void expect_reports(BoardRig& rig, const Harm& harm, int axis, const std::string& what) {
  for (int each = 0; each < sim::kAxes; ++each) {
    const fault_id fault = bench::first_fault(rig, each);
    const std::string found = fmt::format("{}: axis {} reports {}", what, each, static_cast<int>(fault));
    const bool harmed = harm.both_react || each == axis;
    TEST_ASSERT_TRUE_MESSAGE(harmed ? (harm.faults >> fault & 1U) != 0 : fault == FAULT_NONE, found.c_str());
    TEST_ASSERT_TRUE_MESSAGE(harmed || (rig.client.is_enabled(each) && rig.machine.is_bridge_on(each)), found.c_str());
  }
}

// From the reaction to the repair.
void expect_safe_stop(BoardRig& rig, Turning& turning, const Harm& harm, int axis, const std::string& what) {
  constexpr int kReport_ms = 5;
  const sim::TruthState start = rig.truth();
  turning.pass(kReport_ms);
  expect_reports(rig, harm, axis, what);
  const auto reaction = static_cast<fault_reaction>(fault_table[bench::first_fault(rig, axis)].reaction);
  const std::vector<std::size_t> harmed = harmed_axes(harm, axis);
  turning.halt();
  bench::expect_to_stop(rig, harmed, start, reaction, 0, what, [&] {
    turning.pass(1);
    TEST_ASSERT_TRUE_MESSAGE(reaction != REACTION_CUT || is_off(rig, harmed), what.c_str());
  });
  if (harm.later != FAULT_NONE) {
    turning.pass(static_cast<int>(kPermitted_ms));
    TEST_ASSERT_TRUE_MESSAGE(
        bench::has_heard_of_axis(rig, harm.later, 0) && bench::has_heard_of_axis(rig, harm.later, 1), what.c_str());
  }
  for (int i = 0; i < kBraking_ms && !is_off(rig, harmed); ++i) {
    turning.pass(1);
  }
  TEST_ASSERT_TRUE_MESSAGE(is_off(rig, harmed), (what + ": a bridge is still on").c_str());
}

double try_harm(BoardRig& rig, const Harm& harm, const BoardRun& run, sim::SplitMix64& random) {
  const std::string what = fmt::format("{}, {}, axis {}, moment {}", harm.name, run.motion->name, run.axis, run.moment);
  Turning turning(rig, *run.motion);
  turning.reach(random);
  rig.client.forget();
  const double reaction_ms = expect_reaction_in_time(rig, turning, harm, run.axis, what);
  expect_safe_stop(rig, turning, harm, run.axis, what);
  harm.end(rig, run.axis);
  turning.pass(20);
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    const bool harmed = harm.both_react || axis == run.axis;
    TEST_ASSERT_TRUE_MESSAGE(harmed ? rig.client.enable_again(axis) : rig.client.is_enabled(axis), what.c_str());
  }
  return reaction_ms;
}

template <std::size_t count>
void try_harms(BoardRig& rig, const Harm (&harms)[count], std::uint64_t seed) {
  sim::SplitMix64 random(seed);
  for (std::size_t i = 0; i < count; i += static_cast<std::size_t>(by_size(3, 1, 1))) {
    const std::vector<BoardRun> runs = bench::runs_of(static_cast<int>(i), harms[i].on_each_axis);
    double worst_ms = 0.0;
    for (const BoardRun& run : runs) {
      worst_ms = std::max(worst_ms, try_harm(rig, harms[i], run, random));
    }
    TEST_MESSAGE(
        fmt::format("{}: {:.2f} ms of {}, {} runs", harms[i].name, worst_ms, harms[i].max_ms, runs.size()).c_str());
  }
  TEST_ASSERT_EQUAL_INT(0, rig.machine.chip().resets());
  bench::expect_no_violations(rig);
}

void test_a_sensor_that_fails_stops_its_axis() {
  BoardRig rig(bench::calm_plant());
  bench::boot(rig);
  try_harms(rig, kSensorHarms, 11);
}

void test_sensors_that_die_together_at_rest_stop_their_axis() {
  BoardRig rig(bench::calm_plant());
  bench::boot(rig);
  sim::SplitMix64 random(15);
  for (const BoardRun& run : {BoardRun{&bench::kBoardMotions[0], 0, 0}, BoardRun{&bench::kBoardMotions[0], 1, 0}}) {
    TEST_MESSAGE(fmt::format("{}, axis {}: {:.0f} ms of {:.0f}", kDeadSensors.name, run.axis,
                             try_harm(rig, kDeadSensors, run, random), kDeadSensors.max_ms)
                     .c_str());
  }
  bench::expect_no_violations(rig);
}

void test_a_fault_of_power_or_clock_stops_what_it_concerns() {
  BoardRig rig(bench::calm_plant());
  bench::boot(rig);
  try_harms(rig, kPowerHarms, 12);
}

void test_safe_torque_off_removes_the_torque_of_both_axes() {
  BoardRig rig(bench::calm_plant());
  bench::boot(rig);
  try_harms(rig, kSafeTorqueHarms, 13);
}

void test_a_contact_that_contradicts_its_brake_stops_its_axis() {
  BoardRig rig(bench::calm_plant(), 1, true);
  bench::set_up_brakes(rig);
  try_harms(rig, kBrakeHarms, 14);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_sensor_that_fails_stops_its_axis);
  RUN_TEST(test_sensors_that_die_together_at_rest_stop_their_axis);
  RUN_TEST(test_a_fault_of_power_or_clock_stops_what_it_concerns);
  RUN_TEST(test_safe_torque_off_removes_the_torque_of_both_axes);
  RUN_TEST(test_a_contact_that_contradicts_its_brake_stops_its_axis);
  return UNITY_END();
}
