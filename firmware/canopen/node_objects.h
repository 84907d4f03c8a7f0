/* SPDX-License-Identifier: Apache-2.0 */
/* What happens when the bus reads or writes the node's own objects.
 *
 * Standard: CiA 301 v4.2.0, clause 7.5.2, the value definition of each object. These are the hooks of the two
 * dictionary parts of the node; canopen_node.c installs them. */
#ifndef TRACKSERVO_CANOPEN_NODE_OBJECTS_H
#define TRACKSERVO_CANOPEN_NODE_OBJECTS_H

#include "canopen/canopen_node.h"

/* The owner is the canopen_node. */
extern const od_hooks node_objects_hooks;

/* Puts the parameters of PDO n and of SYNC into effect after the objects have changed; the PDO restarts. */
void node_objects_configure_rpdo(canopen_node *node, uint32_t n);
void node_objects_configure_tpdo(canopen_node *node, uint32_t n);
void node_objects_configure_sync(canopen_node *node);
void node_objects_configure_sdo(canopen_node *node);

/* Updates what the receive interrupt accepts. Call after any of these and after a change of the monitored
 * heartbeats. */
void node_objects_listen(canopen_node *node);

/* Clears EMCY 8130 unless a monitored heartbeat is missing. */
void node_objects_judge_heartbeats(canopen_node *node);

/* Raises EMCY 8210 while the last frame of an RPDO was too short, 8250 while an RPDO is late, 8200 while a value in the
 * last frame of one was refused, and clears them afterwards. Each covers all RPDOs together. */
void node_objects_judge_rpdos(canopen_node *node);

/* Returns whether SYNC, an RPDO or the requests of 1201h share an identifier, so that one of them would receive
 * nothing. accept() prevents it, but default COB-IDs follow a new node id. */
bool node_objects_receivers_collide(const communication_objects *objects);

/* Returns whether stored values that pass their limits may be in effect together, by the rules that accept() applies to
 * each write. */
bool node_objects_are_good(const object_dictionary *dictionary, const communication_objects *objects);

#endif
