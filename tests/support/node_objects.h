/* SPDX-License-Identifier: Apache-2.0 */
/* Reads and writes objects of a servo node in a test, as its SDO server does. Values travel as the low bytes of a word.
 */
#ifndef TRACKSERVO_TESTS_SUPPORT_NODE_OBJECTS_H
#define TRACKSERVO_TESTS_SUPPORT_NODE_OBJECTS_H

#include "node/servo_node.h"
#include "unity.h"

/* Fails the test when there is no such object. */
static inline od_object node_object(const servo_node *node, uint16_t index, uint8_t sub) {
  od_object object;
  TEST_ASSERT_EQUAL(OD_OK, od_find(servo_node_dictionary(node), index, sub, &object));
  return object;
}

static inline od_abort node_object_set(const servo_node *node, uint16_t index, uint8_t sub, uint32_t value) {
  const od_object object = node_object(node, index, sub);
  od_abort answer = od_write(&object, (const uint8_t *)&value, object.entry->bytes);
  while (answer == OD_PENDING && object.entry->index == 0x2070) { /* the check of the gains goes on with each call */
    answer = od_write(&object, (const uint8_t *)&value, object.entry->bytes);
  }
  return answer;
}

static inline uint32_t node_object_get(const servo_node *node, uint16_t index, uint8_t sub) {
  const od_object object = node_object(node, index, sub);
  uint32_t value = 0;
  uint16_t length = 0;
  TEST_ASSERT_EQUAL(OD_OK, od_read(&object, (uint8_t *)&value, sizeof value, &length));
  return value;
}

#endif
