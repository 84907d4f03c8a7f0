// SPDX-License-Identifier: Apache-2.0
#include "design/commissioning/acquisition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <string>

#include "machine/run/machine.hpp"

namespace trackservo::sim {
namespace {

constexpr double kRadPerTurn32 = 2.0 * kPi / 4294967296.0;
constexpr double kRampTime_s = 0.3;   // from rest to the speed between two places
constexpr int kSettleTicks = 300;     // at rest after a move
constexpr int kRestTicks = 100;       // at rest before each experiment
constexpr double kStrayShare = 0.05;  // share of its travel: an experiment may begin this far from its place
constexpr double kMovePatience_s = 10.0;

const char *name_of(stimulus_kind kind) {
  switch (kind) {
    case STIMULUS_SWEEP:
      return "speed sweep";
    case STIMULUS_TORQUE_RAMPS:
      return "torque ramps";
    case STIMULUS_HYSTERESIS:
      return "hysteresis loops";
    case STIMULUS_CHIRP:
      return "chirp";
    case STIMULUS_BREAKAWAY:
      return "break-away";
    case STIMULUS_NONE:
    default:
      return "unknown experiment";
  }
}

const char *reason_of(experiment_state state) {
  switch (state) {
    case EXPERIMENT_LEFT_TRAVEL:
      return "the axis exceeded its travel limit";
    case EXPERIMENT_TOO_FAST:
      return "the axis exceeded its speed limit";
    case EXPERIMENT_TOO_LONG:
      return "it exceeded its time limit";
    case EXPERIMENT_DRIVE_STOPPED:
      return "the drive stopped the axis";
    default:
      return "it was aborted";
  }
}

const char *error_of(control_status status) {
  return status == CONTROL_INCONSISTENT ? "it does not fit its own limits" : "one of its values is out of range";
}

// Where wind is stronger than friction, the axis does not stay where a break-away leaves it. This does no harm.
bool swept_away(const experiment& e) {
  return e.setup.kind == STIMULUS_BREAKAWAY && (e.state == EXPERIMENT_LEFT_TRAVEL || e.state == EXPERIMENT_TOO_FAST);
}

// The axis moving to a place: on a speed ramp, with a braking ramp that ends there.
class Move {
 public:
  Move(double place_rad, double speed_rad_s) : place_rad_(place_rad), speed_rad_s_(speed_rad_s) {}

  // The set-point of this tick [rad/s].
  double rate_rad_s(double angle_rad) {
    const double acceleration_rad_s2 = speed_rad_s_ / kRampTime_s;
    const double remaining_rad = place_rad_ - angle_rad;
    if (std::abs(remaining_rad) < 0.01 * speed_rad_s_) {
      there_ = true;
    }
    const double braking_rad_s = std::sqrt(acceleration_rad_s2 * std::abs(remaining_rad));
    const double requirement_rad_s = there_ ? 0.0 : std::copysign(std::min(speed_rad_s_, braking_rad_s), remaining_rad);
    const double step_rad_s = acceleration_rad_s2 * kTick_s;
    rate_rad_s_ += std::clamp(requirement_rad_s - rate_rad_s_, -step_rad_s, step_rad_s);
    return rate_rad_s_;
  }

  bool there() const { return there_; }

 private:
  double place_rad_;
  double speed_rad_s_;
  double rate_rad_s_ = 0;
  bool there_ = false;
};

class Bench {
 public:
  explicit Bench(const AcquisitionSetup& setup)
      : axis_(setup.axis),
        machine_(*setup.plant, setup.params, setup.seed, setup.start_angle_rad),
        board_(machine_.board()),
        angle_rad_(setup.start_angle_rad[static_cast<std::size_t>(setup.axis)]) {
    machine_.on_tick([this](servo_board& /*board*/) { tick(); });
    for (int axis = 0; axis < kAxes; ++axis) {  // the other axis stays where it is
      servo_axis_command& command = board_.command.axis[axis];
      command.mode = SERVO_POSITION;
      command.position = board_.samples.axis[axis].sensors.joint_angle_turn32;
    }
    last_angle_ = board_.samples.axis[axis_].sensors.joint_angle_turn32;
  }

  void move_to(double place_rad, double speed_rad_s) {
    begin(STIMULUS_SWEEP);
    Move move(place_rad, speed_rad_s);
    // The function is called by advance_tick() below only.
    // cppcheck-suppress danglingLifetime
    deciding_ = [&move](Bench& bench) {
      bench.stand();
      bench.command().speed.rate_rad_s = static_cast<float>(move.rate_rad_s(bench.angle_rad_));
    };
    const double patience_s = kMovePatience_s + 3.0 * std::abs(place_rad - angle_rad_) / speed_rad_s;
    for (int ticks = 0; !move.there(); ++ticks) {
      if (ticks * kTick_s > patience_s) {
        throw ExperimentError(
            fmt::format("{} does not reach {:.1f} deg, it is at {:.1f} deg: friction or load exceeds its motor torque.",
                        axis_name(axis_), place_rad * kDegPerRad, angle_rad_ * kDegPerRad));
      }
      machine_.advance_tick();
    }
    rest(kSettleTicks);
  }

  // A sweep does not end at its start angle.
  void return_to(double place_rad, double speed_rad_s, double travel_rad) {
    if (std::abs(angle_rad_ - place_rad) > kStrayShare * travel_rad) {
      move_to(place_rad, speed_rad_s);
    }
  }

  void perform(const stimulus_setup& setup, const experiment_limits& limits) {
    deciding_ = [](Bench& bench) { bench.stand(); };
    rest(kRestTicks);
    begin(setup.kind);
    const control_status status = experiment_start(&experiment_, &setup, &limits, last_angle_);
    if (status != CONTROL_OK) {
      throw ExperimentError(fmt::format("{}, experiment {} ({}): {}.", axis_name(axis_), result_.ended.size() + 1,
                                        name_of(setup.kind), error_of(status)));
    }
    bool running = true;
    // cppcheck-suppress danglingLifetime; called by advance_tick() below only
    deciding_ = [&running](Bench& bench) { running = bench.step_experiment(); };
    while (running) {
      machine_.advance_tick();
    }
    if (experiment_.state != EXPERIMENT_DONE && !swept_away(experiment_)) {
      throw ExperimentError(fmt::format("{}, experiment {} ({}) at {:.1f} deg: {}.", axis_name(axis_),
                                        result_.ended.size() + 1, name_of(setup.kind), angle_rad_ * kDegPerRad,
                                        reason_of(experiment_.state)));
    }
    result_.ended.push_back(experiment_);
  }

  Acquisition take() { return std::move(result_); }

 private:
  // The firmware's tick, and a record of its inputs and outputs.
  void tick() {
    servo_board_sample(&board_);
    const angle_turn32 angle = board_.samples.axis[axis_].sensors.joint_angle_turn32;
    angle_rad_ += kRadPerTurn32 * static_cast<double>(static_cast<std::int32_t>(angle - last_angle_));
    last_angle_ = angle;
    deciding_(*this);
    servo_board_control(&board_);
    record();
  }

  servo_axis_command& command() { return board_.command.axis[axis_]; }

  void stand() {
    command() = {};
    command().mode = SERVO_SPEED;
  }

  bool step_experiment() {
    const float joint_rate_rad_s = board_.app.axis[axis_].signals.rates.joint_rate_rad_s;
    if (experiment_step(&experiment_, last_angle_, joint_rate_rad_s, &command(), SERVO_TICK_S)) {
      return true;
    }
    begin(STIMULUS_SWEEP);
    stand();
    return false;
  }

  double reference() {
    switch (command().mode) {
      case SERVO_TORQUE:
        return static_cast<double>(command().torque_nm);
      case SERVO_POSITION:
        return angle_rad_ + kRadPerTurn32 * static_cast<std::int32_t>(command().position - last_angle_);
      default:
        return static_cast<double>(command().speed.rate_rad_s);
    }
  }

  void record() {
    const servo_axis_samples& seen = board_.samples.axis[axis_];
    const double torque_constant_nm_a = static_cast<double>(board_.app.params.axis[axis_].torque_constant_nm_a);
    identification::Recording& recording = result_.recording;
    recording.time_s.push_back(kTick_s * static_cast<double>(recording.ticks()));
    recording.run.push_back(run_);
    recording.kind.push_back(static_cast<identification::RunKind>(kind_));
    recording.joint_angle_rad.push_back(angle_rad_);
    recording.joint_rate_rad_s.push_back(static_cast<double>(board_.app.axis[axis_].signals.rates.joint_rate_rad_s));
    recording.inertial_rate_rad_s.push_back(seen.sensors.gyro_valid ? static_cast<double>(seen.sensors.gyro_rad_s)
                                                                    : std::numeric_limits<double>::quiet_NaN());
    recording.torque_nm.push_back(torque_constant_nm_a * static_cast<double>(seen.sensors.mean_current_a));
    recording.reference.push_back(reference());
  }

  // The direction of the last decision.
  void rest(int ticks) {
    for (int tick = 0; tick < ticks; ++tick) {
      machine_.advance_tick();
    }
  }

  // Motion outside the experiments is a sweep: at the speed of a move, or at rest.
  void begin(stimulus_kind kind) {
    ++run_;
    kind_ = kind;
  }

  int axis_;
  Machine machine_;
  servo_board& board_;
  experiment experiment_{};
  std::function<void(Bench&)> deciding_ = [](Bench&) {};
  Acquisition result_;
  int run_ = 0;
  stimulus_kind kind_ = STIMULUS_SWEEP;
  double angle_rad_;
  angle_turn32 last_angle_ = 0;
};

}  // namespace

Acquisition acquire(const AcquisitionSetup& setup, const commissioning::TestPlan& test_plan) {
  Bench bench(setup);
  for (const commissioning::Place& place : test_plan.places) {
    bench.move_to(place.angle_rad, test_plan.moving_rad_s);
    for (const stimulus_setup& experiment : place.experiments) {
      bench.return_to(place.angle_rad, test_plan.moving_rad_s, static_cast<double>(test_plan.limits.travel_rad));
      bench.perform(experiment, test_plan.limits);
    }
  }
  return bench.take();
}

}  // namespace trackservo::sim
