// SPDX-License-Identifier: Apache-2.0
// The machine with the firmware's servo on it, as `sim_host run` has it. Its inputs are the set-points of both axes.
#include <fmt/format.h>

#include <memory>
#include <optional>
#include <stdexcept>

#include "design/control_design.hpp"
#include "machine/run/machine.hpp"
#include "machine_variables.hpp"
#include "unit.hpp"

namespace trackservo::fmi {
namespace {

constexpr double kMostFrictionError = 0.5;

class ServoUnit : public Unit {
 public:
  explicit ServoUnit(std::filesystem::path resources) : resources_(std::move(resources)) {
    choice_.add_to(variables_);
    variables_.push_back({"controller", Causality::kParameter, "",
                          "One of those of `sim_host run`: pi, pi_vob, pi_ftc, pi_vob_ftc, pi_coulomb, least_error",
                          &controller_});
    variables_.push_back({"friction_parameter_error", Causality::kParameter, "",
                          "Share by which each friction parameter that the controller knows is off", &friction_error_});
    for (std::size_t i = 0; i < sim::kAxes; ++i) {
      add_axis(i);
    }
    truth_.add_to(variables_);
  }

  void start() override {
    if (!(friction_error_ >= 0.0 && friction_error_ <= kMostFrictionError)) {
      throw std::invalid_argument(
          fmt::format("friction_parameter_error: {:g}; expected 0 to {:g}.", friction_error_, kMostFrictionError));
    }
    const sim::PlantConfig plant = choice_.plant(resources_);
    sim::DesignOptions options;
    options.seed = choice_.seed;
    options.friction_parameter_error = friction_error_;
    const servo_params params = sim::design_controller(plant, designed_controller(), options);
    machine_.emplace(plant, params, choice_.seed, choice_.start_angle_rad);
    renew_outputs();
  }

  void step() override {
    for (std::size_t i = 0; i < sim::kAxes; ++i) {
      servo_axis_command& command = machine_->command().axis[i];
      command.mode = axis_[i].enabled ? SERVO_SPEED : SERVO_OFF;
      command.speed = {static_cast<float>(axis_[i].rate_set_point_rad_s),
                       static_cast<float>(axis_[i].acceleration_set_point_rad_s2)};
      machine_->inject_torque(static_cast<int>(i), axis_[i].disturbance_nm);
      machine_->broken().axis[i].push_nm = axis_[i].external_torque_nm;
    }
    machine_->advance_period();
    renew_outputs();
  }

 private:
  struct Axis {
    bool enabled = true;
    double rate_set_point_rad_s = 0;
    double acceleration_set_point_rad_s2 = 0;
    double external_torque_nm = 0;
    double disturbance_nm = 0;
    AxisReadings readings;
    double measured_rate_rad_s = 0;
    double torque_command_nm = 0;
    double friction_feedforward_nm = 0;
    double disturbance_estimate_nm = 0;
    double duty = 0;
    bool bridge_on = false;
  };

  // `sim_host run` searches for pi_best in runs of its scenario; here is none.
  const sim::ControllerSpec& designed_controller() const {
    if (controller_ == "pi_best") {
      throw std::invalid_argument(
          "controller: pi_best belongs to one scenario of 'sim_host run'; expected pi, pi_vob, "
          "pi_ftc, pi_vob_ftc, pi_coulomb or least_error.");
    }
    return sim::controller_spec(controller_);
  }

  void add_axis(std::size_t i) {
    Axis& axis = axis_[i];
    const auto input = [this, i](const char *name, const char *unit, const char *description, auto *value,
                                 double bound = 0) {
      variables_.push_back({of_axis(i, name), Causality::kInput, unit, description, value, bound});
    };
    const auto output = [this, i](const char *name, const char *unit, const char *description, auto *value) {
      variables_.push_back({of_axis(i, name), Causality::kOutput, unit, description, value});
    };
    input("enabled", "", "Whether the axis is controlled; its motor's terminals are open otherwise", &axis.enabled);
    input("rate_set_point_rad_s", "rad/s", "Inertial rate that the axis shall have; read each 1 ms",
          &axis.rate_set_point_rad_s, kRateBound_rad_s);
    input("acceleration_set_point_rad_s2", "rad/s2", "Derivative of the rate set-point, for the feedforward",
          &axis.acceleration_set_point_rad_s2, kAccelerationBound_rad_s2);
    input("external_torque_nm", "N.m", "Torque on the joint from outside, positive forward; read each 1 ms",
          &axis.external_torque_nm, kTorqueBound_nm);
    input("disturbance_nm", "N.m",
          "Torque added to the set-point of the current loop, which the controller does not know", &axis.disturbance_nm,
          kTorqueBound_nm);
    axis.readings.add_to(variables_, sim::axis_name(static_cast<int>(i)));
    output("measured_rate_rad_s", "rad/s", "Feedback of the speed loop", &axis.measured_rate_rad_s);
    output("torque_command_nm", "N.m", "Torque set-point of the controller", &axis.torque_command_nm);
    output("friction_feedforward_nm", "N.m", "Its part that compensates friction", &axis.friction_feedforward_nm);
    output("disturbance_estimate_nm", "N.m", "Its part of the disturbance observer", &axis.disturbance_estimate_nm);
    output("duty", "", "Duty of the bridge in the coming PWM period, -1 to 1", &axis.duty);
    output("bridge_on", "", "Whether the bridge drives the motor in the coming PWM period", &axis.bridge_on);
  }

  void renew_outputs() {
    for (std::size_t i = 0; i < sim::kAxes; ++i) {
      const int axis = static_cast<int>(i);
      const servo_axis_signals& signals = machine_->firmware(axis).signals;
      axis_[i].readings.renew(machine_->samples().axis[i].sensors);
      axis_[i].measured_rate_rad_s = static_cast<double>(signals.rates.feedback_rad_s);
      axis_[i].torque_command_nm = static_cast<double>(signals.torque.torque_nm);
      axis_[i].friction_feedforward_nm = static_cast<double>(signals.torque.friction_nm);
      axis_[i].disturbance_estimate_nm = static_cast<double>(signals.torque.disturbance_nm);
      axis_[i].duty = machine_->duty(axis);
      axis_[i].bridge_on = machine_->bridge_on(axis);
    }
    truth_.renew(machine_->truth());
  }

  std::filesystem::path resources_;
  MachineChoice choice_;
  std::string controller_ = "pi_vob_ftc";
  double friction_error_ = 0.15;
  MachineTruth truth_;
  std::array<Axis, sim::kAxes> axis_;
  std::optional<sim::Machine> machine_;
};

}  // namespace

UnitKind unit_kind() {
  return {"trackservo_servo",
          "Two-axis tracker with the firmware's servo: PI, disturbance observer, LuGre feedforward"};
}

std::unique_ptr<Unit> make_unit(const std::filesystem::path& resources) {
  return std::make_unique<ServoUnit>(resources);
}

}  // namespace trackservo::fmi
