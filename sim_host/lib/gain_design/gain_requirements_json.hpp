// SPDX-License-Identifier: Apache-2.0
// wishes.json: the requirements for the gains.
#ifndef TRACKSERVO_GAIN_DESIGN_GAIN_REQUIREMENTS_JSON_HPP
#define TRACKSERVO_GAIN_DESIGN_GAIN_REQUIREMENTS_JSON_HPP

#include "gain_design/gain_design.hpp"
#include "gain_design/input_file.hpp"

namespace trackservo::gain_design {

// Reads any of the keys in docs/gain-design.md. Throws InputFileError for an unknown key, another type, a value out of
// range.
GainRequirements read_gain_requirements(const InputFile& file);

}  // namespace trackservo::gain_design

#endif
