/* SPDX-License-Identifier: Apache-2.0 */
#include "node/scope_objects.h"

#include "canopen/object_dictionary_rows.h"
#include "node/scope_signals.h"
#include "node/servo_node.h"

enum { SCOPE_OBJECT = 0x3000, SCOPE_COMMAND_SUB = 1, SCOPE_DATA_OBJECT = 0x3001 };
enum { COMMAND_ARM = 1, COMMAND_STOP = 2, COMMAND_FORCE = 3 };

#define SIGNAL(sub_, number_, preset_)                                                             \
  OD_U8(0x3000, sub_, OD_RW, 0, scope_objects, signal[(number_)-1], 1, SCOPE_SIGNALS, preset_, "", \
        "Scope channel " #number_, "Signal number, see 0x3002")

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x3000, 17, "Scope", "Records up to 8 signals around a trigger in 32 KiB"),
    OD_U8(0x3000, 1, OD_RW, 0, scope_objects, command, 0, 3, 0, "", "Scope command", "1: arm; 2: stop; 3: trigger now"),
    OD_U8(0x3000, 2, OD_RO, OD_TPDO, scope_objects, state, 0, 4, 0, "", "Scope state",
          "0: idle; 1: filling; 2: waiting; 3: triggered; 4: done"),
    OD_U16(0x3000, 3, OD_RW, 0, scope_objects, divider, 1, 65535, 1, "ms", "Scope divider",
           "Number of ticks per frame"),
    OD_U16(0x3000, 4, OD_RW, 0, scope_objects, pretrigger, 0, 8191, 0, "", "Scope pre-trigger",
           "Number of frames before the trigger"),
    OD_U8(0x3000, 5, OD_RW, 0, scope_objects, trigger, 0, 6, 0, "", "Scope trigger",
          "0: at once; 1: above; 2: below; 3: rising; 4: falling; 5: state change; 6: fault"),
    OD_U8(0x3000, 6, OD_RW, 0, scope_objects, trigger_channel, 0, 7, 0, "", "Scope trigger channel",
          "0: the first channel"),
    OD_F32(0x3000, 7, OD_RW, 0, scope_objects, trigger_level, -1e9f, 1e9f, 0.0f, "", "Scope trigger level",
           "In the unit of the trigger channel"),
    OD_U32(0x3000, 8, OD_RO, 0, scope_objects, frames, 0, INT64_C(0xFFFFFFFF), 0, "", "Scope frames",
           "Number of frames captured so far"),
    OD_U8(0x3000, 9, OD_RW, 0, scope_objects, channels, 1, 8, 4, "", "Scope channels",
          "Number of channels used: 3000:10 to 3000:17"),
    SIGNAL(10, 1, 1),
    SIGNAL(11, 2, 2),
    SIGNAL(12, 3, 6),
    SIGNAL(13, 4, 8),
    SIGNAL(14, 5, 9),
    SIGNAL(15, 6, 10),
    SIGNAL(16, 7, 11),
    SIGNAL(17, 8, 12),
    OD_STREAM(0x3001, 0, OD_RO, "Scope data", "Header and frames of a finished capture; format: commissioning/scope.h"),
};

const od_table scope_objects_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};

static scope_config config_of(const servo_node *node) {
  const scope_objects *objects = &node->scope_setup;
  scope_config config = {
      .channels = objects->channels,
      .divider = objects->divider,
      .pretrigger = objects->pretrigger,
      .trigger = {.source = (scope_source)objects->trigger,
                  .channel = objects->trigger_channel,
                  .level = objects->trigger_level},
  };
  for (int i = 0; i < SCOPE_CHANNELS; ++i) {
    const uint32_t signal = objects->signal[i];
    config.channel[i] =
        (scope_channel){.id = signal, .kind = SCOPE_FLOAT, .source = (const char *)node + scope_signal_offset(signal)};
  }
  return config;
}

static bool is_command(const od_object *object) {
  return object->entry->index == SCOPE_OBJECT && object->entry->sub == SCOPE_COMMAND_SUB;
}

static od_abort refresh(void *owner, const od_object *object) {
  servo_node *node = owner;
  (void)object;
  node->scope_setup.state = (uint8_t)node->recorder.phase;
  node->scope_setup.frames = node->recorder.frames;
  return OD_OK;
}

static od_abort accept(void *owner, const od_object *object, od_number value) {
  const servo_node *node = owner;
  if (is_command(object) && value.i == COMMAND_ARM) {
    const scope_config config = config_of(node);
    return scope_check(&config) == SCOPE_OK ? OD_OK : OD_INCOMPATIBLE;
  }
  return OD_OK;
}

static void changed(void *owner, const od_object *object) {
  servo_node *node = owner;
  if (is_command(object) && node->scope_setup.command == COMMAND_ARM) {
    const scope_config config = config_of(node);
    (void)scope_arm(&node->recorder, &config, SERVO_TICK_S); /* accept() has checked it */
  } else if (is_command(object) && node->scope_setup.command == COMMAND_STOP) {
    scope_stop(&node->recorder);
  } else if (is_command(object) && node->scope_setup.command == COMMAND_FORCE) {
    scope_force(&node->recorder);
  }
}

static od_abort stream_begin(void *owner, const od_object *object, bool writing, uint32_t *size) {
  const servo_node *node = owner;
  (void)object;
  (void)writing;
  *size = scope_bytes(&node->recorder);
  return *size > 0 ? OD_OK : OD_NO_DATA;
}

static od_abort stream_read(void *owner, const od_object *object, uint32_t offset, uint8_t *bytes, uint32_t length) {
  const servo_node *node = owner;
  (void)object;
  return scope_read(&node->recorder, offset, bytes, length) == SCOPE_OK ? OD_OK : OD_NO_DATA;
}

const od_hooks scope_objects_hooks = {
    .refresh = refresh, .accept = accept, .changed = changed, .stream_begin = stream_begin, .stream_read = stream_read};
