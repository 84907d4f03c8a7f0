/* SPDX-License-Identifier: Apache-2.0 */
/* The state of the machine, one for the chip: data that the interrupts share. */
#ifndef TRACKSERVO_STM32G4_MACHINE_H
#define TRACKSERVO_STM32G4_MACHINE_H

#include "clock_check.h"
#include "current_sense.h"
#include "encoder_spi.h"
#include "gyro_uart.h"
#include "hal_board.h"
#include "image_check.h"
#include "parameter_flash.h"
#include "safe_torque.h"
#include "strobe.h"

/* All that three elements of the FIFO can hold while the interrupt empties it. */
enum { CAN_MAX_FRAMES_PER_INTERRUPT = 6 };

struct hal {
  hal_board_tasks tasks; /* written before the interrupts begin */
  hal_reset reset;
  volatile uint32_t test_bits;           /* HAL_TEST_*, of the self-tests */
  volatile uint32_t axis_bits[HAL_AXES]; /* those that prevent one axis from being driven */

  /* Written by the current loop's interrupt. */
  volatile uint32_t period;  /* the next one: 0 .. 19, 0 is the one in which the tick samples */
  volatile uint32_t periods; /* so far */
  volatile uint32_t periods_since_tick;
  volatile bool timing_lost; /* tick and PWM periods are out of order: the watchdog must reset */
  volatile float current_a[HAL_AXES];
  volatile float current_sum_a[HAL_AXES]; /* of the periods since period 0 */
  volatile float mean_current_a[HAL_AXES];
  volatile float bus_voltage_v;
  volatile uint32_t heat_sink_counts;

  /* Written by the tick's interrupt. */
  volatile uint32_t ticks;            /* done so far */
  hal_axis_samples samples[HAL_AXES]; /* the first ones are the self-test's; no image processor is connected */
  bool too_hot;
  safe_torque safe_torque;
  safe_torque_state safe_torque_state;
  volatile bool powered[HAL_AXES];

  volatile bool service_under_way; /* from the request of the tick to its end */

  volatile hal_health tripped[HAL_AXES]; /* why a bridge was last switched off */
  float offset_counts[HAL_AXES];         /* of the current sensors; written before the interrupts begin */
  current_sense_scales scales;           /* written while the bridges are off */
  encoder_readings encoder[HAL_AXES];
  gyro_line gyro[HAL_AXES];
  strobe_line strobe;
  uint32_t first_tick_us; /* written before the interrupts begin */

  /* The background's. */
  image_check image;
  uint32_t hot_code_at; /* next word to compare */
  uint32_t ticks_at_image_check;
  clock_check clock;
  uint32_t ticks_at_clock_check;
  volatile bool image_damaged;
  hal_flash parameter_flash[2];
  hal_flash bus_flash;
  bool button_was_held;   /* at the start */
  uint32_t option_status; /* HAL_STATUS_ bits that do not change */
  uint32_t ticks_at_refresh;
  uint32_t periods_at_refresh;
};

/* Takes the samples of an axis from what its sensors have delivered since the last call. Call once per tick. */
void board_take_samples(hal *machine, int axis);

#endif
