// SPDX-License-Identifier: Apache-2.0
// The board's image on the emulated chip: its start, its messages, its storage, and the cost of its interrupts. Its
// reactions to faults: test_board_faults.cpp.
#include <boost/crc.hpp>
#include <cstring>
#include <map>
#include <string>

#include "board_steps.hpp"
#include "machine/sensors/camera_sender.hpp"

using bench::BoardRig;
using bench::boot;
using bench::boot_and_turn;
using bench::expect_no_violations;
using bench::has_heard;
using bench::kBoot_ms;
using bench::kCyclicVelocity;
using bench::kSlow_urad_s;
using bench::kTick_us;
namespace sim = trackservo::sim;
namespace target = trackservo::target;

void setUp(void) {}
void tearDown(void) {}

namespace {

// --- start ---

void test_it_starts_safe_passes_its_self_tests_and_is_heard() {
  BoardRig rig(bench::tracker_plant());
  constexpr std::uint32_t kResetFlags = 0x40021094;  // cleared once the RAM has been tested
  double tested_after_s = 0.0;
  double heard_after_s = 0.0;
  rig.machine.chip().bus.monitor([&](const target::Bus::Write& write) {
    tested_after_s = write.address == kResetFlags ? rig.machine.time_s() : tested_after_s;
  });
  for (int part = 0; part < 20 * kBoot_ms; ++part) {
    rig.machine.run(0.05e-3);
    heard_after_s = rig.client.boots() == 0 ? rig.machine.time_s() : heard_after_s;
    TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "a bridge is on before a command");
  }
  TEST_MESSAGE(
      fmt::format("after power-on: RAM tested {:.0f} ms, heard {:.0f} ms", 1e3 * tested_after_s, 1e3 * heard_after_s)
          .c_str());
  TEST_ASSERT_EQUAL_INT(1, rig.client.boots());
  TEST_ASSERT_GREATER_OR_EQUAL_INT(2, rig.client.heartbeats());
  TEST_ASSERT_EQUAL_UINT(0, rig.client.emergencies().size());
  TEST_ASSERT_EQUAL_UINT32(170'000'000, rig.machine.chip().rcc.core_hz());
  TEST_ASSERT_TRUE(rig.machine.chip().watchdog.is_running());
  TEST_ASSERT_EQUAL_INT(0, rig.machine.chip().resets());
  expect_no_violations(rig);
}

// Two boards on one bus can be distinguished, and the contents of the flash can be traced to the flashed file.
void test_it_says_which_board_and_which_dictionary_it_is() {
  constexpr std::size_t kSchemaHashAt = 0x200 + 80;
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  boost::crc_32_type crc;
  crc.process_bytes(target::FactoryWords::kUniqueId, sizeof target::FactoryWords::kUniqueId);
  TEST_ASSERT_EQUAL_HEX32(crc.checksum(), rig.client.read(0x1018, 4).value());
  std::uint32_t schema_hash = 0;
  std::memcpy(&schema_hash, bench::board_image().data() + kSchemaHashAt, sizeof schema_hash);
  TEST_ASSERT_EQUAL_HEX32_MESSAGE(schema_hash, rig.client.read(0x3030, 2).value(),
                                  "run tools/update-docs dictionary, then build the image again");
  expect_no_violations(rig);
}

void test_a_dip_of_the_supply_is_reported_and_a_power_on_is_not() {
  constexpr std::uint16_t kSupplyFailed = 0x5100;
  constexpr std::uint8_t kBrownOut = 7;
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  rig.client.forget();
  rig.machine.chip().request_brown_out();
  boot(rig);
  TEST_ASSERT_TRUE_MESSAGE(has_heard(rig, kSupplyFailed, kBrownOut), "the dip is not reported");
  TEST_ASSERT_TRUE_MESSAGE(rig.client.enable(kCyclicVelocity),
                           "the dip is over, and must not keep an axis from working");
  rig.client.forget();
  rig.machine.chip().request_reset(target::ResetCause::kPowerOn);
  boot(rig);
  TEST_ASSERT_EQUAL_UINT_MESSAGE(0, rig.client.emergencies().size(), "RAM full of anything is no dip");
  expect_no_violations(rig);
}

void test_both_axes_turn_when_told_to() {
  BoardRig rig(bench::tracker_plant());
  boot_and_turn(rig);
  expect_no_violations(rig);
}

// A motor with shorted terminals would carry 0.2 A at this rate, and brake.
void test_a_bridge_that_is_switched_off_leaves_the_terminals_open() {
  constexpr std::uint16_t kControlword = 0x6040;
  constexpr double kFast_rad_s = 0.1;
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  rig.client.start_node();
  TEST_ASSERT_TRUE(rig.client.enable(kCyclicVelocity));
  for (int i = 0; i < 300; ++i) {
    rig.client.set_speeds(static_cast<std::int32_t>(1e6 * kFast_rad_s), 0);
    rig.client.pass(1);
  }
  TEST_ASSERT_TRUE(rig.client.write(kControlword, 0, 0, 2));
  for (int i = 0; i < 20 && rig.machine.is_bridge_on(0); ++i) {
    rig.client.pass(1);
  }
  TEST_ASSERT_FALSE(rig.machine.is_bridge_on(0));
  rig.client.pass(3);  // the diodes lead the current until it is gone
  TEST_ASSERT_TRUE_MESSAGE(rig.truth().joint_rate_rad_s[0] > 0.5 * kFast_rad_s, "it turns no more");
  TEST_ASSERT_TRUE_MESSAGE(rig.truth().current_a[0] == 0.0, "current flows while the bridge is off");
  expect_no_violations(rig);
}

// --- bus-off ---

void test_it_comes_back_from_bus_off() {
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  rig.machine.chip().fdcan1.go_bus_off();
  rig.client.pass(400);
  rig.client.forget();
  rig.client.pass(250);
  TEST_ASSERT_GREATER_OR_EQUAL_INT(2, rig.client.heartbeats());
  TEST_ASSERT_TRUE(rig.client.read(0x1000).has_value());
  expect_no_violations(rig);
}

// --- parameter store ---

constexpr std::uint16_t kSpeedLimit = 0x607F;
constexpr int kMaxStoring_ms = 600;
constexpr std::uint64_t kMaxTickCycles = 85'000;  // half a millisecond

bool store(BoardRig& rig, std::uint32_t speed_limit) {
  constexpr std::uint32_t kSave = 0x65766173;
  TEST_ASSERT_TRUE(rig.client.write(kSpeedLimit, 0, speed_limit, 4));
  return rig.client.write(0x1010, 1, kSave, 4, kMaxStoring_ms);
}

void fail_supply(BoardRig& rig) { rig.machine.chip().request_reset(target::ResetCause::kPowerOn); }

std::uint64_t worst_tick_cycles(BoardRig& rig) {
  std::uint64_t worst = 0;
  for (const auto& [exception, costs] : rig.machine.chip().core.costs().finished()) {
    if (exception - target::kFirstInterrupt == target::kTim6Interrupt) {
      worst = target::summary_of(costs).worst.cycles;
    }
  }
  return worst;
}

void test_what_is_stored_survives_a_loss_of_power() {
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  TEST_ASSERT_EQUAL_UINT32(0, rig.client.read(0x3031, 1).value());
  for (std::uint32_t n = 1; n <= 3; ++n) {  // the third begins with the erasing of four pages
    const double begin_s = rig.machine.time_s();
    rig.machine.chip().core.costs().clear();
    TEST_ASSERT_TRUE(store(rig, 654320 + n));
    const std::uint64_t worst_cycles = worst_tick_cycles(rig);
    TEST_MESSAGE(
        fmt::format("save {}: {:.0f} ms, worst tick {} cycles", n, 1e3 * (rig.machine.time_s() - begin_s), worst_cycles)
            .c_str());
    TEST_ASSERT_TRUE_MESSAGE(worst_cycles < kMaxTickCycles, "storing makes a tick too long");
  }
  TEST_ASSERT_EQUAL_INT(0, rig.machine.chip().resets());  // the watchdog was refreshed all the time
  rig.client.forget();
  fail_supply(rig);
  boot(rig);
  TEST_ASSERT_EQUAL_UINT32(654323, rig.client.read(kSpeedLimit).value());
  TEST_ASSERT_EQUAL_UINT32(1, rig.client.read(0x3031, 1).value());
  TEST_ASSERT_EQUAL_UINT32(3, rig.client.read(0x3031, 2).value());
  TEST_ASSERT_EQUAL_UINT(0, rig.client.emergencies().size());
  expect_no_violations(rig);
}

// The first save finds blank pages; those after a cut erase four pages first: each number is an operation of the flash.
void test_a_loss_of_power_while_it_stores_leaves_the_old_set_or_the_new_one() {
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  TEST_ASSERT_TRUE(store(rig, 700000));
  std::uint32_t old = 700000;
  std::uint32_t wanted = old;
  for (const int operation : {0, 2, 4, 150, 272}) {
    ++wanted;
    rig.client.forget();
    rig.machine.chip().flash.fail_supply_in(operation, [&rig] { fail_supply(rig); });
    TEST_ASSERT_FALSE(store(rig, wanted));
    TEST_ASSERT_EQUAL_INT(1, rig.client.boots());
    const std::uint32_t found = rig.client.read(kSpeedLimit).value();
    TEST_MESSAGE(fmt::format("power cut at operation {}: {}", operation, found == old ? "old set" : "new set").c_str());
    TEST_ASSERT_TRUE(found == old || found == wanted);
    old = found;
  }
  TEST_ASSERT_TRUE(store(rig, 800000));
  expect_no_violations(rig);
}

// Two wrong bits in the newest set: the NMI reports them to the reader, whatever ECCR shows of the program, without a
// restart.
void test_a_set_that_the_flash_cannot_read_is_reported_and_no_axis_turns() {
  for (const bool program_is_weak : {false, true}) {
    BoardRig rig(bench::tracker_plant());
    boot(rig);
    TEST_ASSERT_TRUE(store(rig, 700000));
    TEST_ASSERT_TRUE(store(rig, 700001));  // behind it: its first double word is that of the third page
    target::FlashInterface& flash = rig.machine.chip().flash;
    constexpr std::uint32_t kNewest = target::Stm32g474::kParameterOffset + (2 + 2) * 2048;
    flash.weaken(kNewest, target::FlashInterface::WrongBits::kTwo);
    flash.weaken(kNewest - 2 * 2048 + 40, target::FlashInterface::WrongBits::kOne);  // of the older set: corrected
    flash.correct_program_at_reset(program_is_weak);
    rig.client.forget();
    fail_supply(rig);
    boot(rig);
    TEST_ASSERT_EQUAL_INT(1, rig.machine.chip().resets());
    TEST_ASSERT_EQUAL_UINT32(700000, rig.client.read(kSpeedLimit).value());
    TEST_ASSERT_EQUAL_UINT32(3, rig.client.read(0x3031, 1).value());
    TEST_ASSERT_TRUE_MESSAGE(has_heard(rig, 0x6310, 1), "an older set in silence");
    TEST_ASSERT_EQUAL_HEX32(0x08, rig.client.read(0x6041).value() & 0x4F);
    TEST_ASSERT_TRUE(store(rig, 700002));
    rig.client.forget();
    fail_supply(rig);
    boot(rig);
    TEST_ASSERT_EQUAL_UINT32(700002, rig.client.read(kSpeedLimit).value());
    TEST_ASSERT_EQUAL_UINT32(1, rig.client.read(0x3031, 1).value());
    expect_no_violations(rig);
  }
}

// --- cost ---

constexpr double kMaxLoad = 0.30;
constexpr std::uint64_t kMaxTickInstructions = 6500;
constexpr int kScope = 0x3000;
constexpr double kCyclesPerMicrosecond = 170.0;

// A full bus at 1 Mbit/s: SYNC, four RPDOs and four TPDOs each ms, an SDO request and its answer in every eighth. In
// tracking RPDO4 carries a camera's frames at 500 Hz, in cyclic torque RPDO3 the torques.
class FullBus {
 public:
  FullBus(BoardRig& rig, int mode) : rig_(rig), mode_(mode), takes_pictures_(mode == kTracking) {
    for (int n = 0; n < 4; ++n) {
      write(0x1400 + n, 2, 1, 1);
      write(0x1800 + n, 2, 1, 1);
    }
    if (mode == kTracking) {
      for (const sim::ObjectWrite& object : sim::camera_mapping(4, 0x501)) {
        write(object.index, object.sub, object.value, object.sub == 0 ? 1 : 4);
      }
      write(0x1403, 2, 255, 1);  // at once
    } else if (mode == kCyclicTorque) {
      write(0x1402, 1, 0x80000401, 4);
      write(0x1602, 0, 0, 1);
      write(0x1602, 1, 0x60710010, 4);
      write(0x1602, 2, 0x68710010, 4);
      write(0x1602, 0, 2, 1);
      write(0x1402, 1, 0x401, 4);
    }
    write(kScope, 9, 8, 1);  // signals, more than the default
    write(kScope, 5, 6, 1);  // waits for a fault
    write(kScope, 1, 1, 1);
    rig.client.start_node();
    TEST_ASSERT_TRUE(rig.client.enable(mode));
    for (int axis = 0; axis < 2; ++axis) {
      start_counts_[axis] =
          static_cast<std::int32_t>(rig.client.read(static_cast<std::uint16_t>(0x6064 + 0x800 * axis)).value());
    }
  }

  void pass_ms() {
    const bool back = tick_ % 1000 >= 500;
    const int since_turn = tick_ % 500;
    const auto moved = [&](int axis) {
      const int ramp = 200 * (back ? 500 - since_turn : since_turn);
      return start_counts_[axis] + (mode_ == kProfilePosition ? (back ? -200000 : 200000) : ramp);
    };
    for (int axis = 0; axis < 2; ++axis) {
      send(0x201 + 0x100 * axis, {since_turn < 250 ? 0x3FU : 0x2FU, 0, static_cast<unsigned>(mode_)});
    }
    if (mode_ == kCyclicTorque) {
      send(0x401, back ? kTorques : kOpposite);
    } else {
      send_words(0x401, back ? -20000 : 20000, back ? 20000 : -20000);
    }
    if (!takes_pictures_) {
      send_words(0x501, moved(0), moved(1));
    } else if (tick_ % 2 == 0) {
      send_picture(back);
    }
    if (tick_ % 8 == 0) {
      send(0x601, {0x40, 0x64, 0x68, 0, 0, 0, 0, 0});
    }
    send(0x080, {});
    rig_.client.pass(1);
    ++tick_;
  }

  // From the next millisecond on; the set-points stay those of this mode's kind.
  void set_mode(int mode) { mode_ = mode; }

  static constexpr int kProfilePosition = 1;
  static constexpr int kCyclicTorque = 10;
  static constexpr int kTracking = 0xFF;  // -1 as an 8-bit number

 private:
  // Of +-2 % of the rated torque for the azimuth and for the pitch.
  const std::vector<unsigned> kTorques{20, 0, 0xEC, 0xFF};
  const std::vector<unsigned> kOpposite{0xEC, 0xFF, 20, 0};

  // Image errors of 50 and -30 urad, or -50 and 30, 21 ms old.
  void send_picture(bool back) {
    ++picture_;
    if (back) {
      send(0x501, {0xCE, 0xFF, 30, 0, 0x34, 0x08, 90, picture_ & 0xFFU});
    } else {
      send(0x501, {50, 0, 0xE2, 0xFF, 0x34, 0x08, 90, picture_ & 0xFFU});
    }
  }

  void write(int index, int sub, std::uint32_t value, int bytes) {
    TEST_ASSERT_TRUE(
        rig_.client.write(static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(sub), value, bytes));
  }

  void send(std::uint32_t identifier, const std::vector<unsigned>& bytes) {
    can_frame frame = {};
    frame.id = identifier;
    frame.length = static_cast<std::uint8_t>(bytes.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      frame.data[i] = static_cast<std::uint8_t>(bytes[i]);
    }
    rig_.client.send(frame);
  }

  void send_words(std::uint32_t identifier, std::int32_t first, std::int32_t second) {
    std::vector<unsigned> bytes;
    for (const std::int32_t word : {first, second}) {
      for (int shift = 0; shift < 32; shift += 8) {
        bytes.push_back(static_cast<std::uint32_t>(word) >> shift & 0xFFU);
      }
    }
    send(identifier, bytes);
  }

  BoardRig& rig_;
  int mode_;
  bool takes_pictures_;  // in RPDO4, instead of positions
  int tick_ = 0;
  unsigned picture_ = 0;
  std::array<std::int32_t, 2> start_counts_{};
};

void print_costs(const std::map<int, std::vector<target::Cost>>& costs, const char *mode, double cycles, double *load) {
  const std::map<int, const char *> names = {{target::kFirstInterrupt + target::kAdc12Interrupt, "both current loops"},
                                             {target::kFirstInterrupt + target::kTim6Interrupt, "1 kHz task"},
                                             {target::kFirstInterrupt + target::kTim7Interrupt, "pre-tick"},
                                             {target::kFirstInterrupt + target::kFdcan1Interrupt0, "CAN frame"},
                                             {target::kPendSv, "service"}};
  for (const auto& [exception, name] : names) {
    const target::CostSummary cost = target::summary_of(costs.at(exception));
    TEST_MESSAGE(fmt::format("| {} | {} | {} | {} | {} | {} | {} |", mode, name, cost.count, cost.typical.instructions,
                             cost.worst.instructions, cost.typical.cycles, cost.worst.cycles)
                     .c_str());
    *load += static_cast<double>(cost.sum.cycles) / cycles;
  }
}

void test_what_the_interrupts_cost_on_a_full_bus() {
  const std::map<int, const char *> modes = {{9, "cyclic velocity"},
                                             {8, "cyclic position"},
                                             {FullBus::kProfilePosition, "profile position"},
                                             {FullBus::kCyclicTorque, "cyclic torque"},
                                             {FullBus::kTracking, "tracking"}};
  TEST_MESSAGE("| mode | interrupt | times | instructions, typical | worst | cycles, typical | worst |");
  for (const auto& [mode, name] : modes) {
    BoardRig rig(bench::tracker_plant());
    boot(rig);
    FullBus bus(rig, mode);
    for (int i = 0; i < 100; ++i) {
      bus.pass_ms();
    }
    auto& core = rig.machine.chip().core;
    core.costs().clear();
    const std::uint64_t begin = core.cycles();
    for (int i = 0; i < 1000; ++i) {
      bus.pass_ms();
    }
    double load = 0.0;
    print_costs(core.costs().finished(), name, static_cast<double>(core.cycles() - begin), &load);
    TEST_MESSAGE(fmt::format("load by interrupts at 170 MHz, {}: {:.1f} %", name, 100.0 * load).c_str());
    TEST_ASSERT_TRUE_MESSAGE(load < kMaxLoad, "too little time left for the background");
    const auto& ticks = core.costs().finished().at(target::kFirstInterrupt + target::kTim6Interrupt);
    const target::Cost worst = target::summary_of(ticks).worst;
    TEST_ASSERT_TRUE_MESSAGE(worst.instructions <= kMaxTickInstructions,
                             "the 1 kHz task takes more than 6,500 instructions");
    const auto& loops = core.costs().finished().at(target::kFirstInterrupt + target::kAdc12Interrupt);
    const auto end_of = [&loops](double cycles) {
      return kTick_us +
             (cycles + 2.0 * static_cast<double>(target::summary_of(loops).worst.cycles)) / kCyclesPerMicrosecond;
    };
    const double end_us = end_of(static_cast<double>(worst.cycles));
    TEST_MESSAGE(fmt::format("the longest tick of {} ends {:.0f} us after its period began", name, end_us).c_str());
    TEST_ASSERT_TRUE_MESSAGE(end_us < 100.0, "set-points come too late for period 2");
    const double longest_us = end_of(static_cast<double>(worst.cycles) / static_cast<double>(worst.instructions) *
                                     static_cast<double>(kMaxTickInstructions));
    TEST_MESSAGE(
        fmt::format("one of {} instructions would end after {:.0f} us", kMaxTickInstructions, longest_us).c_str());
    TEST_ASSERT_TRUE_MESSAGE(longest_us < 100.0, "a tick that uses all its instructions would end too late");
    TEST_ASSERT_TRUE(rig.client.is_enabled(0) && rig.client.is_enabled(1));
    expect_no_violations(rig);
  }
}

// The bus with which an axis can change between these modes; csp needs the RPDO that tracking takes for pictures.
struct ModeChanges {
  int bus;
  std::vector<int> modes;
};

// Every pair of modes, with both axes turning, in one RPDO per axis: the tick that closes another loop does more.
void check_changes(const ModeChanges& changes) {
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  FullBus bus(rig, changes.bus);
  for (int i = 0; i < 100; ++i) {
    bus.pass_ms();
  }
  auto& core = rig.machine.chip().core;
  core.costs().clear();
  for (const int from : changes.modes) {
    for (const int to : changes.modes) {
      for (const int mode : {from, to}) {
        bus.set_mode(mode);
        for (int i = 0; i < 15; ++i) {
          bus.pass_ms();
        }
      }
    }
  }
  const auto& ticks = core.costs().finished().at(target::kFirstInterrupt + target::kTim6Interrupt);
  const auto& loops = core.costs().finished().at(target::kFirstInterrupt + target::kAdc12Interrupt);
  const target::Cost worst = target::summary_of(ticks).worst;
  const double end_us =
      kTick_us + static_cast<double>(worst.cycles + 2 * target::summary_of(loops).worst.cycles) / kCyclesPerMicrosecond;
  TEST_MESSAGE(fmt::format("worst tick with changes of the mode: {} instructions, {} cycles, ends after {:.0f} us",
                           worst.instructions, worst.cycles, end_us)
                   .c_str());
  constexpr std::uint64_t kMaxInstructions = 6500;  // as of a tick that keeps its mode
  TEST_ASSERT_TRUE(worst.instructions <= kMaxInstructions);
  TEST_ASSERT_TRUE(end_us < 100.0);
  TEST_ASSERT_EQUAL_INT(0, rig.machine.chip().resets());
  expect_no_violations(rig);
}

void test_a_tick_that_changes_the_mode_is_in_time() {
  check_changes({kCyclicVelocity, {1, 3, 8, 9}});
  check_changes({FullBus::kTracking, {1, 3, 9, FullBus::kTracking}});
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_it_starts_safe_passes_its_self_tests_and_is_heard);
  RUN_TEST(test_it_says_which_board_and_which_dictionary_it_is);
  RUN_TEST(test_a_dip_of_the_supply_is_reported_and_a_power_on_is_not);
  RUN_TEST(test_both_axes_turn_when_told_to);
  RUN_TEST(test_a_bridge_that_is_switched_off_leaves_the_terminals_open);
  RUN_TEST(test_it_comes_back_from_bus_off);
  RUN_TEST(test_what_is_stored_survives_a_loss_of_power);
  RUN_TEST(test_a_set_that_the_flash_cannot_read_is_reported_and_no_axis_turns);
  RUN_TEST(test_a_loss_of_power_while_it_stores_leaves_the_old_set_or_the_new_one);
  RUN_TEST(test_what_the_interrupts_cost_on_a_full_bus);
  RUN_TEST(test_a_tick_that_changes_the_mode_is_in_time);
  return UNITY_END();
}
