/* Emergency messages: what is wrong now, what was wrong before, and telling the bus of both.
 *
 * Standard: CiA 301 v4.2.0, clause 7.2.7, objects 0x1001 (error register), 0x1003 (history), 0x1014 (COB-ID) and
 * 0x1015 (inhibit time). Whoever sees an error raises it, every tick if he likes: it is told once, until cleared. */
#ifndef TRACKSERVO_CANOPEN_EMERGENCY_H
#define TRACKSERVO_CANOPEN_EMERGENCY_H

#include "canopen/can_frame.h"

enum { EMERGENCY_HISTORY = 8, EMERGENCY_ACTIVE = 16, EMERGENCY_WAITING = 8, EMERGENCY_SOURCE_NODE = 0 };

/* Bits of 0x1001. */
enum {
  ERROR_GENERIC = 0x01,
  ERROR_CURRENT = 0x02,
  ERROR_VOLTAGE = 0x04,
  ERROR_TEMPERATURE = 0x08,
  ERROR_COMMUNICATION = 0x10,
  ERROR_PROFILE = 0x20,
  ERROR_MANUFACTURER = 0x80
};

/* Error codes that the node itself raises, CiA 301 table 26. */
enum {
  EMERGENCY_NONE = 0x0000,
  EMERGENCY_CAN_OVERRUN = 0x8110,
  EMERGENCY_ERROR_PASSIVE = 0x8120,
  EMERGENCY_HEARTBEAT = 0x8130,
  EMERGENCY_BUS_OFF_RECOVERED = 0x8140,
  EMERGENCY_PDO_LENGTH = 0x8210,
  EMERGENCY_SYNC_LENGTH = 0x8240,
  EMERGENCY_RPDO_TIME_OUT = 0x8250,
  EMERGENCY_SYNC_TIME_OUT = 0x8700
};

typedef struct {
  uint8_t error_register;              /* 0x1001 */
  uint8_t count;                       /* 0x1003:0, 0 .. 8 */
  uint32_t history[EMERGENCY_HISTORY]; /* 0x1003:1.., newest first: code, detail << 16, source << 24 */
  uint32_t cob_id;                     /* 0x1014, bit 31: do not send */
  uint16_t inhibit_100us;              /* 0x1015 */
} emergency_objects;

/* The same code of two sources is two errors: each is told, and each is cleared by itself. */
typedef struct {
  uint16_t code;
  uint8_t register_bits;
  uint8_t source; /* EMERGENCY_SOURCE_NODE; others are the application's */
  uint8_t detail; /* what more is known; the meaning is the code's */
} emergency_error;

typedef struct {
  emergency_error active[EMERGENCY_ACTIVE];
  uint8_t active_count;
  uint8_t waiting[EMERGENCY_WAITING][CAN_FRAME_BYTES];
  uint8_t waiting_first;
  uint8_t waiting_count;
  uint16_t dropped;    /* messages that found no room */
  uint16_t inhibit_ms; /* still to wait before the next one */
} emergency_producer;

/* Nothing wrong, nothing to tell; the history stays: a reset of the node clears it by its defaults. */
void emergency_reset(emergency_producer *self, emergency_objects *objects);

/* False when the source has this code already, or 16 errors are active. Byte 3 of the message is the detail, byte 4
 * the source. */
bool emergency_raise(emergency_producer *self, emergency_objects *objects, const emergency_error *error);

/* The same for who knows that it is news: of several errors that share source and code each is told. They are one error
 * in the register, and cleared together. */
bool emergency_raise_again(emergency_producer *self, emergency_objects *objects, const emergency_error *error);

/* Tells "no error" (code 0) with what the register still holds. False when the source had no such error. */
bool emergency_clear(emergency_producer *self, emergency_objects *objects, uint8_t source, uint16_t code);

bool emergency_is_active(const emergency_producer *self, uint8_t source, uint16_t code);

/* One ms: sends at most one waiting message when the inhibit time allows. */
void emergency_tick(emergency_producer *self, const emergency_objects *objects, const can_sender *sender);

#endif
