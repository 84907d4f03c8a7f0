/* SPDX-License-Identifier: Apache-2.0 */
/* Checks an object dictionary, row by row.
 *
 * Standard: the rules are CiA 301's (types, mapping) and those that object_dictionary.h states for tables. The tests
 * run it on every dictionary that ships; a node may run it at its start. */
#ifndef TRACKSERVO_CANOPEN_OBJECT_DICTIONARY_CHECK_H
#define TRACKSERVO_CANOPEN_OBJECT_DICTIONARY_CHECK_H

#include "canopen/object_dictionary.h"

typedef enum {
  OD_TABLE_GOOD = 0,
  OD_TABLE_UNSORTED,     /* not above the previous row: wrong order or duplicate */
  OD_TABLE_NO_HEAD,      /* first row of an object is not sub-index 0, or sub-indices follow a simple variable */
  OD_TABLE_HEAD_TOO_LOW, /* a sub-index above the number in the head */
  OD_TABLE_BAD_TYPE,     /* not an od_type, or a size that does not match the type */
  OD_TABLE_BAD_LIMITS,   /* low above high, not finite, or outside the type */
  OD_TABLE_BAD_DEFAULT,  /* default outside the limits, or text longer than its room */
  OD_TABLE_BAD_MAPPING,  /* a type that cannot be mapped, or a mapping direction that the access forbids */
  OD_TABLE_NO_TEXT,      /* name, unit or help missing */
  OD_TABLE_OVERLAP,      /* an index that another part also has */
  OD_TABLE_NOT_STORABLE  /* OD_STORED on a value that cannot be written back */
} od_table_fault;

typedef struct {
  od_table_fault fault;
  uint16_t index; /* place in the table (index not shifted); 0 when there is no error */
  uint8_t sub;
} od_table_verdict;

/* Checks one table. */
od_table_verdict od_check_table(const od_table *table);

/* Checks all parts, and that no object is in two of them. */
od_table_verdict od_check_dictionary(const object_dictionary *dictionary);

#endif
