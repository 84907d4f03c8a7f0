// Whether a machine can hurt anybody: speed and force at each contact with an end stop, axes that run away, values that
// are not numbers.
#ifndef TRACKSERVO_SIM_ATTACK_MOTION_JUDGE_HPP
#define TRACKSERVO_SIM_ATTACK_MOTION_JUDGE_HPP

#include <array>
#include <optional>

#include "fault_injection/driven_node.hpp"

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
  kNotStopped  // still turns kStopTime_s after the last command that lets it turn
};

constexpr double kOverspeedMargin_rad_s = 0.25;  // what the reaction to an overspeed needs
constexpr double kStopTime_s = 3.0;
constexpr double kTurning_rad_s = 0.1;
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

// Of one run. Call `look` after each tick.
class MotionJudge {
 public:
  explicit MotionJudge(const NodeSetup& setup) : setup_(setup) {}

  void look(const DrivenNode& node, double time_s);

  const Harm& harm() const { return harm_; }

 private:
  void look_at_stops(int axis, const TruthState& truth, double time_s);
  void look_at_speed(int axis, const DrivenNode& node, double rate_rad_s, double time_s);

  const NodeSetup& setup_;
  Harm harm_;
  std::array<bool, kAxes> in_contact_{};
  std::array<double, kAxes> last_rate_rad_s_{};
  std::array<int, kAxes> stop_ticks_{};  // since the last command that lets the axis turn
};

}  // namespace trackservo::sim

#endif
