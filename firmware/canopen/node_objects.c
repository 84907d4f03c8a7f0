/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/node_objects.h"

#include "canopen/cob_id.h"

/* Which of the four PDO ranges an index is in. */
typedef enum { NO_PDO, RPDO_COMMUNICATION, RPDO_MAPPING, TPDO_COMMUNICATION, TPDO_MAPPING } pdo_range;

static pdo_range range_of(uint16_t index) {
  const uint32_t n = (uint32_t)index & 0xFFu;
  switch (index & 0xFF00u) {
    case 0x1400:
      return n < RPDO_COUNT ? RPDO_COMMUNICATION : NO_PDO;
    case 0x1600:
      return n < RPDO_COUNT ? RPDO_MAPPING : NO_PDO;
    case 0x1800:
      return n < TPDO_COUNT ? TPDO_COMMUNICATION : NO_PDO;
    case 0x1A00:
      return n < TPDO_COUNT ? TPDO_MAPPING : NO_PDO;
    default:
      return NO_PDO;
  }
}

enum { SDO_REQUEST = 1, SDO_RESPONSE = 2 }; /* sub-indices of 0x1201 */

static bool same_identifier(uint32_t one, uint32_t other) { return ((one ^ other) & COB_ID_IDENTIFIER) == 0; }

static bool is_valid_and_same(uint32_t cob_id, uint32_t other) {
  return cob_id_is_valid(cob_id) && same_identifier(cob_id, other);
}

/* --- one identifier, one use -------------------------------------------------------------------------------------- */

/* Every COB-ID that can be set, in this order. Other services have identifiers that none of them may have
 * (heard_frames.c). */
enum { USE_SYNC, USE_SDO_REQUEST, USE_RPDO, USE_SDO_RESPONSE = USE_RPDO + RPDO_COUNT, USE_EMCY, USE_TPDO };
enum { RECEIVING_USES = USE_SDO_RESPONSE, USES = USE_TPDO + TPDO_COUNT };

/* Bit 31 of 1005 has no meaning (clause 7.5.2.5): SYNC is never off. */
static uint32_t value_of(uint32_t use, uint32_t cob_id) { return use == USE_SYNC ? cob_id & ~COB_ID_INVALID : cob_id; }

static uint32_t cob_id_of(const communication_objects *objects, uint32_t use) {
  switch (use) {
    case USE_SYNC:
      return value_of(USE_SYNC, objects->sync.cob_id);
    case USE_SDO_REQUEST:
      return objects->sdo[1].request_cob_id;
    case USE_SDO_RESPONSE:
      return objects->sdo[1].response_cob_id;
    case USE_EMCY:
      return objects->emergency.cob_id;
    default:
      return use < RECEIVING_USES ? objects->rpdo[use - USE_RPDO].cob_id : objects->tpdo[use - USE_TPDO].cob_id;
  }
}

/* Whether `cob_id`, as the COB-ID of `use`, has the identifier of another of the first `count` uses. Two RPDOs share
 * none either: what a frame may cost the tick is bounded by one RPDO, and its commands take effect together or wait
 * together. */
static bool is_taken(const communication_objects *objects, uint32_t use, uint32_t cob_id, uint32_t count) {
  bool taken = false;
  /* Bound: USES: what its callers give. */
  for (uint32_t other = 0; other < count && cob_id_is_valid(cob_id); other++) {
    taken = taken || (other != use && is_valid_and_same(cob_id_of(objects, other), cob_id));
  }
  return taken;
}

/* The use whose COB-ID this object is; USES: the object is none. */
static uint32_t use_of(uint16_t index, uint8_t sub) {
  const pdo_range range = range_of(index);
  const uint8_t n = (uint8_t)index;
  if (index == 0x1005) {
    return USE_SYNC;
  }
  if (index == 0x1014) {
    return USE_EMCY;
  }
  if (index == 0x1201) {
    return sub == SDO_REQUEST ? USE_SDO_REQUEST : USE_SDO_RESPONSE;
  }
  if (sub == 1 && (range == RPDO_COMMUNICATION || range == TPDO_COMMUNICATION)) {
    return (range == RPDO_COMMUNICATION ? (uint32_t)USE_RPDO : (uint32_t)USE_TPDO) + n;
  }
  return USES;
}

bool node_objects_receivers_collide(const communication_objects *objects) {
  bool collide = false;
  for (uint32_t use = 0; use < RECEIVING_USES; use++) {
    collide = collide || is_taken(objects, use, cob_id_of(objects, use), RECEIVING_USES);
  }
  return collide;
}

static od_abort accept_pdo(const canopen_node *node, pdo_range range, uint8_t n, uint8_t sub, od_number value) {
  const communication_objects *objects = &node->objects;
  switch (range) {
    case RPDO_COMMUNICATION:
      return pdo_accept_communication(&objects->rpdo[n], sub, value);
    case TPDO_COMMUNICATION:
      return pdo_accept_communication(&objects->tpdo[n], sub, value);
    case RPDO_MAPPING:
      return pdo_accept_mapping(&node->dictionary, PDO_RECEIVE, &objects->rpdo[n], &objects->rpdo_mapping[n], sub,
                                value);
    case TPDO_MAPPING:
      return pdo_accept_mapping(&node->dictionary, PDO_TRANSMIT, &objects->tpdo[n], &objects->tpdo_mapping[n], sub,
                                value);
    case NO_PDO:
      break;
  }
  return OD_OK;
}

static od_abort accept_consumer(const communication_objects *objects, uint8_t sub, uint32_t value) {
  const uint8_t monitored = heartbeat_consumer_node(value);
  for (uint32_t i = 0; i < HEARTBEAT_CONSUMERS; i++) {
    const uint32_t other = objects->heartbeat_consumer[i];
    if (i + 1 != sub && heartbeat_consumer_active(value) && heartbeat_consumer_active(other) &&
        heartbeat_consumer_node(other) == monitored) {
      return OD_INCOMPATIBLE;
    }
  }
  return OD_OK;
}

/* Bit 30 of 0x1005 requests a SYNC producer, which this node does not have. */
static od_abort accept_sync_cob_id(uint32_t value) {
  const bool producer = (value & COB_ID_NO_REMOTE) != 0;
  return producer || !cob_id_is_allowed(value) ? OD_BAD_VALUE : OD_OK;
}

/* Clause 7.5.2.34: identifiers may change only while the channel is off. Bit 30 (dynamic) is not supported. */
static od_abort accept_sdo_cob_id(const communication_objects *objects, uint8_t sub, uint32_t value) {
  const bool request = sub == SDO_REQUEST;
  const uint32_t now = request ? objects->sdo[1].request_cob_id : objects->sdo[1].response_cob_id;
  if ((value & (COB_ID_NO_REMOTE | COB_ID_EXTENDED)) != 0) {
    return OD_BAD_VALUE;
  }
  if (!cob_id_is_valid(value)) {
    return OD_OK; /* while switched off, any identifier may be set */
  }
  if (!cob_id_is_allowed(value)) {
    return OD_BAD_VALUE;
  }
  return cob_id_is_valid(now) && !same_identifier(now, value) ? OD_DEVICE_STATE : OD_OK;
}

static od_abort accept_emergency_cob_id(uint32_t now, uint32_t value) {
  if (!cob_id_is_allowed(value) || (value & COB_ID_NO_REMOTE) != 0) {
    return OD_BAD_VALUE;
  }
  const bool moves = (now & COB_ID_IDENTIFIER) != (value & COB_ID_IDENTIFIER);
  return cob_id_is_valid(now) && cob_id_is_valid(value) && moves ? OD_DEVICE_STATE : OD_OK;
}

/* 0x1019 is 0 or at least 2, and may be set only while no period is set (clause 7.5.2.22). */
static od_abort accept_sync_overflow(uint32_t period_us, od_number value) {
  if (value.i == 1) {
    return OD_BAD_VALUE;
  }
  return period_us != 0 ? OD_DEVICE_STATE : OD_OK;
}

static od_abort accept_value(const canopen_node *node, uint16_t index, uint8_t sub, od_number value) {
  const communication_objects *objects = &node->objects;
  switch (index) {
    case 0x1003:
      return value.i == 0 ? OD_OK : OD_BAD_VALUE;
    case 0x1005:
      return accept_sync_cob_id((uint32_t)value.i);
    case 0x1010:
    case 0x1011:
      return storage_accept(index == 0x1010, (uint32_t)value.i);
    case 0x1014:
      return accept_emergency_cob_id(objects->emergency.cob_id, (uint32_t)value.i);
    case 0x1016:
      return accept_consumer(objects, sub, (uint32_t)value.i);
    case 0x1019:
      return accept_sync_overflow(objects->sync.period_us, value);
    case 0x1201:
      return accept_sdo_cob_id(objects, sub, (uint32_t)value.i);
    default:
      return accept_pdo(node, range_of(index), (uint8_t)index, sub, value);
  }
}

static od_abort accept(void *owner, const od_object *object, od_number value) {
  const canopen_node *node = owner;
  const uint16_t index = od_index(object);
  const uint8_t sub = object->entry->sub;
  const od_abort answer = accept_value(node, index, sub, value);
  const uint32_t use = use_of(index, sub);
  const bool taken = use < USES && is_taken(&node->objects, use, value_of(use, (uint32_t)value.i), USES);
  return answer == OD_OK && taken ? OD_INCOMPATIBLE : answer;
}

/* No PDO reaches these: the store may answer "pending". */
static od_abort execute(void *owner, const od_object *object, od_number value) {
  (void)value;
  const canopen_node *node = owner;
  const uint16_t index = od_index(object);
  return index == 0x1010 || index == 0x1011
             ? storage_execute(&node->config.storage, index == 0x1010, object->entry->sub)
             : OD_OK;
}

/* As if it were switched off, and therefore free to change. */
static bool pdo_is_good(const object_dictionary *dictionary, pdo_direction direction,
                        const pdo_communication *communication, const pdo_mapping *mapping) {
  const pdo_communication off = {.cob_id = COB_ID_INVALID};
  pdo_map map;
  return pdo_accept_communication(&off, 1, (od_number){.i = communication->cob_id}) == OD_OK &&
         pdo_accept_communication(&off, 2, (od_number){.i = communication->type}) == OD_OK &&
         pdo_resolve(dictionary, direction, mapping, &map) == OD_OK;
}

bool node_objects_are_good(const object_dictionary *dictionary, const communication_objects *objects) {
  bool good = !node_objects_receivers_collide(objects) && accept_sync_cob_id(objects->sync.cob_id) == OD_OK &&
              accept_emergency_cob_id(COB_ID_INVALID, objects->emergency.cob_id) == OD_OK &&
              accept_sync_overflow(0, (od_number){.i = objects->sync.overflow}) == OD_OK &&
              accept_sdo_cob_id(objects, SDO_REQUEST, objects->sdo[1].request_cob_id) == OD_OK &&
              accept_sdo_cob_id(objects, SDO_RESPONSE, objects->sdo[1].response_cob_id) == OD_OK;
  for (uint32_t i = 0; i < HEARTBEAT_CONSUMERS; i++) {
    good = good && accept_consumer(objects, (uint8_t)(i + 1), objects->heartbeat_consumer[i]) == OD_OK;
  }
  for (uint32_t n = 0; n < RPDO_COUNT; n++) {
    good = good && pdo_is_good(dictionary, PDO_RECEIVE, &objects->rpdo[n], &objects->rpdo_mapping[n]);
  }
  for (uint32_t n = 0; n < TPDO_COUNT; n++) {
    good = good && pdo_is_good(dictionary, PDO_TRANSMIT, &objects->tpdo[n], &objects->tpdo_mapping[n]);
  }
  return good;
}

static void clear(canopen_node *node, uint16_t code) {
  (void)emergency_clear(&node->emergency, &node->objects.emergency, EMERGENCY_SOURCE_NODE, code);
}

void node_objects_judge_heartbeats(canopen_node *node) {
  bool lost = false;
  for (uint32_t i = 0; i < HEARTBEAT_CONSUMERS; i++) {
    lost = lost || node->consumers[i].health == HEARTBEAT_LOST;
  }
  if (!lost) {
    clear(node, EMERGENCY_HEARTBEAT);
  }
}

/* With its details, or no longer. */
static void report(canopen_node *node, const emergency_error *error, bool active) {
  if (active) {
    (void)emergency_raise(&node->emergency, &node->objects.emergency, error);
  } else {
    clear(node, error->code);
  }
}

void node_objects_judge_rpdos(canopen_node *node) {
  bool short_one = false;
  bool late_one = false;
  uint32_t refused_object = 0;
  uint32_t refusing = RPDO_COUNT;
  node->rpdos_changed = false;
  for (uint32_t n = 0; n < RPDO_COUNT; n++) {
    rpdo *judged = &node->rpdos[n];
    const rpdo_errors errors = rpdo_take_errors(judged);
    node->rpdos_changed = node->rpdos_changed || errors.short_one != judged->wrong_length ||
                          errors.refused_object != judged->refused_object; /* the next ms tells of its end */
    short_one = short_one || errors.short_one;
    late_one = late_one || judged->late;
    if (refusing == RPDO_COUNT && errors.refused_object != 0) {
      refusing = n;
      refused_object = errors.refused_object;
    }
  }
  const bool refused = refusing < RPDO_COUNT;
  const emergency_error too_short = {.code = EMERGENCY_PDO_LENGTH, .register_bits = ERROR_COMMUNICATION};
  const emergency_error late = {.code = EMERGENCY_RPDO_TIME_OUT, .register_bits = ERROR_COMMUNICATION};
  const emergency_error value = {.code = EMERGENCY_PDO_REFUSED,
                                 .register_bits = ERROR_COMMUNICATION,
                                 .detail = (uint8_t)(refusing + 1),
                                 .object = refused_object};
  report(node, &too_short, short_one);
  report(node, &late, late_one);
  report(node, &value, refused);
}

enum { NO_IDENTIFIER = COB_ID_IDENTIFIER + 1 };

void node_objects_configure_rpdo(canopen_node *node, uint32_t n) {
  const pdo_communication *communication = &node->objects.rpdo[n];
  rpdo_configure(&node->rpdos[n], &node->dictionary, communication, &node->objects.rpdo_mapping[n]);
  node->listeners.rpdo[n] = node->rpdos[n].on ? communication->cob_id & COB_ID_IDENTIFIER : NO_IDENTIFIER;
  node_objects_judge_rpdos(node);
}

void node_objects_configure_tpdo(canopen_node *node, uint32_t n) {
  tpdo_configure(&node->tpdos[n], &node->dictionary, &node->objects.tpdo[n], &node->objects.tpdo_mapping[n]);
  node->tpdos_in_use = 0;
  for (uint32_t i = 0; i < TPDO_COUNT; i++) {
    node->tpdos_in_use = node->tpdos[i].on ? i + 1 : node->tpdos_in_use;
  }
}

void node_objects_configure_sync(canopen_node *node) {
  node->listeners.sync = node->objects.sync.cob_id & COB_ID_IDENTIFIER;
  sync_reset(&node->sync);
  sync_clock_reset(&node->clock);
  clear(node, EMERGENCY_SYNC_CLOCK);
}

static bool sdo_is_on(const communication_objects *objects, uint32_t channel) {
  const sdo_channel *ids = &objects->sdo[channel];
  return cob_id_is_valid(ids->request_cob_id) && cob_id_is_valid(ids->response_cob_id);
}

void node_objects_configure_sdo(canopen_node *node) {
  for (uint32_t i = 0; i < SDO_CHANNELS; i++) {
    node->listeners.sdo_request[i] =
        sdo_is_on(&node->objects, i) ? node->objects.sdo[i].request_cob_id & COB_ID_IDENTIFIER : NO_IDENTIFIER;
  }
}

static void add(uint32_t *heard, uint32_t identifier) {
  if (identifier <= COB_ID_IDENTIFIER) {
    heard[identifier / 32u] |= 1u << identifier % 32u;
  }
}

void node_objects_listen(canopen_node *node) {
  node->sync_is_used = false;
  for (uint32_t n = 0; n < RPDO_COUNT; n++) {
    node->sync_is_used = node->sync_is_used || (node->rpdos[n].on && node->rpdos[n].synchronous);
  }
  /* Bound: TPDO_COUNT: at most 1 + the last of them. */
  for (uint32_t n = 0; n < node->tpdos_in_use; n++) {
    node->sync_is_used = node->sync_is_used || (node->tpdos[n].on && node->tpdos[n].synchronous);
  }
  uint32_t heard[CANOPEN_HEARD_WORDS] = {0};
  add(heard, NMT_COB_ID);
  add(heard, LSS_REQUEST_COB_ID);
  add(heard, node->listeners.sync);
  for (uint32_t i = 0; i < SDO_CHANNELS; i++) {
    add(heard, node->listeners.sdo_request[i]);
  }
  for (uint32_t n = 0; n < RPDO_COUNT; n++) {
    add(heard, node->listeners.rpdo[n]);
  }
  for (uint32_t i = 0; i < HEARTBEAT_CONSUMERS; i++) {
    const uint32_t object = node->objects.heartbeat_consumer[i];
    add(heard, heartbeat_consumer_active(object) ? (uint32_t)HEARTBEAT_COB_ID + heartbeat_consumer_node(object)
                                                 : NO_IDENTIFIER);
  }
  for (uint32_t i = 0; i < CANOPEN_HEARD_WORDS; i++) { /* the interrupt reads one word: any order will do */
    atomic_store_explicit(&node->heard[i], heard[i], memory_order_relaxed);
  }
}

static void pdo_changed(canopen_node *node, pdo_range range, uint8_t n) {
  if (range == RPDO_COMMUNICATION || range == RPDO_MAPPING) {
    node_objects_configure_rpdo(node, n);
  } else if (range == TPDO_COMMUNICATION || range == TPDO_MAPPING) {
    node_objects_configure_tpdo(node, n);
  }
}

static void changed(void *owner, const od_object *object) {
  canopen_node *node = owner;
  const uint16_t index = od_index(object);
  const uint8_t sub = object->entry->sub;
  switch (index) {
    case 0x1005:
    case 0x1006:
    case 0x1019:
      node_objects_configure_sync(node);
      break;
    case 0x1201:
      node_objects_configure_sdo(node);
      break;
    case 0x1010:
      node->objects.save[sub - 1] = STORAGE_ON_COMMAND;
      break;
    case 0x1011:
      node->objects.restore[sub - 1] = STORAGE_ON_COMMAND;
      break;
    case 0x1016:
      heartbeat_consumer_reset(&node->consumers[sub - 1]);
      node_objects_judge_heartbeats(node);
      break;
    default:
      pdo_changed(node, range_of(index), (uint8_t)index);
      break;
  }
  node_objects_listen(node);
}

static od_abort refresh(void *owner, const od_object *object) {
  const canopen_node *node = owner;
  const bool beyond = object->entry->index == 0x1003 && object->entry->sub > node->objects.emergency.count;
  return beyond ? OD_NO_DATA : OD_OK;
}

const od_hooks node_objects_hooks = {.refresh = refresh, .accept = accept, .execute = execute, .changed = changed};
