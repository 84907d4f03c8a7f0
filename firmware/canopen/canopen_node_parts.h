/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the node on the bus share; other rooms use canopen_node.h.
 *
 *     canopen_node.c          state, reset, queues, the millisecond
 *     canopen_process_data.c  NMT, SYNC, RPDO: in the tick
 *     canopen_services.c      SDO, heartbeats of others, LSS: after it */
#ifndef TRACKSERVO_CANOPEN_CANOPEN_NODE_PARTS_H
#define TRACKSERVO_CANOPEN_CANOPEN_NODE_PARTS_H

#include "canopen/canopen_node.h"

/* Sends a frame, unless LSS keeps the node silent. Returns whether it was taken. */
bool canopen_send(const canopen_node *node, const can_frame *frame);

/* Enters an NMT state. */
void canopen_enter(canopen_node *node, nmt_state state);

/* Begins a reset; its steps follow, one per ms. */
void canopen_begin_reset(canopen_node *node, bool whole_node);

/* Raises or clears an EMCY of the communication itself. */
void canopen_raise_or_clear(canopen_node *node, uint16_t code, bool active);

/* Does what 0x1029:1 wants when the communication fails (clause 7.5.2.32). */
void canopen_obey_error_behaviour(canopen_node *node);

/* Returns the SDO channel whose requests have this identifier; SDO_CHANNELS: none. */
uint32_t canopen_sdo_channel_of(const canopen_node *node, const can_frame *frame);

bool canopen_is_heartbeat(const can_frame *frame);

/* --- process data --- */

/* Returns whether the frame has been used. While LSS changes the bit rate, only NMT is obeyed: the node could not
 * report what anything else has caused. */
bool canopen_receive_process_data(canopen_node *node, const can_frame *frame);

/* --- services --- */

void canopen_receive_service(canopen_node *node, const can_frame *frame);

/* Sends up to `limit` SDO frames. The channels take turns: a block upload on one channel leaves room for answers on the
 * other. */
void canopen_send_sdos(canopen_node *node, uint32_t limit);

void canopen_send_lss(canopen_node *node);

void canopen_tick_sdo(canopen_node *node);

/* Returns how many channels have a command that goes on from ms to ms. */
uint32_t canopen_sdo_commits(const canopen_node *node);

/* Reports that a heartbeat producer is lost. */
void canopen_lose_producer(canopen_node *node, uint8_t lost);

#endif
