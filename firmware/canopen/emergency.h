/* SPDX-License-Identifier: Apache-2.0 */
/* Emergency messages: active errors, error history, and the messages that report both.
 *
 * Standard: CiA 301 v4.2.0, clause 7.2.7, objects 0x1001 (error register), 0x1003 (history), 0x1014 (COB-ID) and
 * 0x1015 (inhibit time). The owner of an error may raise it in every tick: it is reported once, until it is cleared. */
#ifndef TRACKSERVO_CANOPEN_EMERGENCY_H
#define TRACKSERVO_CANOPEN_EMERGENCY_H

#include "base/can_frame.h"
#include "base/error_register.h"

enum { EMERGENCY_HISTORY = 8, EMERGENCY_ACTIVE = 16, EMERGENCY_WAITING = 8, EMERGENCY_SOURCE_NODE = 0 };

/* Error codes that the node itself raises, CiA 301 table 26. */
enum {
  EMERGENCY_NONE = 0x0000,
  EMERGENCY_CAN_OVERRUN = 0x8110,
  EMERGENCY_ERROR_PASSIVE = 0x8120,
  EMERGENCY_HEARTBEAT = 0x8130,
  EMERGENCY_BUS_OFF_RECOVERED = 0x8140,
  EMERGENCY_PDO_REFUSED = 0x8200,
  EMERGENCY_PDO_LENGTH = 0x8210,
  EMERGENCY_SYNC_LENGTH = 0x8240,
  EMERGENCY_RPDO_TIME_OUT = 0x8250,
  EMERGENCY_SYNC_TIME_OUT = 0x8700,
  EMERGENCY_SYNC_CLOCK = 0x8701 /* of this device */
};

typedef struct {
  uint8_t error_register;              /* 0x1001 */
  uint8_t count;                       /* 0x1003:0, 0 .. 8 */
  uint32_t history[EMERGENCY_HISTORY]; /* 0x1003:1.., newest first: code, detail << 16, source << 24 */
  uint32_t cob_id;                     /* 0x1014, bit 31: do not send */
  uint16_t inhibit_100us;              /* 0x1015 */
} emergency_objects;

/* The same code from two sources is two errors: each is reported and cleared separately. */
typedef struct {
  uint16_t code;
  uint8_t register_bits;
  uint8_t source;  /* EMERGENCY_SOURCE_NODE; other sources belong to the application */
  uint8_t detail;  /* additional information; the code defines its meaning */
  uint32_t object; /* that the error is about: index << 8 | sub-index; 0: none */
} emergency_error;

typedef struct {
  emergency_error active[EMERGENCY_ACTIVE];
  uint8_t active_count;
  uint8_t waiting[EMERGENCY_WAITING][CAN_FRAME_BYTES];
  uint8_t waiting_first;
  uint8_t waiting_count;
  uint16_t dropped;    /* messages that found no room */
  uint16_t inhibit_ms; /* time left before the next message */
} emergency_producer;

/* Clears active errors and pending messages. The history stays: a reset of the node clears it through its defaults. */
void emergency_reset(emergency_producer *self, emergency_objects *objects);

/* Reports an error. Returns false when the source has this code already, or 16 errors are active. Byte 3 of the message
 * is the detail, byte 4 the source, bytes 5 to 7 index (low byte first) and sub-index of the object. */
bool emergency_raise(emergency_producer *self, emergency_objects *objects, const emergency_error *error);

/* Reports the error even if the source has the same code already, for a caller that knows that it is a new one. Errors
 * with equal source and code are one error in the register and are cleared together. */
bool emergency_raise_again(emergency_producer *self, emergency_objects *objects, const emergency_error *error);

/* Reports "no error" (code 0) with the remaining register value. Returns false when the source had no such error. */
bool emergency_clear(emergency_producer *self, emergency_objects *objects, uint8_t source, uint16_t code);

bool emergency_is_active(const emergency_producer *self, uint8_t source, uint16_t code);

/* Sends at most one waiting message when the inhibit time allows. Call it once per ms. */
void emergency_tick(emergency_producer *self, const emergency_objects *objects, const can_sender *sender);

#endif
