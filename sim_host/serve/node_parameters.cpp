#include "serve/node_parameters.hpp"

#include "experiments/control_design.hpp"

namespace trackservo::sim {
namespace {

axis_friction_direction direction_of(const lugre_direction& d) {
  return {d.coulomb_nm, d.breakaway_nm, d.stribeck_speed_rad_s, d.viscous_nm_s_rad};
}

void set_speed_loop(axis_parameters& p, const speed_loop_params& speed) {
  p.speed_loop = {speed.pi.proportional_gain, speed.pi.integral_gain, speed.pi.setpoint_weight,
                  speed.pi.tracking_rate_per_s, speed.acceleration_inertia_kg_m2};
  p.observer = {speed.observer_on ? 1U : 0U, speed.observer.inertia_kg_m2, speed.observer.viscous_nm_s_rad,
                speed.observer.bandwidth_rad_s, speed.observer.limit_nm};
  p.friction.model = static_cast<std::uint32_t>(speed.friction.model);
  p.friction.gain = speed.friction.gain;
  p.friction.lead_limit_rad_s = speed.friction.lead_limit_rad_s;
  p.friction.sign_width_rad_s = speed.friction.sign_width_rad_s;
  p.friction.stiffness_nm_rad = speed.friction.lugre.stiffness_nm_rad;
  p.friction.damping_nm_s_rad = speed.friction.lugre.damping_nm_s_rad;
  p.friction.positive = direction_of(speed.friction.lugre.positive);
  p.friction.negative = direction_of(speed.friction.lugre.negative);
  p.filters = {0.0F, 10.0F, 0.1F, 0.0F, 0.7F};
  p.sensors = {static_cast<std::uint32_t>(speed.rate_fusion.source), speed.rate_fusion.crossover_rad_s,
               static_cast<std::uint32_t>(speed.rate_estimator.window_ticks)};
}

}  // namespace

axis_parameters node_parameters(const PlantConfig& plant, int axis) {
  DesignOptions options;
  options.tracker = TRACKER_PREDICTIVE;
  const servo_params designed = design_controller(plant, controller_spec("pi_vob_ftc"), options);
  const servo_axis_params& built = designed.axis[axis];
  const MotorConfig& motor = plant.axis[static_cast<std::size_t>(axis)].motor;
  const DesignConfig& design = plant.design[static_cast<std::size_t>(axis)];
  axis_parameters p{};
  set_speed_loop(p, built.speed);
  p.position_loop = {built.position.proportional_per_s, built.position.rate_limit_rad_s,
                     built.position.deceleration_rad_s2};
  p.tracking_loop = {static_cast<std::uint32_t>(built.tracker.kind), built.tracker.proportional_per_s,
                     built.tracker.integral_per_s2, built.tracker.estimator_rad_s, built.tracker.coast_s};
  p.motor = {built.torque_constant_nm_a,
             static_cast<float>(motor.resistance_ohm),
             static_cast<float>(motor.inductance_h),
             static_cast<float>(motor.back_emf_constant_v_s_rad),
             static_cast<float>(2.0 * kPi * design.current_loop_bandwidth_hz),
             built.current_limit_a};
  return p;
}

}  // namespace trackservo::sim
