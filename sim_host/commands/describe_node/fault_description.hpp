// SPDX-License-Identifier: Apache-2.0
// Descriptions of the faults, printed from the firmware's fault table and its texts: for servoctl, and for people.
#ifndef TRACKSERVO_SIM_COMMANDS_DESCRIBE_NODE_FAULT_DESCRIPTION_HPP
#define TRACKSERVO_SIM_COMMANDS_DESCRIBE_NODE_FAULT_DESCRIPTION_HPP

#include <nlohmann/json.hpp>
#include <string>

extern "C" {
#include "protection/fault_table.h"
}

namespace trackservo::dictionary {

// Returns "tell", "stop", "brake" or "cut".
std::string reaction_name(const fault_row& row);

// Returns the file faults.json: every fault by its number, and the columns of a fault log entry.
nlohmann::ordered_json describe_faults();

// Returns the page docs/faults.md.
std::string print_fault_page();

}  // namespace trackservo::dictionary

#endif
