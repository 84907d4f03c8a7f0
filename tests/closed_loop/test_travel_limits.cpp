// SPDX-License-Identifier: Apache-2.0
// Moves towards the hard end of the travel (0x2060:9, :10), in every mode, at every speed, in wind: they must end
// inside, reported by statusword bit 11, and never in fault 8612.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "bench.hpp"
#include "device/driven_node.hpp"
#include "machine/base/random.hpp"
#include "support/test_size.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr int kProfilePosition = 1;
constexpr int kProfileVelocity = 3;
constexpr int kCyclicPosition = 8;
constexpr int kCyclicVelocity = 9;
constexpr int kCyclicTorque = 10;
constexpr int kModes[] = {kProfilePosition, kProfileVelocity, kCyclicPosition, kCyclicVelocity, kCyclicTorque};
constexpr double kCountsPerRad = 1e7;
constexpr std::uint32_t kNoLimit = 0xFFFFFFFF;
constexpr unsigned kInternalLimit = 1U << 11;

enum class Ending { kHeld, kHalted, kQuickStopped };

// One move outwards. Rates and accelerations in 1e-6, as on the bus.
struct Approach {
  int mode = kProfileVelocity;
  int axis = sim::kAzimuth;
  double direction = 1.0;
  double room_rad = 0.3;
  std::uint32_t rate = 1000000;
  std::uint32_t acceleration = 1000000;
  std::uint32_t deceleration = 1000000;
  std::uint32_t quick_stop = 3000000;
  Ending ending = Ending::kHeld;
  double ended_at_rad = 0.0;  // share of the remaining distance at which the halt or quick stop comes
  std::uint64_t seed = 1;
};

struct Outcome {
  fault_id fault = FAULT_NONE;
  double left_rad = 1e3;  // to the hard end, at least
  double rest_rad = 0.0;  // at the end
  double speed_rad_s = 0.0;
  bool reported = false;  // bit 11 at the end
};

std::string describe(const Approach& a, const Outcome& o) {
  return fmt::format(
      "mode {} axis {} direction {:+.0f} room {:.3f} rate {} acceleration {} deceleration {} quick stop {} ending {} "
      "at "
      "{:.3f} seed {}: fault {}, {:.2f} mrad left at least, {:.2f} at the end, {:.3f} rad/s at most",
      a.mode, a.axis, a.direction, a.room_rad, a.rate, a.acceleration, a.deceleration, a.quick_stop,
      static_cast<int>(a.ending), a.ended_at_rad, a.seed, static_cast<int>(o.fault), 1e3 * o.left_rad, 1e3 * o.rest_rad,
      o.speed_rad_s);
}

class Run {
 public:
  Run(const sim::NodeSetup& setup, const Approach& approach)
      : a_(approach),
        i_(static_cast<std::size_t>(approach.axis)),
        end_rad_(end_of(setup, approach)),
        node_(setup, approach.seed, start_of(setup, approach)) {}

  Outcome run() {
    node_.write(a_.axis, 0x607D, 1, 0);  // no software limit before the hard one
    node_.write(a_.axis, 0x607D, 2, 0);
    node_.write(a_.axis, 0x607F, 0, a_.rate);
    node_.write(a_.axis, 0x6081, 0, a_.rate);
    node_.write(a_.axis, 0x6083, 0, a_.acceleration);
    node_.write(a_.axis, 0x6084, 0, a_.deceleration);
    node_.write(a_.axis, 0x6085, 0, a_.quick_stop);
    node_.write(a_.axis, 0x605A, 0, 6);
    std::array<std::int8_t, sim::kAxes> modes = {kProfilePosition, kProfilePosition};
    modes[i_] = static_cast<std::int8_t>(a_.mode);
    node_.enable(modes);
    wanted_rad_ = position();
    const double fastest = std::min(1e-6 * a_.rate, 1.0);
    const double braked = 1e-6 * std::min({a_.deceleration, a_.quick_stop, a_.acceleration});
    return go_on(2500 + static_cast<int>(1e3 * (a_.room_rad / fastest + 2.0 * std::min(fastest / braked, 8.0))));
  }

  Outcome go_on(int ticks) {
    for (int tick = 0; tick < ticks && outcome_.fault == FAULT_NONE; ++tick) {
      set_point();
      finish();
      node_.tick();
      note();
    }
    outcome_.rest_rad = left();
    outcome_.reported = (objects().state.statusword & kInternalLimit) != 0;
    return outcome_;
  }

  // From now on in the other direction.
  Outcome come_back(int ticks) {
    inwards_ = true;
    tick_ = 0;
    wanted_rad_ = position();
    return go_on(ticks);
  }

 private:
  static double end_of(const sim::NodeSetup& setup, const Approach& a) {
    const protection_limits& limits = setup.limits[static_cast<std::size_t>(a.axis)];
    return static_cast<double>(a.direction < 0.0 ? limits.minimum_rad : limits.maximum_rad);
  }

  static std::array<double, sim::kAxes> start_of(const sim::NodeSetup& setup, const Approach& a) {
    std::array<double, sim::kAxes> start = {0.2, 0.4};
    start[static_cast<std::size_t>(a.axis)] = end_of(setup, a) - a.direction * a.room_rad;
    return start;
  }

  const drive_objects& objects() const { return node_.axis(a_.axis).objects; }
  double position() const { return static_cast<double>(objects().position.actual) / kCountsPerRad; }
  double left() { return a_.direction * (end_rad_ - node_.machine().truth().joint_angle_rad[i_]); }

  void set_point() {
    const double direction = inwards_ ? -a_.direction : a_.direction;
    const double rate_rad_s = direction * std::min(1e-6 * a_.rate, 2.0);
    const auto velocity = static_cast<std::int64_t>(direction * std::min(a_.rate, 2000000000U));
    const int tick = tick_++;
    switch (a_.mode) {
      case kProfilePosition:
        if (tick == 0) {
          node_.write(a_.axis, 0x607A, 0, std::llround((end_rad_ + 0.5 * direction) * kCountsPerRad));
          node_.write(a_.axis, 0x6040, 0, 0x1F);
        } else if (tick == 3) {
          node_.write(a_.axis, 0x6040, 0, 0x0F);
        }
        break;
      case kCyclicPosition:
        wanted_rad_ += rate_rad_s * sim::kTick_s;
        node_.write(a_.axis, 0x607A, 0, std::llround(wanted_rad_ * kCountsPerRad));
        break;
      case kCyclicTorque:
        node_.write(a_.axis, 0x6071, 0, static_cast<std::int64_t>(direction * 1000.0));
        break;
      default:
        node_.write(a_.axis, 0x60FF, 0, velocity);
        break;
    }
  }

  void finish() {
    if (a_.ending == Ending::kHeld || left() > a_.ended_at_rad) {
      return;
    }
    node_.write(a_.axis, 0x6040, 0, a_.ending == Ending::kHalted ? 0x10F : 0x0B);
  }

  void note() {
    outcome_.fault = node_.axis(a_.axis).drive.fault;
    outcome_.left_rad = std::min(outcome_.left_rad, left());
    outcome_.speed_rad_s = std::max(outcome_.speed_rad_s, a_.direction * node_.machine().truth().joint_rate_rad_s[i_]);
  }

  Approach a_;
  std::size_t i_;
  double end_rad_;
  sim::DrivenNode node_;
  double wanted_rad_ = 0;
  int tick_ = 0;
  bool inwards_ = false;
  Outcome outcome_;
};

std::uint32_t counts(double value) { return static_cast<std::uint32_t>(std::min(1e6 * value, 4294967295.0)); }

double between(sim::SplitMix64& random, double low, double high) {
  return low * std::exp(random.uniform() * std::log(high / low));
}

Approach random_approach(std::uint64_t seed) {
  sim::SplitMix64 random(sim::SplitMix64::mix(seed));
  Approach a;
  a.seed = seed;
  a.mode = kModes[seed % std::size(kModes)];
  a.axis = static_cast<int>(seed / std::size(kModes) % 2);
  a.direction = random.uniform() < 0.5 ? -1.0 : 1.0;
  a.room_rad = between(random, 0.02, 0.8);
  a.rate = random.uniform() < 0.2 ? kNoLimit : counts(between(random, 0.02, 1.2));
  a.acceleration = random.uniform() < 0.2 ? kNoLimit : counts(between(random, 0.3, 20.0));
  a.deceleration = random.uniform() < 0.2 ? kNoLimit : counts(between(random, 0.3, 20.0));
  a.quick_stop = counts(between(random, 0.3, 20.0));
  a.ending = static_cast<Ending>(random.uniform() * 3.0);
  a.ended_at_rad = between(random, 0.003, 0.2);
  return a;
}

// Within the half turn in which a drive that has just started knows its position.
sim::NodeSetup setup_with_travel() {
  sim::NodeSetup setup(sim::load_plant("sim_host/plants/tracker.toml"));
  setup.limits[sim::kAzimuth].minimum_rad = -1.2F;
  setup.limits[sim::kAzimuth].maximum_rad = 1.2F;
  return setup;
}

// Always inside; reported where the limit stops it.
void expect_inside(const Approach& approach, const Outcome& outcome) {
  const std::string what = describe(approach, outcome);
  TEST_ASSERT_EQUAL_MESSAGE(FAULT_NONE, outcome.fault, what.c_str());
  TEST_ASSERT_TRUE_MESSAGE(outcome.left_rad > 0.0, what.c_str());
  TEST_ASSERT_TRUE_MESSAGE(approach.ending != Ending::kHeld || outcome.reported, what.c_str());
}

// pp and pv with the objects' values after a start: each of these ended in fault 8612, 0.3 to 3.8 mrad outside.
void test_twelve_plain_moves_to_the_hard_end_stop_inside_and_say_so() {
  const sim::NodeSetup setup = setup_with_travel();
  double min_rad = 1e3;
  std::uint64_t seed = 0;
  for (const int mode : {kProfilePosition, kProfileVelocity}) {
    for (const int axis : {sim::kAzimuth, sim::kPitch}) {
      for (const double rate_rad_s : {0.1, 0.35, 1.0}) {
        Approach approach;
        approach.mode = mode;
        approach.axis = axis;
        approach.direction = seed % 2 == 0 ? 1.0 : -1.0;
        approach.rate = counts(rate_rad_s);
        approach.seed = ++seed;
        const Outcome outcome = Run(setup, approach).run();
        expect_inside(approach, outcome);
        min_rad = std::min(min_rad, outcome.left_rad);
      }
    }
  }
  std::printf("12 plain moves: %.2f mrad left to the hard end at least\n", 1e3 * min_rad);
}

// Rates up to 607F = FFFFFFFF, accelerations up to the objects' maximum, in all modes, held against the limit, or
// stopped by halt or quick stop before it. Some of the stopping margin of 5 mrad must be left.
void test_moves_of_all_kinds_towards_the_hard_end_stop_inside() {
  const auto moves = static_cast<std::size_t>(by_size(40, 300, 3000));
  const sim::NodeSetup setup = setup_with_travel();
  std::vector<double> left_rad;
  for (std::uint64_t seed = 1; seed <= moves; ++seed) {
    const Approach approach = random_approach(seed);
    const Outcome outcome = Run(setup, approach).run();
    expect_inside(approach, outcome);
    left_rad.push_back(outcome.left_rad);
  }
  std::sort(left_rad.begin(), left_rad.end());
  std::printf("%d moves: %.2f mrad left to the hard end at least, 5th percentile %.2f\n", static_cast<int>(moves),
              1e3 * left_rad.front(), 1e3 * left_rad[moves / 20]);
}

// The drive's model of the machine is wrong by 30 %, in both directions.
void test_a_wrong_inertia_does_not_lead_outside() {
  const auto last = static_cast<std::uint64_t>(1000 + by_size(10, 60, 600));
  for (const float share : {0.7F, 1.3F}) {
    sim::NodeSetup setup = setup_with_travel();
    for (axis_parameters& parameters : setup.parameters) {
      parameters.observer.inertia_kg_m2 *= share;
      parameters.speed_loop.acceleration_inertia_kg_m2 *= share;
    }
    for (std::uint64_t seed = 1001; seed <= last; ++seed) {
      const Approach approach = random_approach(seed);
      expect_inside(approach, Run(setup, approach).run());
    }
  }
}

// A rate of 0 refers to inertial space: an axis held by it would drift out with gyro bias, base and gusts.
void test_an_axis_that_is_held_against_its_limit_stays_there() {
  const sim::NodeSetup setup = setup_with_travel();
  for (const int mode : {kProfileVelocity, kCyclicVelocity, kCyclicTorque}) {
    Approach approach;
    approach.mode = mode;
    approach.room_rad = 0.05;
    approach.seed = static_cast<std::uint64_t>(mode);
    Run run(setup, approach);
    const Outcome arrived = run.run();
    expect_inside(approach, arrived);
    const Outcome later = run.go_on(60000);
    expect_inside(approach, later);
    std::printf("mode %d, a minute later: %.2f mrad left, %.2f before\n", mode, 1e3 * later.rest_rad,
                1e3 * arrived.rest_rad);
    TEST_ASSERT_DOUBLE_WITHIN(2e-3, arrived.rest_rad, later.rest_rad);
  }
}

// Pushed into the margin, or out of the travel: outward set-points are not followed there, inward ones are.
void test_an_axis_that_stands_outside_comes_back() {
  const sim::NodeSetup setup = setup_with_travel();
  for (const double room_rad : {0.003, -0.008}) {
    for (const int mode : kModes) {
      Approach approach;
      approach.mode = mode;
      approach.axis = mode % 2 == 0 ? sim::kPitch : sim::kAzimuth;
      approach.room_rad = room_rad;
      approach.rate = counts(0.1);
      approach.seed = 77;
      Run run(setup, approach);
      const Outcome outwards = run.run();
      const std::string what = describe(approach, outwards);
      TEST_ASSERT_EQUAL_MESSAGE(FAULT_NONE, outwards.fault, what.c_str());
      TEST_ASSERT_TRUE_MESSAGE(outwards.reported, what.c_str());
      TEST_ASSERT_TRUE_MESSAGE(outwards.left_rad > room_rad - 2e-3, what.c_str());
      const Outcome inwards = run.come_back(1000);
      TEST_ASSERT_EQUAL_MESSAGE(FAULT_NONE, inwards.fault, what.c_str());
      TEST_ASSERT_TRUE_MESSAGE(inwards.rest_rad > 0.03, describe(approach, inwards).c_str());
    }
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_twelve_plain_moves_to_the_hard_end_stop_inside_and_say_so);
  RUN_TEST(test_moves_of_all_kinds_towards_the_hard_end_stop_inside);
  RUN_TEST(test_a_wrong_inertia_does_not_lead_outside);
  RUN_TEST(test_an_axis_that_is_held_against_its_limit_stays_there);
  RUN_TEST(test_an_axis_that_stands_outside_comes_back);
  return UNITY_END();
}
