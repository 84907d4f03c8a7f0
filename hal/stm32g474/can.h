/* CAN: FDCAN1, classic frames, 1 Mbit/s, sample point 88 %.
 *
 * Received are the frames of canopen/heard_frames.h; the hardware drops the rest, extended and remote frames among
 * them. */
#ifndef TRACKSERVO_STM32G474_CAN_H
#define TRACKSERVO_STM32G474_CAN_H

#include <stdbool.h>
#include <stdint.h>

#include "canopen/can_frame.h"

typedef enum { CAN_GOOD = 0, CAN_ERROR_PASSIVE, CAN_BUS_OFF } can_state;

/* False: the controller does not answer. */
bool can_start(void);

void can_enable_interrupt(void);

/* False: three frames wait already. From the tick only. */
bool can_send(const can_frame *frame);

/* Takes the oldest frame; false: there is none. From the receive interrupt only. */
bool can_receive(can_frame *frame);

void can_acknowledge_interrupt(void);

/* State of the bus; ends a bus-off after BUS_OFF_WAIT_TICKS. Once per tick. */
can_state can_supervise(void);

/* Frames that were lost because three waited in the hardware already. */
uint32_t can_lost_frames(void);

#endif
