// SPDX-License-Identifier: Apache-2.0
#include "device_description.hpp"

namespace trackservo::dictionary {

SortedObjects sorted_objects(const object_dictionary& dictionary) {
  SortedObjects objects;
  for (std::uint32_t i = 0; i < dictionary.count; ++i) {
    const od_part& part = dictionary.parts[i];
    for (std::uint32_t row = 0; row < part.table.count; ++row) {
      const od_object object{&part, &part.table.entries[row]};
      objects.emplace(std::pair(od_index(&object), object.entry->sub), object);
    }
  }
  return objects;
}

std::string full_name(const od_object& object) { return std::string(object.part->prefix) + object.entry->name; }

const char *access_name(const od_entry& entry) {
  constexpr const char *kNames[] = {"const", "ro", "wo", "rw"};
  return kNames[entry.access & 3];
}

bool is_signed(const od_entry& entry) {
  return entry.type == OD_INTEGER8 || entry.type == OD_INTEGER16 || entry.type == OD_INTEGER32;
}

}  // namespace trackservo::dictionary
