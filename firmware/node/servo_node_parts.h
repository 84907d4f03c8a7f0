/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the servo node share; other rooms use servo_node.h.
 *
 *     servo_node.c          the tick, and what follows it
 *     servo_node_hooks.c    what a write to an object of drive, board or clock asks and changes
 *     servo_node_storage.c  saves, loads, and says what was lost
 *     servo_node_reset.c    the application's part of a reset
 *     servo_node_start.c    puts everything together */
#ifndef TRACKSERVO_NODE_SERVO_NODE_PARTS_H
#define TRACKSERVO_NODE_SERVO_NODE_PARTS_H

#include "canopen/emergency.h"
#include "node/servo_node.h"

/* Of EMCY messages; the source of an axis is its number + 1. */
enum { SOURCE_BOARD = SERVO_AXES + 1, SOURCE_STORAGE = SERVO_AXES + 2 };

bool servo_node_any_axis_is_powered(const servo_node *node);

/* Returns the same, or whether an axis still turns since it had torque: protection may have to brake it. */
bool servo_node_any_axis_moves(const servo_node *node);

/* Gives both axes a fault in the next tick. */
void servo_node_command_fault(servo_node *node, fault_id fault);

/* Returns the EMCY of a row of the fault table. */
emergency_error servo_node_error_of(fault_id fault, uint8_t source, uint8_t detail);

void servo_node_raise_emergency(servo_node *node, fault_id fault, uint8_t source, uint8_t detail);

/* Owners: servo_node_axis, servo_node, servo_node. */
extern const od_hooks servo_node_drive_hooks;
extern const od_hooks servo_node_board_hooks;
extern const od_hooks servo_node_clock_hooks;

/* --- storage --- */

/* Details of FAULT_PARAMETERS_LOST, as a sum. */
enum { SET_DAMAGED = 1, SET_UNFINISHED = 2, SET_REFUSED = 4, COB_IDS_COLLIDE = 8, BUS_SETTINGS_IN_DOUBT = 16 };

/* Serve 0x1010 and 0x1011, see canopen_storage. */
od_abort servo_node_save(void *context, uint8_t group);
od_abort servo_node_restore(void *context, uint8_t group);

/* Stores the hash of the owner's word (0x3040). */
od_abort servo_node_store_word(void *context, uint64_t hash);

/* Puts the stored word in force, unless recovery has waived it. */
void servo_node_take_word(servo_node *node);

/* Loads what is stored. Call in the first reset, in which all objects have their defaults: 0x1011 restores these. */
void servo_node_start_storage(servo_node *node);

/* Puts what is stored in force: of an axis, and what both share. */
void servo_node_take_stored(servo_node *node, int i);
void servo_node_take_shared(servo_node *node, const persisted_objects *from);

/* Puts limits in force that have been checked. */
void servo_node_take_limits(servo_node_axis *axis, const protection_limits *limits);

/* Shows the result of loading or saving in 0x2070:5 and 0x3031, and by EMCY while what is damaged, cut off or refused
 * has not been replaced by a good save. */
void servo_node_report_stored(servo_node *node);

/* Returns the detail of FAULT_PARAMETERS_LOST; 0: what is stored was found. */
int servo_node_lost_parameters(const servo_node *node);

/* --- reset, called by the node on the bus (canopen_events) --- */

/* Switches off, at once. */
void servo_node_reset_begins(void *context, bool whole_node);

/* Makes one step of the reset, of about equal work. Returns true after the last one. */
bool servo_node_reset(void *context, bool whole_node, uint32_t step);

#endif
