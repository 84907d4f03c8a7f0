/* What makes this device different from other CANopen nodes: identity and default PDOs.
 *
 * CiA 301 clause 7.5.2.1 (1000), .9 to .11 (1008 to 100A), .23 (1018), CiA 402-2 clause 5 (PDO usage). The offsets
 * point into `communication_objects`. Each axis has a command and a state PDO of its own, so that two masters' tools,
 * one per axis, never write over each other. */
#ifndef TRACKSERVO_NODE_OBJECTS_DEVICE_DICTIONARY_H
#define TRACKSERVO_NODE_OBJECTS_DEVICE_DICTIONARY_H

#include "canopen/object_dictionary.h"

extern const od_table device_table;

#endif
