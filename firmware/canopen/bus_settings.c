/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/bus_settings.h"

#include "canopen/cob_id.h"
#include "canopen/pdo.h"

enum { FIRST_TPDO = 0x1800, SUB_INHIBIT = 3 };

/* CiA 305, standard table of bit rates; 0: this node does not support it. */
static const uint16_t kbit_s_of_index[] = {1000, 0, 500, 250, 125};

enum { BIT_RATES = sizeof kbit_s_of_index / sizeof kbit_s_of_index[0] };

bool bus_node_id_is_good(uint8_t node_id) {
  return (node_id >= 1 && node_id <= BUS_LAST_NODE_ID) || node_id == BUS_UNCONFIGURED;
}

uint16_t bus_kbit_s_of_index(uint8_t index) { return index < BIT_RATES ? kbit_s_of_index[index] : 0; }

uint8_t bus_index_of_kbit_s(uint16_t kbit_s) {
  uint8_t index = 0;
  /* Bound: BIT_RATES. */
  while (index < BIT_RATES && kbit_s_of_index[index] != kbit_s) {
    index++;
  }
  return index;
}

static uint32_t default_identifier(const od_entry *entry, uint8_t node_id) {
  return ((uint32_t)entry->preset.i + node_id) & COB_ID_IDENTIFIER;
}

static void follow_node_id(const od_entry *entry, uint8_t *place, uint8_t from, uint8_t to) {
  uint32_t cob_id = 0;
  memcpy(&cob_id, place, sizeof cob_id);
  if ((cob_id & COB_ID_IDENTIFIER) == default_identifier(entry, from)) {
    cob_id = (cob_id & ~COB_ID_IDENTIFIER) | default_identifier(entry, to);
    memcpy(place, &cob_id, sizeof cob_id);
  }
}

static uint16_t default_inhibit(const od_entry *entry, uint16_t kbit_s) {
  return (uint16_t)((uint32_t)entry->preset.i * BUS_DEFAULT_KBIT_S / kbit_s);
}

static void follow_bit_rate(const od_entry *entry, uint8_t *place, uint16_t from, uint16_t to) {
  uint16_t inhibit_100us = 0;
  memcpy(&inhibit_100us, place, sizeof inhibit_100us);
  if (inhibit_100us == default_inhibit(entry, from)) {
    inhibit_100us = default_inhibit(entry, to);
    memcpy(place, &inhibit_100us, sizeof inhibit_100us);
  }
}

static bool is_inhibit_time(const od_entry *entry) {
  return entry->index >= FIRST_TPDO && entry->index < FIRST_TPDO + TPDO_COUNT && entry->sub == SUB_INHIBIT;
}

void bus_defaults_follow(const od_table *table, void *values, const bus_settings *from, const bus_settings *to) {
  /* Bound: rows of a table, which is constant. */
  for (uint32_t i = 0; i < table->count; i++) {
    const od_entry *entry = &table->entries[i];
    uint8_t *place = (uint8_t *)values + entry->offset;
    if (entry->offset == OD_NO_VALUE) {
      continue;
    }
    if ((entry->flags & OD_NODE_ID) != 0 && entry->type == OD_UNSIGNED32) {
      follow_node_id(entry, place, from->node_id, to->node_id);
    } else if (is_inhibit_time(entry)) {
      follow_bit_rate(entry, place, from->kbit_s, to->kbit_s);
    }
  }
}
