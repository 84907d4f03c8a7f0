/* SPDX-License-Identifier: Apache-2.0 */
#include "parameters/axis_parameters.h"

#include <math.h>
#include <string.h>

#include "base/crc32.h"
#include "base/scalar.h"
#include "parameters/axis_dictionary.h"
#include "servo/servo_app.h"

_Static_assert(sizeof(axis_parameters) % 4 == 0, "there must be no padding in what the CRC covers");

/* --- each value by itself ----------------------------------------------------------------------------------------- */

float axis_parameters_value(const axis_parameters *parameters, const od_entry *entry) {
  const char *place = (const char *)parameters + entry->offset;
  if (entry->type == OD_REAL32) {
    float value;
    memcpy(&value, place, sizeof value);
    return value;
  }
  uint32_t value;
  memcpy(&value, place, sizeof value);
  return (float)value;
}

bool axis_parameters_has(const od_entry *entry) { return (entry->flags & OD_STORED) != 0; }

static scalar_range range_of(const od_entry *entry) {
  const bool real = entry->type == OD_REAL32;
  return (scalar_range){.low = real ? entry->low.f : (float)entry->low.i,
                        .high = real ? entry->high.f : (float)entry->high.i};
}

static parameter_refusal check_rows(const axis_parameters *p) {
  /* Bound: rows of a table, which is constant. */
  for (uint32_t i = 0; i < axis_parameters_table.count; ++i) {
    const od_entry *entry = &axis_parameters_table.entries[i];
    if (axis_parameters_has(entry)) {
      scalar_range range = range_of(entry);
      range.value = axis_parameters_value(p, entry);
      const control_status status = scalar_check_ranges(&range, 1);
      if (status != CONTROL_OK) {
        return (parameter_refusal){status, PARAMETER_OBJECT(entry->index, entry->sub), 0, range.low, range.high};
      }
    }
  }
  return (parameter_refusal){.status = CONTROL_OK};
}

/* --- what must hold between two ----------------------------------------------------------------------------------- */

/* `object` is refused for what `bound_by` is; its own range holds as well. */
static parameter_refusal refuse(control_status status, uint32_t object, uint32_t bound_by, float low, float high) {
  parameter_refusal refusal = {status, object, bound_by, low, high};
  /* Bound: rows of a table, which is constant. */
  for (uint32_t i = 0; i < axis_parameters_table.count; ++i) {
    const od_entry *entry = &axis_parameters_table.entries[i];
    if (axis_parameters_has(entry) && PARAMETER_OBJECT(entry->index, entry->sub) == object) {
      const scalar_range range = range_of(entry);
      refusal.low = scalar_max(low, range.low);
      refusal.high = scalar_min(high, range.high);
    }
  }
  return refusal;
}

/* Of eq. (5), and a bristle deflection of at most 1 rad; `sub` is that of the direction's Coulomb torque. */
static parameter_refusal check_direction(const lugre_direction *d, float stiffness_nm_rad, uint32_t sub) {
  const uint32_t coulomb = PARAMETER_OBJECT(0x2030, sub);
  const uint32_t breakaway = PARAMETER_OBJECT(0x2030, sub + 1u);
  const uint32_t stiffness = PARAMETER_OBJECT(0x2030, 5);
  if (d->breakaway_nm < d->coulomb_nm) {
    return refuse(CONTROL_INCONSISTENT, breakaway, coulomb, d->coulomb_nm, INFINITY);
  }
  if (d->breakaway_nm > stiffness_nm_rad) {
    return refuse(CONTROL_INCONSISTENT, stiffness, breakaway, d->breakaway_nm, INFINITY);
  }
  return (parameter_refusal){.status = CONTROL_OK};
}

#define LOWEST_FILTER_HZ (BIQUAD_LOWEST_TURNS / SERVO_TICK_S)
#define HIGHEST_FILTER_HZ (BIQUAD_HIGHEST_TURNS / SERVO_TICK_S)
#define RAD_PER_TURN (2.0f * SCALAR_PI)

/* Frequency 0 switches a filter off. */
static parameter_refusal design_notch(const axis_parameters *p, biquad_params *notch) {
  const float hz = p->filters.notch_hz;
  *notch = biquad_pass();
  const control_status status =
      hz == 0.0f ? CONTROL_OK
                 : biquad_design_notch(notch, RAD_PER_TURN * hz, RAD_PER_TURN * p->filters.notch_width_hz,
                                       p->filters.notch_depth, SERVO_TICK_S);
  if (status == CONTROL_OK) {
    return (parameter_refusal){.status = CONTROL_OK};
  }
  const uint32_t frequency = PARAMETER_OBJECT(0x2040, 1);
  if (hz < LOWEST_FILTER_HZ) {
    return refuse(status, frequency, 0, LOWEST_FILTER_HZ, HIGHEST_FILTER_HZ);
  }
  const float widest_hz = scalar_min(BIQUAD_WIDEST_SHARE * hz, BIQUAD_WIDEST_RAD / (RAD_PER_TURN * SERVO_TICK_S));
  return refuse(status, PARAMETER_OBJECT(0x2040, 2), frequency, BIQUAD_NARROWEST_SHARE * hz, widest_hz);
}

static parameter_refusal design_lowpass(const axis_parameters *p, biquad_params *lowpass) {
  const float hz = p->filters.lowpass_hz;
  *lowpass = biquad_pass();
  const control_status status =
      hz == 0.0f ? CONTROL_OK
                 : biquad_design_lowpass(lowpass, RAD_PER_TURN * hz, p->filters.lowpass_damping, SERVO_TICK_S);
  if (status != CONTROL_OK) {
    return refuse(status, PARAMETER_OBJECT(0x2040, 4), 0, LOWEST_FILTER_HZ, HIGHEST_FILTER_HZ);
  }
  return (parameter_refusal){.status = CONTROL_OK};
}

static parameter_refusal design_setpoint_model(const axis_parameters *p, setpoint_model_params *model) {
  const control_status status = setpoint_model_design(model, p->speed_loop.setpoint_model_rad_s, SERVO_TICK_S);
  if (status != CONTROL_OK) {
    return refuse(status, PARAMETER_OBJECT(0x2000, 6), 0, SETPOINT_MODEL_LOWEST_RAD_S, SETPOINT_MODEL_HIGHEST_RAD_S);
  }
  return (parameter_refusal){.status = CONTROL_OK};
}

/* --- into the blocks ---------------------------------------------------------------------------------------------- */

/* What the list says to copy; one value has two users. */
static void copy_to_blocks(const axis_parameters *p, servo_axis_params *all) {
#define COPY_NOTHING(...)
#define COPY_REAL(index_, sub_, flags_, group_, member_, low_, high_, default_, unit_, name_, help_, to_) \
  all->to_ = p->group_.member_;
#define COPY_WHOLE(index_, sub_, flags_, group_, member_, low_, high_, default_, name_, help_, to_, type_) \
  all->to_ = (type_)p->group_.member_;
#define COPY_DIRECTION(sub_, side_, title_) FRICTION_DIRECTION_ROWS(COPY_REAL, sub_, side_, title_)
  AXIS_PARAMETERS(COPY_NOTHING, COPY_REAL, COPY_NOTHING, COPY_WHOLE, COPY_DIRECTION, COPY_NOTHING)
  all->tracker.rate_limit_rad_s = p->position_loop.rate_limit_rad_s;
}

/* The integral must not be moved by a limit much faster than errors move it: what a long limitation leaves in it would
 * turn the axis at set-point 0 for kp/ki. Without integral gain this would last for ever. */
static void bound_anti_windup(pi_controller_params *pi) {
  if (pi->tracking_rate_per_s * pi->proportional_gain > ANTI_WINDUP_FACTOR * pi->integral_gain) {
    pi->tracking_rate_per_s = ANTI_WINDUP_FACTOR * pi->integral_gain / pi->proportional_gain;
  } else if (pi->integral_gain == 0.0f) {
    pi->tracking_rate_per_s = 0.0f;
  }
}

/* The last of them asks the blocks, which refuse nothing that came so far (a test draws sets): then it names no value.
 */
static parameter_refusal build(const axis_parameters *p, servo_axis_params *all) {
  copy_to_blocks(p, all);
  parameter_refusal refusal = check_rows(p);
  if (refusal.status == CONTROL_OK) {
    refusal = check_direction(&p->friction.positive, p->friction.stiffness_nm_rad, 7);
  }
  if (refusal.status == CONTROL_OK) {
    refusal = check_direction(&p->friction.negative, p->friction.stiffness_nm_rad, 11);
  }
  if (refusal.status == CONTROL_OK) {
    refusal = design_setpoint_model(p, &all->speed.setpoint_model);
  }
  if (refusal.status == CONTROL_OK) {
    refusal = design_notch(p, &all->speed.notch);
  }
  if (refusal.status == CONTROL_OK) {
    refusal = design_lowpass(p, &all->speed.lowpass);
  }
  if (refusal.status == CONTROL_OK) {
    refusal.status = current_loop_design(&all->current, p->motor.resistance_ohm, p->motor.inductance_h,
                                         p->motor.back_emf_v_s_rad, p->motor.bandwidth_rad_s, SERVO_PWM_PERIOD_S);
  }
  if (refusal.status == CONTROL_OK) {
    bound_anti_windup(&all->speed.pi);
    refusal.status = servo_axis_check(all, SERVO_TICK_S, SERVO_PWM_PERIOD_S);
  }
  return refusal;
}

parameter_refusal axis_parameters_check(const axis_parameters *parameters) {
  servo_axis_params all = {.torque_constant_nm_a = 0.0f};
  return build(parameters, &all);
}

control_status axis_parameters_build(const axis_parameters *parameters, servo_axis_params *built) {
  servo_axis_params all = {.torque_constant_nm_a = 0.0f};
  const control_status status = build(parameters, &all).status;
  if (status == CONTROL_OK) {
    *built = all;
  }
  return status;
}

uint32_t axis_parameters_crc(const axis_parameters *parameters) {
  return crc32_end(crc32_add(CRC32_START, (const uint8_t *)parameters, sizeof *parameters));
}
