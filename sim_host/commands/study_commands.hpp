// SPDX-License-Identifier: Apache-2.0
// The commands of sim_host that run many machines and write the results.
#ifndef TRACKSERVO_SIM_COMMANDS_STUDY_COMMANDS_HPP
#define TRACKSERVO_SIM_COMMANDS_STUDY_COMMANDS_HPP

#include <CLI/CLI.hpp>

namespace trackservo::sim {

void add_experiments(CLI::App& app);
void add_assumed_plants(CLI::App& app);
void add_random_plants(CLI::App& app);
void add_base_motion(CLI::App& app);
void add_node_tracking(CLI::App& app);

}  // namespace trackservo::sim

#endif
