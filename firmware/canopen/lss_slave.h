/* SPDX-License-Identifier: Apache-2.0 */
/* LSS slave (layer setting services): sets node id and bit rate over the bus, also for a node that has no node id.
 *
 * Standard: CiA 305. Each request and each answer is one frame of 8 bytes, 7E5h and 7E4h, lowest byte first:
 *
 *     04 state               switch state global: 0 waiting, 1 configuration             no answer
 *     40 41 42 43 number     switch state selective: vendor, product, revision, serial   44 from the node that is meant
 *     11 id                  configure node id: 1 .. 127, or 255 for none                11 error detail
 *     13 table index         configure bit rate                                          13 error detail
 *     15 delay_ms (2 bytes)  activate bit rate                                           no answer
 *     17                     store configuration                                         17 error detail
 *     5A 5B 5C 5D            inquire vendor, product, revision, serial number            5A .. 5D number
 *     5E                     inquire node id, 255: none                                  5E id
 *     46 .. 4B number        identify: vendor, product, range of revision and serial     4F
 *     4C                     identify a node without node id                             50
 *     51 number bit part next  fastscan of nodes without node id                         4F
 *
 * The node starts in the waiting state. Commands 11 to 17 and 5A to 5E work only in the configuration state. A new node
 * id takes effect at the next reset of the communication. A node without node id takes it when it is switched to the
 * waiting state. Like sdo_server, this file does not handle CAN: it receives the bytes of requests, provides the
 * answer, and is advanced in time by its owner. */
#ifndef TRACKSERVO_CANOPEN_LSS_SLAVE_H
#define TRACKSERVO_CANOPEN_LSS_SLAVE_H

#include "canopen/bus_settings.h"

enum { LSS_REQUEST_COB_ID = 0x7E5, LSS_RESPONSE_COB_ID = 0x7E4, LSS_BYTES = 8 };

/* Second byte of an answer to 11, 13 and 17. */
enum { LSS_OK = 0, LSS_OUT_OF_RANGE = 1, LSS_STORE_UNSUPPORTED = 1, LSS_STORE_FAILED = 2, LSS_SEE_DETAIL = 255 };

/* Third byte, with LSS_SEE_DETAIL. */
enum { LSS_DETAIL_TORQUE = 1 };

typedef enum { LSS_STORE_PENDING, LSS_STORE_DONE, LSS_STORE_REFUSED } lss_store_progress;

/* What only the device can do or know. `store` and `activate` may be NULL when the device does not support them. */
typedef struct {
  /* True while a motor has torque: the settings must not change then. NULL: no motor ever has torque. */
  bool (*has_torque)(void *context);
  /* Called again in each tick until it no longer returns pending; the settings do not change meanwhile. */
  lss_store_progress (*store)(void *context, const bus_settings *settings);
  /* The CAN controller changes its bit rate. */
  void (*activate)(void *context, uint16_t kbit_s);
  void *context;
} lss_callbacks;

enum { LSS_IDENTITY_PARTS = 4 };

/* Progress of "activate bit rate": the node is silent before and after the change, each time for the delay that the
 * master gave. */
typedef enum { LSS_NO_CHANGE, LSS_BEFORE_CHANGE, LSS_AFTER_CHANGE } lss_change;

typedef struct {
  lss_callbacks callbacks;
  uint32_t identity[LSS_IDENTITY_PARTS]; /* vendor, product, revision, serial number: 0x1018 */
  bus_settings active;                   /* in force */
  bus_settings pending;                  /* as configured */
  bool configuring;                      /* in the configuration state */
  uint8_t selected;                      /* matching parts of "switch state selective", in order */
  uint8_t identified;                    /* the same for "identify" */
  uint8_t scanned;                       /* current part of fastscan */
  uint8_t compared;                      /* its parts that matched to the last bit, a bit each */
  bool storing;
  lss_change change;
  uint16_t delay_ms;
  uint16_t left_ms; /* of this silence */
  uint8_t answer[LSS_BYTES];
  bool answer_waiting;
} lss_slave;

void lss_slave_init(lss_slave *slave, const bus_settings *active, const lss_callbacks *callbacks);

/* Sets the identity of 0x1018. Call it before any request. */
void lss_slave_identify(lss_slave *slave, const uint32_t identity[LSS_IDENTITY_PARTS]);

/* Makes the pending node id take effect. Call at a reset of the communication. */
void lss_slave_take_node_id(lss_slave *slave);

/* Takes a request of exactly 8 bytes. Returns true when the node had no node id, has received one, and must initialise
 * now. */
bool lss_slave_receive(lss_slave *slave, const uint8_t request[LSS_BYTES]);

/* Returns the 8 bytes to send next, or NULL. They stay until `lss_slave_sent`. */
const uint8_t *lss_slave_outgoing(const lss_slave *slave);
void lss_slave_sent(lss_slave *slave);

/* Stores the configuration and changes the bit rate. Call once per ms. When an axis has torque, the silence ends; a bit
 * rate that has not changed yet stays. */
void lss_slave_tick(lss_slave *slave);

/* Returns whether the node must not send, because it or other nodes are about to change the bit rate. It must then obey
 * nothing but NMT. */
static inline bool lss_slave_is_silent(const lss_slave *slave) { return slave->change != LSS_NO_CHANGE; }

static inline bool lss_slave_is_unconfigured(const lss_slave *slave) {
  return slave->active.node_id == BUS_UNCONFIGURED;
}

#endif
