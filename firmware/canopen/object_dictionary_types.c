/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/object_dictionary.h"

uint16_t od_type_bytes(od_type type) {
  switch (type) {
    case OD_BOOLEAN:
    case OD_INTEGER8:
    case OD_UNSIGNED8:
      return 1;
    case OD_INTEGER16:
    case OD_UNSIGNED16:
      return 2;
    case OD_INTEGER32:
    case OD_UNSIGNED32:
    case OD_REAL32:
      return 4;
    case OD_UNSIGNED64:
      return 8;
    case OD_VISIBLE_STRING:
    case OD_DOMAIN:
      break;
  }
  return 0;
}
