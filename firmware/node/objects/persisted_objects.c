/* SPDX-License-Identifier: Apache-2.0 */
#include "node/objects/persisted_objects.h"

#include "canopen/node_objects.h"
#include "canopen/object_dictionary_rows.h"
#include "canopen/storage.h"
#include "drive/drive_state.h"
#include "drive/homing.h"
#include "drive/setpoint_queue.h"
#include "node/objects/base_objects.h"
#include "node/objects/board_objects.h"
#include "node/objects/camera_objects.h"
#include "node/objects/device_dictionary.h"
#include "node/objects/drive_dictionary.h"
#include "node/objects/master_objects.h"
#include "node/objects/protection_objects.h"
#include "parameters/axis_dictionary.h"
#include "parameters/axis_tuning.h"

enum { FIRST_APPLICATION_INDEX = 0x2000, BUS_INDEX = 0x3050, ACCESS_INDEX = 0x3042, TABLES = 8 + 3 * SERVO_AXES };

_Static_assert(offsetof(axis_tuning, staged) == 0,
               "rows of gains are read in an axis_parameters, not in its axis_tuning");

/* Node id and bit rate in effect, for which the values of the set are valid. */
static const od_entry bus_rows[] = {
    OD_U8(BUS_INDEX, 1, OD_RW, OD_STORED, persisted_objects, bus.node_id, 1, BUS_LAST_NODE_ID, BUS_DEFAULT_NODE_ID, "",
          "Node id", ""),
    OD_U16(BUS_INDEX, 2, OD_RW, OD_STORED, persisted_objects, bus.kbit_s, 1, UINT16_MAX, BUS_DEFAULT_KBIT_S, "kbit/s",
           "Bit rate", ""),
};
static const od_table bus_table = {bus_rows, sizeof bus_rows / sizeof bus_rows[0]};

/* The hash of the owner's word. No object of the node has this index, so none shows it. */
static const od_entry access_rows[] = {
    OD_U32(ACCESS_INDEX, 1, OD_RW, OD_STORED, persisted_objects, access_hash[0], 0, INT64_C(0xFFFFFFFF), 0, "",
           "Hash, low word", ""),
    OD_U32(ACCESS_INDEX, 2, OD_RW, OD_STORED, persisted_objects, access_hash[1], 0, INT64_C(0xFFFFFFFF), 0, "",
           "Hash, high word", ""),
};
static const od_table access_table = {access_rows, sizeof access_rows / sizeof access_rows[0]};

uint8_t retained_groups(uint8_t group) {
  switch (group) {
    case STORAGE_COMMUNICATION:
      return PERSISTED_COMMUNICATION;
    case STORAGE_APPLICATION:
      return PERSISTED_APPLICATION;
    default:
      return PERSISTED_COMMUNICATION | PERSISTED_APPLICATION;
  }
}

void persisted_communication_copy(communication_objects *to, const communication_objects *from) {
  od_copy_stored(&communication_profile_table, from, to);
  od_copy_stored(&device_table, from, to);
}

void persisted_communication_follow(communication_objects *objects, const bus_settings *from, const bus_settings *to) {
  bus_defaults_follow(&communication_profile_table, objects, from, to);
  bus_defaults_follow(&device_table, objects, from, to);
}

void persisted_objects_copy(persisted_objects *to, const persisted_objects *from, uint8_t groups) {
  if ((groups & PERSISTED_COMMUNICATION) != 0) {
    persisted_communication_copy(&to->communication, &from->communication);
    to->bus = from->bus;
  }
  if ((groups & PERSISTED_APPLICATION) != 0) {
    for (int i = 0; i < SERVO_AXES; ++i) {
      to->parameters[i] = from->parameters[i];
      od_copy_stored(&drive_objects_table, &from->drive[i], &to->drive[i]);
      to->protection[i] = from->protection[i];
    }
    to->scales = from->scales;
    od_copy_stored(&master_objects_table, &from->master, &to->master);
    od_copy_stored(&camera_objects_table, &from->camera, &to->camera);
    od_copy_stored(&base_objects_table, &from->base, &to->base);
  }
}

bool persisted_objects_are_same(const persisted_objects *kept, const persisted_objects *other, uint8_t groups) {
  const communication_objects *own = &kept->communication;
  bool same = (groups & PERSISTED_COMMUNICATION) == 0 ||
              (od_same_stored(&communication_profile_table, own, &other->communication) &&
               od_same_stored(&device_table, own, &other->communication));
  same = same && ((groups & PERSISTED_APPLICATION) == 0 ||
                  (od_same_stored(&board_objects_table, &kept->scales, &other->scales) &&
                   od_same_stored(&master_objects_table, &kept->master, &other->master) &&
                   od_same_stored(&camera_objects_table, &kept->camera, &other->camera) &&
                   od_same_stored(&base_objects_table, &kept->base, &other->base)));
  for (int i = 0; i < SERVO_AXES && (groups & PERSISTED_APPLICATION) != 0; ++i) {
    same = same && od_same_stored(&axis_parameters_table, &kept->parameters[i], &other->parameters[i]) &&
           od_same_stored(&drive_objects_table, &kept->drive[i], &other->drive[i]) &&
           od_same_stored(&protection_objects_table, &kept->protection[i], &other->protection[i]);
  }
  return same;
}

bool persisted_objects_same_guarded(const persisted_objects *one, const persisted_objects *other) {
  bool same = od_same_guarded(&board_objects_table, &one->scales, &other->scales);
  for (int i = 0; i < SERVO_AXES; ++i) {
    same = same && od_same_guarded(&axis_parameters_table, &one->parameters[i], &other->parameters[i]) &&
           od_same_guarded(&drive_objects_table, &one->drive[i], &other->drive[i]) &&
           od_same_guarded(&protection_objects_table, &one->protection[i], &other->protection[i]);
  }
  return same;
}

/* --- rows ------------------------------------------------------------------------------------------------------- */

/* A dictionary of the persisted objects only, without hooks: a write to it only stores the value. */
static object_dictionary view_of(persisted_objects *kept, od_part parts[TABLES]) {
  uint32_t count = 0;
  parts[count++] = (od_part){.table = bus_table, .values = kept};
  parts[count++] = (od_part){.table = communication_profile_table, .values = &kept->communication};
  parts[count++] = (od_part){.table = device_table, .values = &kept->communication};
  for (int i = 0; i < SERVO_AXES; ++i) {
    const uint16_t shift = (uint16_t)(i * AXIS_INDEX_SHIFT);
    parts[count++] = (od_part){.table = axis_parameters_table, .shift = shift, .values = &kept->parameters[i]};
    parts[count++] = (od_part){.table = protection_objects_table, .shift = shift, .values = &kept->protection[i]};
    parts[count++] = (od_part){.table = drive_objects_table, .shift = shift, .values = &kept->drive[i]};
  }
  parts[count++] = (od_part){.table = board_objects_table, .values = &kept->scales};
  parts[count++] = (od_part){.table = master_objects_table, .values = &kept->master};
  parts[count++] = (od_part){.table = camera_objects_table, .values = &kept->camera};
  parts[count++] = (od_part){.table = base_objects_table, .values = &kept->base};
  parts[count++] = (od_part){.table = access_table, .values = kept};
  return (object_dictionary){.parts = parts, .count = count};
}

static uint8_t group_of(uint16_t index) {
  if (index == ACCESS_INDEX) {
    return PERSISTED_ACCESS;
  }
  return index < FIRST_APPLICATION_INDEX || index == BUS_INDEX ? PERSISTED_COMMUNICATION : PERSISTED_APPLICATION;
}

static bool is_kept(const od_object *object, uint8_t groups) {
  return (object->entry->flags & OD_STORED) != 0 && (group_of(od_index(object)) & groups) != 0;
}

static uint32_t row_id(const od_object *object) {
  return (uint32_t)od_index(object) << 16 | (uint32_t)object->entry->sub << 8 | object->entry->type;
}

static bool row_of(const od_object *object, parameter_row *row) {
  uint16_t length = 0;
  uint8_t bytes[sizeof row->value] = {0};
  *row = (parameter_row){.id = row_id(object)};
  if (od_read(object, bytes, sizeof bytes, &length) != OD_OK) {
    return false;
  }
  row->value = (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
  return true;
}

/* Iterates over the persisted objects of some groups. */
typedef struct {
  uint32_t part;
  uint32_t entry; /* next object */
} persisted_walk;

/* False at the end. */
static bool next_kept(const object_dictionary *view, uint8_t groups, persisted_walk *walk, od_object *object) {
  /* Bound: TABLES: the parts that are kept, all counted there. */
  for (; walk->part < view->count; ++walk->part, walk->entry = 0) {
    const od_part *part = &view->parts[walk->part];
    /* Bound: rows of a table, which is constant. */
    while (walk->entry < part->table.count) {
      *object = (od_object){part, &part->table.entries[walk->entry++]};
      if (is_kept(object, groups)) {
        return true;
      }
    }
  }
  return false;
}

uint32_t persisted_objects_to_rows(persisted_objects *kept, uint8_t groups, parameter_row *rows, uint32_t capacity) {
  od_part parts[TABLES];
  const object_dictionary view = view_of(kept, parts);
  persisted_walk walk = {.part = 0};
  od_object object;
  uint32_t count = 0;
  /* Bound: objects of those tables: the walk goes forward only. */
  while (next_kept(&view, groups, &walk, &object)) {
    if (count == capacity || !row_of(&object, &rows[count])) {
      return UINT32_MAX;
    }
    ++count;
  }
  return count;
}

static uint32_t count_kept(const object_dictionary *view, uint8_t groups) {
  persisted_walk walk = {.part = 0};
  od_object object;
  uint32_t count = 0;
  /* Bound: objects of those tables: the walk goes forward only. */
  while (next_kept(view, groups, &walk, &object)) {
    ++count;
  }
  return count;
}

static od_abort put_row(const od_object *object, const parameter_row *row) {
  const uint8_t bytes[] = {(uint8_t)row->value, (uint8_t)(row->value >> 8), (uint8_t)(row->value >> 16),
                           (uint8_t)(row->value >> 24)};
  const uint16_t size = object->entry->bytes;
  return size > sizeof bytes ? OD_TOO_LONG : od_write(object, bytes, size);
}

/* Node id and bit rate under which the rows were saved. Sets of versions that could not change them have no rows for
 * it. */
static bus_settings saved_under(const parameter_row *rows, uint32_t count) {
  bus_settings bus = {.node_id = BUS_DEFAULT_NODE_ID, .kbit_s = BUS_DEFAULT_KBIT_S};
  /* Bound: rows of a parameter set: PERSISTED_MAX_ROWS, checked when it is loaded. */
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t place = rows[i].id >> 8;
    if (place == (BUS_INDEX << 8 | 1)) {
      bus.node_id = (uint8_t)rows[i].value;
    } else if (place == (BUS_INDEX << 8 | 2)) {
      bus.kbit_s = (uint16_t)rows[i].value;
    }
  }
  return bus;
}

static bool is_good(const bus_settings *bus) {
  return bus->node_id >= 1 && bus->node_id <= BUS_LAST_NODE_ID &&
         bus_kbit_s_of_index(bus_index_of_kbit_s(bus->kbit_s)) != 0;
}

/* Objects without a row keep their defaults: those for the node id and bit rate of the other rows. */
static bool follow_rows(persisted_objects *kept, const parameter_row *rows, uint32_t count) {
  const bus_settings bus = saved_under(rows, count);
  if (!is_good(&bus)) {
    return false;
  }
  persisted_communication_follow(&kept->communication, &kept->bus, &bus);
  kept->bus = bus;
  return true;
}

bool persisted_objects_from_rows(persisted_objects *kept, const parameter_row *rows, uint32_t count,
                                 persisted_rows_report *report) {
  const uint8_t all = PERSISTED_COMMUNICATION | PERSISTED_APPLICATION | PERSISTED_ACCESS;
  od_part parts[TABLES];
  const object_dictionary view = view_of(kept, parts);
  *report = (persisted_rows_report){.groups = 0};
  if (!follow_rows(kept, rows, count)) {
    return false;
  }
  /* Bound: rows of a parameter set: PERSISTED_MAX_ROWS, checked when it is loaded. */
  for (uint32_t i = 0; i < count; ++i) {
    const uint16_t index = (uint16_t)(rows[i].id >> 16);
    od_object object;
    report->groups |= group_of(index);
    if (od_find(&view, index, (uint8_t)(rows[i].id >> 8), &object) != OD_OK || !is_kept(&object, all) ||
        row_id(&object) != rows[i].id) {
      report->dropped++;
    } else if (put_row(&object, &rows[i]) != OD_OK) {
      return false;
    }
  }
  const uint32_t expected = count_kept(&view, report->groups);
  const uint32_t taken = count - report->dropped;
  report->missing = expected > taken ? expected - taken : 0;
  return true;
}

/* --- checks ----------------------------------------------------------------------------------------------------- */

static bool options_are_good(const drive_options *option) {
  return drive_option_supported(0x605A, option->quick_stop) && drive_option_supported(0x605B, option->shutdown) &&
         drive_option_supported(0x605C, option->disable) && drive_option_supported(0x605D, option->halt) &&
         drive_option_supported(0x605E, option->fault_reaction);
}

bool persisted_objects_are_good(const persisted_objects *kept, const object_dictionary *dictionary) {
  bool good = node_objects_are_good(dictionary, &kept->communication) &&
              board_objects_check(&kept->scales) == CONTROL_OK &&
              camera_input_check(&kept->camera.params) == CONTROL_OK;
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_axis_params built;
    good = good && options_are_good(&kept->drive[i].state.option) &&
           homing_method_supported(kept->drive[i].homing.method) &&
           setpoint_option_supported(kept->drive[i].position.option) &&
           kept->drive[i].limit.position_minimum <= kept->drive[i].limit.position_maximum &&
           axis_parameters_build(&kept->parameters[i], &built) == CONTROL_OK &&
           protection_check(&kept->protection[i]) == CONTROL_OK;
  }
  return good;
}
