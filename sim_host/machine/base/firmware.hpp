// SPDX-License-Identifier: Apache-2.0
// The firmware's public headers, as C++ sees them: the simulator links the very same core as the board.
#ifndef TRACKSERVO_SIM_BASE_FIRMWARE_HPP
#define TRACKSERVO_SIM_BASE_FIRMWARE_HPP

extern "C" {
#include "hal_host.h"
#include "servo/servo_board.h"
}

#endif
