/* SPDX-License-Identifier: Apache-2.0 */
/* CAN: FDCAN1, classic frames, 125 kbit/s to 1 Mbit/s, sample point 88 %.
 *
 * The hardware drops frames that can_accept does not name, and extended and remote frames. */
#ifndef TRACKSERVO_STM32G4_CAN_H
#define TRACKSERVO_STM32G4_CAN_H

#include <stdbool.h>
#include <stdint.h>

#include "base/can_frame.h"

/* About the number of frames that the bus carries in a tick: a node that sends a TPDO in every tick on each of its
 * channels still has room for its heartbeat and its SDO answers. A power of two. */
enum { CAN_SEND_FRAMES = 8 };

typedef enum { CAN_GOOD = 0, CAN_ERROR_PASSIVE, CAN_BUS_OFF } can_state;

/* Sets the identifiers to receive. Call before can_start; `ranges` must stay valid. Ranges beyond HAL_CAN_RANGES, the
 * number of filters in the hardware, are not used. */
void can_accept(const can_id_range *ranges, uint32_t count);

/* Starts the controller at 1000, 500, 250 or 125 kbit/s. Call it again for another bit rate: frames that wait to be
 * sent or read are lost then. Returns false when the controller does not answer. */
bool can_start(uint16_t kbit_s);

void can_enable_interrupt(void);

/* Sends frames in the order of the calls. Returns false when CAN_SEND_FRAMES already wait behind the three in the
 * hardware. From the deferred task only. */
bool can_send(const can_frame *frame);

/* Passes waiting frames to the hardware, which has sent its own. From the interrupt only. */
void can_send_waiting(void);

/* Takes the oldest frame; returns false when there is none. The controller has counted the bits since its start: its
 * time does not depend on when this is called. From the interrupt only. */
bool can_receive(can_frame *frame);

void can_acknowledge_interrupt(void);

/* Returns the state of the bus; ends a bus-off after BUS_OFF_WAIT_TICKS. Call it once per tick. */
can_state can_supervise(void);

/* Returns the number of interrupts since power-up that found a frame lost because three already waited in the hardware.
 * */
uint32_t can_lost_frames(void);

#endif
