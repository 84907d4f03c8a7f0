// SPDX-License-Identifier: Apache-2.0
// What ends in a reset of the board, in five motions and at random instants: outputs are safe in the stated time, the
// axes stand within the stated distance, and the bus gets the cause after the restart.
// TESTS_SIZE=large takes 4 instants in each motion, 20 in all; otherwise each fault has one or two runs.
#include <cstring>
#include <string>

#include "board_motions.hpp"

using bench::BoardRig;
using bench::expect_no_violations;
using bench::has_heard;
using bench::kBoot_ms;
using bench::kWatchdog_ms;
namespace sim = trackservo::sim;
namespace target = trackservo::target;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr double kStep_s = 50e-6;  // of checking the outputs: a PWM period
constexpr double kTick_ms = 1.0;

// The lower half of the byte with the cause of a reset (HAL_RESET_...).
constexpr std::uint8_t kWatchdog = 4;
constexpr std::uint8_t kException = 5;
constexpr std::uint8_t kBrownOut = 7;
constexpr std::uint8_t kStackOverflow = 8;
constexpr std::uint8_t kParity = 9;

struct Harm {
  const char *name;
  void (*begin)(BoardRig& rig);
  double max_ms;        // until both bridges are off
  fault_id seen;        // reported for each axis before the reset; FAULT_NONE: no code runs that could report
  fault_id reported;    // after it, with this detail
  std::uint8_t detail;  //
};

const Harm kHarms[] = {
    {"the tick no longer comes", [](BoardRig& rig) { rig.machine.chip().tim6.stall(); }, 2.0 + kTick_ms, FAULT_NONE,
     FAULT_WATCHDOG_RESET, kWatchdog},
    {"the tick comes 0.6 ms late",
     [](BoardRig& rig) { rig.machine.chip().tim6.slip(600 * target::kUnitsPerMicrosecond); }, 2.0 + kTick_ms,
     FAULT_TICK_LATE, FAULT_WATCHDOG_RESET, kWatchdog},
    {"the background hangs", [](BoardRig& rig) { rig.machine.chip().core.hang(target::kThread); }, kWatchdog_ms,
     FAULT_NONE, FAULT_WATCHDOG_RESET, kWatchdog},
    {"what comes after the tick hangs", [](BoardRig& rig) { rig.machine.chip().core.hang(target::kPendSv); },
     2.0 + kTick_ms, FAULT_NONE, FAULT_WATCHDOG_RESET, kWatchdog},
    {"HardFault", [](BoardRig& rig) { rig.machine.chip().exceptions.pend(target::kHardFault); }, kTick_ms, FAULT_NONE,
     FAULT_EXCEPTION_RESET, target::kHardFault << 4 | kException},
    {"NMI", [](BoardRig& rig) { rig.machine.chip().exceptions.pend(target::kNmi); }, kTick_ms, FAULT_NONE,
     FAULT_EXCEPTION_RESET, target::kNmi << 4 | kException},
    {"the stack overflows", [](BoardRig& rig) { rig.machine.chip().core.sink_stack_to(0x20000000); }, kTick_ms,
     FAULT_NONE, FAULT_STACK_OVERFLOW, target::kMemManage << 4 | kStackOverflow},
    {"the RAM finds a wrong bit", [](BoardRig& rig) { rig.machine.chip().syscfg.find_parity_error(); }, kTick_ms,
     FAULT_NONE, FAULT_STACK_OVERFLOW, target::kNmi << 4 | kParity},
    {"the supply dips", [](BoardRig& rig) { rig.machine.chip().request_brown_out(); }, kTick_ms, FAULT_NONE,
     FAULT_BROWN_OUT_RESET, kBrownOut},
};

// How long the outputs took [ms].
double expect_safe_in_time(BoardRig& rig, const Harm& harm, const char *what) {
  int steps = 0;
  while (!rig.machine.is_safe() && steps * kStep_s <= 1e-3 * harm.max_ms) {
    rig.machine.run(kStep_s);
    ++steps;
  }
  TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), what);
  return 1e3 * steps * kStep_s;
}

// The axes coast: no bridge is on before an axis is enabled again.
double try_harm(BoardRig& rig, const Harm& harm, const char *what) {
  const int resets_before = rig.machine.chip().resets();
  rig.client.forget();
  harm.begin(rig);
  const double safe_ms = expect_safe_in_time(rig, harm, what);
  bench::expect_to_stop(rig, {0, 1}, rig.truth(), REACTION_CUT, kWatchdog_ms + kBoot_ms, what, [&] {
    rig.client.pass(1);
    TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "left the safe state by itself");
  });
  TEST_ASSERT_EQUAL_INT_MESSAGE(resets_before + 1, rig.machine.chip().resets(), what);
  TEST_ASSERT_EQUAL_INT_MESSAGE(1, rig.client.boots(), what);
  TEST_ASSERT_TRUE_MESSAGE(has_heard(rig, fault_table[harm.reported].code, harm.detail), what);
  for (int axis = 0; harm.seen != FAULT_NONE && axis < sim::kAxes; ++axis) {
    TEST_ASSERT_TRUE_MESSAGE(bench::has_heard_of_axis(rig, harm.seen, axis), what);
  }
  return safe_ms;
}

void test_what_ends_in_a_reset_is_safe_in_every_motion() {
  BoardRig rig(bench::calm_plant());
  bench::boot(rig);
  sim::SplitMix64 random(1);
  int number = 0;
  for (const Harm& harm : kHarms) {
    const std::vector<bench::BoardRun> runs = bench::runs_of(number++, false);
    double worst_ms = 0.0;
    for (const bench::BoardRun& run : runs) {
      bench::Turning(rig, *run.motion).reach(random);
      const std::string what = fmt::format("{}, {}, moment {}", harm.name, run.motion->name, run.moment);
      worst_ms = std::max(worst_ms, try_harm(rig, harm, what.c_str()));
    }
    TEST_MESSAGE(
        fmt::format("{}: safe after {:.2f} ms of {:.0f}, {} runs", harm.name, worst_ms, harm.max_ms, runs.size())
            .c_str());
  }
  expect_no_violations(rig);
}

// The last byte of the image is an initial value that nobody reads any more.
std::uint8_t *last_byte_of_image(BoardRig& rig) {
  constexpr std::uint32_t kFlash = 0x08000000;
  constexpr std::uint32_t kImageBytesAt = kFlash + 0x208;
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, rig.machine.chip().core.memory_at(kImageBytesAt, 4), 4);
  return rig.machine.chip().core.memory_at(kFlash + bytes - 1, 1);
}

// How long the check of the image took [ms]. Only a restart ends the fault.
int try_damaged_image(BoardRig& rig, bench::Turning& turning, const std::string& what) {
  constexpr int kTwoRounds_ms = 10400;
  constexpr std::uint8_t kBit = 0x10;
  const std::uint8_t fault = FAULT_IMAGE_DAMAGED;
  const int resets_before = rig.machine.chip().resets();
  rig.client.forget();
  *last_byte_of_image(rig) ^= kBit;
  int passed_ms = 0;
  for (; passed_ms < kTwoRounds_ms && !has_heard(rig, fault_table[fault].code, fault); ++passed_ms) {
    turning.pass(1);
  }
  TEST_ASSERT_TRUE_MESSAGE(has_heard(rig, fault_table[fault].code, fault), what.c_str());
  turning.halt();
  bench::expect_to_stop(rig, {0, 1}, rig.truth(), REACTION_STOP, 300, what, [&turning] { turning.pass(1); });
  TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "a bridge is still on");
  TEST_ASSERT_EQUAL_INT(resets_before, rig.machine.chip().resets());
  *last_byte_of_image(rig) ^= kBit;
  rig.machine.chip().request_brown_out();
  rig.client.pass(kWatchdog_ms + kBoot_ms);
  return passed_ms;
}

void test_a_damaged_image_stops_both_axes() {
  BoardRig rig(bench::calm_plant());
  bench::boot(rig);
  sim::SplitMix64 random(2);
  const int runs = std::max(1, bench::moments() * static_cast<int>(bench::kBoardMotions.size()));
  int worst_ms = 0;
  for (int i = 0; i < runs; ++i) {
    const bench::BoardMotion& motion = bench::kBoardMotions[static_cast<std::size_t>(i + 2) % 5];
    bench::Turning turning(rig, motion);
    turning.reach(random);
    worst_ms = std::max(worst_ms, try_damaged_image(rig, turning, fmt::format("image damaged, {}", motion.name)));
  }
  TEST_MESSAGE(fmt::format("image damaged: reported after {} ms, {} runs", worst_ms, runs).c_str());
  expect_no_violations(rig);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_what_ends_in_a_reset_is_safe_in_every_motion);
  RUN_TEST(test_a_damaged_image_stops_both_axes);
  return UNITY_END();
}
