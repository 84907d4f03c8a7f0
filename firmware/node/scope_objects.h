/* SPDX-License-Identifier: Apache-2.0 */
/* The scope on the bus: 0x3000 sets it up and arms it, 0x3001 is the capture as a DOMAIN.
 *
 * Set-up objects are plain values; the command "arm" checks them together and refuses a set-up that does not fit with
 * 0604
 * 0043. */
#ifndef TRACKSERVO_NODE_SCOPE_OBJECTS_H
#define TRACKSERVO_NODE_SCOPE_OBJECTS_H

#include "canopen/object_dictionary.h"
#include "commissioning/scope.h"

typedef struct {
  uint8_t command;
  uint8_t state; /* scope_phase */
  uint16_t divider;
  uint16_t pretrigger;
  uint8_t trigger;
  uint8_t trigger_channel;
  float trigger_level;
  uint32_t frames;
  uint8_t channels;
  uint8_t signal[SCOPE_CHANNELS]; /* numbers of 0x3002 */
} scope_objects;

extern const od_table scope_objects_table;

/* The owner of the part is the servo_node. */
extern const od_hooks scope_objects_hooks;

#endif
