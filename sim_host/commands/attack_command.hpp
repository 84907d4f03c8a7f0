// SPDX-License-Identifier: Apache-2.0
// The command that attacks the drive with legal writes.
#ifndef TRACKSERVO_SIM_COMMANDS_ATTACK_COMMAND_HPP
#define TRACKSERVO_SIM_COMMANDS_ATTACK_COMMAND_HPP

#include <CLI/CLI.hpp>

namespace trackservo::sim {

// Adds the subcommand attack; `code` becomes the program's exit code: 1 when a run did harm.
void add_attack(CLI::App& app, int& code);

}  // namespace trackservo::sim

#endif
