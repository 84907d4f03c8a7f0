#include "commissioning/acquisition.hpp"

#include <fmt/format.h>
#include <fmt/os.h>

#include <cmath>
#include <limits>
#include <string>

#include "run/machine.hpp"

namespace trackservo::sim {
namespace {

constexpr int kSettleTicks = 1000;  // at rest before each experiment
constexpr double kRadPerTurn32 = 2.0 * kPi / 4294967296.0;

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
      return "the axis left its travel limit";
    case EXPERIMENT_TOO_FAST:
      return "the axis was faster than its speed limit";
    case EXPERIMENT_TOO_LONG:
      return "it lasted longer than its time limit";
    case EXPERIMENT_DRIVE_STOPPED:
      return "the drive stopped the axis";
    default:
      return "it was aborted";
  }
}

const char *complaint_of(control_status status) {
  return status == CONTROL_INCONSISTENT ? "it does not fit its own limits" : "a value of it is out of range";
}

class Acquisition {
 public:
  Acquisition(const PlantConfig& plant, const servo_params& params, int axis,
              const std::array<double, kAxes>& start_angle_rad, std::uint64_t seed)
      : machine_(plant, params, seed, start_angle_rad),
        axis_(axis),
        torque_constant_nm_a_(static_cast<double>(params.axis[axis].torque_constant_nm_a)),
        angle_rad_(start_angle_rad[static_cast<std::size_t>(axis)]) {
    machine_.command().axis[0].mode = machine_.command().axis[1].mode = SERVO_SPEED;
  }

  void run(const PlannedExperiment& planned) {
    ++run_;
    for (int tick = 0; tick < kSettleTicks; ++tick) {
      advance();
    }
    experiment e{};
    const control_status status = experiment_start(&e, &planned.setup, &planned.limits, samples().motion.joint_angle);
    if (status != CONTROL_OK) {
      throw ExperimentError(
          fmt::format("experiment {} ({}): {}.", run_, name_of(planned.setup.kind), complaint_of(status)));
    }
    while (obey(e)) {
      advance();
      record(planned.setup.kind);
    }
    machine_.command().axis[axis_] = servo_axis_command{};
    machine_.command().axis[axis_].mode = SERVO_SPEED;
    if (e.state != EXPERIMENT_DONE) {
      throw ExperimentError(
          fmt::format("experiment {} ({}): {}.", run_, name_of(planned.setup.kind), reason_of(e.state)));
    }
    recording_.ended.push_back(e);
  }

  Recording take() { return std::move(recording_); }

 private:
  const servo_axis_samples& samples() const { return machine_.samples().axis[axis_]; }

  bool obey(experiment& e) {
    const float joint_rate_rad_s = machine_.firmware(axis_).signals.rates.joint_rate_rad_s;
    return experiment_step(&e, samples().motion.joint_angle, joint_rate_rad_s, &machine_.command().axis[axis_],
                           SERVO_TICK_S);
  }

  void advance() {
    const angle_turn32 before = samples().motion.joint_angle;
    machine_.advance_tick();
    if (ticks_++ > 0) {
      angle_rad_ += kRadPerTurn32 * static_cast<std::int32_t>(samples().motion.joint_angle - before);
    }
  }

  double reference() {
    const servo_axis_command& command = machine_.command().axis[axis_];
    switch (command.mode) {
      case SERVO_TORQUE:
        return static_cast<double>(command.torque_nm);
      case SERVO_POSITION:
        return angle_rad_ + kRadPerTurn32 * static_cast<std::int32_t>(command.position - samples().motion.joint_angle);
      default:
        return static_cast<double>(command.speed.rate_rad_s);
    }
  }

  void record(stimulus_kind kind) {
    const servo_axis_samples& seen = samples();
    const double gyro_rad_s =
        seen.motion.gyro_valid ? static_cast<double>(seen.motion.gyro_rad_s) : std::numeric_limits<double>::quiet_NaN();
    recording_.ticks.push_back({1e-3 * static_cast<double>(ticks_), run_, kind, angle_rad_,
                                static_cast<double>(machine_.firmware(axis_).signals.rates.joint_rate_rad_s),
                                gyro_rad_s, torque_constant_nm_a_ * static_cast<double>(seen.mean_current_a),
                                reference()});
  }

  Machine machine_;
  int axis_;
  double torque_constant_nm_a_;
  double angle_rad_;
  std::int64_t ticks_ = 0;
  int run_ = 0;
  Recording recording_;
};

}  // namespace

Recording run_experiments(const PlantConfig& plant, const servo_params& params, int axis,
                          const std::array<double, kAxes>& start_angle_rad, const std::vector<PlannedExperiment>& plan,
                          std::uint64_t seed) {
  Acquisition acquisition(plant, params, axis, start_angle_rad, seed);
  for (const PlannedExperiment& planned : plan) {
    acquisition.run(planned);
  }
  return acquisition.take();
}

void write_recording(const Recording& recording, const std::filesystem::path& file) {
  try {
    auto out = fmt::output_file(file.string());
    out.print("time_s,run,kind,joint_angle_rad,joint_rate_rad_s,inertial_rate_rad_s,torque_nm,reference\n");
    for (const RecordedTick& t : recording.ticks) {
      out.print("{:.3f},{},{},{:.10g},{:.7g},{},{:.6g},{:.8g}\n", t.time_s, t.run, static_cast<int>(t.kind),
                t.joint_angle_rad, t.joint_rate_rad_s,
                std::isnan(t.inertial_rate_rad_s) ? std::string() : fmt::format("{:.7g}", t.inertial_rate_rad_s),
                t.torque_nm, t.reference);
    }
  } catch (const std::system_error& error) {
    throw std::runtime_error(fmt::format("cannot write {}: {}", file.string(), error.code().message()));
  }
}

}  // namespace trackservo::sim
