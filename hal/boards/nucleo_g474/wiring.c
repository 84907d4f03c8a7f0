/* SPDX-License-Identifier: Apache-2.0 */
/* The peripherals that the axes of this board use; pins.c has their pins. */
#include "connections.h"
#include "outputs.h"
#include "registers/dma.h"

const bridge_connection board_bridges[HAL_AXES] = {{TIM1, GPIOC, AZIMUTH_ENABLE_PIN}, {TIM8, GPIOC, PITCH_ENABLE_PIN}};

const encoder_connection board_encoders[HAL_AXES] = {{SPI1, 0, DMAMUX_SPI1_RX, 1, DMAMUX_SPI1_TX},
                                                     {SPI3, 2, DMAMUX_SPI3_RX, 3, DMAMUX_SPI3_TX}};

const gyro_connection board_gyros[HAL_AXES] = {{USART1, 0, DMAMUX_USART1_RX}, {USART3, 1, DMAMUX_USART3_RX}};

const adc_connection board_adcs[2] = {{.current_input = 1, .second_input = 6}, {.current_input = 2, .second_input = 7}};

const hal_scales board_scales_at_first = {
    .current_full_scale_a = {25.0f, 25.0f}, .over_current_a = {25.0f, 25.0f}, .voltage_full_scale_v = 66.0f};
