// SPDX-License-Identifier: Apache-2.0
// Reactions of the emulated board to faults: which outputs go off and when, the statusword and the messages on the bus,
// and what continues.
#include <cstring>
#include <string>

#include "board_steps.hpp"

using bench::bits_of;
using bench::BoardRig;
using bench::boot_and_turn;
using bench::expect_no_violations;
using bench::expect_safe_reset;
using bench::kSlow_urad_s;
using bench::kWatchdog_ms;
using bench::turn;
using bench::unlock;
namespace sim = trackservo::sim;
namespace target = trackservo::target;

void setUp(void) {}
void tearDown(void) {}

namespace {

// Messages of the board itself: CiA 301, table 26.
constexpr std::uint16_t kSoftwareReset = 0x6100;

// The lower half of the accompanying byte.
constexpr std::uint8_t kWatchdog = 4;
constexpr std::uint8_t kFault = 5;

// --- sensors that fail ---

// Without its angle the axis is braked by its shorted motor: its bridge stays on at duty 0 for a while, then goes off.
void expect_error_after(BoardRig& rig, const char *what) {
  constexpr int kBraking_ms = 2100;  // DRIVE_BRAKE_TICKS, and some
  rig.client.pass(100);
  TEST_ASSERT_FALSE_MESSAGE(rig.client.is_enabled(0), what);
  rig.client.pass(kBraking_ms);
  TEST_ASSERT_FALSE_MESSAGE(rig.machine.is_bridge_on(0), what);
  TEST_ASSERT_TRUE_MESSAGE(!rig.client.emergencies().empty(), what);
  expect_no_violations(rig);
}

void test_an_axis_without_its_encoder_is_switched_off() {
  const auto with = [](void (*harm)(BoardRig&), const char *what) {
    BoardRig rig(bench::tracker_plant());
    boot_and_turn(rig);
    rig.client.forget();
    harm(rig);
    expect_error_after(rig, what);
  };
  with([](BoardRig& rig) { rig.machine.encoder(0).is_connected = false; }, "encoder's wire is broken");
  with([](BoardRig& rig) { rig.machine.encoder(0).has_error = true; }, "encoder reports an error");
  with([](BoardRig& rig) { rig.machine.encoder(0).flipped_bits = 4; }, "encoder's CRC is wrong");
}

// --- power stages that fail ---

// Messages of an axis that has cut its torque, while the other one keeps turning.
void expect_fault_of_azimuth(BoardRig& rig, std::uint16_t code) {
  turn(rig, 100);
  TEST_ASSERT_EQUAL_HEX32(0x08, rig.client.statusword(0) & 0x4FU);
  TEST_ASSERT_EQUAL_HEX32(code, rig.client.error_code(0));
  TEST_ASSERT_EQUAL_UINT(1, rig.client.emergencies().size());
  TEST_ASSERT_EQUAL_HEX32(code, rig.client.emergencies().front().code);
  TEST_ASSERT_EQUAL_UINT8_MESSAGE(1, rig.client.emergencies().front().bytes[4], "azimuth is its source");
  TEST_ASSERT_FALSE(rig.machine.is_bridge_on(0));
  TEST_ASSERT_TRUE(rig.client.is_enabled(1) && rig.machine.is_bridge_on(1));
  TEST_ASSERT_DOUBLE_WITHIN(0.1 * kSlow_urad_s, kSlow_urad_s, 1e6 * rig.truth().inertial_rate_rad_s[1]);
}

void expect_that_it_comes_back(BoardRig& rig) {
  TEST_ASSERT_TRUE(rig.client.enable_again(0));
  TEST_ASSERT_TRUE(rig.machine.is_bridge_on(0));
  turn(rig, 300);
  TEST_ASSERT_DOUBLE_WITHIN(0.1 * kSlow_urad_s, kSlow_urad_s, 1e6 * rig.truth().inertial_rate_rad_s[0]);
  expect_no_violations(rig);
}

// The encoder is enough for braking: the axis stops in its loop, then its bridge goes off.
void expect_stop_without_gyro(void (*harm)(BoardRig&), void (*repair)(BoardRig&), const char *what) {
  constexpr std::uint16_t kGyro = 0x7310;
  constexpr int kMaxLatency_ms = 10;  // six ticks, and the bus delay
  constexpr int kStopping_ms = 500;
  BoardRig rig(bench::tracker_plant());
  boot_and_turn(rig);
  rig.client.forget();
  harm(rig);
  int latency_ms = 0;
  for (; rig.client.emergencies().empty() && latency_ms <= kMaxLatency_ms; ++latency_ms) {
    turn(rig, 1);
  }
  TEST_MESSAGE(fmt::format("{}: reported after {} ms", what, latency_ms).c_str());
  TEST_ASSERT_LESS_OR_EQUAL_INT_MESSAGE(kMaxLatency_ms, latency_ms, what);
  turn(rig, kStopping_ms);
  TEST_ASSERT_DOUBLE_WITHIN(0.1 * kSlow_urad_s, 0.0, 1e6 * rig.truth().inertial_rate_rad_s[0]);
  expect_fault_of_azimuth(rig, kGyro);
  repair(rig);
  expect_that_it_comes_back(rig);
}

void test_an_axis_without_its_gyro_stops_by_its_encoder() {
  expect_stop_without_gyro([](BoardRig& rig) { rig.machine.gyro(0).is_connected = false; },
                           [](BoardRig& rig) { rig.machine.gyro(0).is_connected = true; }, "gyro's wire is broken");
  expect_stop_without_gyro([](BoardRig& rig) { rig.machine.gyro(0).breaks_crc = true; },
                           [](BoardRig& rig) { rig.machine.gyro(0).breaks_crc = false; }, "gyro's CRC is wrong");
}

void test_a_driver_fault_switches_its_bridge_off_at_once() {
  constexpr std::uint16_t kPowerStage = 0x5410;
  BoardRig rig(bench::tracker_plant());
  boot_and_turn(rig);
  rig.client.forget();
  rig.machine.set_driver_fault(0, true);
  TEST_ASSERT_FALSE_MESSAGE(rig.machine.is_bridge_on(0), "by hardware, before any instruction");
  expect_fault_of_azimuth(rig, kPowerStage);
  TEST_ASSERT_FALSE_MESSAGE(rig.client.enable_again(0), "while the driver reports its fault");
  TEST_ASSERT_FALSE(rig.machine.is_bridge_on(0));
  rig.machine.set_driver_fault(0, false);
  expect_that_it_comes_back(rig);
  rig.machine.set_driver_fault(1, true);
  TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_bridge_on(0) && !rig.machine.is_bridge_on(1), "pitch has its own");
}

// More than the sensor can measure: the current loop's interrupt switches the bridge off without waiting for the tick.
void test_an_over_current_switches_its_bridge_off_within_two_periods() {
  constexpr std::uint16_t kOverCurrent = 0x2310;
  constexpr double kPwmPeriod_s = 50e-6;
  constexpr double kShort_a = 30.0;
  BoardRig rig(bench::tracker_plant());
  boot_and_turn(rig);
  rig.client.forget();
  rig.machine.set_short_current(0, kShort_a);
  int periods = 0;
  for (; periods < 20 && rig.machine.is_bridge_on(0); ++periods) {
    rig.machine.run(kPwmPeriod_s);
  }
  TEST_MESSAGE(fmt::format("bridge off after {} PWM periods", periods).c_str());
  TEST_ASSERT_LESS_OR_EQUAL_INT(2, periods);
  expect_fault_of_azimuth(rig, kOverCurrent);
  TEST_ASSERT_FALSE_MESSAGE(rig.client.enable_again(0), "into a short");
  TEST_ASSERT_FALSE(rig.machine.is_bridge_on(0));
  rig.machine.set_short_current(0, 0.0);
  expect_that_it_comes_back(rig);
}

// 3060: below the end of the range, the threshold decides; and it defines the value of a count.
void test_the_boards_scales_decide_what_a_current_is() {
  BoardRig rig(bench::tracker_plant());
  bench::boot(rig);
  unlock(rig);
  TEST_ASSERT_TRUE(rig.client.write(0x3060, 3, bits_of(20.0F), 4));
  rig.client.start_node();
  TEST_ASSERT_TRUE(rig.client.enable(bench::kCyclicVelocity));
  turn(rig, 100);
  TEST_ASSERT_EQUAL_HEX32(0, rig.client.error_code(0));
  TEST_ASSERT_TRUE(rig.machine.is_bridge_on(0));
  rig.machine.set_short_current(0, 5.0);
  rig.machine.run(200e-6);
  TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_bridge_on(0), "5 A and what the motor takes are below the threshold");
  rig.machine.set_short_current(0, 22.0);
  rig.machine.run(200e-6);
  TEST_ASSERT_FALSE_MESSAGE(rig.machine.is_bridge_on(0), "22 A are beyond it, and within the sensor's range");
  TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_bridge_on(1), "the other axis has its own");

  BoardRig doubled(bench::tracker_plant());
  bench::boot(doubled);
  unlock(doubled);
  TEST_ASSERT_TRUE(doubled.client.write(0x3060, 5, bits_of(132.0F), 4));
  TEST_ASSERT_TRUE(doubled.client.write(0x3040, 1, 0, 4));
  doubled.client.start_node();
  doubled.client.pass(20);
  TEST_ASSERT_EQUAL_HEX32_MESSAGE(0x3210, doubled.client.error_code(0), "48 V read as 96 V are over-voltage");
}

// One axis has no gyro and does not need it, the other one has no encoder: the first one works.
void test_an_axis_works_without_a_gyro_and_without_the_other_axis() {
  BoardRig rig(bench::tracker_plant());
  rig.machine.gyro(0).is_connected = false;
  rig.machine.gyro(1).is_connected = false;
  rig.machine.encoder(1).is_connected = false;
  bench::boot(rig);
  TEST_ASSERT_TRUE_MESSAGE(bench::has_heard(rig, 0x5000, 0x20 | 0x40 | 0x10), "the failed test is reported");
  TEST_ASSERT_EQUAL_HEX32_MESSAGE(0x7310, rig.client.error_code(0), "its gyro is used and missing");
  rig.client.start_node();
  TEST_ASSERT_TRUE(rig.client.write(0x2050, 1, 0, 4));
  TEST_ASSERT_TRUE(rig.client.write(0x2070, 1, 1, 1));
  TEST_ASSERT_TRUE(rig.client.write(0x6060, 0, bench::kCyclicVelocity, 1));
  for (const std::uint32_t word : {0x00U, 0x80U, 0x06U, 0x07U, 0x0FU}) {
    TEST_ASSERT_TRUE(rig.client.write(0x6040, 0, word, 2));
    rig.client.pass(5);
  }
  TEST_ASSERT_TRUE_MESSAGE(rig.client.is_enabled(0), "azimuth");
  TEST_ASSERT_TRUE(rig.machine.is_bridge_on(0));
  turn(rig, 300);
  TEST_ASSERT_DOUBLE_WITHIN(0.1 * kSlow_urad_s, kSlow_urad_s, 1e6 * rig.truth().inertial_rate_rad_s[0]);
  TEST_ASSERT_FALSE(rig.client.is_enabled(1));
  TEST_ASSERT_FALSE_MESSAGE(rig.machine.is_bridge_on(1), "an axis whose self-test failed is never powered");
  expect_no_violations(rig);
}

// --- what must end in the safe state and a reset ---

void test_a_hard_fault_is_safe_and_resets() {
  BoardRig rig(bench::tracker_plant());
  boot_and_turn(rig);
  rig.client.forget();
  rig.machine.chip().exceptions.pend(target::kHardFault);
  expect_safe_reset(rig, 1, kSoftwareReset, target::kHardFault << 4 | kFault);
}

void test_a_tick_that_does_not_come_is_safe_and_resets() {
  BoardRig rig(bench::tracker_plant());
  boot_and_turn(rig);
  rig.client.forget();
  rig.machine.chip().tim6.stall();
  expect_safe_reset(rig, 5, kSoftwareReset, kWatchdog);
}

void test_a_background_that_hangs_is_safe_and_resets() {
  BoardRig rig(bench::tracker_plant());
  boot_and_turn(rig);
  rig.client.forget();
  rig.machine.chip().core.hang(target::kThread);
  expect_safe_reset(rig, kWatchdog_ms, kSoftwareReset, kWatchdog);
}

// The next tick could read partially written objects: it is skipped, and the bridges are off.
void test_a_service_that_hangs_is_safe_and_resets() {
  BoardRig rig(bench::tracker_plant());
  boot_and_turn(rig);
  rig.client.forget();
  rig.machine.chip().core.hang(target::kPendSv);
  expect_safe_reset(rig, 2, kSoftwareReset, kWatchdog);
}

// --- converters and bus ---

// The loop around a reading that is stuck adds voltage until the torque runs away: the voltage that it gives has no
// current beside it (5210), or the motor turns differently from its voltage (7300).
void test_a_current_converter_that_is_stuck_takes_the_torque_of_its_axis() {
  constexpr std::uint16_t kCurrentSensor = 0x5210;
  constexpr std::uint16_t kMotorContradicts = 0x7300;
  constexpr int kMaxLatency_ms = 100;
  constexpr double kMaxRate_urad_s = 6.0 * kSlow_urad_s;
  BoardRig rig(bench::tracker_plant());
  boot_and_turn(rig);
  rig.client.forget();
  rig.machine.stick_current(0, true);
  int latency_ms = 0;
  double fastest_urad_s = 0.0;
  for (; rig.client.is_enabled(0) && latency_ms < 2000; ++latency_ms) {
    turn(rig, 1);
    fastest_urad_s = std::max(fastest_urad_s, std::abs(1e6 * rig.truth().joint_rate_rad_s[0]));
  }
  const std::uint32_t code = rig.client.error_code(0);
  TEST_MESSAGE(fmt::format("{:04X} after {} ms at {:.0f} urad/s", code, latency_ms, fastest_urad_s).c_str());
  TEST_ASSERT_LESS_OR_EQUAL_INT(kMaxLatency_ms, latency_ms);
  TEST_ASSERT_TRUE(fastest_urad_s < kMaxRate_urad_s);
  TEST_ASSERT_TRUE(code == kCurrentSensor || code == kMotorContradicts);
  turn(rig, 2100);
  TEST_ASSERT_FALSE(rig.machine.is_bridge_on(0));
  TEST_ASSERT_TRUE(rig.client.is_enabled(1) && rig.machine.is_bridge_on(1));
  expect_no_violations(rig);
}

void test_a_bus_voltage_that_is_too_high_brakes_both_axes() {
  constexpr std::uint16_t kOverVoltage = 0x3210;
  constexpr int kMaxLatency_ms = 5;  // with the frame that reports it
  constexpr int kBraking_ms = 2100;
  BoardRig rig(bench::tracker_plant());
  boot_and_turn(rig);
  rig.client.forget();
  rig.machine.set_bus_voltage(61.0);  // the limit is 60 V
  int latency_ms = 0;
  for (; rig.client.emergencies().empty() && latency_ms < 100; ++latency_ms) {
    turn(rig, 1);
  }
  TEST_MESSAGE(fmt::format("reported after {} ms", latency_ms).c_str());
  TEST_ASSERT_LESS_OR_EQUAL_INT(kMaxLatency_ms, latency_ms);
  turn(rig, kBraking_ms);
  TEST_ASSERT_EQUAL_HEX32(kOverVoltage, rig.client.error_code(0));
  TEST_ASSERT_EQUAL_HEX32(kOverVoltage, rig.client.error_code(1));
  TEST_ASSERT_TRUE(rig.machine.is_safe());
  rig.machine.set_bus_voltage(std::nullopt);
  expect_that_it_comes_back(rig);
}

// --- clock ---

// A master whose SYNC comes every 101 ms, while 1006 says 100 ms: it is reported, and no axis stops, because nobody
// knows which of the two clocks is wrong.
void test_a_clock_1_percent_off_sync_is_reported_and_stops_no_axis() {
  constexpr std::uint16_t kSyncClock = 0x8701;
  constexpr int kMaxLatency_ms = 5000;
  for (const int period_ms : {100, 101}) {
    BoardRig rig(bench::tracker_plant());
    boot_and_turn(rig);
    TEST_ASSERT_TRUE(rig.client.write(0x1006, 0, 100000, 4));
    rig.client.forget();
    int passed_ms = 0;
    for (; rig.client.emergencies().empty() && passed_ms <= kMaxLatency_ms; ++passed_ms) {
      if (passed_ms % period_ms == 0) {
        rig.client.send(can_frame{0x080, 0, 0, {}, 0});
      }
      turn(rig, 1);
    }
    TEST_MESSAGE(
        fmt::format("SYNC every {} ms: {} messages after {} ms", period_ms, rig.client.emergencies().size(), passed_ms)
            .c_str());
    if (period_ms == 100) {
      TEST_ASSERT_TRUE(rig.client.emergencies().empty());
    } else {
      TEST_ASSERT_LESS_OR_EQUAL_INT(kMaxLatency_ms, passed_ms);
      TEST_ASSERT_EQUAL_HEX32(kSyncClock, rig.client.emergencies().front().code);
    }
    TEST_ASSERT_TRUE(rig.client.is_enabled(0) && rig.client.is_enabled(1));
    expect_no_violations(rig);
  }
}

// A clock 3 % off against an HSI16 that is 1 % off the same way: 1.98 % between them. In the cold a right clock and
// HSI16 differ by 1.7 %.
void test_a_clock_that_is_3_percent_off_stops_both_axes() {
  constexpr std::uint16_t kClock = 0x5530;
  constexpr int kMaxLatency_ms = 400;
  for (const double error : {1.03 / 1.01 - 1.0, 0.97 / 0.99 - 1.0, 0.1}) {
    BoardRig rig(bench::tracker_plant());
    boot_and_turn(rig);
    rig.machine.chip().rcc.set_hsi_error(error < 0.0 ? -0.017 : 0.017);
    turn(rig, 1000);
    TEST_ASSERT_TRUE_MESSAGE(rig.client.is_enabled(0) && rig.client.is_enabled(1), "1.7 % are no error");
    rig.client.forget();
    rig.machine.chip().rcc.set_hsi_error(error);
    int latency_ms = 0;
    for (; rig.client.emergencies().empty() && latency_ms < 2000; ++latency_ms) {
      turn(rig, 1);
    }
    TEST_MESSAGE(fmt::format("{:+.2f} %: reported after {} ms", 100.0 * error, latency_ms).c_str());
    TEST_ASSERT_LESS_OR_EQUAL_INT(kMaxLatency_ms, latency_ms);
    turn(rig, 500);
    TEST_ASSERT_EQUAL_HEX32(kClock, rig.client.error_code(0));
    TEST_ASSERT_EQUAL_HEX32(kClock, rig.client.error_code(1));
    TEST_ASSERT_TRUE(rig.machine.is_safe());
    expect_no_violations(rig);
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_an_axis_without_its_encoder_is_switched_off);
  RUN_TEST(test_an_axis_without_its_gyro_stops_by_its_encoder);
  RUN_TEST(test_a_driver_fault_switches_its_bridge_off_at_once);
  RUN_TEST(test_an_over_current_switches_its_bridge_off_within_two_periods);
  RUN_TEST(test_the_boards_scales_decide_what_a_current_is);
  RUN_TEST(test_an_axis_works_without_a_gyro_and_without_the_other_axis);
  RUN_TEST(test_a_hard_fault_is_safe_and_resets);
  RUN_TEST(test_a_tick_that_does_not_come_is_safe_and_resets);
  RUN_TEST(test_a_background_that_hangs_is_safe_and_resets);
  RUN_TEST(test_a_service_that_hangs_is_safe_and_resets);
  RUN_TEST(test_a_current_converter_that_is_stuck_takes_the_torque_of_its_axis);
  RUN_TEST(test_a_bus_voltage_that_is_too_high_brakes_both_axes);
  RUN_TEST(test_a_clock_1_percent_off_sync_is_reported_and_stops_no_axis);
  RUN_TEST(test_a_clock_that_is_3_percent_off_stops_both_axes);
  return UNITY_END();
}
