// SPDX-License-Identifier: Apache-2.0
// Is a wrong bit in a register detected? One bit of a register that the image writes is stuck at the opposite of the
// written value, and the board must show an error: against the chip's rules, on the bus, in its motion, in its fault
// reactions, or in the clocks, pins, priorities and times of docs/board.md.
//
// TESTS_SIZE=large inverts every bit, otherwise some.
#include <algorithm>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "rig.hpp"
#include "support/test_size.h"
#include "unity.h"

using bench::BoardRig;
using bench::kTick_us;
namespace sim = trackservo::sim;
namespace target = trackservo::target;

void setUp(void) {}
void tearDown(void) {}

namespace {

using Write = target::Bus::Write;
using Bend = target::Bus::Bend;

constexpr int kBoot_ms = 370;
constexpr int kCyclicVelocity = 9;
constexpr std::int32_t kSpeed_urad_s = 17453;

bool is_near(double value, double wanted, double tolerance) { return std::abs(value - wanted) <= tolerance; }

// Registers of the board's page that affect no motion: these bits have these values.
struct Promise {
  std::uint32_t address;
  std::uint32_t mask;
  std::uint32_t value;
  const char *what;
};

constexpr Promise kPromises[] = {
    {0x40012C44, 0x3F31FFF, 0x1031D55,
     "azimuth: dead time 0.5 us, fault input on and filtered, STO on and asynchronous, lock level 1, low while off"},
    {0x40013444, 0x3F31FFF, 0x1031D55,
     "pitch: dead time 0.5 us, fault input on and filtered, STO on and asynchronous, lock level 1, low while off"},
    {0x40012C64, 0x201, 0x1, "azimuth: the pin of channel B of STO is the second break input"},
    {0x40013464, 0x201, 0x1, "pitch: the pin of channel B of STO is the second break input"},
    {0x40013430, 0xFFFF, 1, "both bridges take new duties at the same instant"},
    {0x40012C0C, 0x80, 0x80, "azimuth: a driver's fault interrupts"},
    {0x4001340C, 0x80, 0x80, "pitch: a driver's fault interrupts"},
    {0x40022000, 0x700, 0x700, "the flash is read with prefetch and both caches"},
    {0x40021000, 1U << 19, 1U << 19, "the crystal is monitored"},
    {0x40007008, 1U << 14, 1U << 14, "the dead battery pull-downs are off"},
    {0xE0042008, 0x1010, 0x1010, "a halted core stops tick and watchdog"},
    {0xE0042010, 0x2800, 0x2800, "a halted core stops both PWM timers"},
    {0xE000ED14, 0x10, 0x10, "a division by zero is a fault"},
    {0xE000ED94, 7, 5, "the guard below the stack is on"},
    {0xE000ED9C, 0xFFFFFFE0, 0x1FFF8000, "the guard ends where the stack does"},
    {0xE000EDA0, 0x1700FF3F, 0x1000001D, "the guard: 32 KiB without access"},
    {0xE000ED24, 0x70000, 0x70000, "bus, usage and memory faults have their own exceptions"},
    {0x40003008, 0xFFF, 159, "the watchdog's time is 20 ms"},
    {0x40003010, 0xFFF, 119, "the watchdog's window"},
    {0xE000ED08, 0xFFFFFFFF, 0x08000000, "the vectors are the image's, whatever is mapped at 0"},
    {0x4001001C, 0xF, 0x3, "a parity error and a lock-up of the core are connected to the timers' break inputs"},
    {0x40010020, 0xFFFFFFFF, 0xFFFFFFFF, "the hot code is protected against writing"},
    {0x40021008, 0x7F000000, 0x43000000, "the other oscillator is given out, divided by 16"},
    {0x4001445C, 0xF, 0x2, "TIM16 captures it"},
    {0x40014418, 0xF, 0xD, "TIM16 captures each eighth edge"},
    {0x40014420, 0x1, 0x1, "TIM16's capture is on"},
    {0x40014400, 0x1, 0x1, "TIM16 runs"},
    {0x40013800, 0x8, 0x8, "azimuth: the line to the gyro is driven, so that it rests high"},
    {0x40004800, 0x8, 0x8, "pitch: the line to the gyro is driven, so that it rests high"},
    {0x40013808, 0x1000, 0x1000, "azimuth: a byte of the gyro that comes too early does not stop the receiver"},
    {0x40004808, 0x1000, 0x1000, "pitch: a byte of the gyro that comes too early does not stop the receiver"},
    {0x40020008, 0x3000, 0x2000, "azimuth: what the encoder sends goes before what is sent to it"},
    {0x40020030, 0x3000, 0x2000, "pitch: what the encoder sends goes before what is sent to it"},
    {0x40000C18, 0xFF00, 0xF100, "TIM5 captures the strobe behind its filter"},
    {0x40000C20, 0x30, 0x10, "TIM5 captures rising edges"},
    {0x40020430, 0x7FFF, 0xAA1, "the strobe's captures of 32 bits go into a ring"},
    {0x40020434, 0xFFFF, 32, "the ring of the strobe has 32 places"},
    {0x40006420, 0xF0003, 1, "FDCAN1 stamps frames in bits"},
};

// The function of each pin in the board's table, and where its pull must hold an open wire. Gates and a driver's fault
// input are pulled low, serial and CAN inputs to their idle high, an encoder's open data line to the level at which no
// frame can come.
struct PinPromise {
  char port;
  unsigned pin;
  unsigned function;
  std::uint32_t pull;   // 1 up, 2 down, 0 none
  std::uint32_t speed;  // 1 where it drives more than 5 MHz or gates, otherwise the slowest
};

constexpr PinPromise kPins[] = {
    {'A', 8, 6, 2, 1}, {'B', 13, 6, 2, 1}, {'A', 9, 6, 2, 1},  {'B', 14, 6, 2, 1}, {'C', 6, 4, 2, 1},
    {'A', 7, 4, 2, 1}, {'C', 7, 4, 2, 1},  {'B', 0, 4, 2, 1},  {'B', 12, 6, 2, 0}, {'A', 6, 4, 2, 0},
    {'B', 3, 5, 0, 1}, {'B', 4, 5, 2, 0},  {'C', 10, 6, 0, 1}, {'C', 11, 6, 2, 0}, {'C', 4, 7, 0, 0},
    {'C', 5, 7, 1, 0}, {'B', 10, 7, 0, 0}, {'B', 11, 7, 1, 0}, {'A', 11, 9, 1, 0}, {'A', 12, 9, 0, 1},
    {'C', 3, 6, 2, 0}, {'B', 6, 10, 2, 0}, {'C', 12, 1, 2, 0},
};

// STO channel A, both read-backs, both contacts, the button: read, and low when the wire is broken.
constexpr std::pair<char, unsigned> kInputs[] = {{'C', 2}, {'B', 1}, {'B', 2}, {'B', 5}, {'B', 7}, {'C', 13}};
// Both brakes, both drivers' enables, the LED.
constexpr std::pair<char, unsigned> kOutputs[] = {{'B', 15}, {'B', 9}, {'C', 8}, {'C', 9}, {'A', 5}};

std::string broken_pin(target::Stm32g474& chip) {
  for (const auto& [name, pin] : kInputs) {
    const target::Gpio& port = chip.port(name);
    if (port.mode(pin) != target::Gpio::Mode::kInput || (port.peek(0x0C) >> (2 * pin) & 3U) != 2) {
      return fmt::format("P{}{} is not read, pulled down", name, pin);
    }
  }
  for (const auto& [name, pin] : kOutputs) {
    if (chip.port(name).mode(pin) != target::Gpio::Mode::kOutput) {
      return fmt::format("P{}{} is not driven", name, pin);
    }
  }

  for (const PinPromise& promise : kPins) {
    const target::Gpio& port = chip.port(promise.port);
    const std::uint32_t pull = port.peek(0x0C) >> (2 * promise.pin) & 3U;
    const std::uint32_t speed = port.peek(0x08) >> (2 * promise.pin) & 3U;
    if (!port.has_function(promise.pin, promise.function) || pull != promise.pull || speed != promise.speed) {
      return fmt::format("P{}{} is not what the board's table says", promise.port, promise.pin);
    }
  }
  return "";
}

// Cycles of the core since the start of the PWM period, where the counter turns upwards.
int cycles_into_period(target::Stm32g474& chip) {
  constexpr std::uint32_t kDown = 1U << 4;
  constexpr int kPeriod_cycles = 8500;
  const int count = static_cast<int>(chip.bus.read(0x40012C24, 4));
  return (chip.bus.read(0x40012C00, 4) & kDown) != 0 ? kPeriod_cycles - count : count;
}

// Both bridges switch at the same time, and the tick comes when the current loop and the encoders are done.
std::string broken_phase(target::Stm32g474& chip) {
  constexpr int kCyclesPerTickCount = 4;
  constexpr int kPeriod_cycles = 8500;
  if (chip.bus.read(0x40012C24, 4) != chip.bus.read(0x40013424, 4) ||
      chip.tim1.is_running() != chip.tim8.is_running()) {
    return "the bridges do not count in phase";
  }
  const int since_tick = static_cast<int>(chip.bus.read(0x40001024, 4)) * kCyclesPerTickCount;
  const int tick = ((cycles_into_period(chip) - since_tick) % kPeriod_cycles + kPeriod_cycles) % kPeriod_cycles;
  return is_near(tick / 170.0, kTick_us, 1.0) ? ""
                                              : fmt::format("the tick comes {:.1f} us into its period", tick / 170.0);
}

std::string broken_promise(target::Stm32g474& chip) {
  if (chip.rcc.causes() != 0) {
    return "the cause of the reset is kept in the chip, too, where the next one would be added to it";
  }
  for (const std::string& broken : {broken_pin(chip), broken_phase(chip)}) {
    if (!broken.empty()) {
      return broken;
    }
  }
  for (const Promise& promise : kPromises) {
    if ((chip.bus.peek(promise.address) & promise.mask) != promise.value) {
      return promise.what;
    }
  }
  const std::map<int, int> priorities = {{target::kTim1BreakInterrupt, 0}, {target::kTim8BreakInterrupt, 0},
                                         {target::kAdc12Interrupt, 1},     {target::kTim6Interrupt, 2},
                                         {target::kTim7Interrupt, 2},      {target::kFdcan1Interrupt0, 3}};
  for (const auto& [interrupt, priority] : priorities) {
    if (chip.exceptions.priority(target::kFirstInterrupt + interrupt) != priority << 4 ||
        !chip.exceptions.is_enabled(target::kFirstInterrupt + interrupt)) {
      return fmt::format("interrupt {} is not enabled at priority {}", interrupt, priority);
    }
  }
  if (chip.exceptions.priority(target::kPendSv) != 4 << 4) {
    return "the deferred task does not run below all interrupts";
  }
  if (chip.rcc.core_hz() != 170'000'000 || chip.tim1.period() != chip.tim8.period() ||
      chip.tim1.period() != 50 * target::kUnitsPerMicrosecond ||
      chip.tim6.period() != 1000 * target::kUnitsPerMicrosecond) {
    return "a clock is not what it should be";
  }
  return is_near(chip.watchdog.timeout_s(), 0.02, 0.002) ? "" : "the watchdog's time is not 20 ms";
}

// The filters pass the frames of canopen/heard_frames.h and no others: no other, extended or remote frame costs an
// interrupt.
std::string broken_filter(BoardRig& rig) {
  const auto accepted_of = [&rig](const std::vector<can_frame>& frames) {
    const int before = rig.machine.chip().fdcan1.accepted();
    for (const can_frame& frame : frames) {
      rig.client.send(frame);
    }
    rig.client.pass(3);
    return rig.machine.chip().fdcan1.accepted() - before;
  };
  const std::vector<can_frame> foreign = {{0x581, 0, 8, {}, 0},
                                          {0x6E0, 0, 8, {}, 0},
                                          {0x7E4, 0, 8, {}, 0},
                                          {0x601, CAN_FRAME_REMOTE, 8, {}, 0},
                                          {0x601, CAN_FRAME_EXTENDED, 8, {}, 0},
                                          {0x601, CAN_FRAME_EXTENDED | CAN_FRAME_REMOTE, 8, {}, 0}};
  const std::vector<can_frame> heard = {{0x000, 0, 2, {1, 1}, 0}, {0x080, 0, 0, {}, 0}, {0x181, 0, 0, {}, 0},
                                        {0x57F, 0, 0, {}, 0},     {0x680, 0, 0, {}, 0}, {0x6DF, 0, 0, {}, 0},
                                        {0x77F, 0, 1, {5}, 0},    {0x7E5, 0, 8, {}, 0}};
  if (accepted_of(foreign) != 0) {
    return "a frame that is not for the node passes the filters";
  }
  return accepted_of(heard) == static_cast<int>(heard.size()) ? "" : "a frame for the node does not pass the filters";
}

// Each edge of the strobe is counted, and stamped with the clock, which counts us.
std::string broken_strobe(BoardRig& rig) {
  constexpr std::uint32_t kEdges = 40;  // more than the ring holds
  constexpr std::uint32_t kClock = 0x40000C24;
  const std::uint32_t begin_us = rig.machine.chip().bus.read(kClock, 4);
  const double begin_s = rig.machine.time_s();
  for (std::uint32_t i = 0; i < kEdges; ++i) {
    rig.machine.strobe();
    rig.client.pass(1);
  }
  if (!is_near(rig.machine.chip().bus.read(kClock, 4) - begin_us, 1e6 * (rig.machine.time_s() - begin_s), 2.0)) {
    return "TIM5 does not count us";
  }
  const std::uint32_t last_us = rig.machine.chip().bus.read(kClock, 4);
  rig.machine.strobe();
  rig.client.pass(2);
  if (rig.client.read(0x3074, 4) != last_us) {
    return "an edge of the strobe is not stamped with the clock";
  }
  return rig.client.read(0x3074, 5) == kEdges + 1 && rig.client.read(0x3074, 11) == 0U ? ""
                                                                                       : "edges of the strobe are lost";
}

// The first error found; empty when there is none.
std::string flaw_of(BoardRig& rig) {
  target::Stm32g474& chip = rig.machine.chip();
  const auto violation = [&chip] { return chip.violations.list().empty() ? "" : chip.violations.list().front(); };
  for (int i = 0; i < kBoot_ms; ++i) {
    rig.client.pass(1);
    if (!violation().empty() || !rig.machine.is_safe()) {
      return violation().empty() ? "a bridge is on at the start" : violation();
    }
  }
  if (rig.client.boots() != 1 || rig.client.heartbeats() < 2 || !rig.client.emergencies().empty()) {
    return "it does not start as it should";
  }
  if (const std::string promise = broken_promise(chip); !promise.empty()) {
    return promise;
  }
  if (const std::string strobe = broken_strobe(rig); !strobe.empty()) {
    return strobe;
  }
  rig.client.start_node();
  rig.client.pass(3);
  if (rig.client.pdos() != 4) {  // all TPDOs, in one tick
    return "a frame that waits for a transmit buffer does not go out";
  }
  if (const std::string filter = broken_filter(rig); !filter.empty()) {
    return filter;
  }
  if (!rig.client.enable(kCyclicVelocity)) {
    return "an axis is not enabled";
  }
  for (int i = 0; i < 150; ++i) {
    rig.client.set_speeds(kSpeed_urad_s, kSpeed_urad_s);
    rig.client.pass(1);
  }
  if (chip.core.costs().finished().count(target::kFirstInterrupt + target::kTim7Interrupt) == 0) {
    return "nothing is read before the tick";
  }
  for (std::size_t axis = 0; axis < sim::kAxes; ++axis) {
    if (!is_near(1e6 * rig.truth().inertial_rate_rad_s[axis], kSpeed_urad_s, 0.05 * kSpeed_urad_s)) {
      return "an axis does not turn as commanded";
    }
  }
  if (!violation().empty() || !rig.client.emergencies().empty() || chip.resets() != 0) {
    return violation().empty() ? "an error while it turns" : violation();
  }
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    rig.machine.set_driver_fault(axis, true);
    if (rig.machine.is_bridge_on(axis)) {
      return "a driver's fault does not switch its bridge off";
    }
  }
  rig.client.pass(20);
  if (rig.client.emergencies().empty()) {
    return "a driver's fault is not reported";
  }
  if (chip.port('C').drives_high(8) || chip.port('C').drives_high(9)) {
    return "a gate driver stays enabled after its fault";
  }
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    rig.machine.set_driver_fault(axis, false);
    if (!rig.client.enable_again(axis)) {
      return "an axis does not come back when its driver's fault has gone";
    }
  }
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    if (!rig.machine.is_brake_powered(axis)) {
      return "a brake is not released while torque stands";
    }
  }
  rig.machine.set_sto(target::BoardMachine::StoChannel::kB, false);
  rig.machine.run(4e-3);
  if (!rig.machine.is_safe()) {
    return "channel B of STO does not switch both bridges off";
  }
  rig.client.pass(5);
  if (rig.client.error_code(0) != 0x5441 || rig.machine.is_brake_powered(0) || rig.machine.is_brake_powered(1)) {
    return "channel B of STO is not reported as such, or a brake is not engaged";
  }
  rig.machine.set_sto(target::BoardMachine::StoChannel::kB, true);
  rig.client.pass(10);
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    if (!rig.client.enable_again(axis)) {
      return "an axis does not come back when STO permits torque again";
    }
  }
  chip.tim6.stall();
  rig.client.pass(60);
  return chip.resets() == 1 && chip.last_reset() == target::ResetCause::kWatchdog ? violation() : "no watchdog reset";
}

// Writes that carry data and no wiring (duties, message RAM, DMA addresses), or whose effect only people can see.
bool is_data(std::uint32_t address) {
  const std::uint32_t page = address & ~0x3FFU;
  const std::uint32_t offset = address & 0x3FFU;
  const bool timer = page == 0x40012C00 || page == 0x40013400;
  const bool dma = page == 0x40020000 || page == 0x40020400;
  const bool clears_pending = address >= 0xE000E280 && address < 0xE000E300;  // of which nothing pends at the start
  const bool led = page == 0x48000000 && offset == 0x18;                      // PA5
  return clears_pending || led || (timer && (offset == 0x34 || offset == 0x38)) ||
         (address >= 0x4000A400 && address < 0x4000A800) || (dma && offset >= 8 && (offset - 8) % 0x14 == 12);
}

// Flags that a timer's status register clears by zeros: the bits beside them have no effect.
std::uint32_t bits_without_effect(const Write& write) {
  const std::uint32_t page = write.address & ~0x3FFU;
  const bool timer = page == 0x40001000 || page == 0x40012C00 || page == 0x40013400;
  return timer && (write.address & 0x3FFU) == 0x10 ? write.value : 0;
}

// Every bit that the image changes in a register, with its first new value.
std::vector<Bend> all_bends() {
  std::map<std::uint32_t, std::uint32_t> known;
  std::vector<Bend> bends;
  BoardRig rig(bench::tracker_plant());
  rig.machine.chip().bus.monitor([&](const Write& write) {
    std::uint32_t fresh =
        is_data(write.address) ? 0 : write.changed & ~known[write.address] & ~bits_without_effect(write);
    known[write.address] |= fresh;
    for (; fresh != 0; fresh &= fresh - 1) {
      const std::uint32_t bit = fresh & (~fresh + 1);
      bends.push_back({write.address, bit, (write.value & bit) == 0});
    }
  });
  TEST_ASSERT_EQUAL_STRING("", flaw_of(rig).c_str());
  return bends;
}

// Bits that may be wrong without any effect on this board, and why: docs/emulator.md lists them.
struct Harmless {
  std::uint32_t address;
  unsigned bit;
  bool forced;
  const char *why;
};

constexpr Harmless kHarmless[] = {
    {0x50000000, 0, false, "ADC1 is switched on once after a reset, which has cleared the ready flag"},
    {0x50000100, 0, false, "ADC2, the same"},
    {0x50000000, 1, true, "ADC1: clears the end-of-sampling flag, which nobody asks for"},
    {0x50000100, 1, true, "ADC2, the same"},
    {0x50000000, 5, true, "ADC1: clears the end-of-conversion flag, which nobody asks for"},
    {0x50000100, 5, true, "ADC2, the same"},
    {0x50000100, 6, false, "ADC2 ends its sequence with ADC1, whose flag is read"},
    {0x40012C00, 7, false, "TIM1's period is never changed, so its preload does nothing after the first update"},
    {0x40013400, 7, false, "TIM8, the same"},
    {0x40001000, 7, false, "TIM6, the same"},
    {0x40001000, 2, false, "TIM6: the flag that it keeps away is cleared before the interrupt is enabled"},
    {0x40012C10, 0, true, "TIM1's update flag has no interrupt, and nobody asks for it"},
    {0x40013410, 0, true, "TIM8, the same"},
    {0x40001024, 4, false, "TIM6 begins 0.4 us earlier or later, of a tick that is promised to 1 us"},
    {0x40022018, 30, false, "flash: clears the flag of a corrected bit, and no bit of this flash is weak"},
    {0x40006480, 0, false, "FDCAN1: a remote extended frame is refused as an extended one, too"},
    {0x40006450, 2, false, "FDCAN1: lost frames are counted twice; the count is for a debugger"},
};

const char *why_harmless(const Bend& bend) {
  for (const Harmless& harmless : kHarmless) {
    if (harmless.address == bend.address && 1U << harmless.bit == bend.bit && harmless.forced == bend.forced) {
      return harmless.why;
    }
  }
  return nullptr;
}

void test_a_wrong_bit_is_seen() {
  const std::vector<Bend> bends = all_bends();
  const auto some = static_cast<std::size_t>(by_size(30, 60, 60));
  const bool all = test_size_wanted() == TEST_LARGE;
  const std::size_t step = all ? 1 : std::max<std::size_t>(1, bends.size() / some);
  std::size_t bent = 0;
  std::size_t seen = 0;
  std::size_t unexplained = 0;
  for (std::size_t i = 0; i < bends.size(); i += step) {
    BoardRig rig(bench::tracker_plant());
    rig.machine.chip().bus.bend(bends[i]);
    const std::string flaw = flaw_of(rig);
    const char *const harmless = flaw.empty() ? why_harmless(bends[i]) : nullptr;
    ++bent;
    seen += flaw.empty() ? 0 : 1;
    unexplained += flaw.empty() && harmless == nullptr ? 1 : 0;
    if (flaw.empty() || all) {
      const std::string fate = harmless != nullptr ? fmt::format("harmless: {}", harmless) : "NOT SEEN";
      TEST_MESSAGE(fmt::format("0x{:08x}, bit {} stuck at {}: {}", bends[i].address, __builtin_ctz(bends[i].bit),
                               bends[i].forced ? 1 : 0, flaw.empty() ? fate : flaw)
                       .c_str());
    }
  }
  TEST_MESSAGE(fmt::format("{} of {} bent bits are seen, {} are harmless, {} neither (of {} in all)", seen, bent,
                           bent - seen - unexplained, unexplained, bends.size())
                   .c_str());
  TEST_ASSERT_GREATER_OR_EQUAL_UINT(30, bent);
  TEST_ASSERT_EQUAL_UINT_MESSAGE(0, unexplained, "a wrong bit stays unseen");
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_wrong_bit_is_seen);
  return UNITY_END();
}
