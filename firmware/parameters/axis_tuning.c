#include "parameters/axis_tuning.h"

#include "servo/servo_axis.h"

control_status axis_tuning_start(axis_tuning *tuning, const axis_parameters *parameters, servo_axis_params *in_force) {
  const control_status status = axis_parameters_build(parameters, in_force);
  if (status == CONTROL_OK) {
    tuning->staged = *parameters;
    tuning->active = *parameters;
    tuning->previous = *parameters;
    tuning->proven = *parameters;
    tuning->proven_is_active = true;
    tuning->quiet_ticks = 0;
    tuning->active_crc = axis_parameters_crc(parameters);
    tuning->stored_crc = 0;
    tuning->last_result = CONTROL_OK;
    tuning->refusal = (parameter_refusal){.status = CONTROL_OK};
  }
  return status;
}

static void activate(axis_tuning *tuning, const axis_parameters *set) {
  tuning->previous = tuning->active;
  tuning->active = *set;
  tuning->active_crc = axis_parameters_crc(&tuning->active);
  tuning->proven_is_active = tuning->active_crc == axis_parameters_crc(&tuning->proven);
  tuning->quiet_ticks = 0;
}

control_status axis_tuning_apply(axis_tuning *tuning, servo_axis *axis, servo_axis_params *in_force, float tick_s) {
  servo_axis_params next;
  const control_status status = axis_parameters_build(&tuning->staged, &next);
  tuning->last_result = (uint32_t)status;
  if (status == CONTROL_OK) {
    servo_axis_retune(axis, in_force, &next, tick_s);
    activate(tuning, &tuning->staged);
    tuning->refusal = (parameter_refusal){.status = CONTROL_OK};
  } else {
    tuning->refusal = axis_parameters_check(&tuning->staged);
  }
  return status;
}

void axis_tuning_revert(axis_tuning *tuning) { tuning->staged = tuning->active; }

control_status axis_tuning_undo(axis_tuning *tuning, servo_axis *axis, servo_axis_params *in_force, float tick_s) {
  tuning->staged = tuning->previous;
  return axis_tuning_apply(tuning, axis, in_force, tick_s);
}

void axis_tuning_ran(axis_tuning *tuning, bool closed) {
  if (!closed || tuning->proven_is_active) {
    return;
  }
  tuning->quiet_ticks++;
  if (tuning->quiet_ticks >= AXIS_TUNING_PROVEN_TICKS) {
    tuning->proven = tuning->active;
    tuning->proven_is_active = true;
  }
}

void axis_tuning_take_back(axis_tuning *tuning, servo_axis *axis, servo_axis_params *in_force, float holding_nm,
                           float tick_s) {
  servo_axis_params next;
  if (axis_parameters_build(&tuning->proven, &next) == CONTROL_OK) { /* it was in effect */
    servo_axis_replace(axis, in_force, &next, holding_nm, tick_s);
    activate(tuning, &tuning->proven);
    tuning->previous = tuning->active; /* 2070:1 = 3 must not bring the other set back */
  }
}

void axis_tuning_refresh(axis_tuning *tuning) {
  const bool staged = axis_parameters_crc(&tuning->staged) != tuning->active_crc;
  const bool dirty = tuning->active_crc != tuning->stored_crc;
  tuning->flags = (staged ? AXIS_TUNING_STAGED : 0u) | (dirty ? AXIS_TUNING_DIRTY : 0u);
}
