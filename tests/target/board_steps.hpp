// SPDX-License-Identifier: Apache-2.0
// Common first and last steps of tests of the emulated board.
#ifndef TRACKSERVO_SIM_EMULATOR_BOARD_STEPS_HPP
#define TRACKSERVO_SIM_EMULATOR_BOARD_STEPS_HPP

#include <algorithm>
#include <cstring>

#include "rig.hpp"
#include "unity.h"

namespace bench {

constexpr int kCyclicVelocity = 9;
constexpr int kBoot_ms = 380;

// Time for 20 ms of the watchdog, its oscillator's tolerance and a background round.
constexpr int kWatchdog_ms = 40;

constexpr std::int32_t kSlow_urad_s = 17453;  // 1 deg/s

inline void expect_no_violations(BoardRig& rig) {
  for (const std::string& violation : rig.machine.chip().violations.list()) {
    TEST_MESSAGE(violation.c_str());
  }
  TEST_ASSERT_EQUAL_UINT(0, rig.machine.chip().violations.list().size());
}

inline void boot(BoardRig& rig) {
  rig.client.pass(kBoot_ms);
  TEST_ASSERT_EQUAL_INT(1, rig.client.boots());
}

// Set-points for both axes at 1 deg/s, one a millisecond.
inline void turn(BoardRig& rig, int milliseconds) {
  for (int i = 0; i < milliseconds; ++i) {
    rig.client.set_speeds(kSlow_urad_s, kSlow_urad_s);
    rig.client.pass(1);
  }
}

inline void boot_and_turn(BoardRig& rig) {
  boot(rig);
  rig.client.start_node();
  TEST_ASSERT_TRUE(rig.client.enable(kCyclicVelocity));
  TEST_ASSERT_TRUE(rig.machine.is_bridge_on(0) && rig.machine.is_bridge_on(1));
  turn(rig, 300);
  TEST_ASSERT_DOUBLE_WITHIN(0.1 * kSlow_urad_s, kSlow_urad_s, 1e6 * rig.truth().inertial_rate_rad_s[0]);
  TEST_ASSERT_DOUBLE_WITHIN(0.1 * kSlow_urad_s, kSlow_urad_s, 1e6 * rig.truth().inertial_rate_rad_s[1]);
}

inline std::uint32_t bits_of(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

inline void unlock(BoardRig& rig) { TEST_ASSERT_TRUE(rig.client.write(0x3040, 1, 0x6E65706F, 4)); }

// Boots with the times of the brakes in the plant file, with their contacts.
inline void set_up_brakes(BoardRig& rig) {
  boot(rig);
  unlock(rig);
  for (const int index : {0x2060, 0x2860}) {
    const auto object = static_cast<std::uint16_t>(index);
    TEST_ASSERT_TRUE(rig.client.write(object, 24, bits_of(0.03F), 4));
    TEST_ASSERT_TRUE(rig.client.write(object, 25, bits_of(0.04F), 4));
    TEST_ASSERT_TRUE(rig.client.write(object, 26, bits_of(1.0F), 4));
  }
  TEST_ASSERT_TRUE(rig.client.write(0x3040, 1, 0, 4));
  rig.client.start_node();
}

// EMCY with this code and, in byte 3, this detail.
inline bool has_heard(const BoardRig& rig, std::uint16_t code, std::uint8_t detail) {
  const auto& heard = rig.client.emergencies();
  return std::any_of(heard.begin(), heard.end(), [code, detail](const auto& emergency) {
    return emergency.code == code && emergency.bytes[3] == detail;
  });
}

// Safe within `max_ms` and permanently; the watchdog resets once; the bus gets the reason.
inline void expect_safe_reset(BoardRig& rig, int max_ms, std::uint16_t code, std::uint8_t detail) {
  for (int i = 0; i < max_ms; ++i) {
    rig.client.pass(1);
  }
  TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "not in the safe state in time");
  for (int i = 0; i < kWatchdog_ms + kBoot_ms; ++i) {
    rig.client.pass(1);
    TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "left the safe state by itself");
  }
  TEST_ASSERT_EQUAL_INT(1, rig.machine.chip().resets());
  TEST_ASSERT_EQUAL_HEX32(static_cast<std::uint32_t>(target::ResetCause::kWatchdog),
                          static_cast<std::uint32_t>(rig.machine.chip().last_reset()));
  TEST_ASSERT_EQUAL_INT_MESSAGE(1, rig.client.boots(), "it must start again");
  TEST_ASSERT_TRUE_MESSAGE(has_heard(rig, code, detail), "the cause of the reset is not reported");
}

}  // namespace bench

#endif
