// SPDX-License-Identifier: Apache-2.0
// The program with the emulated board in it: emulate_board, which has the commands `check` and `serve` as sim_host has.
#ifndef TRACKSERVO_SIM_COMMANDS_BOARD_PROGRAM_HPP
#define TRACKSERVO_SIM_COMMANDS_BOARD_PROGRAM_HPP

#include <string>
#include <vector>

namespace trackservo::sim {

// Replaces this process by emulate_board with the same arguments, for the option --image: sim_host is not linked with
// the emulator. Throws std::invalid_argument when the program is not built.
[[noreturn]] void hand_over_to_board(const std::vector<std::string>& arguments);

}  // namespace trackservo::sim

#endif
