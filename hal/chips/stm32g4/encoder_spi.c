/* SPDX-License-Identifier: Apache-2.0 */
#include "encoder_spi.h"

#include "connections.h"
#include "registers/dma.h"
#include "sensors/angle_mean.h"

/* The sent data are ignored by the encoder; sending generates the clock. */
static const uint8_t sent = 0;

/* DMA needs addresses as numbers. */
static uint32_t address(const volatile void *object) { return (uint32_t)(uintptr_t)object; }

static void start_port(const encoder_connection *port) {
  dma_ch_registers *receive = &DMA1->ch[port->receive_channel];
  dma_ch_registers *transmit = &DMA1->ch[port->transmit_channel];
  DMAMUX->ccr[port->receive_channel] = FIELD_VALUE(DMAMUX_CCR_DMAREQ_ID, port->receive_request);
  DMAMUX->ccr[port->transmit_channel] = FIELD_VALUE(DMAMUX_CCR_DMAREQ_ID, port->transmit_request);
  receive->par = address(&port->spi->dr);
  transmit->par = address(&port->spi->dr);
  port->spi->cr2 = FIELD_VALUE(SPI1_CR2_DS, 8 - 1) | SPI1_CR2_FRXTH | SPI1_CR2_RXDMAEN | SPI1_CR2_TXDMAEN;
  const uint32_t mode = SPI1_CR1_MSTR | SPI1_CR1_SSM | SPI1_CR1_SSI | SPI1_CR1_CPOL | SPI1_CR1_CPHA |
                        FIELD_VALUE(SPI1_CR1_BR, SPI1_BR_PCLK_32);
  port->spi->cr1 = mode;
  port->spi->cr1 = mode | SPI1_CR1_SPE;
}

void encoder_start(encoder_readings readings[]) {
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    readings[axis] = (encoder_readings){0};
    start_port(&board_encoders[axis]);
  }
}

enum { RECEIVE_MODE = DMA_CH_CR_MINC | FIELD_VALUE(DMA_CH_CR_PL, DMA_PRIORITY_HIGH), TRANSMIT_MODE = DMA_CH_CR_DIR };

/* Addresses and counts can be written only while a channel is off. */
static void arm(dma_ch_registers *channel, uint32_t mode, const volatile void *memory) {
  channel->cr = mode;
  channel->mar = address(memory);
  channel->ndtr = BISS_BYTES;
  channel->cr = mode | DMA_CH_CR_EN;
}

void encoder_begin_read(encoder_readings readings[], int number) {
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    arm(&DMA1->ch[board_encoders[axis].receive_channel], RECEIVE_MODE, readings[axis].answer[number]);
    arm(&DMA1->ch[board_encoders[axis].transmit_channel], TRANSMIT_MODE, &sent);
  }
}

/* The buffer is cleared after reading, so that a missing answer is not taken for an old one. */
void encoder_decode(encoder_readings *readings) {
  if (readings->decoded >= ENCODER_READS_PER_TICK) {
    return; /* all of them are */
  }
  uint32_t *answer = readings->answer[readings->decoded++];
  biss_reading reading;
  if (biss_decode((const uint8_t *)answer, &reading) == BISS_OK) {
    readings->good_turn32[readings->good++] = reading.angle_turn32;
    readings->warning = reading.warning;
  } else {
    readings->refused++;
  }
  answer[0] = 0;
  answer[1] = 0;
}

bool encoder_take(encoder_readings *readings, uint32_t *angle_turn32) {
  for (int i = 0; i < ENCODER_READS_PER_TICK; ++i) {
    encoder_decode(readings);
  }
  const int good = readings->good;
  readings->decoded = 0;
  readings->good = 0;
  if (good == 0) {
    return false;
  }
  *angle_turn32 = angle_mean(readings->good_turn32, good);
  return true;
}
