/* cost_core TRACE...: instructions of the servo core's parts over the traces, as a table; ends with 1 when one of them
 * costs more than is asked.
 *
 * The linker hands the parts to this program first (--wrap): a part is counted from before its call to after it. */
#include <stdio.h>

#include "app/servo_app.h"
#include "cortex_m4/core_replay.h"
#include "cortex_m4/cost_table.h"
#include "cortex_m4/instruction_count.h"

static cost_row speed_loop = {.name = "speed loop, one axis", .asked = 600};
static cost_row current_loop = {.name = "current loop, one axis", .asked = 250};
static int sense_cost;

speed_loop_rates __real_speed_loop_sense(speed_loop_state *state, const speed_loop_params *params,
                                         const speed_loop_samples *samples, float dt_s);
speed_loop_rates __wrap_speed_loop_sense(speed_loop_state *state, const speed_loop_params *params,
                                         const speed_loop_samples *samples, float dt_s);

speed_loop_rates __wrap_speed_loop_sense(speed_loop_state *state, const speed_loop_params *params,
                                         const speed_loop_samples *samples, float dt_s) {
  const uint32_t start = instruction_count_now();
  const speed_loop_rates rates = __real_speed_loop_sense(state, params, samples, dt_s);
  sense_cost = instruction_count_since(start);
  return rates;
}

speed_loop_output __real_speed_loop_control(speed_loop_state *state, const speed_loop_params *params,
                                            const speed_loop_rates *rates, const speed_reference *reference,
                                            float applied_nm, const torque_limits *limits, float dt_s);
speed_loop_output __wrap_speed_loop_control(speed_loop_state *state, const speed_loop_params *params,
                                            const speed_loop_rates *rates, const speed_reference *reference,
                                            float applied_nm, const torque_limits *limits, float dt_s);

speed_loop_output __wrap_speed_loop_control(speed_loop_state *state, const speed_loop_params *params,
                                            const speed_loop_rates *rates, const speed_reference *reference,
                                            float applied_nm, const torque_limits *limits, float dt_s) {
  const uint32_t start = instruction_count_now();
  const speed_loop_output output = __real_speed_loop_control(state, params, rates, reference, applied_nm, limits, dt_s);
  cost_row_add(&speed_loop, sense_cost + instruction_count_since(start));
  return output;
}

float __real_servo_app_pwm(servo_app *app, int axis, float current_a, float bus_voltage_v);
float __wrap_servo_app_pwm(servo_app *app, int axis, float current_a, float bus_voltage_v);

float __wrap_servo_app_pwm(servo_app *app, int axis, float current_a, float bus_voltage_v) {
  const uint32_t start = instruction_count_now();
  const float duty = __real_servo_app_pwm(app, axis, current_a, bus_voltage_v);
  cost_row_add(&current_loop, instruction_count_since(start));
  return duty;
}

int main(int argc, char **argv) {
  bool good = instruction_count_start();
  for (int i = 1; i < argc; ++i) {
    good = core_replay(argv[i], NULL) && good;
  }
  cost_table_head();
  good = cost_row_print(&speed_loop) && good;
  good = cost_row_print(&current_loop) && good;
  return good ? 0 : 1;
}
