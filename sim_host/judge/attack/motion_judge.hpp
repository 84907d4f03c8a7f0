// SPDX-License-Identifier: Apache-2.0
// Whether a machine can hurt anybody: speed and force at each contact with an end stop, axes that run away, values that
// are not numbers.
#ifndef TRACKSERVO_SIM_ATTACK_MOTION_JUDGE_HPP
#define TRACKSERVO_SIM_ATTACK_MOTION_JUDGE_HPP

#include <array>
#include <optional>

#include "device/driven_node.hpp"

namespace trackservo::sim {

// The worst contact of an axis with an end stop.
struct EndStopContacts {
  int count = 0;
  double speed_rad_s = 0;   // of the joint as it reaches the stop
  double energy_j = 0;      // of the axis at that speed
  double torque_nm = 0;     // of the stop
  double first_time_s = 0;  // of the fastest contact
};

enum class Runaway {
  kNone,
  kTooFast,    // faster than 2060:1 plus kOverspeedMargin_rad_s
  kNotStopped  // still turns kStopTime_s after the last command that lets it turn; see kTurning_rad_s
};

constexpr double kOverspeedMargin_rad_s = 0.25;  // what the reaction to an overspeed needs

// An axis that no command has let turn for kStopTime_s may turn faster than kTurning_rad_s only for so long and so far,
// summed up since it was enabled last: an enabled axis that a gust or a change of gains pushes gets back to rest, while
// one that oscillates or creeps on uses this up. Ticks in which the motor acts against the motion with all the torque
// that the master permits do not count, when this is less than the motor has: wind turns an axis that may not use its
// torque, and the drive is not what moves it. The limits of speed and contacts hold for such an axis, too.
constexpr double kStopTime_s = 3.0;
constexpr double kTurning_rad_s = 0.1;
constexpr double kTurningTime_s = 0.3;
constexpr double kTurningPath_rad = 2.0 * kRadPerDeg;

// In profile and cyclic modes of a rate or a position the master lets an axis turn in the direction of 60FF (in csv
// with 60B1), or while 607A is not reached, and the axis is not halted. Otherwise, as in mode -1 below, only the rest
// of a motion does, whose set-point does not rise.
//
// In mode -1 a target lets an axis turn, as docs/can.md says: while 3072:5 (:6) is 2 to 4, a frame has counted
// (3072:1), and found a target (3071:6), and not longer ago than 2011:5. The time in which the target is expected back
// (3075:1) or the azimuth turns back (3075:3) does not count, up to kLongestAbsence_s. Without a target only the rest
// of a motion lets the axis turn, whose set-point does not rise; or, with 2011:6, the way back to where the mode began.
constexpr double kLongestAbsence_s = 15.0;
constexpr double kContactLimit_rad_s = 5.0 * kRadPerDeg;

struct AxisHarm {
  EndStopContacts contacts;
  double max_rate_rad_s = 0;
  Runaway runaway = Runaway::kNone;
  double runaway_time_s = 0;
};

struct Harm {
  std::array<AxisHarm, kAxes> axis;
  bool not_finite = false;

  bool hits_hard() const;
  bool runs_away() const;
};

// Without holding brakes an axis that came to rest without power is moved by the wind alone: neither its contacts nor
// its motion count until it has power again, and has been at rest with it, or has had it for kTakesOver_s: who turns it
// on shortly before the end stop has not moved it there. Slower than this an axis is at rest.
constexpr double kCameToRest_rad_s = 0.02;
constexpr double kTakesOver_s = 0.3;

// Of one run. Call `look` after each tick.
class MotionJudge {
 public:
  explicit MotionJudge(const NodeSetup& setup, bool brakes = true) : setup_(setup), brakes_(brakes) {}

  void look(const DrivenNode& node, double time_s);

  const Harm& harm() const { return harm_; }

 private:
  // The frames that have counted, as the bus can read it.
  struct Frames {
    std::uint32_t taken = 0;    // 3072:1
    bool found = false;         // a target, ever
    double since_s = 0;         // the last one that found a target, without the time in which it is expected back
    double since_absent_s = 0;  // with it
  };

  // An axis in operation that nothing commands to turn.
  struct Rest {
    int ticks = 0;
    double min_rad_s = 0;  // smallest set-point in them
  };

  // Of an axis in mode -1.
  struct Tracking {
    double coast_s = 0;    // longest 2011:5 of both axes since the mode began
    double start_rad = 0;  // where the mode began
  };

  struct Standstill {
    int ticks = 0;               // since the last command that lets the axis turn
    bool closed = false;         // a loop was closed in the last tick
    int turning_ticks = 0;       // that count, see kTurning_rad_s
    double path_rad = 0;         // in them
    double reference_rad_s = 0;  // magnitude of the rate that the loop followed in the last tick
  };

  void look_at_frames(const DrivenNode& node);
  bool target_may_turn(const DrivenNode& node, int axis);
  bool returns(const DrivenNode& node, int axis, double angle_rad) const;
  bool set_point_rises(int axis, double set_point_rad_s);
  bool demands_standstill(const DrivenNode& node, int axis);
  void look_at_power(int axis, const DrivenNode& node, double rate_rad_s);
  void look_at_stops(int axis, const TruthState& truth, double time_s);
  void look_at_standstill(int axis, const DrivenNode& node, double rate_rad_s);
  void look_at_speed(int axis, const DrivenNode& node, double rate_rad_s, double time_s);

  const NodeSetup& setup_;
  bool brakes_;
  Harm harm_;
  std::array<bool, kAxes> counts_{};
  std::array<int, kAxes> powered_ticks_{};
  std::array<bool, kAxes> in_contact_{};
  std::array<double, kAxes> last_rate_rad_s_{};
  std::array<Standstill, kAxes> still_{};
  Frames frames_{};
  std::array<Rest, kAxes> rest_{};
  std::array<Tracking, kAxes> tracking_{};
};

}  // namespace trackservo::sim

#endif
