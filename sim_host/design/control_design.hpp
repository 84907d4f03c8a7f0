// SPDX-License-Identifier: Apache-2.0
// From a plant's numbers and its design requirements to the firmware's parameters, for each compared controller.
//
// All controllers share the PI, the sensors, the acceleration feedforward and the limits; they differ only as their
// names say; those of the least error are designed without the plant's requirements, if a disturbance is known. All are
// designed from an assumed plant: the result of an identification, or, without one, the plant's inertia and friction
// parameters that are deliberately wrong, every one by +-`friction_parameter_error`.
#ifndef TRACKSERVO_SIM_DESIGN_CONTROL_DESIGN_HPP
#define TRACKSERVO_SIM_DESIGN_CONTROL_DESIGN_HPP

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "design/loop_margins.hpp"
#include "gain_design/gain_design.hpp"
#include "gain_design/speed_loop_pi.hpp"
#include "machine/base/firmware.hpp"
#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

struct ControllerSpec {
  std::string name;   // as in --controller
  std::string title;  // for people
  std::string text;   // its active parts
  bool observer;
  friction_model friction;
  bool least_error = false;  // gains for the least rate error in the disturbance that is known, with a set-point model
};

// Returns pi, pi_vob, pi_ftc, pi_vob_ftc, pi_coulomb, pi_best, least_error.
const std::vector<ControllerSpec>& controller_specs();

// Throws std::invalid_argument with the choices when there is no such controller.
const ControllerSpec& controller_spec(const std::string& name);

using gain_design::PiRequirement;

// Knowledge of both axes for the design of gains.
using AssumedPlant = std::array<gain_design::IdentifiedPlant, kAxes>;

using AxesParameters = std::array<axis_parameters, kAxes>;

struct DesignOptions {
  std::uint64_t seed = 1;                  // draws the signs of the errors
  double friction_parameter_error = 0.15;  // 0 gives the plant's own parameters
  tracker_kind tracker = TRACKER_PI;
  std::optional<AssumedPlant> identified;                    // replaces the plant's own parameters and the errors
  std::optional<AxesParameters> least_error = std::nullopt;  // as design_axes designed them before: spares the search
};

// Returns the plant's requirement for an axis. A requirement given as bandwidth means the bandwidth of the real loop,
// delays included: with PI alone and set-point weight 1, the sliding axis of the assumed plant is at -3 dB there.
PiRequirement pi_requirement(const PlantConfig& plant, int axis, const DesignOptions& options);

// Returns parameters for both axes, accepted by servo_app_configure, with stable speed loops. Throws ConfigError at the
// line of the requirement that cannot be met. Stable loops with less margin than required pass: see margin_warnings().
servo_params design_controller(const PlantConfig& plant, const ControllerSpec& spec, const DesignOptions& options);

// Returns the same for one axis, as the values of the object dictionary; only the firmware's ranges are checked. The
// search for the least error takes some seconds.
axis_parameters design_axis(const PlantConfig& plant, int axis, const ControllerSpec& spec,
                            const DesignOptions& options);

// Returns the same for both axes.
AxesParameters design_axes(const PlantConfig& plant, const ControllerSpec& spec, const DesignOptions& options);

// Returns the plant file's requirements for an axis in the form of the gain design, with the outer loops that
// design_axis gives it.
gain_design::GainRequirements gain_requirements(const PlantConfig& plant, int axis, tracker_kind tracker);

// Sets the PI of one axis from a requirement, for the inertia of the assumed plant.
void set_pi(servo_params& params, int axis, const PiRequirement& requirement);
void set_pi(axis_parameters& parameters, const PiRequirement& requirement);

}  // namespace trackservo::sim

#endif
