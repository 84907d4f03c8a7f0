#include "fault_injection/trial.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {
namespace {

constexpr double kEarliest_s = 0.7;
constexpr double kLatest_s = 1.5;
constexpr int kWatchedTicks = 1500;   // for a reaction
constexpr int kAsideTicks = 300;      // then an axis that stood still is moved, to make its fault visible
constexpr int kReactionTicks = 2300;  // longer than the shorted motor brakes
constexpr int kBrakeTicks = 1990;
constexpr double kStandstill_rad_s = 2e-3;
constexpr double kAside_rad_s = 5.0 * kPi / 180.0;

class Trial {
 public:
  Trial(const NodeSetup& setup, const TrialSetup& trial)
      : trial_(trial), random_(SplitMix64::mix(trial.seed)), node_(setup, trial.seed, {0.2, 0.4}) {}

  TrialResult run() {
    trial_.breakage->prepare(node_, trial_.axis);
    node_.enable(trial_.breakage->mode);
    const double share = random_.uniform();
    const int moves = static_cast<int>((kEarliest_s + share * (kLatest_s - kEarliest_s)) / kTick_s);
    for (int i = 0; i < moves; ++i) {
      trial_.breakage->keep_up(node_, trial_.axis);
      tick();
    }
    result_.speed_before_rad_s = std::abs(joint_rate());
    trial_.breakage->begin(node_, trial_.axis, random_);
    watch();
    if (result_.seen != FAULT_NONE) {
      trial_.breakage->end(node_, trial_.axis);
      judge_reaction();
      brake();
    }
    return result_;
  }

 private:
  double joint_rate() { return node_.machine().truth().joint_rate_rad_s[static_cast<std::size_t>(trial_.axis)]; }
  fault_id fault(int axis) const { return node_.axis(axis).drive.fault; }

  void tick() {
    time_s_ += kTick_s;
    for (int axis = 0; axis < kAxes; ++axis) {
      node_.move(axis, aside_ ? kAside_rad_s : motion_rate_rad_s(trial_.motion, time_s_));
    }
    node_.tick();
  }

  void note_speed() {
    const double wanted = std::abs(static_cast<double>(node_.axis(trial_.axis).objects.velocity.demand)) * 1e-6;
    const bool closed = servo_mode_closes(node_.mode(trial_.axis));
    result_.speed_before_rad_s = std::max(result_.speed_before_rad_s, closed ? wanted : 0.0);
    if (!result_.came_to_rest) {
      result_.speed_most_rad_s = std::max(result_.speed_most_rad_s, std::abs(joint_rate()));
    }
  }

  // Until the firmware has detected it.
  void watch() {
    for (int i = 0; i < kWatchedTicks && result_.seen == FAULT_NONE; ++i) {
      aside_ = trial_.motion == Motion::kStandstill && i >= kAsideTicks;
      const bool shows = trial_.breakage->shows(node_, trial_.axis);
      result_.showed = result_.showed || shows;
      if (trial_.breakage->lasting && !shows) {
        result_.latency_ms = 0;
      }
      had_torque_ = node_.mode(trial_.axis) != SERVO_OFF;
      tick();
      note_speed();
      result_.latency_ms += shows || (result_.showed && !trial_.breakage->lasting) ? 1 : 0;
      result_.seen = fault(trial_.axis);
    }
  }

  void judge_reaction() {
    const servo_mode mode = node_.mode(trial_.axis);
    const auto reaction = static_cast<fault_reaction>(fault_table[result_.seen].reaction);
    switch (had_torque_ ? reaction : REACTION_CUT) {
      case REACTION_CUT:
        result_.reaction_right = mode == SERVO_OFF;
        break;
      case REACTION_BRAKE:
        result_.reaction_right = mode == SERVO_BRAKE;
        break;
      default:
        result_.reaction_right = servo_mode_closes(mode);
    }
    const int other = kAxes - 1 - trial_.axis;
    result_.other_axis_right = (fault(other) != FAULT_NONE) == trial_.breakage->both_axes;
  }

  void brake() {
    const double start_rad = angle();
    int braked_ticks = 1;
    // In wind a gust moves an axis without torque: no speed can be guaranteed then.
    const bool holds = fault_table[result_.seen].reaction == REACTION_STOP && !trial_.breakage->weak;
    const bool judged = trial_.calm || holds;
    for (int i = 0; i < kReactionTicks; ++i) {
      if (!result_.came_to_rest) {
        result_.came_to_rest = std::abs(joint_rate()) < kStandstill_rad_s;
        result_.travel_rad = std::abs(angle() - start_rad);
      }
      tick();
      if (judged) {
        note_speed();
      }
      braked_ticks += node_.mode(trial_.axis) == SERVO_BRAKE ? 1 : 0;
    }
    const bool shorts = had_torque_ && fault_table[result_.seen].reaction == REACTION_BRAKE;
    const bool shorted = shorts ? braked_ticks >= kBrakeTicks : had_torque_ || braked_ticks == 1;
    const bool over = node_.axis(trial_.axis).drive.state.power == DRIVE_FAULT && node_.mode(trial_.axis) == SERVO_OFF;
    result_.reaction_right = result_.reaction_right && shorted && over && fault(trial_.axis) == result_.seen;
  }

  double angle() { return node_.machine().truth().joint_angle_rad[static_cast<std::size_t>(trial_.axis)]; }

  TrialSetup trial_;
  SplitMix64 random_;
  DrivenNode node_;
  TrialResult result_;
  double time_s_ = 0;
  bool aside_ = false;
  bool had_torque_ =
      false;  // in the tick before the detection; an axis without torque gets none, whatever the table says
};

}  // namespace

TrialResult run_trial(const NodeSetup& setup, const TrialSetup& trial) { return Trial(setup, trial).run(); }

}  // namespace trackservo::sim
