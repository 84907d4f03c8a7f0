/* SPDX-License-Identifier: Apache-2.0 */
#include "protection/slow_monitors.h"

#include "base/scalar.h"

#define REDUCED_SPEED_DELAY_S 1.0f /* from its selection on, to slow down */
#define RUNAWAY_SHARE 0.25f        /* of the motor's torque: more than any wind leaves after friction */

enum { STRONG_WINDOWS = 7 }; /* 28 ms: the filters of rate and acceleration have forgotten what was before */

/* What a broken sensor has added is no drift: after its repair the axis can be enabled at once. */
static fault_set broken_sensors(void) {
  return fault_bit(FAULT_ENCODER_LOST) | fault_bit(FAULT_ENCODER_JUMP) | fault_bit(FAULT_ENCODER_STUCK) |
         fault_bit(FAULT_ENCODER_ERRATIC) | fault_bit(FAULT_SENSORS_DISAGREE) | fault_bit(FAULT_GYRO_LOST) |
         fault_bit(FAULT_GYRO_STUCK) | fault_bit(FAULT_GYRO_SATURATED);
}

static fault_set bit_if(bool seen, fault_id fault) { return seen ? fault_bit(fault) : 0; }

void slow_monitors_add(slow_monitors *monitors, const axis_protection *protection, fault_set found, float torque_nm) {
  monitors->spoiled = monitors->spoiled || protection->gyro_missing_ticks > 0 || (found & broken_sensors()) != 0;
  monitors->gyro_sum_rad_s += protection->last_inertial_rad_s;
  monitors->torque_sum_nm += torque_nm;
}

static bool drifts(slow_monitors *m, const protection_limits *limits, float joint_rate_rad_s, float window_s) {
  const float gyro_rad_s = m->gyro_sum_rad_s / (float)SLOW_MONITOR_TICKS;
  const bool usable = !m->spoiled;
  m->gyro_sum_rad_s = 0.0f;
  m->spoiled = false;
  bool found = false;
  if (usable) {
    /* A base that moves, where the gyro's gain counts, is not judged here. */
    const float max_rad_s = protection_sensor_difference_rad_s(limits, 1.0f, joint_rate_rad_s);
    const float slow_rad_s = scalar_clamp(gyro_rad_s - joint_rate_rad_s, -max_rad_s, max_rad_s);
    found = sensor_drift_step(&m->drift, limits->fixed_base_rad, slow_rad_s, joint_rate_rad_s, window_s);
  }
  if (found || !usable) {
    m->drift = (sensor_drift){.path_rad = 0.0f};
  }
  return found;
}

/* The paths on which the axis accelerates against the sign of its set-point, and its torque does not push it there. A
 * loop whose sensor or motor has the wrong sign pushes against the motion that it sees, hard and without a break: only
 * the path after STRONG_WINDOWS of that is a runaway. What accelerated the axis before has left `slow_rate_rad_s` by
 * then, so no pattern of set-points and torque offsets (60B2) makes one. Any other path means that the axis fails to
 * follow. */
static fault_set wrong_direction(slow_monitors *m, const protection_limits *limits, const protection_motor *motor,
                                 const protection_inputs *in, float slow_rate_rad_s, float window_s) {
  const float towards = in->rate_rad_s < 0.0f ? 1.0f : -1.0f; /* the set-point */
  const float push_nm = towards * m->torque_sum_nm * (1.0f / (float)SLOW_MONITOR_TICKS);
  const bool strong = push_nm > RUNAWAY_SHARE * motor->current_limit_a * motor->torque_constant_nm_a;
  m->strong_windows = !strong ? 0 : m->strong_windows + (m->strong_windows < STRONG_WINDOWS ? 1 : 0);
  const bool grows = towards * (in->rate_rad_s - slow_rate_rad_s) < 0.0f && push_nm >= 0.0f;
  if (grows) {
    const float path_rad = scalar_abs(in->rate_rad_s) * window_s;
    m->against_rad += path_rad;
    m->pushed_rad += m->strong_windows >= STRONG_WINDOWS ? path_rad : 0.0f;
  }
  return bit_if(m->against_rad > limits->direction_rad, FAULT_SPEED_ERROR) |
         bit_if(m->pushed_rad > limits->direction_rad, FAULT_RUNAWAY);
}

static fault_set direction_faults(slow_monitors *m, const protection_limits *limits, const protection_motor *motor,
                                  const protection_inputs *in, float slow_rate_rad_s, float window_s) {
  const bool opposite = in->speed_closed && limits->direction_rad > 0.0f && in->reference_rad_s * in->rate_rad_s < 0.0f;
  fault_set found = 0;
  if (opposite) {
    found = wrong_direction(m, limits, motor, in, slow_rate_rad_s, window_s);
  } else {
    m->against_rad = 0.0f;
    m->pushed_rad = 0.0f;
    m->strong_windows = 0;
  }
  m->torque_sum_nm = 0.0f;
  return found;
}

static bool too_fast(slow_monitors *m, const protection_limits *limits, bool monitored, float joint_rate_rad_s,
                     float window_s) {
  if (!monitored) {
    m->reduced_s = 0.0f;
    return false;
  }
  if (m->reduced_s < REDUCED_SPEED_DELAY_S) {
    m->reduced_s += window_s;
    return false;
  }
  return !scalar_within(joint_rate_rad_s, limits->reduced_speed_rad_s);
}

void slow_monitors_judge(slow_monitors *monitors, const protection_limits *limits, const protection_motor *motor,
                         const axis_protection *protection, const protection_inputs *in, const slow_commands *commands,
                         float dt_s) {
  const float window_s = (float)SLOW_MONITOR_TICKS * dt_s;
  const bool known = monitors->angle_known && in->angle_valid;
  const float step_rad = known ? angle_difference_rad(in->angle, monitors->angle) : 0.0f;
  const float joint_rate_rad_s = step_rad / window_s;
  monitors->angle = in->angle;
  monitors->angle_known = in->angle_valid;
  monitors->spoiled = monitors->spoiled || !known;
  const float standstill_rad = limits->fixed_base_rad > 0.0f ? limits->standstill_rad : 0.0f;
  const bool drift = drifts(monitors, limits, joint_rate_rad_s, window_s);
  const bool left = standstill_monitor_step(&monitors->standstill, standstill_rad, in->closed && commands->standing,
                                            step_rad, window_s);
  const fault_set against = direction_faults(monitors, limits, motor, in, protection->slow_rate_rad_s, window_s);
  const bool fast = too_fast(monitors, limits, in->closed && commands->reduced, joint_rate_rad_s, window_s);
  monitors->found = bit_if(drift, FAULT_SENSORS_DRIFT) | bit_if(left, FAULT_STANDSTILL_LEFT) |
                    bit_if(fast, FAULT_REDUCED_SPEED) | against;
}
