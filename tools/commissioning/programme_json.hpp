// A programme as the file that servoctl carries out. Keys are the fields of object 2100, in its units; what a kind of
// experiment does not use is left out.
#ifndef TRACKSERVO_COMMISSIONING_PROGRAMME_JSON_HPP
#define TRACKSERVO_COMMISSIONING_PROGRAMME_JSON_HPP

#include <nlohmann/json.hpp>

#include "commissioning/programme.hpp"

namespace trackservo::commissioning {

// `start_rad`: where the axis is, for the predicted duration.
nlohmann::ordered_json to_json(const Programme& programme, double start_rad);

}  // namespace trackservo::commissioning

#endif
