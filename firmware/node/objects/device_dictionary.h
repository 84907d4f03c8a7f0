/* SPDX-License-Identifier: Apache-2.0 */
/* What distinguishes this device from other CANopen nodes: identity and default PDOs.
 *
 * CiA 301 clause 7.5.2.1 (1000), .9 to .11 (1008 to 100A), .23 (1018), CiA 402-2 clause 5 (PDO usage). The offsets
 * point into `communication_objects`. Each axis has a command PDO and a state PDO of its own, so the tools of two
 * masters, one per axis, never overwrite each other. */
#ifndef TRACKSERVO_NODE_OBJECTS_DEVICE_DICTIONARY_H
#define TRACKSERVO_NODE_OBJECTS_DEVICE_DICTIONARY_H

#include "canopen/object_dictionary.h"

extern const od_table device_table;

#endif
