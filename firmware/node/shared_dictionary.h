/* SPDX-License-Identifier: Apache-2.0 */
/* The rows of the objects that both axes share: timing (0x3010), version (0x3030) and stored parameters (0x3031).
 * Offsets point into `servo_node_objects`. */
#ifndef TRACKSERVO_NODE_SHARED_DICTIONARY_H
#define TRACKSERVO_NODE_SHARED_DICTIONARY_H

#include "canopen/object_dictionary.h"

extern const od_table shared_table;

#endif
