/* SPDX-License-Identifier: Apache-2.0 */
/* A servo axis on a bare inertia of 20 kg m^2 with an ideal encoder and current loop and no gyro: the load gets the
 * commanded torque, unless the bench limits the motor. */
#ifndef TRACKSERVO_TESTS_SUPPORT_SERVO_BENCH_H
#define TRACKSERVO_TESTS_SUPPORT_SERVO_BENCH_H

#include <math.h>

#include "seals.h"
#include "servo/servo_axis.h"

static const float dt_s = 1e-3f;
static const double inertia_kg_m2 = 20.0;

typedef struct {
  servo_axis_params params;
  servo_axis axis;
  servo_axis_command command;
  servo_axis_samples samples;
  double rate_rad_s;
  double turns;
  double load_nm;
  double motor_limit_nm; /* maximum torque that the bus can drive, both directions; 0: no limit */
  double worst_step_nm;  /* of the torque from tick to tick */
} bench;

static inline bench bench_at_rest(void) {
  bench b = {
      .params = {.speed = {.rate_estimator = {.window_ticks = 2},
                           .rate_fusion = {.source = RATE_FROM_ENCODER, .crossover_rad_s = 60.0f},
                           .notch = biquad_pass(),
                           .lowpass = biquad_pass(),
                           .pi = {.proportional_gain = 1200.0f,
                                  .integral_gain = 14000.0f,
                                  .setpoint_weight = 1.0f,
                                  .tracking_rate_per_s = 100.0f},
                           .acceleration_inertia_kg_m2 = 20.0f,
                           .observer_on = true,
                           .observer = {.inertia_kg_m2 = 20.0f, .bandwidth_rad_s = 60.0f, .limit_nm = 100.0f},
                           .friction = {.model = FRICTION_LUGRE,
                                        .gain = 0.0f,
                                        .lead_limit_rad_s = 0.05f,
                                        .sign_width_rad_s = 1e-3f,
                                        .lugre = stiff_seal()}},
                 .position = {.proportional_per_s = 10.0f, .rate_limit_rad_s = 1.0f, .deceleration_rad_s2 = 1.0f},
                 .tracker = {.kind = TRACKER_PI, .proportional_per_s = 1.0f, .rate_limit_rad_s = 1.0f},
                 .current = {.pi = {.proportional_gain = 2.0f,
                                    .integral_gain = 900.0f,
                                    .setpoint_weight = 1.0f,
                                    .tracking_rate_per_s = 450.0f},
                             .back_emf_v_s_rad = 2.5f,
                             .duty_limit = 0.98f},
                 .torque_constant_nm_a = 2.5f,
                 .current_limit_a = 20.0f,
                 .plant_inertia_kg_m2 = 1.0f,
                 .min_inertia_kg_m2 = 1.0f}};
  servo_axis_reset(&b.axis, &b.params, 0u, dt_s);
  return b;
}

static inline void tick(bench *b) {
  const float before_nm = b->axis.commanded_nm;
  const double turns = b->turns - floor(b->turns);
  b->samples.sensors.joint_angle_turn32 = (angle_turn32)(uint64_t)(turns * 4294967296.0);
  servo_axis_tick(&b->axis, &b->params, &b->command, &b->samples, dt_s);
  b->worst_step_nm = fmax(b->worst_step_nm, fabs((double)b->axis.commanded_nm - (double)before_nm));
  const double commanded_nm = (double)b->axis.commanded_nm;
  b->samples.motor_limited = b->motor_limit_nm > 0.0 && fabs(commanded_nm) > b->motor_limit_nm;
  const double given_nm = b->samples.motor_limited ? copysign(b->motor_limit_nm, commanded_nm) : commanded_nm;
  const double acceleration = (given_nm - b->load_nm) / inertia_kg_m2;
  b->turns += (b->rate_rad_s * 1e-3 + 0.5e-6 * acceleration) / 6.283185307179586;
  b->rate_rad_s += acceleration * 1e-3;
  b->samples.sensors.mean_current_a = (float)given_nm / b->params.torque_constant_nm_a;
}

static inline void ticks(bench *b, int count) {
  for (int i = 0; i < count; ++i) {
    tick(b);
  }
}

#endif
