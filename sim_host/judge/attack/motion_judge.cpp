// SPDX-License-Identifier: Apache-2.0
#include "judge/attack/motion_judge.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {
namespace {

constexpr double kAtRest_rad_s = 0.01;  // of a set-point that demands standstill
constexpr int kReached = 10'000;        // counts between 607A and 6064: 1 mrad
constexpr double kEqual_nm = 1e-3;
constexpr int kEntryTicks = 2;  // in which a stop begins at the set-point before

// The set-point that the firmware follows. The speed that comes with a position counts, too: a slow position loop may
// follow it later.
double set_point_rad_s(const DrivenNode& node, int axis) {
  const float reference_rad_s = node.machine().firmware(axis).signals.reference.rate_rad_s;
  const float command_rad_s = node.node().board.command.axis[axis].speed.rate_rad_s;
  return static_cast<double>(std::max(std::abs(reference_rad_s), std::abs(command_rad_s)));
}

// A set-point in the direction of the rate that the master has written; one of 0 has any.
bool is_towards(const DrivenNode& node, int axis, std::int64_t target_counts) {
  const float reference_rad_s = node.machine().firmware(axis).signals.reference.rate_rad_s;
  return target_counts != 0 && static_cast<double>(reference_rad_s) * static_cast<double>(target_counts) >= 0.0;
}

// What the master has written lets the axis turn, whatever the firmware makes of it. Homing and experiments choose
// their own set-points.
bool master_lets_turn(const DrivenNode& node, int axis) {
  const drive_objects& objects = node.axis(axis).objects;
  if ((objects.state.controlword & DRIVE_CONTROL_HALT) != 0) {
    return false;
  }
  switch (node.axis(axis).drive.motion.mode) {
    case DRIVE_PROFILE_VELOCITY:
      return is_towards(node, axis, objects.velocity.target);
    case DRIVE_CYCLIC_VELOCITY:
      return is_towards(node, axis, std::int64_t{objects.velocity.target} + objects.velocity.offset);
    case DRIVE_PROFILE_POSITION:
    case DRIVE_CYCLIC_POSITION:
      return std::abs(static_cast<std::int64_t>(objects.position.target) - objects.position.actual) > kReached;
    default:
      return true;
  }
}

// The motor acts against the motion, with all the torque that the master permits (6072, 60E0, 60E1), which is less than
// the motor has. So what turns the axis comes from outside, and the drive takes energy from it. Below the rate at which
// an axis turns this is told only of one that may use no torque at all.
bool brakes_as_permitted(const DrivenNode& node, int axis, double rate_rad_s) {
  const servo_board& board = node.node().board;
  const servo_axis_command& command = board.command.axis[axis];
  const servo_axis_params& params = board.app.params.axis[axis];
  if (!servo_mode_closes(board.app.axis[axis].mode) || !command.torque_limited) {
    return false;
  }
  const auto commanded_nm = static_cast<double>(board.app.axis[axis].commanded_nm);
  const auto permitted_nm =
      static_cast<double>(rate_rad_s > 0.0 ? -command.limits.minimum_nm : command.limits.maximum_nm);
  const auto motor_nm = static_cast<double>(params.current_limit_a * params.torque_constant_nm_a);
  const double against_nm = rate_rad_s > 0.0 ? -commanded_nm : commanded_nm;
  if (std::abs(rate_rad_s) <= (permitted_nm < kEqual_nm ? kCameToRest_rad_s : kTurning_rad_s)) {
    return false;
  }
  return permitted_nm < motor_nm - kEqual_nm && against_nm > permitted_nm - kEqual_nm;
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

void MotionJudge::look_at_frames(const DrivenNode& node) {
  const camera_objects& camera = node.node().tracking.objects;
  const bool counts = camera.taken != frames_.taken;
  frames_.taken = camera.taken;
  if (counts && camera.message.quality >= camera.params.min_quality) {
    frames_ = {camera.taken, true, 0.0, 0.0};
    return;
  }
  const bool expected = camera.back_in_ms != 0 || camera.wrap_state == CAMERA_TURNS_BACK;
  frames_.since_s += expected ? 0.0 : kTick_s;
  frames_.since_absent_s += kTick_s;
}

static int tracking_state(const DrivenNode& node, int axis) {
  const camera_objects& camera = node.node().tracking.objects;
  return axis == kAzimuth ? camera.azimuth_tracking : camera.pitch_tracking;
}

// The frames let the axis turn, and the node says that it follows them.
bool MotionJudge::target_may_turn(const DrivenNode& node, int axis) {
  const int state = tracking_state(node, axis);
  double& coast_s = tracking_[static_cast<std::size_t>(axis)].coast_s;
  for (int i = 0; i < kAxes; ++i) {
    coast_s = std::max(coast_s, static_cast<double>(node.axis(i).tuning.active.tracking_loop.coast_s));
  }
  const bool follows = state >= DRIVE_ACQUIRING && state <= DRIVE_COASTING;
  return follows && frames_.found && frames_.since_s <= coast_s &&
         frames_.since_absent_s <= coast_s + kLongestAbsence_s;
}

// The target is lost, and the axis turns towards where it began to track.
bool MotionJudge::returns(const DrivenNode& node, int axis, double angle_rad) const {
  const auto i = static_cast<std::size_t>(axis);
  const bool may = frames_.found && node.axis(axis).tuning.active.tracking_loop.at_loss == TARGET_LOSS_RETURN;
  const double rate_rad_s = static_cast<double>(node.machine().firmware(axis).signals.reference.rate_rad_s);
  return may && tracking_state(node, axis) == DRIVE_TARGET_LOST &&
         rate_rad_s * (tracking_[i].start_rad - angle_rad) > 0;
}

// One tick in which nothing commands the axis to turn.
bool MotionJudge::set_point_rises(int axis, double set_point_rad_s) {
  Rest& rest = rest_[static_cast<std::size_t>(axis)];
  const bool begins = ++rest.ticks <= kEntryTicks;
  const bool rises = !begins && set_point_rad_s > rest.min_rad_s + kAtRest_rad_s;
  rest.min_rad_s = begins ? set_point_rad_s : std::min(rest.min_rad_s, set_point_rad_s);
  return rises;
}

// Nothing lets the axis turn, or no loop follows a set-point.
bool MotionJudge::demands_standstill(const DrivenNode& node, int axis) {
  const auto i = static_cast<std::size_t>(axis);
  const drive_axis& drive = node.axis(axis).drive;
  const double angle_rad = node.machine().truth().joint_angle_rad[i];
  const bool runs = drive.state.action == DRIVE_RUN;
  const bool tracks = runs && drive.motion.mode == DRIVE_TRACKING;
  if (!tracks) {
    tracking_[i] = {};
    tracking_[i].start_rad = angle_rad;
  }
  const servo_mode mode = node.machine().firmware(axis).mode;
  if (!runs || (!tracks && mode != SERVO_SPEED && mode != SERVO_POSITION)) {
    rest_[i] = {};
    return !runs;
  }
  const double wanted_rad_s = set_point_rad_s(node, axis);
  const bool commanded =
      tracks ? target_may_turn(node, axis) || returns(node, axis, angle_rad) : master_lets_turn(node, axis);
  if (commanded) {
    rest_[i] = {};
    return !tracks && wanted_rad_s < kAtRest_rad_s;
  }
  const bool follows = tracks && drive.motion.followed != nullptr;
  return set_point_rises(axis, wanted_rad_s) || follows || wanted_rad_s < kAtRest_rad_s;
}

void MotionJudge::look_at_power(int axis, const DrivenNode& node, double rate_rad_s) {
  bool& counts = counts_[static_cast<std::size_t>(axis)];
  int& powered_ticks = powered_ticks_[static_cast<std::size_t>(axis)];
  const bool rests = std::abs(rate_rad_s) <= kCameToRest_rad_s;
  powered_ticks = node.machine().firmware(axis).mode != SERVO_OFF ? powered_ticks + 1 : 0;
  const bool takes_over = powered_ticks > 0 && (rests || powered_ticks * kTick_s > kTakesOver_s);
  counts = brakes_ || takes_over || (counts && (powered_ticks > 0 || !rests));
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
  if (touches && !in_contact_[i] && counts_[i]) {
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

void MotionJudge::look_at_standstill(int axis, const DrivenNode& node, double rate_rad_s) {
  const auto i = static_cast<std::size_t>(axis);
  Standstill& still = still_[i];
  const bool closed = servo_mode_closes(node.machine().firmware(axis).mode);
  // A set-point and a stop in neighbouring ticks: the stop's ramp begins at the set-point, which let the axis turn.
  const double reference_rad_s =
      std::abs(static_cast<double>(node.machine().firmware(axis).signals.reference.rate_rad_s));
  const bool rests = rest_[i].ticks > kEntryTicks;
  const bool commanded = !rests && reference_rad_s > still.reference_rad_s + kAtRest_rad_s;
  const bool demanded = demands_standstill(node, axis) && !commanded && counts_[i];
  still.reference_rad_s = reference_rad_s;
  still.ticks = demanded ? still.ticks + 1 : 0;
  if (!demanded || (closed && !still.closed)) {
    still.turning_ticks = 0;
    still.path_rad = 0.0;
  }
  still.closed = closed;
  const bool turns = std::abs(rate_rad_s) > kTurning_rad_s;
  if (brakes_as_permitted(node, axis, rate_rad_s)) {
    still.ticks = 0;  // what turns it from outside lets it turn until it may brake with all its torque
  } else if (still.ticks * kTick_s > kStopTime_s && turns) {
    still.turning_ticks++;
    still.path_rad += std::abs(rate_rad_s) * kTick_s;
  }
}

void MotionJudge::look_at_speed(int axis, const DrivenNode& node, double rate_rad_s, double time_s) {
  const auto i = static_cast<std::size_t>(axis);
  AxisHarm& harm = harm_.axis[i];
  harm.max_rate_rad_s = std::max(harm.max_rate_rad_s, std::abs(rate_rad_s));
  look_at_standstill(axis, node, rate_rad_s);
  const double limit_rad_s = static_cast<double>(setup_.limits[i].overspeed_rad_s) + kOverspeedMargin_rad_s;
  Runaway found = Runaway::kNone;
  if (std::abs(rate_rad_s) > limit_rad_s) {
    found = Runaway::kTooFast;
  } else if (still_[i].turning_ticks * kTick_s > kTurningTime_s || still_[i].path_rad > kTurningPath_rad) {
    found = Runaway::kNotStopped;
  }
  if (harm.runaway == Runaway::kNone && found != Runaway::kNone) {
    harm.runaway = found;
    harm.runaway_time_s = time_s;
  }
}

void MotionJudge::look(const DrivenNode& node, double time_s) {
  const TruthState truth = node.machine().truth();
  look_at_frames(node);
  for (int axis = 0; axis < kAxes; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    look_at_power(axis, node, truth.joint_rate_rad_s[i]);
    look_at_stops(axis, truth, time_s);
    look_at_speed(axis, node, truth.joint_rate_rad_s[i], time_s);
    harm_.not_finite = harm_.not_finite || !is_finite(node.machine().firmware(axis)) ||
                       !std::isfinite(truth.joint_rate_rad_s[i]) || !std::isfinite(truth.joint_angle_rad[i]);
    last_rate_rad_s_[i] = truth.joint_rate_rad_s[i];
  }
}

}  // namespace trackservo::sim
