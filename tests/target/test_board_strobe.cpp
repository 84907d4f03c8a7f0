// SPDX-License-Identifier: Apache-2.0
// When a camera's frame was exposed, on the emulated board: the node's clock (1013) set by a time producer, and the
// camera's strobe at PC12. The test prints how exactly both are known.
#include <cmath>
#include <cstring>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "board_steps.hpp"
#include "device/bus/can_bit_time.hpp"
#include "machine/target/target_camera.hpp"

using bench::BoardRig;
namespace sim = trackservo::sim;
using sim::TargetCamera;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr std::uint32_t kClockRpdo = 0x401;
constexpr std::uint32_t kClockTpdo = 0x381;
constexpr double kMaxJitter_us = 20.0;
constexpr int kTracking = 0xFF;  // -1 as an 8-bit number
constexpr std::uint16_t kStrobe = 0x3074;
constexpr int kAge = 0;
constexpr int kStrobeOrAge = 2;

struct Spread {
  double least = INFINITY;
  double greatest = -INFINITY;
  void add(double value) {
    least = std::min(least, value);
    greatest = std::max(greatest, value);
  }
  double width() const { return greatest - least; }
};

std::uint32_t read(BoardRig& rig, std::uint16_t index, std::uint8_t sub) {
  const std::optional<std::uint32_t> value = rig.client.read(index, sub);
  TEST_ASSERT_TRUE_MESSAGE(value.has_value(), fmt::format("{:04X}:{} is not readable", index, sub).c_str());
  return *value;
}

void write(BoardRig& rig, std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes) {
  TEST_ASSERT_TRUE_MESSAGE(rig.client.write(index, sub, value, bytes),
                           fmt::format("{:04X}:{} is not writable", index, sub).c_str());
}

// The only object of a PDO: 1013.
void map_clock(BoardRig& rig, std::uint16_t communication, std::uint32_t cob_id) {
  const auto mapping = static_cast<std::uint16_t>(communication + 0x200);
  write(rig, communication, 1, 0x80000000U | cob_id, 4);
  write(rig, mapping, 0, 0, 1);
  write(rig, mapping, 1, 0x10130020, 4);
  write(rig, mapping, 0, 1, 1);
  write(rig, communication, 1, cob_id, 4);
}

double now_us(const BoardRig& rig) { return 1e6 * rig.machine.time_s(); }

can_frame clock_frame(std::uint32_t time_us) {
  can_frame frame{};
  frame.id = kClockRpdo;
  frame.length = 4;
  std::memcpy(frame.data, &time_us, sizeof time_us);
  return frame;
}

std::uint32_t u32_of(const can_frame& frame) {
  std::uint32_t value = 0;
  std::memcpy(&value, frame.data, sizeof value);
  return value;
}

void expect_rules_kept(BoardRig& rig) {
  bench::expect_no_violations(rig);
  TEST_ASSERT_EQUAL_INT(0, rig.machine.chip().resets());
}

// When a frame began, from a port of its own.
class Listener {
 public:
  explicit Listener(BoardRig& rig)
      : rig_(rig), port_(rig.bus.attach([this](const can_frame& frame) {
          began_us_[frame.id] = now_us(rig_) - sim::can_frame_bits(frame);
          last_[frame.id] = frame;
          ++count_[frame.id];
        })) {}
  ~Listener() { rig_.bus.detach(port_); }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  double began_us(std::uint32_t id) const { return began_us_.at(id); }
  const can_frame& last(std::uint32_t id) const { return last_.at(id); }
  int count(std::uint32_t id) { return count_[id]; }

 private:
  BoardRig& rig_;
  std::map<std::uint32_t, double> began_us_;
  std::map<std::uint32_t, can_frame> last_;
  std::map<std::uint32_t, int> count_;
  sim::VirtualBus::Port port_;
};

// 100 times at any place within a tick, beside all TPDOs: a strobe shows how far the node's clock is from the
// producer's.
void test_a_time_producer_sets_the_clock_within_20_us() {
  BoardRig rig(bench::tracker_plant());
  bench::boot(rig);
  map_clock(rig, 0x1402, kClockRpdo);
  map_clock(rig, 0x1802, kClockTpdo);
  rig.client.start_node();
  rig.client.pass(5);
  Listener heard(rig);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> part(0.0, 1e-3);
  Spread set;
  Spread edges;
  for (int i = 0; i < 100; ++i) {
    const auto value = static_cast<std::uint32_t>(random());
    rig.machine.run(part(random));
    rig.client.send(clock_frame(value));
    rig.client.pass(3);
    rig.machine.run(part(random));
    const double strobe_us = now_us(rig);
    rig.machine.strobe();
    rig.client.pass(2);
    const std::uint32_t first = read(rig, kStrobe, 4);
    const double expected = value + strobe_us - heard.began_us(kClockRpdo);
    set.add(static_cast<double>(static_cast<std::int32_t>(first - static_cast<std::uint32_t>(std::llround(expected)))));
    rig.machine.run(part(random));
    const double later_us = now_us(rig);
    rig.machine.strobe();
    rig.client.pass(2);
    const std::uint32_t second = read(rig, kStrobe, 4);
    edges.add(static_cast<double>(second - first) - (later_us - strobe_us));
  }
  const std::string text = fmt::format(
      "1013 set 100 times by PDO: {:.0f} to {:+.0f} us from the producer ({:.0f} us allowed); between two edges of the "
      "strobe: {:.1f} to {:+.1f} us",
      set.least, set.greatest, kMaxJitter_us, edges.least, edges.greatest);
  TEST_MESSAGE(text.c_str());
  TEST_ASSERT_TRUE_MESSAGE(std::max(-set.least, set.greatest) <= kMaxJitter_us, text.c_str());
  TEST_ASSERT_TRUE_MESSAGE(edges.width() <= 2.1, text.c_str());
  expect_rules_kept(rig);
}

// A read gives the time at which the node answers; a TPDO that at which it is composed.
void test_the_clock_can_be_read_and_sent() {
  BoardRig rig(bench::tracker_plant());
  bench::boot(rig);
  map_clock(rig, 0x1802, kClockTpdo);
  Listener heard(rig);
  rig.client.start_node();
  rig.client.pass(100);
  Spread sent;
  for (int i = 0; i < 100; ++i) {
    const int before = heard.count(kClockTpdo);
    while (heard.count(kClockTpdo) == before) {
      rig.machine.run(50e-6);
    }
    sent.add(heard.began_us(kClockTpdo) - u32_of(heard.last(kClockTpdo)));
  }
  const std::uint32_t first = read(rig, 0x1013, 0);
  const double first_us = now_us(rig);
  rig.client.pass(1000);
  const std::uint32_t second = read(rig, 0x1013, 0);
  TEST_ASSERT_DOUBLE_WITHIN(1000.0, now_us(rig) - first_us, second - first);
  const std::string text = fmt::format(
      "a TPDO with 1013 begins {:.0f} us after its time on average of the ends, "
      "{:.0f} us between earliest and latest (the emulated bus moves in steps of 50 us)",
      0.5 * (sent.least + sent.greatest) - sent.least, sent.width());
  TEST_MESSAGE(text.c_str());
  TEST_ASSERT_TRUE_MESSAGE(sent.width() <= 200.0, text.c_str());
  expect_rules_kept(rig);
}

// 20 kHz at the pin for 0.2 s, then quiet.
void test_noise_at_the_pin_is_counted_and_does_no_harm() {
  BoardRig rig(bench::tracker_plant());
  bench::boot(rig);
  for (int i = 0; i < 4000; ++i) {
    rig.machine.strobe();
    rig.machine.run(50e-6);
  }
  rig.client.pass(2);
  TEST_ASSERT_UINT32_WITHIN(3, 200, read(rig, kStrobe, 11));
  const std::uint32_t before = read(rig, kStrobe, 5);
  rig.machine.strobe();
  rig.client.pass(2);
  TEST_ASSERT_EQUAL_UINT32(before + 1, read(rig, kStrobe, 5));
  expect_rules_kept(rig);
}

struct Flight {
  double misstated_s = 0.0;  // added to the age that the sender states
  int source = kAge;         // 3071:5
};

struct Result {
  std::array<double, sim::kAxes> sigma_urad{};
  Spread age_ms;               // of the frames, 3072:7
  std::uint32_t paired = 0;    // frames
  std::uint32_t unpaired = 0;  // since the flight has settled
};

sim::ScenarioConfig fly_by() {
  sim::ScenarioConfig scenario = sim::load_scenario("sim_host/scenarios/tracking.toml");
  scenario.duration_s = 9.0;
  return scenario;
}

void set_up(BoardRig& rig, const Flight& flight) {
  for (const sim::ObjectWrite& object : sim::camera_mapping(4, sim::kCameraCobId)) {
    write(rig, object.index, object.sub, object.value, object.sub == 0 ? 1 : 4);
  }
  write(rig, 0x3071, 5, static_cast<std::uint32_t>(flight.source), 1);
  write(rig, 0x3040, 1, 0x6E65706F, 4);
  write(rig, 0x2061, 5, 0, 1);  // it stands in this turn
  write(rig, 0x3040, 1, 0, 4);
}

Result fly(const Flight& flight) {
  const sim::ScenarioConfig scenario = fly_by();
  constexpr double kBegins_s = 1.0;
  TargetCamera camera(scenario, 1, kBegins_s);
  BoardRig rig(bench::tracker_plant(), 1, false, camera.first_angle_rad());
  rig.client.pass(bench::kBoot_ms);
  set_up(rig, flight);
  rig.client.start_node();
  TEST_ASSERT_TRUE(rig.client.enable(kTracking));
  Result result;
  std::array<double, sim::kAxes> sum{};
  std::array<double, sim::kAxes> squares{};
  int count = 0;
  while (rig.truth().time_s < kBegins_s + scenario.duration_s) {
    if (const std::optional<can_frame> frame = camera.look(rig.truth(), flight.misstated_s)) {
      rig.client.send(*frame);
    }
    if (camera.exposed()) {
      rig.machine.strobe();
    }
    rig.client.pass(1);
    if (rig.truth().time_s < kBegins_s + scenario.settle_s) {
      continue;
    }
    const std::array<double, sim::kAxes> error_rad = camera.error_rad(rig.truth());
    for (std::size_t axis = 0; axis < sim::kAxes; ++axis) {
      sum[axis] += error_rad[axis];
      squares[axis] += error_rad[axis] * error_rad[axis];
    }
    if (count == 0) {
      result.unpaired = read(rig, kStrobe, 7);
    }
    if (count++ % 101 == 0) {
      result.age_ms.add(read(rig, 0x3072, 7));
    }
  }
  for (std::size_t axis = 0; axis < sim::kAxes; ++axis) {
    result.sigma_urad[axis] = 1e6 * std::sqrt(squares[axis] / count - std::pow(sum[axis] / count, 2));
  }
  result.paired = read(rig, kStrobe, 6);
  result.unpaired = read(rig, kStrobe, 7) - result.unpaired;
  TEST_ASSERT_EQUAL_HEX32(0, rig.client.error_code(0));
  TEST_ASSERT_EQUAL_HEX32(0, rig.client.error_code(1));
  expect_rules_kept(rig);
  return result;
}

// The first frames count by the sender's statement, until edges and frames are in step: the flights differ from there
// on.
void test_with_the_strobe_a_wrong_age_does_not_count() {
  const Result right = fly({});
  for (const double misstated_s : {-0.01, 0.01}) {
    const Result result = fly({misstated_s, kStrobeOrAge});
    const std::string text = fmt::format(
        "stated age wrong by {:+.0f} ms, with strobe: {:.2f} and {:.2f} urad; right age, without: {:.2f} and {:.2f} "
        "urad; "
        "ages {:.0f} to {:.0f} ms, {} frames paired, {} not since 5 s",
        1e3 * misstated_s, result.sigma_urad[0], result.sigma_urad[1], right.sigma_urad[0], right.sigma_urad[1],
        result.age_ms.least, result.age_ms.greatest, result.paired, result.unpaired);
    TEST_MESSAGE(text.c_str());
    for (std::size_t axis = 0; axis < sim::kAxes; ++axis) {
      TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(0.05 * right.sigma_urad[axis], right.sigma_urad[axis], result.sigma_urad[axis],
                                        text.c_str());
    }
    TEST_ASSERT_TRUE_MESSAGE(result.age_ms.least >= 20.0 && result.age_ms.greatest <= 21.0, text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(result.paired > 400 && result.unpaired == 0, text.c_str());
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_time_producer_sets_the_clock_within_20_us);
  RUN_TEST(test_the_clock_can_be_read_and_sent);
  RUN_TEST(test_noise_at_the_pin_is_counted_and_does_no_harm);
  RUN_TEST(test_with_the_strobe_a_wrong_age_does_not_count);
  return UNITY_END();
}
