/* Node id and bit rate of the servo's node: in force, stored, and what LSS wants of both. Objects 0x3050.
 *
 * The settings in force are the stored ones, from the log in flash, or those that the node was configured with. What
 * LSS stores counts from the next start on; it is independent of 0x1010 and 0x1011. */
#ifndef TRACKSERVO_NODE_OBJECTS_BUS_OBJECTS_H
#define TRACKSERVO_NODE_OBJECTS_BUS_OBJECTS_H

#include "canopen/lss_slave.h"
#include "parameters/bus_settings_log.h"

/* Takes part in the bus at this bit rate, from now on; false: the CAN controller does not answer. */
typedef struct {
  bool (*join)(void *context, uint16_t kbit_s);
  void *context;
} bus_joiner;

typedef struct {
  bus_settings in_force; /* 0x3050:1 and :2; of a node without node id: 255 */
  bus_settings stored;   /* 0x3050:3 and :4 */
  bus_joiner joiner;     /* .join NULL: there is nothing to do */
  bool join_failed;
  bool saving;
  bus_settings_log log;
} bus_objects;

/* `defaults` count where nothing is stored, and in place of what is stored where `recovering`. */
void bus_objects_start(bus_objects *bus, const bus_settings *defaults, bool recovering, const hal_flash *flash,
                       const bus_joiner *joiner);

/* The CAN controller has this bit rate from now on. */
void bus_objects_join(bus_objects *bus, uint16_t kbit_s);

/* What lss_callbacks.store answers. */
lss_store_progress bus_objects_store(bus_objects *bus, const bus_settings *settings);

#endif
