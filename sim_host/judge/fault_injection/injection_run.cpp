// SPDX-License-Identifier: Apache-2.0
#include "judge/fault_injection/injection_run.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "judge/fault_injection/braking.hpp"

namespace trackservo::sim {
namespace {

constexpr double kEarliest_s = 0.7;
constexpr double kLatest_s = 1.5;
constexpr int kAsideTicks = 300;      // then an axis that stood still is moved, to make its fault visible
constexpr int kReactionTicks = 2300;  // longer than the shorted motor brakes
constexpr int kBrakeTicks = 1990;
constexpr double kAside_rad_s = 5.0 * kRadPerDeg;
constexpr double kAgain_rad_s = 10.0 * kRadPerDeg;  // after a fault reset, towards the middle of the travel
constexpr double kAgain_rad_s2 = 1.0;
constexpr double kExcitation_rad_s2 = 2.0;
constexpr int kAgainTicks = 400;
constexpr int kResetTicks = 300;  // until the conditions have ended
constexpr double kTurns_rad_s = 0.01;
constexpr int kGustTicks = 5000;

class InjectionRun {
 public:
  InjectionRun(const NodeSetup& setup, const InjectionRunSetup& injection_run)
      : setup_(setup),
        injection_run_(injection_run),
        random_(SplitMix64::mix(injection_run.seed)),
        node_(setup, injection_run.seed, {0.2, 0.4}) {}

  InjectionRunResult run() {
    injection_run_.fault_injection->prepare(node_, injection_run_.axis);
    node_.enable(injection_run_.fault_injection->mode);
    const double share = random_.uniform();
    const int moves = static_cast<int>((kEarliest_s + share * (kLatest_s - kEarliest_s)) / kTick_s);
    for (int i = 0; i < moves; ++i) {
      injection_run_.fault_injection->keep_up(node_, injection_run_.axis);
      tick();
    }
    result_.speed_before_rad_s = std::abs(joint_rate());
    inject();
    InjectionRunResult first = result_;
    for (int i = 0; i < kLaterFaults; ++i) {
      const std::vector<const FaultInjection *>& list = later_fault_injections();
      first.later.push_back({list[random_() % list.size()], nullptr});
      if (!is_enabled_again()) {
        break;
      }
      injection_run_.fault_injection = first.later.back().fault_injection;
      inject();
      first.later.back().result = std::make_shared<InjectionRunResult>(result_);
      if (result_.seen == FAULT_NONE) {
        break;
      }
    }
    return first;
  }

 private:
  void inject() {
    injection_run_.fault_injection->begin(node_, injection_run_.axis, random_);
    excited_ = injection_run_.fault_injection->excitation_rad_s > 0.0;
    excited_from_s_ = time_s_ + 0.5;  // the first reversal, so that the axis moves to both sides
    exciting_rad_s_ = excited_ ? wanted_rate_before_ : 0.0;
    monitor();
    if (result_.seen != FAULT_NONE) {
      injection_run_.fault_injection->end(node_, injection_run_.axis);
      judge_reaction();
      brake();
    }
  }

  // As a technician does: repairs what is broken, resets the fault or restarts the controller, enables both axes and
  // moves them.
  bool is_enabled_again() {
    stop_without_fault();
    repair();
    wait_for_bridges();
    face_the_middle();
    for (int i = 0; i < kResetTicks; ++i) {
      for (int axis = 0; axis < kAxes; ++axis) {
        if (fault(axis) != FAULT_NONE) {
          node_.write(axis, 0x6040, 0, i % 2 == 0 ? 0x00 : 0x80);
        }
      }
      tick();
    }
    wait_for_standstill();
    try {
      node_.enable(DRIVE_CYCLIC_VELOCITY);
    } catch (const std::runtime_error&) {
      return false;
    }
    for (int i = 0; i < kAgainTicks; ++i) {
      tick();
    }
    result_ = {};
    result_.speed_before_rad_s = std::abs(joint_rate());
    return fault(injection_run_.axis) == FAULT_NONE;
  }

  // An axis whose fault was not detected still follows its set-point.
  void stop_without_fault() {
    for (int axis = 0; axis < kAxes; ++axis) {
      if (fault(axis) == FAULT_NONE) {
        node_.write(axis, 0x6040, 0, 0x02);
      }
    }
    const bool turns = fault(kAzimuth) == FAULT_NONE || fault(kPitch) == FAULT_NONE;
    for (int i = 0; i < kResetTicks && turns; ++i) {
      tick();
    }
  }

  void repair() {
    node_.machine().broken() = {};
    node_.speak_again();
    if (injection_run_.fault_injection->needs_restart) {
      node_.restart();
      node_.tick();  // it receives nothing before
    } else {
      undo_writes();
    }
    node_.receive(can_frame{0x000, 0, 2, {0x01, 0x00}, 0});
  }

  // What the injections write to the node.
  void undo_writes() {
    for (int axis = 0; axis < kAxes; ++axis) {
      node_.node().axis[axis].monitor.limits = setup_.limits[static_cast<std::size_t>(axis)];
      node_.node().axis[axis].limits.changes++;
      node_.write(axis, 0x6072, 0, 1000);
    }
    node_.write(kAzimuth, 0x1016, 1, 0);
    node_.write(kAzimuth, 0x1402, 5, 0);
  }

  // An axis that found a fault of both axes late may still be braked.
  void wait_for_bridges() {
    const auto brakes = [this](int axis) { return node_.mode(axis) == SERVO_BRAKE; };
    for (int i = 0; i < kReactionTicks && (brakes(kAzimuth) || brakes(kPitch)); ++i) {
      tick();
    }
  }

  // A gust can turn an axis without torque.
  void wait_for_standstill() {
    const auto turns = [this](int axis) {
      return std::abs(node_.machine().truth().joint_rate_rad_s[static_cast<std::size_t>(axis)]) > kTurns_rad_s;
    };
    for (int i = 0; i < kGustTicks && (turns(kAzimuth) || turns(kPitch)); ++i) {
      tick();
      again_from_s_ = time_s_;
    }
  }

  // Each axis will move towards the middle of its travel.
  void face_the_middle() {
    again_from_s_ = time_s_ + kResetTicks * kTick_s;
    for (int axis = 0; axis < kAxes; ++axis) {
      const double middle_rad = 0.5 * (static_cast<double>(setup_.limits[static_cast<std::size_t>(axis)].minimum_rad) +
                                       static_cast<double>(setup_.limits[static_cast<std::size_t>(axis)].maximum_rad));
      const double angle_rad = node_.machine().truth().joint_angle_rad[static_cast<std::size_t>(axis)];
      again_direction_[static_cast<std::size_t>(axis)] = angle_rad > middle_rad ? -1.0 : 1.0;
    }
    again_ = true;
    aside_ = false;
    excited_ = false;
  }

  // A set-point that reverses with 2 rad/s^2 at most.
  double exciting_rate() {
    const double speed_rad_s = injection_run_.fault_injection->excitation_rad_s;
    const double goal_rad_s = std::fmod(time_s_ - excited_from_s_, 2.0) < 1.0 ? speed_rad_s : -speed_rad_s;
    const double step_rad_s = kExcitation_rad_s2 * kTick_s;
    exciting_rad_s_ += std::clamp(goal_rad_s - exciting_rad_s_, -step_rad_s, step_rad_s);
    return exciting_rad_s_;
  }

  double wanted_rate(int axis) {
    if (excited_ && axis == injection_run_.axis) {
      return exciting_rate();
    }
    if (again_) {
      return again_direction_[static_cast<std::size_t>(axis)] *
             std::clamp(kAgain_rad_s2 * (time_s_ - again_from_s_), 0.0, kAgain_rad_s);
    }
    return aside_ ? kAside_rad_s : motion_rate_rad_s(injection_run_.motion, time_s_);
  }

  double joint_rate() {
    return node_.machine().truth().joint_rate_rad_s[static_cast<std::size_t>(injection_run_.axis)];
  }
  fault_id fault(int axis) const { return node_.axis(axis).drive.fault; }

  void tick() {
    time_s_ += kTick_s;
    for (int axis = 0; axis < kAxes; ++axis) {
      const double rate_rad_s = wanted_rate(axis);
      wanted_rate_before_ = axis == injection_run_.axis ? rate_rad_s : wanted_rate_before_;
      node_.move(axis, rate_rad_s);
    }
    node_.tick();
  }

  void note_speed() {
    const double wanted = std::abs(static_cast<double>(node_.axis(injection_run_.axis).objects.velocity.demand)) * 1e-6;
    const bool closed = servo_mode_closes(node_.mode(injection_run_.axis));
    result_.speed_before_rad_s = std::max(result_.speed_before_rad_s, closed ? wanted : 0.0);
    if (!result_.came_to_rest) {
      result_.speed_most_rad_s = std::max(result_.speed_most_rad_s, std::abs(joint_rate()));
    }
  }

  // Until the firmware has detected it.
  void monitor() {
    const FaultInjection& injected = *injection_run_.fault_injection;
    double led_rad = angle();
    for (int i = 0; i < injected.monitored_ticks && result_.seen == FAULT_NONE; ++i) {
      aside_ = injection_run_.motion == Motion::kStandstill && i >= kAsideTicks && !injected.stays && !again_;
      const bool shows = injection_run_.fault_injection->shows(node_, injection_run_.axis);
      result_.showed = result_.showed || shows;
      if (injection_run_.fault_injection->lasting && !shows) {
        result_.latency_ms = 0;
      }
      had_torque_ = node_.mode(injection_run_.axis) != SERVO_OFF;
      injected.go_on(node_, injection_run_.axis);
      tick();
      note_speed();
      led_rad += static_cast<double>(node_.axis(injection_run_.axis).objects.velocity.demand) * 1e-6 * kTick_s;
      result_.deviation_rad = std::max(result_.deviation_rad, std::abs(angle() - led_rad));
      result_.latency_ms += shows || (result_.showed && !injection_run_.fault_injection->lasting) ? 1 : 0;
      result_.visible_ms = std::max(result_.visible_ms, result_.latency_ms);
      result_.seen = injected.during == FAULT_NONE ? fault(injection_run_.axis) : fault_during_reaction();
    }
  }

  // Of those that are right, the one that the drive reports beside the fault that it reacts to.
  fault_id fault_during_reaction() {
    const fault_set right = right_faults(*injection_run_.fault_injection);
    return fault_worst(node_.axis(injection_run_.axis).drive.faults & right);
  }

  void judge_reaction() {
    const servo_mode mode = node_.mode(injection_run_.axis);
    const auto reaction = static_cast<fault_reaction>(fault_table[result_.seen].reaction);
    switch (had_torque_ ? reaction : REACTION_CUT) {
      case REACTION_CUT:
        result_.reaction_right = mode == SERVO_OFF;
        break;
      case REACTION_PROTECT:
        result_.reaction_right = mode == SERVO_PROTECTIVE_STOP;
        break;
      case REACTION_BRAKE:
        result_.reaction_right = mode == SERVO_BRAKE;
        break;
      default:
        result_.reaction_right = servo_mode_closes(mode);
    }
    // A monitor of this axis may detect a common cause first; the other axis then has the rest of the allowed time.
    const FaultInjection& injected = *injection_run_.fault_injection;
    const int other = kAxes - 1 - injection_run_.axis;
    result_.other_axis_right = (fault(other) != FAULT_NONE) == injected.both_axes;
    other_has_ms_ =
        injected.both_axes && result_.seen != injected.expected ? allowed_latency_ms(injected) - result_.latency_ms : 0;
  }

  void brake() {
    Braking braking(angle());
    int braked_ticks = 1;
    // In wind a gust moves an axis without torque: no speed can be guaranteed then.
    const bool holds = fault_table[result_.seen].reaction == REACTION_STOP && !injection_run_.fault_injection->weak;
    const bool judged = injection_run_.calm || holds;
    const int other = kAxes - 1 - injection_run_.axis;
    // A second monitor that sees the same cause can turn a stop into the shorted motor, which lasts longer.
    for (int i = 0; i < kReactionTicks || (i < 2 * kReactionTicks && node_.mode(injection_run_.axis) == SERVO_BRAKE);
         ++i) {
      (void)braking.step(node_.machine().truth(), injection_run_.axis);
      result_.came_to_rest = braking.at_rest();
      result_.travel_rad = std::abs(braking.travel_rad());
      tick();
      if (judged) {
        note_speed();
      }
      braked_ticks += node_.mode(injection_run_.axis) == SERVO_BRAKE ? 1 : 0;
      if (i < other_has_ms_ && (right_faults(*injection_run_.fault_injection) >> fault(other) & 1U) != 0) {
        result_.other_axis_right = true;
      }
    }
    const bool shorts = had_torque_ && fault_table[result_.seen].reaction == REACTION_BRAKE;
    const bool shorted = shorts ? braked_ticks >= kBrakeTicks : had_torque_ || braked_ticks == 1;
    const bool over = node_.axis(injection_run_.axis).drive.state.power == DRIVE_FAULT &&
                      node_.mode(injection_run_.axis) == SERVO_OFF;
    const fault_id during = injection_run_.fault_injection->during;
    const fault_id first = during == FAULT_NONE ? result_.seen : during;
    result_.reaction_right = result_.reaction_right && shorted && over && fault(injection_run_.axis) == first;
  }

  double angle() { return node_.machine().truth().joint_angle_rad[static_cast<std::size_t>(injection_run_.axis)]; }

  const NodeSetup& setup_;
  InjectionRunSetup injection_run_;
  SplitMix64 random_;
  DrivenNode node_;
  InjectionRunResult result_;
  double time_s_ = 0;
  bool aside_ = false;
  bool again_ = false;  // after a fault reset
  bool excited_ = false;
  double excited_from_s_ = 0;
  double exciting_rad_s_ = 0;
  double wanted_rate_before_ = 0;
  double again_from_s_ = 0;
  std::array<double, kAxes> again_direction_{};
  int other_has_ms_ = 0;
  bool had_torque_ =
      false;  // in the tick before the detection; an axis without torque gets none, whatever the table says
};

}  // namespace

InjectionRunResult run_injection_run(const NodeSetup& setup, const InjectionRunSetup& injection_run) {
  return InjectionRun(setup, injection_run).run();
}

}  // namespace trackservo::sim
