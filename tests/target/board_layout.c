/* SPDX-License-Identifier: Apache-2.0 */
/* Where the image keeps what board_recording.hpp reads: compiled for the chip, because only its compiler knows. */
#include <stddef.h>

#include "machine.h"
#include "node/servo_node.h"
#include "servo/servo_board.h"

/* In the order of bench::Layout. */
const uint32_t board_layout[] = {
    sizeof(struct hal),
    offsetof(struct hal, tasks.context),
    offsetof(struct hal, period),
    offsetof(struct hal, service_under_way),
    offsetof(struct hal, current_a),
    offsetof(struct hal, bus_voltage_v),
    offsetof(struct hal, samples),
    sizeof(hal_axis_samples),
    offsetof(servo_board, motor),
    sizeof(motor_stage),
    offsetof(motor_stage, state.voltage_v),
    offsetof(servo_node, objects), /* servo, gains, limits, drives and protection come before */
};
