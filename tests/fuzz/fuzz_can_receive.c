/* SPDX-License-Identifier: Apache-2.0 */
/* libFuzzer harness of the CAN receive path: any frames, in any order, at any time, into the whole node on a machine.
 *
 * Input: for each step a control byte, whose upper half says what happens:
 *   0 .. 3   an SDO request, its bytes follow           4, 5   expedited download to object n: n (2 bytes), 4 bytes
 *   6        upload of object n: n (2 bytes)            7      NMT command: its byte follows, to all nodes
 *   8 .. 11  RPDO 1 .. 4, its bytes follow              12     SYNC, or the heartbeat of another node
 *   13       something happens to the machine           14     a frame with any identifier (2 bytes), its bytes follow
 *   15       time passes
 * The lower half is the length of a frame, or how long, or what happens. */
#include <string.h>

#include "input_bytes.h"
#include "require.h"
#include "support/rigid_machine.h"

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { NODE_ID = 5, MAX_TICKS = 64 };

static rigid_machine machine;
static servo_node node;
static rigid_machine fresh_machine;
static servo_node fresh_node;
static uint32_t frames_sent;
static uint32_t ticks_left;

static bool count_frame(void *context, const can_frame *frame) {
  (void)context;
  require(frame->length <= CAN_FRAME_BYTES && frame->id <= 0x7FF);
  frames_sent++;
  return frames_sent % 5 != 0; /* the bus is full now and then */
}

static void tick(void) {
  if (ticks_left == 0) {
    return;
  }
  ticks_left--;
  servo_node_tick(&node);
  servo_node_serve(&node);
  servo_node_background(&node);
  servo_board_pwm_period(&node.board, SERVO_TICK_LATENCY_PERIODS);
  for (int i = 0; i < SERVO_AXES; ++i) {
    const float limit_a = node.board.app.params.axis[i].current_limit_a;
    require(fabsf(node.board.app.axis[i].current_reference_a) <= limit_a * 1.0001f); /* false for NaN */
    require(fabsf(machine.axis[i].duty) <= 1.0f);
  }
  rigid_machine_turn(&machine, &node.board);
}

static void receive(uint16_t id, uint8_t flags, uint8_t length, const uint8_t *bytes) {
  can_frame frame = {.id = id, .length = length, .flags = flags};
  memcpy(frame.data, bytes, length < CAN_FRAME_BYTES ? length : CAN_FRAME_BYTES);
  (void)servo_node_receive(&node, &frame);
}

static void receive_rest(uint16_t id, uint8_t flags, uint8_t length, input_bytes *input) {
  uint8_t bytes[CAN_FRAME_BYTES] = {0};
  for (uint8_t i = 0; i < length && i < CAN_FRAME_BYTES; ++i) {
    bytes[i] = input_u8(input);
  }
  receive(id, flags, length, bytes);
}

static void ask_for_object(bool writing, input_bytes *input) {
  const od_object object = nth_object(servo_node_dictionary(&node), input_u16(input));
  const uint16_t index = od_index(&object);
  uint8_t request[8] = {0x40, (uint8_t)index, (uint8_t)(index >> 8), object.entry->sub};
  if (writing) {
    request[0] = 0x22; /* as many bytes as the type has */
    for (int i = 4; i < 8; ++i) {
      request[i] = input_u8(input);
    }
  }
  receive(0x600 + NODE_ID, 0, 8, request);
}

static void disturb(uint8_t what) {
  rigid_axis *axis = &machine.axis[what & 1];
  switch (what >> 1) {
    case 0:
      axis->encoder_failed = !axis->encoder_failed;
      break;
    case 1:
      axis->gyro_missing = !axis->gyro_missing;
      break;
    case 2:
      axis->health = (hal_health)((axis->health + 1) % (HAL_TIMING_LOST + 1));
      break;
    case 3:
      machine.bus_voltage_v = machine.bus_voltage_v > 0.0f ? 0.0f : 48.0f;
      break;
    case 4:
      axis->turns += 0.3;
      break;
    case 5:
      axis->current_error_a = 1.0f;
      break;
    case 6:
      axis->gyro_error_rad_s = isnan(axis->gyro_error_rad_s) ? 0.5f : NAN;
      break;
    default:
      axis->rate_rad_s = 0.0;
      axis->turns = 0.0;
      break;
  }
}

static void step(uint8_t control, input_bytes *input) {
  const uint8_t low = control & 15u;
  const uint8_t length = low >= 9 ? 8 : low;
  const uint8_t kind = control >> 4;
  if (kind < 4) {
    receive_rest(0x600 + NODE_ID, 0, length, input);
  } else if (kind < 7) {
    ask_for_object(kind != 6, input);
  } else if (kind == 7) {
    receive(0, 0, 2, (const uint8_t[]){input_u8(input), 0});
  } else if (kind < 12) {
    receive_rest((uint16_t)(0x205 + 0x100 * (kind - 8)), 0, length, input);
  } else if (kind == 12) {
    receive_rest(low < 8 ? 0x080 : 0x701, 0, low & 7u, input);
  } else if (kind == 13) {
    disturb(low);
  } else if (kind == 14) {
    const uint16_t id = input_u16(input);
    receive_rest(id & 0x3FFF, (uint8_t)(id >> 14), low, input);
  }
  for (int i = 0; i < (kind == 15 ? 4 * low : 1) && low != 15; ++i) {
    tick();
  }
}

int LLVMFuzzerInitialize(int *argc, char ***argv) {
  (void)argc;
  (void)argv;
  rigid_machine_init(&machine);
  require(rigid_machine_start_node(&machine, &node, NODE_ID, (can_sender){count_frame, NULL}, NULL));
  ticks_left = 2;
  tick();
  tick();
  fresh_machine = machine;
  memcpy(&fresh_node, &node, sizeof node);
  return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  memcpy(&machine, &fresh_machine, sizeof machine);
  memcpy(&node, &fresh_node, sizeof node);
  frames_sent = 0;
  ticks_left = MAX_TICKS;
  input_bytes input = {data, size};
  while (!input_is_empty(&input) && ticks_left > 0) {
    step(input_u8(&input), &input);
  }
  ticks_left++;
  tick();
  require_values_within_limits(servo_node_dictionary(&node));
  return 0;
}
