#include "attack/motion_judge.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {
namespace {

constexpr double kAtRest_rad_s = 0.01;  // of a set-point that demands standstill

// The set-point that the firmware itself follows demands no motion, or no loop follows one.
bool demands_standstill(const DrivenNode& node, int axis) {
  if (node.axis(axis).drive.state.action != DRIVE_RUN) {
    return true;
  }
  const servo_axis& servo = node.machine().firmware(axis);
  const bool follows_rate = servo.mode == SERVO_SPEED || servo.mode == SERVO_POSITION;
  return follows_rate && std::abs(static_cast<double>(servo.signals.reference.rate_rad_s)) < kAtRest_rad_s;
}

bool is_finite(const servo_axis& servo) {
  const speed_loop_rates& rates = servo.signals.rates;
  return std::isfinite(servo.commanded_nm) && std::isfinite(servo.current_reference_a) &&
         std::isfinite(rates.rate_rad_s) && std::isfinite(servo.signals.reference.rate_rad_s);
}

}  // namespace

bool Harm::hits_hard() const {
  return std::any_of(axis.begin(), axis.end(),
                     [](const AxisHarm& one) { return one.contacts.speed_rad_s > kContactLimit_rad_s; });
}

bool Harm::runs_away() const {
  return std::any_of(axis.begin(), axis.end(), [](const AxisHarm& one) { return one.runaway != Runaway::kNone; });
}

void MotionJudge::look_at_stops(int axis, const TruthState& truth, double time_s) {
  const auto i = static_cast<std::size_t>(axis);
  const std::optional<EndStopConfig>& stop = setup_.plant.axis[i].end_stops;
  if (!stop) {
    return;
  }
  const double angle_rad = truth.joint_angle_rad[i];
  const bool touches = angle_rad < stop->lower_rad || angle_rad > stop->upper_rad;
  EndStopContacts& contacts = harm_.axis[i].contacts;
  if (touches && !in_contact_[i]) {
    // The stop acts within a tick: the faster of the speeds before and after it.
    const double speed_rad_s = std::max(std::abs(last_rate_rad_s_[i]), std::abs(truth.joint_rate_rad_s[i]));
    contacts.count++;
    if (speed_rad_s > contacts.speed_rad_s) {
      contacts.speed_rad_s = speed_rad_s;
      contacts.first_time_s = time_s;
      contacts.energy_j =
          0.5 * axis_inertia_kg_m2(setup_.plant, axis, truth.joint_angle_rad[kPitch]) * speed_rad_s * speed_rad_s;
    }
  }
  in_contact_[i] = touches;
  if (touches) {
    contacts.torque_nm = std::max(contacts.torque_nm, std::abs(truth.end_stop_torque_nm[i]));
  }
}

void MotionJudge::look_at_speed(int axis, const DrivenNode& node, double rate_rad_s, double time_s) {
  const auto i = static_cast<std::size_t>(axis);
  AxisHarm& harm = harm_.axis[i];
  harm.max_rate_rad_s = std::max(harm.max_rate_rad_s, std::abs(rate_rad_s));
  stop_ticks_[i] = demands_standstill(node, axis) ? stop_ticks_[i] + 1 : 0;
  const double limit_rad_s = static_cast<double>(setup_.limits[i].overspeed_rad_s) + kOverspeedMargin_rad_s;
  Runaway found = Runaway::kNone;
  if (std::abs(rate_rad_s) > limit_rad_s) {
    found = Runaway::kTooFast;
  } else if (stop_ticks_[i] * kTick_s > kStopTime_s && std::abs(rate_rad_s) > kTurning_rad_s) {
    found = Runaway::kNotStopped;
  }
  if (harm.runaway == Runaway::kNone && found != Runaway::kNone) {
    harm.runaway = found;
    harm.runaway_time_s = time_s;
  }
}

void MotionJudge::look(const DrivenNode& node, double time_s) {
  const TruthState truth = node.machine().truth();
  for (int axis = 0; axis < kAxes; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    look_at_stops(axis, truth, time_s);
    look_at_speed(axis, node, truth.joint_rate_rad_s[i], time_s);
    harm_.not_finite = harm_.not_finite || !is_finite(node.machine().firmware(axis)) ||
                       !std::isfinite(truth.joint_rate_rad_s[i]) || !std::isfinite(truth.joint_angle_rad[i]);
    last_rate_rad_s_[i] = truth.joint_rate_rad_s[i];
  }
}

}  // namespace trackservo::sim
