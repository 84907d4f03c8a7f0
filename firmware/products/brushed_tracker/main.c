/* SPDX-License-Identifier: Apache-2.0 */
/* The servo on a board: one node, and the order of its calls.
 *
 *     PWM period (20 kHz)     motor stages of both axes
 *     pre-tick task           node: process data that has arrived already
 *     tick (1 kHz)            node: process data, protection, drives, control
 *     CAN frame               node: into one of its queues
 *     deferred task (1 kHz)   node: communication other than process data; each tick starts it
 *     background              watchdog, storing of parameters
 *
 * Each may interrupt those below it. */
#include <stdint.h>

#include "canopen/heard_frames.h"
#include "hal_board.h"
#include "node/servo_node.h"
#include "products/brushed_tracker/default_parameters.h"

typedef struct {
  hal *machine;
  servo_node node;
  hal_can_state can_state;
} servo_main;

static servo_main self;

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

static void pwm_period(void *context, uint32_t period) { servo_board_pwm_period(context, period); }

static void pre_tick(void *context) {
  (void)context;
  servo_node_take(&self.node);
}

static void tick(void *context) {
  (void)context;
  servo_node_tick_taken(&self.node); /* pre_tick has just run */
}

static void deferred(void *context) {
  (void)context;
  report_can_state();
  canopen_node_lost_frames(&self.node.canopen, hal_can_lost_frames(self.machine));
  servo_node_serve(&self.node);
}

static void receive(void *context, const can_frame *frame) {
  (void)context;
  (void)servo_node_receive(&self.node, frame);
}

static bool send(void *context, const can_frame *frame) { return hal_can_send(context, frame); }

static bool join(void *context, uint16_t kbit_s) { return hal_can_join(context, kbit_s); }

/* A failed self-test persists; the reset cause is reported once, and is in 1003 and the fault log. */
static void report_how_it_started(uint32_t failed_tests) {
  static const fault_id fault_of[] = {[HAL_RESET_WATCHDOG] = FAULT_WATCHDOG_RESET,
                                      [HAL_RESET_FAULT] = FAULT_EXCEPTION_RESET,
                                      [HAL_RESET_BROWN_OUT] = FAULT_BROWN_OUT_RESET,
                                      [HAL_RESET_STACK_OVERFLOW] = FAULT_STACK_OVERFLOW,
                                      [HAL_RESET_RAM_PARITY] = FAULT_RAM_PARITY};
  if ((failed_tests & ~(uint32_t)HAL_TEST_BANKS) != 0) {
    servo_node_report(&self.node, FAULT_SELF_TEST, (uint8_t)failed_tests, true);
  }
  enum { NO_RAM_PARITY = 1, NO_WRITE_PROTECTION = 2, OTHER_BANKS = 4 };
  const uint32_t status = hal_status(self.machine);
  const uint32_t missing = ((status & HAL_STATUS_RAM_PARITY) != 0 ? 0U : NO_RAM_PARITY) |
                           ((status & HAL_STATUS_WRITE_PROTECTION) != 0 ? 0U : NO_WRITE_PROTECTION) |
                           ((status & HAL_STATUS_FLASH_BANKS) != 0 ? 0U : OTHER_BANKS);
  if (missing != 0) {
    servo_node_report(&self.node, FAULT_OPTION_BYTES, (uint8_t)missing, false);
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

static const hal_board_tasks tasks = {.context = &self.node.board,
                                      .pwm_period = pwm_period,
                                      .pre_tick = pre_tick,
                                      .tick = tick,
                                      .can_frame = receive,
                                      .deferred = deferred};

/* Not inlined: main, on whose stack everything else lies, would keep its frame. */
__attribute__((noinline)) static void background(void) {
  hal_board_background(self.machine);
  servo_node_background(&self.node);
}

int main(void) {
  self.machine = hal_board_start();
  uint32_t failed_tests = hal_board_self_test(self.machine);
  hal_can_accept(self.machine, heard_ranges, HEARD_RANGES);
  const servo_node_config config = {.node_id = BUS_DEFAULT_NODE_ID,
                                    .sender = {send, self.machine},
                                    .machine = self.machine,
                                    .parameters = default_parameters,
                                    .limits = default_limits,
                                    .flash = hal_board_flash(self.machine),
                                    .serial_number = hal_board_serial_number(self.machine),
                                    .hardware_version = TRACKSERVO_PRODUCT ", " TRACKSERVO_BOARD,
                                    .bus = {.kbit_s = BUS_DEFAULT_KBIT_S,
                                            .recovering = hal_board_recovery_is_requested(self.machine),
                                            .flash = hal_board_bus_flash(self.machine),
                                            .joiner = {join, self.machine}}};
  if (!servo_node_start(&self.node, &config)) {
    /* Bound: for ever: a build that was never tested; everything stays off and nothing answers. */
    for (;;) {
    }
  }
  if (self.node.objects.bus.join_failed) {
    hal_board_fail(self.machine, HAL_TEST_CONTROLLER);
    failed_tests |= HAL_TEST_CONTROLLER;
  }
  const uint32_t unused = unused_gyros();
  hal_board_waive(self.machine, unused);
  report_how_it_started(failed_tests & ~unused);
  hal_board_run(self.machine, &tasks);
  /* Bound: for ever: the background, which every interrupt leaves. */
  for (;;) {
    background();
  }
}
