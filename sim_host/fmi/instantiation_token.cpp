// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "machine/base/checksum.hpp"
#include "unit_description.hpp"

namespace trackservo::fmi {

std::string instantiation_token(const Unit& unit) {
  std::string names;
  for (const Variable& variable : unit.variables()) {
    names += fmt::format("{} {} {}\n", variable.name, static_cast<int>(variable.causality), variable.value.index());
  }
  return std::string(unit_kind().name) + "-" TRACKSERVO_VERSION "-" + sim::checksum_of(names);
}

}  // namespace trackservo::fmi
