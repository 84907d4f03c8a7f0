// SPDX-License-Identifier: Apache-2.0
// result.json of `identify fit`, as far as the gain design needs it.
#ifndef TRACKSERVO_GAIN_DESIGN_IDENTIFIED_PLANT_JSON_HPP
#define TRACKSERVO_GAIN_DESIGN_IDENTIFIED_PLANT_JSON_HPP

#include "gain_design/identified_plant.hpp"
#include "gain_design/input_file.hpp"

namespace trackservo::gain_design {

// Throws InputFileError; if the identification refused a parameter, the message names the missing run.
IdentifiedPlant read_identified_plant(const InputFile& file);

}  // namespace trackservo::gain_design

#endif
