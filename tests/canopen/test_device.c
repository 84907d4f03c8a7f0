/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/test_device.h"

#include <string.h>

#include "canopen/cob_id.h"
#include "canopen/object_dictionary_rows.h"

static const od_entry identity_rows[] = {
    OD_FIXED(OD_UNSIGNED32, 4, 0x1000, 0, 0, 0x00020192, "Device type", "A drive, CiA 402."),
    OD_FIXED_TEXT(0x1008, 0, "test device", "Manufacturer device name", "What it is."),
    OD_FIXED_TEXT(0x1009, 0, "0.0", "Manufacturer hardware version", "Board."),
    OD_FIXED_TEXT(0x100A, 0, "0.0.1", "Manufacturer software version", "Firmware."),
    CANOPEN_IDENTITY_ROWS(0, 0x54534456, 1),
    CANOPEN_RPDO_ROWS(0, "1", 0, 255, 0),
    CANOPEN_RPDO_ROWS(1, "2", 0, 1, 0),
    CANOPEN_RPDO_ROWS(2, "3", COB_ID_INVALID, 255, 0),
    CANOPEN_RPDO_ROWS(3, "4", COB_ID_INVALID, 255, 0),
    CANOPEN_MAPPING_ROWS(0x1600, rpdo_mapping[0], "RPDO1", 2, CANOPEN_MAP(0x6040, 0, 16), CANOPEN_MAP(0x6060, 0, 8), 0,
                         0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1601, rpdo_mapping[1], "RPDO2", 2, CANOPEN_MAP(0x60FF, 0, 32), CANOPEN_MAP(0x68FF, 0, 32), 0,
                         0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1602, rpdo_mapping[2], "RPDO3", 0, 0, 0, 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1603, rpdo_mapping[3], "RPDO4", 0, 0, 0, 0, 0, 0, 0, 0, 0),
    CANOPEN_TPDO_ROWS(0, "1", 0, 255, 100, 0),
    CANOPEN_TPDO_ROWS(1, "2", 0, 1, 0, 0),
    CANOPEN_TPDO_ROWS(2, "3", COB_ID_INVALID, 255, 0, 50),
    CANOPEN_TPDO_ROWS(3, "4", COB_ID_INVALID, 255, 0, 0),
    CANOPEN_FURTHER_TPDO_ROWS(4, "5", 255, 0, 0),
    CANOPEN_FURTHER_TPDO_ROWS(5, "6", 255, 0, 0),
    CANOPEN_FURTHER_TPDO_ROWS(6, "7", 255, 0, 0),
    CANOPEN_FURTHER_TPDO_ROWS(7, "8", 255, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A00, tpdo_mapping[0], "TPDO1", 2, CANOPEN_MAP(0x6041, 0, 16), CANOPEN_MAP(0x6061, 0, 8), 0,
                         0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A01, tpdo_mapping[1], "TPDO2", 2, CANOPEN_MAP(0x606C, 0, 32), CANOPEN_MAP(0x686C, 0, 32), 0,
                         0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A02, tpdo_mapping[2], "TPDO3", 0, 0, 0, 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A03, tpdo_mapping[3], "TPDO4", 0, 0, 0, 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A04, tpdo_mapping[4], "TPDO5", 0, 0, 0, 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A05, tpdo_mapping[5], "TPDO6", 0, 0, 0, 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A06, tpdo_mapping[6], "TPDO7", 0, 0, 0, 0, 0, 0, 0, 0, 0),
    CANOPEN_MAPPING_ROWS(0x1A07, tpdo_mapping[7], "TPDO8", 0, 0, 0, 0, 0, 0, 0, 0, 0),
};

const od_table test_device_identity = {identity_rows, sizeof identity_rows / sizeof identity_rows[0]};

static const od_entry axis_rows[] = {
    OD_RECORD_HEAD(0x2000, 2, "Speed loop", "Gains."),
    OD_F32(0x2000, 1, OD_RW, OD_STORED | OD_RPDO, test_axis, kp, 0.0f, 100.0f, 1.5f, "Nm s/rad", "Proportional gain",
           "Torque for each rad/s of error."),
    OD_F32(0x2000, 2, OD_RW, OD_STORED, test_axis, ki, 0.0f, 1000.0f, 20.0f, "Nm/rad", "Integral gain",
           "Torque for each rad of error."),
    OD_U16(0x6040, 0, OD_RW, OD_RPDO, test_axis, controlword, 0, 65535, 0, "", "Controlword", "Commands."),
    OD_U16(0x6041, 0, OD_RO, OD_TPDO | OD_EVENT, test_axis, statusword, 0, 65535, 0, "", "Statusword", "State."),
    OD_I8(0x6060, 0, OD_RW, OD_RPDO, test_axis, mode, 0, 10, 3, "", "Modes of operation", "Wanted."),
    OD_I8(0x6061, 0, OD_RO, OD_TPDO | OD_EVENT, test_axis, mode_display, 0, 10, 0, "", "Modes of operation display",
          "In force."),
    OD_I32(0x606C, 0, OD_RO, OD_TPDO, test_axis, velocity, INT32_MIN, INT32_MAX, 0, "1e-6 rad/s",
           "Velocity actual value", "Measured."),
    OD_I32(0x60FF, 0, OD_RW, OD_RPDO, test_axis, target_velocity, -1000000, 1000000, 0, "1e-6 rad/s", "Target velocity",
           "Wanted."),
};

static const od_entry value_rows[] = {
    OD_RECORD_HEAD(0x2F00, 12, "Every type", "One value of each."),
    OD_BOOL(0x2F00, 1, OD_RW, 0, test_values, boolean, 0, 1, 1, "", "A boolean", "Yes or no."),
    OD_I8(0x2F00, 2, OD_RW, OD_TPDO, test_values, i8, -100, 100, -5, "", "An integer8", "Limited."),
    OD_I16(0x2F00, 3, OD_RW, OD_TPDO, test_values, i16, -1000, 1000, -500, "", "An integer16", "Limited."),
    OD_I32(0x2F00, 4, OD_RW, OD_TPDO, test_values, i32, -100000, 100000, -50000, "", "An integer32", "Limited."),
    OD_U8(0x2F00, 5, OD_RW, OD_RPDO | OD_TPDO, test_values, u8, 10, 200, 50, "", "An unsigned8", "Limited."),
    OD_U16(0x2F00, 6, OD_RW, OD_RPDO | OD_TPDO, test_values, u16, 0, 65535, 0xBEEF, "", "An unsigned16", "Free."),
    OD_U32(0x2F00, 7, OD_RW, OD_RPDO | OD_TPDO, test_values, u32, 0, 0xFFFFFFFF, 0xDEADBEEF, "", "An unsigned32",
           "Free."),
    OD_U64(0x2F00, 8, OD_RW, OD_RPDO | OD_TPDO, test_values, u64, 1, -1, 0x0123456789ABCDEF, "", "An unsigned64",
           "Anything but 0."),
    OD_F32(0x2F00, 9, OD_RW, OD_RPDO | OD_TPDO, test_values, f32, -1000.0f, 1000.0f, 0.1f, "rad", "A real32",
           "Limited."),
    OD_TEXT(0x2F00, 10, OD_RW, 0, test_values, text, "hello world", "A text", "Up to 16 characters."),
    OD_U32(0x2F00, 11, OD_WO, 0, test_values, secret, 0, 0xFFFFFFFF, 0, "", "A secret", "Write only."),
    OD_FIXED(OD_UNSIGNED16, 2, 0x2F00, 12, OD_TPDO, 0x1234, "A constant", "Read only."),
    OD_STREAM(0x2F01, 0, OD_RW, "A stream", "Any bytes."),
    OD_STREAM(0x2F02, 0, OD_RO, "A capture", "The bytes of the stream, read only."),
    OD_U8(0x2F10, 0, OD_RW, OD_RPDO, test_values, moody, 0, 255, 0, "", "A moody value", "Has its days."),
    OD_U8(0x2F11, 0, OD_RW, 0, test_values, slow, 0, 255, 0, "", "A slow value", "Takes some ticks."),
    OD_U8(0x2F12, 0, OD_RW, OD_RPDO, test_values, command, 0, 99, 0, "", "A command", "Is counted, or fails."),
    OD_U16(0x2F20, 0, OD_RW, 0, test_values, error, 0, 65535, 0, "", "An error", "Raises, or clears with 0."),
};

static od_abort accept(void *owner, const od_object *object, od_number value) {
  (void)owner;
  if (object->entry->index == 0x2F10 && value.i == 13) {
    return OD_DEVICE_STATE;
  }
  if (object->entry->index == 0x2F10 && value.i == 66) {
    return OD_HARDWARE;
  }
  if (object->entry->index == 0x2F12 && value.i == 66) {
    return OD_HARDWARE;
  }
  return OD_OK;
}

static od_abort execute(void *owner, const od_object *object, od_number value) {
  test_device *device = owner;
  if (object->entry->index == 0x2F11) {
    device->calls++;
    return device->calls % 4 == 0 ? OD_OK : OD_PENDING;
  }
  if (object->entry->index == 0x2F12) {
    device->commands++;
    return value.i == 13 ? OD_DEVICE_STATE : OD_OK;
  }
  return OD_OK;
}

static bool stops(const od_object *object, od_number value) {
  return object->entry->index == 0x6040 && (value.i & 0x06) != 0x06;
}

static bool waits(void *owner, const od_object *object) {
  const test_device *device = owner;
  return object->entry->index == 0x6040 && device->busy;
}

static unsigned needed(const od_object *object) {
  const bool executes = object->entry->index == 0x2F11 || object->entry->index == 0x2F12;
  const bool may_wait = object->entry->index == 0x6040;
  return OD_HOOK_REFRESH | OD_HOOK_ACCEPT | OD_HOOK_CHANGED | (executes ? OD_HOOK_EXECUTE : 0u) |
         (may_wait ? OD_HOOK_WAITS : 0u);
}

static void changed(void *owner, const od_object *object) {
  test_device *device = owner;
  if (object->entry->index == 0x2F12) {
    device->carried_out++;
  }
  if (object->entry->index != 0x2F20) {
    return;
  }
  if (device->values.error != 0) {
    const emergency_error error = {
        .code = device->values.error, .register_bits = ERROR_MANUFACTURER, .source = 7, .detail = 42};
    (void)canopen_node_raise(&device->node, &error);
    device->raised = device->values.error;
  } else {
    (void)canopen_node_clear(&device->node, 7, device->raised);
  }
}

static od_abort stream_begin(void *owner, const od_object *object, bool writing, uint32_t *size) {
  test_device *device = owner;
  (void)object;
  if (!writing) {
    *size = device->stream_size;
  } else if (*size != OD_SIZE_UNKNOWN && *size > TEST_DEVICE_STREAM) {
    return OD_TOO_LONG;
  }
  device->streams_open++;
  return OD_OK;
}

static od_abort stream_read(void *owner, const od_object *object, uint32_t offset, uint8_t *bytes, uint32_t length) {
  const test_device *device = owner;
  (void)object;
  if (device->stream_broken) {
    return OD_HARDWARE;
  }
  memcpy(bytes, &device->stream[offset], length);
  return OD_OK;
}

static od_abort stream_write(void *owner, const od_object *object, uint32_t offset, const uint8_t *bytes,
                             uint32_t length) {
  test_device *device = owner;
  (void)object;
  if (device->stream_broken) {
    return OD_HARDWARE;
  }
  if (length > TEST_DEVICE_STREAM - offset) {
    return OD_TOO_LONG;
  }
  memcpy(&device->staged[offset], bytes, length);
  return OD_OK;
}

static od_abort stream_end(void *owner, const od_object *object, bool writing, bool complete, uint32_t total) {
  test_device *device = owner;
  (void)object;
  device->streams_open--;
  if (writing && complete) {
    memcpy(device->stream, device->staged, total);
    device->stream_size = total;
  }
  return OD_OK;
}

static const od_hooks value_hooks = {.accept = accept,
                                     .execute = execute,
                                     .changed = changed,
                                     .needed = needed,
                                     .stream_begin = stream_begin,
                                     .stream_read = stream_read,
                                     .stream_write = stream_write,
                                     .stream_end = stream_end};

static const od_hooks axis_hooks = {
    .accept = accept, .execute = execute, .changed = changed, .stops = stops, .waits = waits, .needed = needed};

static od_abort save(void *context, uint8_t group) {
  test_device *device = context;
  (void)group;
  if (device->store_broken) {
    return OD_HARDWARE;
  }
  device->saves++;
  return OD_OK;
}

static od_abort restore(void *context, uint8_t group) {
  test_device *device = context;
  (void)group;
  device->loads++;
  return OD_OK;
}

/* In two pieces, of which the second is the last. */
static bool on_reset(void *context, bool whole_node, uint32_t step) {
  test_device *device = context;
  device->resets += step > 0 ? 0 : whole_node ? 0x10000u : 1u;
  return step == 1;
}

static void on_heartbeat_lost(void *context, uint8_t node_id) {
  test_device *device = context;
  device->heartbeats_lost += node_id;
}

static od_part part_of(test_device *device, const od_entry *rows, uint32_t count, void *values, const od_hooks *hooks) {
  return (od_part){.table = {rows, count}, .prefix = "", .values = values, .owner = device, .hooks = hooks};
}

bool test_device_init(test_device *device, uint8_t node_id, can_sender sender) {
  memset(&device->values, 0, sizeof device->values);
  device->stream_size = 0;
  device->calls = 0;
  device->commands = 0;
  device->carried_out = 0;
  device->raised = 0;
  device->saves = 0;
  device->loads = 0;
  device->store_broken = false;
  device->stream_broken = false;
  device->busy = false;
  device->heartbeats_lost = 0;
  device->resets = 0;
  device->streams_open = 0;
  od_part parts[1 + TEST_DEVICE_AXES];
  parts[0] = part_of(device, value_rows, sizeof value_rows / sizeof value_rows[0], &device->values, &value_hooks);
  for (uint16_t i = 0; i < TEST_DEVICE_AXES; i++) {
    parts[1 + i] = part_of(device, axis_rows, sizeof axis_rows / sizeof axis_rows[0], &device->axis[i], &axis_hooks);
    parts[1 + i].shift = (uint16_t)(0x800 * i);
    parts[1 + i].prefix = i == 0 ? "Azimuth " : "Pitch ";
  }
  for (uint32_t i = 0; i < 1 + TEST_DEVICE_AXES; i++) {
    od_restore_defaults(&parts[i], node_id);
  }
  const canopen_config config = {
      .node_id = node_id,
      .device_table = &test_device_identity,
      .parts = parts,
      .part_count = 1 + TEST_DEVICE_AXES,
      .sender = sender,
      .process_data = device->process_data,
      .services = device->services,
      .queue_capacity = TEST_DEVICE_QUEUE,
      .storage = {.save = save, .restore = restore, .context = device},
      .events = {.reset = on_reset, .heartbeat_lost = on_heartbeat_lost},
      .context = device,
  };
  if (!canopen_node_init(&device->node, &config)) {
    return false;
  }
  device->node.objects.serial_number = 4711;
  return true;
}

void test_device_tick(test_device *device) {
  for (uint32_t i = 0; i < TEST_DEVICE_AXES; i++) {
    test_axis *axis = &device->axis[i];
    axis->statusword = axis->controlword;
    axis->mode_display = axis->mode;
    axis->velocity = axis->target_velocity;
  }
  canopen_node_tick(&device->node);
}
