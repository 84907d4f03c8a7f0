// Gains that make the axis shake: the oscillation monitor takes them back in time, and it does so for no other reason.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "base/random.hpp"
#include "bench.hpp"
#include "design/loop_margins.hpp"
#include "fault_injection/driven_node.hpp"
#include "serve/node_parameters.hpp"
#include "unity.h"

namespace sim = trackservo::sim;
using bench::kRadPerDeg;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

sim::PlantConfig tracker_plant() { return sim::load_plant("sim_host/plants/tracker.toml"); }

struct Caught {
  loop_verdict verdict = LOOP_RUNNING;  // of the device, before the gains were applied in spite of it
  bool taken_back = false;
  fault_id fault = FAULT_NONE;
  double visible_s = -1.0;   // from the gains to the first visible motion
  double caught_s = -1.0;    // from the gains until they were taken back, or the fault
  double peak_deg_s = 0.0;   // of the rate error
  double peak_deg = 0.0;     // of the travel that the rate error makes
  double after_deg_s = 0.0;  // largest rate error in the last half second
};

constexpr double kVisible_deg_s = 1.0;
constexpr int kRunTicks = 3000;

// Two seconds with the good gains, then the others, as if a client had overridden the check.
Caught shake(const sim::NodeSetup& setup, int axis, const axis_parameters& gains, double rate_deg_s,
             std::uint64_t seed) {
  sim::DrivenNode node(setup, seed, {0.0, 0.6});
  node.enable(DRIVE_CYCLIC_VELOCITY);
  double rate_rad_s = 0.0;
  for (int tick = 0; tick < 2000; ++tick) {
    rate_rad_s = std::min(rate_rad_s + 0.001, rate_deg_s * kRadPerDeg);
    node.set_rate(axis, rate_rad_s);
    node.tick();
  }
  servo_node_axis& moved = node.node().axis[axis];
  moved.tuning.staged = gains;
  Caught caught;
  servo_board& board = node.node().board;
  caught.verdict = LOOP_RUNNING;
  while (caught.verdict == LOOP_RUNNING) {
    caught.verdict = axis_tuning_judge(&moved.tuning);
  }
  TEST_ASSERT_EQUAL(
      CONTROL_OK, axis_tuning_apply(&moved.tuning, &board.app.axis[axis], &board.app.params.axis[axis], SERVO_TICK_S));
  double travel_rad = 0.0;
  for (int tick = 0; tick < kRunTicks; ++tick) {
    node.set_rate(axis, rate_rad_s);
    node.tick();
    const double time_s = tick * 1e-3;
    const double error_rad_s = rate_rad_s - node.machine().truth().inertial_rate_rad_s[static_cast<std::size_t>(axis)];
    travel_rad += caught.fault == FAULT_NONE ? error_rad_s * 1e-3 : 0.0;
    if (caught.fault == FAULT_NONE) {
      caught.peak_deg_s = std::max(caught.peak_deg_s, std::abs(error_rad_s) / kRadPerDeg);
      caught.peak_deg = std::max(caught.peak_deg, std::abs(travel_rad) / kRadPerDeg);
      if (tick > kRunTicks - 500) {
        caught.after_deg_s = std::max(caught.after_deg_s, std::abs(error_rad_s) / kRadPerDeg);
      }
    }
    if (caught.visible_s < 0.0 && std::abs(error_rad_s) > kVisible_deg_s * kRadPerDeg) {
      caught.visible_s = time_s;
    }
    if (caught.caught_s < 0.0 && (moved.tuning.proven_is_active || moved.drive.fault != FAULT_NONE)) {
      caught.caught_s = time_s;
      caught.taken_back = moved.tuning.proven_is_active;
    }
    if (moved.drive.fault != FAULT_NONE && caught.fault == FAULT_NONE) {
      caught.fault = moved.drive.fault;
    }
  }
  return caught;
}

// The node starts with such gains: there is nothing to take back.
Caught start_shaking(const sim::NodeSetup& setup, double rate_deg_s) {
  sim::DrivenNode node(setup, 7, {0.0, 0.6});
  node.enable(DRIVE_CYCLIC_VELOCITY);
  Caught caught;
  double rate_rad_s = 0.0;
  for (int tick = 0; tick < kRunTicks; ++tick) {
    rate_rad_s = std::min(rate_rad_s + 0.001, rate_deg_s * kRadPerDeg);
    node.set_rate(sim::kAzimuth, rate_rad_s);
    node.tick();
    const double error_rad_s = rate_rad_s - node.machine().truth().inertial_rate_rad_s[sim::kAzimuth];
    caught.fault = node.axis(sim::kAzimuth).drive.fault;
    if (caught.fault != FAULT_NONE) {
      caught.caught_s = tick * 1e-3;
      return caught;
    }
    caught.peak_deg_s = std::max(caught.peak_deg_s, std::abs(error_rad_s) / kRadPerDeg);
    if (caught.visible_s < 0.0 && std::abs(error_rad_s) > kVisible_deg_s * kRadPerDeg) {
      caught.visible_s = tick * 1e-3;
    }
  }
  return caught;
}

struct Case {
  std::string name;
  std::function<void(axis_parameters&)> write;
};

const std::vector<Case> kCases = {
    {"low-pass 5 Hz", [](axis_parameters& p) { p.filters.lowpass_hz = 5.0F; }},
    {"low-pass 20 Hz", [](axis_parameters& p) { p.filters.lowpass_hz = 20.0F; }},
    {"Kp x 30", [](axis_parameters& p) { p.speed_loop.proportional_nm_s_rad *= 30.0F; }},
    {"Kp 20000", [](axis_parameters& p) { p.speed_loop.proportional_nm_s_rad = 20000.0F; }},
    {"Ki 1e8", [](axis_parameters& p) { p.speed_loop.integral_nm_rad = 1e8F; }},
    {"Kp x 10", [](axis_parameters& p) { p.speed_loop.proportional_nm_s_rad *= 10.0F; }},
};

// In range, and unstable in sliding or in pre-sliding: half of the values from anywhere in their range.
axis_parameters random_gains(const axis_parameters& good, sim::SplitMix64& random) {
  const auto log_uniform = [&](double low, double high) {
    return static_cast<float>(std::exp(std::log(low) + (std::log(high) - std::log(low)) * random.uniform()));
  };
  const auto yes = [&](double share) { return random.uniform() < share; };
  axis_parameters p = good;
  if (yes(0.5))
    p.speed_loop.proportional_nm_s_rad = log_uniform(10.0, 1e6);
  if (yes(0.5))
    p.speed_loop.integral_nm_rad = log_uniform(100.0, 1e8);
  if (yes(0.3))
    p.observer.inertia_kg_m2 = log_uniform(0.1, 1000.0);
  if (yes(0.3))
    p.observer.bandwidth_rad_s = log_uniform(1.0, 1000.0);
  if (yes(0.2))
    p.observer.on = 0;
  if (yes(0.3)) {
    p.filters.lowpass_hz = log_uniform(1.0, 490.0);
    p.filters.lowpass_damping = log_uniform(0.1, 2.0);
  }
  if (yes(0.2)) {
    p.filters.notch_hz = log_uniform(2.0, 400.0);
    p.filters.notch_width_hz = p.filters.notch_hz * log_uniform(0.01, 1.0);
  }
  if (yes(0.3))
    p.sensors.window_ticks = 2 + static_cast<std::uint32_t>(random() % 15);
  if (yes(0.2))
    p.sensors.source = static_cast<std::uint32_t>(random() % 3);
  return p;
}

std::string text_of(const std::string& name, const Caught& c) {
  return fmt::format(
      "{}: {}, fault {}, visible after {:.3f} s, ended after {:.3f} s, peak {:.2f} deg/s, travel {:.3f} deg", name,
      c.taken_back ? "taken back" : "not taken back", static_cast<int>(c.fault), c.visible_s, c.caught_s, c.peak_deg_s,
      c.peak_deg);
}

std::string text_of(int axis, double rate_deg_s, const axis_parameters& p) {
  return fmt::format(
      "axis {} at {:g} deg/s: 2000:1 {:g} 2000:2 {:g} 2020:1 {} 2020:2 {:g} 2020:4 {:g} 2040:1 {:g} 2040:2 {:g} 2040:4 "
      "{:g} 2040:5 {:g} 2050:1 {} 2050:3 {}",
      axis, rate_deg_s, p.speed_loop.proportional_nm_s_rad, p.speed_loop.integral_nm_rad, p.observer.on,
      p.observer.inertia_kg_m2, p.observer.bandwidth_rad_s, p.filters.notch_hz, p.filters.notch_width_hz,
      p.filters.lowpass_hz, p.filters.lowpass_damping, p.sensors.source, p.sensors.window_ticks);
}

constexpr double kLongest_s = 0.5;
constexpr double kLongestOfAll_s = 1.0;  // an oscillation below 1 Hz has not made a whole swing in half a second
constexpr double kPeakAtRest_deg_s = 3.0;
constexpr double kPeakMoving_deg_s = 25.0;
constexpr double kTravelMoving_deg = 2.0;

// Whether the gains were taken back in time and the axis runs on. An oscillation that never becomes visible need not
// be: friction holds the axis, or it grows for longer than the run.
bool is_caught(const Caught& c, double rate_deg_s) {
  if (c.visible_s < 0.0) {
    return c.fault == FAULT_NONE;
  }
  return c.taken_back && c.fault == FAULT_NONE && c.caught_s - c.visible_s <= kLongestOfAll_s &&
         c.peak_deg_s <= (rate_deg_s == 0.0 ? kPeakAtRest_deg_s : kPeakMoving_deg_s) &&
         c.peak_deg <= kTravelMoving_deg && c.after_deg_s <= kVisible_deg_s;
}

void test_the_gains_that_shook_unnoticed_are_taken_back() {
  const sim::NodeSetup setup(tracker_plant());
  for (const Case& shaking : kCases) {
    for (const double rate_deg_s : {0.0, 20.0}) {
      axis_parameters gains = setup.parameters[sim::kAzimuth];
      shaking.write(gains);
      const Caught caught = shake(setup, sim::kAzimuth, gains, rate_deg_s, 5);
      const std::string text = text_of(fmt::format("{} at {:g} deg/s", shaking.name, rate_deg_s), caught);
      std::printf("%s\n", text.c_str());
      TEST_ASSERT_EQUAL_MESSAGE(LOOP_REFUSED, caught.verdict, text.c_str());
      TEST_ASSERT_TRUE_MESSAGE(caught.taken_back && is_caught(caught, rate_deg_s), text.c_str());
    }
  }
}

void test_without_gains_to_take_back_the_axis_stops_with_its_own_fault() {
  for (const Case& shaking : kCases) {
    sim::NodeSetup setup(tracker_plant());
    shaking.write(setup.parameters[sim::kAzimuth]);
    for (const double rate_deg_s : {0.0, 10.0}) {
      const Caught caught = start_shaking(setup, rate_deg_s);
      const std::string text = text_of(fmt::format("{} at {:g} deg/s", shaking.name, rate_deg_s), caught);
      std::printf("from the start, %s\n", text.c_str());
      TEST_ASSERT_EQUAL_MESSAGE(FAULT_OSCILLATION, caught.fault, text.c_str());
      TEST_ASSERT_TRUE_MESSAGE(caught.caught_s <= kLongest_s, text.c_str());
      TEST_ASSERT_TRUE_MESSAGE(caught.peak_deg_s <= kPeakMoving_deg_s, text.c_str());
    }
  }
}

// Seeded; at rest and at 10 deg/s, both axes. SHAKING_SETS: how many, 500 if not set.
void test_random_gains_that_shake_are_taken_back() {
  const sim::PlantConfig plant = tracker_plant();
  const sim::NodeSetup setup(plant);
  const char *const given = std::getenv("SHAKING_SETS");
  const int count = given != nullptr ? std::atoi(given) : 500;
  sim::SplitMix64 random(1);
  int seen = 0;
  int missed = 0;
  int late = 0;
  double longest_s = 0.0;
  double peak_deg_s[2] = {0.0, 0.0};
  double travel_deg = 0.0;
  for (int i = 0; i < count;) {
    const int axis = i % 2;
    const axis_parameters gains = random_gains(setup.parameters[static_cast<std::size_t>(axis)], random);
    servo_axis_params built;
    if (axis_parameters_build(&gains, &built) != CONTROL_OK || sim::speed_loop_is_stable(plant, axis, built.speed)) {
      continue;
    }
    const bool moving = i % 4 >= 2;
    const double rate_deg_s = moving ? 10.0 : 0.0;
    const Caught caught = shake(setup, axis, gains, rate_deg_s, 100 + static_cast<std::uint64_t>(i));
    TEST_ASSERT_EQUAL_MESSAGE(LOOP_REFUSED, caught.verdict, text_of(axis, rate_deg_s, gains).c_str());
    if (!is_caught(caught, rate_deg_s)) {
      ++missed;
      std::printf("%s\n", text_of(text_of(axis, rate_deg_s, gains), caught).c_str());
    }
    if (caught.taken_back) {
      ++seen;
      late += caught.visible_s >= 0.0 && caught.caught_s - caught.visible_s > kLongest_s ? 1 : 0;
      longest_s = std::max(longest_s, caught.visible_s < 0.0 ? 0.0 : caught.caught_s - caught.visible_s);
      peak_deg_s[moving ? 1 : 0] = std::max(peak_deg_s[moving ? 1 : 0], caught.peak_deg_s);
      travel_deg = std::max(travel_deg, caught.peak_deg);
    }
    ++i;
  }
  std::printf(
      "%d sets, %d taken back, %d missed, %d later than 0.5 s; at most %.3f s after %.1f deg/s, peak %.2f deg/s at "
      "rest, %.2f deg/s and "
      "%.2f "
      "deg moving\n",
      count, seen, missed, late, longest_s, kVisible_deg_s, peak_deg_s[0], peak_deg_s[1], travel_deg);
  TEST_ASSERT_EQUAL(0, missed);
  TEST_ASSERT_LESS_OR_EQUAL(count / 200, late);
  TEST_ASSERT_GREATER_THAN(count * 3 / 4, seen);
}

// Whether they hold the axis against its friction. Much weaker loops hunt: they stick and slip, at 1 deg/s and more.
bool are_strong(const axis_parameters& gains, const axis_parameters& designed) {
  return gains.speed_loop.proportional_nm_s_rad >= 0.3F * designed.speed_loop.proportional_nm_s_rad &&
         gains.observer.inertia_kg_m2 <= 10.0F * designed.observer.inertia_kg_m2;
}

// Gains that keep 6 dB and 40 degrees, new ones on a machine in wind: at rest, moving, with steps and reversals of the
// set-point.
void test_new_gains_with_margins_are_never_taken_back() {
  const sim::PlantConfig plant = tracker_plant();
  const sim::NodeSetup setup(plant);
  const char *const given = std::getenv("QUIET_SETS");
  const int count = given != nullptr ? std::atoi(given) : 100;
  sim::SplitMix64 random(2);
  int taken_back = 0;
  for (int i = 0; i < count;) {
    const int axis = i % 2;
    axis_parameters gains = random_gains(setup.parameters[static_cast<std::size_t>(axis)], random);
    gains.speed_loop.tracking_rate_per_s =
        std::min(1000.0F, gains.speed_loop.integral_nm_rad / gains.speed_loop.proportional_nm_s_rad);
    servo_axis_params built;
    if (axis_parameters_build(&gains, &built) != CONTROL_OK ||
        !are_strong(gains, setup.parameters[static_cast<std::size_t>(axis)]) ||
        !sim::speed_loop_is_stable(plant, axis, built.speed) ||
        !sim::keeps_margins(sim::worst_margins(plant, axis, built.speed))) {
      continue;
    }
    sim::DrivenNode node(setup, 500 + static_cast<std::uint64_t>(i), {0.0, 0.6});
    node.enable(DRIVE_CYCLIC_VELOCITY);
    servo_node_axis& moved = node.node().axis[axis];
    servo_board& board = node.node().board;
    moved.tuning.staged = gains;
    TEST_ASSERT_EQUAL(CONTROL_OK, axis_tuning_apply(&moved.tuning, &board.app.axis[axis], &board.app.params.axis[axis],
                                                    SERVO_TICK_S));
    for (int tick = 0; tick < 6000 && !moved.tuning.proven_is_active && moved.drive.fault == FAULT_NONE; ++tick) {
      const double time_s = tick * 1e-3;
      const double slow_deg_s = 3.0 * std::sin(2.0 * sim::kPi * time_s);
      const double steps_deg_s = tick % 500 < 250 ? 1.0 : -1.0;
      node.set_rate(axis, kRadPerDeg * (tick < 1500 ? 0.0 : tick < 3500 ? slow_deg_s : steps_deg_s));
      node.tick();
    }
    if (moved.tuning.proven_is_active || moved.drive.fault != FAULT_NONE) {
      ++taken_back;
      std::printf("%s: fault %d\n", text_of(axis, 0.0, gains).c_str(), static_cast<int>(moved.drive.fault));
    }
    ++i;
  }
  std::printf("%d sets with margins, %d taken back\n", count, taken_back);
  TEST_ASSERT_EQUAL(0, taken_back);
}

// A client's set-points that alternate fast, up to where they take all of the motor's torque, and gains that are new
// and good: what the motor does follows from the set-points.
void test_good_new_gains_are_kept_while_set_points_alternate_fast() {
  const sim::PlantConfig plant = tracker_plant();
  const sim::NodeSetup setup(plant);
  for (const double size_rad_s : {2e-3, 8e-3, 20e-3}) {
    for (const double frequency_hz : {10.0, 36.0, 77.0, 143.0, 333.0}) {
      sim::DrivenNode node(setup, 5, {0.0, 0.6});
      node.enable(DRIVE_CYCLIC_VELOCITY);
      for (int axis = 0; axis < SERVO_AXES; ++axis) {
        axis_tuning& tuning = node.node().axis[axis].tuning;
        tuning.staged = setup.parameters[static_cast<std::size_t>(axis)];
        tuning.staged.speed_loop.proportional_nm_s_rad *= 0.95F;
        servo_board& board = node.node().board;
        TEST_ASSERT_EQUAL(
            CONTROL_OK, axis_tuning_apply(&tuning, &board.app.axis[axis], &board.app.params.axis[axis], SERVO_TICK_S));
      }
      for (int tick = 0; tick < 2000; ++tick) {
        const double rate_rad_s = size_rad_s * std::sin(2.0 * sim::kPi * frequency_hz * tick * 1e-3);
        node.set_rate(sim::kAzimuth, rate_rad_s);
        node.set_rate(sim::kPitch, rate_rad_s);
        node.tick();
      }
      for (int axis = 0; axis < SERVO_AXES; ++axis) {
        const std::string text = fmt::format("axis {}, {:g} mrad/s at {:g} Hz, fault {}", axis, 1e3 * size_rad_s,
                                             frequency_hz, static_cast<int>(node.axis(axis).drive.fault));
        TEST_ASSERT_EQUAL_MESSAGE(FAULT_NONE, node.axis(axis).drive.fault, text.c_str());
        TEST_ASSERT_FALSE_MESSAGE(node.node().axis[axis].tuning.proven_is_active, text.c_str());
      }
    }
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_gains_that_shook_unnoticed_are_taken_back);
  RUN_TEST(test_without_gains_to_take_back_the_axis_stops_with_its_own_fault);
  RUN_TEST(test_random_gains_that_shake_are_taken_back);
  RUN_TEST(test_new_gains_with_margins_are_never_taken_back);
  RUN_TEST(test_good_new_gains_are_kept_while_set_points_alternate_fast);
  return UNITY_END();
}
