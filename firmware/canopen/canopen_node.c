/* SPDX-License-Identifier: Apache-2.0 */
#include <string.h>

#include "canopen/canopen_node_parts.h"
#include "canopen/cob_id.h"
#include "canopen/node_objects.h"

enum { PART_COMMUNICATION, PART_DEVICE, NODE_PARTS, QUEUE_CAPACITY_MIN = 64, OVERRUN_QUIET_MS = 1000 };

_Static_assert((uint32_t)LSS_REQUEST_COB_ID == (uint32_t)HEARD_LSS_REQUEST, "it must pass the filters");

bool canopen_send(const canopen_node *node, const can_frame *frame) {
  return node->sender.send(node->sender.context, frame);
}

static bool send_unless_silent(void *context, const can_frame *frame) {
  const canopen_node *node = context;
  return !lss_slave_is_silent(&node->lss) && node->config.sender.send(node->config.sender.context, frame);
}

static void reset_sdo(canopen_node *node) {
  for (uint32_t i = 0; i < SDO_CHANNELS; i++) {
    sdo_server_reset(&node->sdo[i]);
  }
}

/* What waits for a SYNC is forgotten with the state, but not a stop in it. */
static void obey_waiting_stops(canopen_node *node) {
  for (uint32_t n = 0; n < RPDO_COUNT; n++) {
    if (node->rpdos[n].waiting) {
      rpdo_obey_stops(&node->rpdos[n], NULL);
    }
  }
}

void canopen_enter(canopen_node *node, nmt_state state) {
  if (node->rpdos_changed) {
    node_objects_judge_rpdos(node); /* rpdo_reset would forget it */
  }
  obey_waiting_stops(node);
  node->state = state;
  if (state == NMT_OPERATIONAL) {
    node->sync_count = 0;
    for (uint32_t n = 0; n < RPDO_COUNT; n++) {
      rpdo_reset(&node->rpdos[n]);
    }
    for (uint32_t n = 0; n < TPDO_COUNT; n++) {
      tpdo_reset(&node->tpdos[n]);
    }
    node_objects_judge_rpdos(node);
  }
  if (!nmt_allows_sdo(state)) {
    reset_sdo(node);
  }
  if (node->config.events.state_changed != NULL) {
    node->config.events.state_changed(node->config.context, state);
  }
}

/* --- Reset: urgent parts at once, then one piece per ms --------------------------------------------------------- */

/* The node's steps before the application's; the application's first step follows the last of them. */
enum { STEP_COMMUNICATION, STEP_DEVICE, STEP_SERVICES, STEP_APPLICATION };

/* Far more than any application needs; it bounds canopen_node_init. */
enum { RESET_STEPS_MAX = 64 };

bus_settings canopen_node_settings(const canopen_node *node) {
  return (bus_settings){.node_id = node->config.node_id, .kbit_s = node->config.kbit_s};
}

/* A node id that LSS has set takes effect now. */
static void take_lss_node_id(canopen_node *node) {
  lss_slave_take_node_id(&node->lss);
  if (!lss_slave_is_unconfigured(&node->lss)) {
    node->config.node_id = node->lss.active.node_id;
  }
}

void canopen_begin_reset(canopen_node *node, bool whole_node) {
  take_lss_node_id(node);
  node->reset = (canopen_reset){.pending = true, .whole_node = whole_node, .step = STEP_COMMUNICATION};
  reset_sdo(node);
  if (node->config.events.reset_begins != NULL) {
    node->config.events.reset_begins(node->config.context, whole_node);
  }
  canopen_enter(node, NMT_INITIALISING);
}

static void restore_defaults(canopen_node *node, uint32_t part) {
  const uint32_t serial_number = node->objects.serial_number;
  char hardware_version[CANOPEN_HARDWARE_VERSION];
  memcpy(hardware_version, node->objects.hardware_version, sizeof hardware_version);
  const bus_settings now = canopen_node_settings(node);
  const bus_settings preset = {.node_id = now.node_id, .kbit_s = BUS_DEFAULT_KBIT_S};
  od_restore_defaults(&node->parts[part], now.node_id);
  bus_defaults_follow(&node->parts[part].table, &node->objects, &preset, &now);
  node->objects.serial_number = serial_number;
  memcpy(node->objects.hardware_version, hardware_version, sizeof hardware_version);
}

static void reset_services(canopen_node *node) {
  emergency_reset(&node->emergency, &node->objects.emergency);
  node->sync_wrong_length = false;
  heartbeat_producer_sent(&node->producer);
  for (uint32_t i = 0; i < HEARTBEAT_CONSUMERS; i++) {
    heartbeat_consumer_reset(&node->consumers[i]);
  }
}

/* After the application, which may have written other values to the objects: one PDO of each direction per step, then
 * the heard identifiers. */
static void configure(canopen_node *node, uint32_t n) {
  if (n < RPDO_COUNT) {
    node_objects_configure_rpdo(node, n);
  }
  if (n < TPDO_COUNT) {
    node_objects_configure_tpdo(node, n);
    return;
  }
  node_objects_configure_sync(node);
  node_objects_configure_sdo(node);
  node_objects_listen(node);
  node->reset.pending = false;
}

static bool application_is_reset(canopen_node *node, uint32_t step) {
  return node->config.events.reset == NULL ||
         node->config.events.reset(node->config.context, node->reset.whole_node, step);
}

static void step_reset(canopen_node *node) {
  canopen_reset *reset = &node->reset;
  const uint32_t step = reset->step++;
  switch (step) {
    case STEP_COMMUNICATION:
      restore_defaults(node, PART_COMMUNICATION);
      break;
    case STEP_DEVICE:
      restore_defaults(node, PART_DEVICE);
      break;
    case STEP_SERVICES:
      reset_services(node);
      break;
    default:
      if (reset->configured > 0) {
        configure(node, reset->configured - 1);
        reset->configured++;
      } else if (application_is_reset(node, step - STEP_APPLICATION)) {
        reset->configured = 1;
      }
      break;
  }
}

static od_part own_part(canopen_node *node, const od_table *table) {
  return (od_part){
      .table = *table, .shift = 0, .prefix = "", .values = &node->objects, .owner = node, .hooks = &node_objects_hooks};
}

bool canopen_node_init(canopen_node *node, const canopen_config *config) {
  const uint16_t kbit_s = config->kbit_s == 0 ? BUS_DEFAULT_KBIT_S : config->kbit_s;
  const bool good = bus_node_id_is_good(config->node_id) && bus_kbit_s_of_index(bus_index_of_kbit_s(kbit_s)) != 0 &&
                    config->sender.send != NULL && config->part_count <= CANOPEN_PARTS - NODE_PARTS &&
                    config->queue_capacity >= QUEUE_CAPACITY_MIN;
  if (!good || !can_queue_init(&node->process_data, config->process_data, config->queue_capacity) ||
      !can_queue_init(&node->services, config->services, config->queue_capacity)) {
    return false;
  }
  const bus_settings settings = {.node_id = config->node_id, .kbit_s = kbit_s};
  node->config = *config;
  node->config.node_id = BUS_DEFAULT_NODE_ID; /* until reset() takes the node id of the settings, if there is one */
  node->config.kbit_s = kbit_s;
  node->sender = (can_sender){.send = send_unless_silent, .context = node};
  lss_slave_init(&node->lss, &settings, &config->lss);
  memset(&node->objects, 0, sizeof node->objects);
  node->parts[PART_COMMUNICATION] = own_part(node, &communication_profile_table);
  node->parts[PART_DEVICE] = own_part(node, config->device_table);
  /* Bound: CANOPEN_PARTS: checked before (good). */
  for (uint32_t i = 0; i < config->part_count; i++) {
    node->parts[NODE_PARTS + i] = config->parts[i];
  }
  const uint32_t part_count = NODE_PARTS + config->part_count;
  od_group_parts(&node->groups, node->parts, part_count);
  node->dictionary = (object_dictionary){.parts = node->parts, .count = part_count, .groups = &node->groups};
  node->controller_overruns = 0;
  node->overruns_reported = 0;
  node->overrun_quiet_ms = 0;
  node->silent_ms = 0;
  node->sdo_client = SDO_CHANNELS;
  node->producer = (heartbeat_producer){.elapsed_ms = 0};
  for (uint32_t i = 0; i < SDO_CHANNELS; i++) {
    sdo_server_init(&node->sdo[i], &node->dictionary);
  }
  canopen_begin_reset(node, true);
  for (uint32_t i = 0; i < RESET_STEPS_MAX && node->reset.pending; i++) {
    step_reset(node);
  }
  return !node->reset.pending;
}

bool canopen_is_heartbeat(const can_frame *frame) {
  return frame->id > HEARTBEAT_COB_ID && frame->id <= HEARTBEAT_COB_ID + 127;
}

uint32_t canopen_sdo_channel_of(const canopen_node *node, const can_frame *frame) {
  uint32_t channel = 0;
  /* Bound: SDO_CHANNELS. */
  while (channel < SDO_CHANNELS && frame->id != node->listeners.sdo_request[channel]) {
    channel++;
  }
  return channel;
}

static bool is_heard(const canopen_node *node, const can_frame *frame) {
  const uint32_t word = frame->id / 32u;
  return frame->flags == 0 && frame->length <= CAN_FRAME_BYTES && word < CANOPEN_HEARD_WORDS &&
         (atomic_load_explicit(&node->heard[word], memory_order_relaxed) >> frame->id % 32u & 1u) != 0;
}

bool canopen_node_receive(canopen_node *node, const can_frame *frame) {
  if (!is_heard(node, frame)) {
    return true;
  }
  const bool waits = canopen_is_heartbeat(frame) || frame->id == LSS_REQUEST_COB_ID ||
                     canopen_sdo_channel_of(node, frame) < SDO_CHANNELS;
  return can_queue_push(waits ? &node->services : &node->process_data, frame);
}

bool canopen_node_raise(canopen_node *node, const emergency_error *error) {
  return emergency_raise(&node->emergency, &node->objects.emergency, error);
}

bool canopen_node_raise_again(canopen_node *node, const emergency_error *error) {
  return emergency_raise_again(&node->emergency, &node->objects.emergency, error);
}

bool canopen_node_clear(canopen_node *node, uint8_t source, uint16_t code) {
  return emergency_clear(&node->emergency, &node->objects.emergency, source, code);
}

void canopen_raise_or_clear(canopen_node *node, uint16_t code, bool active) {
  if (active) {
    (void)canopen_node_raise(node, &(emergency_error){.code = code, .register_bits = ERROR_COMMUNICATION});
  } else {
    (void)canopen_node_clear(node, EMERGENCY_SOURCE_NODE, code);
  }
}

void canopen_node_error_passive(canopen_node *node, bool passive) {
  canopen_raise_or_clear(node, EMERGENCY_ERROR_PASSIVE, passive);
}

void canopen_node_request_tpdo(canopen_node *node, uint32_t n) {
  if (n < TPDO_COUNT) {
    tpdo_request(&node->tpdos[n]);
  }
}

void canopen_obey_error_behaviour(canopen_node *node) {
  if (node->state != NMT_OPERATIONAL) {
    return;
  }
  if (node->objects.error_behaviour == ON_ERROR_PRE_OPERATIONAL) {
    canopen_enter(node, NMT_PRE_OPERATIONAL);
  } else if (node->objects.error_behaviour == ON_ERROR_STOP) {
    canopen_enter(node, NMT_STOPPED);
  }
}

void canopen_node_bus_off_recovered(canopen_node *node) {
  canopen_raise_or_clear(node, EMERGENCY_BUS_OFF_RECOVERED, true);
  canopen_raise_or_clear(node, EMERGENCY_BUS_OFF_RECOVERED, false);
  canopen_obey_error_behaviour(node);
}

void canopen_node_set_bit_rate(canopen_node *node, uint16_t kbit_s) {
  const bus_settings before = canopen_node_settings(node);
  node->config.kbit_s = kbit_s;
  const bus_settings now = canopen_node_settings(node);
  for (uint32_t part = 0; part < NODE_PARTS; part++) {
    bus_defaults_follow(&node->parts[part].table, &node->objects, &before, &now);
  }
  for (uint32_t n = 0; n < TPDO_COUNT; n++) {
    node_objects_configure_tpdo(node, n);
  }
}

/* --- Queues ------------------------------------------------------------------------------------------------------- */

void canopen_node_take(canopen_node *node) {
  const can_frame *frame = can_queue_front(&node->process_data);
  /* Bound: CANOPEN_FRAMES_PER_CALL: counted since canopen_node_serve. */
  for (; node->frames_taken < CANOPEN_FRAMES_PER_CALL && frame != NULL; node->frames_taken++) {
    node->received_us = frame->received_us;
    if (node->state != NMT_INITIALISING && !canopen_receive_process_data(node, frame)) {
      return;
    }
    can_queue_drop(&node->process_data);
    frame = can_queue_front(&node->process_data);
  }
}

/* `waiting`, process data or NULL, came before it: what it asks must not take effect before them. */
static bool overtakes(const can_frame *service, const can_frame *waiting) {
  return waiting != NULL && (int16_t)(service->received_us - waiting->received_us) >= 0;
}

/* An SDO request, but no segment of a block: it costs little, and blocks come at the speed of the bus. */
static bool is_request(const canopen_node *node, const can_frame *frame) {
  const uint32_t channel = canopen_sdo_channel_of(node, frame);
  return channel < SDO_CHANNELS && node->sdo[channel].state != SDO_BLOCK_DOWNLOADING;
}

static uint32_t requests_allowed(const canopen_node *node) {
  return canopen_sdo_commits(node) != 0 ? 1 : CANOPEN_REQUESTS_PER_CALL;
}

static void take_services(canopen_node *node) {
  const can_frame *waiting = can_queue_front(&node->process_data);
  const can_frame *frame = can_queue_front(&node->services);
  for (uint32_t i = 0; i < CANOPEN_FRAMES_PER_CALL && frame != NULL && !overtakes(frame, waiting); i++) {
    if (i > 0 && is_request(node, frame) && i >= requests_allowed(node)) {
      return;
    }
    node->received_us = frame->received_us;
    canopen_receive_service(node, frame);
    can_queue_drop(&node->services);
    frame = can_queue_front(&node->services);
  }
}

void canopen_node_answer(canopen_node *node) {
  take_services(node);
  canopen_send_sdos(node, CANOPEN_SDO_FRAMES_PER_CALL);
  canopen_send_lss(node);
}

/* --- One millisecond --------------------------------------------------------------------------------------------- */

/* Heartbeat and boot-up message. The boot-up message is the heartbeat of an initialising node; a node without node id
 * initialises until it gets one. */
static void tick_producer(canopen_node *node) {
  if (lss_slave_is_unconfigured(&node->lss)) {
    return;
  }
  const bool boot = node->state == NMT_INITIALISING;
  const bool due = heartbeat_producer_due(&node->producer, node->objects.heartbeat_producer_ms);
  if (!boot && !due) {
    return;
  }
  const can_frame frame = {
      .id = HEARTBEAT_COB_ID + (uint32_t)node->config.node_id, .length = 1, .data = {(uint8_t)node->state}};
  if (!canopen_send(node, &frame)) {
    return;
  }
  heartbeat_producer_sent(&node->producer);
  if (boot) {
    canopen_enter(node, NMT_PRE_OPERATIONAL);
  }
}

/* The master sends a heartbeat or an RPDO with a time limit of its own, and within that limit. */
static bool is_monitored(const canopen_node *node) {
  bool monitored = false;
  for (uint32_t i = 0; i < HEARTBEAT_CONSUMERS; i++) {
    monitored = monitored || (node->consumers[i].health == HEARTBEAT_ALIVE &&
                              heartbeat_consumer_active(node->objects.heartbeat_consumer[i]));
  }
  for (uint32_t n = 0; n < RPDO_COUNT && nmt_allows_pdo(node->state); n++) {
    monitored = monitored || (rpdo_is_monitored(&node->rpdos[n]) && node->rpdos[n].speaks);
  }
  return monitored;
}

uint32_t canopen_node_silent_ms(const canopen_node *node) {
  return node->silent_ms == 0 || is_monitored(node) ? 0 : node->silent_ms;
}

static void tick_consumers(canopen_node *node) {
  for (uint32_t i = 0; i < HEARTBEAT_CONSUMERS; i++) {
    const uint32_t object = node->objects.heartbeat_consumer[i];
    if (heartbeat_consumer_tick(&node->consumers[i], object)) {
      canopen_lose_producer(node, heartbeat_consumer_node(object));
    }
  }
}

void canopen_node_lost_frames(canopen_node *node, uint32_t total) { node->controller_overruns = total; }

static void tick_overruns(canopen_node *node) {
  const uint32_t overruns = can_queue_overruns(&node->process_data) + can_queue_overruns(&node->services) +
                            node->controller_overruns + node->dropped_commands;
  if (overruns != node->overruns_reported) {
    node->overruns_reported = overruns;
    node->overrun_quiet_ms = 0;
    canopen_raise_or_clear(node, EMERGENCY_CAN_OVERRUN, true);
  } else if (node->overrun_quiet_ms <= OVERRUN_QUIET_MS && ++node->overrun_quiet_ms > OVERRUN_QUIET_MS) {
    canopen_raise_or_clear(node, EMERGENCY_CAN_OVERRUN, false);
  }
}

/* TPDOs carry the result that the tick computed from the RPDOs. */
static void report_syncs(canopen_node *node) {
  /* Bound: CANOPEN_FRAMES_PER_CALL: none is added beyond it (receive_sync). */
  for (uint32_t i = 0; i < node->sync_count; i++) {
    /* Bound: TPDO_COUNT: at most 1 + the last of them (node_objects.c). */
    for (uint32_t n = 0; n < node->tpdos_in_use; n++) {
      tpdo_sync(&node->tpdos[n], node->sync_counter[i]);
    }
  }
  node->sync_count = 0;
}

static void tick_pdos(canopen_node *node) {
  report_syncs(node);
  if (node->rpdos_changed) {
    node_objects_judge_rpdos(node);
  }
  for (uint32_t n = 0; n < RPDO_COUNT; n++) {
    if (rpdo_is_monitored(&node->rpdos[n]) && rpdo_tick(&node->rpdos[n])) {
      node_objects_judge_rpdos(node);
      if (node->config.events.rpdo_late != NULL) {
        node->config.events.rpdo_late(node->config.context, n);
      }
    }
  }
  /* Bound: TPDO_COUNT: at most 1 + the last of them (node_objects.c). */
  for (uint32_t n = 0; n < node->tpdos_in_use; n++) {
    if (tpdo_is_monitored(&node->tpdos[n])) {
      tpdo_tick(&node->tpdos[n], &node->sender);
    }
  }
}

void canopen_node_serve(canopen_node *node) {
  node->frames_taken = 0;
  lss_slave_tick(&node->lss);
  node->silent_ms += node->silent_ms < UINT32_MAX ? 1 : 0;
  sync_clock_tick(&node->clock);
  if (node->reset.pending) {
    canopen_node_answer(node); /* only LSS is processed; the queues must not overflow */
    step_reset(node);
    return;
  }
  if (nmt_allows_pdo(node->state)) {
    tick_pdos(node);
  }
  tick_producer(node);
  canopen_tick_sdo(node); /* first: a long command that begins now goes on in the next ms */
  canopen_node_answer(node);
  tick_consumers(node);
  tick_overruns(node);
  if (nmt_allows_sdo(node->state)) {
    if (sync_tick(&node->sync, &node->objects.sync)) {
      canopen_raise_or_clear(node, EMERGENCY_SYNC_TIME_OUT, true);
    }
    emergency_tick(&node->emergency, &node->objects.emergency, &node->sender);
  }
}

void canopen_node_tick(canopen_node *node) {
  canopen_node_take(node);
  canopen_node_serve(node);
}
