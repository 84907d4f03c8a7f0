// SPDX-License-Identifier: Apache-2.0
#include "machine/run/demand.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "machine/plant/base_spectrum.hpp"
#include "machine/run/scenario_check.hpp"

namespace trackservo::sim {
namespace {

constexpr double kSigmas = 3.0;
constexpr int kWeakMotor = 4;  // loads: break-away and Coulomb torque of both directions, wind, gusts ...

// Collects the demands on one axis.
class Demands {
 public:
  Demands(const PlantConfig& plant, const ScenarioConfig& scenario, int axis, double reference_rad_s)
      : plant_(plant),
        axis_(plant.axis[static_cast<std::size_t>(axis)]),
        design_(plant.design[static_cast<std::size_t>(axis)]),
        name_(axis_name(axis)),
        is_azimuth_(axis == kAzimuth),
        available_nm_(available_torque_nm(plant, axis)),
        reference_rad_s_(reference_rad_s),
        inertia_kg_m2_(axis_inertia_kg_m2(plant, axis, scenario.initial_joint_angle_rad[kPitch])),
        time_s_(std::max(scenario.settle_s > 0.0 ? scenario.settle_s : scenario.duration_s - scenario.rest_s, kTick_s)),
        angle_rad_(scenario.initial_joint_angle_rad[static_cast<std::size_t>(axis)]) {}

  std::vector<Demand> all() {
    add_friction();
    add_loads();
    add_motor();
    add_currents();
    add_rates();
    add_inertia();
    add_requirements();
    std::stable_sort(demands_.begin(), demands_.end(),
                     [](const Demand& a, const Demand& b) { return a.share > b.share; });
    if (torques_too_large_ >= kWeakMotor) {
      demands_.insert(demands_.begin(), weak_motor());
    }
    return demands_;
  }

 private:
  // The value is in the file's unit, and its effect is proportional to it.
  void add(const std::string& key, double value, double share, const std::string& reason) {
    const double limit = share > 0.0 ? std::abs(value) / share : 0.0;
    demands_.push_back({key, fmt::format("{:g} {}", value, reason), fmt::format("give at most {:.3g}", limit), share});
  }

  std::string on_axis(const char *key) const { return name_ + "." + key; }

  // The limit of the motor's torque, as written in the file.
  std::string motor_text() const {
    const MotorConfig& motor = axis_.motor;
    const std::string limit =
        is_stall_limited()
            ? fmt::format("resistance_ohm = {:g}, supply.voltage_v = {:g}, supply.source_resistance_ohm = {:g}",
                          motor.resistance_ohm, plant_.supply.voltage_v, plant_.supply.source_resistance_ohm)
            : fmt::format("current_limit_a = {:g}", motor.current_limit_a);
    return fmt::format("the motor gives {:.3g} Nm ({}.motor.torque_constant_nm_a = {:g}, {})", available_nm_, name_,
                       motor.torque_constant_nm_a, limit);
  }

  void add_torque(const std::string& key, double value, double torque_nm, const char *verb = "takes") {
    if (torque_nm > 0.0) {
      torques_too_large_ += torque_nm > available_nm_ ? 1 : 0;
      largest_torque_ = torque_nm > largest_torque_.torque_nm ? Torque{key, value, torque_nm} : largest_torque_;
      add(key, value, torque_nm / available_nm_, fmt::format("{} {:.3g} Nm, but {}", verb, torque_nm, motor_text()));
    }
  }

  // With this many loads above the motor's torque the motor is wrong, not the loads.
  Demand weak_motor() const {
    const MotorConfig& motor = axis_.motor;
    const double share = largest_torque_.torque_nm / available_nm_;
    const std::string reason = fmt::format("{}, but {} = {:g} takes {:.3g} Nm", motor_text(), largest_torque_.key,
                                           largest_torque_.value, largest_torque_.torque_nm);
    if (is_stall_limited()) {
      return {on_axis("motor.resistance_ohm"), reason,
              fmt::format("give at most {:.3g}, or raise supply.voltage_v", motor.resistance_ohm / share), share};
    }
    return {on_axis("motor.torque_constant_nm_a"), reason,
            fmt::format("give at least {:.3g}, or raise current_limit_a to at least {:.3g}",
                        motor.torque_constant_nm_a * share, motor.current_limit_a * share),
            share};
  }

  double stall_a() const {
    return plant_.supply.voltage_v / (axis_.motor.resistance_ohm + plant_.supply.source_resistance_ohm);
  }

  bool is_stall_limited() const { return stall_a() < axis_.motor.current_limit_a; }

  double friction_level() const { return 1.0 + axis_.friction.eccentricity_once + axis_.friction.eccentricity_twice; }

  void add_direction(const char *direction, const StribeckConfig& s) {
    const auto key = [&](const char *which) { return fmt::format("{}.friction.{}.{}", name_, direction, which); };
    add_torque(key("breakaway_nm"), s.breakaway_nm, friction_level() * s.breakaway_nm);
    add_torque(key("coulomb_nm"), s.coulomb_nm, friction_level() * s.coulomb_nm);
    add_torque(key("viscous_nm_s_rad"), s.viscous_nm_s_rad, s.viscous_nm_s_rad * reference_rad_s_);
  }

  void add_friction() {
    if (plant_.friction_model == FrictionModel::kNone) {
      return;
    }
    add_direction("positive", axis_.friction.positive);
    add_direction("negative", axis_.friction.negative);
    add_torque(on_axis("friction.damping_nm_s_rad"), axis_.friction.damping_nm_s_rad,
               axis_.friction.damping_nm_s_rad * reference_rad_s_);
    if (plant_.friction_model == FrictionModel::kMaxwellSlip) {
      add_drift();
    }
  }

  void add_drift() {
    const MaxwellSlipConfig& m = plant_.maxwell_slip;
    const double coulomb_nm = friction_level() * axis_.friction.positive.coulomb_nm;
    const double load_nm = axis_.friction.positive.coulomb_nm + std::abs(axis_.load.wind_mean_nm);
    add_torque("maxwell_slip.level_per_load_1_nm", m.level_per_load_1_nm, m.level_per_load_1_nm * load_nm * coulomb_nm,
               "adds");
    const double drift_k =
        std::abs(m.temperature_start_k) > std::abs(m.temperature_end_k) ? m.temperature_start_k : m.temperature_end_k;
    const std::string warm = fmt::format("with temperature_start_k = {:g} and temperature_end_k = {:g}",
                                         m.temperature_start_k, m.temperature_end_k);
    add_torque("maxwell_slip.level_per_k", m.level_per_k, coulomb_nm * (std::exp(m.level_per_k * drift_k) - 1.0),
               (warm + " adds").c_str());
    add_torque(
        "maxwell_slip.viscosity_per_k", m.viscosity_per_k,
        axis_.friction.positive.viscous_nm_s_rad * reference_rad_s_ * (std::exp(m.viscosity_per_k * drift_k) - 1.0),
        (warm + " adds").c_str());
  }

  void add_loads() {
    const LoadConfig& load = axis_.load;
    const double lever = is_azimuth_ ? std::sin(plant_.base_tilt.tilt_rad) : 1.0;
    add_torque(on_axis("load.wind_mean_nm"), load.wind_mean_nm, std::abs(load.wind_mean_nm));
    add_torque(on_axis("load.wind_gust_rms_nm"), load.wind_gust_rms_nm, kSigmas * load.wind_gust_rms_nm);
    add_torque(on_axis("load.imbalance_nm"), load.imbalance_nm, std::abs(lever) * load.imbalance_nm);
    add_torque(
        on_axis("load.cable_stiffness_nm_rad"), load.cable_stiffness_nm_rad,
        load.cable_stiffness_nm_rad * (std::abs(angle_rad_ - load.cable_neutral_rad) + reference_rad_s_ * time_s_));
    add_torque(on_axis("load.broadband_rms_nm"), load.broadband_rms_nm, kSigmas * load.broadband_rms_nm);
    for (std::size_t i = 0; i < axis_.motor.cogging.size(); ++i) {
      add_torque(fmt::format("{}.motor.cogging[{}].amplitude_nm", name_, i), axis_.motor.cogging[i].amplitude_nm,
                 axis_.motor.cogging[i].amplitude_nm);
    }
    const double sway_rad_s = 2.0 * kPi * axis_.base_sway.frequency_hz;
    add_torque(on_axis("base_sway.rms_urad"), 1e6 * axis_.base_sway.rms_rad,
               kSigmas * inertia_kg_m2_ * sway_rad_s * sway_rad_s * axis_.base_sway.rms_rad);
  }

  // Voltage needed for the friction current, at standstill and with the changes that the speed loop requires.
  void add_motor() {
    const MotorConfig& motor = axis_.motor;
    const double current_a = axis_.friction.positive.coulomb_nm / motor.torque_constant_nm_a;
    const double loop_rad_s =
        design_.speed_loop_natural_frequency_rad_s.value_or(2.0 * kPi * design_.speed_loop_bandwidth_hz.value_or(30.0));
    const auto add_voltage = [&](const char *key, double value, double voltage_v) {
      add(on_axis(key), value, voltage_v / plant_.supply.voltage_v,
          fmt::format("takes {:.3g} V of the supply's {:g} V (supply.voltage_v)", voltage_v, plant_.supply.voltage_v));
    };
    add_voltage("motor.inductance_mh", 1e3 * motor.inductance_h, motor.inductance_h * current_a * loop_rad_s);
    add_voltage("motor.back_emf_constant_v_s_rad", motor.back_emf_constant_v_s_rad,
                motor.back_emf_constant_v_s_rad * reference_rad_s_);
  }

  void add_currents() {
    const double kt = axis_.motor.torque_constant_nm_a;
    add_torque("adc.current_offset_a", plant_.adc.current_offset_a, kt * std::abs(plant_.adc.current_offset_a),
               "causes an apparent torque of");
    add_torque("adc.current_noise_rms_a", plant_.adc.current_noise_rms_a, kSigmas * kt * plant_.adc.current_noise_rms_a,
               "causes an apparent torque of");
  }

  void add_rate(const char *key, double value, double rate_rad_s) {
    add(on_axis(key), value, rate_rad_s / reference_rad_s_,
        fmt::format("causes a rate error of {:.3g} deg/s at a set-point of {:.3g} deg/s", kDegPerRad * rate_rad_s,
                    kDegPerRad * reference_rad_s_));
  }

  void add_rates() {
    const EncoderConfig& encoder = axis_.encoder;
    const GyroConfig& gyro = axis_.gyro;
    const double readings = std::sqrt(2.0 / encoder.reads_per_tick);
    const double step_rad = 2.0 * kPi / std::pow(2.0, encoder.resolution_bits);
    const double step_rate_rad_s = step_rad * readings / std::sqrt(12.0) / kTick_s;
    demands_.push_back(
        {on_axis("encoder.resolution_bits"),
         fmt::format("{} causes {:.3g} deg/s of noise at a set-point of {:.3g} deg/s", encoder.resolution_bits,
                     kDegPerRad * step_rate_rad_s, kDegPerRad * reference_rad_s_),
         fmt::format("give at least {:.0f}",
                     std::min(32.0, encoder.resolution_bits +
                                        std::ceil(std::log2(std::max(1.0, step_rate_rad_s / reference_rad_s_))))),
         step_rate_rad_s / reference_rad_s_});
    add_rate("encoder.jitter_rms_urad", 1e6 * encoder.jitter_rms_rad, encoder.jitter_rms_rad * readings / kTick_s);
    add_rate("encoder.eccentricity_urad", 1e6 * encoder.eccentricity_rad, encoder.eccentricity_rad * reference_rad_s_);
    add_rate("gyro.noise_density_deg_s_rthz", kDegPerRad * gyro.noise_density_rad_s_rthz,
             gyro.noise_density_rad_s_rthz * std::sqrt(0.5 * kPi * gyro.bandwidth_hz));
    add_rate("gyro.bias_deg_s", kDegPerRad * gyro.bias_rad_s, std::abs(gyro.bias_rad_s));
    add_rate("gyro.scale_error_ppm", 1e6 * gyro.scale_error, std::abs(gyro.scale_error) * reference_rad_s_);
    for (std::size_t i = 0; i < plant_.base_motion.size(); ++i) {
      const BaseMotionLine& line = plant_.base_motion[i];
      const double rate_rad_s = 2.0 * kPi * line.frequency_hz * line.amplitude_rad;
      add(fmt::format("base_motion[{}].amplitude_deg", i), kDegPerRad * line.amplitude_rad,
          rate_rad_s / reference_rad_s_,
          fmt::format("with frequency_hz = {:g} turns the base at {:.3g} deg/s, at a set-point of {:.3g} deg/s",
                      line.frequency_hz, kDegPerRad * rate_rad_s, kDegPerRad * reference_rad_s_));
    }
    add_base_spectra();
    add_rate("base_sway.rms_urad", 1e6 * axis_.base_sway.rms_rad,
             kSigmas * 2.0 * kPi * axis_.base_sway.frequency_hz * axis_.base_sway.rms_rad);
    demands_.push_back({on_axis("gyro.bandwidth_hz"),
                        fmt::format("{:g} is below the crossover of the fused rates, {:g} Hz", gyro.bandwidth_hz,
                                    design_.fusion_crossover_hz),
                        fmt::format("give at least {:.3g}", design_.fusion_crossover_hz),
                        design_.fusion_crossover_hz / gyro.bandwidth_hz});
  }

  void add_base_spectra() {
    for (std::size_t i = 0; i < plant_.base_spectrum.size(); ++i) {
      PlantConfig alone;
      alone.base_spectrum = {plant_.base_spectrum[i]};
      const double rate_rad_s = fastest_base_rate_rad_s(alone);
      add(fmt::format("base_spectrum[{}].rms_deg", i), kDegPerRad * plant_.base_spectrum[i].rms_rad,
          rate_rad_s / reference_rad_s_,
          fmt::format("turns the base at up to {:.3g} deg/s, at a set-point of {:.3g} deg/s", kDegPerRad * rate_rad_s,
                      kDegPerRad * reference_rad_s_));
    }
  }

  // Too much to be accelerated in the time, or so little that friction unknown to the design moves it within a tick.
  void add_inertia() {
    const double slow = inertia_kg_m2_ * reference_rad_s_ / available_nm_ / time_s_;
    add(on_axis("inertia_kg_m2"), axis_.inertia_kg_m2, slow,
        fmt::format("takes {:.3g} s to accelerate, and {}", slow * time_s_, motor_text()));
    const StribeckConfig& s = axis_.friction.positive;
    const double jump_rad_s = (s.breakaway_nm - s.coulomb_nm + 0.15 * s.coulomb_nm) * kTick_s / inertia_kg_m2_;
    if (plant_.friction_model != FrictionModel::kNone) {
      demands_.push_back(
          {on_axis("inertia_kg_m2"),
           fmt::format("{:g} changes speed by {:.3g} deg/s within a tick of 1 ms when the seal breaks away",
                       axis_.inertia_kg_m2, kDegPerRad * jump_rad_s),
           fmt::format("give at least {:.3g}, or less friction (friction.positive.breakaway_nm = {:g})",
                       axis_.inertia_kg_m2 * jump_rad_s / reference_rad_s_, s.breakaway_nm),
           jump_rad_s / reference_rad_s_});
    }
  }

  void add_requirements() {
    const bool is_bandwidth = design_.speed_loop_bandwidth_hz.has_value();
    const double loop_rad_s = is_bandwidth ? 2.0 * kPi * *design_.speed_loop_bandwidth_hz
                                           : design_.speed_loop_natural_frequency_rad_s.value_or(1.0);
    const double value = is_bandwidth ? *design_.speed_loop_bandwidth_hz : loop_rad_s;
    const double share = 3.0 / loop_rad_s / time_s_;
    demands_.push_back(
        {"design." + name_ + (is_bandwidth ? ".speed_loop_bandwidth_hz" : ".speed_loop_natural_frequency_rad_s"),
         fmt::format("{:g} takes about {:.3g} s to settle, but the scenario allows {:.3g} s", value, 3.0 / loop_rad_s,
                     time_s_),
         fmt::format("give at least {:.3g}", value * share), share});
  }

  const PlantConfig& plant_;
  const AxisConfig& axis_;
  const DesignConfig& design_;
  std::string name_;
  bool is_azimuth_;
  double available_nm_;
  double reference_rad_s_;
  double inertia_kg_m2_;
  double time_s_;
  double angle_rad_;
  struct Torque {
    std::string key;
    double value = 0;
    double torque_nm = 0;
  };

  std::vector<Demand> demands_;
  int torques_too_large_ = 0;
  Torque largest_torque_;
};

}  // namespace

std::vector<Demand> demands_on(const PlantConfig& plant, const ScenarioConfig& scenario, int axis,
                               double reference_rad_s) {
  return Demands(plant, scenario, axis, reference_rad_s).all();
}

}  // namespace trackservo::sim
