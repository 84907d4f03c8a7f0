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

}  // namespace trackservo::dictionary
