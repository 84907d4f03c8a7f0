// SPDX-License-Identifier: Apache-2.0
#include "machine/config/plant_keys.hpp"

namespace trackservo::sim {

namespace {

constexpr Range kTurn{-360, 360};
constexpr Range kTorque{0, 1e4};
constexpr Range kFrequency{1e-3, 1e4};

}  // namespace

const Keys<PlantConfig>& plant_keys() {
  static const Keys<PlantConfig> keys = {words("title", &PlantConfig::title, "one line for the report")};
  return keys;
}

const Keys<PlantConfig>& friction_model_keys() {
  static const Keys<PlantConfig> keys = {choice("model", {"none", "lugre", "maxwell_slip"},
                                                &PlantConfig::friction_model,
                                                "friction model of both axes; `none` also removes viscous friction")};
  return keys;
}

const Keys<MaxwellSlipConfig>& maxwell_slip_keys() {
  using Config = MaxwellSlipConfig;
  static const Keys<MaxwellSlipConfig> keys = {
      number("elements", unit::kNone, {1, 16}, &Config::elements, "number of spring-slider elements per axis")
          .or_else(8),
      number("attraction_1_s", unit::kPerSecond, {0, 1e4}, &Config::attraction_1_s,
             "how fast slipping elements follow the Stribeck curve")
          .or_else(50),
      number("sticking_damping_fraction", unit::kNone, {0, 1}, &Config::sticking_damping_fraction,
             "share of damping_nm_s_rad in sticking elements")
          .or_else(0),
      number("level_per_load_1_nm", unit::kPerNewtonMetre, {0, 1}, &Config::level_per_load_1_nm,
             "relative rise of the friction level per Nm of load torque")
          .or_else(0),
      number("temperature_start_k", unit::kKelvin, {-100, 100}, &Config::temperature_start_k,
             "seal temperature at time 0, relative to that of the friction parameters")
          .or_else(0),
      number("temperature_end_k", unit::kKelvin, {-100, 100}, &Config::temperature_end_k, "final seal temperature")
          .or_else(0),
      number("temperature_time_constant_s", unit::kSecond, {1e-2, 1e6}, &Config::temperature_time_constant_s,
             "time constant of the temperature drift")
          .or_else(100),
      number("level_per_k", unit::kPerKelvin, {-0.05, 0.05}, &Config::level_per_k,
             "logarithmic change of the friction level per K")
          .or_else(0),
      number("viscosity_per_k", unit::kPerKelvin, {-0.05, 0.05}, &Config::viscosity_per_k,
             "logarithmic change of the viscous coefficient per K")
          .or_else(0),
  };
  return keys;
}

const Keys<SupplyConfig>& supply_keys() {
  using Config = SupplyConfig;
  static const Keys<SupplyConfig> keys = {
      number("voltage_v", unit::kVolt, {1, 1000}, &Config::voltage_v, "open-circuit supply voltage"),
      number("source_resistance_ohm", unit::kOhm, {0, 10}, &Config::source_resistance_ohm,
             "resistance of supply and wiring")
          .or_else(0),
      number("pwm_counts", unit::kNone, {16, 1e6}, &Config::pwm_counts, "timer counts at full duty cycle"),
      number("capacitance_mf", unit::kMillifarad, {0, 1000}, &Config::capacitance_f,
             "capacitor of the bus; the supply then takes no current back; 0: it does, without a capacitor")
          .or_else(0),
      number("brake_resistor_ohm", unit::kOhm, {0, 1000}, &Config::brake_resistor_ohm,
             "resistor that is switched across the bus, with a capacitor only; 0: none")
          .or_else(0),
      number("brake_resistor_v", unit::kVolt, {1, 1000}, &Config::brake_resistor_v,
             "bus voltage above which the resistor is on")
          .or_else(55),
  };
  return keys;
}

const Keys<AdcConfig>& adc_keys() {
  using Config = AdcConfig;
  static const Keys<AdcConfig> keys = {
      number("resolution_bits", unit::kNone, {8, 24}, &Config::resolution_bits,
             "resolution of the current and voltage converters"),
      number("current_full_scale_a", unit::kAmpere, {0.1, 1e4}, &Config::current_full_scale_a,
             "range is plus and minus this value"),
      number("current_noise_rms_a", unit::kAmpere, {0, 100}, &Config::current_noise_rms_a, "white noise").or_else(0),
      number("current_offset_a", unit::kAmpere, {-100, 100}, &Config::current_offset_a, "constant offset").or_else(0),
      number("voltage_full_scale_v", unit::kVolt, {1, 2000}, &Config::voltage_full_scale_v,
             "range is from 0 to this value"),
      number("voltage_noise_rms_v", unit::kVolt, {0, 100}, &Config::voltage_noise_rms_v, "white noise").or_else(0),
  };
  return keys;
}

const Keys<MechanicsConfig>& mechanics_keys() {
  static const Keys<MechanicsConfig> keys = {
      number("pwm_periods_per_step", unit::kNone, {1, 4}, &MechanicsConfig::pwm_periods_per_step,
             "PWM periods of 50 us per step of joints, friction and sensors: 1, 2 or 4")
          .or_else(1),
  };
  return keys;
}

const Keys<BaseTiltConfig>& base_tilt_keys() {
  using Config = BaseTiltConfig;
  static const Keys<BaseTiltConfig> keys = {
      number("tilt_deg", unit::kDegree, {-45, 45}, &Config::tilt_rad, "constant tilt of the base").or_else(0),
      number("direction_deg", unit::kDegree, kTurn, &Config::direction_rad,
             "azimuth joint angle at which the tilt points up")
          .or_else(0),
  };
  return keys;
}

const Keys<BaseMotionLine>& base_motion_keys() {
  using Config = BaseMotionLine;
  static const Keys<BaseMotionLine> keys = {
      choice("axis", {"roll", "pitch", "yaw"}, &Config::axis,
             "axis of the base: x ahead, the pitch raises x, z up; the order is yaw, pitch, roll"),
      number("frequency_hz", unit::kHertz, {0.001, 100}, &Config::frequency_hz, "frequency of the sine"),
      number("amplitude_deg", unit::kDegree, {0, 90}, &Config::amplitude_rad, "amplitude of the sine"),
      number("phase_deg", unit::kDegree, kTurn, &Config::phase_rad, "phase of the sine at time 0").or_else(0),
  };
  return keys;
}

const Keys<BaseSpectrum>& base_spectrum_keys() {
  using Config = BaseSpectrum;
  static const Keys<BaseSpectrum> keys = {
      choice("axis", {"roll", "pitch", "yaw"}, &Config::axis, "axis of the base, as in [[base_motion]]"),
      number("rms_deg", unit::kDegree, {0, 45}, &Config::rms_rad, "standard deviation of the angle in this band"),
      number("low_hz", unit::kHertz, {0.001, 100}, &Config::low_hz, "lower end of the band"),
      number("high_hz", unit::kHertz, {0.001, 100}, &Config::high_hz, "upper end of the band; above low_hz"),
      number("slope", unit::kNone, {0, 8}, &Config::slope,
             "the power density of the angle falls as frequency^-slope; 4: as that of a constant angular acceleration")
          .or_else(4),
      number("sines", unit::kNone, {1, 500}, &Config::sines, "number of sines that stand for the band").or_else(40),
      number("seed", unit::kNone, {0, 1e6}, &Config::seed, "seed of their frequencies and phases").or_else(1),
  };
  return keys;
}

const Keys<AxisConfig>& axis_keys() {
  using Config = AxisConfig;
  static const Keys<AxisConfig> keys = {
      number("inertia_kg_m2", unit::kKilogramSquareMetre, {1e-6, 1e6}, &Config::inertia_kg_m2,
             "inertia about the axis; azimuth: the part J0 that does not depend on pitch"),
      number("inertia_swing_kg_m2", unit::kKilogramSquareMetre, {0, 1e6}, &Config::inertia_swing_kg_m2,
             "azimuth only: J1 in J0 + J1 cos^2(pitch)")
          .or_else(0),
  };
  return keys;
}

const Keys<EndStopKeys>& end_stop_keys() {
  using Config = EndStopKeys;
  static const Keys<EndStopKeys> keys = {
      number("end_stops_deg", unit::kDegree, {-1e5, 1e5}, &Config::range_rad,
             "[lower, upper] travel limits of the joint; absent: no end stops")
          .or_absent(),
      number("end_stop_stiffness_nm_rad", unit::kNewtonMetrePerRadian, {1, 1e8}, &Config::stiffness_nm_rad,
             "stiffness of the buffers")
          .or_else(1e5),
      number("end_stop_restitution", unit::kNone, {0.01, 1}, &Config::restitution,
             "ratio of the speeds after and before the impact")
          .or_else(0.3),
  };
  return keys;
}

const Keys<MotorConfig>& motor_keys() {
  using Config = MotorConfig;
  static const Keys<MotorConfig> keys = {
      number("torque_constant_nm_a", unit::kNewtonMetrePerAmpere, {1e-4, 1e3}, &Config::torque_constant_nm_a,
             "Kt, torque per current"),
      number("back_emf_constant_v_s_rad", unit::kVoltSecondPerRadian, {0, 1e3}, &Config::back_emf_constant_v_s_rad,
             "Ke, voltage per speed"),
      number("resistance_ohm", unit::kOhm, {1e-4, 1e4}, &Config::resistance_ohm, "R of winding and cable"),
      number("inductance_mh", unit::kMillihenry, {1e-4, 1e4}, &Config::inductance_h, "L of the winding"),
      number("current_limit_a", unit::kAmpere, {1e-3, 1e4}, &Config::current_limit_a,
             "current limit of the drive; the controller enforces it, the plant does not"),
      number("dead_time_us", unit::kMicrosecond, {0, 10}, &Config::dead_time_s, "dead time of the bridge").or_else(0),
  };
  return keys;
}

const Keys<RippleConfig>& ripple_keys() {
  using Config = RippleConfig;
  static const Keys<RippleConfig> keys = {
      number("harmonic", unit::kNone, {1, 1000}, &Config::harmonic, "periods per turn of the joint"),
      number("amplitude_percent", unit::kPercent, {0, 50}, &Config::fraction, "amplitude relative to the torque"),
      number("phase_deg", unit::kDegree, kTurn, &Config::phase_rad, "phase of the cosine at joint angle 0").or_else(0),
  };
  return keys;
}

const Keys<CoggingConfig>& cogging_keys() {
  using Config = CoggingConfig;
  static const Keys<CoggingConfig> keys = {
      number("harmonic", unit::kNone, {1, 1000}, &Config::harmonic, "periods per turn of the joint"),
      number("amplitude_nm", unit::kNewtonMetre, kTorque, &Config::amplitude_nm,
             "amplitude, independent of the current"),
      number("phase_deg", unit::kDegree, kTurn, &Config::phase_rad, "phase of the sine at joint angle 0").or_else(0),
  };
  return keys;
}

const Keys<FrictionConfig>& friction_keys() {
  using Config = FrictionConfig;
  static const Keys<FrictionConfig> keys = {
      number("stiffness_nm_rad", unit::kNewtonMetrePerRadian, {1e-3, 1e9}, &Config::stiffness_nm_rad,
             "sigma0, eq. (1)"),
      number("damping_nm_s_rad", unit::kNewtonMetreSecondPerRadian, {0, 1e6}, &Config::damping_nm_s_rad,
             "sigma1, eq. (1)"),
      number("eccentricity_once_percent", unit::kPercent, {0, 90}, &Config::eccentricity_once,
             "variation of the friction level once per turn")
          .or_else(0),
      number("eccentricity_once_phase_deg", unit::kDegree, kTurn, &Config::eccentricity_once_phase_rad,
             "joint angle of the maximum")
          .or_else(0),
      number("eccentricity_twice_percent", unit::kPercent, {0, 90}, &Config::eccentricity_twice,
             "variation of the friction level twice per turn")
          .or_else(0),
      number("eccentricity_twice_phase_deg", unit::kDegree, kTurn, &Config::eccentricity_twice_phase_rad,
             "joint angle of one of the maxima")
          .or_else(0),
  };
  return keys;
}

const Keys<StribeckConfig>& stribeck_keys() {
  using Config = StribeckConfig;
  static const Keys<StribeckConfig> keys = {
      number("coulomb_nm", unit::kNewtonMetre, {1e-6, 1e4}, &Config::coulomb_nm, "Tc, eq. (3)"),
      number("breakaway_nm", unit::kNewtonMetre, {1e-6, 1e4}, &Config::breakaway_nm, "Ts >= Tc, eq. (3)"),
      number("stribeck_speed_deg_s", unit::kDegreePerSecond, {1e-4, 5e3}, &Config::stribeck_speed_rad_s,
             "Stribeck speed, eq. (3)"),
      number("viscous_nm_s_rad", unit::kNewtonMetreSecondPerRadian, {0, 1e4}, &Config::viscous_nm_s_rad,
             "sigma2, eq. (1)"),
  };
  return keys;
}

const Keys<LoadConfig>& load_keys() {
  using Config = LoadConfig;
  static const Keys<LoadConfig> keys = {
      number("imbalance_nm", unit::kNewtonMetre, kTorque, &Config::imbalance_nm,
             "gravity torque of the off-centre mass; on azimuth it acts on a tilted base only")
          .or_else(0),
      number("imbalance_phase_deg", unit::kDegree, kTurn, &Config::imbalance_phase_rad,
             "direction of the off-centre mass at joint angle 0")
          .or_else(0),
      number("cable_stiffness_nm_rad", unit::kNewtonMetrePerRadian, {0, 1e4}, &Config::cable_stiffness_nm_rad,
             "torsional stiffness of the cable loop")
          .or_else(0),
      number("cable_neutral_deg", unit::kDegree, {-1e4, 1e4}, &Config::cable_neutral_rad,
             "joint angle at which the cable is relaxed")
          .or_else(0),
      number("wind_mean_nm", unit::kNewtonMetre, {-1e4, 1e4}, &Config::wind_mean_nm,
             "mean wind torque, positive against forward motion")
          .or_else(0),
      number("wind_gust_rms_nm", unit::kNewtonMetre, kTorque, &Config::wind_gust_rms_nm,
             "standard deviation of the gust torque")
          .or_else(0),
      number("wind_turbulence_corner_hz", unit::kHertz, kFrequency, &Config::wind_turbulence_corner_hz,
             "first pole of the gusts: wind speed over eddy size")
          .or_else(0.7),
      number("wind_admittance_corner_hz", unit::kHertz, kFrequency, &Config::wind_admittance_corner_hz,
             "second pole: wind speed over cabin size")
          .or_else(0.7),
      number("broadband_rms_nm", unit::kNewtonMetre, kTorque, &Config::broadband_rms_nm,
             "white torque noise, held for 1 ms")
          .or_else(0),
  };
  return keys;
}

const Keys<HoldingBrakeConfig>& holding_brake_keys() {
  using Config = HoldingBrakeConfig;
  static const Keys<HoldingBrakeConfig> keys = {
      number("torque_nm", unit::kNewtonMetre, {1e-3, 1e5}, &Config::torque_nm,
             "holding torque; above it the brake slips with this friction torque"),
      number("engage_ms", unit::kMillisecond, {0, 1000}, &Config::engage_s, "time from bridge off to brake closed")
          .or_else(30),
      number("release_ms", unit::kMillisecond, {0, 1000}, &Config::release_s, "time from bridge on to brake open")
          .or_else(20),
  };
  return keys;
}

const Keys<StructureConfig>& structure_keys() {
  using Config = StructureConfig;
  static const Keys<StructureConfig> keys = {
      number("frequency_hz", unit::kHertz, {1, 400}, &Config::frequency_hz,
             "resonance of the axis without friction, at pitch 0"),
      number("damping", unit::kNone, {0.001, 1}, &Config::damping, "damping ratio of that resonance"),
      number("inertia_share", unit::kNone, {0.001, 0.9}, &Config::inertia_share,
             "share of the axis' inertia behind the spring"),
      number("backlash_urad", unit::kMicroradian, {0, 1e5}, &Config::backlash_rad,
             "play in series with the spring, from one end to the other")
          .or_else(0),
      choice("optics", {"joint", "payload"}, &Config::optics,
             "side of the spring on which gyro and camera are: the joint's, or the payload behind it")
          .or_else(0),
      choice("wind", {"joint", "payload"}, &Config::wind, "side of the spring on which the wind acts").or_else(0),
  };
  return keys;
}

const Keys<BaseSwayConfig>& base_sway_keys() {
  using Config = BaseSwayConfig;
  static const Keys<BaseSwayConfig> keys = {
      number("rms_urad", unit::kMicroradian, {0, 1e5}, &Config::rms_rad, "standard deviation of the base angle"),
      number("frequency_hz", unit::kHertz, {0.01, 100}, &Config::frequency_hz, "resonant frequency of the sway"),
      number("damping", unit::kNone, {0.001, 2}, &Config::damping, "damping ratio of the resonance"),
  };
  return keys;
}

const Keys<DesignConfig>& design_keys() {
  using Config = DesignConfig;
  static const Keys<DesignConfig> keys = {
      number("speed_loop_bandwidth_hz", unit::kHertz, {0.01, 300}, &Config::speed_loop_bandwidth_hz,
             "closed-loop bandwidth; give either this or speed_loop_natural_frequency_rad_s")
          .or_absent(),
      number("speed_loop_natural_frequency_rad_s", unit::kRadianPerSecond, {0.01, 2e3},
             &Config::speed_loop_natural_frequency_rad_s, "natural frequency of the PI loop with the bare inertia")
          .or_absent(),
      number("speed_loop_damping", unit::kNone, {0.1, 10}, &Config::speed_loop_damping, "damping ratio of the PI loop"),
      number("observer_bandwidth_hz", unit::kHertz, {0.01, 159}, &Config::observer_bandwidth_hz,
             "bandwidth of the disturbance observer's Q filter"),
      choice("feedback", {"fused", "gyro", "encoder"}, &Config::feedback, "rate signal of the speed loop"),
      number("fusion_crossover_hz", unit::kHertz, {0.01, 318}, &Config::fusion_crossover_hz,
             "fused: gyro below this frequency, encoder above"),
      number("rate_window_ticks", unit::kNone, {2, 16}, &Config::rate_window_ticks,
             "window of the encoder's rate estimate; 2 has the least delay, more reduce the phase margin"),
      number("setpoint_weight", unit::kNone, {0, 1}, &Config::setpoint_weight,
             "set-point weight of the proportional part"),
      number("setpoint_model_hz", unit::kHertz, {0, 159}, &Config::setpoint_model_hz,
             "natural frequency of the set-point model; 0: none, else from 16 Hz")
          .or_else(0),
      number("current_loop_bandwidth_hz", unit::kHertz, {10, 2500}, &Config::current_loop_bandwidth_hz,
             "closed-loop bandwidth of the current loop"),
  };
  return keys;
}

const Keys<Assumption>& assumption_keys() {
  static const Keys<Assumption> keys = {
      words("topic", &Assumption::topic, "subject of the assumption"),
      words("text", &Assumption::text, "the assumption and its reason; printed in the report")};
  return keys;
}

std::string plant_keys_markdown() {
  std::vector<KeyText> axis = texts_of(axis_keys());
  for (const KeyText& key : texts_of(end_stop_keys())) {
    axis.push_back(key);
  }
  std::vector<Section> sections = {
      {"(top of the file)", "", texts_of(plant_keys())},
      {"[friction]", "", texts_of(friction_model_keys())},
      {"[maxwell_slip]", "Optional. Used when `friction.model` is `maxwell_slip`.", texts_of(maxwell_slip_keys())},
      {"[supply]", "", texts_of(supply_keys())},
      {"[adc]", "", texts_of(adc_keys())},
      {"[base_tilt]", "Optional.", texts_of(base_tilt_keys())},
      {"[mechanics]", "Optional. The default is the exact simulation, by which the results are judged.",
       texts_of(mechanics_keys())},
      {"[[base_motion]]",
       "Optional; may be repeated, so that the lines of a spectrum add up. The base turns as on a vehicle or a ship: "
       "joints, gyros, gravity and the picture of a camera with `geometry = \"line_of_sight\"` see it exactly.",
       texts_of(base_motion_keys())},
      {"[[base_spectrum]]",
       "Optional; may be repeated: bands and axes add up, also with `[[base_motion]]`. The base turns with a sum of "
       "sines whose power is that of the band. A ship: rms 2 deg, 0.08 to 0.3 Hz, slope 4. A vehicle off the road: "
       "rms 0.3 deg, 0.5 to 10 Hz, slope 4.",
       texts_of(base_spectrum_keys())},
      {"[azimuth], [pitch]", "", axis},
      {"[azimuth.motor], [pitch.motor]", "", texts_of(motor_keys())},
      {"[[azimuth.motor.ripple]], [[pitch.motor.ripple]]", "Optional; may be repeated.", texts_of(ripple_keys())},
      {"[[azimuth.motor.cogging]], [[pitch.motor.cogging]]", "Optional; may be repeated.", texts_of(cogging_keys())},
      {"[azimuth.friction], [pitch.friction]", "", texts_of(friction_keys())},
      {"[azimuth.friction.positive], [azimuth.friction.negative], the same for pitch",
       "One per direction of motion. Without `negative` both directions are equal.", texts_of(stribeck_keys())},
      {"[azimuth.load], [pitch.load]", "Optional.", texts_of(load_keys())},
      {"[azimuth.holding_brake], [pitch.holding_brake]",
       "Optional. A brake closed by springs and opened by a coil. The gate driver's enable line feeds the coil, so "
       "the brake holds while the bridge is off. Only `sim_host serve` and `emulate_board` simulate it. `run`, "
       "`identify`, `faults`, `soak` and the studies omit it, so that their results do not depend on a brake. "
       "`sim_host serve` starts with its times in 2060:24 and 2060:25.",
       texts_of(holding_brake_keys())},
      {"[azimuth.structure], [pitch.structure]",
       "Optional; without it the axis is rigid. Part of the inertia is connected by a spring. Motor, seal, cable, "
       "imbalance and encoder are on the joint's side of the spring.",
       texts_of(structure_keys())},
      {"[azimuth.base_sway], [pitch.base_sway]", "Optional; without it the base does not move.",
       texts_of(base_sway_keys())},
  };
  for_each_sensor([&sections](const std::string& name, const auto& keys, auto) {
    sections.push_back(
        {"[azimuth." + name + "], [pitch." + name + "]", all_optional(keys) ? "Optional." : "", texts_of(keys)});
  });
  sections.push_back(
      {"[design.azimuth], [design.pitch]", "Requirements for the gain design.", texts_of(design_keys())});
  sections.push_back({"[[assumption]]", "One table per assumption.", texts_of(assumption_keys())});
  return sections_markdown(
      "Keys of a plant file",
      "What you can write into a plant file: each key with unit, allowed values, default and meaning. A plant file\n"
      "describes the machine that `sim_host` simulates, and what the design of its gains must reach. Start with a copy "
      "of\n"
      "[`tracker.toml`](../sim_host/plants/tracker.toml). The build prints this page from the reader of the files. Do "
      "not\n"
      "edit it: run `tools/update-docs keys`.",
      sections);
}

}  // namespace trackservo::sim
