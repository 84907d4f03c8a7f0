// SPDX-License-Identifier: Apache-2.0
#include "machine/run/start_firmware.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "dictionary/refusal_text.hpp"

namespace trackservo::sim {

void start_servo(servo_board& board, hal& machine, const servo_params& params) {
  if (servo_board_start(&board, &machine, &params) != CONTROL_OK) {
    throw std::invalid_argument("the firmware refuses the parameters: " + dictionary::refusal_of(params).value_or("") +
                                ".");
  }
}

void start_node(servo_node& node, const servo_node_config& config) {
  if (!servo_node_start(&node, &config)) {
    std::array<axis_parameters, SERVO_AXES> parameters{};
    std::array<protection_limits, SERVO_AXES> limits{};
    std::copy_n(config.parameters, SERVO_AXES, parameters.begin());
    std::copy_n(config.limits, SERVO_AXES, limits.begin());
    throw std::runtime_error("the node did not start: " + dictionary::refusal_of(parameters, limits) + ".");
  }
}

}  // namespace trackservo::sim
