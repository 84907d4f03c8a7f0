/* SPDX-License-Identifier: Apache-2.0 */
/* The frames that a node hears: one table for the board, the simulator and the objects.
 *
 * Standard: CiA 301 v4.2.0, clause 7.3.5 and table 40 (identifiers that no object may have), CiA 305 (LSS). The board's
 * CAN controller has a filter for each row. The simulated node accepts what `heard_frame` passes. An object accepts a
 * COB-ID only if the table has it. So every identifier that can be set is heard. The table is the same for every node
 * id, so a change of the node id (LSS) does not change the filters. */
#ifndef TRACKSERVO_CANOPEN_HEARD_FRAMES_H
#define TRACKSERVO_CANOPEN_HEARD_FRAMES_H

#include "base/can_frame.h"

enum { HEARD_RANGES = 9, HEARD_LSS_REQUEST = 0x7E5 };

/* In rising order, without overlap. */
extern const can_id_range heard_ranges[HEARD_RANGES];

/* Returns whether a frame is a data frame whose 11-bit identifier is in the table. Extended and remote frames never
 * are. */
bool heard_frame(const can_frame *frame);

/* Returns whether an object may use this 11-bit identifier. */
bool heard_identifier_is_free(uint32_t identifier);

#endif
