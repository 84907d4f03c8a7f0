/* SPDX-License-Identifier: Apache-2.0 */
#include "can.h"

#include <stddef.h>

#include "base/can_queue.h"
#include "clock.h"
#include "hal_board.h"
#include "interrupts.h"
#include "registers/fdcan.h"
#include "strobe.h"

/* 34 time quanta a bit: 1 + 29 before the sample point, 4 after it; 170 MHz / 5 at 1 Mbit/s. */
enum { QUANTA_BEFORE_SAMPLE = 29, QUANTA_AFTER_SAMPLE = 4, JUMP_WIDTH_QUANTA = 4, KHZ_OF_QUANTA_PER_KBIT_S = 34 };
_Static_assert(1 + QUANTA_BEFORE_SAMPLE + QUANTA_AFTER_SAMPLE == KHZ_OF_QUANTA_PER_KBIT_S, "quanta of a bit");
_Static_assert(CLOCK_HZ % (KHZ_OF_QUANTA_PER_KBIT_S * 1000000u) == 0, "the prescalers are whole numbers");

enum { MAX_WAIT_US = 1000, BUS_OFF_WAIT_TICKS = 100 };

static uint32_t bus_off_ticks;
static volatile uint32_t lost_frames;
static uint32_t us_per_bit;
static const can_id_range *accepted;
static uint32_t accepted_count;
static can_frame waiting_frames[CAN_SEND_FRAMES];
static can_queue waiting; /* from the deferred task to the interrupt */

static bool wait_for_init(uint32_t wanted) {
  const uint32_t start = clock_cycles();
  /* Bound: MAX_WAIT_US, by the if in it. */
  while ((FDCAN1->cccr & FDCAN_CCCR_INIT) != wanted) {
    if (clock_cycles() - start > MAX_WAIT_US * CLOCK_CYCLES_PER_US) {
      return false;
    }
  }
  return true;
}

void can_accept(const can_id_range *ranges, uint32_t count) {
  accepted = ranges;
  accepted_count = count <= HAL_CAN_RANGES ? count : HAL_CAN_RANGES;
}

static void write_filters(void) {
  /* Bound: HAL_CAN_RANGES, limited when the ranges are set; at the start. */
  for (uint32_t i = 0; i < accepted_count; ++i) {
    FDCAN1_RAM->standard_filter[i] = FIELD_VALUE(STANDARD_FILTER_SFT, FILTER_TYPE_RANGE) |
                                     FIELD_VALUE(STANDARD_FILTER_SFEC, FILTER_TO_FIFO_0) |
                                     FIELD_VALUE(STANDARD_FILTER_ID1, (uint32_t)accepted[i].first) |
                                     FIELD_VALUE(STANDARD_FILTER_ID2, (uint32_t)accepted[i].last);
  }
}

/* Without the interrupt, which reads from the queue and the FIFO that are emptied here. */
bool can_start(uint16_t kbit_s) {
  const uint32_t prescaler = CLOCK_HZ / 1000u / KHZ_OF_QUANTA_PER_KBIT_S / kbit_s;
  const uint32_t lines = FDCAN1->ile;
  FDCAN1->ile = 0;
  bus_off_ticks = 0;
  if (!can_queue_init(&waiting, waiting_frames, CAN_SEND_FRAMES)) {
    return false;
  }
  FDCAN1->cccr |= FDCAN_CCCR_INIT;
  if (!wait_for_init(FDCAN_CCCR_INIT)) {
    return false;
  }
  FDCAN1->cccr |= FDCAN_CCCR_CCE;
  FDCAN1->nbtp =
      FIELD_VALUE(FDCAN_NBTP_NBRP, prescaler - 1) | FIELD_VALUE(FDCAN_NBTP_NTSEG1, QUANTA_BEFORE_SAMPLE - 1) |
      FIELD_VALUE(FDCAN_NBTP_NTSEG2, QUANTA_AFTER_SAMPLE - 1) | FIELD_VALUE(FDCAN_NBTP_NSJW, JUMP_WIDTH_QUANTA - 1);
  FDCAN1->tscc = FIELD_VALUE(FDCAN_TSCC_TSS, FDCAN_TIMESTAMP_IN_BITS);
  us_per_bit = 1000u / (uint32_t)kbit_s;
  write_filters();
  FDCAN1->rxgfc = FIELD_VALUE(FDCAN_RXGFC_LSS, accepted_count) | FDCAN_RXGFC_RRFE | FDCAN_RXGFC_RRFS |
                  FIELD_VALUE(FDCAN_RXGFC_ANFE, FDCAN_NON_MATCHING_REJECTED) |
                  FIELD_VALUE(FDCAN_RXGFC_ANFS, FDCAN_NON_MATCHING_REJECTED);
  FDCAN1->cccr &= ~FDCAN_CCCR_INIT;
  FDCAN1->ile = lines;
  return wait_for_init(0);
}

void can_enable_interrupt(void) {
  FDCAN1->ie = FDCAN_IE_RF0NE | FDCAN_IE_TFEE;
  FDCAN1->ile = FDCAN_ILE_EINT0;
}

static uint32_t word_of(const uint8_t *bytes) {
  return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static void put_word(uint8_t *bytes, uint32_t word) {
  for (int i = 0; i < 4; ++i) {
    bytes[i] = (uint8_t)(word >> (8 * i));
  }
}

static bool has_room(void) { return (FDCAN1->txfqs & FDCAN_TXFQS_TFFL) != 0; }

static void transmit(const can_frame *frame) {
  const uint32_t index = field_get(FDCAN1->txfqs, FDCAN_TXFQS_TFQPI);
  fdcan_element *element = &FDCAN1_RAM->transmit[index];
  const bool extended = (frame->flags & CAN_FRAME_EXTENDED) != 0;
  element->identifier = (extended ? ELEMENT_EXTENDED | FIELD_VALUE(ELEMENT_EXTENDED_ID, frame->id)
                                  : FIELD_VALUE(ELEMENT_STANDARD_ID, frame->id)) |
                        ((frame->flags & CAN_FRAME_REMOTE) != 0 ? ELEMENT_REMOTE : 0u);
  element->control = FIELD_VALUE(ELEMENT_LENGTH, frame->length);
  element->data[0] = word_of(frame->data);
  element->data[1] = word_of(frame->data + 4);
  FDCAN1->txbar = 1u << index;
}

/* While frames wait, only the interrupt writes to the hardware; only frames pushed here wait. It comes when the
 * hardware has sent all its frames; if that was before the frame was pushed, it is requested. */
bool can_send(const can_frame *frame) {
  if (can_queue_front(&waiting) == NULL && has_room()) {
    transmit(frame);
    return true;
  }
  const bool waits = can_queue_push(&waiting, frame);
  if (has_room()) {
    interrupt_request(FDCAN1_IT0_INTERRUPT);
  }
  return waits;
}

void can_send_waiting(void) {
  const can_frame *frame = can_queue_front(&waiting);
  for (int i = 0; i < FDCAN_FIFO_ELEMENTS && frame != NULL && has_room(); ++i) {
    transmit(frame);
    can_queue_drop(&waiting);
    frame = can_queue_front(&waiting);
  }
}

bool can_receive(can_frame *frame) {
  const uint32_t status = FDCAN1->rxf0s;
  if ((status & FDCAN_RXF0S_F0FL) == 0) {
    return false;
  }
  const uint32_t index = field_get(status, FDCAN_RXF0S_F0GI);
  const fdcan_element *element = &FDCAN1_RAM->receive_fifo_0[index];
  const uint32_t identifier = element->identifier;
  const uint32_t control = element->control;
  const uint32_t length = field_get(control, ELEMENT_LENGTH);
  const uint32_t waited_bits = (FDCAN1->tscv - control) & ELEMENT_TIMESTAMP;
  const bool extended = (identifier & ELEMENT_EXTENDED) != 0;
  frame->id = field_get(identifier, extended ? ELEMENT_EXTENDED_ID : ELEMENT_STANDARD_ID);
  frame->flags =
      (uint8_t)((extended ? CAN_FRAME_EXTENDED : 0) | ((identifier & ELEMENT_REMOTE) != 0 ? CAN_FRAME_REMOTE : 0));
  frame->length = (uint8_t)(length <= CAN_FRAME_BYTES ? length : CAN_FRAME_BYTES);
  put_word(frame->data, element->data[0]);
  put_word(frame->data + 4, element->data[1]);
  frame->received_us = (uint16_t)(strobe_clock_us() - waited_bits * us_per_bit);
  FDCAN1->rxf0a = index;
  return true;
}

void can_acknowledge_interrupt(void) {
  if ((FDCAN1->ir & FDCAN_IR_RF0L) != 0) {
    lost_frames++;
  }
  FDCAN1->ir = FDCAN_IR_RF0N | FDCAN_IR_RF0L | FDCAN_IR_TFE;
}

/* The controller leaves the bus by setting INIT. After INIT is cleared it returns after 129 times 11 recessive bits
 * (ISO 11898-1). */
can_state can_supervise(void) {
  const uint32_t status = FDCAN1->psr;
  if ((status & FDCAN_PSR_BO) == 0) {
    bus_off_ticks = 0;
    return (status & FDCAN_PSR_EP) != 0 ? CAN_ERROR_PASSIVE : CAN_GOOD;
  }
  if (++bus_off_ticks >= BUS_OFF_WAIT_TICKS) {
    bus_off_ticks = 0;
    FDCAN1->cccr &= ~FDCAN_CCCR_INIT;
  }
  return CAN_BUS_OFF;
}

uint32_t can_lost_frames(void) { return lost_frames; }
