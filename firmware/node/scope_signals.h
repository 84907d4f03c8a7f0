/* SPDX-License-Identifier: Apache-2.0 */
/* The signals that the scope can record, by number: their place in the node, and their name on the bus. */
#ifndef TRACKSERVO_NODE_SCOPE_SIGNALS_H
#define TRACKSERVO_NODE_SCOPE_SIGNALS_H

#include "canopen/object_dictionary.h"
#include "commissioning/scope.h"

/* Both axes have the same signals: 1 .. 12 of azimuth, 13 .. 24 of pitch. */
enum { SCOPE_SIGNALS_PER_AXIS = 12, SCOPE_SIGNALS = 24 };

/* Object 0x3002: sub-index n is the name of signal n, with its unit at the end ("azimuth.torque_nm"). */
extern const od_table scope_signals_table;

/* Returns the offset in `servo_node` of signal 1 .. SCOPE_SIGNALS; all are floats. */
uint32_t scope_signal_offset(uint32_t signal);

#endif
