// SPDX-License-Identifier: Apache-2.0
// Node id and bit rate of the board's image: found by fastscan, set by LSS, persisted over a loss of power, recovered
// with the button; and the behaviour of a slow bus. All times are those of the emulated chip.
#include "board_steps.hpp"
#include "device/bus/can_bit_time.hpp"

using bench::BoardRig;
using bench::boot;
using bench::expect_no_violations;
using bench::kBoot_ms;
using bench::kCyclicVelocity;
using bench::kSlow_urad_s;
namespace target = trackservo::target;
namespace sim = trackservo::sim;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr std::uint32_t kLssRequest = 0x7E5;
constexpr std::uint32_t kLssAnswer = 0x7E4;
constexpr std::uint8_t kUnconfigured = 255;
constexpr std::uint8_t kSwitchGlobal = 0x04;
constexpr std::uint8_t kConfigureNodeId = 0x11;
constexpr std::uint8_t kConfigureBitRate = 0x13;
constexpr std::uint8_t kActivateBitRate = 0x15;
constexpr std::uint8_t kStore = 0x17;
constexpr std::uint8_t kFastscan = 0x51;
constexpr int kAnswer_ms = 5;
constexpr int kMasterWaits_ms = 20;   // python-canopen's RESPONSE_TIMEOUT in the test of the node
constexpr int kMasterSleeps_ms = 10;  // after each of its requests

// A master on its own port, which also counts all frames.
class LssMaster {
 public:
  explicit LssMaster(BoardRig& rig)
      : rig_(rig), port_(rig.bus.attach([this](const can_frame& frame) { receive(frame); })) {}
  ~LssMaster() { rig_.bus.detach(port_); }
  LssMaster(const LssMaster&) = delete;
  LssMaster& operator=(const LssMaster&) = delete;

  void set_bit_rate(double bits_per_s) {
    rig_.bus.set_bit_rate(port_, bits_per_s);
    rig_.client.set_bit_rate(bits_per_s);
  }

  void send(std::uint32_t identifier, const std::vector<std::uint8_t>& bytes) {
    can_frame frame{};
    frame.id = identifier;
    frame.length = static_cast<std::uint8_t>(bytes.size());
    std::copy(bytes.begin(), bytes.end(), frame.data);
    rig_.bus.send(port_, frame);
  }

  // The answer, within 5 ms.
  std::optional<can_frame> ask(std::vector<std::uint8_t> request) {
    request.resize(8);
    answer_.reset();
    send(kLssRequest, request);
    for (int ms = 0; ms < kAnswer_ms && !answer_; ++ms) {
      rig_.client.pass(1);
      ++passed_ms_;
      slowest_ms_ = answer_ ? std::max(slowest_ms_, ms + 1) : slowest_ms_;
    }
    return answer_;
  }

  void expect(const std::vector<std::uint8_t>& request, int error) {
    const std::optional<can_frame> answer = ask(request);
    TEST_ASSERT_TRUE_MESSAGE(answer.has_value(), "no answer within 5 ms");
    TEST_ASSERT_EQUAL_HEX8(request[0], answer->data[0]);
    TEST_ASSERT_EQUAL(error, answer->data[1]);
  }

  void switch_to(std::uint8_t state) { TEST_ASSERT_FALSE(ask({kSwitchGlobal, state}).has_value()); }

  // At the pace of python-canopen. The serial number; nothing: no node answered.
  std::optional<std::uint32_t> fastscan() {
    std::array<std::uint32_t, 4> numbers{};
    if (!scan(0, 0x80, 0, 0)) {
      return std::nullopt;
    }
    for (std::uint8_t part = 0; part < 4; ++part) {
      for (int bit = 31; bit >= 0; --bit) {
        numbers[part] |= scan(numbers[part], static_cast<std::uint8_t>(bit), part, part) ? 0U : 1U << bit;
      }
      TEST_ASSERT_TRUE(scan(numbers[part], 0, part, static_cast<std::uint8_t>((part + 1) % 4)));
    }
    return numbers[3];
  }

  double scanned_s() const { return 1e-3 * passed_ms_; }
  int slowest_ms() const { return slowest_ms_; }

  // Bits of the received TPDOs, and number of frames of an identifier.
  std::uint64_t tpdo_bits() const { return tpdo_bits_; }
  int heard(std::uint32_t identifier) { return heard_[identifier]; }
  void forget() {
    heard_.clear();
    tpdo_bits_ = 0;
  }

 private:
  bool scan(std::uint32_t number, std::uint8_t bit, std::uint8_t part, std::uint8_t next) {
    const int begin_ms = passed_ms_;
    const bool answered =
        ask({kFastscan, static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8),
             static_cast<std::uint8_t>(number >> 16), static_cast<std::uint8_t>(number >> 24), bit, part, next})
            .has_value();
    const int rest_ms = (answered ? 0 : kMasterWaits_ms - (passed_ms_ - begin_ms)) + kMasterSleeps_ms;
    rig_.client.pass(rest_ms);
    passed_ms_ += rest_ms;
    return answered;
  }

  void receive(const can_frame& frame) {
    ++heard_[frame.id];
    if (frame.id == kLssAnswer) {
      answer_ = frame;
    }
    const bool is_tpdo = frame.id >= 0x180 && frame.id < 0x500 && (frame.id >> 7) % 2 == 1;
    if (is_tpdo) {
      tpdo_bits_ += static_cast<std::uint64_t>(sim::can_frame_bits(frame));
    }
  }

  BoardRig& rig_;
  sim::VirtualBus::Port port_;
  std::optional<can_frame> answer_;
  std::map<std::uint32_t, int> heard_;
  std::uint64_t tpdo_bits_ = 0;
  int passed_ms_ = 0;
  int slowest_ms_ = 0;
};

struct Rate {
  std::uint8_t index;
  double bits_per_s;
};
constexpr Rate kRates[] = {{0, 1e6}, {2, 500e3}, {3, 250e3}, {4, 125e3}};

void power_cycle(BoardRig& rig) {
  rig.client.forget();
  rig.machine.chip().request_reset(target::ResetCause::kPowerOn);
  rig.client.pass(kBoot_ms);
}

void store(LssMaster& master, std::uint8_t node_id, std::uint8_t rate_index) {
  master.switch_to(1);
  master.expect({kConfigureNodeId, node_id}, 0);
  master.expect({kConfigureBitRate, 0, rate_index}, 0);
  master.expect({kStore}, 0);
  master.switch_to(0);
}

void test_a_board_without_node_id_is_found_by_fastscan_and_numbered() {
  constexpr std::uint8_t kNodeId = 42;
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  const std::uint32_t serial = rig.client.read(0x1018, 4).value();
  LssMaster master(rig);
  store(master, kUnconfigured, 0);
  power_cycle(rig);
  master.forget();
  rig.client.pass(500);
  TEST_ASSERT_EQUAL(0, master.heard(0x701));
  const double begin_s = master.scanned_s();
  const std::optional<std::uint32_t> found = master.fastscan();
  const double scan_s = master.scanned_s() - begin_s;
  TEST_ASSERT_TRUE(found.has_value());
  TEST_ASSERT_EQUAL_HEX32(serial, *found);
  master.expect({kConfigureNodeId, kNodeId}, 0);
  master.expect({kStore}, 0);
  TEST_MESSAGE(fmt::format("fastscan of the board took {:.2f} s, its slowest answer {} ms", scan_s, master.slowest_ms())
                   .c_str());
  TEST_ASSERT_TRUE(scan_s < 5.0);
  master.switch_to(0);
  rig.client.pass(120);
  TEST_ASSERT_GREATER_OR_EQUAL(1, master.heard(0x700 + kNodeId));
  power_cycle(rig);
  rig.client.set_node(kNodeId);
  TEST_ASSERT_EQUAL_HEX32(serial, rig.client.read(0x1018, 4).value());
  TEST_ASSERT_EQUAL(kNodeId, rig.client.read(0x3050, 1).value());
  expect_no_violations(rig);
}

void test_each_bit_rate_is_stored_and_no_other_is_understood() {
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  LssMaster master(rig);
  for (const Rate& rate : kRates) {
    store(master, 1, rate.index);
    power_cycle(rig);
    for (const Rate& other : kRates) {
      const bool same = other.index == rate.index;
      master.set_bit_rate(other.bits_per_s);
      rig.client.forget();
      rig.client.pass(250);
      TEST_ASSERT_EQUAL(same, rig.client.heartbeats() > 0);
      TEST_ASSERT_EQUAL(same, rig.client.read(0x1000).has_value());
    }
    master.set_bit_rate(rate.bits_per_s);
  }
  expect_no_violations(rig);
}

void test_the_bit_rate_changes_when_it_is_activated() {
  constexpr std::uint8_t kDelay_ms = 100;
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  LssMaster master(rig);
  master.switch_to(1);
  master.expect({kConfigureBitRate, 0, 4}, 0);
  TEST_ASSERT_FALSE(master.ask({kActivateBitRate, kDelay_ms, 0}).has_value());
  master.set_bit_rate(125e3);
  master.forget();
  rig.client.pass(2 * kDelay_ms - 10);
  TEST_ASSERT_EQUAL_MESSAGE(0, master.heard(0x701), "not silent");
  rig.client.pass(130);
  TEST_ASSERT_GREATER_OR_EQUAL(1, master.heard(0x701));
  TEST_ASSERT_EQUAL(125, rig.client.read(0x3050, 2).value());
  TEST_ASSERT_EQUAL(1000, rig.client.read(0x3050, 4).value());
  TEST_ASSERT_EQUAL(160, rig.client.read(0x1800, 3).value() & 0xFFFFU);
  power_cycle(rig);  // it was not stored
  master.set_bit_rate(1e6);
  TEST_ASSERT_TRUE(rig.client.read(0x1000).has_value());
  expect_no_violations(rig);
}

// Power on with the button held then, and when its RAM is tested and its pins have been read once.
void start_with_button(BoardRig& rig, bool held_at_start, bool held_later) {
  auto& port = rig.machine.chip().port('C');
  port.set_input(13, held_at_start);
  rig.client.forget();
  rig.machine.chip().request_reset(target::ResetCause::kPowerOn);
  rig.client.pass(130);
  port.set_input(13, held_later);
  rig.client.pass(kBoot_ms);
  port.set_input(13, false);
}

void test_the_button_recovers_a_wrong_stored_bit_rate() {
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  LssMaster master(rig);
  store(master, 42, 4);
  master.set_bit_rate(1e6);
  const auto is_heard = [&rig](bool held_at_start, bool held_later) {
    start_with_button(rig, held_at_start, held_later);
    return rig.client.boots() == 1 && rig.client.read(0x1000).has_value();
  };
  TEST_ASSERT_FALSE(is_heard(false, false));
  TEST_ASSERT_FALSE_MESSAGE(is_heard(true, false), "a pulse is not a held button");
  TEST_ASSERT_FALSE(is_heard(false, true));
  TEST_ASSERT_TRUE(is_heard(true, true));
  TEST_ASSERT_EQUAL(42, rig.client.read(0x3050, 3).value());
  TEST_ASSERT_EQUAL(125, rig.client.read(0x3050, 4).value());
  master.switch_to(1);
  master.expect({kStore}, 0);  // node id 1 and 1 Mbit/s, as in effect
  TEST_ASSERT_TRUE(is_heard(false, false));
  expect_no_violations(rig);
}

// 8 bytes, in two segments.
bool set_word(BoardRig& rig, LssMaster& master, const std::string& word) {
  std::vector<std::uint8_t> bytes(word.begin(), word.end());
  bytes.resize(8);
  master.send(0x601, {0x21, 0x40, 0x30, 4, 8, 0, 0, 0});
  rig.client.pass(2);
  master.send(0x601, {0x00, bytes[0], bytes[1], bytes[2], bytes[3], bytes[4], bytes[5], bytes[6]});
  rig.client.pass(2);
  master.send(0x601, {0x1D, bytes[7], 0, 0, 0, 0, 0, 0});
  rig.client.pass(100);  // until it is in flash
  return rig.client.read(0x3040, 5).value() == (word.empty() ? 0U : 1U);
}

void test_the_button_recovers_a_lost_word_of_the_owner() {
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  LssMaster master(rig);
  const auto opens = [&rig] { return rig.client.write(0x3040, 1, 0x6E65706F, 4); };
  TEST_ASSERT_TRUE(opens());
  TEST_ASSERT_TRUE(set_word(rig, master, "falcon77"));
  start_with_button(rig, false, false);
  TEST_ASSERT_FALSE_MESSAGE(opens(), "the word survives a power cycle");
  start_with_button(rig, true, false);
  TEST_ASSERT_FALSE_MESSAGE(opens(), "a pulse is not a held button");
  start_with_button(rig, true, true);
  TEST_ASSERT_TRUE(opens());
  start_with_button(rig, false, false);
  TEST_ASSERT_FALSE_MESSAGE(opens(), "only until the next start");
  start_with_button(rig, true, true);
  TEST_ASSERT_TRUE(opens());
  TEST_ASSERT_TRUE(set_word(rig, master, ""));
  start_with_button(rig, false, false);
  TEST_ASSERT_TRUE_MESSAGE(opens(), "the word is removed");
  expect_no_violations(rig);
}

// Both axes turn with new set-points, and all four TPDOs are sent as often as their inhibit times allow.
void test_sdo_answers_in_time_on_a_slow_bus_while_both_axes_move() {
  constexpr int kMax_ms = 50;
  constexpr int kSetPoint_ms = 10;
  for (const Rate& rate : kRates) {
    BoardRig rig(bench::tracker_plant());
    boot(rig);
    LssMaster master(rig);
    store(master, 1, rate.index);
    power_cycle(rig);
    master.set_bit_rate(rate.bits_per_s);
    const std::uint32_t inhibit_100us = rig.client.read(0x1800, 3).value() & 0xFFFFU;
    for (int n = 0; n < 4; ++n) {  // an event every ms
      TEST_ASSERT_TRUE(rig.client.write(static_cast<std::uint16_t>(0x1800 + n), 5, 1, 2));
    }
    rig.client.start_node();
    TEST_ASSERT_TRUE(rig.client.enable(kCyclicVelocity));
    for (const std::uint16_t index : {std::uint16_t{0x60C2}, std::uint16_t{0x68C2}}) {
      TEST_ASSERT_TRUE(rig.client.write(index, 1, kSetPoint_ms, 1));
    }
    master.forget();
    int slowest_ms = 0;
    int passed_ms = 0;
    for (int n = 0; n < 100; ++n) {
      rig.client.set_speeds(kSlow_urad_s, kSlow_urad_s);
      const int answer_ms = rig.client.read_within(0x606C, kMax_ms);
      TEST_ASSERT_TRUE_MESSAGE(answer_ms >= 0, "SDO does not answer within 50 ms");
      const int rest_ms = std::max(0, kSetPoint_ms - answer_ms);
      rig.client.pass(rest_ms);
      slowest_ms = std::max(slowest_ms, answer_ms);
      passed_ms += answer_ms + rest_ms;
    }
    const double share = static_cast<double>(master.tpdo_bits()) / (1e-3 * passed_ms * rate.bits_per_s);
    TEST_MESSAGE(fmt::format("{:4.0f} kbit/s: inhibit time {:.1f} ms, TPDOs take {:.1f} % of the bus, the slowest SDO "
                             "answer {} ms",
                             1e-3 * rate.bits_per_s, 0.1 * inhibit_100us, 100.0 * share, slowest_ms)
                     .c_str());
    TEST_ASSERT_TRUE_MESSAGE(share > 0.1, "the TPDOs do not go out");
    TEST_ASSERT_TRUE(share <= 0.5);
    TEST_ASSERT_TRUE(rig.client.is_enabled(0) && rig.client.is_enabled(1));
    TEST_ASSERT_DOUBLE_WITHIN(0.2 * kSlow_urad_s, kSlow_urad_s, 1e6 * rig.truth().inertial_rate_rad_s[0]);
    expect_no_violations(rig);
  }
}

void test_a_loss_of_power_while_lss_stores_leaves_the_old_settings_or_the_new_ones() {
  BoardRig rig(bench::tracker_plant());
  boot(rig);
  LssMaster master(rig);
  store(master, 7, 0);
  for (const std::uint8_t node_id : {std::uint8_t{8}, std::uint8_t{9}}) {
    power_cycle(rig);
    rig.client.set_node(7);
    TEST_ASSERT_EQUAL(7, rig.client.read(0x3050, 1).value());
    master.switch_to(1);
    master.expect({kConfigureNodeId, node_id}, 0);
    rig.machine.chip().flash.fail_supply_in(0,
                                            [&rig] { rig.machine.chip().request_reset(target::ResetCause::kPowerOn); });
    TEST_ASSERT_FALSE(master.ask({kStore}).has_value());
    rig.client.pass(kBoot_ms);
    TEST_ASSERT_EQUAL(7, rig.client.read(0x3050, 3).value());
  }
  store(master, 10, 0);
  power_cycle(rig);
  rig.client.set_node(10);
  TEST_ASSERT_EQUAL(10, rig.client.read(0x3050, 1).value());
  expect_no_violations(rig);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_board_without_node_id_is_found_by_fastscan_and_numbered);
  RUN_TEST(test_each_bit_rate_is_stored_and_no_other_is_understood);
  RUN_TEST(test_the_bit_rate_changes_when_it_is_activated);
  RUN_TEST(test_the_button_recovers_a_wrong_stored_bit_rate);
  RUN_TEST(test_the_button_recovers_a_lost_word_of_the_owner);
  RUN_TEST(test_sdo_answers_in_time_on_a_slow_bus_while_both_axes_move);
  RUN_TEST(test_a_loss_of_power_while_lss_stores_leaves_the_old_settings_or_the_new_ones);
  return UNITY_END();
}
