// SPDX-License-Identifier: Apache-2.0
#include "machine/base/key.hpp"

#include <fmt/format.h>

#include "markdown.hpp"

namespace trackservo::sim {

namespace {

const char *type_text(KeyType type) {
  switch (type) {
    case KeyType::kInteger:
      return "integer";
    case KeyType::kList:
      return "list of numbers";
    case KeyType::kThreeNumbers:
      return "3 numbers";
    default:
      return "number";
  }
}

std::string default_text(const KeyText& key) {
  if (key.fallback && key.type == KeyType::kChoice) {
    return fmt::format("\"{}\"", key.choices.at(static_cast<std::size_t>(*key.fallback)));
  }
  if (key.fallback) {
    return fmt::format("{:g}", *key.fallback);
  }
  return key.optional ? "absent" : "required";
}

}  // namespace

std::string allowed_text(const KeyText& key) {
  if (key.type == KeyType::kText) {
    return "non-empty text";
  }
  if (key.type == KeyType::kChoice) {
    std::string text = "one of";
    for (const std::string& name : key.choices) {
      text += fmt::format(" \"{}\"", name);
    }
    return text;
  }
  return fmt::format("{} from {:g} to {:g}{}", type_text(key.type), key.range.least, key.range.most,
                     std::string(key.unit.text) == "-" ? "" : fmt::format(" {}", key.unit.text));
}

std::string sections_markdown(const std::string& title, const std::string& opening,
                              const std::vector<Section>& sections) {
  std::vector<std::string> headings;
  headings.reserve(sections.size());
  for (const Section& section : sections) {
    headings.push_back(section.heading);
  }
  std::string page = fmt::format("# {}\n\n{}\n\n{}", title, opening, contents_of(headings, "`"));
  for (const Section& section : sections) {
    page += fmt::format("\n## {}\n\n{}| key | unit | allowed | default | meaning |\n|---|---|---|---|---|\n",
                        section.heading, section.note.empty() ? "" : section.note + "\n\n");
    for (const KeyText& key : section.keys) {
      page += fmt::format("| `{}` | {} | {} | {} | {} |\n", key.name, key.unit.text, allowed_text(key),
                          default_text(key), key.meaning);
    }
  }
  return page;
}

}  // namespace trackservo::sim
