/* A CANopen node: all services of one device on one bus.
 *
 * Standard: CiA 301 v4.2.0; each service is a file of its own, this one ties them together. The receive interrupt
 * calls `canopen_node_receive`, which puts each frame into one of two queues; everything leaves through one sender.
 *
 *     process data: NMT, SYNC, RPDO    `canopen_node_take`, at the beginning of a 1 ms tick: what the tick acts upon
 *     services: SDO, LSS, heartbeat    `canopen_node_serve`, when the tick has done what is urgent
 *
 * The latter also sends TPDOs, with what the tick made, EMCY and heartbeat, and keeps the times. So an SDO request
 * takes no time from the tick. A reset by NMT takes some 20 calls of it: each does one piece, and the boot-up message
 * comes after the last. Both run in one thread, never one within the other. */
#ifndef TRACKSERVO_CANOPEN_CANOPEN_NODE_H
#define TRACKSERVO_CANOPEN_CANOPEN_NODE_H

#include "canopen/can_queue.h"
#include "canopen/communication_profile.h"
#include "canopen/lss_slave.h"
#include "canopen/nmt.h"
#include "canopen/rpdo.h"
#include "canopen/sdo_server.h"
#include "canopen/tpdo.h"

enum {
  CANOPEN_PARTS = 18,           /* of the dictionary: two of the node, the others of the application */
  CANOPEN_FRAMES_PER_CALL = 16, /* of a queue; twice what 1 Mbit/s can bring in 1 ms */
  CANOPEN_SDO_FRAMES_PER_CALL = 8
};

/* What the application wants to know; each may be NULL. None is called from the interrupt. */
typedef struct {
  void (*state_changed)(void *context, nmt_state state);
  /* NMT asked for a reset: what cannot wait, such as to take torque away. `whole_node`: of the application, too. */
  void (*reset_begins)(void *context, bool whole_node);
  /* Once the communication objects have their defaults again: the place to put stored values over them, with od_put.
   * Called once a ms with `step` 0, 1, 2 ... until it answers true, so that no ms has too much to do; without a pause
   * by canopen_node_init. */
  bool (*reset)(void *context, bool whole_node, uint32_t step);
  void (*heartbeat_lost)(void *context, uint8_t node_id);
  void (*rpdo_late)(void *context, uint32_t n);
} canopen_events;

typedef struct {
  uint8_t node_id;              /* 1 .. 127; BUS_UNCONFIGURED: nothing but LSS, until that gives one */
  uint16_t kbit_s;              /* bit rate of the bus; 0: BUS_DEFAULT_KBIT_S */
  const od_table *device_table; /* identity and PDO rows, see communication_profile.h */
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

/* The identifiers that are listened to, out of the objects: a frame is compared with these alone. Greater than any
 * identifier: nobody listens. */
typedef struct {
  uint32_t sync;
  uint32_t sdo_request[SDO_CHANNELS];
  uint32_t rpdo[PDO_COUNT];
} canopen_listeners;

/* A reset under way, while the state is NMT_INITIALISING. */
typedef struct {
  bool pending;
  bool whole_node;
  uint32_t step;       /* the next one */
  uint32_t configured; /* 0: the application is not done yet; else 1 + the PDO to be configured next */
} canopen_reset;

/* The same, and heartbeats, for the receive interrupt: a bit for each identifier. */
enum { CANOPEN_HEARD_WORDS = 0x800 / 32 };

typedef struct {
  canopen_config config; /* node_id is always 1 .. 127: without a node id, the one that the objects are for */
  can_sender sender;     /* the configured one, but while the bit rate changes */
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
  uint32_t first_sdo; /* the channel that sends first in the next call: both have their share */
  lss_slave lss;
  heartbeat_producer producer;
  heartbeat_consumer consumers[HEARTBEAT_CONSUMERS];
  sync_consumer sync;
  emergency_producer emergency;
  rpdo rpdos[PDO_COUNT];
  tpdo tpdos[PDO_COUNT];
  bool sync_wrong_length;
  uint8_t sync_counter[CANOPEN_FRAMES_PER_CALL]; /* of each SYNC taken since TPDOs were served */
  uint32_t sync_count;
  uint32_t overruns_told;
  uint16_t overrun_quiet_ms;
  shared_word heard[CANOPEN_HEARD_WORDS];
} canopen_node;

/* False on a bad node id, too many parts or a bad queue; the node must not be used then. It must not move in memory
 * afterwards. The boot-up message leaves with the first tick that finds room for it. */
bool canopen_node_init(canopen_node *node, const canopen_config *config);

/* From the receive interrupt, or any one other thread. A frame that nobody listens to is dropped here, so that a bus
 * full of other nodes' frames fills no queue. False: the queue was full, the frame is lost and counted. */
bool canopen_node_receive(canopen_node *node, const can_frame *frame);

/* Every 1 ms, with bounded work: at most CANOPEN_FRAMES_PER_CALL frames in. Obeys NMT, gives RPDOs to the objects. */
void canopen_node_take(canopen_node *node);

/* Every 1 ms, after it, as bounded. */
void canopen_node_serve(canopen_node *node);

/* Both, for a device that has nothing to do between them. */
void canopen_node_tick(canopen_node *node);

/* Optional, between ticks and in the same thread: SDO requests, so that answers need not wait for the tick. */
void canopen_node_answer(canopen_node *node);

/* Errors of the application, see emergency.h; its sources are not 0. */
bool canopen_node_raise(canopen_node *node, const emergency_error *error);
bool canopen_node_raise_again(canopen_node *node, const emergency_error *error);
bool canopen_node_clear(canopen_node *node, uint8_t source, uint16_t code);

/* From the CAN driver's supervision, in the tick's thread. */
void canopen_node_bus_off_recovered(canopen_node *node);
void canopen_node_error_passive(canopen_node *node, bool passive);

/* Node id and bit rate in force, as the COB-IDs and default inhibit times have them. */
bus_settings canopen_node_settings(const canopen_node *node);

/* The CAN controller has another bit rate from now on; default inhibit times follow. */
void canopen_node_set_bit_rate(canopen_node *node, uint16_t kbit_s);

/* Sends TPDO n (0 .. 3) as soon as its type and inhibit time allow. */
void canopen_node_request_tpdo(canopen_node *node, uint32_t n);

#endif
