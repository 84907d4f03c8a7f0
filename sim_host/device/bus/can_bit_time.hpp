// SPDX-License-Identifier: Apache-2.0
// How long a frame occupies the bus, to the bit.
//
// ISO 11898-1: the bits from start of frame to the end of the CRC are stuffed after five equal ones; CRC delimiter,
// acknowledge, end of frame and intermission (13 bits) are not. Used for bus load and for pacing the VirtualBus.
#ifndef TRACKSERVO_SIM_BUS_CAN_BIT_TIME_HPP
#define TRACKSERVO_SIM_BUS_CAN_BIT_TIME_HPP

extern "C" {
#include "base/can_frame.h"
}

namespace trackservo::sim {

int can_frame_bits(const can_frame& frame);

}  // namespace trackservo::sim

#endif
