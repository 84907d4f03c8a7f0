/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/pdo.h"

#include "canopen/cob_id.h"

enum { SUB_COB_ID = 1, SUB_TYPE = 2, SUB_INHIBIT = 3, SUB_SYNC_START = 6 };

static od_abort accept_cob_id(uint32_t now, uint32_t value) {
  if (!cob_id_is_allowed(value)) {
    /* While switched off, any identifier may be set, since clients write 0x80000000. */
    return cob_id_is_valid(value) || (value & COB_ID_EXTENDED) != 0 ? OD_BAD_VALUE : OD_OK;
  }
  const bool stays_on = cob_id_is_valid(now) && cob_id_is_valid(value);
  const bool same = (now & COB_ID_IDENTIFIER) == (value & COB_ID_IDENTIFIER);
  return stays_on && !same ? OD_DEVICE_STATE : OD_OK;
}

od_abort pdo_accept_communication(const pdo_communication *communication, uint8_t sub, od_number value) {
  const bool on = cob_id_is_valid(communication->cob_id);
  switch (sub) {
    case SUB_COB_ID:
      return accept_cob_id(communication->cob_id, (uint32_t)value.i);
    case SUB_TYPE:
      /* 241..251 are reserved; 252 and 253 need remote requests, which this node does not support. */
      return value.i > PDO_SYNC_MAX && value.i < PDO_EVENT_MAKER ? OD_BAD_VALUE : OD_OK;
    case SUB_INHIBIT:
    case SUB_SYNC_START:
      return on ? OD_DEVICE_STATE : OD_OK;
    default:
      return OD_OK;
  }
}

od_abort pdo_accept_mapping(const object_dictionary *dictionary, pdo_direction direction,
                            const pdo_communication *communication, const pdo_mapping *mapping, uint8_t sub,
                            od_number value) {
  if (cob_id_is_valid(communication->cob_id)) {
    return OD_DEVICE_STATE;
  }
  if (sub == 0) {
    pdo_mapping wanted = *mapping;
    pdo_map map;
    wanted.count = (uint8_t)value.i;
    return pdo_resolve(dictionary, direction, &wanted, &map);
  }
  return mapping->count != 0 ? OD_DEVICE_STATE : pdo_check_entry(dictionary, direction, (uint32_t)value.i);
}
