// SPDX-License-Identifier: Apache-2.0
// Descriptions of a device, printed from its object dictionary: one table, several formats.
//
// EDS by CiA 306-1 v1.4 for masters, parameters.json for tools, DBC for bus monitors, a page for people. The EDS has no
// REAL32 limits and defaults: its readers disagree about them, as they do about units.
#ifndef TRACKSERVO_DICTIONARY_DEVICE_DESCRIPTION_HPP
#define TRACKSERVO_DICTIONARY_DEVICE_DESCRIPTION_HPP

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

extern "C" {
#include "canopen/object_dictionary.h"
#include "parameters/axis_dictionary.h"
#include "parameters/axis_parameters.h"
#include "protection/axis_protection.h"
#include "servo/servo_app.h"
}

namespace trackservo::dictionary {

// Data that are not in the table.
struct DeviceInfo {
  std::string file_name;
  std::string vendor;
  std::string product;
  std::string description;
  std::string date = "01-01-2026";  // constant, so that the same table gives the same file
  std::string time = "12:00AM";
};

// All entries of all parts by (index, sub-index) as on the bus.
using SortedObjects = std::map<std::pair<std::uint16_t, std::uint8_t>, od_object>;
SortedObjects sorted_objects(const object_dictionary& dictionary);

// Returns the name with the part's prefix.
std::string full_name(const od_object& object);

// Returns "const", "ro", "wo" or "rw".
const char *access_name(const od_entry& entry);

bool is_signed(const od_entry& entry);

std::string print_eds(const object_dictionary& dictionary, const DeviceInfo& info);

// Returns the default PDOs of a node with this id as messages and signals in SI units, for tools that read DBC files.
// Torques are scaled with the default of 6076. Throws std::runtime_error when a name is too long for the format.
std::string print_dbc(const object_dictionary& dictionary, const DeviceInfo& info, std::uint8_t node_id);

// Returns the page docs/can-objects.md: a table per group of objects.
std::string print_can_reference(const object_dictionary& dictionary, const DeviceInfo& info);

// Returns a value as JSON; a REAL32 as the shortest decimal that is this float.
nlohmann::ordered_json json_number(const od_entry& entry, od_number value);

// Returns every entry with type, access, unit, limits, default, mapping and help text; empty texts and false flags are
// left out.
nlohmann::ordered_json describe_parameters(const object_dictionary& dictionary, const DeviceInfo& info);

// Returns JSON with one line per element of each array, so that a change of one object changes one line. `document` is
// an object.
std::string print_by_rows(const nlohmann::ordered_json& document);

// Returns the defaults that the list of parameters gives: what a design starts from.
axis_parameters listed_defaults();

// Returns the file firmware/products/brushed_tracker/default_parameters.c: what a board starts with.
std::string print_default_parameters(const std::array<axis_parameters, SERVO_AXES>& parameters,
                                     const std::array<protection_limits, SERVO_AXES>& limits);

// Returns the header with DEFAULT_SCHEMA_HASH, for the image's version block.
std::string print_default_schema(std::uint32_t schema_hash);

}  // namespace trackservo::dictionary

#endif
