/* SPDX-License-Identifier: Apache-2.0 */
#include "parameters/axis_tuning.h"

#include <stddef.h>
#include <string.h>

#include "base/scalar.h"
#include "parameters/axis_dictionary.h"
#include "parameters/feedforward_check.h"
#include "servo/servo_axis.h"
#include "servo/servo_timing.h"

control_status axis_tuning_start(axis_tuning *tuning, const axis_parameters *parameters, servo_axis_params *in_force) {
  const control_status status = axis_parameters_build(parameters, in_force);
  if (status == CONTROL_OK) {
    tuning->staged = *parameters;
    tuning->active = *parameters;
    tuning->changes++;
    tuning->previous = *parameters;
    tuning->proven = *parameters;
    tuning->proven_is_active = true;
    tuning->can_take_back = false;
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

/* All guarded values are equal. Without the table, because a change of the set has little time: 20 comparisons. */
#define SAME_NOTHING(...)
#define SAME_ROW(index_, sub_, flags_, group_, member_, ...) \
  same = same && (((flags_)&OD_GUARDED) == 0 || one->group_.member_ == other->group_.member_);
#define SAME_DIRECTION(sub_, side_, title_) FRICTION_DIRECTION_ROWS(SAME_ROW, sub_, side_, title_)
static bool names_same_machine(const axis_parameters *one, const axis_parameters *other) {
  bool same = true;
  AXIS_PARAMETERS(SAME_NOTHING, SAME_ROW, SAME_ROW, SAME_ROW, SAME_DIRECTION, SAME_NOTHING)
  return same;
}

static bool are_same(const axis_parameters *one, const axis_parameters *other) {
  return memcmp((const uint8_t *)one, (const uint8_t *)other, sizeof *one) == 0;
}

static void activate(axis_tuning *tuning, const axis_parameters *set) {
  tuning->previous = tuning->active;
  tuning->active = *set;
  tuning->changes++;
  tuning->active_crc = axis_parameters_crc(&tuning->active);
  tuning->proven_is_active = are_same(&tuning->active, &tuning->proven);
  tuning->can_take_back = !tuning->proven_is_active && names_same_machine(&tuning->active, &tuning->proven);
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

static void input_of(const axis_parameters *set, const servo_axis_params *built, bool gains_follow,
                     loop_stability_input *input) {
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
      .gains_follow = gains_follow,
      .gyro_vanishes = gains_follow && built->gyro == GYRO_ON_LINE_OF_SIGHT,
      .gyro_below = built->gyro == GYRO_BELOW_JOINT,
      .dt_s = SERVO_TICK_S,
  };
}

/* Whether each member of axis_parameters decides about stability. */
#define DECIDES_NOTHING(...)
#define DECIDES_ROW(index_, sub_, flags_, ...) ((flags_)&DECIDES) != 0,
#define DECIDES_DIRECTION(sub_, side_, title_) FRICTION_DIRECTION_ROWS(DECIDES_ROW, sub_, side_, title_)
static const bool kDecides[] = {
    AXIS_PARAMETERS(DECIDES_NOTHING, DECIDES_ROW, DECIDES_ROW, DECIDES_ROW, DECIDES_DIRECTION, DECIDES_NOTHING)};
_Static_assert(sizeof kDecides / sizeof kDecides[0] == sizeof(axis_parameters) / sizeof(float), "a row per member");

static bool decides(const od_entry *entry) {
  return axis_parameters_has(entry) && kDecides[entry->offset / sizeof(float)];
}

/* How far two values are apart, 0 .. 1. */
static float change_of(const axis_tuning *tuning, const od_entry *entry) {
  const float staged = axis_parameters_value(&tuning->staged, entry);
  const float active = axis_parameters_value(&tuning->active, entry);
  const float larger = scalar_max(scalar_abs(staged), scalar_abs(active));
  return larger > 0.0f ? scalar_abs(staged - active) / larger : 0.0f;
}

/* What was active is right, and nothing is known beyond it. Of equal changes the first counts. When nothing has
 * changed, the set does not suit its plant: then the plant's inertia is named. */
static parameter_refusal unstable(const axis_tuning *tuning) {
  parameter_refusal refusal = {.status = CONTROL_UNSTABLE,
                               .object = PARAMETER_OBJECT(0x2056, 1),
                               .low = tuning->active.plant.inertia_kg_m2,
                               .high = tuning->active.plant.inertia_kg_m2};
  float most = 0.0f;
  /* Bound: rows of a table, which is constant. */
  for (uint32_t i = 0; i < axis_parameters_table.count; ++i) {
    const od_entry *entry = &axis_parameters_table.entries[i];
    const float change = decides(entry) ? change_of(tuning, entry) : 0.0f;
    if (change > most) {
      most = change;
      refusal.object = PARAMETER_OBJECT(entry->index, entry->sub);
      refusal.low = axis_parameters_value(&tuning->active, entry);
      refusal.high = refusal.low;
    }
  }
  return refusal;
}

static bool start_judging(axis_tuning *tuning) {
  servo_axis_params built;
  if (axis_parameters_build(&tuning->staged, &built) != CONTROL_OK) {
    return false;
  }
  input_of(&tuning->staged, &built, tuning->gains_follow, &tuning->judged);
  loop_stability_start(&tuning->judgement);
  tuning->judged_set = tuning->staged;
  tuning->judging = true;
  return true;
}

static loop_verdict refuse(axis_tuning *tuning, parameter_refusal refusal) {
  tuning->judging = false;
  tuning->last_result = (uint32_t)refusal.status;
  tuning->refusal = refusal;
  return LOOP_REFUSED;
}

/* Those in force have been judged, with the motor of that time. So its current limit may be lowered for a first
 * power-up without a change of the friction model. */
#define CHANGE_NOTHING(...)
#define CHANGE_ROW(index_, sub_, flags_, group_, member_, ...) \
  changes = changes || ((index_) == FRICTION_FEEDFORWARD && next->group_.member_ != now->group_.member_);
#define CHANGE_DIRECTION(sub_, side_, title_) FRICTION_DIRECTION_ROWS(CHANGE_ROW, sub_, side_, title_)
static bool feedforward_changes(const axis_parameters *next, const axis_parameters *now) {
  enum { FRICTION_FEEDFORWARD = 0x2030 };
  bool changes = next->speed_loop.acceleration_inertia_kg_m2 != now->speed_loop.acceleration_inertia_kg_m2;
  AXIS_PARAMETERS(CHANGE_NOTHING, CHANGE_ROW, CHANGE_ROW, CHANGE_ROW, CHANGE_DIRECTION, CHANGE_NOTHING)
  return changes;
}

/* Its beginning, each slice and what follows the last slice have calls of their own: together they would take too long.
 */
loop_verdict axis_tuning_judge(axis_tuning *tuning) {
  if (!tuning->judging || !are_same(&tuning->judged_set, &tuning->staged)) {
    if (!start_judging(tuning)) {
      return LOOP_STABLE;
    }
    const parameter_refusal feedforward = feedforward_check(&tuning->staged);
    const bool refused = feedforward.status != CONTROL_OK && feedforward_changes(&tuning->staged, &tuning->active);
    return refused ? refuse(tuning, feedforward) : LOOP_RUNNING;
  }
  const loop_verdict verdict = tuning->judgement.verdict;
  if (verdict == LOOP_RUNNING) {
    (void)loop_stability_step(&tuning->judgement, &tuning->judged, AXIS_TUNING_SLICE);
    return LOOP_RUNNING;
  }
  tuning->judging = false;
  return verdict == LOOP_REFUSED ? refuse(tuning, unstable(tuning)) : verdict;
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
    tuning->can_take_back = false;
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
  const bool staged = !are_same(&tuning->staged, &tuning->active);
  const bool dirty = tuning->active_crc != tuning->stored_crc;
  tuning->flags = (staged ? AXIS_TUNING_STAGED : 0u) | (dirty ? AXIS_TUNING_DIRTY : 0u);
}
