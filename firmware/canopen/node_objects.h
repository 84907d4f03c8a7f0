/* What happens when the bus reads or writes the node's own objects.
 *
 * Standard: CiA 301 v4.2.0, clause 7.5.2, the value definition of each object. These are the hooks of the two
 * dictionary parts that belong to the node; canopen_node.c installs them. */
#ifndef TRACKSERVO_CANOPEN_NODE_OBJECTS_H
#define TRACKSERVO_CANOPEN_NODE_OBJECTS_H

#include "canopen/canopen_node.h"

/* The owner is the canopen_node. */
extern const od_hooks node_objects_hooks;

/* Puts the parameters of PDO n and of SYNC in force, after the objects have changed; the PDO starts anew. */
void node_objects_configure_rpdo(canopen_node *node, uint32_t n);
void node_objects_configure_tpdo(canopen_node *node, uint32_t n);
void node_objects_configure_sync(canopen_node *node);
void node_objects_configure_sdo(canopen_node *node);

/* Both COB-IDs of SDO channel `channel` (0: 0x1200) are valid. */
bool node_objects_sdo_is_on(const communication_objects *objects, uint32_t channel);

/* After any of these, and after a change of the heartbeats to be watched: tells the receive interrupt what to take. */
void node_objects_listen(canopen_node *node);

/* EMCY 8130 while a watched heartbeat is missing. */
void node_objects_judge_heartbeats(canopen_node *node);

/* Whether values that pass their limits, out of a store, may be in force together: what accept() asks of each write. */
bool node_objects_are_good(const object_dictionary *dictionary, const communication_objects *objects);

#endif
