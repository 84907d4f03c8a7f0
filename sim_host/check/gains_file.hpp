// SPDX-License-Identifier: Apache-2.0
// A gains file: TOML, as `servoctl save` writes it and `servoctl restore` sends it to a device.
//
// Every name and value is checked against the firmware's own object dictionary; the table [device] is not read. The
// gains reach a device as a client would send them: staged, applied in one piece, limits written directly.
#ifndef TRACKSERVO_SIM_CHECK_GAINS_FILE_HPP
#define TRACKSERVO_SIM_CHECK_GAINS_FILE_HPP

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "check/checked_device.hpp"
#include "machine/config/source_lines.hpp"

namespace trackservo::sim {

struct Gain {
  std::string name;  // "azimuth.speed_loop.proportional_gain"
  std::uint16_t index;
  std::uint8_t sub;
  int bytes;
  std::uint32_t bits;  // as on the bus
};

struct Gains {
  std::filesystem::path file;  // empty: the start gains of a device
  SourceLines lines;
  std::vector<Gain> values;
};

// Throws ConfigError with file, line and remedy. The plant is that of the check.
Gains read_gains(const std::filesystem::path& file, const PlantConfig& plant);

// Throws ConfigError at the line of a value that the device refuses, std::runtime_error when it refuses the whole set.
void apply_gains(CheckedDevice& device, const Gains& gains);

// Writes the gains that the design computes for this plant, with its limits, as a gains file. Throws ConfigError,
// std::runtime_error.
void write_designed_gains(const PlantConfig& plant, const std::filesystem::path& file);

}  // namespace trackservo::sim

#endif
