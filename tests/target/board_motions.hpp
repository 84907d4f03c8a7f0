// SPDX-License-Identifier: Apache-2.0
// Motions in which the tests of the emulated board inject faults at random instants, and the stop that must follow.
#ifndef TRACKSERVO_SIM_EMULATOR_BOARD_MOTIONS_HPP
#define TRACKSERVO_SIM_EMULATOR_BOARD_MOTIONS_HPP

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "board_steps.hpp"
#include "judge/fault_injection/injection_run.hpp"
#include "machine/base/random.hpp"
#include "support/test_size.h"

namespace bench {

constexpr double kStandstill_rad_s = 2e-3;

struct BoardMotion {
  const char *name;
  double speed_rad_s;  // the highest
  bool reverses;       // somewhere between the two directions
  bool flies_by;
};

constexpr BoardMotion kFast = {"20 deg/s", 20.0 * sim::kRadPerDeg, false, false};
constexpr std::array<BoardMotion, 5> kBoardMotions = {{{"standstill", 0.0, false, false},
                                                       {"1 deg/s", 1.0 * sim::kRadPerDeg, false, false},
                                                       kFast,
                                                       {"reversal", 5.0 * sim::kRadPerDeg, true, false},
                                                       {"fly-by", 12.0 * sim::kRadPerDeg, false, true}}};

// Random instants of each fault in each motion on each axis. 0: a sample.
inline int moments() { return by_size(0, 0, 4); }

struct BoardRun {
  const BoardMotion *motion;
  int axis;
  int moment;
};

// The runs of the fault with this number in its list; the sample has one or two, in different motions.
inline std::vector<BoardRun> runs_of(int number, bool on_each_axis) {
  std::vector<BoardRun> runs;
  if (moments() == 0) {
    for (int i = 0; i < by_size(1, 2, 0); ++i) {
      const auto motion = static_cast<std::size_t>(2 * number + 2 + 3 * i) % kBoardMotions.size();
      runs.push_back({&kBoardMotions[motion], on_each_axis ? i : 0, 0});
    }
  }
  for (const BoardMotion& motion : kBoardMotions) {
    for (int axis = 0; axis < (on_each_axis ? sim::kAxes : 1); ++axis) {
      for (int moment = 0; moment < moments(); ++moment) {
        runs.push_back({&motion, axis, moment});
      }
    }
  }
  return runs;
}

// A distance is stated only for calm air.
inline sim::PlantConfig calm_plant() {
  sim::PlantConfig plant = tracker_plant();
  for (sim::AxisConfig& axis : plant.axis) {
    axis.load.wind_mean_nm = 0.0;
    axis.load.wind_gust_rms_nm = 0.0;
  }
  return plant;
}

// Both axes, from standstill with 1 rad/s^2, each kept within a part of its travel.
class Turning {
 public:
  Turning(BoardRig& rig, const BoardMotion& motion) : rig_(rig), motion_(motion) {
    rig_.client.start_node();
    TEST_ASSERT_TRUE(rig_.client.enable(kCyclicVelocity));
    for (std::size_t axis = 0; axis < sim::kAxes; ++axis) {
      face_the_middle(axis);
    }
  }

  void pass(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) {
      time_s_ += sim::kTick_s;
      for (std::size_t axis = 0; axis < sim::kAxes; ++axis) {
        if (std::abs(from_middle_rad(axis)) > kRoom_rad) {
          face_the_middle(axis);
        }
        const double max_rad_s = kRamp_rad_s2 * sim::kTick_s;
        wanted_rad_s_[axis] +=
            std::clamp(direction_[axis] * speed_rad_s() - wanted_rad_s_[axis], -max_rad_s, max_rad_s);
      }
      rig_.client.set_speeds(counts(wanted_rad_s_[0]), counts(wanted_rad_s_[1]));
      rig_.client.pass(1);
    }
  }

  // Up to speed, and on to a random instant between two PWM periods.
  void reach(sim::SplitMix64& random) {
    const auto ramp_ms = static_cast<int>(1e3 * motion_.speed_rad_s / kRamp_rad_s2);
    pass(motion_.flies_by ? 700 + static_cast<int>(800.0 * random.uniform())
                          : ramp_ms + 50 + static_cast<int>(100.0 * random.uniform()));
    for (std::size_t axis = 0; axis < sim::kAxes; ++axis) {
      const double rate_rad_s = rig_.truth().joint_rate_rad_s[axis];
      const double tolerance_rad_s = 0.2 * motion_.speed_rad_s + kStandstill_rad_s;
      TEST_ASSERT_TRUE_MESSAGE(
          std::abs(rate_rad_s - wanted_rad_s_[axis]) <= tolerance_rad_s,
          fmt::format("{}, axis {}: {:.4f} rad/s instead of {:.4f}, error code {:04X}", motion_.name, axis, rate_rad_s,
                      wanted_rad_s_[axis], rig_.client.error_code(static_cast<int>(axis)))
              .c_str());
    }
    if (motion_.reverses) {
      direction_ = {-direction_[0], -direction_[1]};
      pass(static_cast<int>(2.0 * ramp_ms * random.uniform()));
    }
    rig_.machine.run(random.uniform() * sim::kTick_s);
  }

  // From now on the set-points lead to standstill.
  void halt() { halts_ = true; }

 private:
  static constexpr double kRamp_rad_s2 = 1.0;
  static constexpr double kRoom_rad = 30.0 * sim::kRadPerDeg;
  static constexpr std::array<double, sim::kAxes> kMiddle_rad = {0.0, 30.0 * sim::kRadPerDeg};

  static std::int32_t counts(double rate_rad_s) { return static_cast<std::int32_t>(std::lround(1e6 * rate_rad_s)); }

  double from_middle_rad(std::size_t axis) const { return rig_.truth().joint_angle_rad[axis] - kMiddle_rad[axis]; }
  void face_the_middle(std::size_t axis) { direction_[axis] = from_middle_rad(axis) > 0.0 ? -1.0 : 1.0; }

  double speed_rad_s() const {
    if (halts_) {
      return 0.0;
    }
    return motion_.flies_by ? sim::motion_rate_rad_s(sim::Motion::kTracking, time_s_) : motion_.speed_rad_s;
  }

  BoardRig& rig_;
  BoardMotion motion_;
  bool halts_ = false;
  double time_s_ = 0.0;
  std::array<double, sim::kAxes> direction_{};
  std::array<double, sim::kAxes> wanted_rad_s_{};
};

// These axes come to rest within the stated distance of the reaction from `start`, where it began. `pass_ms` lets a
// millisecond pass, at least so many.
template <class Pass>
void expect_to_stop(BoardRig& rig, const std::vector<std::size_t>& axes, const sim::TruthState& start,
                    fault_reaction reaction, int at_least_ms, const std::string& what, Pass pass_ms) {
  constexpr int kLongest_ms = 1000;
  std::array<double, sim::kAxes> travel_rad{};
  bool stands = false;
  for (int i = 0; i < kLongest_ms && (!stands || i < at_least_ms); ++i) {
    pass_ms();
    stands = true;
    const sim::TruthState now = rig.truth();
    for (const std::size_t axis : axes) {
      travel_rad[axis] = std::max(travel_rad[axis], std::abs(now.joint_angle_rad[axis] - start.joint_angle_rad[axis]));
      stands = stands && std::abs(now.joint_rate_rad_s[axis]) < kStandstill_rad_s;
    }
  }
  TEST_ASSERT_TRUE_MESSAGE(stands, what.c_str());
  for (const std::size_t axis : axes) {
    const double promised_rad = sim::promised_travel_rad(reaction, std::abs(start.joint_rate_rad_s[axis]));
    TEST_ASSERT_TRUE_MESSAGE(
        travel_rad[axis] <= promised_rad,
        fmt::format("{}, axis {}: {:.4f} rad of {:.4f}", what, axis, travel_rad[axis], promised_rad).c_str());
  }
}

inline bool has_heard_of_axis(const BoardRig& rig, fault_id fault, int axis) {
  const auto& heard = rig.client.emergencies();
  return std::any_of(heard.begin(), heard.end(), [fault, axis](const auto& emergency) {
    return emergency.code == fault_table[fault].code && emergency.bytes[3] == fault && emergency.bytes[4] == axis + 1;
  });
}

// The first fault that is reported for an axis.
inline fault_id first_fault(const BoardRig& rig, int axis) {
  for (const CanClient::Emergency& emergency : rig.client.emergencies()) {
    if (emergency.code != 0 && emergency.bytes[4] == axis + 1) {
      return static_cast<fault_id>(emergency.bytes[3]);
    }
  }
  return FAULT_NONE;
}

}  // namespace bench

#endif
