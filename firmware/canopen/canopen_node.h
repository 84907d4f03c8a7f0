/* SPDX-License-Identifier: Apache-2.0 */
/* A CANopen node: all services of one device on one bus.
 *
 * Standard: CiA 301 v4.2.0. Each service has its own file; this file combines them. The receive interrupt calls
 * `canopen_node_receive`, which puts each frame into one of two queues. All frames leave through one send function.
 *
 *     process data: NMT, SYNC, RPDO    `canopen_node_take`, at the beginning of a 1 ms tick: what the tick acts upon
 *     services: SDO, LSS, heartbeat    `canopen_node_serve`, when the tick has done what is urgent
 *
 * `canopen_node_serve` also sends TPDOs with the results of the tick, EMCY and heartbeat, and advances the timers. So
 * an SDO request takes no time from the tick. A reset by NMT takes some 20 calls of it: each call does one piece, and
 * the boot-up message follows the last. Both functions run in one thread and never interrupt each other. */
#ifndef TRACKSERVO_CANOPEN_CANOPEN_NODE_H
#define TRACKSERVO_CANOPEN_CANOPEN_NODE_H

#include "base/can_queue.h"
#include "canopen/communication_profile.h"
#include "canopen/lss_slave.h"
#include "canopen/nmt.h"
#include "canopen/rpdo.h"
#include "canopen/sdo_server.h"
#include "canopen/tpdo.h"

enum {
  CANOPEN_PARTS = 21,            /* of the dictionary: two of the node, the others of the application */
  CANOPEN_FRAMES_PER_CALL = 16,  /* of a queue; twice the frames with eight bytes that 1 Mbit/s delivers in 1 ms */
  CANOPEN_REQUESTS_PER_CALL = 4, /* of SDO: one may cost the deferred task 120 us */
  CANOPEN_SDO_FRAMES_PER_CALL = 8
};

/* Callbacks into the application; each may be NULL. None is called from the interrupt. */
typedef struct {
  void (*state_changed)(void *context, nmt_state state);
  /* NMT requested a reset: do the urgent part, such as removing torque. `whole_node`: reset the application as well. */
  void (*reset_begins)(void *context, bool whole_node);
  /* The communication objects have their defaults again: write stored values over them here, with od_put. Called once
   * per ms with `step` 0, 1, 2 ... until it returns true, so that no ms has too much work. canopen_node_init calls it
   * without pauses. */
  bool (*reset)(void *context, bool whole_node, uint32_t step);
  void (*heartbeat_lost)(void *context, uint8_t node_id);
  void (*rpdo_late)(void *context, uint32_t n);
} canopen_events;

typedef struct {
  uint8_t node_id;              /* 1 .. 127; BUS_UNCONFIGURED: only LSS, until LSS sets a node id */
  uint16_t kbit_s;              /* bit rate of the bus; 0: BUS_DEFAULT_KBIT_S */
  const od_table *device_table; /* identity and PDO rows; see communication_profile.h */
  const od_part *parts;         /* of the application, copied */
  uint32_t part_count;          /* 0 .. 14 */
  can_sender sender;
  can_frame *process_data; /* room for the two queues, owned by the caller */
  can_frame *services;
  uint32_t queue_capacity; /* of each: a power of two, at least 64 */
  storage_callbacks storage;
  lss_callbacks lss;
  canopen_events events;
  void *context; /* of the events */
} canopen_config;

enum { CANOPEN_LAST_IDENTIFIER = 0x7FF };

/* The heard identifiers, taken from the objects: a received frame is compared with these only. Greater than any
 * identifier: not heard. */
typedef struct {
  uint32_t sync;
  uint32_t sdo_request[SDO_CHANNELS];
  uint32_t rpdo[RPDO_COUNT];
} canopen_listeners;

/* A reset in progress, while the state is NMT_INITIALISING. */
typedef struct {
  bool pending;
  bool whole_node;
  uint32_t step;       /* the next step */
  uint32_t configured; /* 0: the application is not done yet; otherwise 1 + the PDO to configure next */
} canopen_reset;

/* The same identifiers, and heartbeats, for the receive interrupt: one bit per identifier. */
enum { CANOPEN_HEARD_WORDS = 0x800 / 32 };

typedef struct {
  canopen_config config; /* node_id is always 1 .. 127; with none configured, that of the objects */
  can_sender sender;     /* the configured sender, except while the bit rate changes */
  communication_objects objects;
  od_part parts[CANOPEN_PARTS];
  od_groups groups;
  object_dictionary dictionary;
  nmt_state state;
  canopen_reset reset;
  canopen_listeners listeners;
  can_queue process_data;
  can_queue services;
  sdo_server sdo[SDO_CHANNELS];
  uint32_t sdo_client;  /* the channel whose request is being executed; SDO_CHANNELS: none, e.g. an RPDO */
  uint32_t commit_turn; /* the channel whose long command goes on in this ms when both have one */
  uint32_t first_sdo;   /* the channel that sends first in the next call, so that both get their share */
  lss_slave lss;
  heartbeat_producer producer;
  heartbeat_consumer consumers[HEARTBEAT_CONSUMERS];
  bool rpdos_changed; /* a frame of theirs was wrong, or the first right one after it: to be reported */
  sync_consumer sync;
  sync_clock clock;
  emergency_producer emergency;
  rpdo rpdos[RPDO_COUNT];
  tpdo tpdos[TPDO_COUNT];
  uint32_t tpdos_in_use; /* 1 + the last one that is on */
  uint16_t received_us;  /* of the frame that is being executed, as in can_frame */
  uint32_t silent_ms;    /* since the last frame for this node; see canopen_node_silent_ms */
  bool sync_is_used;     /* a PDO is synchronous: SYNC is for this node, too */
  bool sync_wrong_length;
  uint8_t sync_counter[CANOPEN_FRAMES_PER_CALL]; /* of each SYNC received since TPDOs were last processed */
  uint32_t sync_count;
  uint32_t controller_overruns;
  uint32_t dropped_commands; /* frames whose command had to wait while the queue was more than half full */
  uint32_t overruns_reported;
  uint16_t overrun_quiet_ms;
  uint32_t frames_taken; /* of process_data, since canopen_node_serve */
  shared_word heard[CANOPEN_HEARD_WORDS];
} canopen_node;

/* Initialises the node. Returns false for a bad node id, too many parts or a bad queue; the node must not be used then.
 * It must not be moved in memory afterwards. The boot-up message is sent in the first tick that finds room for it. */
bool canopen_node_init(canopen_node *node, const canopen_config *config);

/* Queues a received frame. Call from the receive interrupt, or from any one other thread. Drops a frame that the node
 * does not use, so that the traffic of other nodes fills no queue. Returns false when the queue was full; the frame is
 * lost and counted. */
bool canopen_node_receive(canopen_node *node, const can_frame *frame);

/* Executes NMT commands and writes RPDOs to the objects. Call every 1 ms, or several times. Takes at most
 * CANOPEN_FRAMES_PER_CALL received frames until canopen_node_serve is called. */
void canopen_node_take(canopen_node *node);

/* Returns whether an SDO channel has both its identifiers. */
static inline bool canopen_sdo_is_on(const canopen_node *node, uint32_t channel) {
  return node->listeners.sdo_request[channel] <= CANOPEN_LAST_IDENTIFIER;
}

/* Answers SDO and LSS, sends PDOs, EMCY and heartbeat, and advances the timers. Call every 1 ms, after
 * canopen_node_take. Takes at most CANOPEN_FRAMES_PER_CALL received frames, and of them
 * CANOPEN_REQUESTS_PER_CALL SDO requests, or one while an owner goes on with an earlier one. */
void canopen_node_serve(canopen_node *node);

/* Calls both, for a device that does nothing between them. */
void canopen_node_tick(canopen_node *node);

/* Processes SDO requests, so that answers need not wait for the tick. Optional; call between ticks and in the same
 * thread. */
void canopen_node_answer(canopen_node *node);

/* Returns how long no frame for this node has come, in ms. Frames for it are: NMT commands to it or to all, SDO
 * requests, its RPDOs and SYNC while the node acts upon them (SYNC only if a PDO is synchronous), and heartbeats of
 * nodes in 0x1016. While a heartbeat (0x1016) or an RPDO (event timer, 0x1400:5) is monitored and in time, the result
 * is 0: the owner has set how long that one may be silent. */
uint32_t canopen_node_silent_ms(const canopen_node *node);

/* Restarts the supervision of the master, for an application that also receives from its master by another bus. */
static inline void canopen_node_heard(canopen_node *node) { node->silent_ms = 0; }

/* Raises an error of the application; see emergency.h. Source 0 is the node's own. */
bool canopen_node_raise(canopen_node *node, const emergency_error *error);
bool canopen_node_raise_again(canopen_node *node, const emergency_error *error);
bool canopen_node_clear(canopen_node *node, uint8_t source, uint16_t code);

/* Reports that a bus-off has ended. Call from the supervision of the CAN driver, in the tick's thread. */
void canopen_node_bus_off_recovered(canopen_node *node);
void canopen_node_error_passive(canopen_node *node, bool passive);

/* Reports how many received frames the controller itself has lost since the start. They count as those of a full queue.
 * Call in the tick's thread. */
void canopen_node_lost_frames(canopen_node *node, uint32_t total);

/* Returns node id and bit rate in effect, as the COB-IDs and default inhibit times use them. */
bus_settings canopen_node_settings(const canopen_node *node);

/* Takes the new bit rate of the CAN controller; default inhibit times follow. Call after the controller has changed
 * it. */
void canopen_node_set_bit_rate(canopen_node *node, uint16_t kbit_s);

/* Sends TPDO n (0 .. 7) as soon as its type and inhibit time allow. */
void canopen_node_request_tpdo(canopen_node *node, uint32_t n);

#endif
