/* SPDX-License-Identifier: Apache-2.0 */
#include "commissioning/experiment.h"

#include "base/scalar.h"

/* Share of the travel that the stimulus uses; the rest is for overshoot. */
#define USED_TRAVEL 0.9f

static bool fits(const stimulus_setup *setup, const experiment_limits *limits) {
  const float room_rad = USED_TRAVEL * limits->travel_rad;
  const float rate_rad_s = stimulus_peak_rate_rad_s(setup);
  const float leg_rad = setup->kind == STIMULUS_CHIRP ? rate_rad_s * setup->dwell_s : 0.0f;
  const bool speed = setup->kind == STIMULUS_SWEEP || setup->kind == STIMULUS_CHIRP;
  const float turn_rad = speed ? rate_rad_s * rate_rad_s / setup->acceleration_rad_s2 : 0.0f;
  const float swing_rad = speed || setup->kind == STIMULUS_TORQUE_RAMPS ? 0.0f : setup->amplitude_rad;
  return rate_rad_s <= limits->rate_rad_s && stimulus_peak_torque_nm(setup) <= limits->torque_nm &&
         leg_rad + turn_rad <= room_rad && swing_rad <= room_rad && stimulus_duration_s(setup) <= limits->duration_s;
}

control_status experiment_check(const stimulus_setup *setup, const experiment_limits *limits) {
  const scalar_range ranges[] = {
      {limits->travel_rad, 1e-6f, 3.0f},
      {limits->rate_rad_s, 1e-6f, 1e2f},
      {limits->torque_nm, 1e-6f, 1e4f},
      {limits->duration_s, 1e-3f, 3600.0f},
  };
  const control_status status = scalar_check_ranges(ranges, 4);
  if (status != CONTROL_OK) {
    return status;
  }
  const control_status setup_status = stimulus_check(setup);
  if (setup_status != CONTROL_OK) {
    return setup_status;
  }
  return fits(setup, limits) ? CONTROL_OK : CONTROL_INCONSISTENT;
}

control_status experiment_start(experiment *e, const stimulus_setup *setup, const experiment_limits *limits,
                                angle_turn32 angle) {
  const control_status status = experiment_check(setup, limits);
  if (status == CONTROL_OK) {
    *e = (experiment){.state = EXPERIMENT_RUNNING,
                      .setup = *setup,
                      .limits = *limits,
                      .whole_s = stimulus_duration_s(setup),
                      .last_angle = angle};
    stimulus_start(&e->stimulus, setup, angle);
  }
  return status;
}

void experiment_abort(experiment *e, experiment_state reason) {
  if (e->state == EXPERIMENT_RUNNING) {
    e->state = reason;
  }
}

static float travel_of(experiment *e, angle_turn32 angle) {
  e->travel_turn32 += (int32_t)(angle - e->last_angle);
  e->last_angle = angle;
  return (float)e->travel_turn32 * ANGLE_RAD_PER_TURN32;
}

/* EXPERIMENT_RUNNING, or the exceeded limit. */
static experiment_state judge(const experiment *e, float travel_rad, float joint_rate_rad_s, float dt_s) {
  if (!scalar_within(travel_rad, e->limits.travel_rad)) {
    return EXPERIMENT_LEFT_TRAVEL;
  }
  if (!scalar_within(joint_rate_rad_s, e->limits.rate_rad_s)) {
    return EXPERIMENT_TOO_FAST;
  }
  return (float)e->ticks * dt_s > e->limits.duration_s ? EXPERIMENT_TOO_LONG : EXPERIMENT_RUNNING;
}

bool experiment_step(experiment *e, angle_turn32 angle, float joint_rate_rad_s, servo_axis_command *command,
                     float dt_s) {
  if (e->state != EXPERIMENT_RUNNING) {
    return false;
  }
  const float travel_rad = travel_of(e, angle);
  e->ticks++;
  e->state = judge(e, travel_rad, joint_rate_rad_s, dt_s);
  if (e->state != EXPERIMENT_RUNNING) {
    return false;
  }
  const stimulus_view view = {.travel_rad = travel_rad, .room_rad = USED_TRAVEL * e->limits.travel_rad};
  if (!stimulus_step(&e->stimulus, &e->setup, &view, command, dt_s)) {
    e->state = EXPERIMENT_DONE;
    return false;
  }
  command->torque_limited = true;
  command->limits = (torque_limits){-e->limits.torque_nm, e->limits.torque_nm};
  return true;
}

int experiment_progress_percent(const experiment *e, float dt_s) {
  if (e->state == EXPERIMENT_DONE) {
    return 100;
  }
  return (int)scalar_min(100.0f * (float)e->ticks * dt_s / scalar_max(e->whole_s, dt_s), 99.0f);
}
