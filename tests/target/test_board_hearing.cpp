// SPDX-License-Identifier: Apache-2.0
// The frames that the board's CAN controller accepts, compared with the simulator's node: an RPDO and a SYNC at each
// kind of identifier, set and sent only over CAN.
#include <optional>

#include "rig.hpp"
#include "unity.h"

using bench::BoardRig;
using bench::HostRig;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr std::uint16_t kSyncCobId = 0x1005;
constexpr std::uint16_t kRpdo3 = 0x1402;  // target velocities of both axes
constexpr std::uint16_t kTargetVelocity = 0x60FF;
constexpr std::uint32_t kOff = 0x80000000;
constexpr std::uint32_t kDefaultSync = 0x080;
constexpr std::uint32_t kDefaultRpdo3 = 0x401;
constexpr int kBoot_ms = 320;

// Both ends of each range of the predefined connection set, and of the ranges that CiA 301 reserves between them.
constexpr std::uint32_t kIdentifiers[] = {0x000, 0x001, 0x07F, 0x080, 0x082, 0x0FF, 0x100, 0x101, 0x180, 0x182,
                                          0x1FF, 0x200, 0x280, 0x300, 0x4FF, 0x500, 0x57F, 0x580, 0x581, 0x5FF,
                                          0x600, 0x601, 0x602, 0x67F, 0x680, 0x683, 0x6DF, 0x6E0, 0x6FF, 0x700,
                                          0x701, 0x702, 0x77F, 0x780, 0x7E4, 0x7E5, 0x7FF};

bool is_restricted(std::uint32_t id) {
  return id <= 0x07F || (id >= 0x101 && id <= 0x180) || (id >= 0x581 && id <= 0x5FF) || (id >= 0x601 && id <= 0x67F) ||
         (id >= 0x6E0 && id <= 0x6FF) || id >= 0x701;
}

can_frame frame_of(std::uint32_t identifier) {
  can_frame frame{};
  frame.id = identifier;
  return frame;
}

enum class Answer { kRefused, kDeaf, kHeard };

const char *name(Answer answer) {
  return answer == Answer::kRefused ? "refused" : answer == Answer::kDeaf ? "taken, but not heard" : "heard";
}

template <typename Rig>
class Listener {
 public:
  Listener() {
    rig_.client.pass(kBoot_ms);
    rig_.client.start_node();
    rig_.client.pass(2);
  }

  Answer try_pdo(std::uint32_t identifier) {
    must_write(kRpdo3, 1, kOff, 4);
    must_write(kSyncCobId, 0, kDefaultSync, 4);
    must_write(kRpdo3, 2, 255, 1);
    if (!rig_.client.write(kRpdo3, 1, identifier, 4)) {
      return Answer::kRefused;
    }
    return has_come(send_pdo(identifier)) ? Answer::kHeard : Answer::kDeaf;
  }

  // A synchronous RPDO takes effect when the SYNC comes.
  Answer try_sync(std::uint32_t identifier) {
    must_write(kRpdo3, 1, kOff, 4);
    must_write(kSyncCobId, 0, kDefaultSync, 4);
    must_write(kRpdo3, 2, 0, 1);
    must_write(kRpdo3, 1, kDefaultRpdo3, 4);
    if (!rig_.client.write(kSyncCobId, 0, identifier, 4)) {
      return Answer::kRefused;
    }
    const std::uint32_t value = send_pdo(kDefaultRpdo3);
    TEST_ASSERT_FALSE_MESSAGE(has_come(value), "a synchronous RPDO counts without a SYNC");
    rig_.client.send(frame_of(identifier));
    return has_come(value) ? Answer::kHeard : Answer::kDeaf;
  }

 private:
  void must_write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes) {
    TEST_ASSERT_TRUE(rig_.client.write(index, sub, value, bytes));
  }

  std::uint32_t send_pdo(std::uint32_t identifier) {
    can_frame frame = frame_of(identifier);
    frame.length = 8;
    frame.data[0] = frame.data[4] = ++last_value_;
    rig_.client.send(frame);
    return last_value_;
  }

  bool has_come(std::uint32_t value) {
    rig_.client.pass(3);
    return rig_.client.read(kTargetVelocity).value() == value;
  }

  Rig rig_{bench::tracker_plant()};
  std::uint8_t last_value_ = 0;
};

void expect(const char *kind, std::uint32_t identifier, Answer expected, Answer board, Answer simulator) {
  const std::string text =
      fmt::format("{} at {:03X}: board {}, simulator {}", kind, identifier, name(board), name(simulator));
  TEST_ASSERT_TRUE_MESSAGE(board == expected && simulator == expected, text.c_str());
}

void test_board_and_simulator_hear_the_same_pdos_and_syncs() {
  Listener<BoardRig> board;
  Listener<HostRig> simulator;
  for (const std::uint32_t identifier : kIdentifiers) {
    const Answer free = is_restricted(identifier) ? Answer::kRefused : Answer::kHeard;
    expect("PDO", identifier, identifier == kDefaultSync ? Answer::kRefused : free, board.try_pdo(identifier),
           simulator.try_pdo(identifier));
    expect("SYNC", identifier, free, board.try_sync(identifier), simulator.try_sync(identifier));
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_board_and_simulator_hear_the_same_pdos_and_syncs);
  return UNITY_END();
}
