// SPDX-License-Identifier: Apache-2.0
// Devices for `check --image`: the image of the board on the emulated board, driven over CAN alone, as a master would.
#ifndef TRACKSERVO_SIM_EMULATOR_CHECKED_BOARD_HPP
#define TRACKSERVO_SIM_EMULATOR_CHECKED_BOARD_HPP

#include <filesystem>

#include "check/device.hpp"

namespace trackservo::target {

// Throws std::runtime_error when the image cannot be read.
sim::DeviceMaker checked_boards(const std::filesystem::path& image);

}  // namespace trackservo::target

#endif
