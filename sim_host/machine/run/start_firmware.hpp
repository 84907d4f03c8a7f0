// SPDX-License-Identifier: Apache-2.0
// Starts the firmware on a simulated machine: the whole node, or its servo alone. No other file of a program for the
// host starts one.
#ifndef TRACKSERVO_SIM_RUN_START_FIRMWARE_HPP
#define TRACKSERVO_SIM_RUN_START_FIRMWARE_HPP

#include "machine/base/firmware.hpp"

extern "C" {
#include "node/servo_node.h"
}

namespace trackservo::sim {

// Starts the servo of a board, without drive, protection and node. Throws std::invalid_argument with what it refuses.
void start_servo(servo_board& board, hal& machine, const servo_params& params);

// Starts the node in an empty memory. Throws std::runtime_error with what it refuses.
void start_node(servo_node& node, const servo_node_config& config);

}  // namespace trackservo::sim

#endif
