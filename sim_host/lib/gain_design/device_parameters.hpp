// SPDX-License-Identifier: Apache-2.0
// The parameters of one axis as files have them: value by "0xINDEX:SUB" of the object dictionary, azimuth's indices for
// both axes. Names, units, ranges and places in the struct are those of firmware/parameters/axis_parameter_list.h.
#ifndef TRACKSERVO_GAIN_DESIGN_DEVICE_PARAMETERS_HPP
#define TRACKSERVO_GAIN_DESIGN_DEVICE_PARAMETERS_HPP

#include <nlohmann/json.hpp>

#include "gain_design/firmware.hpp"
#include "gain_design/identified_plant.hpp"
#include "gain_design/input_file.hpp"

namespace trackservo::gain_design {

// Reads all of 0x2000 to 0x2055, which must be present; 0x2056 and sub-index 0 may be. Throws InputFileError.
axis_parameters read_device_parameters(const InputFile& file);

// Returns rows {index, sub, name, unit, before, value} of the results of a gain design: 0x2000 to 0x204F and the plant,
// 0x2056.
nlohmann::ordered_json parameter_rows(const axis_parameters& before, const axis_parameters& after);

// Returns rows {index, sub, name, unit, value} of an identified plant: 0x2056, against which the device checks gains.
nlohmann::ordered_json plant_rows(const IdentifiedPlant& plant);

}  // namespace trackservo::gain_design

#endif
