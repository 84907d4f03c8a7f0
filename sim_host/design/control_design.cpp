// SPDX-License-Identifier: Apache-2.0
#include "design/control_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "design/design_check.hpp"
#include "design/plant_remedy.hpp"
#include "design/true_plant.hpp"
#include "dictionary/device_description.hpp"
#include "dictionary/refusal_text.hpp"
#include "gain_design/outer_loops.hpp"
#include "machine/base/random.hpp"

extern "C" {
#include "parameters/axis_dictionary.h"
#include "parameters/axis_tuning.h"
}

namespace trackservo::sim {
namespace {

constexpr double kPositionLoop_per_s = 10.0;
constexpr double kPredictiveTracker_per_s = 20.0;
constexpr double kTrackingBandwidth_hz = 2.0;  // the paper's
// Of the least error: what a faster speed loop and the noise of the plants' camera allow.
constexpr double kFastTracker_per_s = 40.0;
constexpr double kFastEstimator_rad_s = 6.0;

float to_float(double value) { return static_cast<float>(value); }

// Every friction parameter is wrong by the same share, each with its own sign.
class WrongBy {
 public:
  WrongBy(double share, std::uint64_t seed, int axis) : share_(share), signs_(seed, "friction.parameter.error", axis) {}
  double operator()(double value) { return value * (signs_.uniform() < 0.5 ? 1.0 - share_ : 1.0 + share_); }

 private:
  double share_;
  RandomStream signs_;
};

lugre_direction wrong_direction(const StribeckConfig& truth, WrongBy& wrong) {
  const double coulomb_nm = wrong(truth.coulomb_nm);
  const double breakaway_nm = std::max(wrong(truth.breakaway_nm), coulomb_nm);
  const double stribeck_speed_rad_s = wrong(truth.stribeck_speed_rad_s);
  const double viscous_nm_s_rad = wrong(truth.viscous_nm_s_rad);
  return {to_float(coulomb_nm), to_float(breakaway_nm), to_float(stribeck_speed_rad_s), to_float(viscous_nm_s_rad)};
}

lugre_params wrong_friction(const FrictionConfig& truth, WrongBy wrong) {
  lugre_params params{};
  params.stiffness_nm_rad = to_float(wrong(truth.stiffness_nm_rad));
  params.damping_nm_s_rad = to_float(wrong(truth.damping_nm_s_rad));
  params.positive = wrong_direction(truth.positive, wrong);
  params.negative = wrong_direction(truth.negative, wrong);
  return params;
}

gain_design::IdentifiedPlant believed(const PlantConfig& plant, int axis, const DesignOptions& options) {
  if (options.identified) {
    return (*options.identified)[static_cast<std::size_t>(axis)];
  }
  gain_design::IdentifiedPlant assumed_plant = true_plant(plant, axis);
  assumed_plant.friction = wrong_friction(plant.axis[static_cast<std::size_t>(axis)].friction,
                                          WrongBy(options.friction_parameter_error, options.seed, axis));
  return assumed_plant;
}

rate_source source_of(FeedbackSource feedback) {
  switch (feedback) {
    case FeedbackSource::kGyro:
      return RATE_FROM_GYRO;
    case FeedbackSource::kEncoder:
      return RATE_FROM_ENCODER;
    case FeedbackSource::kFused:
    default:
      return RATE_FUSED;
  }
}

void set_speed_loop(axis_parameters& p, const PlantConfig& plant, int axis, const ControllerSpec& spec,
                    double believed_inertia_kg_m2) {
  const std::size_t i = static_cast<std::size_t>(axis);
  const DesignConfig& design = plant.design[i];
  const float inertia_kg_m2 = to_float(believed_inertia_kg_m2);
  const double limit_nm = plant.axis[i].motor.current_limit_a * plant.axis[i].motor.torque_constant_nm_a;
  p.speed_loop.acceleration_inertia_kg_m2 = inertia_kg_m2;
  p.speed_loop.setpoint_model_rad_s = to_float(2.0 * kPi * design.setpoint_model_hz);
  p.observer.on = spec.observer ? 1U : 0U;
  p.observer.inertia_kg_m2 = inertia_kg_m2;
  p.observer.bandwidth_rad_s = to_float(2.0 * kPi * design.observer_bandwidth_hz);
  p.observer.limit_nm = to_float(limit_nm);
  p.sensors.source = static_cast<std::uint32_t>(source_of(design.feedback));
  p.sensors.crossover_rad_s = to_float(2.0 * kPi * design.fusion_crossover_hz);
  p.sensors.window_ticks = static_cast<std::uint32_t>(design.rate_window_ticks);
}

void set_friction(axis_parameters& p, const ControllerSpec& spec, const lugre_params& friction) {
  p.friction.model = static_cast<std::uint32_t>(spec.friction);
  p.friction.lead_limit_rad_s = to_float(5.0 * kRadPerDeg);
  p.friction.sign_width_rad_s = to_float(0.01 * kRadPerDeg);
  gain_design::set_friction(p, friction);
}

void set_tracker(axis_parameters& p, tracker_kind kind) {
  p.tracking_loop.kind = static_cast<std::uint32_t>(kind);
  p.tracking_loop.proportional_per_s = to_float(kPredictiveTracker_per_s);
  if (kind == TRACKER_PI) {
    const double w = gain_design::tracking_frequency_rad_s(kTrackingBandwidth_hz, gain_design::kTrackingDelay_s);
    p.tracking_loop.proportional_per_s = to_float(2.0 * w);
    p.tracking_loop.integral_per_s2 = to_float(w * w);
  }
}

void set_motor(axis_parameters& p, const PlantConfig& plant, int axis) {
  const MotorConfig& motor = plant.axis[static_cast<std::size_t>(axis)].motor;
  const DesignConfig& design = plant.design[static_cast<std::size_t>(axis)];
  p.motor.torque_constant_nm_a = to_float(motor.torque_constant_nm_a);
  p.motor.resistance_ohm = to_float(motor.resistance_ohm);
  p.motor.inductance_h = to_float(motor.inductance_h);
  p.motor.back_emf_v_s_rad = to_float(motor.back_emf_constant_v_s_rad);
  p.motor.bandwidth_rad_s = to_float(2.0 * kPi * design.current_loop_bandwidth_hz);
  p.motor.current_limit_a = to_float(motor.current_limit_a);
}

// Throws ConfigError where the firmware cannot use the gyro.
gyro_mounting mounting_of(const PlantConfig& plant, int axis) {
  const GyroMounting mounting = plant.axis[static_cast<std::size_t>(axis)].gyro.mounting;
  const bool encoder_alone = plant.design[static_cast<std::size_t>(axis)].feedback == FeedbackSource::kEncoder;
  if (mounting == GyroMounting::kLineOfSight) {
    return GYRO_ON_LINE_OF_SIGHT;
  }
  if (mounting == GyroMounting::kJoint || (mounting == GyroMounting::kStage && axis == kAzimuth)) {
    return GYRO_ON_AXIS;
  }
  if (is_below_joint(mounting, axis)) {
    return GYRO_BELOW_JOINT;
  }
  if (!encoder_alone) {
    throw plant.lines.error(
        axis_name(axis) + std::string(".gyro.mounting"),
        "puts the gyro of the pitch below the azimuth, which turns it away; the firmware cannot use it",
        "give \"joint\", \"line_of_sight\" or \"stage\", or design with feedback = \"encoder\"");
  }
  return GYRO_ON_AXIS;
}

// The plant that the device checks gains against, and from which it follows the azimuth's inertia: what an
// identification at pitch 0 found or the true one, and at 90 degrees the share of it that the plant file says.
void set_plant(axis_parameters& p, const PlantConfig& plant, int axis, const DesignOptions& options) {
  gain_design::set_plant(
      p, options.identified ? (*options.identified)[static_cast<std::size_t>(axis)] : true_plant(plant, axis));
  const double share = axis_inertia_kg_m2(plant, axis, 0.5 * kPi) / axis_inertia_kg_m2(plant, axis, 0.0);
  p.plant.min_inertia_kg_m2 = to_float(share) * p.plant.inertia_kg_m2;
  p.plant.gyro_mounting = static_cast<std::uint32_t>(mounting_of(plant, axis));
}

// Everything except the PI. What no rule decides is the default of the parameter list.
axis_parameters without_pi(const PlantConfig& plant, int axis, const ControllerSpec& spec,
                           const DesignOptions& options) {
  const gain_design::IdentifiedPlant assumed_plant = believed(plant, axis, options);
  axis_parameters p = dictionary::listed_defaults();
  set_speed_loop(p, plant, axis, spec, assumed_plant.inertia_kg_m2);
  p.position_loop.proportional_per_s = to_float(kPositionLoop_per_s);
  p.position_loop.rate_limit_rad_s = to_float(60.0 * kRadPerDeg);
  p.position_loop.deceleration_rad_s2 = to_float(60.0 * kRadPerDeg);
  set_tracker(p, options.tracker);
  set_friction(p, spec, assumed_plant.friction);
  set_motor(p, plant, axis);
  set_plant(p, plant, axis, options);
  return p;
}

// What the design chooses is not required.
gain_design::GainRequirements least_error_requirements(tracker_kind tracker) {
  gain_design::GainRequirements requirements;
  requirements.least = kMinMargins;
  requirements.least_rate_error = true;
  if (tracker == TRACKER_PREDICTIVE) {
    requirements.tracking_bandwidth_hz = kFastTracker_per_s / (2.0 * kPi);
  }
  return requirements;
}

axis_parameters with_least_error(const PlantConfig& plant, int axis, const DesignOptions& options,
                                 const axis_parameters& present) {
  if (options.least_error) {
    return (*options.least_error)[static_cast<std::size_t>(axis)];
  }
  const gain_design::IdentifiedPlant assumed_plant = believed(plant, axis, options);
  try {
    axis_parameters designed =
        gain_design::design_gains(assumed_plant, least_error_requirements(options.tracker), present).parameters;
    designed.tracking_loop.estimator_rad_s = to_float(kFastEstimator_rad_s);
    set_plant(designed, plant, axis, options);
    return designed;
  } catch (const gain_design::GainDesignError& error) {
    throw plant.lines.error(axis_name(axis), fmt::format("leads to no gains: {}", error.what()),
                            "compare inertia, friction and motor with those of a shipped plant");
  }
}

// The firmware does not accept such parameters. Cheap to throw: the search for a remedy catches many of them.
struct Refused : ConfigError {
  Refused(const std::string& what, const axis_parameters& the_parameters)
      : ConfigError(what), parameters(the_parameters) {}
  axis_parameters parameters;
};

servo_axis_params built(const PlantConfig& plant, int axis, const axis_parameters& parameters) {
  servo_axis_params params{};
  if (axis_parameters_build(&parameters, &params) != CONTROL_OK) {
    throw Refused(plant.lines
                      .error(axis_name(axis), "needs parameters that the firmware refuses",
                             "compare inertia, friction and motor with those of a shipped plant")
                      .what(),
                  parameters);
  }
  return params;
}

// A requirement that no machine can meet at 1 kHz and a PWM of 20 kHz.
std::optional<ConfigError> impossible_requirement(const PlantConfig& plant, int axis) {
  const DesignConfig& design = plant.design[static_cast<std::size_t>(axis)];
  const auto error = [&](const char *key, const char *reason, const char *right) {
    return plant.lines.error(fmt::format("design.{}.{}", axis_name(axis), key), reason, right);
  };
  const char *const range = "is outside the firmware's range at 1 kHz";
  if (design.current_loop_bandwidth_hz < 10.0 || design.current_loop_bandwidth_hz > 2500.0) {
    return error("current_loop_bandwidth_hz", "is not possible with this motor and a PWM of 20 kHz", "give 10 to 2500");
  }
  if (design.observer_bandwidth_hz > 159.0) {
    return error("observer_bandwidth_hz", range, "give at most 159");
  }
  if (design.fusion_crossover_hz > 318.0) {
    return error("fusion_crossover_hz", range, "give at most 318");
  }
  return std::nullopt;
}

}  // namespace

const std::vector<ControllerSpec>& controller_specs() {
  static const std::vector<ControllerSpec> specs = {
      {"pi", "PI", "PI speed loop with acceleration feedforward", false, FRICTION_NONE},
      {"pi_vob", "PI + VOB", "PI and velocity disturbance observer", true, FRICTION_NONE},
      {"pi_ftc", "PI + FTC", "PI and LuGre friction feedforward", false, FRICTION_LUGRE},
      {"pi_vob_ftc", "PI + VOB + FTC", "PI, observer and LuGre friction feedforward", true, FRICTION_LUGRE},
      {"pi_coulomb", "PI + Coulomb", "PI and the usual Coulomb and viscous feedforward of drives", false,
       FRICTION_COULOMB},
      {"pi_best", "best PI", "PI tuned by an optimiser for this scenario, with the same margins", false, FRICTION_NONE},
      {"least_error", "least error",
       "PI + VOB + FTC and set-point model, with gains for the least rate error in the wind; without wind PI + VOB + "
       "FTC",
       true, FRICTION_LUGRE, true},
  };
  return specs;
}

const ControllerSpec& controller_spec(const std::string& name) {
  std::string choices;
  for (const ControllerSpec& spec : controller_specs()) {
    if (spec.name == name) {
      return spec;
    }
    choices += (choices.empty() ? "" : ", ") + spec.name;
  }
  throw std::invalid_argument(fmt::format("unknown controller \"{}\"; give one of {}", name, choices));
}

PiRequirement pi_requirement(const PlantConfig& plant, int axis, const DesignOptions& options) {
  const DesignConfig& design = plant.design[static_cast<std::size_t>(axis)];
  if (design.speed_loop_natural_frequency_rad_s) {
    return {*design.speed_loop_natural_frequency_rad_s, design.speed_loop_damping, design.setpoint_weight};
  }
  const servo_axis_params params = built(plant, axis, without_pi(plant, axis, controller_spec("pi"), options));
  LinearMachine machine = linear_machine(plant, axis, false);
  if (options.identified) {
    const gain_design::IdentifiedPlant& assumed_plant = (*options.identified)[static_cast<std::size_t>(axis)];
    machine = gain_design::linear_machine(assumed_plant, 2.0 * kPi * design.current_loop_bandwidth_hz, false);
  }
  return {gain_design::natural_frequency_rad_s(machine, params.speed, design.speed_loop_bandwidth_hz.value(),
                                               design.speed_loop_damping),
          design.speed_loop_damping, design.setpoint_weight};
}

void set_pi(servo_params& params, int axis, const PiRequirement& requirement) {
  speed_loop_params& loop = params.axis[axis].speed;
  loop.pi = gain_design::pi_params(requirement, static_cast<double>(loop.acceleration_inertia_kg_m2));
}

void set_pi(axis_parameters& parameters, const PiRequirement& requirement) {
  const auto inertia_kg_m2 = static_cast<double>(parameters.speed_loop.acceleration_inertia_kg_m2);
  gain_design::set_pi(parameters, gain_design::pi_params(requirement, inertia_kg_m2));
}

gain_design::GainRequirements gain_requirements(const PlantConfig& plant, int axis, tracker_kind tracker) {
  const DesignConfig& design = plant.design[static_cast<std::size_t>(axis)];
  gain_design::GainRequirements requirements;
  requirements.speed_loop_bandwidth_hz = design.speed_loop_bandwidth_hz;
  requirements.speed_loop_natural_frequency_rad_s = design.speed_loop_natural_frequency_rad_s;
  requirements.speed_loop_damping = design.speed_loop_damping;
  requirements.setpoint_weight = design.setpoint_weight;
  requirements.setpoint_model_hz = design.setpoint_model_hz;
  requirements.observer_bandwidth_hz = design.observer_bandwidth_hz;
  requirements.least = kMinMargins;
  requirements.tracking_bandwidth_hz =
      tracker == TRACKER_PREDICTIVE ? kPredictiveTracker_per_s / (2.0 * kPi) : kTrackingBandwidth_hz;
  requirements.position_bandwidth_hz = kPositionLoop_per_s / (2.0 * kPi);
  return requirements;
}

axis_parameters design_axis(const PlantConfig& plant, int axis, const ControllerSpec& spec,
                            const DesignOptions& options) {
  axis_parameters parameters = without_pi(plant, axis, spec, options);
  if (spec.least_error && believed(plant, axis, options).disturbance) {
    return with_least_error(plant, axis, options, parameters);
  }
  gain_design::set_pi(parameters, gain_design::pi_params(pi_requirement(plant, axis, options),
                                                         believed(plant, axis, options).inertia_kg_m2));
  return parameters;
}

AxesParameters design_axes(const PlantConfig& plant, const ControllerSpec& spec, const DesignOptions& options) {
  return {design_axis(plant, kAzimuth, spec, options), design_axis(plant, kPitch, spec, options)};
}

servo_params design_controller(const PlantConfig& plant, const ControllerSpec& spec, const DesignOptions& options) {
  // Identified values do not change with the plant's numbers, so no remedy can be found then. The least error does not
  // depend on the requirements, and its search takes seconds.
  const auto is_possible = [&](const PlantConfig& changed, int axis) {
    if (spec.least_error) {
      return false;
    }
    try {
      const servo_axis_params params = built(changed, axis, design_axis(changed, axis, spec, options));
      return keeps_margins(worst_margins(changed, axis, params.speed)) &&
             speed_loop_is_stable(changed, axis, params.speed);
    } catch (const ConfigError&) {
      return false;
    }
  };
  servo_params params{};
  for (int axis = 0; axis < kAxes; ++axis) {
    try {
      params.axis[axis] = built(plant, axis, design_axis(plant, axis, spec, options));
    } catch (const Refused& refused) {
      if (const std::optional<ConfigError> requirement = impossible_requirement(plant, axis)) {
        throw ConfigError(*requirement);
      }
      throw design_error(
          plant, axis,
          fmt::format("leads to gains that the firmware refuses ({})", dictionary::refusal_reason(refused.parameters)),
          [&](const PlantConfig& changed) { return is_possible(changed, axis); });
    }
  }
  refuse_unstable_loops(plant, params, is_possible);
  return params;
}

}  // namespace trackservo::sim
