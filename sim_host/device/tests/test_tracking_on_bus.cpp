// SPDX-License-Identifier: Apache-2.0
// What is read from TPDO1 and TPDO2 as delivered, and that frames with another mapping are not read.
#include "device/tracking_on_bus.hpp"

#include <initializer_list>

extern "C" {
#include "drive/drive_axis.h"
}
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace trackservo::sim;

constexpr std::uint32_t kNode = 1;
constexpr std::uint32_t kTpdo1 = 0x180 + kNode;
constexpr std::uint32_t kTpdo2 = 0x280 + kNode;

class Node {
 public:
  void send(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
    can_frame frame{};
    frame.id = id;
    for (const std::uint8_t byte : bytes) {
      frame.data[frame.length++] = byte;
    }
    TEST_ASSERT_TRUE(bus_.send(port_, frame));
    bus_.advance(1e-3);
  }

  void check(int azimuth, int pitch) const {
    TEST_ASSERT_EQUAL(azimuth, tracking_.states()[0]);
    TEST_ASSERT_EQUAL(pitch, tracking_.states()[1]);
  }

 private:
  VirtualBus bus_;
  VirtualBus::Port port_ = bus_.attach([](const can_frame&) {});
  TrackingOnBus tracking_{bus_};
};

// Statusword, mode, error code and torque: operation enabled in mode -1, with and without bit 10; in mode 8.
void test_the_states_of_both_axes_are_read_from_the_mapping_as_delivered() {
  Node node;
  node.send(kTpdo1, {0x27, 0x02, 0xFF, 0, 0, 0, 0});
  node.check(DRIVE_SEARCHING, DRIVE_NOT_TRACKING);
  node.send(kTpdo2, {0x27, 0x02, 0xFF, 0, 0, 0, 0});
  node.check(DRIVE_SEARCHING, DRIVE_SEARCHING);
  node.send(kTpdo1, {0x27, 0x06, 0xFF, 0, 0, 0, 0});
  node.check(DRIVE_ON_TARGET, DRIVE_SEARCHING);
  node.send(kTpdo1, {0x27, 0x06, 8, 0, 0, 0, 0});
  node.check(DRIVE_NOT_TRACKING, DRIVE_SEARCHING);
}

// docs/ros2/bus.yml: TPDO2 has velocity and torque of azimuth, in 6 bytes. Here they look as a state on target.
void test_frames_with_another_mapping_are_no_state() {
  for (const std::uint32_t id : {kTpdo1, kTpdo2}) {
    Node node;
    node.send(id, {0x27, 0x04, 0xFF, 0xFF, 0, 0});
    node.send(id, {0x27, 0x04, 0xFF});
    node.send(id, {0x27, 0x04, 0xFF, 0, 0, 0, 0, 0});
    node.send(id, {0x27, 0x04});
    node.send(id, {});
    node.check(DRIVE_NOT_TRACKING, DRIVE_NOT_TRACKING);
  }
}

void test_a_change_of_the_mapping_ends_what_was_known() {
  Node node;
  node.send(kTpdo2, {0x27, 0x04, 0xFF, 0, 0, 0, 0});
  node.check(DRIVE_NOT_TRACKING, DRIVE_ON_TARGET);
  node.send(kTpdo2, {0x27, 0x04, 0xFF, 0, 0, 0});
  node.check(DRIVE_NOT_TRACKING, DRIVE_NOT_TRACKING);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_states_of_both_axes_are_read_from_the_mapping_as_delivered);
  RUN_TEST(test_frames_with_another_mapping_are_no_state);
  RUN_TEST(test_a_change_of_the_mapping_ends_what_was_known);
  return UNITY_END();
}
