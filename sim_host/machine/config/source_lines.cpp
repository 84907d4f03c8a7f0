// SPDX-License-Identifier: Apache-2.0
#include "machine/config/source_lines.hpp"

#include <fmt/format.h>

namespace trackservo::sim {

std::string SourceLines::place(const std::string& dotted_key) const {
  std::string name = dotted_key;
  while (!name.empty() && lines_.count(name) == 0) {
    const std::size_t dot = name.rfind('.');
    name.resize(dot == std::string::npos ? 0 : dot);
  }
  return fmt::format("{}:{}", file_, name.empty() ? 1 : lines_.at(name));
}

ConfigError SourceLines::error(const std::string& dotted_key, const std::string& reason,
                               const std::string& remedy) const {
  return ConfigError(fmt::format("{}: {}: {}, {}", place(dotted_key), dotted_key, reason, remedy));
}

}  // namespace trackservo::sim
