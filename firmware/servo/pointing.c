/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/pointing.h"

#include "base/scalar.h"

control_status pointing_check(const pointing_params *params) {
  const pointing_inertia *inertia = &params->inertia;
  const scalar_range ranges[] = {
      {inertia->azimuth_kg_m2, 1e-9f, 1e5f},
      {inertia->azimuth_swing_kg_m2, -1e5f, 1e5f},
      {inertia->azimuth_kg_m2 + inertia->azimuth_swing_kg_m2, 1e-9f, 1e5f},
      {inertia->pitch_kg_m2, 1e-9f, 1e5f},
      {params->fed_forward_kg_m2.azimuth, 0.0f, 1e5f},
      {params->fed_forward_kg_m2.pitch, 0.0f, 1e5f},
  };
  const control_status status = pointing_tracker_check(&params->tracker);
  return status != CONTROL_OK ? status : scalar_check_ranges(ranges, sizeof ranges / sizeof ranges[0]);
}

control_status pointing_configure(pointing *self, const pointing_params *params) {
  const control_status status = pointing_check(params);
  if (status != CONTROL_OK) {
    return status;
  }
  self->params = *params;
  self->largest_kg_m2 = params->inertia.azimuth_kg_m2 + params->inertia.azimuth_swing_kg_m2;
  self->fed_forward_share = params->fed_forward_kg_m2.azimuth / self->largest_kg_m2;
  pointing_reset(self);
  return CONTROL_OK;
}

void pointing_reset(pointing *self) {
  pointing_tracker_reset(&self->tracker);
  self->known_ticks = 0;
}

void pointing_look_away(pointing *self) {
  pointing_tracker_lose(&self->tracker);
  self->known_ticks = -1;
}

pointing_motion pointing_motion_of(const servo_app *app, const servo_samples *samples) {
  return (pointing_motion){
      .pitch = samples->pitch,
      .inertial_rad_s = {.azimuth = app->axis[SERVO_AZIMUTH].signals.rates.rate_rad_s,
                         .pitch = app->axis[SERVO_PITCH].signals.rates.rate_rad_s},
  };
}

pointing_output pointing_step(pointing *self, const pointing_frame *frame, const pointing_motion *motion,
                              float tick_s) {
  const pointing_params *params = &self->params;
  const rotation pitch = motion->pitch;
  const line_of_sight_rates los =
      line_of_sight_of_joints(pitch, motion->inertial_rad_s.azimuth, motion->inertial_rad_s.pitch);
  pointing_frame known = *frame;
  known.valid = frame->valid && frame->age_ticks <= self->known_ticks;
  if (self->known_ticks < TARGET_TRACKER_HISTORY) {
    ++self->known_ticks;
  }
  const pointing_command wanted = pointing_tracker_step(&self->tracker, &params->tracker, &known, &los, pitch, tick_s);
  const joint_vector torque_nm =
      pointing_torques_nm(&params->inertia, pitch, wanted.rate_rad_s, wanted.acceleration_rad_s2);
  const joint_vector acceleration = wanted.acceleration_rad_s2;
  const joint_vector inertia = {
      .azimuth = self->fed_forward_share *
                 scalar_min(pointing_azimuth_inertia_kg_m2(&params->inertia, pitch), self->largest_kg_m2),
      .pitch = params->fed_forward_kg_m2.pitch};
  return (pointing_output){
      .locked = wanted.locked,
      .limited = wanted.limited,
      .error_rad = wanted.error_rad,
      .error_of_joints_rad = wanted.error_of_joints_rad,
      .seen_rad = wanted.seen_rad,
      .reference = {[SERVO_AZIMUTH] = {.rate_rad_s = wanted.rate_rad_s.azimuth,
                                       .acceleration_rad_s2 = acceleration.azimuth},
                    [SERVO_PITCH] = {.rate_rad_s = wanted.rate_rad_s.pitch, .acceleration_rad_s2 = acceleration.pitch}},
      .torque_nm = {[SERVO_AZIMUTH] = torque_nm.azimuth - inertia.azimuth * acceleration.azimuth,
                    [SERVO_PITCH] = torque_nm.pitch - inertia.pitch * acceleration.pitch},
  };
}
