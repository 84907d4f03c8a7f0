/* SPDX-License-Identifier: Apache-2.0 */
/* The servo on the bus: a CANopen node with two CiA 402 axes around the servo core.
 *
 *     servo_node_tick     RPDO -> samples -> protection -> drive (CiA 402) -> servo_board -> set-points of the motors
 *     servo_node_serve    what the tick did -> objects, fault log, scope -> TPDO, SDO, EMCY, heartbeat
 *
 * Each of the two runs once per ms, in that order, on top of any HAL: the motor set-points do not wait for work that
 * only the bus needs. Parts of the dictionary: that of the device (1000), for each axis its parameters (2000),
 * protection (2060), experiments (2100, 2101) and drive (6000), pitch shifted by 0x800, and the part that both share
 * (3000).
 */
#ifndef TRACKSERVO_NODE_SERVO_NODE_H
#define TRACKSERVO_NODE_SERVO_NODE_H

#include "canopen/canopen_node.h"
#include "drive/drive_axis.h"
#include "drive/drive_objects.h"
#include "node/axis_monitor.h"
#include "node/experiment_objects.h"
#include "node/fault_reports.h"
#include "node/guarded_sets.h"
#include "node/moving_base.h"
#include "node/objects/board_objects.h"
#include "node/objects/bus_objects.h"
#include "node/objects/clock_objects.h"
#include "node/objects/fault_objects.h"
#include "node/objects/protection_objects.h"
#include "node/objects/tuning_objects.h"
#include "node/persisted_storage.h"
#include "node/recorded_tick.h"
#include "node/scope_objects.h"
#include "node/tracking.h"
#include "node/waiting_stops.h"
#include "servo/servo_board.h"

enum { SERVO_NODE_QUEUE = 64 };

/* What the tick uses comes first: short offsets cost fewer instructions. */
typedef struct {
  drive_objects objects;
  drive_axis drive;
  axis_monitor monitor;
  protection_objects limits;     /* 0x2060 */
  protection_owner limits_owner; /* of its part */
  bool setpoint_arrived;
  waiting_stops waiting;       /* for 6040 */
  drive_axis_inputs inputs;    /* of this tick */
  servo_axis_command stimulus; /* of an experiment, when it gives the set-point */
  fault_reports reports;       /* of faults, for EMCY and log */
  fault_set bus_faults;        /* commanded in the next tick */
  drive_machine machine;       /* of the drive's bounds */
  bool left_alone;             /* stopped because the master was silent; until the axis is in operation again */
  axis_tuning tuning;
  tuning_owner owner;            /* of the parameters' part */
  experiment_objects experiment; /* 0x2100 */
  recorded_tick recorded;        /* 0x2101 */
} servo_node_axis;

/* 0x3010, 0x3030, 0x3031, 0x3050 and 0x3061. */
typedef struct {
  uint32_t ticks;
  uint32_t schema_hash;
  uint32_t board_status; /* HAL_STATUS_ bits */
  persisted_report persisted_set;
  bus_objects bus;
} servo_node_objects;

typedef struct {
  servo_board board;
  servo_node_axis axis[SERVO_AXES];
  servo_node_objects objects;
  scope_objects scope_setup; /* 0x3000 */
  scope recorder;
  bool started;
  persisted_storage storage;
  persisted_objects in_force; /* as of the last store command */
  const hal_flash *flash;     /* as configured */
  hal_scales scales;          /* 0x3060 */
  master_objects master;      /* 0x3040, 0x3041 */
  target_tracking tracking;   /* 0x3070 .. 0x3075 */
  bool camera_is_stale;       /* reported as such */
  moving_base base;           /* 0x3076 .. 0x3078 */
  clock_objects clock;        /* 0x1013 */
  master_owner master_part;
  bool cob_ids_collide; /* the stored ones did at the last reset: the defaults are in force */
  fault_log log;        /* 0x3020 */
  access_lock lock;     /* 0x3040 */
  bool recovering;      /* as configured */
  uint64_t waived_hash; /* of the owner's word that recovery has put out of force, or 0 */
  guarded_sets guarded;
  fault_objects fault_setup;
  fault_objects_owner fault_owner;
  canopen_node canopen;
  can_frame process_data[SERVO_NODE_QUEUE];
  can_frame services[SERVO_NODE_QUEUE];
} servo_node;

/* The node's bus, besides its node id. */
typedef struct {
  uint16_t kbit_s;        /* bit rate while LSS has stored none; 0: BUS_DEFAULT_KBIT_S */
  bool recovering;        /* use the node id and bit rate given here, regardless of those that LSS has stored, and no
                             owner's word (0x3040) until one is set or the node starts again */
  const hal_flash *flash; /* BUS_SETTINGS_LOG_PAGES pages for what LSS stores; NULL: in RAM only */
  bus_joiner joiner;      /* first called before servo_node_start returns */
} servo_node_bus;

typedef struct {
  uint8_t node_id; /* 1 .. 127 or BUS_UNCONFIGURED, while LSS has stored none */
  can_sender sender;
  hal *machine;
  const axis_parameters *parameters; /* of both axes, SERVO_AXES of them: the defaults of the stored objects */
  const protection_limits *limits; /* the same; the default of 607D comes from them, see axis_monitor_default_travel */
  const hal_flash *flash;          /* PARAMETER_STORE_AREAS of them, for the stored parameters; NULL: in RAM only */
  uint32_t serial_number;          /* 0x1018:4; 0: none */
  servo_node_bus bus;
  const char *hardware_version; /* 0x1009, at most CANOPEN_HARDWARE_VERSION letters; NULL: none */
  const hal_scales *scales;     /* of the board's sensors, the defaults of 0x3060; NULL: those of its table */
} servo_node_config;

/* Returns false when the parameters or the node id are refused. Stored values that pass their checks are then in
 * effect, otherwise the defaults; 0x3031 reports which, and EMCY 6310 if something was skipped. The node must not be
 * moved in memory afterwards. */
bool servo_node_start(servo_node *node, const servo_node_config *config);

/* Queues a received frame. Call from the CAN receive interrupt, or from one other thread. Returns false when the queue
 * was full; the frame is lost and counted. */
bool servo_node_receive(servo_node *node, const can_frame *frame);

/* Stops both axes. Call before a tick when the CAN controller went bus-off, because no frame can be received then. */
void servo_node_bus_off(servo_node *node);

/* Reports a fault of the board itself, not of an axis, by EMCY and in the log. Call before a tick. A fault that does
 * not persist (`lasts` false) ends at once: only the history keeps it. */
void servo_node_report(servo_node *node, fault_id fault, uint8_t detail, bool lasts);

/* Takes process data that has arrived, so that the tick has less work. Optional; call shortly before a tick and in its
 * thread. */
void servo_node_take(servo_node *node);

/* Call every 1 ms. Takes process data, then computes the current set-points of both axes from the samples. */
void servo_node_tick(servo_node *node);

/* Does as servo_node_tick, but takes no process data. Call right after servo_node_take: later frames take effect in the
 * next tick, so the cost of this one does not depend on when frames arrive. */
void servo_node_tick_taken(servo_node *node);

/* Sends, answers requests and records. Call after each tick and before the next, never within one. Values received by
 * SDO take effect in the next tick. */
void servo_node_serve(servo_node *node);

/* Stores, with one flash operation per call. Call repeatedly between ticks, or from a background that the tick
 * interrupts. */
void servo_node_background(servo_node *node);

/* Returns the whole dictionary, for printing EDS and other descriptions. */
const object_dictionary *servo_node_dictionary(const servo_node *node);

#endif
