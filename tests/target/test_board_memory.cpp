// The board's image on an emulated chip whose memory fails: RAM that is found at the start.
#include "board_steps.hpp"

namespace target = trackservo::target;

void setUp(void) {}
void tearDown(void) {}

namespace {

using namespace bench;

constexpr std::uint16_t kSelfTest = 0x5000;
constexpr std::uint8_t kRam = 0x00;

constexpr std::uint32_t kRamBegin = 0x20000000;
constexpr std::uint32_t kRamEnd = 0x20018000;

// --- RAM at the start ---

void expect_not_ready(BoardRig& rig) {
  constexpr std::uint32_t kStateBits = 0x4F;
  TEST_ASSERT_EQUAL_HEX32(0, rig.client.read(0x6041).value() & kStateBits);
  TEST_ASSERT_FALSE_MESSAGE(rig.client.enable(kCyclicVelocity), "an axis works on damaged RAM");
  TEST_ASSERT_TRUE(rig.machine.is_safe());
}

// Where the stack never gets to, in the middle of the variables (the scope's record), and where nothing lies.
void test_a_stuck_bit_of_ram_keeps_both_axes_from_being_ready() {
  for (const std::uint32_t address : {kRamBegin, kRamBegin + 0xA000, kRamEnd - 4}) {
    for (const bool value : {false, true}) {
      BoardRig rig(bench::tracker_plant());
      rig.machine.chip().core.stick(address, 17, value);
      boot(rig);
      TEST_MESSAGE(fmt::format("bit 17 of 0x{:08x} stuck at {}", address, value ? 1 : 0).c_str());
      TEST_ASSERT_TRUE_MESSAGE(has_heard(rig, kSelfTest, kRam), "it is not told");
      expect_not_ready(rig);
      expect_no_complaints(rig);
    }
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_stuck_bit_of_ram_keeps_both_axes_from_being_ready);
  return UNITY_END();
}
