// SPDX-License-Identifier: Apache-2.0
#include "parameter_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <vector>

namespace trackservo::dictionary {
namespace {

using Words = std::vector<std::string>;

Words words_of(const std::string& text) {
  Words words(1);
  for (const char letter : text) {
    const auto byte = static_cast<unsigned char>(letter);
    if (std::isalnum(byte) != 0) {
      words.back() += static_cast<char>(std::tolower(byte));
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  if (words.back().empty()) {
    words.pop_back();
  }
  return words;
}

std::string joined(const Words& words) { return fmt::format("{}", fmt::join(words, "_")); }

// Removes the axis from the words and returns it; empty when they begin with none.
std::string take_axis(Words& words) {
  if (words.size() < 2 || (words.front() != "azimuth" && words.front() != "pitch")) {
    return "";
  }
  std::string axis = words.front();
  words.erase(words.begin());
  return axis;
}

// Drops the longest run of leading words that are the beginning or the end of the head; at least one word stays.
Words without_head(const Words& entry, const Words& head) {
  for (std::size_t length = std::min(entry.size() - 1, head.size()); length > 0; --length) {
    const auto run_end = entry.begin() + static_cast<std::ptrdiff_t>(length);
    if (std::equal(entry.begin(), run_end, head.begin()) ||
        std::equal(entry.begin(), run_end, head.end() - static_cast<std::ptrdiff_t>(length))) {
      return {run_end, entry.end()};
    }
  }
  return entry;
}

std::string dotted_name(const od_object& object, const std::map<std::uint16_t, std::string>& heads) {
  Words entry = words_of(full_name(object));
  const std::string axis = take_axis(entry);
  const auto head = heads.find(od_index(&object));
  std::string name = joined(entry);
  if (head != heads.end() && head->second != full_name(object)) {
    Words head_words = words_of(head->second);
    take_axis(head_words);
    name = joined(head_words) + "." + joined(without_head(entry, head_words));
  } else if (object.entry->sub != 0) {
    name += fmt::format(".{}", object.entry->sub);
  }
  return axis.empty() ? name : axis + "." + name;
}

bool is_tunable(const od_object& object) {
  return (object.entry->flags & OD_STORED) != 0 && object.entry->access == OD_RW &&
         od_type_bytes(static_cast<od_type>(object.entry->type)) != 0;
}

}  // namespace

std::map<std::string, od_object> tunable_parameters(const object_dictionary& dictionary) {
  const SortedObjects objects = sorted_objects(dictionary);
  std::map<std::uint16_t, std::string> heads;
  for (const auto& [place, object] : objects) {
    if (place.second == 0) {
      heads[place.first] = full_name(object);
    }
  }
  std::map<std::string, int> seen;
  for (const auto& [place, object] : objects) {
    ++seen[dotted_name(object, heads)];
  }
  std::map<std::string, od_object> tunable;
  for (const auto& [place, object] : objects) {
    std::string name = dotted_name(object, heads);
    if (seen[name] > 1) {
      name += fmt::format("_{:04x}_{}", place.first, place.second);
    }
    const bool of_axis = name.rfind("azimuth.", 0) == 0 || name.rfind("pitch.", 0) == 0;
    if (of_axis && is_tunable(object)) {
      tunable.emplace(name, object);
    }
  }
  return tunable;
}

}  // namespace trackservo::dictionary
