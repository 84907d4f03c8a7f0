/* SPDX-License-Identifier: Apache-2.0 */
/* Printed by the build from the node's dictionary: do not edit it, `tools/update-docs dictionary` renews it. */
#ifndef TRACKSERVO_PRODUCTS_BRUSHED_TRACKER_DEFAULT_SCHEMA_H
#define TRACKSERVO_PRODUCTS_BRUSHED_TRACKER_DEFAULT_SCHEMA_H

/* Object 3030:2, see node/schema_hash.h. */
#define DEFAULT_SCHEMA_HASH 0x699F9E75u

#endif
