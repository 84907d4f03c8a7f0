/* SPDX-License-Identifier: Apache-2.0 */
/* CAN controller FDCAN1: RM0440, and its part of the message RAM, whose layout is fixed
 * on this chip: two receive FIFOs and a transmit buffer of three elements each, every element 18 words. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_FDCAN_H
#define TRACKSERVO_STM32G4_REGISTERS_FDCAN_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t crel;
  volatile uint32_t endn;
  uint32_t reserved_08;
  volatile uint32_t dbtp;
  volatile uint32_t test;
  volatile uint32_t rwd;
  volatile uint32_t cccr;
  volatile uint32_t nbtp;
  volatile uint32_t tscc;
  volatile uint32_t tscv;
  volatile uint32_t tocc;
  volatile uint32_t tocv;
  uint32_t reserved_30[4];
  volatile uint32_t ecr;
  volatile uint32_t psr;
  volatile uint32_t tdcr;
  uint32_t reserved_4c;
  volatile uint32_t ir;
  volatile uint32_t ie;
  volatile uint32_t ils;
  volatile uint32_t ile;
  uint32_t reserved_60[8];
  volatile uint32_t rxgfc;
  volatile uint32_t xidam;
  volatile uint32_t hpms;
  uint32_t reserved_8c;
  volatile uint32_t rxf0s;
  volatile uint32_t rxf0a;
  volatile uint32_t rxf1s;
  volatile uint32_t rxf1a;
  uint32_t reserved_a0[8];
  volatile uint32_t txbc;
  volatile uint32_t txfqs;
  volatile uint32_t txbrp;
  volatile uint32_t txbar;
  volatile uint32_t txbcr;
} fdcan_registers;
REGISTER_AT(fdcan_registers, ir, 0x50);
REGISTER_AT(fdcan_registers, rxf0s, 0x90);
REGISTER_AT(fdcan_registers, txbcr, 0xD0);

#define FDCAN1 ((fdcan_registers *)0x40006400u)

#define FDCAN_CREL_RESET 0x32141218u
#define FDCAN_ENDN_RESET 0x87654321u
#define FDCAN_DBTP_RESET 0x00000A33u

#define FDCAN_CCCR_RESET 0x00000001u
#define FDCAN_CCCR_INIT FIELD(0, 1)
#define FDCAN_CCCR_CCE FIELD(1, 1)

#define FDCAN_NBTP_RESET 0x06000A03u
#define FDCAN_NBTP_NTSEG2 FIELD(0, 7) /* all four: value - 1 */
#define FDCAN_NBTP_NTSEG1 FIELD(8, 8)
#define FDCAN_NBTP_NBRP FIELD(16, 9)
#define FDCAN_NBTP_NSJW FIELD(25, 7)

#define FDCAN_TSCC_TSS FIELD(0, 2)
#define FDCAN_TSCV_TSC FIELD(0, 16)
enum { FDCAN_TIMESTAMP_IN_BITS = 1 };

#define FDCAN_TOCC_RESET 0xFFFF0000u
#define FDCAN_TOCV_RESET 0x0000FFFFu

#define FDCAN_PSR_RESET 0x00000707u
#define FDCAN_PSR_EP FIELD(5, 1)
#define FDCAN_PSR_BO FIELD(7, 1)

#define FDCAN_IR_RF0N FIELD(0, 1)
#define FDCAN_IR_RF0L FIELD(2, 1)
#define FDCAN_IR_TFE FIELD(9, 1)
#define FDCAN_IE_RF0NE FIELD(0, 1)
#define FDCAN_IE_TFEE FIELD(9, 1)
#define FDCAN_ILE_EINT0 FIELD(0, 1)

#define FDCAN_RXGFC_RRFE FIELD(0, 1)
#define FDCAN_RXGFC_RRFS FIELD(1, 1)
#define FDCAN_RXGFC_ANFE FIELD(2, 2)
#define FDCAN_RXGFC_ANFS FIELD(4, 2)
#define FDCAN_RXGFC_LSS FIELD(16, 5)
enum { FDCAN_NON_MATCHING_REJECTED = 2 };

#define FDCAN_XIDAM_RESET 0x1FFFFFFFu

#define FDCAN_RXF0S_F0FL FIELD(0, 4)
#define FDCAN_RXF0S_F0GI FIELD(8, 2)
#define FDCAN_RXF0S_RF0L FIELD(25, 1)
#define FDCAN_RXF0A_F0AI FIELD(0, 3)

#define FDCAN_TXFQS_RESET 0x00000003u
#define FDCAN_TXFQS_TFFL FIELD(0, 3)
#define FDCAN_TXFQS_TFQPI FIELD(16, 2)

/* --- message RAM --- */

enum { FDCAN_STANDARD_FILTERS = 28, FDCAN_EXTENDED_FILTERS = 8, FDCAN_FIFO_ELEMENTS = 3, FDCAN_ELEMENT_WORDS = 18 };

typedef struct {
  volatile uint32_t identifier;
  volatile uint32_t control;
  volatile uint32_t data[FDCAN_ELEMENT_WORDS - 2];
} fdcan_element;

typedef struct {
  volatile uint32_t standard_filter[FDCAN_STANDARD_FILTERS];
  volatile uint32_t extended_filter[FDCAN_EXTENDED_FILTERS][2];
  fdcan_element receive_fifo_0[FDCAN_FIFO_ELEMENTS];
  fdcan_element receive_fifo_1[FDCAN_FIFO_ELEMENTS];
  volatile uint32_t transmit_event[FDCAN_FIFO_ELEMENTS][2];
  fdcan_element transmit[FDCAN_FIFO_ELEMENTS];
} fdcan_message_ram;
REGISTER_AT(fdcan_message_ram, extended_filter, 0x70);
REGISTER_AT(fdcan_message_ram, receive_fifo_0, 0xB0);
REGISTER_AT(fdcan_message_ram, receive_fifo_1, 0x188);
REGISTER_AT(fdcan_message_ram, transmit_event, 0x260);
REGISTER_AT(fdcan_message_ram, transmit, 0x278);
_Static_assert(sizeof(fdcan_message_ram) == 0x350, "RM0440: the part of one FDCAN");

#define FDCAN1_RAM ((fdcan_message_ram *)0x4000A400u)

/* First word of an element: a standard identifier stands in the upper 11 of the 29 bits. */
#define ELEMENT_EXTENDED_ID FIELD(0, 29)
#define ELEMENT_STANDARD_ID FIELD(18, 11)
#define ELEMENT_REMOTE FIELD(29, 1)
#define ELEMENT_EXTENDED FIELD(30, 1)
/* Second word. */
#define ELEMENT_TIMESTAMP FIELD(0, 16) /* of its start */
#define ELEMENT_LENGTH FIELD(16, 4)

/* A standard filter: identifiers from ID1 to ID2. */
#define STANDARD_FILTER_ID2 FIELD(0, 11)
#define STANDARD_FILTER_ID1 FIELD(16, 11)
#define STANDARD_FILTER_SFEC FIELD(27, 3)
#define STANDARD_FILTER_SFT FIELD(30, 2)
enum { FILTER_TYPE_RANGE = 0, FILTER_TO_FIFO_0 = 1 };

#endif
