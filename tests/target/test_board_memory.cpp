// The board's image on an emulated chip with memory faults: RAM at the start, the program memory in operation, the
// stack that is too small.
#include <cstring>

#include "board_steps.hpp"

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
constexpr std::uint32_t kRamEnd = 0x20018000;

// --- RAM at the start ---

void expect_not_ready(BoardRig& rig) {
  constexpr std::uint32_t kStateBits = 0x4F;
  TEST_ASSERT_EQUAL_HEX32(0, rig.client.read(0x6041).value() & kStateBits);
  TEST_ASSERT_FALSE_MESSAGE(rig.client.enable(kCyclicVelocity), "an axis works on damaged RAM");
  TEST_ASSERT_TRUE(rig.machine.is_safe());
}

// Where the stack never extends, in the middle of the variables (the scope's record), and in unused RAM.
void test_a_stuck_bit_of_ram_keeps_both_axes_from_being_ready() {
  for (const std::uint32_t address : {kRamBegin, kRamBegin + 0xA000, kRamEnd - 4}) {
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
  RUN_TEST(test_a_bit_of_the_program_that_flips_stops_both_axes_within_two_rounds_of_its_check);
  RUN_TEST(test_a_stack_that_overflows_is_safe_and_reported_after_the_reset);
  return UNITY_END();
}
