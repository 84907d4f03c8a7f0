/* CAN: FDCAN1, classic frames, 125 kbit/s to 1 Mbit/s, sample point 88 %.
 *
 * Received are the frames of canopen/heard_frames.h; the hardware drops the rest, extended and remote frames among
 * them. */
#ifndef TRACKSERVO_STM32G474_CAN_H
#define TRACKSERVO_STM32G474_CAN_H

#include <stdbool.h>
#include <stdint.h>

#include "base/can_frame.h"

/* About what the bus carries in a tick: a node that sends a TPDO in every tick on each of its channels still has room
 * for its heartbeat and its SDO answers. A power of two. */
enum { CAN_SEND_FRAMES = 8 };

typedef enum { CAN_GOOD = 0, CAN_ERROR_PASSIVE, CAN_BUS_OFF } can_state;

/* kbit_s: 1000, 500, 250 or 125. Also again, for another bit rate: frames that wait to be sent or taken are lost then.
 * False: the controller does not answer. */
bool can_start(uint16_t kbit_s);

void can_enable_interrupt(void);

/* Frames go out in the order of their calls. False: CAN_SEND_FRAMES wait already behind the three in the hardware. From
 * the service only. */
bool can_send(const can_frame *frame);

/* Gives frames that wait to the hardware, which has sent its own. From the interrupt only. */
void can_send_waiting(void);

/* Takes the oldest frame; false: there is none. From the interrupt only. */
bool can_receive(can_frame *frame);

void can_acknowledge_interrupt(void);

/* State of the bus; ends a bus-off after BUS_OFF_WAIT_TICKS. Once per tick. */
can_state can_supervise(void);

/* Frames that were lost because three waited in the hardware already. */
uint32_t can_lost_frames(void);

#endif
