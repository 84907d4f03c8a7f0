// SPDX-License-Identifier: Apache-2.0
// `identify design`: gains from result.json, requirements and the device's parameters.
#ifndef TRACKSERVO_SIM_COMMANDS_DESIGN_COMMAND_HPP
#define TRACKSERVO_SIM_COMMANDS_DESIGN_COMMAND_HPP

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

namespace trackservo::identification {

struct DesignCommand {
  std::string identified;
  std::string requirements;
  std::string parameters;
  std::filesystem::path json;
};

// Adds the subcommand design. Its options fill `options`, which must exist longer than `app`; the subcommand runs when
// it is given.
void add_design_command(CLI::App& app, DesignCommand& options);

}  // namespace trackservo::identification

#endif
