// Faults that only the board has, in every motion that it supports (it has no camera, so it does not track) and at
// random instants: outputs are safe in the stated time, the axes stand within the stated distance, and the bus gets the
// cause after the restart. TARGET_MOMENTS=20 takes more instants than one of each.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>

#include "base/random.hpp"
#include "board_steps.hpp"
#include "fault_injection/injection_run.hpp"

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
constexpr double kStandstill_rad_s = 2e-3;
constexpr double kTick_ms = 1.0;

// The lower half of the byte with the cause of a reset (HAL_RESET_...).
constexpr std::uint8_t kWatchdog = 4;
constexpr std::uint8_t kException = 5;
constexpr std::uint8_t kBrownOut = 7;
constexpr std::uint8_t kStackOverflow = 8;

struct Motion {
  const char *name;
  double speed_rad_s;
  bool reverses;  // somewhere between the two directions
};

constexpr Motion kFast = {"20 deg/s", 20.0 * sim::kRadPerDeg, false};
constexpr Motion kMotions[] = {{"standstill", 0.0, false},
                               {"1 deg/s", 1.0 * sim::kRadPerDeg, false},
                               kFast,
                               {"reversal", 5.0 * sim::kRadPerDeg, true}};

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
    {"the supply dips", [](BoardRig& rig) { rig.machine.chip().request_brown_out(); }, kTick_ms, FAULT_NONE,
     FAULT_BROWN_OUT_RESET, kBrownOut},
};

// A distance is stated only for calm air.
sim::PlantConfig calm_plant() {
  sim::PlantConfig plant = bench::tracker_plant();
  for (sim::AxisConfig& axis : plant.axis) {
    axis.load.wind_mean_nm = 0.0;
    axis.load.wind_gust_rms_nm = 0.0;
  }
  return plant;
}

int moments() {
  const char *wanted = std::getenv("TARGET_MOMENTS");
  return wanted != nullptr ? std::max(1, std::atoi(wanted)) : 1;
}

using Pair = std::array<double, sim::kAxes>;

// Both axes, from standstill with 1 rad/s^2, pitch kept within its travel.
class Turning {
 public:
  Turning(BoardRig& rig, const Motion& motion)
      : rig_(rig), speed_rad_s_(motion.speed_rad_s), reverses_(motion.reverses) {
    rig_.client.start_node();
    TEST_ASSERT_TRUE(rig_.client.enable(bench::kCyclicVelocity));
    direction_ = angle(sim::kPitch) > 25.0 * sim::kRadPerDeg ? -1.0 : 1.0;
  }

  void pass(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) {
      if (angle(sim::kPitch) > 60.0 * sim::kRadPerDeg || angle(sim::kPitch) < 0.0) {
        direction_ = angle(sim::kPitch) > 25.0 * sim::kRadPerDeg ? -1.0 : 1.0;
      }
      const double max_rad_s = kRamp_rad_s2 * sim::kTick_s;
      wanted_rad_s_ += std::clamp(direction_ * speed_rad_s_ - wanted_rad_s_, -max_rad_s, max_rad_s);
      const auto counts = static_cast<std::int32_t>(std::lround(1e6 * wanted_rad_s_));
      rig_.client.set_speeds(counts, counts);
      rig_.client.pass(1);
    }
  }

  // Up to speed, and on to a random instant between two PWM periods.
  void reach(sim::SplitMix64& random) {
    const auto ramp_ms = static_cast<int>(1e3 * speed_rad_s_ / kRamp_rad_s2);
    pass(ramp_ms + 50 + static_cast<int>(100.0 * random.uniform()));
    for (int axis = 0; axis < sim::kAxes; ++axis) {
      const double rate_rad_s = rig_.truth().joint_rate_rad_s[static_cast<std::size_t>(axis)];
      TEST_ASSERT_DOUBLE_WITHIN(0.2 * speed_rad_s_ + kStandstill_rad_s, direction_ * speed_rad_s_, rate_rad_s);
    }
    if (reverses_) {
      direction_ = -direction_;
      pass(static_cast<int>(2.0 * ramp_ms * random.uniform()));
    }
    rig_.machine.run(random.uniform() * sim::kTick_s);
  }

 private:
  static constexpr double kRamp_rad_s2 = 1.0;

  double angle(int axis) const { return rig_.truth().joint_angle_rad[static_cast<std::size_t>(axis)]; }

  BoardRig& rig_;
  double speed_rad_s_;
  bool reverses_;
  double direction_ = 1.0;
  double wanted_rad_s_ = 0.0;
};

// From now to standstill, at most the stated distance of this reaction; `each_ms` must hold all the time.
template <class Each>
void expect_to_stop(BoardRig& rig, fault_reaction reaction, int at_least_ms, const char *what, Each each_ms) {
  constexpr int kLongest_ms = 1000;
  const sim::TruthState start = rig.truth();
  Pair travel_rad{};
  bool stands = false;
  for (int i = 0; i < kLongest_ms && (!stands || i < at_least_ms); ++i) {
    rig.client.pass(1);
    each_ms();
    stands = true;
    for (std::size_t axis = 0; axis < travel_rad.size(); ++axis) {
      const sim::TruthState now = rig.truth();
      travel_rad[axis] = std::max(travel_rad[axis], std::abs(now.joint_angle_rad[axis] - start.joint_angle_rad[axis]));
      stands = stands && std::abs(now.joint_rate_rad_s[axis]) < kStandstill_rad_s;
    }
  }
  TEST_ASSERT_TRUE_MESSAGE(stands, what);
  for (std::size_t axis = 0; axis < travel_rad.size(); ++axis) {
    const double promised_rad = sim::promised_travel_rad(reaction, std::abs(start.joint_rate_rad_s[axis]));
    TEST_ASSERT_TRUE_MESSAGE(
        travel_rad[axis] <= promised_rad,
        fmt::format("{}, axis {}: {:.4f} rad of {:.4f}", what, axis, travel_rad[axis], promised_rad).c_str());
  }
}

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

bool has_heard_of_axis(const BoardRig& rig, fault_id fault, int axis) {
  const auto& heard = rig.client.emergencies();
  return std::any_of(heard.begin(), heard.end(), [fault, axis](const auto& emergency) {
    return emergency.code == fault_table[fault].code && emergency.bytes[3] == fault && emergency.bytes[4] == axis + 1;
  });
}

// The axes coast: no bridge is on before an axis is enabled again.
double try_harm(BoardRig& rig, const Harm& harm, const char *what) {
  const int resets_before = rig.machine.chip().resets();
  rig.client.forget();
  harm.begin(rig);
  const double safe_ms = expect_safe_in_time(rig, harm, what);
  expect_to_stop(rig, REACTION_CUT, kWatchdog_ms + kBoot_ms, what,
                 [&] { TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "left the safe state by itself"); });
  TEST_ASSERT_EQUAL_INT_MESSAGE(resets_before + 1, rig.machine.chip().resets(), what);
  TEST_ASSERT_EQUAL_INT_MESSAGE(1, rig.client.boots(), what);
  TEST_ASSERT_TRUE_MESSAGE(has_heard(rig, fault_table[harm.reported].code, harm.detail), what);
  for (int axis = 0; harm.seen != FAULT_NONE && axis < sim::kAxes; ++axis) {
    TEST_ASSERT_TRUE_MESSAGE(has_heard_of_axis(rig, harm.seen, axis), what);
  }
  return safe_ms;
}

void test_what_ends_in_a_reset_is_safe_in_every_motion() {
  BoardRig rig(calm_plant());
  bench::boot(rig);
  sim::SplitMix64 random(1);
  for (const Harm& harm : kHarms) {
    double worst_ms = 0.0;
    for (const Motion& motion : kMotions) {
      for (int moment = 0; moment < moments(); ++moment) {
        Turning(rig, motion).reach(random);
        const std::string what = fmt::format("{}, {}, moment {}", harm.name, motion.name, moment);
        worst_ms = std::max(worst_ms, try_harm(rig, harm, what.c_str()));
      }
    }
    TEST_MESSAGE(fmt::format("{}: safe after {:.2f} ms of {:.0f}", harm.name, worst_ms, harm.max_ms).c_str());
  }
  expect_no_violations(rig);
}

// The last byte of the image is an initial value that nobody reads any more.
void test_a_damaged_image_stops_both_axes_while_they_turn_fast() {
  constexpr std::uint32_t kFlash = 0x08000000;
  constexpr std::uint32_t kImageBytesAt = kFlash + 0x208;
  constexpr int kTwoRounds_ms = 6200;
  const std::uint8_t fault = FAULT_IMAGE_DAMAGED;
  BoardRig rig(calm_plant());
  bench::boot(rig);
  sim::SplitMix64 random(2);
  Turning turning(rig, kFast);
  turning.reach(random);
  rig.client.forget();
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, rig.machine.chip().core.memory_at(kImageBytesAt, 4), 4);
  *rig.machine.chip().core.memory_at(kFlash + bytes - 1, 1) ^= 0x10;
  for (int i = 0; i < kTwoRounds_ms && !has_heard(rig, fault_table[fault].code, fault); ++i) {
    turning.pass(1);
  }
  TEST_ASSERT_TRUE_MESSAGE(has_heard(rig, fault_table[fault].code, fault), "it is not reported");
  expect_to_stop(rig, REACTION_STOP, 300, "image damaged", [] {});
  TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "a bridge is still on");
  TEST_ASSERT_EQUAL_INT(0, rig.machine.chip().resets());
  expect_no_violations(rig);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_what_ends_in_a_reset_is_safe_in_every_motion);
  RUN_TEST(test_a_damaged_image_stops_both_axes_while_they_turn_fast);
  return UNITY_END();
}
