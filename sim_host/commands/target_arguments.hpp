// SPDX-License-Identifier: Apache-2.0
// The options of a command that serves a machine with a target in front of it.
#ifndef TRACKSERVO_SIM_COMMANDS_TARGET_ARGUMENTS_HPP
#define TRACKSERVO_SIM_COMMANDS_TARGET_ARGUMENTS_HPP

#include <CLI/CLI.hpp>
#include <filesystem>

#include "device/serve/served_target.hpp"
#include "machine/config/plant_config.hpp"
#include "output_files.hpp"

namespace trackservo::sim {

struct TargetArguments {
  std::filesystem::path scenario;  // empty: no target
  TargetOptions options;
};

// Adds --target, --camera-id, --video, --truth and --overwrite.
void add_target(CLI::App& command, OutputFiles& outputs, TargetArguments& arguments);

// Returns the options with the scenario of --target. Throws like load_scenario, also for a scenario without a target or
// a course that the machine cannot follow; warns of what is unusual.
TargetOptions load_target(const TargetArguments& arguments, const PlantConfig& plant);

// Prints a line to the standard output: where the target waits, and what shows it. For a machine of which only the bus
// is seen, prints one to the standard error: how it is known that an axis tracks. Prints none without a target.
void print_start(const TargetOptions& target, bool sees_only_the_bus);

}  // namespace trackservo::sim

#endif
