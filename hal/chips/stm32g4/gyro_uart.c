/* SPDX-License-Identifier: Apache-2.0 */
#include "gyro_uart.h"

#include "clock.h"
#include "connections.h"
#include "registers/dma.h"

enum { BAUD = 921600, NEVER_TICKS = 1000 };

enum { DMAMUX_OF_DMA2 = 8 }; /* its first channel in the multiplexer */

static void start_port(const gyro_connection *port, gyro_line *line) {
  dma_ch_registers *channel = &DMA2->ch[port->channel];
  DMAMUX->ccr[DMAMUX_OF_DMA2 + port->channel] = FIELD_VALUE(DMAMUX_CCR_DMAREQ_ID, port->request);
  channel->par = (uint32_t)(uintptr_t)&port->usart->rdr;
  channel->mar = (uint32_t)(uintptr_t)line->ring;
  channel->ndtr = GYRO_RING_BYTES;
  channel->cr = DMA_CH_CR_MINC | DMA_CH_CR_CIRC;
  channel->cr = DMA_CH_CR_MINC | DMA_CH_CR_CIRC | DMA_CH_CR_EN;
  port->usart->brr = (CLOCK_HZ + BAUD / 2) / BAUD;
  port->usart->cr3 = USART1_CR3_DMAR | USART1_CR3_OVRDIS;
  port->usart->cr1 = USART1_CR1_RE | USART1_CR1_TE;
  port->usart->cr1 = USART1_CR1_RE | USART1_CR1_TE | USART1_CR1_UE;
}

void gyro_start(gyro_line lines[]) {
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    lines[axis] = (gyro_line){.age_ticks = NEVER_TICKS};
    start_port(&board_gyros[axis], &lines[axis]);
  }
}

/* Bytes of the ring from `taken` to `end`. */
static void take_bytes(gyro_line *line, uint32_t end) {
  const uint32_t frames = gyro_frame_take(&line->reader, line->ring + line->taken, end - line->taken, &line->last);
  if (frames != 0) {
    line->frames += frames;
    line->fresh = true;
  }
  line->taken = end % GYRO_RING_BYTES;
}

void gyro_read(gyro_line *line, int axis) {
  const uint32_t written = GYRO_RING_BYTES - DMA2->ch[board_gyros[axis].channel].ndtr;
  if (written < line->taken) {
    take_bytes(line, GYRO_RING_BYTES);
  }
  if (written > line->taken) {
    take_bytes(line, written);
  }
}

bool gyro_take(gyro_line *line, int axis, float *rate_rad_s) {
  gyro_read(line, axis);
  if (line->fresh) {
    line->age_ticks = 0;
  } else if (line->age_ticks < NEVER_TICKS) {
    line->age_ticks++;
  }
  line->fresh = false;
  *rate_rad_s = line->last.rate_rad_s;
  return line->age_ticks <= GYRO_MAX_AGE_TICKS && line->last.valid;
}
