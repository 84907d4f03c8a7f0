// The result of an identification as JSON and its residuals as CSV; docs/identification.md describes both.
#ifndef TRACKSERVO_IDENTIFICATION_RESULT_JSON_HPP
#define TRACKSERVO_IDENTIFICATION_RESULT_JSON_HPP

#include <nlohmann/json.hpp>
#include <ostream>

#include "identification/identification.hpp"

namespace trackservo::identification {

// `structure`: chirps that were recorded to find resonances in. Without them the recording itself is searched, which
// shows those that its own chirps reach.
nlohmann::ordered_json to_json(const Identification& result, const Recording& recording,
                               const Recording& structure = {});

// One row per node that was used.
void write_residuals(std::ostream& out, const Identification& result, const Recording& recording);

}  // namespace trackservo::identification

#endif
