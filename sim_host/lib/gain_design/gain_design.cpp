// SPDX-License-Identifier: Apache-2.0
#include "gain_design/gain_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "gain_design/outer_loops.hpp"
#include "gain_design/speed_loop_design.hpp"
#include "gain_design/speed_loop_pi.hpp"
#include "units.hpp"

namespace trackservo::gain_design {
namespace {

double to_double(float value) { return static_cast<double>(value); }
float to_float(double value) { return static_cast<float>(value); }

double peak_torque_nm(const axis_parameters& p) {
  return to_double(p.motor.torque_constant_nm_a) * to_double(p.motor.current_limit_a);
}

double breakaway_nm(const IdentifiedPlant& plant) {
  return to_double(std::max(plant.friction.positive.breakaway_nm, plant.friction.negative.breakaway_nm));
}

void refuse_weak_motor(const IdentifiedPlant& plant, const axis_parameters& present) {
  if (peak_torque_nm(present) <= breakaway_nm(plant)) {
    throw GainDesignError(
        fmt::format("the motor gives {:.3g} Nm at its current limit, but the axis breaks away at {:.3g} Nm: no gains "
                    "move it; check torque constant (0x2055:1) and current limit (0x2055:6)",
                    peak_torque_nm(present), breakaway_nm(plant)));
  }
}

// Limit of the lead of the model's rate over the measured one; it must stay well above the noise of that rate.
void set_lead_limit(const IdentifiedPlant& plant, axis_parameters& p, std::vector<std::string>& notes) {
  constexpr double kUsual_rad_s = 5.0 * kRadPerDeg;
  constexpr double kNoises = 6.0;
  const double n = p.sensors.window_ticks;
  const double rate_noise_rad_s =
      plant.encoder.noise_rad / to_double(SERVO_TICK_S) * std::sqrt(12.0 / (n * (n * n - 1.0)));
  p.friction.lead_limit_rad_s = to_float(std::max(kUsual_rad_s, kNoises * rate_noise_rad_s));
  if (kNoises * rate_noise_rad_s > kUsual_rad_s) {
    notes.push_back(fmt::format("Friction lead limit raised to {:.3g} rad/s: the joint rate has {:.3g} rad/s of noise.",
                                to_double(p.friction.lead_limit_rad_s), rate_noise_rad_s));
  }
}

// With little damping a plain step overshoots.
double setpoint_model_rad_s(const GainRequirements& requirements) {
  constexpr double kFast_hz = 64.0;
  return 2.0 * M_PI * requirements.setpoint_model_hz.value_or(requirements.least_rate_error ? kFast_hz : 0.0);
}

double setpoint_weight(const GainRequirements& requirements) {
  return requirements.setpoint_weight.value_or(setpoint_model_rad_s(requirements) > 0.0 ? 1.0 : 0.8);
}

// Everything except PI, filters and outer loops.
axis_parameters with_plant(const IdentifiedPlant& plant, const GainRequirements& requirements,
                           const axis_parameters& present, std::vector<std::string>& notes) {
  axis_parameters p = present;
  p.speed_loop.setpoint_model_rad_s = to_float(setpoint_model_rad_s(requirements));
  p.speed_loop.setpoint_weight = to_float(setpoint_weight(requirements));
  p.speed_loop.acceleration_inertia_kg_m2 = to_float(plant.inertia_kg_m2);
  p.observer.on = 1;
  p.observer.inertia_kg_m2 = to_float(plant.inertia_kg_m2);
  p.observer.viscous_nm_s_rad = 0.0F;  // the feedforward handles friction
  p.observer.limit_nm = to_float(peak_torque_nm(present));
  p.friction.model = FRICTION_LUGRE;
  p.friction.gain = 1.0F;
  p.friction.sign_width_rad_s = to_float(0.01 * kRadPerDeg);
  set_friction(p, plant.friction);
  set_plant(p, plant);
  set_lead_limit(plant, p, notes);
  return p;
}

// Lowers a bandwidth until the outer loop that `loop_at` makes from it keeps the margins.
template <class LoopAt>
double retained_bandwidth_hz(const char *name, const SpeedLoopDemand& demand, const speed_loop_params& loop,
                             bool required, double bandwidth_hz, LoopAt loop_at, std::vector<std::string>& notes) {
  constexpr int kSteps = 90;  // down to a hundredth
  for (int step = 0; step <= kSteps; ++step) {
    const double lowered_hz = bandwidth_hz * std::pow(0.95, step);
    if (keeps_margins(outer_margins(demand.machines, loop, loop_at(lowered_hz)), demand.least)) {
      if (required && step > 0) {
        notes.push_back(
            fmt::format("{} lowered from {:.3g} Hz to {:.3g} Hz: around this speed loop a higher one does not keep "
                        "{:g} dB and {:g} deg.",
                        name, bandwidth_hz, lowered_hz, demand.least.gain_margin_db, demand.least.phase_margin_deg));
      }
      return lowered_hz;
    }
  }
  throw GainDesignError(
      fmt::format("{}: no bandwidth down to {:.3g} Hz keeps {:g} dB and {:g} deg; require less margin", name,
                  0.01 * bandwidth_hz, demand.least.gain_margin_db, demand.least.phase_margin_deg));
}

OuterLoop crossing_at(double bandwidth_hz) { return {2.0 * M_PI * bandwidth_hz, 0.0, 0.0}; }

OuterLoop tracking_pi(double bandwidth_hz) {
  const double w = tracking_frequency_rad_s(bandwidth_hz, kTrackingDelay_s);
  return {2.0 * w, w * w, kCameraDelay_s};
}

// Without a requirement a tenth of the speed loop: far enough below it to be independent.
void design_outer_loops(const IdentifiedPlant& plant, const GainRequirements& requirements,
                        const SpeedLoopDemand& demand, GainDesign& design) {
  constexpr double kShare = 0.1;
  constexpr double kPaperTracking_hz = 2.0;  // limit with 20 ms of camera delay
  axis_parameters& p = design.parameters;
  const speed_loop_params loop = built(p).speed;
  const double usual_hz = kShare * design.speed_loop_bandwidth_hz;
  const double position_hz =
      retained_bandwidth_hz("Position loop", demand, loop, requirements.position_bandwidth_hz.has_value(),
                            requirements.position_bandwidth_hz.value_or(usual_hz), crossing_at, design.notes);
  p.position_loop.proportional_per_s = to_float(crossing_at(position_hz).proportional_per_s);
  const bool predictive = p.tracking_loop.kind == TRACKER_PREDICTIVE;
  const double tracking_hz = retained_bandwidth_hz(
      "Tracking loop", demand, loop, requirements.tracking_bandwidth_hz.has_value(),
      requirements.tracking_bandwidth_hz.value_or(predictive ? usual_hz : std::min(kPaperTracking_hz, usual_hz)),
      predictive ? crossing_at : tracking_pi, design.notes);
  const OuterLoop tracking = predictive ? crossing_at(tracking_hz) : tracking_pi(tracking_hz);
  p.tracking_loop.proportional_per_s = to_float(tracking.proportional_per_s);
  p.tracking_loop.integral_per_s2 = to_float(tracking.integral_per_s2);
  const double max_rad_s2 = 0.5 * (peak_torque_nm(p) - breakaway_nm(plant)) / plant.inertia_kg_m2;
  if (to_double(p.position_loop.deceleration_rad_s2) > max_rad_s2) {
    design.notes.push_back(fmt::format(
        "Position loop deceleration lowered from {:.3g} rad/s2 to {:.3g} rad/s2, half of the motor's maximum.",
        to_double(p.position_loop.deceleration_rad_s2), max_rad_s2));
    p.position_loop.deceleration_rad_s2 = to_float(max_rad_s2);
  }
}

void predict(const SpeedLoopDemand& demand, GainDesign& design) {
  const speed_loop_params loop = built(design.parameters).speed;
  const LinearMachine& sliding = demand.machines.front();
  design.sliding = worst_margins({sliding}, loop);
  design.pre_sliding = worst_margins({demand.machines[1]}, loop);
  design.speed_loop_bandwidth_hz = closed_loop_bandwidth_hz(sliding, pi_alone(loop));
  design.bandwidth_hz = closed_loop_bandwidth_hz(sliding, loop);
  if (demand.disturbance) {
    design.rate_error = rate_error(sliding, loop, *demand.disturbance, demand.noise);
    design.bound = rate_error_bound(sliding, loop, *demand.disturbance, demand.noise);
  }
  design.torque_noise_nm = 0.0;
  for (const LinearMachine& machine : demand.machines) {
    design.torque_noise_nm = std::max(design.torque_noise_nm, torque_noise_nm(machine, loop, demand.noise));
  }
  design.loop_gain = computed_loop_gain(sliding, loop, log_space(0.5, 450.0, 300));
}

}  // namespace

GainDesign design_gains(const IdentifiedPlant& plant, const GainRequirements& requirements,
                        const axis_parameters& present) {
  constexpr double kUsualNoiseShare = 0.01;
  refuse_weak_motor(plant, present);
  GainDesign design;
  design.parameters = with_plant(plant, requirements, present, design.notes);
  SpeedLoopDemand demand{operating_points(plant, to_double(present.motor.bandwidth_rad_s)),
                         plant.noise(),
                         requirements.least,
                         requirements.max_torque_noise_nm.value_or(kUsualNoiseShare * peak_torque_nm(present)),
                         requirements.disturbance ? requirements.disturbance : plant.disturbance,
                         requirements.least_rate_error};
  if (requirements.least_rate_error && !demand.disturbance) {
    throw GainDesignError(
        "the least rate error needs a disturbance, and the identification found none; give its rms and its corner "
        "frequency");
  }
  if (demand.for_least_error) {
    demand.machines = with_other_inertia(demand.machines);
  }
  design_speed_loop(plant, requirements, demand, design.parameters, design.notes);
  predict(demand, design);
  design_outer_loops(plant, requirements, demand, design);
  built(design.parameters);
  return design;
}

}  // namespace trackservo::gain_design
