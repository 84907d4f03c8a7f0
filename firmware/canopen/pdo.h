/* SPDX-License-Identifier: Apache-2.0 */
/* PDO parameters: the communication record of each PDO, and the rules for changing it and its mapping.
 *
 * Standard: CiA 301 v4.2.0, clauses 7.5.2.35 to 7.5.2.38: switch the PDO off (bit 31 of its COB-ID), set the number
 * of mapped objects to 0, write the entries, set the number, switch the PDO on. Any other order is refused. */
#ifndef TRACKSERVO_CANOPEN_PDO_H
#define TRACKSERVO_CANOPEN_PDO_H

#include "canopen/pdo_map.h"

enum {
  RPDO_COUNT = 4,
  TPDO_COUNT = 8, /* TPDO5 to 8 are off by default: for a client beside the master */
  PDO_SYNC_ACYCLIC = 0,
  PDO_SYNC_MAX = 240,
  PDO_EVENT_MAKER = 254,
  PDO_EVENT_PROFILE = 255
};

/* Values of 0x1400 and 0x1800. */
typedef struct {
  uint32_t cob_id;        /* sub 1: bit 31 off, bit 30 no remote request, bits 0..10 identifier */
  uint8_t type;           /* sub 2: transmission type, 0..240 with SYNC, 254 and 255 by event */
  uint16_t inhibit_100us; /* sub 3, TPDO: minimum time between two */
  uint16_t event_ms;      /* sub 5: TPDO: maximum time between two; RPDO: maximum silence; 0: none */
  uint8_t sync_start;     /* sub 6, TPDO: SYNC counter value to start with; 0: any */
} pdo_communication;

static inline bool pdo_is_synchronous(const pdo_communication *communication) {
  return communication->type <= PDO_SYNC_MAX;
}

/* Returns whether sub-index `sub` of the communication record may be set to `value`. */
od_abort pdo_accept_communication(const pdo_communication *communication, uint8_t sub, od_number value);

/* Returns whether sub-index `sub` of the mapping record may be set to `value`. */
od_abort pdo_accept_mapping(const object_dictionary *dictionary, pdo_direction direction,
                            const pdo_communication *communication, const pdo_mapping *mapping, uint8_t sub,
                            od_number value);

#endif
