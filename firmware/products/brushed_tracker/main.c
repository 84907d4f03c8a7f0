/* The servo on a board: one node, two current loops, and the order of their calls.
 *
 *     PWM period (20 kHz)   current loops
 *     before the tick       node: process data that has come already
 *     tick (1 kHz)          node: process data, protection, drives, control; then the new set-points are handed over
 *     CAN frame             into one of the node's queues
 *     service (1 kHz)       node: what only the bus wants, begun by each tick
 *     background            watchdog, storing of parameters
 *
 * Each may interrupt those below it. */
#include <stdint.h>

#include "hal_board.h"
#include "node/servo_node.h"
#include "products/brushed_tracker/default_parameters.h"
#include "products/brushed_tracker/hardware_version.h"
#include "servo/current_stage.h"

typedef struct {
  hal *machine;
  servo_node node;
  current_stage stage[SERVO_AXES];
  hal_can_state can_state;
} servo_main;

static servo_main self;

void main_pwm_period(uint32_t period) {
  const float bus_voltage_v = hal_bus_voltage_v(self.machine);
  for (int i = 0; i < SERVO_AXES; ++i) {
    const float current_a = hal_current_a(self.machine, i);
    hal_set_duty(self.machine, i, current_stage_step(&self.stage[i], period, current_a, bus_voltage_v));
  }
}

static void report_can_state(void) {
  const hal_can_state state = hal_can_supervise(self.machine);
  if (state == self.can_state) {
    return;
  }
  if (state == HAL_CAN_BUS_OFF) {
    servo_node_bus_off(&self.node);
  }
  if (self.can_state == HAL_CAN_BUS_OFF) {
    canopen_node_bus_off_recovered(&self.node.canopen);
  }
  canopen_node_error_passive(&self.node.canopen, state == HAL_CAN_ERROR_PASSIVE);
  self.can_state = state;
}

void main_before_tick(void) { servo_node_take(&self.node); }

void main_tick(void) {
  servo_app *app = &self.node.board.app;
  for (int i = 0; i < SERVO_AXES; ++i) {
    app->axis[i].current.limited = atomic_load_explicit(&self.stage[i].limited, memory_order_relaxed);
    app->axis[i].current.voltage_v = atomic_load_explicit(&self.stage[i].voltage_v, memory_order_relaxed);
  }
  servo_node_tick_taken(&self.node); /* main_before_tick ran in this period */
  for (int i = 0; i < SERVO_AXES; ++i) {
    const servo_current_command command = servo_axis_current_command(&app->axis[i], &app->params.axis[i]);
    current_stage_hand_over(&self.stage[i], &command);
    hal_power_bridge(self.machine, i, command.powered);
  }
}

void main_service(void) {
  report_can_state();
  servo_node_serve(&self.node);
}

void main_can_frame(const can_frame *frame) { (void)servo_node_receive(&self.node, frame); }

static bool send(void *context, const can_frame *frame) { return hal_can_send(context, frame); }

static bool join(void *context, uint16_t kbit_s) { return hal_can_join(context, kbit_s); }

/* A failed self-test persists; the reset cause is reported once, and is in 1003 and the fault log. */
static void report_how_it_started(uint32_t failed_tests) {
  static const fault_id fault_of[] = {[HAL_RESET_WATCHDOG] = FAULT_WATCHDOG_RESET,
                                      [HAL_RESET_FAULT] = FAULT_EXCEPTION_RESET,
                                      [HAL_RESET_BROWN_OUT] = FAULT_BROWN_OUT_RESET,
                                      [HAL_RESET_STACK_OVERFLOW] = FAULT_STACK_OVERFLOW};
  if (failed_tests != 0) {
    servo_node_report(&self.node, FAULT_SELF_TEST, (uint8_t)failed_tests, true);
  }
  const hal_reset reset = hal_board_reset(self.machine);
  if (reset.cause < sizeof fault_of / sizeof fault_of[0] && fault_of[reset.cause] != FAULT_NONE) {
    const uint8_t exception_shift = 4;
    const uint8_t detail = (uint8_t)(reset.exception << exception_shift | (uint8_t)reset.cause);
    servo_node_report(&self.node, fault_of[reset.cause], detail, false);
  }
}

/* Self-tests of gyros that the axes do not use (2050:1 = 0). */
static uint32_t unused_gyros(void) {
  const uint32_t bits[SERVO_AXES] = {HAL_TEST_GYRO_AZIMUTH, HAL_TEST_GYRO_PITCH};
  uint32_t unused = 0;
  for (int i = 0; i < SERVO_AXES; ++i) {
    const rate_source source = self.node.board.app.params.axis[i].speed.rate_fusion.source;
    unused |= source == RATE_FROM_ENCODER ? bits[i] : 0;
  }
  return unused;
}

int main(void) {
  self.machine = hal_board_start();
  uint32_t failed_tests = hal_board_self_test(self.machine);
  for (int i = 0; i < SERVO_AXES; ++i) {
    current_stage_reset(&self.stage[i]);
  }
  const servo_node_config config = {.node_id = BUS_DEFAULT_NODE_ID,
                                    .sender = {send, self.machine},
                                    .machine = self.machine,
                                    .parameters = default_parameters,
                                    .limits = default_limits,
                                    .flash = hal_board_flash(self.machine),
                                    .serial_number = hal_board_serial_number(self.machine),
                                    .hardware_version = HARDWARE_VERSION,
                                    .bus = {.kbit_s = BUS_DEFAULT_KBIT_S,
                                            .recovering = hal_board_recovery_is_requested(self.machine),
                                            .flash = hal_board_bus_flash(self.machine),
                                            .joiner = {join, self.machine}}};
  if (!servo_node_start(&self.node, &config)) {
    for (;;) { /* a build that was never tested: everything stays off and nothing answers */
    }
  }
  if (self.node.objects.bus.join_failed) {
    hal_board_fail(self.machine, HAL_TEST_CONTROLLER);
    failed_tests |= HAL_TEST_CONTROLLER;
  }
  const uint32_t unused = unused_gyros();
  hal_board_waive(self.machine, unused);
  report_how_it_started(failed_tests & ~unused);
  hal_board_run(self.machine);
  for (;;) {
    hal_board_background(self.machine);
    servo_node_background(&self.node);
  }
}
