// SPDX-License-Identifier: Apache-2.0
// The modelDescription.xml of a unit, from its variables.
#ifndef TRACKSERVO_FMI_UNIT_DESCRIPTION_HPP
#define TRACKSERVO_FMI_UNIT_DESCRIPTION_HPP

#include <string>

#include "unit.hpp"

namespace trackservo::fmi {

constexpr unsigned kTimeReference = 0;
constexpr unsigned kFirstReference = 1;  // of the unit's first variable

// Returns what belongs to one version of the unit with these variables, in modelDescription.xml and library alike.
std::string instantiation_token(const Unit& unit);

// Returns the text of modelDescription.xml.
std::string model_description(const Unit& unit);

}  // namespace trackservo::fmi

#endif
