/* SPDX-License-Identifier: Apache-2.0 */
/* A number that shows whether two devices have the same dictionary: index, sub-index, type, access, limits and default
 * of every object, in order; not the texts, which a board does not have. Tools compare it with the number in
 * parameters.json instead of version strings. */
#ifndef TRACKSERVO_NODE_SCHEMA_HASH_H
#define TRACKSERVO_NODE_SCHEMA_HASH_H

#include "canopen/object_dictionary.h"

/* Returns the CRC-32 (IEEE 802.3) of the schema. Takes about 50 us per 100 objects on a board: for the start, not for
 * the tick. */
uint32_t schema_hash(const object_dictionary *dictionary);

#endif
