/* SPDX-License-Identifier: Apache-2.0 */
#include "parameters/feedforward_check.h"

#include "base/scalar.h"

typedef struct {
  uint32_t object;
  uint32_t bound_by;
  float value;
  float low;
  float high;
} feedforward_limit;

/* A coefficient of the friction model, whose torque is `gain` times as large. */
static feedforward_limit friction_limit(uint32_t sub, uint32_t bound_by, float value, float low, float high,
                                        float gain) {
  return (feedforward_limit){PARAMETER_OBJECT(0x2030, sub), bound_by, value, low, high / gain};
}

static parameter_refusal first_exceeded(const feedforward_limit *limits, int count) {
  /* Bound: 7: the limits of its callers' tables. */
  for (int i = 0; i < count; ++i) {
    const feedforward_limit *limit = &limits[i];
    if (limit->value > limit->high) {
      return (parameter_refusal){CONTROL_UNSTABLE, limit->object, limit->bound_by, limit->low, limit->high};
    }
  }
  return (parameter_refusal){.status = CONTROL_OK};
}

static parameter_refusal check_friction(const axis_parameters *set) {
  const float gain = set->friction.gain;
  if (set->friction.model == (uint32_t)FRICTION_NONE || gain == 0.0f) {
    return (parameter_refusal){.status = CONTROL_OK};
  }
  const uint32_t motor = PARAMETER_OBJECT(0x2055, 6);
  const float torque_nm = FEEDFORWARD_MOTOR_SHARE * set->motor.torque_constant_nm_a * set->motor.current_limit_a;
  const float min_nm = 1e-6f;
  const float viscous = scalar_max(FEEDFORWARD_PLANT_FACTOR * set->plant.viscous_nm_s_rad, torque_nm);
  const float damping = scalar_max(FEEDFORWARD_PLANT_FACTOR * set->plant.damping_nm_s_rad, torque_nm);
  const uint32_t viscous_by = viscous > torque_nm ? PARAMETER_OBJECT(0x2056, 3) : motor;
  const uint32_t damping_by = damping > torque_nm ? PARAMETER_OBJECT(0x2056, 5) : motor;
  const bool bristles = set->friction.model == (uint32_t)FRICTION_LUGRE;
  const lugre_direction *up = &set->friction.positive;
  const lugre_direction *down = &set->friction.negative;
  const feedforward_limit limits[] = {
      friction_limit(7, motor, up->coulomb_nm, min_nm, torque_nm, gain),
      friction_limit(8, motor, up->breakaway_nm, min_nm, torque_nm, gain),
      friction_limit(11, motor, down->coulomb_nm, min_nm, torque_nm, gain),
      friction_limit(12, motor, down->breakaway_nm, min_nm, torque_nm, gain),
      friction_limit(10, viscous_by, up->viscous_nm_s_rad, 0.0f, viscous, gain),
      friction_limit(14, viscous_by, down->viscous_nm_s_rad, 0.0f, viscous, gain),
      friction_limit(6, damping_by, bristles ? set->friction.damping_nm_s_rad : 0.0f, 0.0f, damping, gain),
  };
  return first_exceeded(limits, (int)(sizeof limits / sizeof limits[0]));
}

parameter_refusal feedforward_check(const axis_parameters *set) {
  const feedforward_limit inertia = {
      .object = PARAMETER_OBJECT(0x2000, 5),
      .bound_by = PARAMETER_OBJECT(0x2056, 1),
      .value = set->speed_loop.acceleration_inertia_kg_m2,
      .low = 0.0f,
      .high = FEEDFORWARD_PLANT_FACTOR * set->plant.inertia_kg_m2,
  };
  const parameter_refusal refusal = first_exceeded(&inertia, 1);
  return refusal.status == CONTROL_OK ? check_friction(set) : refusal;
}
