/* SPDX-License-Identifier: Apache-2.0 */
/* Node id and bit rate: what a node needs before it can take part in a bus, and which defaults depend on them.
 *
 * COB-IDs contain the node id ($NODEID in the EDS). The default inhibit times of the TPDOs are those of 1 Mbit/s times
 * 1000 / (kbit/s), so that event-driven TPDOs take the same share of the bus at every bit rate. */
#ifndef TRACKSERVO_CANOPEN_BUS_SETTINGS_H
#define TRACKSERVO_CANOPEN_BUS_SETTINGS_H

#include "canopen/object_dictionary.h"

enum {
  BUS_UNCONFIGURED = 255, /* node id of a node that processes only LSS */
  BUS_LAST_NODE_ID = 127,
  BUS_DEFAULT_NODE_ID = 1,
  BUS_DEFAULT_KBIT_S = 1000
};

typedef struct {
  uint8_t node_id; /* 1 .. 127, or BUS_UNCONFIGURED */
  uint16_t kbit_s; /* 1000, 500, 250 or 125 */
} bus_settings;

static inline bool bus_settings_are_same(const bus_settings *one, const bus_settings *other) {
  return one->node_id == other->node_id && one->kbit_s == other->kbit_s;
}

bool bus_node_id_is_good(uint8_t node_id);

/* Returns the bit rate of an index of CiA 305's standard table (0: 1000, 2: 500, 3: 250, 4: 125 kbit/s), or 0 if it is
 * not supported. */
uint16_t bus_kbit_s_of_index(uint8_t index);

/* Returns the index of a bit rate in that table, or that of an unsupported entry for an unsupported bit rate. */
uint8_t bus_index_of_kbit_s(uint16_t kbit_s);

/* Moves values that have the defaults for `from` to the defaults for `to`: COB-IDs with the node id, inhibit times of
 * TPDOs with the bit rate. Other values stay as they are. `values` is the struct of the table's values; both node ids
 * are 1 .. 127. */
void bus_defaults_follow(const od_table *table, void *values, const bus_settings *from, const bus_settings *to);

#endif
