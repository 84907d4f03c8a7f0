#include "parameters/axis_parameters.h"

#include "base/crc32.h"
#include "base/scalar.h"
#include "servo/servo_app.h"

_Static_assert(sizeof(axis_parameters) % 4 == 0, "there must be no padding in what the CRC covers");

static lugre_direction direction_of(const axis_friction_direction *d) {
  return (lugre_direction){
      .coulomb_nm = d->coulomb_nm,
      .breakaway_nm = d->breakaway_nm,
      .stribeck_speed_rad_s = d->stribeck_speed_rad_s,
      .viscous_nm_s_rad = d->viscous_nm_s_rad,
  };
}

static friction_feedforward_params friction_of(const axis_parameters *p) {
  return (friction_feedforward_params){
      .model = (friction_model)p->friction.model,
      .gain = p->friction.gain,
      .lead_limit_rad_s = p->friction.lead_limit_rad_s,
      .sign_width_rad_s = p->friction.sign_width_rad_s,
      .lugre = {.stiffness_nm_rad = p->friction.stiffness_nm_rad,
                .damping_nm_s_rad = p->friction.damping_nm_s_rad,
                .positive = direction_of(&p->friction.positive),
                .negative = direction_of(&p->friction.negative)},
  };
}

/* Frequency 0 switches a filter off. */
static control_status design_filters(const axis_parameters *p, speed_loop_params *speed) {
  const float rad_per_turn = 2.0f * SCALAR_PI;
  speed->notch = biquad_pass();
  speed->lowpass = biquad_pass();
  control_status status = CONTROL_OK;
  if (p->filters.notch_hz != 0.0f) {
    status = biquad_design_notch(&speed->notch, rad_per_turn * p->filters.notch_hz,
                                 rad_per_turn * p->filters.notch_width_hz, p->filters.notch_depth, SERVO_TICK_S);
  }
  if (status == CONTROL_OK && p->filters.lowpass_hz != 0.0f) {
    status = biquad_design_lowpass(&speed->lowpass, rad_per_turn * p->filters.lowpass_hz, p->filters.lowpass_damping,
                                   SERVO_TICK_S);
  }
  return status;
}

static control_status build_speed_loop(const axis_parameters *p, speed_loop_params *speed) {
  speed->rate_estimator.window_ticks = (int)p->sensors.window_ticks;
  speed->rate_fusion.source = (rate_source)p->sensors.source;
  speed->rate_fusion.crossover_rad_s = p->sensors.crossover_rad_s;
  speed->pi.proportional_gain = p->speed_loop.proportional_nm_s_rad;
  speed->pi.integral_gain = p->speed_loop.integral_nm_rad;
  speed->pi.setpoint_weight = p->speed_loop.setpoint_weight;
  speed->pi.tracking_rate_per_s = p->speed_loop.tracking_rate_per_s;
  speed->acceleration_inertia_kg_m2 = p->speed_loop.acceleration_inertia_kg_m2;
  speed->observer_on = p->observer.on != 0;
  speed->observer.inertia_kg_m2 = p->observer.inertia_kg_m2;
  speed->observer.viscous_nm_s_rad = p->observer.viscous_nm_s_rad;
  speed->observer.bandwidth_rad_s = p->observer.bandwidth_rad_s;
  speed->observer.limit_nm = p->observer.limit_nm;
  speed->friction = friction_of(p);
  return design_filters(p, speed);
}

control_status axis_parameters_build(const axis_parameters *parameters, servo_axis_params *built) {
  const axis_parameters *p = parameters;
  servo_axis_params all = {
      .position = {.proportional_per_s = p->position_loop.proportional_per_s,
                   .rate_limit_rad_s = p->position_loop.rate_limit_rad_s,
                   .deceleration_rad_s2 = p->position_loop.deceleration_rad_s2},
      .tracker = {.kind = (tracker_kind)p->tracking_loop.kind,
                  .proportional_per_s = p->tracking_loop.proportional_per_s,
                  .integral_per_s2 = p->tracking_loop.integral_per_s2,
                  .estimator_rad_s = p->tracking_loop.estimator_rad_s,
                  .rate_limit_rad_s = p->position_loop.rate_limit_rad_s,
                  .coast_s = p->tracking_loop.coast_s},
      .torque_constant_nm_a = p->motor.torque_constant_nm_a,
      .resistance_ohm = p->motor.resistance_ohm,
      .current_limit_a = p->motor.current_limit_a,
  };
  control_status status = build_speed_loop(p, &all.speed);
  if (status == CONTROL_OK) {
    status = current_loop_design(&all.current, p->motor.resistance_ohm, p->motor.inductance_h,
                                 p->motor.back_emf_v_s_rad, p->motor.bandwidth_rad_s, SERVO_PWM_PERIOD_S);
  }
  if (status == CONTROL_OK) {
    status = servo_axis_check(&all, SERVO_TICK_S, SERVO_PWM_PERIOD_S);
  }
  if (status == CONTROL_OK) {
    *built = all;
  }
  return status;
}

uint32_t axis_parameters_crc(const axis_parameters *parameters) {
  return crc32_end(crc32_add(CRC32_START, (const uint8_t *)parameters, sizeof *parameters));
}
