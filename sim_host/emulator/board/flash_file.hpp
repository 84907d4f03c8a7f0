// SPDX-License-Identifier: Apache-2.0
// The parameter pages of the emulated board in a file of the format of `sim_host serve --flash`.
#ifndef TRACKSERVO_SIM_EMULATOR_BOARD_FLASH_FILE_HPP
#define TRACKSERVO_SIM_EMULATOR_BOARD_FLASH_FILE_HPP

#include "chip/stm32g474.hpp"
#include "device/flash_memory.hpp"

namespace trackservo::target {

// Programs the chip's parameter pages with what the file holds. Call before the image starts.
void load_parameter_pages(Stm32g474& chip, const sim::FlashMemory& file);

// Writes them to the file. Throws std::runtime_error if it cannot be written.
void keep_parameter_pages(Stm32g474& chip, const sim::FlashMemory& file);

}  // namespace trackservo::target

#endif
