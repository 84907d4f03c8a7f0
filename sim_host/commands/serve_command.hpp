// SPDX-License-Identifier: Apache-2.0
// sim_host serve: a device as a CANopen node on a bus for clients, until SIGINT or SIGTERM comes.
//
// The same command serves sim_host, whose device is the firmware compiled into it, and emulate_board, whose device is
// the emulated board with an image on it; sim_host passes --image on to emulate_board.
#ifndef TRACKSERVO_SIM_COMMANDS_SERVE_COMMAND_HPP
#define TRACKSERVO_SIM_COMMANDS_SERVE_COMMAND_HPP

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "device/serve/server.hpp"
#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

// What is flashed, and what the board lacks.
struct BoardOptions {
  std::filesystem::path image;
  std::vector<std::string> missing;         // sensors that are not connected, of kSensors
  std::vector<std::uint32_t> option_bytes;  // OPTR and WRP1AR, or none: what tools/image/board sets
};

constexpr const char *kSensors[] = {"azimuth-encoder", "azimuth-gyro", "pitch-encoder", "pitch-gyro"};

// Serves a board with an image; returns the exit code.
using ServeBoard = std::function<int(const BoardOptions& board, const PlantConfig& plant, const ServeOptions& options,
                                     const ServeReports& reports)>;

// Adds the subcommand serve; `arguments` are those of this program, to pass them on; without `serve_board`, --image
// does so.
void add_serve(CLI::App& app, int& code, const std::vector<std::string>& arguments, const ServeBoard& serve_board);

}  // namespace trackservo::sim

#endif
