// result.json of `identify fit`, as far as gains are designed from it.
#ifndef TRACKSERVO_GAIN_DESIGN_IDENTIFIED_PLANT_JSON_HPP
#define TRACKSERVO_GAIN_DESIGN_IDENTIFIED_PLANT_JSON_HPP

#include "gain_design/identified_plant.hpp"
#include "gain_design/input_file.hpp"

namespace trackservo::gain_design {

// Throws InputFileError; where a parameter was refused by the identification the message says which run is missing.
IdentifiedPlant read_identified_plant(const InputFile& file);

}  // namespace trackservo::gain_design

#endif
