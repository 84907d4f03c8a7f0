// SPDX-License-Identifier: Apache-2.0
#include "test_plan/test_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "units.hpp"

namespace trackservo::commissioning {

namespace {

constexpr double kTurnUsed_rad = 340 * kRadPerDeg;  // more gives no new information
constexpr double kFirstLookUsed_rad = 40 * kRadPerDeg;
constexpr double kMinTravel_rad = 0.02;     // from end to end
constexpr double kRateShare = 0.6;          // of the limit, for set-points: wind and overshoot are added
constexpr double kMovingShare = 0.4;        // of the limit
constexpr double kSettle_s = 0.3;           // at rest after a move
constexpr double kTorqueShare = 0.4;        // of the limit, for reversing
constexpr double kPreSlidingLengths = 3.0;  // bristle lengths until an axis slides steadily
constexpr double kUsedTravel = 0.9;         // like commissioning/experiment.c: the rest is for overshoot

// To each side of a place: an angle, and no more than a share of the travel.
struct Room {
  double max_rad;
  double share;
};
constexpr Room kManyPlaces{20 * kRadPerDeg, 0.2};
constexpr Room kLongTravels{60 * kRadPerDeg, 0.4};

// Inputs of the experiments.
struct Means {
  double room_rad;
  double top_rad_s;  // of the sweeps
  double acceleration_rad_s2;
  double torque_nm;
};

struct Bounded {
  const char *what;
  double value;
  double low;
  double high;
};

// `lead` and `advice` are placed before and after the range.
void refuse_outside(const std::vector<Bounded>& all, const char *lead, const char *advice) {
  for (const Bounded& one : all) {
    if (!(one.low <= one.value && one.value <= one.high)) {
      throw TestPlanError(
          fmt::format("{} is {:g}; {} {:g} to {:g}.{}", one.what, one.value, lead, one.low, one.high, advice));
    }
  }
}

void check(const MotionLimits& limits) {
  refuse_outside({{"the lowest joint angle [rad]", limits.lowest_rad, -1e3, 1e3},
                  {"the highest joint angle [rad]", limits.highest_rad, -1e3, 1e3},
                  {"the travel between lowest and highest joint angle [rad]", limits.highest_rad - limits.lowest_rad,
                   kMinTravel_rad, 2e3},
                  {"the speed limit [rad/s]", limits.rate_rad_s, 1e-3, 100.0},
                  {"the torque limit [Nm]", limits.torque_nm, 1e-3, 1e4}},
                 "give", "");
}

void check(const RoughMachine& machine) {
  refuse_outside({{"the rough Coulomb torque [Nm]", machine.coulomb_nm, 1e-5, 1e4},
                  {"the rough bristle length [rad]", machine.bristle_rad, 1e-8, 1.0},
                  {"the rough Stribeck speed [rad/s]", machine.stribeck_rad_s, 1e-6, 10.0},
                  {"the rough inertia [kg m2]", machine.inertia_kg_m2, 1e-7, 1e6}},
                 "the range of machines is", " Identify a first look again.");
}

// Reversing at the top speed takes at most half of the room.
Means means_of(const MotionLimits& limits, double acceleration_rad_s2, const Room& room = kManyPlaces) {
  Means means{};
  means.room_rad = std::min(room.max_rad, room.share * (limits.highest_rad - limits.lowest_rad));
  means.acceleration_rad_s2 = acceleration_rad_s2;
  means.top_rad_s =
      std::min(kRateShare * limits.rate_rad_s, std::sqrt(0.5 * kUsedTravel * means.room_rad * acceleration_rad_s2));
  means.torque_nm = limits.torque_nm;
  return means;
}

experiment_limits limits_of(const MotionLimits& limits, const Means& means) {
  return {static_cast<float>(means.room_rad), static_cast<float>(limits.rate_rad_s),
          static_cast<float>(limits.torque_nm), 600.0F};
}

// `count` places to both sides of the middle of the travel, at most half of `used_rad` away, with room beyond. Not
// evenly spaced, so that no harmonic of the motor has the same phase at all of them.
std::vector<Place> places_in(const MotionLimits& limits, const Means& means, double used_rad, int count) {
  const double middle = 0.5 * (limits.lowest_rad + limits.highest_rad);
  const double reach = std::min(0.5 * (limits.highest_rad - limits.lowest_rad) - means.room_rad, 0.5 * used_rad);
  const auto uneven = [](int i) { return i + 0.35 * std::sin(2.4 * i); };
  std::vector<Place> places;
  places.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    places.push_back({middle + reach * (2.0 * uneven(i) / uneven(count - 1) - 1.0), {}});
  }
  return places;
}

// Speeds from `low` on, each in both directions for `dwell_s`.
stimulus_setup sweep(const Means& means, double low_rad_s, double ratio, int count, double dwell_s) {
  stimulus_setup setup{};
  setup.kind = STIMULUS_SWEEP;
  setup.low_rad_s = static_cast<float>(low_rad_s);
  setup.speed_ratio = static_cast<float>(ratio);
  setup.count = static_cast<std::uint32_t>(count);
  setup.dwell_s = static_cast<float>(dwell_s);
  setup.acceleration_rad_s2 = static_cast<float>(means.acceleration_rad_s2);
  return setup;
}

stimulus_setup loops(double amplitude_rad, double period_s, int count) {
  stimulus_setup setup{};
  setup.kind = STIMULUS_HYSTERESIS;
  setup.dwell_s = static_cast<float>(period_s);
  setup.count = static_cast<std::uint32_t>(count);
  setup.amplitude_rad = static_cast<float>(amplitude_rad);
  return setup;
}

// At a slow speed, as far as the room allows.
stimulus_setup chirp(const Means& means, double rate_rad_s, double torque_nm, double low_hz, double high_hz,
                     double dwell_s) {
  stimulus_setup setup{};
  setup.kind = STIMULUS_CHIRP;
  setup.count = 1;
  setup.dwell_s = static_cast<float>(dwell_s);
  setup.low_rad_s =
      static_cast<float>(std::min({rate_rad_s, 0.5 * kUsedTravel * means.room_rad / dwell_s, 0.5 * means.top_rad_s}));
  setup.amplitude_nm = static_cast<float>(std::min(torque_nm, 0.5 * means.torque_nm));
  setup.low_hz = static_cast<float>(low_hz);
  setup.high_hz = static_cast<float>(high_hz);
  setup.acceleration_rad_s2 = static_cast<float>(means.acceleration_rad_s2);
  return setup;
}

stimulus_setup breakaways(const RoughMachine& machine, const Means& means) {
  constexpr double kPeak = 2.5;  // of Tc: Ts is rarely above two
  stimulus_setup setup{};
  setup.kind = STIMULUS_BREAKAWAY;
  setup.count = 6;
  setup.dwell_s = 2.5F;
  setup.amplitude_nm = static_cast<float>(std::min(kPeak * machine.coulomb_nm, means.torque_nm));
  setup.amplitude_rad = static_cast<float>(std::min(2.0 * machine.bristle_rad, 0.5 * means.room_rad));
  return setup;
}

// A speed needs some bristle lengths until it slides steadily: the slow ones take long, and run one by one.
struct SlowSpeeds {
  std::vector<stimulus_setup> sweeps;
  double seconds = 0;
  double next_rad_s = 0;  // the first that is fast enough for the shortest dwell
};

constexpr double kInertiaTop_hz = 40.0;  // where inertia and friction show

constexpr double kSpeedRatio = 1.6;
constexpr double kShortest_s = 0.4;

SlowSpeeds slow_speeds(const RoughMachine& machine, const Means& means) {
  const double sliding_rad = kPreSlidingLengths * machine.bristle_rad;
  SlowSpeeds slow;
  double speed = (sliding_rad / kShortest_s > machine.stribeck_rad_s ? 0.5 : 0.15) * machine.stribeck_rad_s;
  while (sliding_rad / speed > kShortest_s && speed < means.top_rad_s) {
    slow.sweeps.push_back(sweep(means, speed, 1.0, 1, sliding_rad / speed));
    slow.seconds += 2.0 * sliding_rad / speed;
    speed *= kSpeedRatio;
  }
  slow.next_rad_s = std::min(speed, means.top_rad_s);
  return slow;
}

// Slow compared to the resonance of the axis on its bristles.
stimulus_setup loops_for(const RoughMachine& machine, const Means& means) {
  constexpr double kAll_s = 9.0;
  const double resonance_rad_s = std::sqrt(machine.coulomb_nm / machine.bristle_rad / machine.inertia_kg_m2);
  const double amplitude_rad = std::min(kPreSlidingLengths * machine.bristle_rad, 0.5 * means.room_rad);
  const double period_s = std::max({0.7, 3.0 * 2.0 * M_PI / resonance_rad_s, 4.0 * amplitude_rad / means.top_rad_s});
  return loops(amplitude_rad, period_s, std::max(3, static_cast<int>(std::ceil(kAll_s / period_s))));
}

int speeds_up_to(double top_rad_s, double low_rad_s, double ratio) {
  return std::max(1, static_cast<int>(std::floor(std::log(top_rad_s / low_rad_s) / std::log(ratio))) + 1);
}

}  // namespace

const char *stage_name(Stage stage) {
  switch (stage) {
    case Stage::kFirstLook:
      return "first_look";
    case Stage::kStructure:
      return "structure";
    case Stage::kIdentification:
    default:
      return "identification";
  }
}

TestPlan first_look(const MotionLimits& limits) {
  constexpr double kReach_s = 0.3;  // from rest to the top speed: the inertia is not known yet
  constexpr double kSmallestLoop_rad = 30e-6;
  constexpr int kLoopSizes = 7;  // half a decade apart
  constexpr int kSpeeds = 13;
  constexpr double kRatio = 1.78;  // three decades in all
  constexpr double kDwell_s = 0.5;
  check(limits);
  const Means means = means_of(limits, kRateShare * limits.rate_rad_s / kReach_s);
  TestPlan test_plan{Stage::kFirstLook, places_in(limits, means, kFirstLookUsed_rad, 2),
                     kMovingShare * limits.rate_rad_s, limits_of(limits, means)};
  for (Place& place : test_plan.places) {
    place.experiments.push_back(
        sweep(means, means.top_rad_s * std::pow(kRatio, 1 - kSpeeds), kRatio, kSpeeds, kDwell_s));
    for (int i = 0; i < kLoopSizes; ++i) {
      const double amplitude_rad = std::min(kSmallestLoop_rad * std::pow(10.0, 0.5 * i), 0.2 * means.room_rad);
      place.experiments.push_back(loops(amplitude_rad, std::max(1.0, 4.0 * amplitude_rad / means.top_rad_s), 2));
    }
    place.experiments.push_back(chirp(means, 0.1 * means.top_rad_s, 0.15 * limits.torque_nm, 3.0, kInertiaTop_hz, 4.0));
  }
  return test_plan;
}

TestPlan test_plan_for(const MotionLimits& limits, const RoughMachine& machine) {
  constexpr int kPlaces = 8;
  constexpr double kQuickRatio = 1.45;
  constexpr double kOftenSlow_s = 15.0;  // where the slow speeds take longer, few places must be enough
  check(limits);
  check(machine);
  const Means means = means_of(limits, kTorqueShare * limits.torque_nm / machine.inertia_kg_m2);
  const SlowSpeeds slow = slow_speeds(machine, means);
  TestPlan test_plan{Stage::kIdentification, places_in(limits, means, kTurnUsed_rad, kPlaces),
                     kMovingShare * limits.rate_rad_s, limits_of(limits, means)};
  for (int i = 0; i < kPlaces; ++i) {
    std::vector<stimulus_setup>& experiments = test_plan.places[static_cast<std::size_t>(i)].experiments;
    const bool chosen = i == 2 || i == 5;
    if (slow.seconds < kOftenSlow_s || chosen) {
      experiments = slow.sweeps;
    }
    experiments.push_back(sweep(means, slow.next_rad_s, kSpeedRatio,
                                speeds_up_to(means.top_rad_s, slow.next_rad_s, kSpeedRatio), kShortest_s));
    for (int repeat = 0; repeat < 3; ++repeat) {
      experiments.push_back(sweep(means, means.top_rad_s / std::pow(kQuickRatio, 3), kQuickRatio, 4, 0.3));
    }
    experiments.push_back(loops_for(machine, means));
    experiments.push_back(chirp(means, 3.0 * machine.stribeck_rad_s, machine.coulomb_nm, 1.0, kInertiaTop_hz, 5.0));
    if (chosen) {
      experiments.push_back(breakaways(machine, means));
    }
  }
  return test_plan;
}

TestPlan structure_look(const MotionLimits& limits, const RoughMachine& machine) {
  constexpr double kLowest_hz = 10.0;
  constexpr double kHighest_hz = 300.0;
  constexpr double kDwell_s = 16.5;  // slow, or a resonance would still ring when its window ends
  check(limits);
  check(machine);
  const Means means = means_of(limits, kTorqueShare * limits.torque_nm / machine.inertia_kg_m2, kLongTravels);
  TestPlan test_plan{Stage::kStructure, places_in(limits, means, kFirstLookUsed_rad, 2),
                     kMovingShare * limits.rate_rad_s, limits_of(limits, means)};
  for (Place& place : test_plan.places) {
    place.experiments.push_back(
        chirp(means, 0.25 * means.top_rad_s, machine.coulomb_nm, kLowest_hz, kHighest_hz, kDwell_s));
  }
  return test_plan;
}

double duration_s(const TestPlan& test_plan, double start_rad) {
  double seconds = 0;
  double angle_rad = start_rad;
  for (const Place& place : test_plan.places) {
    seconds += std::abs(place.angle_rad - angle_rad) / test_plan.moving_rad_s + 2.0 * kSettle_s;
    angle_rad = place.angle_rad;
    for (const stimulus_setup& experiment : place.experiments) {
      seconds += static_cast<double>(stimulus_duration_s(&experiment));
    }
  }
  return seconds;
}

}  // namespace trackservo::commissioning
