// SPDX-License-Identifier: Apache-2.0
#include "machine/config/toml_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "text_file.hpp"

namespace trackservo::sim {

namespace {

std::string joined(const std::string& path, const std::string& key) { return path.empty() ? key : path + "." + key; }

std::string type_text(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::string:
      return "text";
    case toml::node_type::integer:
      return "an integer";
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

// Minimum number of letters to insert, remove or change (Levenshtein).
std::size_t edits_between(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) {
    row[j] = j;
  }
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0U : 1U);
      diagonal = row[j];
      row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

std::string text_of(const std::filesystem::path& path) {
  try {
    return read_text(path);
  } catch (const TextFileError& error) {
    throw ConfigError(fmt::format("{}:{}: file: {}", path.string(), error.line(), error.what()));
  }
}

// Tables within tables, by a name with many dots: the parser makes one of the other, as deep as they go.
void refuse_deep_names(const std::string& file, std::string_view text) {
  constexpr int kMostDots = 1000;
  int line = 1;
  int dots = 0;
  bool in_name = true;
  for (const char letter : text) {
    if (letter == '\n') {
      ++line;
      dots = 0;
      in_name = true;
    }
    in_name = in_name && letter != '=' && letter != '#';
    dots += in_name && letter == '.' ? 1 : 0;
    if (dots > kMostDots) {
      throw ConfigError(fmt::format("{}:{}: syntax: a name of more than {} parts", file, line, kMostDots));
    }
  }
}

}  // namespace

TomlReader::TomlReader(const std::filesystem::path& path) : TomlReader(path.string(), text_of(path)) {}

TomlReader::TomlReader(std::string name, std::string_view text) : file_(std::move(name)), lines_(file_) {
  refuse_deep_names(file_, text);
  try {
    root_ = toml::parse(text, file_);
  } catch (const toml::parse_error& error) {
    throw ConfigError(
        fmt::format("{}:{}: syntax: {}, see https://toml.io", file_, error.source().begin.line, error.description()));
  }
  note_lines();
}

// Elements of arrays of tables are named by children().
void TomlReader::note_lines() {
  std::vector<TomlTable> waiting{root()};
  const auto note = [&](const toml::node& node, const std::string& name) {
    lines_.add(name, std::max(static_cast<int>(node.source().begin.line), 1));
    if (const toml::table *table = node.as_table()) {
      waiting.push_back({table, name});
    }
  };
  while (!waiting.empty()) {
    const TomlTable table = waiting.back();
    waiting.pop_back();
    for (const auto& [key, node] : *table.table) {
      const std::string name = joined(table.path, std::string(key.str()));
      note(node, name);
      const toml::array *array = node.as_array();
      for (std::size_t i = 0; array != nullptr && i < array->size(); ++i) {
        note((*array)[i], fmt::format("{}[{}]", name, i));
      }
    }
  }
}

void TomlReader::fail(const TomlTable& table, const std::string& key, const std::string& reason,
                      const std::string& remedy) const {
  throw lines_.error(joined(table.path, key), reason, remedy);
}

TomlTable TomlReader::child(const TomlTable& parent, const std::string& name) const {
  const std::optional<TomlTable> found = child_if_present(parent, name);
  if (!found) {
    fail(parent, name, "is missing", fmt::format("add a table [{}]", joined(parent.path, name)));
  }
  return *found;
}

std::optional<TomlTable> TomlReader::child_if_present(const TomlTable& parent, const std::string& name) const {
  const toml::node *node = parent.table->get(name);
  if (node == nullptr) {
    return std::nullopt;
  }
  if (!node->is_table()) {
    fail(parent, name, fmt::format("is {}", type_text(*node)),
         fmt::format("give a table [{}]", joined(parent.path, name)));
  }
  return TomlTable{node->as_table(), joined(parent.path, name)};
}

std::vector<TomlTable> TomlReader::children(const TomlTable& parent, const std::string& name) const {
  std::vector<TomlTable> tables;
  const toml::node *node = parent.table->get(name);
  if (node == nullptr) {
    return tables;
  }
  const toml::array *array = node->as_array();
  if (array == nullptr ||
      !std::all_of(array->begin(), array->end(), [](const toml::node& n) { return n.is_table(); })) {
    fail(parent, name, "is not an array of tables", fmt::format("write [[{}]]", joined(parent.path, name)));
  }
  for (const toml::node& element : *array) {
    tables.push_back({element.as_table(), fmt::format("{}[{}]", joined(parent.path, name), tables.size())});
  }
  return tables;
}

void TomlReader::refuse_unknown(const TomlTable& table, const std::vector<std::string>& known) const {
  for (const auto& [key, node] : *table.table) {
    const std::string name(key.str());
    if (std::find(known.begin(), known.end(), name) != known.end()) {
      continue;
    }
    std::string nearest;
    std::size_t least = std::numeric_limits<std::size_t>::max();
    for (const std::string& candidate : known) {
      const std::size_t edits = edits_between(name, candidate);
      if (edits < least) {
        least = edits;
        nearest = candidate;
      }
    }
    const bool close = least <= std::max<std::size_t>(2, name.size() / 3);
    fail(table, name, "is not a known key", close ? fmt::format("did you mean {}?", nearest) : "remove it");
  }
}

std::optional<Value> TomlReader::value(const TomlTable& table, const KeyText& key) const {
  const toml::node *node = table.table->get(key.name);
  if (node == nullptr) {
    if (!key.optional) {
      fail(table, key.name, "is missing", fmt::format("give {}", allowed_text(key)));
    }
    if (!key.fallback) {
      return std::nullopt;
    }
    const bool whole = key.type == KeyType::kInteger || key.type == KeyType::kChoice;
    return whole ? Value(static_cast<int>(*key.fallback)) : Value(*key.fallback * key.unit.in_si);
  }
  switch (key.type) {
    case KeyType::kInteger:
      if (!node->is_integer()) {
        fail(table, key.name, fmt::format("is {}", type_text(*node)), fmt::format("give {}", allowed_text(key)));
      }
      return static_cast<int>(checked_number(table, key, *node));
    case KeyType::kText:
      return checked_text(table, key, *node);
    case KeyType::kChoice:
      return checked_choice(table, key, *node);
    case KeyType::kList:
    case KeyType::kThreeNumbers:
      return checked_list(table, key, *node);
    default:
      return key.unit.in_si * checked_number(table, key, *node);
  }
}

double TomlReader::checked_number(const TomlTable& table, const KeyText& key, const toml::node& node) const {
  if (!node.is_number()) {
    fail(table, key.name, fmt::format("is {}", type_text(node)), fmt::format("give {}", allowed_text(key)));
  }
  const double value = *node.value<double>();
  if (!std::isfinite(value)) {
    fail(table, key.name, fmt::format("is {}", value), fmt::format("give a finite one, {}", allowed_text(key)));
  }
  if (value < key.range.least || value > key.range.most) {
    fail(table, key.name, fmt::format("{:g} is out of range", value), fmt::format("give {}", allowed_text(key)));
  }
  return value;
}

std::string TomlReader::checked_text(const TomlTable& table, const KeyText& key, const toml::node& node) const {
  if (!node.is_string()) {
    fail(table, key.name, fmt::format("is {}", type_text(node)), "give text in quotes");
  }
  std::string text = *node.value<std::string>();
  if (text.empty()) {
    fail(table, key.name, "is empty", "give a non-empty text");
  }
  return text;
}

int TomlReader::checked_choice(const TomlTable& table, const KeyText& key, const toml::node& node) const {
  const std::string text = checked_text(table, key, node);
  const auto found = std::find(key.choices.begin(), key.choices.end(), text);
  if (found == key.choices.end()) {
    fail(table, key.name, fmt::format("\"{}\" is not known", text), fmt::format("give {}", allowed_text(key)));
  }
  return static_cast<int>(found - key.choices.begin());
}

std::vector<double> TomlReader::checked_list(const TomlTable& table, const KeyText& key, const toml::node& node) const {
  const toml::array *array = node.as_array();
  if (array == nullptr || array->empty()) {
    fail(table, key.name, array == nullptr ? fmt::format("is {}", type_text(node)) : "is empty",
         fmt::format("give {} in brackets", allowed_text(key)));
  }
  if (key.type == KeyType::kThreeNumbers && array->size() != 3) {
    fail(table, key.name, fmt::format("has {} elements", array->size()), fmt::format("give {}", allowed_text(key)));
  }
  std::vector<double> values;
  for (const toml::node& element : *array) {
    values.push_back(key.unit.in_si * checked_number(table, key, element));
  }
  return values;
}

}  // namespace trackservo::sim
