// SPDX-License-Identifier: Apache-2.0
// Positions of the keys of a configuration file, for errors that appear only when values are combined: a requirement
// that no controller can meet, a scenario that does not fit the plant.
//
// TomlReader::lines() makes it; PlantConfig and ScenarioConfig carry it. `throw plant.lines.error("design.pitch.
// observer_bandwidth_hz", "makes the loop unstable", "give at most 20");`
#ifndef TRACKSERVO_SIM_CONFIG_SOURCE_LINES_HPP
#define TRACKSERVO_SIM_CONFIG_SOURCE_LINES_HPP

#include <map>
#include <string>

#include "machine/config/config_error.hpp"

namespace trackservo::sim {

class SourceLines {
 public:
  SourceLines() = default;
  explicit SourceLines(std::string file) : file_(std::move(file)) {}

  void add(const std::string& dotted_key, int line) { lines_[dotted_key] = line; }

  const std::string& file() const { return file_; }

  // Returns "file:line", line of the key with this dotted name; of its table if the key is absent; 1 if that is absent
  // too.
  std::string place(const std::string& dotted_key) const;

  // Returns "file:line: key: reason, remedy"
  ConfigError error(const std::string& dotted_key, const std::string& reason, const std::string& remedy) const;

 private:
  std::string file_;
  std::map<std::string, int> lines_;
};

}  // namespace trackservo::sim

#endif
