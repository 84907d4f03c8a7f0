// SPDX-License-Identifier: Apache-2.0
// design.json: the designed parameters and their predicted effect; docs/gain-design.md describes it.
#ifndef TRACKSERVO_GAIN_DESIGN_DESIGN_JSON_HPP
#define TRACKSERVO_GAIN_DESIGN_DESIGN_JSON_HPP

#include <nlohmann/json.hpp>

#include "gain_design/gain_design.hpp"

namespace trackservo::gain_design {

// Returns the contents of design.json. `before`: the parameters of the device.
nlohmann::ordered_json to_json(const GainDesign& design, const axis_parameters& before);

}  // namespace trackservo::gain_design

#endif
