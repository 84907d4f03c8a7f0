// SPDX-License-Identifier: Apache-2.0
// `sim_host faults` and `sim_host soak`.
#ifndef TRACKSERVO_SIM_COMMANDS_FAULT_COMMANDS_HPP
#define TRACKSERVO_SIM_COMMANDS_FAULT_COMMANDS_HPP

#include <CLI/CLI.hpp>

namespace trackservo::sim {

// Adds the subcommand; `code` becomes 1 when a requirement was violated, or a fault occurred without a reason.
void add_faults(CLI::App& app, int& code);
void add_soak(CLI::App& app, int& code);

}  // namespace trackservo::sim

#endif
