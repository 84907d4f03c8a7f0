#include "parameters/axis_tuning.h"

#include <stddef.h>
#include <string.h>

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
                .min_inertia_kg_m2 = scalar_min(set->plant.min_inertia_kg_m2, set->plant.inertia_kg_m2),
                .viscous_nm_s_rad = set->plant.viscous_nm_s_rad,
                .stiffness_nm_rad = set->plant.stiffness_nm_rad,
                .damping_nm_s_rad = set->plant.damping_nm_s_rad,
                .encoder_delay_s = delay_s + set->plant.encoder_delay_s,
                .gyro_delay_s = delay_s + set->plant.gyro_delay_s + 1.0f / set->plant.gyro_bandwidth_rad_s},
      .dt_s = SERVO_TICK_S,
  };
}

/* A value that decides about stability. */
typedef struct {
  uint32_t object;
  uint16_t offset;
  bool whole; /* uint32_t, otherwise float */
} deciding_value;

#define DECIDING(index_, sub_, member_) \
  { PARAMETER_OBJECT(index_, sub_), (uint16_t)offsetof(axis_parameters, member_), false }
#define DECIDING_WHOLE(index_, sub_, member_) \
  { PARAMETER_OBJECT(index_, sub_), (uint16_t)offsetof(axis_parameters, member_), true }

/* Of equal changes the first counts. The last one is named when nothing has changed: a set that is refused then does
 * not suit its plant. */
static const deciding_value kDeciding[] = {
    DECIDING(0x2000, 1, speed_loop.proportional_nm_s_rad),
    DECIDING(0x2000, 2, speed_loop.integral_nm_rad),
    DECIDING(0x2020, 4, observer.bandwidth_rad_s),
    DECIDING(0x2020, 2, observer.inertia_kg_m2),
    DECIDING_WHOLE(0x2020, 1, observer.on),
    DECIDING(0x2040, 4, filters.lowpass_hz),
    DECIDING(0x2040, 5, filters.lowpass_damping),
    DECIDING(0x2040, 1, filters.notch_hz),
    DECIDING(0x2040, 2, filters.notch_width_hz),
    DECIDING(0x2040, 3, filters.notch_depth),
    DECIDING_WHOLE(0x2050, 3, sensors.window_ticks),
    DECIDING(0x2050, 2, sensors.crossover_rad_s),
    DECIDING_WHOLE(0x2050, 1, sensors.source),
    DECIDING(0x2010, 1, position_loop.proportional_per_s),
    DECIDING(0x2011, 2, tracking_loop.proportional_per_s),
    DECIDING(0x2011, 3, tracking_loop.integral_per_s2),
    DECIDING_WHOLE(0x2011, 1, tracking_loop.kind),
    DECIDING(0x2000, 3, speed_loop.setpoint_weight),
    DECIDING(0x2055, 5, motor.bandwidth_rad_s),
    DECIDING(0x2056, 1, plant.inertia_kg_m2),
};
enum { DECIDING_VALUES = sizeof kDeciding / sizeof kDeciding[0] };

static float value_in(const axis_parameters *set, const deciding_value *value) {
  const char *place = (const char *)set + value->offset;
  if (value->whole) {
    uint32_t whole;
    memcpy(&whole, place, sizeof whole);
    return (float)whole;
  }
  float real;
  memcpy(&real, place, sizeof real);
  return real;
}

/* How far two values are apart, 0 .. 1. */
static float change_of(const axis_tuning *tuning, const deciding_value *value) {
  const float staged = value_in(&tuning->staged, value);
  const float active = value_in(&tuning->active, value);
  const float larger = scalar_max(scalar_abs(staged), scalar_abs(active));
  return larger > 0.0f ? scalar_abs(staged - active) / larger : 0.0f;
}

/* What was active is right, and nothing is known beyond it. */
static parameter_refusal unstable(const axis_tuning *tuning) {
  const deciding_value *worst = &kDeciding[DECIDING_VALUES - 1];
  float most = 0.0f;
  for (int i = 0; i < DECIDING_VALUES; ++i) {
    const float change = change_of(tuning, &kDeciding[i]);
    if (change > most) {
      most = change;
      worst = &kDeciding[i];
    }
  }
  const float active = value_in(&tuning->active, worst);
  return (parameter_refusal){.status = CONTROL_UNSTABLE, .object = worst->object, .low = active, .high = active};
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
