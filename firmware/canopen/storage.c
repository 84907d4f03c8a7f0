#include "canopen/storage.h"

od_abort storage_command(const storage_callbacks *callbacks, bool saving, uint8_t group, uint32_t value) {
  if (value != (saving ? STORAGE_SAVE : STORAGE_LOAD)) {
    return OD_NOT_TRANSFERRED;
  }
  od_abort (*action)(void *, uint8_t) = saving ? callbacks->save : callbacks->restore;
  return action == NULL ? OD_HARDWARE : action(callbacks->context, group);
}
