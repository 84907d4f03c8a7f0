/* SPDX-License-Identifier: Apache-2.0 */
#include "cortex_m4/core_trace.h"

#include <string.h>

#include "parameters/axis_parameter_list.h"

static float visit_float(const trace_visitor *visitor, const char *name, float value) {
  uint32_t word;
  memcpy(&word, &value, sizeof word);
  word = visitor->word(visitor->context, name, word);
  memcpy(&value, &word, sizeof word);
  return value;
}

#define FLOAT(value) ((value) = visit_float(visitor, #value, value))
#define INTEGER(type, value) ((value) = (type)visitor->word(visitor->context, #value, (uint32_t)(value)))

void trace_visit_event(const trace_visitor *visitor, trace_event *event) { INTEGER(trace_event, *event); }

static void visit_biquad(const trace_visitor *visitor, biquad_params *biquad) {
  FLOAT(biquad->b0);
  FLOAT(biquad->b1);
  FLOAT(biquad->b2);
  FLOAT(biquad->a1);
  FLOAT(biquad->a2);
}

static void visit_pi(const trace_visitor *visitor, pi_controller_params *pi) {
  FLOAT(pi->proportional_gain);
  FLOAT(pi->integral_gain);
  FLOAT(pi->setpoint_weight);
  FLOAT(pi->tracking_rate_per_s);
}

/* What the parameter list copies into the blocks is visited by the list, the rest here: what is designed, and the one
 * value that has two users. */
void trace_visit_params(const trace_visitor *visitor, servo_params *params) {
#define VISIT_NOTHING(...)
#define VISIT_REAL(index_, sub_, flags_, group_, member_, low_, high_, default_, unit_, name_, help_, to_) \
  FLOAT(axis->to_);
#define VISIT_WHOLE(index_, sub_, flags_, group_, member_, low_, high_, default_, name_, help_, to_, type_) \
  INTEGER(type_, axis->to_);
#define VISIT_DIRECTION(sub_, side_, title_) FRICTION_DIRECTION_ROWS(VISIT_REAL, sub_, side_, title_)
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_axis_params *axis = &params->axis[i];
    AXIS_PARAMETERS(VISIT_NOTHING, VISIT_REAL, VISIT_NOTHING, VISIT_WHOLE, VISIT_DIRECTION, VISIT_NOTHING)
    FLOAT(axis->tracker.rate_limit_rad_s);
    FLOAT(axis->speed.setpoint_model.decay);
    FLOAT(axis->speed.setpoint_model.gain_per_s);
    visit_biquad(visitor, &axis->speed.notch);
    visit_biquad(visitor, &axis->speed.lowpass);
    visit_pi(visitor, &axis->current.pi);
    FLOAT(axis->current.back_emf_v_s_rad);
    FLOAT(axis->current.duty_limit);
  }
}

void trace_visit_command(const trace_visitor *visitor, servo_command *command) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_axis_command *axis = &command->axis[i];
    INTEGER(servo_mode, axis->mode);
    FLOAT(axis->speed.rate_rad_s);
    FLOAT(axis->speed.acceleration_rad_s2);
    INTEGER(angle_turn32, axis->position);
    FLOAT(axis->rate_limit_rad_s);
    FLOAT(axis->torque_nm);
    INTEGER(bool, axis->torque_limited);
    FLOAT(axis->limits.minimum_nm);
    FLOAT(axis->limits.maximum_nm);
  }
}

void trace_visit_samples(const trace_visitor *visitor, servo_samples *samples) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    hal_axis_samples *axis = &samples->axis[i].sensors;
    INTEGER(angle_turn32, axis->joint_angle_turn32);
    FLOAT(axis->gyro_rad_s);
    INTEGER(bool, axis->gyro_valid);
    INTEGER(bool, axis->encoder_failed);
    FLOAT(axis->mean_current_a);
  }
  FLOAT(samples->bus_voltage_v);
  FLOAT(samples->pitch.sine);
  FLOAT(samples->pitch.cosine);
}

void trace_visit_period(const trace_visitor *visitor, trace_period *period) {
  INTEGER(uint32_t, period->number);
  for (int i = 0; i < SERVO_AXES; ++i) {
    FLOAT(period->current_a[i]);
  }
  FLOAT(period->bus_voltage_v);
}

void trace_visit_tick_results(const trace_visitor *visitor, servo_axis_samples *samples, servo_axis *axis) {
  INTEGER(bool, samples->motor_limited);
  FLOAT(samples->tick_voltage_v);
  INTEGER(servo_mode, axis->mode);
  FLOAT(axis->signals.rates.joint_rate_rad_s);
  FLOAT(axis->signals.rates.base_rate_rad_s);
  FLOAT(axis->signals.rates.rate_rad_s);
  FLOAT(axis->signals.rates.feedback_rad_s);
  FLOAT(axis->signals.reference.rate_rad_s);
  FLOAT(axis->signals.reference.acceleration_rad_s2);
  FLOAT(axis->signals.torque.torque_nm);
  FLOAT(axis->signals.torque.pi_nm);
  FLOAT(axis->signals.torque.acceleration_nm);
  FLOAT(axis->signals.torque.disturbance_nm);
  FLOAT(axis->signals.torque.friction_nm);
  INTEGER(bool, axis->signals.torque.limited);
  FLOAT(axis->commanded_nm);
  FLOAT(axis->current_reference_a);
}

void trace_visit_duty(const trace_visitor *visitor, float *duty) { FLOAT(*duty); }
