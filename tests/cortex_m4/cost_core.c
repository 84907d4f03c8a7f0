/* SPDX-License-Identifier: Apache-2.0 */
/* cost_core TRACE...: instructions of the servo core's parts over the traces, as a table; ends with 1 when one of them
 * exceeds its limit.
 *
 * The linker redirects the parts to this program (--wrap): the count of a part spans exactly its call. */
#include <stdio.h>

#include "cortex_m4/core_replay.h"
#include "cortex_m4/cost_table.h"
#include "cortex_m4/instruction_count.h"
#include "servo/motor_stage.h"
#include "servo/pointing.h"
#include "servo/servo_app.h"
#include "support/servo_bench.h"

enum { COUNTED_TICKS = 4000, POINTING_LIMIT = 1300 };

static cost_row speed_loop = {.name = "speed loop, one axis", .limit = 600};
static cost_row any_speed_loop = {.name = "speed loop, any rate, window of 16", .limit = 600};
static cost_row model_row = {.name = "set-point model, one axis", .limit = 40};
static cost_row motor = {.name = "motor stage, one axis", .limit = 250};
static cost_row pointing_row = {.name = "pointing of both axes", .limit = POINTING_LIMIT};
static cost_row *counted_speed_loop = &speed_loop;
static int sense_cost;

speed_loop_rates __real_speed_loop_sense(speed_loop_state *state, const speed_loop_params *params,
                                         const speed_loop_samples *samples, float tick_s);
speed_loop_rates __wrap_speed_loop_sense(speed_loop_state *state, const speed_loop_params *params,
                                         const speed_loop_samples *samples, float tick_s);

speed_loop_rates __wrap_speed_loop_sense(speed_loop_state *state, const speed_loop_params *params,
                                         const speed_loop_samples *samples, float tick_s) {
  const uint32_t start = instruction_count_now();
  const speed_loop_rates rates = __real_speed_loop_sense(state, params, samples, tick_s);
  sense_cost = instruction_count_since(start);
  return rates;
}

speed_loop_output __real_speed_loop_control(speed_loop_state *state, const speed_loop_params *params,
                                            const speed_loop_rates *rates, const speed_reference *reference,
                                            float applied_nm, const torque_limits *limits, float tick_s);
speed_loop_output __wrap_speed_loop_control(speed_loop_state *state, const speed_loop_params *params,
                                            const speed_loop_rates *rates, const speed_reference *reference,
                                            float applied_nm, const torque_limits *limits, float tick_s);

speed_loop_output __wrap_speed_loop_control(speed_loop_state *state, const speed_loop_params *params,
                                            const speed_loop_rates *rates, const speed_reference *reference,
                                            float applied_nm, const torque_limits *limits, float tick_s) {
  const uint32_t start = instruction_count_now();
  const speed_loop_output output =
      __real_speed_loop_control(state, params, rates, reference, applied_nm, limits, tick_s);
  cost_row_add(counted_speed_loop, sense_cost + instruction_count_since(start));
  return output;
}

float __real_motor_stage_step(motor_stage *stage, uint32_t period, float current_a, float bus_voltage_v);
float __wrap_motor_stage_step(motor_stage *stage, uint32_t period, float current_a, float bus_voltage_v);

float __wrap_motor_stage_step(motor_stage *stage, uint32_t period, float current_a, float bus_voltage_v) {
  const uint32_t start = instruction_count_now();
  const float duty = __real_motor_stage_step(stage, period, current_a, bus_voltage_v);
  cost_row_add(&motor, instruction_count_since(start));
  return duty;
}

/* Cases that the experiments do not cover: the longest window of the estimator, every rate, and a seal whose Stribeck
 * speed is so high that all branches of the friction model are taken. */
static void sweep_speed_loop(void) {
  bench b = bench_at_rest();
  b.params.speed.rate_estimator.window_ticks = RATE_ESTIMATOR_MAX_WINDOW;
  b.params.speed.rate_fusion.source = RATE_FUSED;
  b.params.speed.friction.lugre.positive.stribeck_speed_rad_s = 0.3f;
  const torque_limits limits = {.minimum_nm = -20.0f, .maximum_nm = 20.0f};
  counted_speed_loop = &any_speed_loop;
  angle_turn32 angle = 0;
  for (int tick = 0; tick < 20000; ++tick) {
    const float part = 1e-4f * (float)((tick * 37) % 20000 - 10000);
    const float rate_rad_s = 100.0f * part * part * part;
    angle += (uint32_t)(int32_t)(rate_rad_s * dt_s / ANGLE_RAD_PER_TURN32);
    const speed_loop_samples samples = {.joint_angle = angle, .gyro_rad_s = rate_rad_s, .gyro_valid = true};
    const speed_loop_rates rates = speed_loop_sense(&b.axis.speed, &b.params.speed, &samples, dt_s);
    const speed_reference reference = {.rate_rad_s = rate_rad_s, .acceleration_rad_s2 = 1.0f};
    (void)speed_loop_control(&b.axis.speed, &b.params.speed, &rates, &reference, 1.0f, &limits, dt_s);
  }
}

__attribute__((noinline)) static speed_reference shape(bench *b, const speed_reference *wanted) {
  return speed_loop_shape(&b->axis.speed, &b->params.speed, wanted, dt_s);
}

static void sweep_setpoint_model(void) {
  bench b = bench_at_rest();
  (void)setpoint_model_design(&b.params.speed.setpoint_model, 400.0f, dt_s);
  for (int tick = 0; tick < 1000; ++tick) {
    const speed_reference wanted = {.rate_rad_s = tick % 20 < 10 ? 0.1f : -0.1f, .acceleration_rad_s2 = 1.0f};
    const uint32_t start = instruction_count_now();
    (void)shape(&b, &wanted);
    cost_row_add(&model_row, instruction_count_since(start));
  }
}

/* Frames of every age, and a pitch through the zenith, where all branches are taken. */
static void sweep_pointing(void) {
  static pointing both;
  const pointing_params params = {
      .tracker = {.proportional_per_s = 30.0f,
                  .estimator_rad_s = 6.0f,
                  .coast_s = 0.5f,
                  .rate_limit_rad_s = {1.0f, 1.0f}},
      .inertia = {.azimuth_kg_m2 = 3.0f, .azimuth_swing_kg_m2 = 3.0f, .pitch_kg_m2 = 2.5f},
      .fed_forward_kg_m2 = {6.0f, 2.5f},
  };
  (void)pointing_configure(&both, &params);
  for (int tick = 0; tick < 20000; ++tick) {
    const float part = 1e-4f * (float)((tick * 37) % 20000 - 10000);
    const pointing_frame frame = {.fresh = tick % 20 == 0,
                                  .valid = tick % 700 != 0,
                                  .age_ticks = (tick / 20) % TARGET_TRACKER_HISTORY,
                                  .error = {0.01f * part, -0.005f * part}};
    const pointing_motion motion = {.pitch = rotation_of((angle_turn32)tick * 60000u),
                                    .inertial_rad_s = {part, -0.5f * part}};
    const uint32_t start = instruction_count_now();
    const pointing_output out = pointing_step(&both, &frame, &motion, dt_s);
    cost_row_add(&pointing_row, instruction_count_since(start));
    pointing_tracker_prepare(&both.tracker, &params.tracker, out.error_of_joints_rad, dt_s);
  }
}

int main(int argc, char **argv) {
  bool good = instruction_count_start();
  for (int i = 1; i < argc; ++i) {
    good = core_replay(argv[i], NULL, COUNTED_TICKS) && good;
  }
  sweep_speed_loop();
  sweep_setpoint_model();
  sweep_pointing();
  cost_table_head();
  good = cost_row_print(&speed_loop) && good;
  good = cost_row_print(&any_speed_loop) && good;
  good = cost_row_print(&model_row) && good;
  good = cost_row_print(&motor) && good;
  good = cost_row_print(&pointing_row) && good;
  return good ? 0 : 1;
}
