/* SPDX-License-Identifier: Apache-2.0 */
/* The object dictionary by its contract: a search finds any of two objects, which a harness makes arbitrary, or none.
 */
#ifndef TRACKSERVO_TESTS_PROOFS_ANY_DICTIONARY_H
#define TRACKSERVO_TESTS_PROOFS_ANY_DICTIONARY_H

#include "canopen/object_dictionary.h"
#include "proof.h"

static od_part part;
static od_entry one;
static od_entry other;

od_abort od_find(const object_dictionary *dictionary, uint16_t index, uint8_t sub, od_object *object) {
  (void)dictionary;
  (void)index;
  (void)sub;
  if (any_bool()) {
    return OD_NO_OBJECT;
  }
  object->part = &part;
  object->entry = any_bool() ? &one : &other;
  return OD_OK;
}

#endif
