// SPDX-License-Identifier: Apache-2.0
// The board's image on an emulated chip with memory faults: RAM at the start, parity errors and the program memory in
// operation, stores to the hot code, the stack that is too small.
#include <cstring>

#include "board_steps.hpp"
#include "image_layout.hpp"

namespace target = trackservo::target;

void setUp(void) {}
void tearDown(void) {}

namespace {

using namespace bench;

constexpr std::uint16_t kSelfTest = 0x5000;
constexpr std::uint8_t kRam = 0x00;

constexpr std::uint16_t kImageDamaged = 0x5520;
constexpr std::uint8_t kImageDamagedFault = 33;

constexpr std::uint16_t kStackOverflow = 0x5510;
constexpr std::uint8_t kStackOverflowCause = 8;

constexpr std::uint32_t kRamBegin = 0x20000000;
constexpr std::uint32_t kRetained = 0x20017FC0;  // survives a reset, and is not tested
constexpr std::uint32_t kParityEnd = 0x20008000;
constexpr std::uint32_t kCcmBegin = 0x10000000;
constexpr std::uint32_t kCcmEnd = 0x10008000;

constexpr std::uint8_t kParityCause = 9;

// --- RAM at the start ---

void expect_not_ready(BoardRig& rig) {
  constexpr std::uint32_t kStateBits = 0x4F;
  TEST_ASSERT_EQUAL_HEX32(0, rig.client.read(0x6041).value() & kStateBits);
  TEST_ASSERT_FALSE_MESSAGE(rig.client.enable(kCyclicVelocity), "an axis works on damaged RAM");
  TEST_ASSERT_TRUE(rig.machine.is_safe());
}

// Where the stack never extends, in the middle of the variables (the scope's record), in unused RAM, and at both ends
// of the RAM for hot code.
void test_a_stuck_bit_of_ram_keeps_both_axes_from_being_ready() {
  for (const std::uint32_t address : {kRamBegin, kRamBegin + 0xA000, kRetained - 4, kCcmBegin, kCcmEnd - 4}) {
    for (const bool value : {false, true}) {
      BoardRig rig(bench::tracker_plant());
      rig.machine.chip().core.stick(address, 17, value);
      boot(rig);
      TEST_MESSAGE(fmt::format("bit 17 of 0x{:08x} stuck at {}", address, value ? 1 : 0).c_str());
      TEST_ASSERT_TRUE_MESSAGE(has_heard(rig, kSelfTest, kRam), "it is not reported");
      expect_not_ready(rig);
      expect_no_violations(rig);
    }
  }
}

// --- parity ---

// With parity, a word that is read before it was written is an error. What survives a reset lies outside.
void test_no_word_with_parity_is_read_before_it_was_written() {
  for (const auto& [begin, end] : {std::pair{kRamBegin, kParityEnd}, std::pair{kCcmBegin, kCcmEnd}}) {
    BoardRig rig(bench::tracker_plant());
    rig.machine.chip().core.report_unwritten_reads(begin, end);
    if (begin == kRamBegin) {
      boot_and_turn(rig);
    } else {  // code: the start-up alone writes it
      boot(rig);
    }
    expect_no_violations(rig);
  }
}

std::uint32_t node_address(BoardRig& rig) {
  const Layout layout = read_layout();
  std::uint32_t node = 0;  // the context of the board's tasks is the node's first member
  std::memcpy(&node, rig.machine.chip().core.memory_at(address_of("board", layout.hal_bytes) + layout.context, 4), 4);
  return node;
}

void test_gains_and_the_state_of_protection_lie_in_ram_with_parity() {
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  const Layout layout = read_layout();
  const std::uint32_t board = address_of("board", layout.hal_bytes);
  const std::uint32_t node = node_address(rig);
  TEST_MESSAGE(fmt::format("board 0x{:08x}, node 0x{:08x}, its safety state ends at 0x{:08x}", board, node,
                           node + layout.node_safety_bytes)
                   .c_str());
  TEST_ASSERT_TRUE(board >= kRamBegin && board + layout.hal_bytes <= kParityEnd);
  TEST_ASSERT_TRUE(node >= kRamBegin && node + layout.node_safety_bytes <= kParityEnd);
}

// Both bridges go off in hardware when the word is read; the board restarts and reports why.
void expect_parity_reset(BoardRig& rig, const char *what) {
  TEST_MESSAGE(what);
  expect_safe_reset(rig, 1, kStackOverflow, target::kNmi << 4 | kParityCause);
  TEST_ASSERT_TRUE_MESSAGE(rig.client.enable(kCyclicVelocity), "the restart has repaired it");
  expect_no_violations(rig);
}

constexpr std::uint16_t kOptionBytes = 0x5500;
constexpr std::uint8_t kNoRamParity = 1;
constexpr std::uint8_t kNoWriteProtection = 2;

constexpr unsigned kDataBit = 13;
constexpr unsigned kParityBit = target::CortexM4::kParityBit;

// The word that every PWM period reads first, both motor stages, and the code of the tick.
void test_a_parity_error_switches_both_bridges_off_and_resets() {
  const Layout layout = read_layout();
  const auto with = [](const char *what, auto address, unsigned bit, std::uint32_t words = 1) {
    BoardRig rig(bench::tracker_plant());
    boot_and_turn(rig);
    rig.client.forget();
    // A word that is written before it is read is repaired: the next one is read.
    for (std::uint32_t i = 0; i < words; ++i) {
      rig.machine.chip().flip_ram_bit((address(rig) & ~3U) + 4 * i, bit);
    }
    for (int i = 0; i < 25 && !rig.machine.is_safe(); ++i) {
      rig.machine.run(50e-6);
    }
    TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "a bridge is on 1.25 ms after the error");
    expect_parity_reset(rig, what);
  };
  with(
      "state of the board", [&layout](BoardRig&) { return address_of("board", layout.hal_bytes) + layout.context; },
      kDataBit);
  with(
      "motor stage of pitch",
      [&layout](BoardRig& rig) { return node_address(rig) + layout.motor + layout.motor_bytes; }, kDataBit,
      layout.motor_bytes / 4);
  // Of code, the parity itself: what an instruction with another bit does depends on where the linker has put it.
  with(
      "code of the current loop", [](BoardRig&) { return address_of("adc1_2_interrupt"); }, kParityBit);
  with(
      "code of the tick", [](BoardRig&) { return address_of("tim6_dac_interrupt"); }, kParityBit);
}

// The break comes from the hardware: the handler of the NMI would do the same, but some cycles later.
void test_a_parity_error_and_a_lock_up_are_connected_to_the_break_inputs() {
  constexpr std::uint32_t kSystemBreak = 1U << 13;
  for (const bool lock_up : {false, true}) {
    BoardRig rig(bench::tracker_plant());
    boot_and_turn(rig);
    if (lock_up) {
      rig.machine.chip().syscfg.find_lock_up();
    } else {
      rig.machine.chip().syscfg.find_parity_error();
    }
    TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "before any instruction");
    TEST_ASSERT_TRUE((rig.machine.chip().bus.peek(0x40012C10) & kSystemBreak) != 0);
  }
}

// As ST ships the chip: no parity, no write protection of the image.
void test_a_flipped_bit_of_the_hot_code_is_found_without_parity_as_well() {
  constexpr int kRound_ms = 1000;
  BoardRig rig(bench::tracker_plant());
  rig.machine.chip().flash.set_options(target::FlashInterface::kOptionsAtDelivery,
                                       target::FlashInterface::kNothingProtected);
  boot_and_turn(rig);
  TEST_ASSERT_TRUE_MESSAGE(has_heard(rig, kOptionBytes, kNoRamParity | kNoWriteProtection), "they are not reported");
  TEST_ASSERT_EQUAL_UINT32(0, rig.client.read(0x3061, 1).value() & 0x70U);
  rig.client.forget();
  rig.machine.chip().flip_ram_bit(address_of("tim1_brk_interrupt") & ~3U, 3);  // runs at a driver's fault only
  int passed_ms = 0;
  while (passed_ms < 2 * kRound_ms && !has_heard(rig, kImageDamaged, kImageDamagedFault)) {
    turn(rig, 1);
    ++passed_ms;
  }
  TEST_MESSAGE(fmt::format("found after {} ms", passed_ms).c_str());
  rig.client.pass(200);
  TEST_ASSERT_TRUE_MESSAGE(has_heard(rig, kImageDamaged, kImageDamagedFault), "it is not reported");
  TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "a bridge is still on");
  expect_no_violations(rig);
}

// A wild pointer: the state of the motor stages would be written over the code of the interrupts.
void test_a_store_to_the_hot_code_is_refused_and_ends_in_the_safe_state() {
  const Layout layout = read_layout();
  BoardRig rig(bench::tracker_plant());
  boot_and_turn(rig);
  rig.client.forget();
  auto& core = rig.machine.chip().core;
  const std::uint8_t *ccm = core.memory_at(kCcmBegin, kCcmEnd - kCcmBegin);
  const std::vector<std::uint8_t> before(ccm, ccm + (kCcmEnd - kCcmBegin));
  TEST_ASSERT_EQUAL_HEX32(0xFFFFFFFF, rig.machine.chip().syscfg.protected_pages());
  std::memcpy(core.memory_at(address_of("board", layout.hal_bytes) + layout.context, 4), &kCcmBegin, 4);
  rig.client.pass(2);
  TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "a bridge is on");
  TEST_ASSERT_EQUAL_INT(0, rig.machine.chip().resets());
  TEST_ASSERT_EQUAL_MEMORY_MESSAGE(before.data(), ccm, before.size(), "the hot code has changed");
  rig.client.pass(kWatchdog_ms + kBoot_ms);
  TEST_ASSERT_EQUAL_INT_MESSAGE(1, rig.machine.chip().resets(), "the board does not restart");
  TEST_ASSERT_TRUE(rig.machine.is_safe());
  // What the code bytes are as pointers depends on the build: they may be read from anywhere, and must write nowhere.
  for (const std::string& violation : rig.machine.chip().violations.list()) {
    TEST_ASSERT_EQUAL_STRING_LEN_MESSAGE("read at ", violation.c_str(), 8, violation.c_str());
  }
}

// --- program memory in operation ---

std::uint32_t image_bytes(BoardRig& rig) {
  constexpr std::uint32_t kImageBytesAt = 0x08000208;
  std::uint32_t bytes = 0;
  std::memcpy(&bytes, rig.machine.chip().core.memory_at(kImageBytesAt, 4), 4);
  return bytes;
}

// The last byte is an initial value that nobody reads any more, so only the check can detect it.
void test_a_bit_of_the_program_that_flips_stops_both_axes_within_two_rounds_of_its_check() {
  constexpr std::uint32_t kBytesPerTick = 32;
  constexpr int kMaxBraking_ms = 200;
  BoardRig rig(bench::tracker_plant());
  boot_and_turn(rig);
  const std::uint32_t bytes = image_bytes(rig);
  const auto round_ms = static_cast<int>(bytes / kBytesPerTick) + 2;
  turn(rig, round_ms);
  TEST_ASSERT_TRUE_MESSAGE(rig.client.is_enabled(0) && rig.client.is_enabled(1), "a whole image is called damaged");
  rig.client.forget();
  *rig.machine.chip().core.memory_at(0x08000000 + bytes - 1, 1) ^= 0x10;
  int passed_ms = 0;
  while (passed_ms < 2 * round_ms && !has_heard(rig, kImageDamaged, kImageDamagedFault)) {
    turn(rig, 1);
    ++passed_ms;
  }
  TEST_MESSAGE(fmt::format("{} bytes: a round takes {} ms; found after {} ms", bytes, round_ms, passed_ms).c_str());
  rig.client.pass(kMaxBraking_ms);
  TEST_ASSERT_TRUE_MESSAGE(has_heard(rig, kImageDamaged, kImageDamagedFault), "it is not reported");
  TEST_ASSERT_TRUE_MESSAGE(rig.machine.is_safe(), "a bridge is still on");
  TEST_ASSERT_FALSE_MESSAGE(rig.client.enable(kCyclicVelocity), "an axis works on a damaged program");
  TEST_ASSERT_EQUAL_INT(0, rig.machine.chip().resets());
  expect_no_violations(rig);
}

// --- stack ---

// The next interrupt finds no room for its frame, or for the first registers that it pushes.
void test_a_stack_that_overflows_is_safe_and_reported_after_the_reset() {
  constexpr std::uint32_t kStackLimit = kRamBegin;
  for (const std::uint32_t left : {0U, 16U, 40U}) {
    BoardRig rig(bench::tracker_plant());
    boot_and_turn(rig);
    rig.client.forget();
    rig.machine.chip().core.sink_stack_to(kStackLimit + left);
    expect_safe_reset(rig, 1, kStackOverflow, target::kMemManage << 4 | kStackOverflowCause);
    expect_no_violations(rig);
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_stuck_bit_of_ram_keeps_both_axes_from_being_ready);
  RUN_TEST(test_no_word_with_parity_is_read_before_it_was_written);
  RUN_TEST(test_gains_and_the_state_of_protection_lie_in_ram_with_parity);
  RUN_TEST(test_a_parity_error_switches_both_bridges_off_and_resets);
  RUN_TEST(test_a_parity_error_and_a_lock_up_are_connected_to_the_break_inputs);
  RUN_TEST(test_a_flipped_bit_of_the_hot_code_is_found_without_parity_as_well);
  RUN_TEST(test_a_store_to_the_hot_code_is_refused_and_ends_in_the_safe_state);
  RUN_TEST(test_a_bit_of_the_program_that_flips_stops_both_axes_within_two_rounds_of_its_check);
  RUN_TEST(test_a_stack_that_overflows_is_safe_and_reported_after_the_reset);
  return UNITY_END();
}
