/* SPDX-License-Identifier: Apache-2.0 */
/* What a platform with interrupts does besides hal.h: it starts, tests itself, calls the product's tasks, and has a CAN
 * controller. The product's main.c is the only caller.
 *
 *     hal_board_start -> hal_board_self_test -> hal_can_join -> hal_board_run -> hal_board_background, without end
 *                                                                     \-> interrupts: hal_board_tasks */
#ifndef TRACKSERVO_HAL_BOARD_H
#define TRACKSERVO_HAL_BOARD_H

#include "base/can_frame.h"
#include "hal.h"
#include "hal_flash.h"

/* Why the board started. The numbers are sent by EMCY. */
typedef enum {
  HAL_RESET_POWER_ON = 1,
  HAL_RESET_PIN = 2,
  HAL_RESET_SOFTWARE = 3,
  HAL_RESET_WATCHDOG = 4, /* tick, current loop or background did not run in time */
  HAL_RESET_FAULT = 5,    /* an exception of the processor, then the watchdog */
  HAL_RESET_OTHER = 6,
  HAL_RESET_BROWN_OUT = 7,      /* the supply dipped: the memory still had its contents */
  HAL_RESET_STACK_OVERFLOW = 8, /* a fault like 5, known to come from the stack */
  HAL_RESET_RAM_PARITY = 9      /* a fault like 5: the RAM found a wrong bit */
} hal_reset_cause;

typedef struct {
  hal_reset_cause cause;
  uint8_t exception;        /* of a fault: 2 NMI, 3 HardFault, 4 MemManage, 5 BusFault, 6 UsageFault .. */
  uint32_t program_counter; /* of a fault, when it was known */
} hal_reset;

/* Results of a self-test. The lower eight bits are sent by EMCY; none of them there is HAL_TEST_MEMORY. HAL_TEST_BANKS
 * is an option byte, and reported as one. */
enum {
  HAL_TEST_IMAGE = 0x01,           /* CRC of the program memory, or the copy of its hot code in RAM */
  HAL_TEST_CLOCK = 0x02,           /* the frames of no connected gyro come at 1 kHz */
  HAL_TEST_CURRENT_OFFSET = 0x04,  /* a current sensor shows current while the bridges are off */
  HAL_TEST_ENCODER_AZIMUTH = 0x08, /* no plausible answer */
  HAL_TEST_ENCODER_PITCH = 0x10,
  HAL_TEST_GYRO_AZIMUTH = 0x20,
  HAL_TEST_GYRO_PITCH = 0x40,
  HAL_TEST_CONTROLLER = 0x80, /* ADC, CAN controller or watchdog did not start */
  HAL_TEST_MEMORY = 0x100,    /* RAM; then no other test is made */
  HAL_TEST_BANKS = 0x200,     /* HAL_STATUS_FLASH_BANKS is missing: nothing can be stored */
  HAL_TEST_COMMON = HAL_TEST_IMAGE | HAL_TEST_CLOCK | HAL_TEST_CONTROLLER | HAL_TEST_MEMORY | HAL_TEST_BANKS
  /* disable both axes */
};

typedef enum { HAL_CAN_GOOD = 0, HAL_CAN_ERROR_PASSIVE, HAL_CAN_BUS_OFF } hal_can_state;

/* Starts clock, pins and peripherals; the bridges are off. Does not return without a clock: the LED blinks then. */
hal *hal_board_start(void);

hal_reset hal_board_reset(const hal *machine);

/* Returns a serial number unique to this board, from the marking of its chip. */
uint32_t hal_board_serial_number(const hal *machine);

/* Tests the board. Returns HAL_TEST_* bits, 0 without an error. Both axes are not ready with one of HAL_TEST_COMMON,
 * one axis with an error of its own encoder or current sensor; a gyro disables no axis. Takes about 0.1 s; the RAM was
 * tested before. */
uint32_t hal_board_self_test(hal *machine);

/* Adds bits from the caller's own tests. */
void hal_board_fail(hal *machine, uint32_t test_bits);

/* Clears bits of gyros that are not used, so that the LED does not report them. */
void hal_board_waive(hal *machine, uint32_t test_bits);

/* Returns the parameter pages, as two areas. Erase and program them in the background only: 25 ms and 0.1 ms, during
 * which the interrupts run and the watchdog is refreshed. */
const hal_flash *hal_board_flash(hal *machine);

/* Returns the pages for node id and bit rate, BUS_SETTINGS_LOG_PAGES of them; the same applies. */
const hal_flash *hal_board_bus_flash(hal *machine);

/* Returns whether a user requests the default node id and bit rate, by a button held from the start until now. Call it
 * after the self-test. */
bool hal_board_recovery_is_requested(const hal *machine);

/* What the interrupts call, each with `context`. The order is that of urgency: each task interrupts those below it. No
 * pointer may be NULL. */
typedef struct {
  void *context;

  /* Every PWM period; `period` counts from 0, the period in which the tick samples, to 19. */
  void (*pwm_period)(void *context, uint32_t period);

  /* Shortly before a tick, one or more times. Interrupts neither the tick nor the deferred task. */
  void (*pre_tick)(void *context);

  /* Every 1 ms, in period 0 after `pwm_period`. */
  void (*tick)(void *context);

  /* A frame was received. */
  void (*can_frame)(void *context, const can_frame *frame);

  /* After every tick. Must end before the next tick: a tick that finds it running is skipped, and a reset follows. */
  void (*deferred)(void *context);
} hal_board_tasks;

/* Starts interrupts and watchdog; the tasks are copied. */
void hal_board_run(hal *machine, const hal_board_tasks *tasks);

/* Refreshes the watchdog while tick and PWM periods come in time. Call in an endless loop. */
void hal_board_background(hal *machine);

/* The identifiers that the controller receives, at most HAL_CAN_RANGES ranges; it drops all other frames, and extended
 * and remote ones. Call it before the first hal_can_join. `ranges` must stay valid. */
enum { HAL_CAN_RANGES = 28 };
void hal_can_accept(hal *machine, const can_id_range *ranges, uint32_t count);

/* Joins the bus at this bit rate (1000, 500, 250 or 125 kbit/s). Call it before hal_board_run, and again from the
 * deferred task to change the bit rate; frames in the queues are lost then. Returns false when the controller does not
 * answer. */
bool hal_can_join(hal *machine, uint16_t kbit_s);

/* Sends a frame. Call from the deferred task only. Returns false when there is no room; try again later. */
bool hal_can_send(hal *machine, const can_frame *frame);

/* Supervises the CAN controller. Call from the deferred task, once. A bus-off ends after 100 ms. */
hal_can_state hal_can_supervise(hal *machine);

/* Returns how many received frames the controller had no room for since the start; at most one for each interrupt is
 * counted. */
uint32_t hal_can_lost_frames(const hal *machine);

#endif
