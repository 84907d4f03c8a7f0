/* SPDX-License-Identifier: Apache-2.0 */
/* What a board connects to the chip. Its folder defines these tables in wiring.c, and the functions of pins.h; the
 * drivers of the chip know no axis and no pin besides. */
#ifndef TRACKSERVO_STM32G4_CONNECTIONS_H
#define TRACKSERVO_STM32G4_CONNECTIONS_H

#include "hal.h"
#include "registers/gpio.h"
#include "registers/spi.h"
#include "registers/timer.h"
#include "registers/usart.h"

/* A timer with channels 1 and 2 for the legs, break input 1 for the driver's fault and 2 for channel B of STO. TIM1
 * starts the others and triggers the ADCs: it belongs to axis 0, TIM8 to axis 1. */
typedef struct {
  tim1_registers *timer;
  gpio_registers *enable_port;
  uint32_t enable_pin; /* high: the gate driver is enabled */
} bridge_connection;

/* Two channels of DMA1, from 0, with their requests. */
typedef struct {
  spi1_registers *spi;
  uint32_t receive_channel;
  uint32_t receive_request;
  uint32_t transmit_channel;
  uint32_t transmit_request;
} encoder_connection;

/* A channel of DMA2, from 0, with its request. */
typedef struct {
  usart1_registers *usart;
  uint32_t channel;
  uint32_t request;
} gyro_connection;

/* Inputs 1 to 9 of an ADC: the current of axis 0 and the bus voltage at ADC1, the current of axis 1 and the heat sink's
 * thermistor at ADC2. */
typedef struct {
  uint32_t current_input;
  uint32_t second_input;
} adc_connection;

/* BOARD_AXES: how many axes the board has, 1 .. HAL_AXES; its CMakeLists.txt defines it, so that every loop over the
 * axes has a constant bound. The tables have a row for each. */

extern const bridge_connection board_bridges[HAL_AXES];
extern const encoder_connection board_encoders[HAL_AXES];
extern const gyro_connection board_gyros[HAL_AXES];
extern const adc_connection board_adcs[2];

/* Before the stored ones (object 0x3060) are known. */
extern const hal_scales board_scales_at_first;

#endif
