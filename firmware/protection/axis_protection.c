/* SPDX-License-Identifier: Apache-2.0 */
#include "protection/axis_protection.h"

#include <math.h>

#include "base/scalar.h"

/* How long a condition must hold, in ticks, before it counts. */
enum {
  GYRO_MISSING_TICKS = 5,
  DISAGREE_TICKS = 5,
  OVERSPEED_TICKS = 2,
  SATURATED_TICKS = 2,
  RUNAWAY_TICKS = 24, /* longer than the filters of rate and acceleration remember what was before */
  DECAY_TICKS = 20,   /* of the current of a bridge that switches off: a few times L / R */
  OFFSET_TICKS = 10,
  MISMATCH_TICKS = 8,
  OVER_CURRENT_TICKS = 2,
  UNDER_VOLTAGE_TICKS = 5,
  OVER_VOLTAGE_TICKS = 2
};

#define DISAGREE_SMOOTHING_S 0.003f
#define DISAGREE_OF_RATE 0.02f /* of the joint rate: scale error and delay of the gyro */
#define MISMATCH_OF_DROP 0.4f  /* of R i: a winding that is 100 K warmer, plus a margin */
#define OVER_CURRENT_FACTOR 1.3f
#define SETTLING_S 0.01f /* of the current of a bridge that is off, and of the rate that runaway compares with */
#define RUNAWAY_TORQUE 0.5f
#define RUNAWAY_ACCELERATION_RAD_S2 0.5f
/* No torque makes a rate fall by more, in multiples of 2060:19, within RUNAWAY_TICKS: decision 0028. */
#define IMPOSSIBLE_S 0.055f
#define IMPOSSIBLE_OF_DELAY 4.0f /* a delayed rate goes on falling as the torque before made it */
#define STANDSTILL_RAD_S 2e-3f
#define OUTWARDS_RAD 2e-3f /* a seal that was wound up moves the axis by less when its brake opens */

uint8_t protection_contradictions(const protection_limits *limits) {
  const float travel_rad = limits->maximum_rad - limits->minimum_rad;
  const bool margin_fits = !protection_has_travel(limits) || 2.0f * limits->stopping_margin_rad < travel_rad;
  const bool voltages = limits->under_voltage_v < limits->over_voltage_v;
  return (uint8_t)((voltages ? 0 : PROTECTION_VOLTAGES) | (travel_rad >= 0.0f && margin_fits ? 0 : PROTECTION_TRAVEL));
}

static uint32_t limit_object(uint32_t sub) { return PARAMETER_OBJECT(0x2060, sub); }

/* `sub`, below 18, is refused for what `bound_by` is; its own range holds as well. */
static parameter_refusal refuse(const scalar_range *ranges, uint32_t sub, uint32_t bound_by, float low, float high) {
  return (parameter_refusal){CONTROL_INCONSISTENT, limit_object(sub), limit_object(bound_by),
                             scalar_max(low, ranges[sub - 1u].low), scalar_min(high, ranges[sub - 1u].high)};
}

parameter_refusal protection_refusal(const protection_limits *limits) {
#define RANGE(sub_, member_, low_, high_, default_, unit_, name_, help_) {limits->member_, low_, high_},
#define SUB(sub_, member_, low_, high_, default_, unit_, name_, help_) (sub_),
  const scalar_range ranges[] = {PROTECTION_LIMITS(RANGE)};
  static const uint8_t subs[] = {PROTECTION_LIMITS(SUB)};
  for (uint32_t i = 0; i < sizeof ranges / sizeof ranges[0]; ++i) {
    const control_status status = scalar_check_ranges(&ranges[i], 1);
    if (status != CONTROL_OK) {
      return (parameter_refusal){status, limit_object(subs[i]), 0, ranges[i].low, ranges[i].high};
    }
  }
  const uint8_t contradictions = protection_contradictions(limits);
  const float travel_rad = limits->maximum_rad - limits->minimum_rad;
  if ((contradictions & PROTECTION_VOLTAGES) != 0) {
    return refuse(ranges, 15, 16, -INFINITY, limits->over_voltage_v);
  }
  if (travel_rad < 0.0f) {
    return refuse(ranges, 10, 9, limits->minimum_rad, INFINITY);
  }
  if ((contradictions & PROTECTION_TRAVEL) != 0) {
    return refuse(ranges, 17, 10, -INFINITY, 0.5f * travel_rad);
  }
  return (parameter_refusal){.status = CONTROL_OK};
}

control_status protection_check(const protection_limits *limits) { return protection_refusal(limits).status; }

void axis_protection_reset(axis_protection *protection) {
  *protection = (axis_protection){.heating_a2 = protection->heating_a2, .witness = protection->witness};
}

/* Counts consecutive ticks with the condition; returns whether they are enough. */
static bool seen_for(int *ticks, bool seen, int enough) {
  if (!seen) {
    *ticks = 0;
    return false;
  }
  *ticks += *ticks < enough ? 1 : 0;
  return *ticks >= enough;
}

static bool lasts(float *seconds, bool seen, float enough_s, float dt_s) {
  if (!seen) {
    *seconds = 0.0f;
    return false;
  }
  *seconds = scalar_min(*seconds + dt_s, enough_s);
  return *seconds >= enough_s - 0.5f * dt_s; /* half a tick for rounding */
}

static void follow(float *slow, float now, float share) { *slow += (now - *slow) * share; }

static fault_set bit_if(bool seen, fault_id fault) { return seen ? fault_bit(fault) : 0; }

/* The position increment is 0 in the first tick with an angle. */
static fault_set monitor_encoder(axis_protection *p, const protection_limits *limits, const protection_inputs *in,
                                 float dt_s, float *step_rad) {
  if (!in->angle_valid) {
    p->angles_known = 0;
    p->same_angle_s = 0.0f;
    p->step_change_rad = 0.0f;
    *step_rad = 0.0f;
    return fault_bit(FAULT_ENCODER_LOST);
  }
  const bool known = p->angles_known > 0;
  *step_rad = known ? angle_difference_rad(in->angle, p->last_angle) : 0.0f;
  p->step_change_rad = p->angles_known > 1 ? *step_rad - p->last_step_rad : 0.0f;
  const bool jumps = !scalar_within(p->step_change_rad, limits->encoder_jump_rad);
  const bool stuck =
      lasts(&p->same_angle_s, known && limits->stuck_s > 0.0f && in->angle == p->last_angle, limits->stuck_s, dt_s);
  p->last_angle = in->angle;
  p->last_step_rad = *step_rad;
  p->angles_known += p->angles_known < 2 ? 1 : 0;
  return bit_if(jumps, FAULT_ENCODER_JUMP) | bit_if(stuck, FAULT_ENCODER_STUCK);
}

float protection_sensor_difference_rad_s(const protection_limits *limits, float gyro_gain, float joint_rate_rad_s) {
  const bool fixed = limits->fixed_base_rad > 0.0f;
  const float base_rad_s = limits->base_rate_rad_s * (fixed ? 1.0f : scalar_max(1.0f, scalar_abs(gyro_gain)));
  return base_rad_s + DISAGREE_OF_RATE * scalar_abs(joint_rate_rad_s);
}

/* Where the encoder alone shows a change of the rate, its increment is wrong, and not the difference of the two. */
static fault_set compare_sensors(axis_protection *p, const protection_limits *limits, float outlier_rad,
                                 float gyro_gain, float inertial_rad_s, float joint_rate_rad_s, float dt_s) {
  const encoder_verdict encoder = encoder_outliers_step(&p->outliers, outlier_rad, p->step_change_rad,
                                                        (inertial_rad_s - p->last_inertial_rad_s) * dt_s);
  if (encoder == ENCODER_FITS) {
    follow(&p->difference_rad_s, p->angles_known > 1 ? inertial_rad_s - joint_rate_rad_s : 0.0f,
           dt_s / DISAGREE_SMOOTHING_S);
  }
  const float max_rad_s = protection_sensor_difference_rad_s(limits, gyro_gain, joint_rate_rad_s);
  const bool disagrees = seen_for(&p->disagree_ticks, !scalar_within(p->difference_rad_s, max_rad_s), DISAGREE_TICKS);
  return bit_if(disagrees, FAULT_SENSORS_DISAGREE) | bit_if(encoder == ENCODER_ERRATIC, FAULT_ENCODER_ERRATIC);
}

void axis_protection_forget_differences(axis_protection *p) {
  p->disagree_ticks = 0;
  p->difference_rad_s = 0.0f;
  p->outliers = (encoder_outliers){0};
}

/* A rate that is NaN counts as missing. */
static fault_set monitor_gyro(axis_protection *p, const protection_limits *limits, const protection_inputs *in,
                              float joint_rate_rad_s, float dt_s) {
  const bool known = in->gyro_valid && scalar_within(in->gyro_rad_s, 1e6f);
  const bool returns = p->gyro_missing_ticks > 0; /* the last rate is older than a tick */
  const bool missing = seen_for(&p->gyro_missing_ticks, !known, GYRO_MISSING_TICKS);
  if (!known) {
    return bit_if(missing && in->gyro_used, FAULT_GYRO_LOST);
  }
  const bool saturated =
      seen_for(&p->saturated_ticks, !scalar_within(in->gyro_rad_s, 0.99f * limits->gyro_range_rad_s), SATURATED_TICKS);
  const bool same = limits->stuck_s > 0.0f && in->gyro_rad_s == p->last_gyro_rad_s;
  const bool stuck = lasts(&p->same_gyro_s, same, limits->stuck_s, dt_s);
  const float outlier_rad = returns ? 0.0f : limits->encoder_outlier_rad;
  const float inertial_rad_s = in->gyro_gain * in->gyro_rad_s + in->gyro_of_joint * joint_rate_rad_s;
  const fault_set compared =
      compare_sensors(p, limits, outlier_rad, in->gyro_gain, inertial_rad_s, joint_rate_rad_s, dt_s);
  p->last_gyro_rad_s = in->gyro_rad_s;
  p->last_inertial_rad_s = inertial_rad_s;
  return bit_if(saturated, FAULT_GYRO_SATURATED) | bit_if(stuck, FAULT_GYRO_STUCK) | compared;
}

/* Means of one tick: L di/dt follows from the current at the tick's ends. The loop around a dead sensor swings between
 * the limits, so the sign is ignored. A warm winding needs more voltage for its current. One whose resistance is
 * smaller than 2055 says needs less, by the tolerance 2060:22 at most; that of the inductance is the same. */
static bool voltage_mismatch(axis_protection *p, const protection_limits *limits, const protection_motor *motor,
                             const protection_inputs *in, float joint_rate_rad_s, float dt_s) {
  const float drop_v = motor->resistance_ohm * in->mean_current_a;
  const float rise_a = in->tick_current_a - p->last_tick_current_a;
  const float inductive_v = motor->resistance_ohm * motor->time_constant_s / dt_s * rise_a;
  const float unexplained_v = in->tick_voltage_v - inductive_v - drop_v - motor->back_emf_v_s_rad * joint_rate_rad_s;
  const float share = unexplained_v * drop_v > 0.0f ? MISMATCH_OF_DROP : limits->motor_tolerance;
  const float of_winding_v = scalar_abs(drop_v) + scalar_abs(inductive_v);
  const bool seen = !scalar_within(unexplained_v, limits->voltage_mismatch_v + share * of_winding_v);
  if (!seen) {
    p->mismatch_ticks -= p->mismatch_ticks > 0 ? 1 : 0;
    return false;
  }
  p->mismatch_ticks += p->mismatch_ticks < MISMATCH_TICKS ? 1 : 0;
  return p->mismatch_ticks >= MISMATCH_TICKS;
}

/* A bridge that is off has no current after its decay time; a motor that is shorted to brake has some. */
static bool current_without_drive(axis_protection *p, const protection_limits *limits, const protection_inputs *in,
                                  float dt_s) {
  if (in->powered) {
    p->off_ticks = 0;
    p->offset_a = 0.0f;
    p->offset_ticks = 0;
    return false;
  }
  if (p->off_ticks < DECAY_TICKS) {
    p->mismatch_ticks = 0;
    p->off_ticks++;
    return false;
  }
  follow(&p->offset_a, in->mean_current_a, dt_s / SETTLING_S);
  return seen_for(&p->offset_ticks, !scalar_within(p->offset_a, limits->current_offset_a), OFFSET_TICKS);
}

static fault_set monitor_current(axis_protection *p, const protection_limits *limits, const protection_motor *motor,
                                 const protection_inputs *in, float joint_rate_rad_s, float dt_s) {
  const float current_a = in->mean_current_a;
  const bool finite = scalar_within(current_a, 1e6f);
  const bool too_much =
      seen_for(&p->over_current_ticks, !scalar_within(current_a, OVER_CURRENT_FACTOR * motor->current_limit_a),
               OVER_CURRENT_TICKS);
  const bool offset = finite && current_without_drive(p, limits, in, dt_s);
  const bool mismatch = in->closed && finite && voltage_mismatch(p, limits, motor, in, joint_rate_rad_s, dt_s);
  p->last_tick_current_a = in->tick_current_a;
  return bit_if(too_much, FAULT_OVER_CURRENT) | bit_if(offset, FAULT_CURRENT_OFFSET) |
         bit_if(mismatch, FAULT_CURRENT_SENSOR);
}

static fault_set monitor_voltage(axis_protection *p, const protection_limits *limits, const protection_inputs *in) {
  const bool under = seen_for(&p->under_voltage_ticks, in->closed && !(in->bus_voltage_v >= limits->under_voltage_v),
                              UNDER_VOLTAGE_TICKS);
  const bool over = seen_for(&p->over_voltage_ticks, in->bus_voltage_v > limits->over_voltage_v, OVER_VOLTAGE_TICKS);
  return bit_if(under, FAULT_UNDER_VOLTAGE) | bit_if(over, FAULT_OVER_VOLTAGE);
}

/* The torque pushes the axis towards its set-point, but it accelerates in the opposite direction: it turns away ever
 * faster, or its rate has fallen by more than torque and friction can make it. One that still turns towards its
 * set-point may get slower by friction. */
static bool runs_away(axis_protection *p, const protection_limits *limits, const protection_motor *motor,
                      const protection_inputs *in, float dt_s) {
  const float slow_rad_s = p->slow_rate_rad_s;
  const float gain_rad_s = in->rate_rad_s - slow_rad_s; /* in SETTLING_S */
  follow(&p->slow_rate_rad_s, in->rate_rad_s, dt_s / SETTLING_S);
  const float error_rad_s = in->reference_rad_s - in->rate_rad_s;
  const float towards = error_rad_s < 0.0f ? -1.0f : 1.0f;
  const float limit_nm = motor->current_limit_a * motor->torque_constant_nm_a;
  const bool away = in->speed_closed && !scalar_within(error_rad_s, 0.1f * limits->speed_error_rad_s) &&
                    towards * in->torque_nm > RUNAWAY_TORQUE * limit_nm &&
                    towards * gain_rad_s < -RUNAWAY_ACCELERATION_RAD_S2 * SETTLING_S;
  if (!away) {
    p->rate_before_rad_s = slow_rad_s;
  }
  if (!seen_for(&p->runaway_ticks, away, RUNAWAY_TICKS)) {
    return false;
  }
  const float fall_rad_s = towards * (p->rate_before_rad_s - in->rate_rad_s);
  p->rate_before_rad_s = in->rate_rad_s; /* friction may go on for long */
  const float impossible_s = IMPOSSIBLE_S + IMPOSSIBLE_OF_DELAY * in->rate_delay_s;
  return towards * in->rate_rad_s < 0.0f || fall_rad_s > impossible_s * limits->deceleration_rad_s2;
}

/* Alternating between both torque limits counts as blocked as well: only motion ends the count. */
static bool stalls(axis_protection *p, const protection_limits *limits, const protection_inputs *in,
                   float joint_rate_rad_s, float dt_s) {
  const bool still = in->speed_closed && scalar_within(joint_rate_rad_s, STANDSTILL_RAD_S);
  if (!still || in->limited) {
    return lasts(&p->stall_s, still, limits->stall_s, dt_s);
  }
  return false;
}

/* By a distance, not by a rate: an axis that is outside creeps, and it jerks when its brake opens. */
static bool moves_outwards(axis_protection *p, const protection_limits *limits, const protection_inputs *in) {
  const float beyond_rad = scalar_max(limits->minimum_rad - in->position_rad, in->position_rad - limits->maximum_rad);
  const float outside_rad = protection_has_travel(limits) ? scalar_max(beyond_rad, 0.0f) : 0.0f;
  const bool compares = in->closed && in->ends_known;
  p->outside_rad = compares ? scalar_min(p->outside_rad, outside_rad) : outside_rad;
  return outside_rad > p->outside_rad + OUTWARDS_RAD;
}

static fault_set monitor_motion(axis_protection *p, const protection_limits *limits, const protection_motor *motor,
                                const protection_inputs *in, float joint_rate_rad_s, float dt_s) {
  const bool overspeed =
      seen_for(&p->overspeed_ticks, !scalar_within(joint_rate_rad_s, limits->overspeed_rad_s), OVERSPEED_TICKS);
  const bool runaway = runs_away(p, limits, motor, in, dt_s);
  const bool far_off =
      in->speed_closed && !scalar_within(in->reference_rad_s - in->rate_rad_s, limits->speed_error_rad_s);
  const bool speed_error = lasts(&p->speed_error_s, far_off, limits->speed_error_s, dt_s);
  const bool stall = stalls(p, limits, in, joint_rate_rad_s, dt_s);
  const bool beyond = moves_outwards(p, limits, in);
  return bit_if(overspeed, FAULT_OVER_SPEED) | bit_if(runaway, FAULT_RUNAWAY) | bit_if(speed_error, FAULT_SPEED_ERROR) |
         bit_if(stall, FAULT_STALL) | bit_if(beyond, FAULT_BEYOND_TRAVEL);
}

static motor_witness_limits witness_limits(const protection_limits *limits) {
  return (motor_witness_limits){.tolerance = limits->motor_tolerance,
                                .back_emf_error_v = limits->back_emf_error_v,
                                .largest_zero_a = limits->current_offset_a,
                                .largest_v = limits->voltage_mismatch_v};
}

/* A bridge that is off heats no winding, and a reading beyond FAULT_OVER_CURRENT lasts for two ticks, or is none. */
static bool overloads(axis_protection *p, const protection_limits *limits, const protection_motor *motor,
                      const protection_inputs *in, float dt_s) {
  const float largest_a = OVER_CURRENT_FACTOR * motor->current_limit_a;
  const bool heats = in->powered && scalar_within(in->mean_current_a, 1e6f);
  const float current_a = heats ? scalar_clamp(in->mean_current_a, -largest_a, largest_a) : 0.0f;
  follow(&p->heating_a2, current_a * current_a, dt_s / limits->thermal_time_s);
  return p->heating_a2 > limits->continuous_current_a * limits->continuous_current_a;
}

fault_set axis_protection_judge(axis_protection *p, const protection_limits *limits, const protection_motor *motor,
                                const protection_inputs *in, float dt_s) {
  const bool whole_tick = p->closed_ticks > 1; /* the voltage of the tick in which the loop closed has two parts */
  p->closed_ticks = !in->closed ? 0 : p->closed_ticks + (whole_tick ? 0 : 1);
  const motor_witness_limits witness = witness_limits(limits);
  const motor_data data = {.resistance_ohm = motor->resistance_ohm,
                           .time_constant_s = motor->time_constant_s,
                           .back_emf_v_s_rad = motor->back_emf_v_s_rad};
  const motor_witness_inputs seen = {.driven = in->closed && whole_tick && p->angles_known > 1,
                                     .idle = p->off_ticks >= DECAY_TICKS,
                                     .voltage_v = in->tick_voltage_v,
                                     .current_a = in->mean_current_a,
                                     .now_a = in->tick_current_a,
                                     .rate_rad_s = p->last_step_rad / dt_s};
  if (p->gyro_missing_ticks > 0) { /* what it said before says nothing of what it says when it is back */
    axis_protection_forget_differences(p);
    p->saturated_ticks = 0;
  }
  const motor_verdict verdict = motor_witness_step(&p->witness, &witness, &data, &seen, dt_s);
  motor_witness_learn(&p->witness, &witness, dt_s);
  if (verdict != MOTOR_AGREES || p->mismatch_ticks >= MISMATCH_TICKS) {
    motor_witness_forget(&p->witness);
  }
  return bit_if(overloads(p, limits, motor, in, dt_s), FAULT_OVERLOAD) |
         bit_if(verdict == MOTOR_CONTRADICTS, FAULT_MOTOR_CONTRADICTS) |
         bit_if(verdict == MOTOR_WEAK, FAULT_MOTOR_WEAK);
}

fault_set axis_protection_step(axis_protection *protection, const protection_limits *limits,
                               const protection_motor *motor, const protection_inputs *in, float dt_s) {
  float step_rad;
  fault_set found = monitor_encoder(protection, limits, in, dt_s, &step_rad);
  const float joint_rate_rad_s = step_rad / dt_s;
  found |= monitor_gyro(protection, limits, in, joint_rate_rad_s, dt_s);
  found |= monitor_current(protection, limits, motor, in, joint_rate_rad_s, dt_s);
  found |= monitor_voltage(protection, limits, in);
  found |= monitor_motion(protection, limits, motor, in, joint_rate_rad_s, dt_s);
  return found;
}

bool axis_protection_warns(const axis_protection *protection, const protection_limits *limits) {
  const float warning_of_square = 0.81f;
  return protection->heating_a2 > warning_of_square * limits->continuous_current_a * limits->continuous_current_a;
}
