#include "node/kept_objects.h"

#include "canopen/storage.h"
#include "node/drive_dictionary.h"

void kept_objects_copy(kept_objects *to, const kept_objects *from, uint8_t group) {
  if (group == STORAGE_ALL || group == STORAGE_COMMUNICATION) {
    od_copy_stored(&communication_profile_table, &from->communication, &to->communication);
  }
  if (group == STORAGE_ALL || group == STORAGE_APPLICATION) {
    for (int i = 0; i < SERVO_AXES; ++i) {
      to->parameters[i] = from->parameters[i];
      od_copy_stored(&drive_objects_table, &from->drive[i], &to->drive[i]);
    }
  }
}
