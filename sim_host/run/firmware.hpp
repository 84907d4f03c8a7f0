// The firmware's public headers, as C++ sees them: the simulator links the very same core as the board.
#ifndef TRACKSERVO_SIM_RUN_FIRMWARE_HPP
#define TRACKSERVO_SIM_RUN_FIRMWARE_HPP

extern "C" {
#include "app/servo_board.h"
#include "hal_host.h"
}

#endif
