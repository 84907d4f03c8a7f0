// SPDX-License-Identifier: Apache-2.0
// The names of parameters in a gains file: "azimuth.speed_loop.proportional_gain".
//
// Derived from the names in the object table by the rules of servoctl (tools/servoctl/servoctl/objects/schema.py); a
// test compares the two over all objects.
#ifndef TRACKSERVO_DICTIONARY_PARAMETER_NAMES_HPP
#define TRACKSERVO_DICTIONARY_PARAMETER_NAMES_HPP

#include <map>
#include <string>

#include "device_description.hpp"

namespace trackservo::dictionary {

// Returns the contents of a gains file: objects of an axis that are stored and writable, by name.
std::map<std::string, od_object> tunable_parameters(const object_dictionary& dictionary);

}  // namespace trackservo::dictionary

#endif
