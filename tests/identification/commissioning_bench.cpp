#include "commissioning_bench.hpp"

#include <fmt/format.h>
#include <fmt/os.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "experiments/control_design.hpp"

namespace commissioning {

namespace {

constexpr double kRadPerTurn32 = 2.0 * sim::kPi / 4294967296.0;

std::array<double, sim::kAxes> start_angles(const BenchSetup& setup, const Programme& programme) {
  std::array<double, sim::kAxes> angles{0.0, setup.pitch_rad};
  angles[static_cast<std::size_t>(setup.axis)] = programme.places.front().angle_rad;
  return angles;
}

class Bench {
 public:
  Bench(const BenchSetup& setup, const Programme& programme)
      : setup_(setup),
        programme_(programme),
        machine_(setup.plant, setup.seed, start_angles(setup, programme)),
        angle_rad_(programme.places.front().angle_rad) {
    servo_params params =
        sim::design_controller(setup.plant, sim::controller_spec(setup.controller), {setup.seed, 0.15, TRACKER_PI});
    if (servo_board_start(&board_, machine_.hal_pointer(), &params) != CONTROL_OK) {
      throw std::invalid_argument("the firmware refuses the design");
    }
    machine_.run_firmware(board_, [this] { tick(); });
    for (int axis = 0; axis < sim::kAxes; ++axis) {  // the other axis stays where it is
      servo_axis_command& command = board_.command.axis[axis];
      command.mode = SERVO_POSITION;
      command.position = board_.samples.axis[axis].motion.joint_angle;
    }
    last_angle_ = board_.samples.axis[setup.axis].motion.joint_angle;
  }

  identification::Recording run() {
    for (const Place& place : programme_.places) {
      move_to(place.angle_rad);
      for (const stimulus_setup& experiment : place.experiments) {
        perform(experiment);
      }
    }
    return std::move(recording_);
  }

 private:
  // The firmware's tick with a look at what it saw and did.
  void tick() {
    servo_board_sample(&board_);
    const servo_axis_samples& samples = board_.samples.axis[setup_.axis];
    angle_rad_ +=
        static_cast<double>(static_cast<std::int32_t>(samples.motion.joint_angle - last_angle_)) * kRadPerTurn32;
    last_angle_ = samples.motion.joint_angle;
    decide(samples.motion.joint_angle);
    servo_board_control(&board_);
    const servo_axis& axis = board_.app.axis[setup_.axis];
    recording_.time_s.push_back(static_cast<double>(recording_.ticks()) * 1e-3);
    recording_.run.push_back(run_);
    recording_.kind.push_back(kind_);
    recording_.joint_angle_rad.push_back(angle_rad_);
    recording_.joint_rate_rad_s.push_back(static_cast<double>(axis.signals.rates.joint_rate_rad_s));
    recording_.inertial_rate_rad_s.push_back(setup_.gyro_recorded && samples.motion.gyro_valid
                                                 ? static_cast<double>(samples.motion.gyro_rad_s)
                                                 : std::numeric_limits<double>::quiet_NaN());
    const double constant = static_cast<double>(board_.app.params.axis[setup_.axis].torque_constant_nm_a);
    recording_.torque_nm.push_back(constant * static_cast<double>(samples.mean_current_a));
    recording_.reference.push_back(reference());
  }

  void decide(angle_turn32 angle) {
    servo_axis_command& command = board_.command.axis[setup_.axis];
    if (moving_) {
      command = {};
      command.mode = SERVO_SPEED;
      command.speed.rate_rad_s = static_cast<float>(moving_rate_rad_s_);
    } else {
      const float rate = board_.app.axis[setup_.axis].signals.rates.joint_rate_rad_s;
      running_ = experiment_step(&experiment_, angle, rate, &command, SERVO_TICK_S);
      if (!running_) {
        command = {};
        command.mode = SERVO_SPEED;
      }
    }
  }

  double reference() const {
    const servo_axis_command& command = board_.command.axis[setup_.axis];
    switch (command.mode) {
      case SERVO_POSITION:
        return static_cast<double>(angle_difference_rad(command.position, experiment_.stimulus.start_angle));
      case SERVO_TORQUE:
        return static_cast<double>(command.torque_nm);
      default:
        return static_cast<double>(command.speed.rate_rad_s);
    }
  }

  void move_to(double place_rad) {
    begin(identification::RunKind::kSpeedSweep);
    moving_ = true;
    const double acceleration = programme_.moving_rad_s / 0.3;
    while (true) {
      const double way_rad = place_rad - angle_rad_;
      const double wish =
          std::copysign(std::min(programme_.moving_rad_s, std::sqrt(1.0 * acceleration * std::abs(way_rad))), way_rad);
      moving_rate_rad_s_ += std::clamp(wish - moving_rate_rad_s_, -acceleration * 1e-3, acceleration * 1e-3);
      if (std::abs(way_rad) < 0.01 * programme_.moving_rad_s) {
        break;
      }
      machine_.advance_tick();
    }
    moving_rate_rad_s_ = 0;
    for (int i = 0; i < 300; ++i) {
      machine_.advance_tick();
    }
    moving_ = false;
  }

  void perform(const stimulus_setup& setup) {
    if (experiment_start(&experiment_, &setup, &programme_.limits, last_angle_) != CONTROL_OK) {
      throw std::invalid_argument(fmt::format("the firmware refuses an experiment of kind {}", int(setup.kind)));
    }
    begin(static_cast<identification::RunKind>(setup.kind));
    running_ = true;
    while (running_) {
      machine_.advance_tick();
    }
    if (experiment_.state != EXPERIMENT_DONE) {
      throw std::runtime_error(
          fmt::format("experiment of kind {} ended in state {}", int(setup.kind), int(experiment_.state)));
    }
  }

  void begin(identification::RunKind kind) {
    ++run_;
    kind_ = kind;
  }

  const BenchSetup& setup_;
  const Programme& programme_;
  sim::Machine machine_;
  servo_board board_{};
  experiment experiment_{};
  identification::Recording recording_;
  int run_ = 0;
  identification::RunKind kind_ = identification::RunKind::kSpeedSweep;
  bool moving_ = false;
  bool running_ = false;
  double moving_rate_rad_s_ = 0;
  double angle_rad_;
  angle_turn32 last_angle_ = 0;
};

}  // namespace

RoughMachine rough_machine(const sim::PlantConfig& plant, int axis, double pitch_rad) {
  const sim::AxisConfig& config = plant.axis[static_cast<std::size_t>(axis)];
  RoughMachine machine;
  machine.coulomb_nm = config.friction.positive.coulomb_nm;
  machine.bristle_rad = machine.coulomb_nm / config.friction.stiffness_nm_rad;
  machine.stribeck_rad_s = config.friction.positive.stribeck_speed_rad_s;
  machine.inertia_kg_m2 = sim::axis_inertia_kg_m2(plant, axis, pitch_rad);
  machine.torque_nm = config.motor.torque_constant_nm_a * config.motor.current_limit_a;
  machine.lowest_rad = config.end_stops ? config.end_stops->lower_rad : -sim::kPi;
  machine.highest_rad = config.end_stops ? config.end_stops->upper_rad : sim::kPi;
  return machine;
}

namespace {

// Speeds from `low` on, each in both directions for `dwell_s`.
stimulus_setup sweep(double low_rad_s, double ratio, std::uint32_t count, double dwell_s, double acceleration_rad_s2) {
  stimulus_setup setup{};
  setup.kind = STIMULUS_SWEEP;
  setup.low_rad_s = static_cast<float>(low_rad_s);
  setup.speed_ratio = static_cast<float>(ratio);
  setup.count = count;
  setup.dwell_s = static_cast<float>(dwell_s);
  setup.acceleration_rad_s2 = static_cast<float>(acceleration_rad_s2);
  return setup;
}

// Triangles over three bristle lengths to each side, slow beside the resonance of the axis on its bristles.
stimulus_setup loops(const RoughMachine& machine) {
  const double resonance_rad_s = std::sqrt(machine.coulomb_nm / machine.bristle_rad / machine.inertia_kg_m2);
  stimulus_setup setup{};
  setup.kind = STIMULUS_HYSTERESIS;
  setup.dwell_s = static_cast<float>(std::max(0.7, 3.0 * 2.0 * sim::kPi / resonance_rad_s));
  setup.count = static_cast<std::uint32_t>(std::max(3.0, std::ceil(9.0 / static_cast<double>(setup.dwell_s))));
  setup.amplitude_rad = static_cast<float>(3.0 * machine.bristle_rad);
  return setup;
}

stimulus_setup chirp(const RoughMachine& machine, double acceleration_rad_s2) {
  stimulus_setup setup{};
  setup.kind = STIMULUS_CHIRP;
  setup.low_rad_s = static_cast<float>(3.0 * machine.stribeck_rad_s);
  setup.count = 1;
  setup.dwell_s = 5.0F;
  setup.amplitude_nm = static_cast<float>(machine.coulomb_nm);
  setup.low_hz = 1.0F;
  setup.high_hz = 40.0F;
  setup.acceleration_rad_s2 = static_cast<float>(acceleration_rad_s2);
  return setup;
}

}  // namespace

Programme programme_for(const RoughMachine& machine) {
  constexpr int kPlaces = 8;
  constexpr double kOctave = 1.6;
  constexpr double kShortest_s = 0.4;
  const double kFastest_rad_s = 20 * kRadPerDeg;
  const double low = std::max(machine.lowest_rad + 20 * kRadPerDeg, -170 * kRadPerDeg);
  const double high = std::min(machine.highest_rad - 20 * kRadPerDeg, 170 * kRadPerDeg);
  const double acceleration = 0.4 * machine.torque_nm / machine.inertia_kg_m2;

  // A speed needs three bristle lengths until it slides steadily. Where that takes long, few places must do.
  std::vector<stimulus_setup> slow;
  double slow_s = 0;
  double speed =
      (3.0 * machine.bristle_rad / kShortest_s > machine.stribeck_rad_s ? 0.5 : 0.15) * machine.stribeck_rad_s;
  for (; 3.0 * machine.bristle_rad / speed > kShortest_s; speed *= kOctave) {
    slow.push_back(sweep(speed, 1.0, 1, 3.0 * machine.bristle_rad / speed, acceleration));
    slow_s += 6.0 * machine.bristle_rad / speed;
  }
  const auto octaves =
      static_cast<std::uint32_t>(std::max(1.0, std::ceil(std::log(kFastest_rad_s / speed) / std::log(kOctave))));

  Programme programme;
  programme.moving_rad_s = 15 * kRadPerDeg;
  programme.limits = {2.9F, 2.0F, static_cast<float>(machine.torque_nm), 3600.0F};
  for (int i = 0; i < kPlaces; ++i) {
    // Not evenly spaced: no harmonic of the motor shall look the same at all places.
    const double share = (i + 0.35 * std::sin(2.4 * i)) / (kPlaces - 1 + 0.35 * std::sin(2.4 * (kPlaces - 1)));
    Place place{low + (high - low) * share, {}};
    if (slow_s < 15.0 || i == 2 || i == 5) {
      place.experiments = slow;
    }
    place.experiments.push_back(sweep(speed, kOctave, octaves, kShortest_s, acceleration));
    for (int repeat = 0; repeat < 3; ++repeat) {
      place.experiments.push_back(sweep(0.3 * kFastest_rad_s, 1.45, 4, 0.3, acceleration));
    }
    place.experiments.push_back(loops(machine));
    place.experiments.push_back(chirp(machine, acceleration));
    programme.places.push_back(place);
  }
  return programme;
}

identification::Recording record(const BenchSetup& setup, const Programme& programme) {
  return Bench(setup, programme).run();
}

void write_csv(const identification::Recording& recording, const std::string& path) {
  auto file = fmt::output_file(path);
  file.print("{}\n", identification::kRecordingHeader);
  for (std::size_t i = 0; i < recording.ticks(); ++i) {
    file.print("{:.3f},{},{},{:.10g},{:.7g},{:.7g},{:.7g},{:.7g}\n", recording.time_s[i], recording.run[i],
               static_cast<int>(recording.kind[i]), recording.joint_angle_rad[i], recording.joint_rate_rad_s[i],
               recording.inertial_rate_rad_s[i], recording.torque_nm[i], recording.reference[i]);
  }
}

}  // namespace commissioning
