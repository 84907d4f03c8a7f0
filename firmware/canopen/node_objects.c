#include "canopen/node_objects.h"

#include "canopen/cob_id.h"

/* Which of the four PDO ranges an index is in. */
typedef enum { NO_PDO, RPDO_COMMUNICATION, RPDO_MAPPING, TPDO_COMMUNICATION, TPDO_MAPPING } pdo_range;

static pdo_range range_of(uint16_t index) {
  if ((index & 0xFFu) >= PDO_COUNT) {
    return NO_PDO;
  }
  switch (index & 0xFF00u) {
    case 0x1400:
      return RPDO_COMMUNICATION;
    case 0x1600:
      return RPDO_MAPPING;
    case 0x1800:
      return TPDO_COMMUNICATION;
    case 0x1A00:
      return TPDO_MAPPING;
    default:
      return NO_PDO;
  }
}

enum { SDO_REQUEST = 1, SDO_RESPONSE = 2 }; /* sub-indices of 0x1201 */

static bool same_identifier(uint32_t one, uint32_t other) { return ((one ^ other) & COB_ID_IDENTIFIER) == 0; }

static bool is_valid_and_same(uint32_t cob_id, uint32_t other) {
  return cob_id_is_valid(cob_id) && same_identifier(cob_id, other);
}

/* An identifier has one use: SYNC, SDO requests or RPDOs. */
static bool is_service(const communication_objects *objects, uint32_t cob_id) {
  return same_identifier(objects->sync.cob_id, cob_id) || is_valid_and_same(objects->sdo[1].request_cob_id, cob_id);
}

static bool is_rpdo(const communication_objects *objects, uint32_t cob_id) {
  bool found = false;
  for (uint32_t n = 0; n < PDO_COUNT; n++) {
    found = found || is_valid_and_same(objects->rpdo[n].cob_id, cob_id);
  }
  return found;
}

static od_abort accept_rpdo(const communication_objects *objects, uint8_t n, uint8_t sub, od_number value) {
  const uint8_t sub_of_cob_id = 1;
  const uint32_t cob_id = (uint32_t)value.i;
  const od_abort answer = pdo_accept_communication(&objects->rpdo[n], sub, value);
  const bool taken = sub == sub_of_cob_id && cob_id_is_valid(cob_id) && is_service(objects, cob_id);
  return answer == OD_OK && taken ? OD_INCOMPATIBLE : answer;
}

static od_abort accept_pdo(const canopen_node *node, pdo_range range, uint8_t n, uint8_t sub, od_number value) {
  const communication_objects *objects = &node->objects;
  switch (range) {
    case RPDO_COMMUNICATION:
      return accept_rpdo(objects, n, sub, value);
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
static od_abort accept_sync_cob_id(const communication_objects *objects, uint32_t value) {
  if ((value & (COB_ID_INVALID | COB_ID_NO_REMOTE)) != 0 || !cob_id_is_allowed(value)) {
    return OD_BAD_VALUE;
  }
  const bool taken = is_rpdo(objects, value) || is_valid_and_same(objects->sdo[1].request_cob_id, value);
  return taken ? OD_INCOMPATIBLE : OD_OK;
}

/* Clause 7.5.2.34: identifiers may change only while the channel is off. Bit 30 (dynamic) is not supported. */
static od_abort accept_sdo_cob_id(const communication_objects *objects, uint8_t sub, uint32_t value) {
  const bool request = sub == SDO_REQUEST;
  const uint32_t now = request ? objects->sdo[1].request_cob_id : objects->sdo[1].response_cob_id;
  const uint32_t other = request ? objects->sdo[1].response_cob_id : objects->sdo[1].request_cob_id;
  if ((value & (COB_ID_NO_REMOTE | COB_ID_EXTENDED)) != 0) {
    return OD_BAD_VALUE;
  }
  if (!cob_id_is_valid(value)) {
    return OD_OK; /* while switched off, any identifier may be set */
  }
  if (!cob_id_is_allowed(value)) {
    return OD_BAD_VALUE;
  }
  if (cob_id_is_valid(now) && !same_identifier(now, value)) {
    return OD_DEVICE_STATE;
  }
  const bool taken = request && (is_rpdo(objects, value) || same_identifier(objects->sync.cob_id, value));
  return taken || is_valid_and_same(other, value) ? OD_INCOMPATIBLE : OD_OK;
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

static od_abort accept(void *owner, const od_object *object, od_number value) {
  const canopen_node *node = owner;
  const communication_objects *objects = &node->objects;
  const uint16_t index = od_index(object);
  const uint8_t sub = object->entry->sub;
  switch (index) {
    case 0x1003:
      return value.i == 0 ? OD_OK : OD_BAD_VALUE;
    case 0x1005:
      return accept_sync_cob_id(objects, (uint32_t)value.i);
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
  bool good = accept_sync_cob_id(objects, objects->sync.cob_id) == OD_OK &&
              accept_emergency_cob_id(COB_ID_INVALID, objects->emergency.cob_id) == OD_OK &&
              accept_sync_overflow(0, (od_number){.i = objects->sync.overflow}) == OD_OK &&
              accept_sdo_cob_id(objects, SDO_REQUEST, objects->sdo[1].request_cob_id) == OD_OK &&
              accept_sdo_cob_id(objects, SDO_RESPONSE, objects->sdo[1].response_cob_id) == OD_OK;
  for (uint32_t i = 0; i < HEARTBEAT_CONSUMERS; i++) {
    good = good && accept_consumer(objects, (uint8_t)(i + 1), objects->heartbeat_consumer[i]) == OD_OK;
  }
  for (uint32_t n = 0; n < PDO_COUNT; n++) {
    good = good && pdo_is_good(dictionary, PDO_RECEIVE, &objects->rpdo[n], &objects->rpdo_mapping[n]) &&
           pdo_is_good(dictionary, PDO_TRANSMIT, &objects->tpdo[n], &objects->tpdo_mapping[n]);
  }
  return good;
}

void node_objects_judge_heartbeats(canopen_node *node) {
  bool lost = false;
  for (uint32_t i = 0; i < HEARTBEAT_CONSUMERS; i++) {
    lost = lost || node->consumers[i].health == HEARTBEAT_LOST;
  }
  if (!lost) {
    (void)canopen_node_clear(node, EMERGENCY_SOURCE_NODE, EMERGENCY_HEARTBEAT);
  }
}

enum { NO_IDENTIFIER = COB_ID_IDENTIFIER + 1 };

void node_objects_configure_rpdo(canopen_node *node, uint32_t n) {
  const pdo_communication *communication = &node->objects.rpdo[n];
  rpdo_configure(&node->rpdos[n], &node->dictionary, communication, &node->objects.rpdo_mapping[n]);
  node->listeners.rpdo[n] = node->rpdos[n].on ? communication->cob_id & COB_ID_IDENTIFIER : NO_IDENTIFIER;
}

void node_objects_configure_tpdo(canopen_node *node, uint32_t n) {
  tpdo_configure(&node->tpdos[n], &node->dictionary, &node->objects.tpdo[n], &node->objects.tpdo_mapping[n]);
}

void node_objects_configure_sync(canopen_node *node) {
  const uint32_t cob_id = node->objects.sync.cob_id;
  node->listeners.sync = cob_id_is_valid(cob_id) ? cob_id & COB_ID_IDENTIFIER : NO_IDENTIFIER;
  sync_reset(&node->sync);
}

bool node_objects_sdo_is_on(const communication_objects *objects, uint32_t channel) {
  const sdo_channel *ids = &objects->sdo[channel];
  return cob_id_is_valid(ids->request_cob_id) && cob_id_is_valid(ids->response_cob_id);
}

void node_objects_configure_sdo(canopen_node *node) {
  for (uint32_t i = 0; i < SDO_CHANNELS; i++) {
    node->listeners.sdo_request[i] = node_objects_sdo_is_on(&node->objects, i)
                                         ? node->objects.sdo[i].request_cob_id & COB_ID_IDENTIFIER
                                         : NO_IDENTIFIER;
  }
}

static void add(uint32_t *heard, uint32_t identifier) {
  if (identifier <= COB_ID_IDENTIFIER) {
    heard[identifier / 32u] |= 1u << identifier % 32u;
  }
}

void node_objects_listen(canopen_node *node) {
  uint32_t heard[CANOPEN_HEARD_WORDS] = {0};
  add(heard, NMT_COB_ID);
  add(heard, LSS_REQUEST_COB_ID);
  add(heard, node->listeners.sync);
  for (uint32_t i = 0; i < SDO_CHANNELS; i++) {
    add(heard, node->listeners.sdo_request[i]);
  }
  for (uint32_t n = 0; n < PDO_COUNT; n++) {
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
