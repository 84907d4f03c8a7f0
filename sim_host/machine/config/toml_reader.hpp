// SPDX-License-Identifier: Apache-2.0
// Reads a TOML file key by key by the key tables, and refuses errors with file, line, key, reason and remedy.
//
// Types are strict (a number may be written as an integer), numbers must be finite and within the key's range, every
// key must be known, and every key without a default must be there. All errors are ConfigError.
//
// Use: TomlReader reader(path); reader.read(reader.root(), keys, owner); reader.refuse_unknown(reader.root(), {...}).
#ifndef TRACKSERVO_SIM_CONFIG_TOML_READER_HPP
#define TRACKSERVO_SIM_CONFIG_TOML_READER_HPP

#include <toml++/toml.h>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "machine/base/key.hpp"
#include "machine/config/config_error.hpp"
#include "machine/config/source_lines.hpp"

namespace trackservo::sim {

// A table of the file with its dotted name ("" for the root).
struct TomlTable {
  const toml::table *table;
  std::string path;
};

class TomlReader {
 public:
  // Parses the file. Throws ConfigError when it cannot be read or is not TOML.
  explicit TomlReader(const std::filesystem::path& path);

  // Parses a text; `name` replaces the file in error messages.
  TomlReader(std::string name, std::string_view text);

  TomlTable root() const { return {&root_, ""}; }

  // Returns a sub-table that must exist / may exist; all tables of an array of tables (none: empty).
  TomlTable child(const TomlTable& parent, const std::string& name) const;
  std::optional<TomlTable> child_if_present(const TomlTable& parent, const std::string& name) const;
  std::vector<TomlTable> children(const TomlTable& parent, const std::string& name) const;

  // Reads every key of the table of keys into the owner.
  template <class Owner>
  void read(const TomlTable& table, const Keys<Owner>& keys, Owner& owner) const {
    for (const Key<Owner>& key : keys) {
      if (const std::optional<Value> found = value(table, key.text)) {
        key.set(owner, *found);
      }
    }
  }

  // Refuses the first key of the table that is not among the known ones.
  void refuse_unknown(const TomlTable& table, const std::vector<std::string>& known) const;

  template <class Owner>
  void refuse_unknown(const TomlTable& table, const Keys<Owner>& keys, std::vector<std::string> more = {}) const {
    for (const Key<Owner>& key : keys) {
      more.push_back(key.text.name);
    }
    refuse_unknown(table, more);
  }

  // Returns the lines of all keys and tables of the file.
  const SourceLines& lines() const { return lines_; }

  // Throws ConfigError at the line of the key (of its table, if the key is absent).
  [[noreturn]] void fail(const TomlTable& table, const std::string& key, const std::string& reason,
                         const std::string& remedy) const;

 private:
  // Returns the key's checked value or its default; nothing when it is absent and optional.
  std::optional<Value> value(const TomlTable& table, const KeyText& key) const;
  double checked_number(const TomlTable& table, const KeyText& key, const toml::node& node) const;
  std::string checked_text(const TomlTable& table, const KeyText& key, const toml::node& node) const;
  int checked_choice(const TomlTable& table, const KeyText& key, const toml::node& node) const;
  std::vector<double> checked_list(const TomlTable& table, const KeyText& key, const toml::node& node) const;

  void note_lines();

  std::string file_;
  toml::table root_;
  SourceLines lines_;
};

}  // namespace trackservo::sim

#endif
