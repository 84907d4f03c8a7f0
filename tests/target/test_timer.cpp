// SPDX-License-Identifier: Apache-2.0
// The emulated timer of a bridge: what it applies does not depend on when a program touches its registers.
#include "chip/timer.hpp"

#include "machine/base/random.hpp"
#include "unity.h"

namespace sim = trackservo::sim;
using namespace trackservo::target;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr std::uint32_t kCr1 = 0x00;
constexpr std::uint32_t kCcmr1 = 0x18;
constexpr std::uint32_t kCcer = 0x20;
constexpr std::uint32_t kArr = 0x2C;
constexpr std::uint32_t kRcr = 0x30;
constexpr std::uint32_t kCcr1 = 0x34;
constexpr std::uint32_t kCcr2 = 0x38;
constexpr std::uint32_t kBdtr = 0x44;
constexpr std::uint32_t kDriven = 0x01009C55;  // main output, both breaks, dead time of 0.5 us
constexpr Instant kPeriod = 50 * kUnitsPerMicrosecond;

void start(Timer& timer) {
  timer.reset();
  timer.clocked_at([] { return 170'000'000U; });
  timer.set_break_input(true);
  timer.set_second_break_input(true);
  timer.bus_write(kCr1, 0xA0, 4);  // centre-aligned, auto-reload preloaded
  timer.bus_write(kCcmr1, 0x6868, 4);
  timer.bus_write(kCcer, 0x55, 4);
  timer.bus_write(kArr, 4250, 4);
  timer.bus_write(kRcr, 1, 4);
  timer.bus_write(kCcr1, 1275, 4);
  timer.bus_write(kCcr2, 2975, 4);
  timer.bus_write(0x60, 1, 4);  // both break inputs
  timer.bus_write(0x64, 1, 4);
  timer.bus_write(0x14, 1, 4);  // loads the preloaded values
  timer.bus_write(kCr1, 0xA1, 4);
  timer.bus_write(kBdtr, kDriven, 4);
}

// Set: 30 % and 70 %. Applied: the program writes BDTR again and again, also when an alarm is due that has not run yet,
// as after the last instruction of a block. Seen: 30 % and 70 % in each period.
void test_the_mean_of_a_period_does_not_depend_on_when_registers_are_written() {
  Timeline timeline;
  Exceptions exceptions;
  Violations violations;
  Timer timer({timeline, exceptions, violations}, "TIM1", {25, 24}, true);
  start(timer);
  sim::SplitMix64 random(1);
  int periods = 0;
  Timeline::Alarm step = 0;
  Instant due = kPeriod;
  step = timeline.add([&] {
    const auto legs = timer.take_mean_legs();
    if (++periods > 1) {
      TEST_ASSERT_TRUE(legs[0].has_value() && legs[1].has_value());
      TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.3, *legs[0]);
      TEST_ASSERT_DOUBLE_WITHIN(1e-9, 0.7, *legs[1]);
    }
    due += kPeriod;
    timeline.set(step, due);
  });
  timeline.set(step, due);
  while (periods < 1000) {
    timeline.advance(1 + static_cast<Instant>(400.0 * random.uniform()));
    timer.bus_write(kBdtr, kDriven, 4);
    timeline.run_due();
  }
  TEST_ASSERT_EQUAL_UINT(0, violations.list().size());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_mean_of_a_period_does_not_depend_on_when_registers_are_written);
  return UNITY_END();
}
