// SPDX-License-Identifier: Apache-2.0
#include "judge/fault_injection/soak.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include "judge/fault_injection/motion.hpp"
#include "machine/base/job_pool.hpp"
#include "machine/base/random.hpp"

namespace trackservo::sim {
namespace {

constexpr int kTasks = 60;
constexpr double kTask_s = 10.0;
constexpr double kShift_s = kTasks * kTask_s;

class Shift {
 public:
  Shift(const NodeSetup& setup, std::uint64_t seed)
      : random_(SplitMix64::mix(seed)), node_(setup, seed, {0.0, 0.6}), seed_(seed) {
    for (int axis = 0; axis < kAxes; ++axis) {
      node_.write(axis, 0x607D, 1, axis == kAzimuth ? -10000000 : 1000000);  // 0.1 to 1.1 rad of pitch
      node_.write(axis, 0x607D, 2, axis == kAzimuth ? 10000000 : 11000000);
    }
  }

  SoakResult run(int tasks) {
    for (int task = 0; task < tasks && result_.false_trips.empty(); ++task) {
      work();
    }
    result_.hours = time_s_ / 3600.0;
    return result_;
  }

 private:
  double uniform(double low, double high) { return low + (high - low) * random_.uniform(); }

  void work() {
    switch (random_() % 6) {
      case 0:
        return position();
      case 1:
        return velocity();
      case 2:
        return fly_by();
      case 3:
        return switch_off();
      case 4:
        return cyclic_position();
      default:
        return stand();
    }
  }

  void position() {
    node_.enable(DRIVE_PROFILE_POSITION);
    for (int part = 0; part < 2; ++part) {
      node_.write(kAzimuth, 0x607A, 0, static_cast<std::int64_t>(uniform(-1.0, 1.0) * 1e7));
      node_.write(kPitch, 0x607A, 0, static_cast<std::int64_t>(uniform(0.1, 1.1) * 1e7));
      for (int axis = 0; axis < kAxes; ++axis) {
        node_.write(axis, 0x6040, 0, 0x3F);
      }
      ticks(2);
      for (int axis = 0; axis < kAxes; ++axis) {
        node_.write(axis, 0x6040, 0, 0x0F);
      }
      ticks(static_cast<int>(kTask_s / 2.0 / kTick_s));
    }
  }

  void velocity() {
    for (int axis = 0; axis < kAxes; ++axis) {
      node_.set_rate(axis, 0.0);
    }
    node_.enable(DRIVE_PROFILE_VELOCITY);
    for (int part = 0; part < 10; ++part) {
      for (int axis = 0; axis < kAxes; ++axis) {
        const double fast = std::pow(10.0, uniform(-4.0, 0.0));  // 1e-4 to 1 rad/s
        node_.set_rate(axis, uniform(0.0, 1.0) < 0.5 ? -fast : fast);
      }
      ticks(static_cast<int>(kTask_s / 10.0 / kTick_s));
    }
  }

  void fly_by() {
    node_.enable(DRIVE_CYCLIC_VELOCITY);
    const double direction = uniform(0.0, 1.0) < 0.5 ? -1.0 : 1.0;
    for (int i = 0; i < static_cast<int>(3.0 / kTick_s); ++i) {
      for (int axis = 0; axis < kAxes; ++axis) {
        node_.set_rate(axis, direction * motion_rate_rad_s(Motion::kTracking, i * kTick_s));
      }
      ticks(1);
    }
    stand();
  }

  // Towards the middle of the travel and to rest there or beyond it.
  void cyclic_position() {
    node_.enable(DRIVE_CYCLIC_POSITION);
    std::array<double, kAxes> mean_rad_s{};
    for (int axis = 0; axis < kAxes; ++axis) {
      const double off_rad = 1e-7 * node_.axis(axis).objects.position.actual - (axis == kAzimuth ? 0.0 : 0.6);
      const double way_rad = axis == kAzimuth ? uniform(0.001, 0.8) : uniform(0.001, 0.4);
      mean_rad_s[static_cast<std::size_t>(axis)] = std::copysign(way_rad / kTask_s, -off_rad);
    }
    for (int i = 0; i < static_cast<int>(kTask_s / kTick_s); ++i) {
      const double share = 1.0 - std::cos(2.0 * kPi * i * kTick_s / kTask_s);
      for (int axis = 0; axis < kAxes; ++axis) {
        node_.move(axis, share * mean_rad_s[static_cast<std::size_t>(axis)]);
      }
      ticks(1);
    }
  }

  void stand() {
    for (int axis = 0; axis < kAxes; ++axis) {
      node_.set_rate(axis, 0.0);
    }
    node_.enable(DRIVE_PROFILE_VELOCITY);
    ticks(static_cast<int>(kTask_s / kTick_s));
  }

  void switch_off() {
    for (int axis = 0; axis < kAxes; ++axis) {
      node_.write(axis, 0x6040, 0, 0x00);
    }
    ticks(static_cast<int>(kTask_s / kTick_s));
  }

  void ticks(int count) {
    for (int i = 0; i < count && result_.false_trips.empty(); ++i) {
      node_.tick();
      time_s_ += kTick_s;
      for (int axis = 0; axis < kAxes; ++axis) {
        look(axis);
      }
    }
  }

  void look(int axis) {
    const servo_node_axis& monitored = node_.axis(axis);
    const axis_protection& seen = monitored.monitor.state;
    const protection_limits& limits = monitored.monitor.limits;
    const auto share = [](float value, float limit) { return std::abs(static_cast<double>(value / limit)); };
    result_.max_disagreement = std::max(result_.max_disagreement, share(seen.difference_rad_s, limits.base_rate_rad_s));
    result_.max_mismatch_ticks = std::max(result_.max_mismatch_ticks, std::abs(seen.mismatch_ticks));
    result_.max_heating = std::max(result_.max_heating,
                                   share(seen.heating_a2, limits.continuous_current_a * limits.continuous_current_a));
    if (monitored.drive.fault != FAULT_NONE) {
      result_.false_trips.push_back(fmt::format("shift {}: fault {} of axis {} after {:.3f} s", seed_,
                                                static_cast<int>(monitored.drive.fault), axis, time_s_));
    }
  }

  SplitMix64 random_;
  DrivenNode node_;
  std::uint64_t seed_;
  SoakResult result_;
  double time_s_ = 0;
};

void add(SoakResult& all, const SoakResult& shift) {
  all.hours += shift.hours;
  all.false_trips.insert(all.false_trips.end(), shift.false_trips.begin(), shift.false_trips.end());
  all.max_disagreement = std::max(all.max_disagreement, shift.max_disagreement);
  all.max_mismatch_ticks = std::max(all.max_mismatch_ticks, shift.max_mismatch_ticks);
  all.max_heating = std::max(all.max_heating, shift.max_heating);
}

}  // namespace

SoakResult run_shift(const NodeSetup& setup, std::uint64_t seed, int tasks) { return Shift(setup, seed).run(tasks); }

SoakResult run_soak(const PlantConfig& plant, double hours, std::uint64_t seed, int threads) {
  const NodeSetup setup(plant);
  const auto shifts = static_cast<std::size_t>(std::ceil(hours * 3600.0 / kShift_s));
  SoakResult all;
  std::mutex mutex;
  JobPool pool(threads, static_cast<int>(shifts), [](int, int, const std::string&) {});
  pool.run(shifts, [&](std::size_t i) {
    const SoakResult result = run_shift(setup, seed * 100000 + i, kTasks);
    const std::lock_guard<std::mutex> lock(mutex);
    add(all, result);
    return std::string("soak");
  });
  return all;
}

std::string print_soak(const SoakResult& result) {
  std::string text = fmt::format(
      "{:.2f} hours, false alarms: {}\nclosest to a limit: gyro and encoder {:.0f} %, voltage {} ticks of 8, heating "
      "{:.0f} %\n",
      result.hours, result.false_trips.size(), 100.0 * result.max_disagreement, result.max_mismatch_ticks,
      100.0 * result.max_heating);
  for (const std::string& trip : result.false_trips) {
    text += trip + "\n";
  }
  return text;
}

}  // namespace trackservo::sim
