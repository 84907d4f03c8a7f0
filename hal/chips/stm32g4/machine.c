/* SPDX-License-Identifier: Apache-2.0 */
/* Implements hal.h and hal_board.h for a board with this chip: combines the drivers and implements the interrupts. */
#include "machine.h"

#include "bridge.h"
#include "can.h"
#include "clock.h"
#include "connections.h"
#include "hot_code.h"
#include "interrupts.h"
#include "pins.h"
#include "ram_parity.h"
#include "ram_test.h"
#include "reset_cause.h"
#include "sensors/thermistor.h"
#include "tick_timer.h"
#include "unique_id.h"
#include "version_block.h"
#include "watchdog.h"

enum { PERIODS_PER_TICK = 20, PERIOD_US = 50, US_PER_TICK = 1000, TICK_AFTER_PERIOD_US = 22 };

/* Without a tick for this long the bridges are switched off; the watchdog reacts later. */
enum { MAX_PERIODS_WITHOUT_TICK = 2 * PERIODS_PER_TICK };

#define TOO_HOT_CELSIUS 85.0f

static hal board;

/* An axis that the board does not have is never ready, and its encoder never answers. */
static bool is_connected(int axis) { return axis < BOARD_AXES; }

/* --- interrupts ------------------------------------------------------------------------------------------------- */

/* The last reading of a tick is that of period 0, 20 us before the tick takes them. */
static void begin_encoder_read(uint32_t period) {
  const uint32_t first = PERIODS_PER_TICK - (ENCODER_READS_PER_TICK - 1);
  if (period >= first) {
    encoder_begin_read(board.encoder, (int)(period - first));
  } else if (period == 0) {
    encoder_begin_read(board.encoder, ENCODER_READS_PER_TICK - 1);
  }
}

/* Each reading is decoded in the period after it; the tick decodes that of period 0. */
static void request_pre_tick(uint32_t period) {
  const uint32_t first = PERIODS_PER_TICK - (ENCODER_READS_PER_TICK - 2);
  if (period >= first || period == 0) {
    interrupt_request(PRE_TICK_INTERRUPT);
  }
}

static void keep_mean_currents(uint32_t period) {
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    if (period == 0) {
      board.mean_current_a[axis] = board.current_sum_a[axis] * (1.0f / (float)PERIODS_PER_TICK);
      board.current_sum_a[axis] = 0.0f;
    }
    board.current_sum_a[axis] += board.current_a[axis];
  }
}

static void trip(int axis, hal_health why) {
  bridge_trip(axis);
  board.tripped[axis] = why;
}

static void take_currents(void) {
  const current_sense_sample sample = current_sense_read();
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    const uint32_t counts = sample.current_counts[axis];
    board.current_a[axis] = ((float)(int32_t)counts - board.offset_counts[axis]) * board.scales.amperes_per_count[axis];
    if (board.powered[axis] && current_sense_is_over(&board.scales, axis, counts)) {
      trip(axis, HAL_OVER_CURRENT);
    }
  }
  board.bus_voltage_v = (float)(int32_t)sample.bus_counts * board.scales.volts_per_count;
  board.heat_sink_counts = sample.heat_sink_counts;
}

static void lose_timing(void) {
  board.timing_lost = true;
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    bridge_trip(axis);
    pins_release_brake(axis, false);
  }
}

/* Channel A has removed the drivers' enable already; without the timers' outputs nothing switches when it returns. */
static void follow_safe_torque(void) {
  const safe_torque_inputs inputs = pins_read_safe_torque();
  board.safe_torque_state = safe_torque_step(&board.safe_torque, &inputs);
  for (int axis = 0; axis < BOARD_AXES && board.safe_torque_state != SAFE_TORQUE_ON; ++axis) {
    trip(axis, HAL_SAFE_TORQUE_OFF);
  }
}

static void switch_off_without_tick(void) {
  if (++board.periods_since_tick > MAX_PERIODS_WITHOUT_TICK) {
    lose_timing();
  }
}

void adc1_2_interrupt(void) {
  const uint32_t period = board.period;
  begin_encoder_read(period);
  current_sense_acknowledge();
  take_currents();
  keep_mean_currents(period);
  board.tasks.pwm_period(board.tasks.context, period);
  switch_off_without_tick();
  request_pre_tick(period);
  board.periods++;
  board.period = period + 1 < PERIODS_PER_TICK ? period + 1 : 0;
}

/* Reads what sensors and bus have already delivered, so that the tick has less to read. Neither interrupts the
 * other. */
void pre_tick_interrupt(void) {
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    encoder_decode(&board.encoder[axis]);
    gyro_read(&board.gyro[axis], axis);
  }
  board.too_hot = thermistor_celsius((int)board.heat_sink_counts) > TOO_HOT_CELSIUS;
  if (!board.service_under_way) { /* otherwise the tick reports an error */
    board.tasks.pre_tick(board.tasks.context);
  }
}

void board_take_samples(hal *machine, int axis) {
  hal_axis_samples *samples = &machine->samples[axis];
  samples->encoder_failed = !encoder_take(&machine->encoder[axis], &samples->joint_angle_turn32);
  samples->gyro_valid = gyro_take(&machine->gyro[axis], axis, &samples->gyro_rad_s);
  samples->mean_current_a = machine->mean_current_a[axis];
}

/* The tick belongs into period 0, after its current loop: anywhere else one of the two clocks is wrong. The tick must
 * not interrupt the deferred task, which can have partially written objects: then this tick and all later ones are
 * skipped. */
void tim6_dac_interrupt(void) {
  tick_timer_acknowledge();
  if (board.period != 1 || board.service_under_way) {
    lose_timing();
  }
  if (board.service_under_way) {
    return;
  }
  board.periods_since_tick = 0;
  follow_safe_torque();
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    board_take_samples(&board, axis);
  }
  board.tasks.tick(board.tasks.context);
  board.ticks++;
  board.service_under_way = true;
  service_request();
}

void pendsv_exception(void) {
  board.tasks.deferred(board.tasks.context);
  board.service_under_way = false;
}

void fdcan1_it0_interrupt(void) {
  can_frame frame;
  can_acknowledge_interrupt();
  for (int i = 0; i < CAN_MAX_FRAMES_PER_INTERRUPT && can_receive(&frame); ++i) {
    board.tasks.can_frame(board.tasks.context, &frame);
  }
  can_send_waiting();
}

static void take_break(int axis) {
  if (is_connected(axis)) {
    board.tripped[axis] = bridge_break_interrupt(axis) ? HAL_SAFE_TORQUE_OFF : HAL_POWER_STAGE;
  }
}

void tim1_brk_interrupt(void) { take_break(0); }

void tim8_brk_interrupt(void) { take_break(1); }

/* --- hal.h ------------------------------------------------------------------------------------------------------ */

void hal_sample(hal *machine, int axis, hal_axis_samples *samples) { *samples = machine->samples[axis]; }

/* Conditions common to both axes, and those of this axis. A missing gyro disables no axis: where one is used, that is
 * fault 5 of the node. */
static bool passed_its_tests(const hal *machine, int axis) {
  return ((machine->test_bits & HAL_TEST_COMMON) | machine->axis_bits[axis]) == 0;
}

hal_health hal_axis_health(hal *machine, int axis) {
  if (!passed_its_tests(machine, axis)) {
    return HAL_NOT_READY;
  }
  if (machine->timing_lost) {
    return HAL_TIMING_LOST;
  }
  if (machine->safe_torque_state != SAFE_TORQUE_ON) {
    return machine->safe_torque_state == SAFE_TORQUE_OFF ? HAL_SAFE_TORQUE_OFF : HAL_SAFE_TORQUE_FAULT;
  }
  if (bridge_fault(axis)) {
    return machine->tripped[axis] == HAL_GOOD ? HAL_POWER_STAGE : machine->tripped[axis];
  }
  if (machine->image_damaged) {
    return HAL_IMAGE_DAMAGED;
  }
  if (machine->clock.failed) {
    return HAL_CLOCK_WRONG;
  }
  return machine->too_hot ? HAL_TOO_HOT : HAL_GOOD;
}

/* After a failed self-test nothing can be powered; damaged RAM may have lost the bit that says so. */
void hal_power_bridge(hal *machine, int axis, bool on) {
  if (!is_connected(axis)) {
    return;
  }
  const bool powered = on && passed_its_tests(machine, axis) && ram_test_passed() && !machine->timing_lost;
  machine->powered[axis] = powered;
  bridge_power(axis, powered);
}

/* Only where torque can stand. */
void hal_release_brake(hal *machine, int axis, bool release) {
  if (is_connected(axis)) {
    pins_release_brake(axis, release && machine->powered[axis] && !bridge_fault(axis));
  }
}

bool hal_brake_is_released(hal *machine, int axis) {
  (void)machine;
  return is_connected(axis) && pins_brake_is_released(axis);
}

static uint32_t bit_if(bool condition, uint32_t bit) { return condition ? bit : 0; }

uint32_t hal_status(hal *machine) {
  const safe_torque_inputs torque = pins_read_safe_torque();
  return machine->option_status | bit_if(torque.channel_a, HAL_STATUS_STO_A) |
         bit_if(torque.channel_b, HAL_STATUS_STO_B) |
         bit_if(hal_brake_is_released(machine, 0), HAL_STATUS_BRAKE_AZIMUTH) |
         bit_if(hal_brake_is_released(machine, 1), HAL_STATUS_BRAKE_PITCH);
}

uint32_t hal_clock_us(hal *machine) {
  (void)machine;
  return strobe_clock_us();
}

/* Both timers have one clock. The tick has been counted when the deferred task runs. */
uint32_t hal_tick_us(hal *machine) { return machine->first_tick_us + (machine->ticks - 1u) * US_PER_TICK; }

void hal_take_strobes(hal *machine, hal_strobes *strobes) { strobe_take(&machine->strobe, strobes); }

float hal_current_a(hal *machine, int axis) { return machine->current_a[axis]; }

float hal_bus_voltage_v(hal *machine) { return machine->bus_voltage_v; }

void hal_set_scales(hal *machine, const hal_scales *scales) { machine->scales = current_sense_scales_of(scales); }

void hal_set_duty(hal *machine, int axis, float duty) {
  (void)machine;
  if (is_connected(axis)) {
    bridge_set_duty(axis, duty);
  }
}

/* --- hal_board.h ------------------------------------------------------------------------------------------------ */

/* Once a second, on the 16 MHz oscillator. */
static void blink_for_ever(void) {
  const uint32_t half_second_cycles = 8000000;
  /* Bound: for ever: the clock has failed, the LED shows it; outputs are off. */
  for (bool lit = true;; lit = !lit) {
    pins_light_led(lit);
    const uint32_t start = clock_cycles();
    /* Bound: half a second, on the core's own counter. */
    while (clock_cycles() - start < half_second_cycles) {
    }
  }
}

static void wait_for_flash(void *context) { hal_board_background(context); }

/* The pages of the image lie in bank 1, from page 0 on. */
static bool image_is_write_protected(void) {
  const uint32_t page_bytes = 2048;
  const uint32_t last_page = (image_version_block.image_bytes - 1u) / page_bytes;
  return field_get(FLASH->wrp1ar, FLASH_WRP1AR_WRP1A_STRT) == 0 &&
         field_get(FLASH->wrp1ar, FLASH_WRP1AR_WRP1A_END) >= last_page;
}

static uint32_t option_status(void) {
  return bit_if(ram_parity_is_on(), HAL_STATUS_RAM_PARITY) |
         bit_if(image_is_write_protected(), HAL_STATUS_WRITE_PROTECTION) |
         bit_if(parameter_flash_has_its_banks(), HAL_STATUS_FLASH_BANKS) |
         bit_if(field_get(FLASH->optr, FLASH_OPTR_RDP) != FLASH_RDP_LEVEL_0, HAL_STATUS_READ_PROTECTION);
}

hal *hal_board_start(void) {
  hal *machine = &board;
  clock_start_cycle_counter();
  machine->reset = reset_cause_take();
  const bool clock_good = clock_start();
  clock_enable_peripherals();
  pins_start();
  if (!clock_good) {
    blink_for_ever();
  }
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    machine->offset_counts[axis] = (float)CURRENT_NOMINAL_OFFSET;
  }
  for (int axis = BOARD_AXES; axis < HAL_AXES; ++axis) {
    machine->axis_bits[axis] = HAL_TEST_ENCODER_PITCH;
    machine->samples[axis].encoder_failed = true;
  }
  hal_set_scales(machine, &board_scales_at_first);
  machine->parameter_flash[0] = parameter_flash(PARAMETER_AREA_0, wait_for_flash, machine);
  machine->parameter_flash[1] = parameter_flash(PARAMETER_AREA_1, wait_for_flash, machine);
  machine->bus_flash = parameter_flash(BUS_SETTINGS_PIECE, wait_for_flash, machine);
  encoder_start(machine->encoder);
  gyro_start(machine->gyro);
  strobe_start(&machine->strobe);
  const bool adc_good = current_sense_start();
  bridge_start();
  clock_check_start();
  machine->image = image_check_begin();
  machine->option_status = option_status();
  machine->test_bits =
      bit_if(!adc_good, HAL_TEST_CONTROLLER) | bit_if(!parameter_flash_has_its_banks(), HAL_TEST_BANKS);
  machine->button_was_held = pins_button_is_held();
  return machine;
}

hal_reset hal_board_reset(const hal *machine) { return machine->reset; }

uint32_t hal_board_serial_number(const hal *machine) {
  (void)machine;
  return unique_id_serial_number();
}

const hal_flash *hal_board_flash(hal *machine) { return machine->parameter_flash; }

const hal_flash *hal_board_bus_flash(hal *machine) { return &machine->bus_flash; }

/* The 80 ms of the self-test are between the two readings. */
bool hal_board_recovery_is_requested(const hal *machine) { return machine->button_was_held && pins_button_is_held(); }

void hal_board_fail(hal *machine, uint32_t test_bits) { machine->test_bits |= test_bits; }

void hal_board_waive(hal *machine, uint32_t test_bits) {
  machine->test_bits &= ~(test_bits & (HAL_TEST_GYRO_AZIMUTH | HAL_TEST_GYRO_PITCH));
}

/* The first tick comes in the next period, which is number 0. */
void hal_board_run(hal *machine, const hal_board_tasks *tasks) {
  machine->tasks = *tasks;
  if (!current_sense_wait()) {
    machine->test_bits |= HAL_TEST_CONTROLLER;
  }
  machine->period = 0;
  machine->first_tick_us = strobe_clock_us() + PERIOD_US + TICK_AFTER_PERIOD_US;
  tick_timer_start(PERIOD_US + TICK_AFTER_PERIOD_US);
  current_sense_enable_interrupt();
  can_enable_interrupt();
  service_start();
  interrupt_enable(TIM1_BRK_INTERRUPT, PRIORITY_DRIVER_FAULT);
  interrupt_enable(TIM8_BRK_INTERRUPT, PRIORITY_DRIVER_FAULT);
  interrupt_enable(ADC1_2_INTERRUPT, PRIORITY_CURRENT_LOOP);
  interrupt_enable(TIM6_DAC_INTERRUPT, PRIORITY_TICK);
  interrupt_enable(PRE_TICK_INTERRUPT, PRIORITY_TICK);
  interrupt_enable(FDCAN1_IT0_INTERRUPT, PRIORITY_CAN);
  if (!watchdog_start()) {
    machine->test_bits |= HAL_TEST_CONTROLLER;
  }
}

/* Checks a piece of the image, and of the hot code, in every tick: 162 KiB take 5.2 s, 31 KiB 1 s; 17 us of each ms. */
static void monitor_image(hal *machine) {
  const uint32_t bytes_per_tick = 32;
  const uint32_t words_per_tick = 8;
  const uint32_t ticks = machine->ticks;
  if (ticks == machine->ticks_at_image_check) {
    return;
  }
  machine->ticks_at_image_check = ticks;
  if (image_check_step(&machine->image, bytes_per_tick) == IMAGE_DAMAGED ||
      !hot_code_check_step(&machine->hot_code_at, words_per_tick)) {
    machine->image_damaged = true;
  }
}

static void monitor_clock(hal *machine) {
  const uint32_t every_ticks = 100;
  const uint32_t ticks = machine->ticks;
  if (ticks - machine->ticks_at_clock_check < every_ticks) {
    return;
  }
  machine->ticks_at_clock_check = ticks;
  clock_check_step(&machine->clock);
}

/* The window of the watchdog is open from the 5th to the 20th ms. */
void hal_board_background(hal *machine) {
  const uint32_t refresh_ticks = 8;
  const uint32_t led_ticks = 512; /* a power of two, so that the LED keeps its rhythm when the count wraps */
  monitor_image(machine);
  monitor_clock(machine);
  const uint32_t ticks = machine->ticks;
  const uint32_t ticks_done = ticks - machine->ticks_at_refresh;
  if (ticks_done < refresh_ticks) {
    __asm volatile("wfi"); /* the next interrupt is at most a PWM period away */
    return;
  }
  const uint32_t periods = machine->periods;
  const uint32_t periods_done = periods - machine->periods_at_refresh;
  const bool right_number = periods_done + PERIODS_PER_TICK > ticks_done * PERIODS_PER_TICK &&
                            periods_done < (ticks_done + 1) * PERIODS_PER_TICK;
  if (machine->timing_lost || !right_number) {
    return; /* and the watchdog resets */
  }
  machine->ticks_at_refresh = ticks;
  machine->periods_at_refresh = periods;
  watchdog_refresh();
  pins_light_led(machine->test_bits != 0 || ticks % (2 * led_ticks) < led_ticks);
}

void hal_can_accept(hal *machine, const can_id_range *ranges, uint32_t count) {
  (void)machine;
  can_accept(ranges, count);
}

bool hal_can_join(hal *machine, uint16_t kbit_s) {
  (void)machine;
  return can_start(kbit_s);
}

bool hal_can_send(hal *machine, const can_frame *frame) {
  (void)machine;
  return can_send(frame);
}

uint32_t hal_can_lost_frames(const hal *machine) {
  (void)machine;
  return can_lost_frames();
}

hal_can_state hal_can_supervise(hal *machine) {
  (void)machine;
  switch (can_supervise()) {
    case CAN_BUS_OFF:
      return HAL_CAN_BUS_OFF;
    case CAN_ERROR_PASSIVE:
      return HAL_CAN_ERROR_PASSIVE;
    case CAN_GOOD:
    default:
      return HAL_CAN_GOOD;
  }
}
