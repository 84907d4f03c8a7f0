// SPDX-License-Identifier: Apache-2.0
// sim_host check: does the firmware still meet its limits on this plant? Exit code 0: met, 1: not met, 2: wrong input.
//
// The same command serves sim_host, whose device is the firmware compiled into it, and emulate_board, whose device is
// the emulated board with an image on it; sim_host passes --image on to emulate_board.
#ifndef TRACKSERVO_SIM_COMMANDS_CHECK_COMMAND_HPP
#define TRACKSERVO_SIM_COMMANDS_CHECK_COMMAND_HPP

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "check/checked_device.hpp"

namespace trackservo::sim {

// Devices that run an image of the board. Throws std::runtime_error when it cannot be read.
using ImageDevices = std::function<DeviceMaker(const std::filesystem::path& image)>;

// Adds the subcommand check; `arguments` are those of this program, to pass them on; without `image_devices`, --image
// does so.
void add_check(CLI::App& app, int& code, const std::vector<std::string>& arguments, const ImageDevices& image_devices);

// Adds the subcommand gains, which writes the gains that the design computes for a plant as a gains file.
void add_gains(CLI::App& app);

}  // namespace trackservo::sim

#endif
