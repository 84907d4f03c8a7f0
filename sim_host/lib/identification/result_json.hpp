// SPDX-License-Identifier: Apache-2.0
// The result of an identification as JSON and its residuals as CSV; docs/identification.md describes both.
#ifndef TRACKSERVO_IDENTIFICATION_RESULT_JSON_HPP
#define TRACKSERVO_IDENTIFICATION_RESULT_JSON_HPP

#include <nlohmann/json.hpp>
#include <ostream>

#include "identification/identification.hpp"

namespace trackservo::identification {

// Returns the result as JSON. `structure`: chirps recorded to find resonances. Without them the recording itself is
// searched, which shows the resonances that its own chirps excite.
nlohmann::ordered_json to_json(const Identification& result, const Recording& recording,
                               const Recording& structure = {});

// Writes one row per used node.
void write_residuals(std::ostream& out, const Identification& result, const Recording& recording);

}  // namespace trackservo::identification

#endif
