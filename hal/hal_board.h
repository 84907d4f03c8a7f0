/* What a platform with a life of its own does besides hal.h: it starts, tests itself, interrupts, and has a CAN
 * controller. firmware/products/brushed_tracker/main.c is the only caller.
 *
 *     hal_board_start -> hal_board_self_test -> hal_can_join -> hal_board_run -> hal_board_background, for ever
 *                                      \-> interrupts: main_pwm_period, main_before_tick, main_tick,
 *                                                      main_can_frame, main_service */
#ifndef TRACKSERVO_HAL_BOARD_H
#define TRACKSERVO_HAL_BOARD_H

#include "base/can_frame.h"
#include "hal.h"
#include "hal_flash.h"

/* Why the board started. The numbers go out by EMCY. */
typedef enum {
  HAL_RESET_POWER_ON = 1,
  HAL_RESET_PIN = 2,
  HAL_RESET_SOFTWARE = 3,
  HAL_RESET_WATCHDOG = 4, /* tick, current loop or background did not do their work */
  HAL_RESET_FAULT = 5,    /* an exception of the processor, then the watchdog */
  HAL_RESET_OTHER = 6,
  HAL_RESET_BROWN_OUT = 7,     /* the supply dipped: the memory still knew the time before */
  HAL_RESET_STACK_OVERFLOW = 8 /* a fault as 5, but known to be the stack's */
} hal_reset_cause;

typedef struct {
  hal_reset_cause cause;
  uint8_t exception;        /* of a fault: 2 NMI, 3 HardFault, 4 MemManage, 5 BusFault, 6 UsageFault .. */
  uint32_t program_counter; /* of a fault, where it was known */
} hal_reset;

/* What a self-test found. The lower eight bits go out by EMCY; none of them there is HAL_TEST_MEMORY. */
enum {
  HAL_TEST_IMAGE = 0x01,           /* CRC of the program memory */
  HAL_TEST_CLOCK = 0x02,           /* the frames of no gyro that is heard come at 1 kHz */
  HAL_TEST_CURRENT_OFFSET = 0x04,  /* a current sensor shows current while the bridges are off */
  HAL_TEST_ENCODER_AZIMUTH = 0x08, /* no plausible answer */
  HAL_TEST_ENCODER_PITCH = 0x10,
  HAL_TEST_GYRO_AZIMUTH = 0x20,
  HAL_TEST_GYRO_PITCH = 0x40,
  HAL_TEST_CONTROLLER = 0x80, /* ADC, CAN controller or watchdog did not start */
  HAL_TEST_MEMORY = 0x100,    /* RAM; no other test is made then */
  HAL_TEST_COMMON = HAL_TEST_IMAGE | HAL_TEST_CLOCK | HAL_TEST_CONTROLLER | HAL_TEST_MEMORY /* keep both axes */
};

typedef enum { HAL_CAN_GOOD = 0, HAL_CAN_ERROR_PASSIVE, HAL_CAN_BUS_OFF } hal_can_state;

/* Clock, pins and peripherals; the bridges are off. Does not return without a clock: the LED blinks then. */
hal *hal_board_start(void);

hal_reset hal_board_reset(const hal *machine);

/* Of this board and no other, from what its chip is marked with. */
uint32_t hal_board_serial_number(const hal *machine);

/* HAL_TEST_* bits, 0: all is well. Both axes are not ready with one of HAL_TEST_COMMON, one axis with its own encoder
 * or current sensor; a gyro keeps none. About 0.1 s; the RAM was tested before. */
uint32_t hal_board_self_test(hal *machine);

/* Adds bits that the caller's own tests found. */
void hal_board_fail(hal *machine, uint32_t test_bits);

/* Takes bits of gyros back that nobody uses, so that the LED does not tell of them. */
void hal_board_waive(hal *machine, uint32_t test_bits);

/* The parameter pages, as two areas. Erasing and programming them is for the background: 25 ms and 0.1 ms, in which the
 * interrupts go on and the watchdog is refreshed. */
const hal_flash *hal_board_flash(hal *machine);

/* Pages for node id and bit rate, BUS_SETTINGS_LOG_PAGES of them; likewise. */
const hal_flash *hal_board_bus_flash(hal *machine);

/* Somebody asks at the board itself for node id and bit rate as delivered: a button was held from the start until now.
 * After the self-test. */
bool hal_board_recovery_is_asked(const hal *machine);

/* Interrupts and watchdog from now on. */
void hal_board_run(hal *machine);

/* The background, to be called without end: refreshes the watchdog while tick and PWM periods come as they should. */
void hal_board_background(hal *machine);

/* Takes part in the bus at this bit rate (1000, 500, 250 or 125 kbit/s) from now on. Before hal_board_run, and again
 * from the service for another one; frames under way are lost then. False: the controller does not answer. */
bool hal_can_join(hal *machine, uint16_t kbit_s);

/* From the service only. False: no room, try again later. */
bool hal_can_send(hal *machine, const can_frame *frame);

/* From the service, once. A bus-off is ended after 100 ms. */
hal_can_state hal_can_supervise(hal *machine);

/* --- main.c gives these --- */

/* Every PWM period; `period` counts from 0, the period in which the tick samples, to 19. */
void main_pwm_period(uint32_t period);

/* Shortly before a tick, one or more times; neither within it nor within the service. */
void main_before_tick(void);

/* Every 1 ms, interrupted by the PWM period. */
void main_tick(void);

/* A frame was received; interrupted by both. */
void main_can_frame(const can_frame *frame);

/* After every tick, interrupted by all of these; done long before the next tick. */
void main_service(void);

#endif
