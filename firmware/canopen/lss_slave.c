/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/lss_slave.h"

/* First byte of requests and answers. */
enum {
  SWITCH_GLOBAL = 0x04,
  CONFIGURE_NODE_ID = 0x11,
  CONFIGURE_BIT_RATE = 0x13,
  ACTIVATE_BIT_RATE = 0x15,
  STORE = 0x17,
  SWITCH_SELECTIVE = 0x40, /* this code and the next three */
  SWITCHED = 0x44,
  IDENTIFY = 0x46, /* this code and the next five */
  IDENTIFY_UNCONFIGURED = 0x4C,
  IDENTIFIED = 0x4F,
  IDENTIFIED_UNCONFIGURED = 0x50,
  FASTSCAN = 0x51,
  INQUIRE_IDENTITY = 0x5A, /* this code and the next three */
  INQUIRE_NODE_ID = 0x5E
};

enum { FASTSCAN_BEGIN = 0x80, IDENTIFY_STEPS = 6, STANDARD_TABLE = 0, NUMBER_BITS = 32 };

enum { ALL_PARTS = (1 << LSS_IDENTITY_PARTS) - 1 };

/* Parts of the identity. */
enum { REVISION = 2, SERIAL = 3 };

void lss_slave_init(lss_slave *slave, const bus_settings *active, const lss_callbacks *callbacks) {
  *slave = (lss_slave){.callbacks = *callbacks, .active = *active, .pending = *active};
}

void lss_slave_identify(lss_slave *slave, const uint32_t identity[LSS_IDENTITY_PARTS]) {
  memcpy(slave->identity, identity, sizeof slave->identity);
}

void lss_slave_take_node_id(lss_slave *slave) { slave->active.node_id = slave->pending.node_id; }

/* --- answers ------------------------------------------------------------------------------------------------------ */

static void answer(lss_slave *slave, uint8_t command) {
  memset(slave->answer, 0, sizeof slave->answer);
  slave->answer[0] = command;
  slave->answer_waiting = true;
}

static void answer_error(lss_slave *slave, uint8_t command, uint8_t error, uint8_t detail) {
  answer(slave, command);
  slave->answer[1] = error;
  slave->answer[2] = detail;
}

static void answer_number(lss_slave *slave, uint8_t command, uint32_t number) {
  answer(slave, command);
  memcpy(&slave->answer[1], &number, sizeof number); /* little-endian; object_dictionary.c asserts this */
}

const uint8_t *lss_slave_outgoing(const lss_slave *slave) { return slave->answer_waiting ? slave->answer : NULL; }

void lss_slave_sent(lss_slave *slave) { slave->answer_waiting = false; }

/* --- configuration state ------------------------------------------------------------------------------------------ */

static bool has_torque(const lss_slave *slave) {
  return slave->callbacks.has_torque != NULL && slave->callbacks.has_torque(slave->callbacks.context);
}

static void configure_node_id(lss_slave *slave, uint8_t node_id) {
  const bool good = bus_node_id_is_good(node_id);
  slave->pending.node_id = good ? node_id : slave->pending.node_id;
  answer_error(slave, CONFIGURE_NODE_ID, good ? LSS_OK : LSS_OUT_OF_RANGE, 0);
}

static void configure_bit_rate(lss_slave *slave, uint8_t table, uint8_t index) {
  const uint16_t kbit_s = table == STANDARD_TABLE ? bus_kbit_s_of_index(index) : 0;
  slave->pending.kbit_s = kbit_s != 0 ? kbit_s : slave->pending.kbit_s;
  answer_error(slave, CONFIGURE_BIT_RATE, kbit_s != 0 ? LSS_OK : LSS_OUT_OF_RANGE, 0);
}

static void step_store(lss_slave *slave) {
  if (slave->callbacks.store == NULL) {
    answer_error(slave, STORE, LSS_STORE_UNSUPPORTED, 0);
    return;
  }
  const lss_store_progress progress = slave->callbacks.store(slave->callbacks.context, &slave->pending);
  slave->storing = progress == LSS_STORE_PENDING;
  if (!slave->storing) {
    answer_error(slave, STORE, progress == LSS_STORE_DONE ? LSS_OK : LSS_STORE_FAILED, 0);
  }
}

/* Services that change something. */
static void change(lss_slave *slave, const uint8_t *request) {
  if (has_torque(slave)) {
    answer_error(slave, request[0], LSS_SEE_DETAIL, LSS_DETAIL_TORQUE);
    return;
  }
  switch (request[0]) {
    case CONFIGURE_NODE_ID:
      configure_node_id(slave, request[1]);
      break;
    case CONFIGURE_BIT_RATE:
      configure_bit_rate(slave, request[1], request[2]);
      break;
    default:
      step_store(slave);
      break;
  }
}

static void activate(lss_slave *slave, uint16_t delay_ms) {
  if (slave->callbacks.activate != NULL && !has_torque(slave)) {
    slave->change = LSS_BEFORE_CHANGE;
    slave->delay_ms = delay_ms;
    slave->left_ms = delay_ms;
  }
}

static void configure(lss_slave *slave, const uint8_t *request) {
  switch (request[0]) {
    case CONFIGURE_NODE_ID:
    case CONFIGURE_BIT_RATE:
    case STORE:
      change(slave, request);
      break;
    case ACTIVATE_BIT_RATE:
      activate(slave, (uint16_t)(request[1] | request[2] << 8));
      break;
    case INQUIRE_NODE_ID:
      answer(slave, INQUIRE_NODE_ID);
      slave->answer[1] = slave->active.node_id;
      break;
    default:
      if (request[0] >= INQUIRE_IDENTITY && request[0] < INQUIRE_IDENTITY + LSS_IDENTITY_PARTS) {
        answer_number(slave, request[0], slave->identity[request[0] - INQUIRE_IDENTITY]);
      }
      break;
  }
}

/* --- finding nodes ------------------------------------------------------------------------------------------------ */

/* The parts come in order; a part that does not match this node starts over. Returns how many matched. */
static uint8_t next_part(uint8_t right_so_far, uint8_t part, bool right) {
  if (!right || (part != right_so_far && part != 0)) {
    return 0;
  }
  return (uint8_t)(part + 1);
}

static void switch_selective(lss_slave *slave, uint8_t part, uint32_t number) {
  slave->selected = next_part(slave->selected, part, number == slave->identity[part]);
  if (slave->selected == LSS_IDENTITY_PARTS) {
    slave->selected = 0;
    slave->configuring = true;
    answer(slave, SWITCHED);
  }
}

static bool is_in_range(const lss_slave *slave, uint8_t step, uint32_t number) {
  switch (step) {
    case 2:
      return slave->identity[REVISION] >= number;
    case 3:
      return slave->identity[REVISION] <= number;
    case 4:
      return slave->identity[SERIAL] >= number;
    case 5:
      return slave->identity[SERIAL] <= number;
    default:
      return slave->identity[step] == number;
  }
}

static void identify(lss_slave *slave, uint8_t step, uint32_t number) {
  slave->identified = next_part(slave->identified, step, is_in_range(slave, step, number));
  if (slave->identified == IDENTIFY_STEPS) {
    slave->identified = 0;
    answer(slave, IDENTIFIED);
  }
}

static bool wants_node_id(const lss_slave *slave) {
  return lss_slave_is_unconfigured(slave) && slave->pending.node_id == BUS_UNCONFIGURED;
}

/* The master asks bit by bit, from the highest bit of each part down; no answer means that the bit is 1. The last bit
 * of the last part leaves one node, which is switched to the configuration state: the next part is then no later
 * one, and all four have matched. */
static void fastscan(lss_slave *slave, const uint8_t *request, uint32_t number) {
  const uint8_t bit = request[5];
  const uint8_t part = request[6];
  const uint8_t next = request[7];
  if (slave->configuring || !wants_node_id(slave)) {
    return;
  }
  if (bit == FASTSCAN_BEGIN) {
    slave->scanned = 0;
    slave->compared = 0;
    answer(slave, IDENTIFIED);
    return;
  }
  if (bit >= NUMBER_BITS || part >= LSS_IDENTITY_PARTS || next >= LSS_IDENTITY_PARTS || part != slave->scanned ||
      (slave->identity[part] ^ number) >> bit != 0) {
    return;
  }
  if (bit == 0) {
    slave->scanned = next;
    slave->compared = (uint8_t)(slave->compared | 1u << part);
    slave->configuring = next < part && slave->compared == ALL_PARTS;
  }
  answer(slave, IDENTIFIED);
}

/* --- states ------------------------------------------------------------------------------------------------------- */

/* True: the node has received its first node id. */
static bool switch_global(lss_slave *slave, uint8_t state) {
  const bool leaves = slave->configuring && state == 0;
  if (state <= 1) {
    slave->configuring = state == 1;
  }
  return leaves && lss_slave_is_unconfigured(slave) && !wants_node_id(slave);
}

bool lss_slave_receive(lss_slave *slave, const uint8_t request[LSS_BYTES]) {
  const uint8_t command = request[0];
  uint32_t number = 0;
  memcpy(&number, &request[1], sizeof number);
  if (slave->storing) {
    return false; /* the master has to receive an answer */
  }
  if (command == SWITCH_GLOBAL) {
    return switch_global(slave, request[1]);
  }
  if (command >= SWITCH_SELECTIVE && command < SWITCH_SELECTIVE + LSS_IDENTITY_PARTS) {
    switch_selective(slave, (uint8_t)(command - SWITCH_SELECTIVE), number);
  } else if (command >= IDENTIFY && command < IDENTIFY + IDENTIFY_STEPS) {
    identify(slave, (uint8_t)(command - IDENTIFY), number);
  } else if (command == IDENTIFY_UNCONFIGURED) {
    if (wants_node_id(slave)) {
      answer(slave, IDENTIFIED_UNCONFIGURED);
    }
  } else if (command == FASTSCAN) {
    fastscan(slave, request, number);
  } else if (slave->configuring) {
    configure(slave, request);
  }
  return false;
}

/* --- time --------------------------------------------------------------------------------------------------------- */

static void change_bit_rate(lss_slave *slave) {
  slave->active.kbit_s = slave->pending.kbit_s;
  slave->callbacks.activate(slave->callbacks.context, slave->active.kbit_s);
  slave->change = LSS_AFTER_CHANGE;
  slave->left_ms = slave->delay_ms;
}

/* An axis that a command before the silence has enabled needs a node that answers. */
static void end_silence_with_torque(lss_slave *slave) {
  if (slave->change != LSS_NO_CHANGE && has_torque(slave)) {
    slave->change = LSS_NO_CHANGE;
  }
}

void lss_slave_tick(lss_slave *slave) {
  if (slave->storing) {
    step_store(slave);
  }
  end_silence_with_torque(slave);
  if (slave->change != LSS_NO_CHANGE && slave->left_ms > 0) {
    slave->left_ms--;
    return;
  }
  if (slave->change == LSS_BEFORE_CHANGE) {
    change_bit_rate(slave);
  } else {
    slave->change = LSS_NO_CHANGE;
  }
}
