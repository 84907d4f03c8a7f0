// SPDX-License-Identifier: Apache-2.0
// More frames in a tick than the CAN controller has transmit buffers for: all of them are sent.
#include <array>
#include <cstring>

#include "board_steps.hpp"

namespace sim = trackservo::sim;
namespace target = trackservo::target;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr std::uint32_t kPdos = 4;
constexpr std::uint16_t kTpdo1 = 0x1800;
constexpr std::uint32_t kOff = 0x80000000U;
constexpr std::uint32_t kTpdo1Identifier = 0x181;
constexpr std::uint16_t kTpdo5 = 0x1804;
constexpr std::array<std::uint32_t, kPdos> kFurtherIdentifiers = {0x680, 0x68C, 0x698, 0x6A4};

class SendingBoard {
 public:
  // A frame of each TPDO in every tick.
  void send_all_tpdos_each_tick() {
    for (std::uint16_t n = 0; n < kPdos; ++n) {
      const std::uint16_t index = kTpdo1 + n;
      const std::uint32_t identifier = kTpdo1Identifier + 0x100U * n;
      TEST_ASSERT_TRUE(client.write(index, 1, identifier | kOff, 4));
      TEST_ASSERT_TRUE(client.write(index, 3, 0, 2));
      TEST_ASSERT_TRUE(client.write(index, 5, 1, 2));
      TEST_ASSERT_TRUE(client.write(index, 1, identifier, 4));
    }
    client.start_node();
    client.pass(10);
    tpdos_ = {};
  }

  // TPDO5 to TPDO8: the tick counter and an angle, in every tick.
  void stream() {
    for (std::uint16_t n = 0; n < kPdos; ++n) {
      const std::uint16_t index = kTpdo5 + n;
      const std::uint16_t mapping = index + 0x200;
      TEST_ASSERT_TRUE(client.write(mapping, 1, 0x30100120, 4));
      TEST_ASSERT_TRUE(client.write(mapping, 2, 0x60640020, 4));
      TEST_ASSERT_TRUE(client.write(mapping, 0, 2, 1));
      TEST_ASSERT_TRUE(client.write(index, 3, 0, 2));
      TEST_ASSERT_TRUE(client.write(index, 5, 1, 2));
      TEST_ASSERT_TRUE(client.write(index, 1, kFurtherIdentifiers.at(n), 4));
    }
    client.start_node();
    client.pass(10);
    tpdos_ = further_ = missed_ = {};
  }

  int tpdos(std::size_t n) const { return tpdos_.at(n); }
  int further(std::size_t n) const { return further_.at(n); }
  int missed(std::size_t n) const { return missed_.at(n); }

 private:
  void count(const can_frame& frame) {
    for (std::size_t n = 0; n < kPdos; ++n) {
      tpdos_[n] += frame.id == kTpdo1Identifier + 0x100U * n ? 1 : 0;
      if (frame.id == kFurtherIdentifiers[n]) {
        std::uint32_t tick = 0;
        std::memcpy(&tick, frame.data, sizeof tick);
        missed_[n] += tick == last_[n] + 1 ? 0 : 1;
        last_[n] = tick;
        ++further_[n];
      }
    }
  }

  sim::VirtualBus bus_{1e6, sim::kPwmPeriod_s};
  std::array<int, kPdos> tpdos_{};
  std::array<int, kPdos> further_{};
  std::array<int, kPdos> missed_{};
  std::array<std::uint32_t, kPdos> last_{};
  sim::VirtualBus::Port listener_ = bus_.attach([this](const can_frame& frame) { count(frame); });

 public:
  target::BoardMachine machine{bench::board_image(), bench::tracker_plant(), bus_, {1, bench::kStart_rad}};
  bench::CanClient client{bus_, [this] { machine.run(sim::kTick_s); }};
};

void test_heartbeat_and_sdo_get_through_beside_four_tpdos_in_every_tick() {
  SendingBoard board;
  board.client.pass(bench::kBoot_ms);
  board.send_all_tpdos_each_tick();
  board.client.forget();
  const double start_s = board.machine.time_s();
  constexpr int kReads = 100;
  for (int i = 0; i < kReads; ++i) {
    TEST_ASSERT_TRUE_MESSAGE(board.client.read(0x1000).has_value(), "no SDO answer");
    board.client.pass(5);
  }
  const double passed_ms = 1e3 * (board.machine.time_s() - start_s);
  TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1.0, passed_ms / 100.0, board.client.heartbeats(), "heartbeats");
  for (std::size_t n = 0; n < kPdos; ++n) {
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2.0, passed_ms, board.tpdos(n), "TPDOs");
  }
  TEST_ASSERT_EQUAL_UINT(0, board.machine.chip().violations.list().size());
}

// TPDO1 to TPDO4 as delivered: all four come in the same tick ten times a second. SDO reads and heartbeats go on.
void test_no_sample_of_tpdo5_to_8_is_lost_beside_the_default_tpdos() {
  SendingBoard board;
  board.client.pass(bench::kBoot_ms);
  board.stream();
  board.client.forget();
  const double start_s = board.machine.time_s();
  constexpr int kReads = 200;
  for (int i = 0; i < kReads; ++i) {
    TEST_ASSERT_TRUE_MESSAGE(board.client.read(0x1000).has_value(), "no SDO answer");
    board.client.pass(4);
  }
  const double passed_ms = 1e3 * (board.machine.time_s() - start_s);
  TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1.0, passed_ms / 100.0, board.client.heartbeats(), "heartbeats");
  for (std::size_t n = 0; n < kPdos; ++n) {
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, board.missed(n), "missed ticks");
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1.0, passed_ms, board.further(n), "TPDO5 to TPDO8");
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(2.0, passed_ms / (n < 2 ? 100.0 : 20.0), board.tpdos(n), "TPDO1 to TPDO4");
  }
  TEST_ASSERT_EQUAL_UINT(0, board.machine.chip().violations.list().size());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_heartbeat_and_sdo_get_through_beside_four_tpdos_in_every_tick);
  RUN_TEST(test_no_sample_of_tpdo5_to_8_is_lost_beside_the_default_tpdos);
  return UNITY_END();
}
