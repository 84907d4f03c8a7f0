// SPDX-License-Identifier: Apache-2.0
// All contents of a plant file, in SI units (the file's own units are in its key names).
//
// A plant is two axes (inertia, motor, friction, loads, sensors), what they share (supply, PWM, ADC, base) and the
// requirements for their controller. Every key with its unit, range and meaning is in the table of plant_keys.cpp, from
// which plant_keys_markdown() prints the reference page. Load it with load_plant(); the result is checked and complete.
#ifndef TRACKSERVO_SIM_CONFIG_PLANT_CONFIG_HPP
#define TRACKSERVO_SIM_CONFIG_PLANT_CONFIG_HPP

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "machine/base/axis.hpp"
#include "machine/config/source_lines.hpp"
#include "machine/sensors/adc.hpp"
#include "machine/sensors/sensor_suite.hpp"

namespace trackservo::sim {

enum class FrictionModel { kNone = 0, kLugre = 1, kMaxwellSlip = 2 };
enum class FeedbackSource { kFused = 0, kGyro = 1, kEncoder = 2 };

// Steady-state friction of one direction of motion, eq. (5) of the paper.
struct StribeckConfig {
  double coulomb_nm = 0;            // Tc
  double breakaway_nm = 0;          // Ts >= Tc
  double stribeck_speed_rad_s = 1;  // the paper's theta_s'
  double viscous_nm_s_rad = 0;      // sigma2
};

struct FrictionConfig {
  double stiffness_nm_rad = 1;  // sigma0
  double damping_nm_s_rad = 0;  // sigma1
  StribeckConfig positive;
  StribeckConfig negative;
  // Seal eccentricity: friction level times 1 + e1 cos(angle - phase1) + e2 cos(2 (angle - phase2)).
  double eccentricity_once = 0;
  double eccentricity_once_phase_rad = 0;
  double eccentricity_twice = 0;
  double eccentricity_twice_phase_rad = 0;
};

// Used only by FrictionModel::kMaxwellSlip: the same Stribeck numbers, another memory, and drift.
struct MaxwellSlipConfig {
  int elements = 8;
  double attraction_1_s = 50;            // C / Ts of the generalised Maxwell-slip model
  double sticking_damping_fraction = 0;  // share of sigma1 that sticking elements keep
  double level_per_load_1_nm = 0;        // relative level per Nm of load torque
  double temperature_start_k = 0;        // against the temperature at which the numbers hold
  double temperature_end_k = 0;
  double temperature_time_constant_s = 100;
  double level_per_k = 0;      // level times exp(level_per_k * temperature)
  double viscosity_per_k = 0;  // sigma2 times exp(viscosity_per_k * temperature)
};

struct RippleConfig {
  int harmonic = 1;  // per turn of the joint
  double fraction = 0;
  double phase_rad = 0;
};

struct CoggingConfig {
  int harmonic = 1;
  double amplitude_nm = 0;
  double phase_rad = 0;
};

struct MotorConfig {
  double torque_constant_nm_a = 1;
  double back_emf_constant_v_s_rad = 1;
  double resistance_ohm = 1;
  double inductance_h = 1e-3;
  double current_limit_a = 1;  // of the drive, for its controller; the motor itself has none
  double dead_time_s = 0;
  std::vector<RippleConfig> ripple;
  std::vector<CoggingConfig> cogging;
};

struct LoadConfig {
  double imbalance_nm = 0;         // gravity moment of the axis' off-centre mass
  double imbalance_phase_rad = 0;  // its direction at joint angle zero
  double cable_stiffness_nm_rad = 0;
  double cable_neutral_rad = 0;
  double wind_mean_nm = 0;
  double wind_gust_rms_nm = 0;
  double wind_turbulence_corner_hz = 0.7;
  double wind_admittance_corner_hz = 0.7;
  double broadband_rms_nm = 0;  // white at 1 kHz
};

struct EndStopConfig {
  double lower_rad = 0;
  double upper_rad = 0;
  double stiffness_nm_rad = 1e5;
  double restitution = 0.3;
};

// Spring-applied, on the joint; holding_brake.hpp.
struct HoldingBrakeConfig {
  double torque_nm = 0;
  double engage_s = 0;   // from switching off the coil's current to springs pressing
  double release_s = 0;  // from switching on the coil's current to the joint being free
};

// Where something of an axis with a structure is: before its spring or behind.
enum class StructureSide { kJoint = 0, kPayload = 1 };

// A part of the inertia behind a spring; motor, seal, cable, imbalance and encoder are before it.
struct StructureConfig {
  double frequency_hz = 100;                     // of the free axis, at pitch 0
  double damping = 0.02;                         // ratio
  double inertia_share = 0.1;                    // of the axis' inertia, behind the spring
  double backlash_rad = 0;                       // from one end of the play to the other
  StructureSide optics = StructureSide::kJoint;  // gyro and camera
  StructureSide wind = StructureSide::kJoint;
};

struct BaseSwayConfig {
  double rms_rad = 0;
  double frequency_hz = 1;
  double damping = 0.1;
};

struct AxisConfig : SensorConfigs {
  double inertia_kg_m2 = 1;        // of azimuth: J0
  double inertia_swing_kg_m2 = 0;  // of azimuth: J1 in J0 + J1 cos^2(pitch); 0 for pitch
  MotorConfig motor;
  FrictionConfig friction;
  LoadConfig load;
  std::optional<EndStopConfig> end_stops;
  std::optional<HoldingBrakeConfig> holding_brake;
  std::optional<StructureConfig> structure;
  BaseSwayConfig base_sway;
};

struct SupplyConfig {
  double voltage_v = 48;
  double source_resistance_ohm = 0;
  int pwm_counts = 4250;
  double capacitance_f = 0;       // of the bus; 0: the supply takes returned current, too
  double brake_resistor_ohm = 0;  // 0: none
  double brake_resistor_v = 55;   // above it the resistor is on
};

struct BaseTiltConfig {
  double tilt_rad = 0;
  double direction_rad = 0;
};

// Requirements for the controller of one axis; the runner designs the gains from them.
struct DesignConfig {
  std::optional<double> speed_loop_bandwidth_hz;             // exactly one
  std::optional<double> speed_loop_natural_frequency_rad_s;  // of these two
  double speed_loop_damping = 1;
  double observer_bandwidth_hz = 1;
  FeedbackSource feedback = FeedbackSource::kFused;
  double fusion_crossover_hz = 10;
  int rate_window_ticks = 2;
  double setpoint_weight = 1;
  double setpoint_model_hz = 0;
  double current_loop_bandwidth_hz = 1000;
};

struct Assumption {
  std::string topic;
  std::string text;
};

// How often the simulator computes the joints. Motors, converters and bus are computed in each PWM period.
struct MechanicsConfig {
  int pwm_periods_per_step = 1;
};

enum class BaseAxis { kRoll = 0, kPitch = 1, kYaw = 2 };

// amplitude * sin(2 pi frequency t + phase) about one axis.
struct BaseMotionLine {
  BaseAxis axis = BaseAxis::kRoll;
  double frequency_hz = 1;
  double amplitude_rad = 0;
  double phase_rad = 0;
};

// A band of a spectrum of base motion about one axis: the power density of the angle falls as frequency^-slope. It is a
// sum of sines (plant/base_spectrum.hpp).
struct BaseSpectrum {
  BaseAxis axis = BaseAxis::kRoll;
  double rms_rad = 0;
  double low_hz = 0.1;
  double high_hz = 10;
  double slope = 4;
  int sines = 40;
  int seed = 1;
};

struct PlantConfig {
  std::string name;  // the file's name without extension
  SourceLines lines;
  std::string title;
  FrictionModel friction_model = FrictionModel::kLugre;
  MaxwellSlipConfig maxwell_slip;
  SupplyConfig supply;
  AdcConfig adc;
  BaseTiltConfig base_tilt;
  MechanicsConfig mechanics;
  std::vector<BaseMotionLine> base_motion;  // none, and no spectrum: the base does not turn
  std::vector<BaseSpectrum> base_spectrum;
  std::array<AxisConfig, kAxes> axis;
  std::array<DesignConfig, kAxes> design;
  std::vector<Assumption> assumptions;
};

// Reads and checks a plant file. Throws ConfigError, also when the file cannot be read.
PlantConfig load_plant(const std::filesystem::path& path);

// Returns the same for a text; `name` is the plant's, and replaces the file in error messages.
PlantConfig parse_plant(const std::string& name, std::string_view text);

// Returns the reference page of all plant keys: one markdown table per section, printed from the table that also checks
// them.
std::string plant_keys_markdown();

// Returns the inertia that the axis' motor turns at a pitch angle [kg m2]: J0 + J1 cos^2(pitch) for azimuth.
double axis_inertia_kg_m2(const PlantConfig& plant, int axis, double pitch_rad);

// Returns the steady-state friction of a joint rate at nominal temperature and level, eq. (5) [Nm]; 0 at standstill.
double steady_friction_nm(const FrictionConfig& friction, double joint_rate_rad_s);

}  // namespace trackservo::sim

#endif
