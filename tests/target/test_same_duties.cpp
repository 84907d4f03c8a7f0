// SPDX-License-Identifier: Apache-2.0
// Board and simulator, the same ticks, every duty equal: what the image on the emulated board reads in each PWM period
// and tick is given to the servo node on the host, in the order in which the simulator runs it, and each duty is
// compared.
//
// Compared are the timers' compare values, which are what the bridges get, and the voltage of each motor stage bit by
// bit.
#include "board_recording.hpp"
#include "board_steps.hpp"
#include "chips/stm32g4/bridge.h"
#include "machine/run/tick_sequence.hpp"

extern "C" {
#include "products/brushed_tracker/default_parameters.h"
}

using bench::BoardPeriod;
using bench::BoardRecording;
using bench::BoardRig;
using bench::BoardTick;
using bench::kAxes;
namespace sim = trackservo::sim;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr std::uint16_t kPitch = 0x800;
constexpr std::uint32_t kHalf = BRIDGE_COUNTS / 2;  // the compare value of duty 0

std::uint32_t bits_of(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

// --- the host's end ----------------------------------------------------------------------------------------------

bool send_nowhere(void *, const can_frame *) { return true; }

// The node of a new device on a machine that reads what was recorded.
class HostNode {
 public:
  explicit HostNode(const BoardTick& start)
      : node_(std::make_unique<servo_node>()), hal_(recorded_hal(this)), tick_(&start), period_(&start.periods[0]) {
    servo_node_config config{};
    config.node_id = BUS_DEFAULT_NODE_ID;
    config.sender = {send_nowhere, nullptr};
    config.machine = &hal_;
    config.parameters = default_parameters;
    config.limits = default_limits;
    TEST_ASSERT_TRUE(servo_node_start(node_.get(), &config));
  }
  HostNode(const HostNode&) = delete;
  HostNode& operator=(const HostNode&) = delete;

  // One tick of the simulator; `compare(period, duty)` after each PWM period.
  template <typename Compare>
  void run(const BoardTick& tick, Compare compare) {
    tick_ = &tick;
    sim::run_tick_sequence(
        node_->board, [this](std::uint32_t period) { period_ = &tick_->periods[period]; },
        [this] {
          for (const can_frame& frame : tick_->frames) {
            servo_node_receive(node_.get(), &frame);
          }
          servo_node_tick(node_.get());
          servo_node_serve(node_.get());
        },
        [this, &compare](std::uint32_t period) { compare(period, duty_, node_->board); });
  }

 private:
  static HostNode& of(void *self) { return *static_cast<HostNode *>(self); }
  static std::size_t at(int axis) { return static_cast<std::size_t>(axis); }

  static hal recorded_hal(HostNode *self) {
    hal table{};
    table.machine = self;
    table.sample = [](void *m, int axis, hal_axis_samples *samples) { *samples = of(m).tick_->samples[at(axis)]; };
    table.axis_health = [](void *, int) { return HAL_GOOD; };
    table.power_bridge = [](void *, int, bool) {};
    table.current_a = [](void *m, int axis) { return of(m).period_->current_a[at(axis)]; };
    table.bus_voltage_v = [](void *m) { return of(m).period_->bus_voltage_v; };
    table.set_duty = [](void *m, int axis, float duty) { of(m).duty_[at(axis)] = duty; };
    table.set_scales = [](void *, const hal_scales *) {};
    table.release_brake = [](void *, int, bool) {};
    table.brake_is_released = [](void *, int) { return false; };
    table.status = [](void *) { return 0U; };
    table.clock_us = [](void *) { return 0U; };
    table.tick_us = [](void *) { return 0U; };
    table.take_strobes = [](void *, hal_strobes *strobes) { *strobes = {}; };
    return table;
  }

  std::unique_ptr<servo_node> node_;
  hal hal_;
  const BoardTick *tick_;
  const BoardPeriod *period_;
  std::array<float, kAxes> duty_{};
};

// --- comparison --------------------------------------------------------------------------------------------------

struct Comparison {
  long duties = 0;
  long driven = 0;  // of them, not 0
  long different = 0;
  std::string first;  // difference
};

Comparison compare(const BoardTick& start, const std::vector<BoardTick>& ticks) {
  Comparison result;
  HostNode host(start);
  for (std::size_t n = 0; n < ticks.size(); ++n) {
    host.run(ticks[n], [&](std::uint32_t period, const std::array<float, kAxes>& duty, const servo_board& board) {
      const BoardPeriod& seen = ticks[n].periods[period];
      for (std::size_t i = 0; i < kAxes; ++i) {
        const std::uint32_t count = bridge_first_leg(duty[i]);
        const float voltage_v = board.motor[i].state.voltage_v;
        result.duties++;
        result.driven += seen.compare_1[i] != kHalf ? 1 : 0;
        if (count != seen.compare_1[i] || bits_of(voltage_v) != bits_of(seen.voltage_v[i])) {
          if (result.different++ == 0) {
            result.first = fmt::format("tick {}, period {}, {}: board {} counts, {:.9g} V; host {} counts, {:.9g} V", n,
                                       period, sim::axis_name(static_cast<int>(i)), seen.compare_1[i],
                                       seen.voltage_v[i], count, voltage_v);
          }
        }
      }
    });
  }
  return result;
}

// --- the board's end ---------------------------------------------------------------------------------------------

constexpr int kCyclicVelocity = 9;

class Script {
 public:
  Script() {
    bench::boot(rig_);
    // Frames go out 0.4 ms after a tick, when it and its deferred task are long over.
    const std::size_t begin = recording_.ticks().size();
    while (recording_.ticks().size() == begin) {
      rig_.machine.run(sim::kPwmPeriod_s);
    }
    rig_.machine.run(0.4e-3);
    rig_.client.start_node();
  }

  BoardRig& rig() { return rig_; }

  const BoardTick& start() const { return recording_.start(); }

  // Complete ticks so far.
  std::vector<BoardTick> ticks() const {
    std::vector<BoardTick> whole = recording_.ticks();
    while (!whole.empty() && whole.back().periods.size() < SERVO_PWM_PER_TICK) {
      whole.pop_back();
    }
    return whole;
  }
  std::size_t now() const { return recording_.ticks().size(); }

  void enable(int mode) { TEST_ASSERT_TRUE(rig_.client.enable(mode)); }

  void write_shared(int index, int sub, std::uint32_t value, int bytes) {
    TEST_ASSERT_TRUE(
        rig_.client.write(static_cast<std::uint16_t>(index), static_cast<std::uint8_t>(sub), value, bytes));
    rig_.client.pass(1);  // gains are worked out after the answer
  }

  void write(int index, int sub, std::uint32_t value, int bytes) {
    for (const int shift : {0, 0 + kPitch}) {
      write_shared(index + shift, sub, value, bytes);
    }
  }

  // Gains of the current loop go with its bandwidth. Motor data change only while both axes are off.
  void set_current_bandwidth(float rad_s) {
    write(0x6040, 0, 0, 2);
    write_shared(0x3040, 1, 0x6E65706F, 4);
    write(0x2055, 5, bits_of(rad_s), 4);
    write(0x2070, 1, 1, 1);
    enable(kCyclicVelocity);
  }

  // Set-points of both axes that change every millisecond, so that the current loops have work.
  void turn(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i, ++turned_ms_) {
      const auto urad_s = static_cast<std::int32_t>(150'000 * std::sin(0.02 * turned_ms_) + 1'000 * (turned_ms_ % 7));
      rig_.client.set_speeds(urad_s, -urad_s / 2);
      rig_.client.pass(1);
    }
  }

  void finish() {
    bench::expect_no_violations(rig_);
    TEST_ASSERT_EQUAL_INT(0, rig_.machine.chip().resets());
    TEST_ASSERT_EQUAL_INT_MESSAGE(0, recording_.frames_in_between(), "the script must keep clear of the tick");
    for (const auto& emergency : rig_.client.emergencies()) {
      TEST_FAIL_MESSAGE(fmt::format("EMCY {:04X}, {}", emergency.code, emergency.bytes[3]).c_str());
    }
  }

 private:
  BoardRig rig_{bench::tracker_plant()};
  BoardRecording recording_{rig_};
  int turned_ms_ = 0;
};

void expect_equal(const char *what, const Script& script) {
  const std::vector<BoardTick> ticks = script.ticks();
  const Comparison result = compare(script.start(), ticks);
  TEST_MESSAGE(fmt::format("{}: {} ticks, {} duties compared, {} of them driven, {} different", what, ticks.size(),
                           result.duties, result.driven, result.different)
                   .c_str());
  TEST_ASSERT_EQUAL_INT_MESSAGE(0, result.different, result.first.c_str());
  TEST_ASSERT_GREATER_THAN_INT_MESSAGE(5000, result.driven, "nothing was driven");
}

// --- cases -------------------------------------------------------------------------------------------------------

constexpr int kProfilePosition = 1;
constexpr int kProfileVelocity = 3;
constexpr int kCyclicPosition = 8;
constexpr int kCyclicTorque = 10;

void test_every_duty_is_equal_in_every_mode_and_in_changes_between_them() {
  Script script;
  for (const int mode : {kCyclicVelocity, kCyclicPosition, kProfileVelocity, kProfilePosition, kCyclicTorque}) {
    script.enable(mode);
    if (mode == kCyclicPosition || mode == kProfilePosition) {
      script.write(0x607A, 0, 150'000, 4);
      script.write(0x6040, 0, 0x3F, 2);
      script.rig().client.pass(150);
    } else if (mode == kCyclicTorque) {
      for (const int permille : {150, -150, 100, 0}) {
        script.write(0x6071, 0, static_cast<std::uint16_t>(permille), 2);
        script.rig().client.pass(30);
      }
    } else {
      script.turn(200);
    }
  }
  script.write(0x6040, 0, 0x02, 2);  // quick stop
  script.rig().client.pass(200);
  script.finish();
  expect_equal("all modes", script);
}

// Half the bandwidth is half of kp and ki, in force with the set-points of the same tick.
void test_every_duty_is_equal_when_the_current_loop_gets_half_its_gain() {
  Script script;
  script.enable(kCyclicVelocity);
  script.turn(100);
  for (int i = 0; i < 4; ++i) {
    script.set_current_bandwidth(3141.5F);
    script.turn(25);
    script.set_current_bandwidth(6283.0F);
    script.turn(25);
  }
  script.finish();
  expect_equal("current loop's gain halved and doubled", script);
}

// The duty stays what the loop gives for two PWM periods more, then it is 0.
void test_every_duty_is_equal_when_a_driving_axis_is_switched_off() {
  Script script;
  int seen = 0;
  for (int i = 0; i < 4; ++i) {
    script.enable(kCyclicVelocity);
    script.turn(90);
    const std::size_t before = script.now();
    script.write(0x6040, 0, 0x00, 2);
    script.rig().client.pass(20);
    const std::vector<BoardTick> ticks = script.ticks();
    for (std::size_t n = before; n < ticks.size(); ++n) {
      const auto& p = ticks[n].periods;
      seen += p[0].compare_1[0] != kHalf && p[1].compare_1[0] != kHalf && p[2].compare_1[0] == kHalf ? 1 : 0;
    }
    script.rig().client.pass(300);  // it comes to rest
  }
  TEST_ASSERT_EQUAL_INT_MESSAGE(4, seen, "each time the azimuth is switched off between periods 1 and 2");
  script.finish();
  expect_equal("switched off while it drives", script);
}

// That the comparison can fail: the last bit of one current in one of all periods.
void test_the_last_bit_of_one_sample_is_seen() {
  Script script;
  script.enable(kCyclicVelocity);
  script.turn(50);
  std::vector<BoardTick> ticks = script.ticks();
  TEST_ASSERT_EQUAL_INT(0, compare(script.start(), ticks).different);
  float& current_a = ticks[ticks.size() - 2].periods[7].current_a[0];
  current_a = std::nextafter(current_a, 100.0F);
  const Comparison result = compare(script.start(), ticks);
  TEST_MESSAGE(result.first.c_str());
  TEST_ASSERT_GREATER_THAN_INT(0, result.different);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_every_duty_is_equal_in_every_mode_and_in_changes_between_them);
  RUN_TEST(test_every_duty_is_equal_when_the_current_loop_gets_half_its_gain);
  RUN_TEST(test_every_duty_is_equal_when_a_driving_axis_is_switched_off);
  RUN_TEST(test_the_last_bit_of_one_sample_is_seen);
  return UNITY_END();
}
