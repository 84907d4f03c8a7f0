/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/storage.h"

od_abort storage_accept(bool saving, uint32_t value) {
  return value == (saving ? STORAGE_SAVE : STORAGE_LOAD) ? OD_OK : OD_NOT_TRANSFERRED;
}

od_abort storage_execute(const storage_callbacks *callbacks, bool saving, uint8_t group) {
  od_abort (*action)(void *, uint8_t) = saving ? callbacks->save : callbacks->restore;
  return action == NULL ? OD_HARDWARE : action(callbacks->context, group);
}
