// SPDX-License-Identifier: Apache-2.0
// The board's image while somebody floods its bus at 1 Mbit/s: neither the pre-tick nor the deferred task may become so
// long that a tick comes too late, because then both bridges are switched off while the axes turn (fault 28).
#include <map>
#include <string>
#include <vector>

#include "board_steps.hpp"

using bench::BoardRig;
using bench::boot;
using bench::expect_no_violations;
using bench::kSlow_urad_s;
namespace target = trackservo::target;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr double kCyclesPerMicrosecond = 170.0;
constexpr int kProfileVelocity = 3;

struct Setting {
  std::uint16_t index;
  std::uint8_t sub;
  std::uint32_t value;
  int bytes;
};

struct Frame {
  std::uint32_t identifier;
  std::vector<unsigned> bytes;
};

// Frames in turn, as many as the bus carries.
struct Flood {
  const char *name;
  std::vector<Frame> frames;
  std::vector<Setting> settings{};  // written before
  bool stops_axes = false;
};

// In bits, with the least stuffing.
int length_of(const Frame& frame) { return 47 + 8 * static_cast<int>(frame.bytes.size()); }

can_frame frame_of(const Frame& frame) {
  can_frame sent = {};
  sent.id = frame.identifier;
  sent.length = static_cast<std::uint8_t>(frame.bytes.size());
  for (std::size_t i = 0; i < frame.bytes.size(); ++i) {
    sent.data[i] = static_cast<std::uint8_t>(frame.bytes[i]);
  }
  return sent;
}

double worst_us(BoardRig& rig, int exception) {
  const auto& costs = rig.machine.chip().core.costs().finished();
  return static_cast<double>(target::summary_of(costs.at(exception)).worst.cycles) / kCyclesPerMicrosecond;
}

void check(const Flood& flood) {
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  for (const Setting& setting : flood.settings) {
    TEST_ASSERT_TRUE(rig.client.write(setting.index, setting.sub, setting.value, setting.bytes));
  }
  rig.client.start_node();
  TEST_ASSERT_TRUE(rig.client.enable(kProfileVelocity));
  rig.client.set_speeds(kSlow_urad_s, kSlow_urad_s);
  rig.client.pass(300);
  rig.machine.chip().core.costs().clear();
  std::size_t next = 0;
  for (int ms = 0; ms < 200; ++ms) {
    for (int bits = 0; bits < 1000; ++next) {
      const Frame& frame = flood.frames[next % flood.frames.size()];
      rig.client.send(frame_of(frame));
      bits += length_of(frame);
    }
    rig.client.pass(1);
  }
  const double pre_tick_us = worst_us(rig, target::kFirstInterrupt + target::kTim7Interrupt);
  const double service_us = worst_us(rig, target::kPendSv);
  TEST_MESSAGE(fmt::format("{}: pre-tick at most {:.0f} us, service {:.0f} us, {} resets", flood.name, pre_tick_us,
                           service_us, rig.machine.chip().resets())
                   .c_str());
  rig.client.set_speeds(kSlow_urad_s, kSlow_urad_s);  // or 3041 stops both for want of a master
  rig.client.pass(600);                               // what still waits on the bus and in the node
  TEST_ASSERT_EQUAL_INT_MESSAGE(0, rig.machine.chip().resets(), flood.name);
  TEST_ASSERT_TRUE_MESSAGE(flood.stops_axes || (rig.client.is_enabled(0) && rig.client.is_enabled(1)), flood.name);
  expect_no_violations(rig);
}

std::vector<Setting> with(std::vector<Setting> settings, const std::vector<Setting>& more) {
  settings.insert(settings.end(), more.begin(), more.end());
  return settings;
}

// Three commands for the azimuth, of which the later ones wait, and then the pitch's.
std::vector<Frame> backlog() {
  std::vector<Frame> frames = {{0x201, {0x0F, 0, 3}}, {0x201, {0x1F, 0, 3}}, {0x201, {0x0F, 0, 3}}};
  frames.insert(frames.end(), 60, {0x301, {0x0F, 0, 99}});
  return frames;
}

std::vector<Setting> eight_synchronous_tpdos() {
  std::vector<Setting> settings;
  for (std::uint16_t n = 0; n < 8; ++n) {
    const auto object = static_cast<std::uint16_t>(0x1800 + n);
    const std::uint32_t identifier = n < 4 ? 0x181U + 0x100U * n : 0x681U + n;
    settings.push_back({object, 1, 0xC0000000U | identifier, 4});
    settings.push_back({object, 2, 1, 1});
    settings.push_back({object, 1, 0x40000000U | identifier, 4});
  }
  return settings;
}

void test_no_flood_makes_a_tick_late() {
  const Frame apply{0x601, {0x2F, 0x70, 0x20, 1, 1, 0, 0, 0}};
  const Frame apply_to_pitch{0x6A0, {0x2F, 0x70, 0x28, 1, 1, 0, 0, 0}};  // in the second client's channel
  const std::vector<Setting> gains = {{0x2000, 1, bench::bits_of(630.0F), 4},
                                      {0x2800, 1, bench::bits_of(330.0F), 4},
                                      {0x1201, 1, 0x6A0, 4},
                                      {0x1201, 2, 0x6A1, 4}};
  const std::vector<Setting> long_sweep = {
      {0x2100, 4, 1, 1}, {0x2100, 5, 1000, 4}, {0x2100, 8, bench::bits_of(1.0000001F), 4}};
  const std::vector<Flood> floods = {
      {"RPDO that are too short", {{0x201, {}}}},
      {"RPDO with a value out of range",
       {{0x301, {0x0F, 0, 99, 0, 0, 0, 0, 0}}, {0x301, {0x0F, 0, 98, 0, 0, 0, 0, 0}}}},
      {"RPDO with another command each time", {{0x201, {0x0F, 0, 3}}, {0x201, {0x1F, 0, 3}}}},
      {"commands that wait, then values out of range", backlog()},
      {"SYNC", {{0x080, {}}}},
      {"SYNC, answered by eight TPDOs", {{0x080, {}}}, eight_synchronous_tpdos()},
      {"camera frames of one byte",
       {{0x501, {1}}, {0x501, {2}}},
       {{0x1403, 1, 0x80000501, 4},
        {0x1603, 0, 0, 1},
        {0x1603, 1, 0x30700508, 4},
        {0x1603, 0, 1, 1},
        {0x1403, 2, 255, 1},
        {0x1403, 1, 0x501, 4}}},
      {"SDO, reading what is computed", {{0x601, {0x40, 0x00, 0x21, 18, 0, 0, 0, 0}}}, long_sweep},
      {"SDO, reading what is compared", {{0x601, {0x40, 0x70, 0x20, 2, 0, 0, 0, 0}}}},
      {"SDO, applying gains of both axes", {apply, apply_to_pitch}, gains},
      {"SDO, applying gains of one axis while a TPDO is mapped",
       {apply_to_pitch, {0x601, {0x2F, 0x00, 0x1A, 0, 8, 0, 0, 0}}},
       with(gains, {{0x1800, 1, 0xC0000181, 4}})},
      {"SDO, applying gains of one axis while defaults are asked for",
       {apply_to_pitch, {0x601, {0x23, 0x11, 0x10, 1, 0x6C, 0x6F, 0x61, 0x64}}},
       gains},
      {"SDO, gains that are refused", {apply}, {{0x2030, 8, bench::bits_of(1e-6F), 4}}},
      {"SDO, storing", {{0x601, {0x23, 0x10, 0x10, 1, 0x73, 0x61, 0x76, 0x65}}}},
      {"LSS", {{0x7E5, {0x5A, 0, 0, 0, 0, 0, 0, 0}}}},
      {"NMT", {{0x000, {128, 1}}, {0x000, {1, 1}}}, {}, true},
  };
  for (const Flood& flood : floods) {
    check(flood);
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_no_flood_makes_a_tick_late);
  return UNITY_END();
}
