/* SPDX-License-Identifier: Apache-2.0 */
/* Node id and bit rate of the servo's node: in effect, stored, and requested by LSS. Objects 0x3050.
 *
 * The settings in effect are the stored ones, from the log in flash, or those that the node was configured with. What
 * LSS stores takes effect at the next start; it is independent of 0x1010 and 0x1011. */
#ifndef TRACKSERVO_NODE_OBJECTS_BUS_OBJECTS_H
#define TRACKSERVO_NODE_OBJECTS_BUS_OBJECTS_H

#include "canopen/lss_slave.h"
#include "parameters/bus_settings_log.h"

/* Joins the bus at this bit rate; returns false when the CAN controller does not answer. */
typedef struct {
  bool (*join)(void *context, uint16_t kbit_s);
  void *context;
} bus_joiner;

typedef struct {
  bus_settings in_force; /* 0x3050:1 and :2; of a node without node id: 255 */
  bus_settings stored;   /* 0x3050:3 and :4 */
  bus_joiner joiner;     /* .join NULL: nothing to do */
  bool join_failed;
  bool saving;
  bus_settings_log log;
} bus_objects;

/* Reads the stored settings. `defaults` apply where nothing is stored, and replace the stored settings when
 * `recovering`. */
void bus_objects_start(bus_objects *bus, const bus_settings *defaults, bool recovering, const hal_flash *flash,
                       const bus_joiner *joiner);

/* Notes that the CAN controller now has this bit rate. */
void bus_objects_join(bus_objects *bus, uint16_t kbit_s);

/* Returns the result for lss_callbacks.store. */
lss_store_progress bus_objects_store(bus_objects *bus, const bus_settings *settings);

#endif
