/* libFuzzer harness of the receive path: any frames, in any order, at any time.
 *
 * Input: for each step one control byte, then a frame. The control byte's upper half picks the identifier, so that
 * most frames reach a service; its lower half is the length. After each step every value that the bus can write must
 * be within its limits. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "canopen/test_device.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static test_device device;
static uint32_t frames_sent;

static bool count_frame(void *context, const can_frame *frame) {
  (void)context;
  if (frame->length > CAN_FRAME_BYTES || frame->id > 0x7FF) {
    abort();
  }
  frames_sent++;
  return frames_sent % 5 != 0; /* the bus is full now and then */
}

static void require(bool good) {
  if (!good) {
    abort();
  }
}

static void check_values(void) {
  const object_dictionary *dictionary = &device.node.dictionary;
  for (uint32_t i = 0; i < dictionary->count; i++) {
    const od_part *part = &dictionary->parts[i];
    for (uint32_t row = 0; row < part->table.count; row++) {
      const od_object object = {part, &part->table.entries[row]};
      const od_number value = od_get(&object);
      const od_entry *entry = object.entry;
      if (entry->type == OD_REAL32) {
        require(isfinite(value.f) && value.f >= entry->low.f && value.f <= entry->high.f);
      } else if (entry->type != OD_VISIBLE_STRING && entry->type != OD_DOMAIN && entry->type != OD_UNSIGNED64) {
        require(value.i >= entry->low.i && value.i <= entry->high.i);
      }
    }
  }
  require(device.streams_open <= 1);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const uint16_t identifiers[] = {0x605, 0x605, 0x605, 0x605, 0x605, 0x605, 0x000,
                                         0x080, 0x205, 0x305, 0x405, 0x505, 0x701, 0x605};
  const can_sender sender = {count_frame, NULL};
  frames_sent = 0;
  require(test_device_init(&device, 5, sender));
  test_device_tick(&device);
  test_device_tick(&device);
  size_t at = 0;
  while (at < size) {
    const uint8_t control = data[at++];
    const uint8_t pick = control >> 4;
    if (pick == 15) {
      for (uint32_t i = 0; i < (control & 15u) * 40u; i++) {
        test_device_tick(&device);
      }
      continue;
    }
    can_frame frame = {.length = (control & 15u) >= 9 ? 8 : control & 15u};
    if (pick == 14) {
      frame.id = at + 1 < size ? (uint32_t)(data[at] | data[at + 1] << 8) : 0;
      frame.flags = (uint8_t)(frame.id >> 14);
    } else {
      frame.id = identifiers[pick];
    }
    for (uint8_t i = 0; i < frame.length && at < size; i++) {
      frame.data[i] = data[at++];
    }
    (void)canopen_node_receive(&device.node, &frame);
    if ((control & 15u) != 15u) { /* else: several frames in one tick */
      test_device_tick(&device);
    }
  }
  test_device_tick(&device);
  check_values();
  return 0;
}
