// SPDX-License-Identifier: Apache-2.0
// Safe torque off and holding brakes of the emulated board: which outputs go off, when, what is reported, and that
// nothing starts again by itself.
#include <cmath>
#include <string>

#include "board_steps.hpp"

using bench::BoardRig;
using bench::boot_and_turn;
using bench::expect_no_violations;
using bench::has_heard;
using bench::kSlow_urad_s;
using bench::set_up_brakes;
using bench::turn;
using Sto = trackservo::target::BoardMachine::StoChannel;
namespace target = trackservo::target;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr std::uint16_t kSafeTorqueOff = 0x5441;
constexpr std::uint16_t kChannels = 0x5442;
constexpr std::uint16_t kBrake = 0x7130;

constexpr double kMaxReaction_ms = 25.0;  // required
constexpr double kStep_s = 20e-6;

void set_both(BoardRig& rig, bool permits) {
  rig.machine.set_sto(Sto::kA, permits);
  rig.machine.set_sto(Sto::kB, permits);
}

// Milliseconds until it holds, from now on.
template <typename Condition>
double time_until(BoardRig& rig, Condition holds) {
  const double begin_s = rig.machine.time_s();
  while (!holds() && rig.machine.time_s() < begin_s + 1.0) {
    rig.machine.run(kStep_s);
  }
  return 1e3 * (rig.machine.time_s() - begin_s);
}

bool has_error(BoardRig& rig, std::uint16_t code) {
  const auto& heard = rig.client.emergencies();
  return std::any_of(heard.begin(), heard.end(), [code](const auto& emergency) { return emergency.code == code; });
}

// --- safe torque off ---

void test_each_channel_alone_removes_the_torque_of_both_axes() {
  for (const std::string channels : {"A", "B", "AB"}) {
    BoardRig rig(bench::tracker_plant());
    boot_and_turn(rig);
    rig.client.forget();
    for (const char channel : channels) {
      rig.machine.set_sto(channel == 'A' ? Sto::kA : Sto::kB, false);
    }
    const double reaction_ms = time_until(rig, [&rig] { return rig.machine.is_safe(); });
    TEST_MESSAGE(fmt::format("channel {}: torque off after {:.2f} ms", channels, reaction_ms).c_str());
    TEST_ASSERT_TRUE(reaction_ms <= kMaxReaction_ms);
    turn(rig, 20);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(0x08, rig.client.statusword(0) & 0x4FU, "azimuth is not in fault");
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(0x08, rig.client.statusword(1) & 0x4FU, "pitch is not in fault");
    TEST_ASSERT_EQUAL_HEX32(kSafeTorqueOff, rig.client.error_code(0));
    TEST_ASSERT_TRUE(has_error(rig, kSafeTorqueOff));
    const std::uint32_t expected = (channels == "A" ? 2U : 0U) | (channels == "B" ? 1U : 0U);
    TEST_ASSERT_EQUAL_UINT32(expected, rig.client.read(0x3061, 1).value() & 3U);
    expect_no_violations(rig);
  }
}

// Channel B is the timers' second break input: it acts while the core hangs in the handler that would do the same.
// Channel A is outside the chip.
void test_both_channels_act_without_the_program() {
  for (const Sto channel : {Sto::kA, Sto::kB}) {
    BoardRig rig(bench::tracker_plant());
    boot_and_turn(rig);
    rig.machine.chip().core.hang(target::kFirstInterrupt + target::kTim1BreakInterrupt);
    rig.machine.set_sto(channel, false);
    const double delay_ms = 1e3 * target::seconds_of(target::BoardMachine::kStoDelay);
    rig.machine.run(1e-3 * delay_ms - kStep_s);
    TEST_ASSERT_FALSE(rig.machine.is_safe());
    const double after_ms = time_until(rig, [&rig] { return rig.machine.is_safe(); });
    TEST_ASSERT_TRUE_MESSAGE(after_ms <= 0.1, "later than the input circuit");
  }
}

void test_the_torque_does_not_come_back_by_itself() {
  BoardRig rig(bench::tracker_plant());
  boot_and_turn(rig);
  set_both(rig, false);
  turn(rig, 50);
  TEST_ASSERT_FALSE_MESSAGE(rig.client.enable_again(0), "while torque is off");
  set_both(rig, true);
  turn(rig, 200);
  TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "a bridge is on without a command");
  TEST_ASSERT_EQUAL_HEX32(0x08, rig.client.statusword(0) & 0x4FU);
  TEST_ASSERT_TRUE(rig.client.write(0x6040, 0, 0x80, 2));
  rig.client.pass(5);
  TEST_ASSERT_EQUAL_HEX32_MESSAGE(0x40, rig.client.statusword(0) & 0x4FU, "switch on disabled after the fault reset");
  TEST_ASSERT_TRUE(rig.machine.is_safe());
  TEST_ASSERT_TRUE(rig.client.enable_again(0) && rig.client.enable_again(1));
  turn(rig, 300);
  TEST_ASSERT_DOUBLE_WITHIN(0.1 * kSlow_urad_s, kSlow_urad_s, 1e6 * rig.truth().inertial_rate_rad_s[0]);
  expect_no_violations(rig);
}

void test_channels_that_differ_are_a_fault_until_both_have_been_off() {
  for (const Sto channel : {Sto::kA, Sto::kB}) {
    BoardRig rig(bench::tracker_plant());
    boot_and_turn(rig);
    rig.client.forget();
    rig.machine.set_sto(channel, false);
    turn(rig, 80);
    TEST_ASSERT_FALSE_MESSAGE(has_error(rig, kChannels), "too early: switches do not act together");
    turn(rig, 60);
    TEST_ASSERT_TRUE_MESSAGE(has_error(rig, kChannels), "the difference is not reported");
    rig.machine.set_sto(channel, true);
    turn(rig, 20);
    TEST_ASSERT_FALSE_MESSAGE(rig.client.enable_again(0), "one channel has not been tested");
    set_both(rig, false);
    turn(rig, 20);
    set_both(rig, true);
    turn(rig, 20);
    TEST_ASSERT_TRUE(rig.client.enable_again(0));
    expect_no_violations(rig);
  }
}

// Of 1 ms, on one channel or on both, every 20 ms.
void test_test_pulses_do_not_trip() {
  for (const std::string channels : {"A", "B", "AB"}) {
    BoardRig rig(bench::tracker_plant());
    boot_and_turn(rig);
    rig.client.forget();
    const auto set = [&](bool permits) {
      for (const char channel : channels) {
        rig.machine.set_sto(channel == 'A' ? Sto::kA : Sto::kB, permits);
      }
    };
    for (int i = 0; i < 30; ++i) {
      set(false);
      turn(rig, 1);
      set(true);
      turn(rig, 19);
      TEST_ASSERT_TRUE(rig.machine.is_bridge_on(0) && rig.machine.is_bridge_on(1));
    }
    TEST_ASSERT_EQUAL_UINT(0, rig.client.emergencies().size());
    TEST_ASSERT_DOUBLE_WITHIN(0.1 * kSlow_urad_s, kSlow_urad_s, 1e6 * rig.truth().inertial_rate_rad_s[0]);
    set(false);
    rig.machine.run(4e-3);
    set(true);
    turn(rig, 20);
    TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "4 ms are no test pulse");
    expect_no_violations(rig);
  }
}

void test_an_enable_that_contradicts_its_command_is_a_fault() {
  for (const bool level : {false, true}) {
    BoardRig rig(bench::tracker_plant());
    bench::boot(rig);
    if (!level) {
      rig.client.start_node();
      TEST_ASSERT_TRUE(rig.client.enable(bench::kCyclicVelocity));
    }
    rig.client.forget();
    rig.machine.stick_driver_enable(0, level);
    turn(rig, 20);
    TEST_ASSERT_TRUE_MESSAGE(has_error(rig, kChannels), "it is not reported");
    TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "a bridge is on");
    expect_no_violations(rig);
  }
}

// --- holding brakes ---

bool any_brake_powered(BoardRig& rig) { return rig.machine.is_brake_powered(0) || rig.machine.is_brake_powered(1); }

void enable_and_turn(BoardRig& rig) {
  TEST_ASSERT_TRUE(rig.client.enable(bench::kCyclicVelocity));
  turn(rig, 400);
  TEST_ASSERT_TRUE(rig.machine.is_brake_powered(0) && rig.machine.is_brake_powered(1));
  TEST_ASSERT_DOUBLE_WITHIN(0.1 * kSlow_urad_s, kSlow_urad_s, 1e6 * rig.truth().inertial_rate_rad_s[0]);
}

void test_a_brake_is_released_while_torque_stands_and_at_no_other_time() {
  BoardRig rig(bench::tracker_plant(), 1, true);
  rig.machine.on_tick([&rig] {
    for (int axis = 0; axis < 2; ++axis) {
      TEST_ASSERT_TRUE_MESSAGE(!rig.machine.is_brake_powered(axis) || rig.machine.is_bridge_on(axis),
                               "a brake is released without torque");
    }
  });
  set_up_brakes(rig);
  TEST_ASSERT_FALSE(any_brake_powered(rig));
  enable_and_turn(rig);
  TEST_ASSERT_EQUAL_UINT32(0xC, rig.client.read(0x3061, 1).value() & 0xCU);
  TEST_ASSERT_TRUE(rig.client.write(0x6040, 0, 7, 2));
  const double engage_ms = time_until(rig, [&rig] { return !rig.machine.is_brake_powered(0); });
  const double hold_ms = time_until(rig, [&rig] { return !rig.machine.is_bridge_on(0); });
  TEST_MESSAGE(
      fmt::format("brake off {:.0f} ms after the command, torque held for {:.0f} ms more", engage_ms, hold_ms).c_str());
  TEST_ASSERT_DOUBLE_WITHIN(3.0, 40.0, hold_ms);
  rig.client.pass(200);
  TEST_ASSERT_EQUAL_UINT(0, rig.client.emergencies().size());
  expect_no_violations(rig);
}

void test_a_brake_engages_within_25_ms_of_every_loss_of_torque() {
  const auto of_axis = [](const char *what, int axis, auto act) {
    BoardRig rig(bench::tracker_plant(), 1, true);
    set_up_brakes(rig);
    enable_and_turn(rig);
    act(rig, axis);
    const double reaction_ms = time_until(rig, [&rig, axis] { return !rig.machine.is_brake_powered(axis); });
    TEST_MESSAGE(
        fmt::format("{}: coil of {} off after {:.2f} ms", what, axis == 0 ? "azimuth" : "pitch", reaction_ms).c_str());
    TEST_ASSERT_TRUE(reaction_ms <= kMaxReaction_ms);
    rig.client.pass(100);
    TEST_ASSERT_TRUE(std::abs(rig.truth().joint_rate_rad_s[static_cast<std::size_t>(axis)]) < 1e-4);
  };
  const auto of_each_axis = [&of_axis](const char *what, auto act) {
    of_axis(what, 0, act);
    of_axis(what, 1, act);
  };
  const auto with = [&of_each_axis](const char *what, auto act) {
    of_each_axis(what, [&act](BoardRig& rig, int /*axis*/) { act(rig); });
  };
  with("STO, channel A", [](BoardRig& rig) { rig.machine.set_sto(Sto::kA, false); });
  with("STO, channel B", [](BoardRig& rig) { rig.machine.set_sto(Sto::kB, false); });
  with("STO, both", [](BoardRig& rig) { set_both(rig, false); });
  of_each_axis("driver fault", [](BoardRig& rig, int axis) { rig.machine.set_driver_fault(axis, true); });
  of_each_axis("short circuit", [](BoardRig& rig, int axis) { rig.machine.set_short_current(axis, 30.0); });
  of_each_axis("encoder lost: motor shorted",
               [](BoardRig& rig, int axis) { rig.machine.encoder(axis).is_connected = false; });
  with("hard fault", [](BoardRig& rig) { rig.machine.chip().exceptions.pend(target::kHardFault); });
  with("missing tick", [](BoardRig& rig) { rig.machine.chip().tim6.stall(); });
  with("parity error", [](BoardRig& rig) { rig.machine.chip().syscfg.find_parity_error(); });
}

void test_a_contact_that_contradicts_the_coil_is_a_fault_of_its_axis() {
  for (const bool released : {false, true}) {
    BoardRig rig(bench::tracker_plant(), 1, true);
    set_up_brakes(rig);
    if (!released) {
      enable_and_turn(rig);
    }
    rig.client.forget();
    rig.machine.stick_brake_contact(0, released);
    turn(rig, 600);
    TEST_ASSERT_TRUE_MESSAGE(has_error(rig, kBrake), "it is not reported");
    TEST_ASSERT_EQUAL_HEX32(kBrake, rig.client.error_code(0));
    TEST_ASSERT_EQUAL_HEX32(0, rig.client.error_code(1));
    TEST_ASSERT_FALSE(rig.machine.is_bridge_on(0) || rig.machine.is_brake_powered(0));
    expect_no_violations(rig);
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_each_channel_alone_removes_the_torque_of_both_axes);
  RUN_TEST(test_both_channels_act_without_the_program);
  RUN_TEST(test_the_torque_does_not_come_back_by_itself);
  RUN_TEST(test_channels_that_differ_are_a_fault_until_both_have_been_off);
  RUN_TEST(test_test_pulses_do_not_trip);
  RUN_TEST(test_an_enable_that_contradicts_its_command_is_a_fault);
  RUN_TEST(test_a_brake_is_released_while_torque_stands_and_at_no_other_time);
  RUN_TEST(test_a_brake_engages_within_25_ms_of_every_loss_of_torque);
  RUN_TEST(test_a_contact_that_contradicts_the_coil_is_a_fault_of_its_axis);
  return UNITY_END();
}
