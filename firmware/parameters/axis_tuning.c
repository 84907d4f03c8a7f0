#include "parameters/axis_tuning.h"

#include <math.h>

#include "base/scalar.h"
#include "servo/servo_axis.h"
#include "servo/servo_timing.h"

control_status axis_tuning_start(axis_tuning *tuning, const axis_parameters *parameters, servo_axis_params *in_force) {
  const control_status status = axis_parameters_build(parameters, in_force);
  if (status == CONTROL_OK) {
    tuning->staged = *parameters;
    tuning->active = *parameters;
    tuning->previous = *parameters;
    tuning->proven = *parameters;
    tuning->proven_is_active = true;
    tuning->quiet_ticks = 0;
    tuning->overridden = false;
    tuning->judging = false;
    tuning->active_crc = axis_parameters_crc(parameters);
    tuning->stored_crc = 0;
    tuning->last_result = CONTROL_OK;
    tuning->refusal = (parameter_refusal){.status = CONTROL_OK};
  }
  return status;
}

enum { COMPARED_VALUES = 20 };

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

/* --- stability ---------------------------------------------------------------------------------------------------- */

/* Until the set-points of a tick take effect, and the current follows. */
static float command_delay_s(const axis_parameters *set) {
  return (float)SERVO_TICK_LATENCY_PERIODS * SERVO_PWM_PERIOD_S + 1.0f / set->motor.bandwidth_rad_s;
}

static void input_of(const axis_parameters *set, const servo_axis_params *built, loop_stability_input *input) {
  const float delay_s = command_delay_s(set);
  *input = (loop_stability_input){
      .speed = built->speed,
      .position_per_s = set->position_loop.proportional_per_s,
      .tracker = built->tracker,
      .plant = {.inertia_kg_m2 = set->plant.inertia_kg_m2,
                .least_inertia_kg_m2 = scalar_min(set->plant.least_inertia_kg_m2, set->plant.inertia_kg_m2),
                .viscous_nm_s_rad = set->plant.viscous_nm_s_rad,
                .stiffness_nm_rad = set->plant.stiffness_nm_rad,
                .damping_nm_s_rad = set->plant.damping_nm_s_rad,
                .encoder_delay_s = delay_s + set->plant.encoder_delay_s,
                .gyro_delay_s = delay_s + set->plant.gyro_delay_s + 1.0f / set->plant.gyro_bandwidth_rad_s},
      .dt_s = SERVO_TICK_S,
  };
}

/* A value that decides about stability: in the staged and in the active set. */
typedef struct {
  uint32_t object;
  float staged;
  float active;
} compared_value;

/* The sub-indices of the innermost loop come first: of equal changes the first counts. */
static void compare(const axis_parameters *s, const axis_parameters *a, compared_value values[]) {
  const compared_value all[] = {
      {PARAMETER_OBJECT(0x2000, 1), s->speed_loop.proportional_nm_s_rad, a->speed_loop.proportional_nm_s_rad},
      {PARAMETER_OBJECT(0x2000, 2), s->speed_loop.integral_nm_rad, a->speed_loop.integral_nm_rad},
      {PARAMETER_OBJECT(0x2020, 4), s->observer.bandwidth_rad_s, a->observer.bandwidth_rad_s},
      {PARAMETER_OBJECT(0x2020, 2), s->observer.inertia_kg_m2, a->observer.inertia_kg_m2},
      {PARAMETER_OBJECT(0x2020, 1), (float)s->observer.on, (float)a->observer.on},
      {PARAMETER_OBJECT(0x2040, 4), s->filters.lowpass_hz, a->filters.lowpass_hz},
      {PARAMETER_OBJECT(0x2040, 5), s->filters.lowpass_damping, a->filters.lowpass_damping},
      {PARAMETER_OBJECT(0x2040, 1), s->filters.notch_hz, a->filters.notch_hz},
      {PARAMETER_OBJECT(0x2040, 2), s->filters.notch_width_hz, a->filters.notch_width_hz},
      {PARAMETER_OBJECT(0x2040, 3), s->filters.notch_depth, a->filters.notch_depth},
      {PARAMETER_OBJECT(0x2050, 3), (float)s->sensors.window_ticks, (float)a->sensors.window_ticks},
      {PARAMETER_OBJECT(0x2050, 2), s->sensors.crossover_rad_s, a->sensors.crossover_rad_s},
      {PARAMETER_OBJECT(0x2050, 1), (float)s->sensors.source, (float)a->sensors.source},
      {PARAMETER_OBJECT(0x2010, 1), s->position_loop.proportional_per_s, a->position_loop.proportional_per_s},
      {PARAMETER_OBJECT(0x2011, 2), s->tracking_loop.proportional_per_s, a->tracking_loop.proportional_per_s},
      {PARAMETER_OBJECT(0x2011, 3), s->tracking_loop.integral_per_s2, a->tracking_loop.integral_per_s2},
      {PARAMETER_OBJECT(0x2011, 1), (float)s->tracking_loop.kind, (float)a->tracking_loop.kind},
      {PARAMETER_OBJECT(0x2000, 3), s->speed_loop.setpoint_weight, a->speed_loop.setpoint_weight},
      {PARAMETER_OBJECT(0x2055, 5), s->motor.bandwidth_rad_s, a->motor.bandwidth_rad_s},
      {PARAMETER_OBJECT(0x2056, 1), s->plant.inertia_kg_m2, a->plant.inertia_kg_m2},
  };
  _Static_assert(sizeof all / sizeof all[0] == COMPARED_VALUES, "the caller's array has this size");
  for (int i = 0; i < COMPARED_VALUES; ++i) {
    values[i] = all[i];
  }
}

/* How far two values are apart, 0 .. 1. */
static float change_of(const compared_value *value) {
  const float larger = scalar_max(scalar_abs(value->staged), scalar_abs(value->active));
  return larger > 0.0f ? scalar_abs(value->staged - value->active) / larger : 0.0f;
}

/* A set that is refused although it differs in nothing from the active one does not suit its plant: its inertia. */
static parameter_refusal unstable(const axis_tuning *tuning) {
  compared_value values[COMPARED_VALUES];
  compare(&tuning->staged, &tuning->active, values);
  compared_value worst = values[COMPARED_VALUES - 1];
  float change = 0.0f;
  for (int i = 0; i < COMPARED_VALUES; ++i) {
    if (change_of(&values[i]) > change) {
      change = change_of(&values[i]);
      worst = values[i];
    }
  }
  /* What was active is right, and nothing is known beyond it. */
  return (parameter_refusal){
      .status = CONTROL_UNSTABLE, .object = worst.object, .low = worst.active, .high = worst.active};
}

static bool start_judging(axis_tuning *tuning, uint32_t crc) {
  servo_axis_params built;
  if (axis_parameters_build(&tuning->staged, &built) != CONTROL_OK) {
    return false;
  }
  input_of(&tuning->staged, &built, &tuning->judged);
  loop_stability_start(&tuning->judgement);
  tuning->judged_crc = crc;
  tuning->judging = true;
  return true;
}

loop_verdict axis_tuning_judge(axis_tuning *tuning) {
  const uint32_t crc = axis_parameters_crc(&tuning->staged);
  if ((!tuning->judging || tuning->judged_crc != crc) && !start_judging(tuning, crc)) {
    return LOOP_STABLE;
  }
  const loop_verdict verdict = loop_stability_step(&tuning->judgement, &tuning->judged, AXIS_TUNING_SLICE);
  tuning->judging = verdict == LOOP_RUNNING;
  if (verdict == LOOP_REFUSED) {
    tuning->last_result = (uint32_t)CONTROL_UNSTABLE;
    tuning->refusal = unstable(tuning);
  }
  return verdict;
}

void axis_tuning_revert(axis_tuning *tuning) { tuning->staged = tuning->active; }

control_status axis_tuning_undo(axis_tuning *tuning, servo_axis *axis, servo_axis_params *in_force, float tick_s) {
  axis_tuning_stage_previous(tuning);
  return axis_tuning_apply(tuning, axis, in_force, tick_s);
}

void axis_tuning_stage_previous(axis_tuning *tuning) { tuning->staged = tuning->previous; }

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
