/* SPDX-License-Identifier: Apache-2.0 */
/* cost_node: instructions of the whole 1 kHz task of both axes, servo_node_tick, on a full bus, and of the deferred
 * task after it. It ends with 1 when one of them exceeds its limit. The deferred task may take longer: it only has to
 * end before the next tick, and with 10,500 instructions it takes about a tenth of the millisecond.
 *
 * Both axes turn a bare inertia with Coulomb friction. In every tick, the frames that 1 Mbit/s can carry in a
 * millisecond: SYNC, all four RPDOs, all four TPDOs, an SDO request and its answer (1061 bits without stuffing). The
 * scope records 8 signals, a frame every tick, and the base's rates are in use. The count has their work with received
 * and sent frames already in memory. It has neither a board's drivers nor the interrupt that puts a frame into the
 * queue. (On the board most frames are taken before the tick; here all of them within it.) */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "cortex_m4/cost_table.h"
#include "cortex_m4/instruction_count.h"
#include "hal_host.h"
#include "node/servo_node.h"
#include "parameters/axis_dictionary.h"

enum { NODE_ID = 1, LIMIT = 6500, WARM_UP_TICKS = 600, COUNTED_TICKS = 2000, TURNING_TICKS = 10000, SETS_OFF = 300 };
enum { TURNED_TICKS = 500 };           /* counted at least after the turn back: the tick takes longer there */
enum { NO_LIMIT = 0, TOO_SLOW = 100 }; /* 607F: less than what an image error of 50 urad asks for */

typedef enum {
  STAYS,      /* before the axes */
  GOES_ROUND, /* leaves the azimuth's travel, and the azimuth turns back */
  COMES_BACK  /* is seen for 0.5 s of every 2 s, and the axes return (2011:6) */
} target_course;

typedef struct {
  float rate_rad_s;
  float rest_turn32; /* remainder of the angle */
  hal_axis_samples samples;
} bare_axis;

/* turn() prepares what the functions of the HAL give: what they cost themselves is in the count. */
typedef struct {
  bare_axis axis[SERVO_AXES];
  uint32_t tick;
  servo_node node;
} bench;

static bench b;

/* --- the machine -------------------------------------------------------------------------------------------------- */

static void sample(void *machine, int axis, hal_axis_samples *samples) {
  *samples = ((bench *)machine)->axis[axis].samples;
}

static float current(void *machine, int axis) { return ((bench *)machine)->axis[axis].samples.mean_current_a; }

static float bus_voltage(void *machine) {
  (void)machine;
  return 48.0f;
}

static hal_health good_health(void *machine, int axis) {
  (void)machine;
  (void)axis;
  return HAL_GOOD;
}

static void ignore_power(void *machine, int axis, bool on) {
  (void)machine;
  (void)axis;
  (void)on;
}

static void ignore_scales(void *machine, const hal_scales *scales) {
  (void)machine;
  (void)scales;
}

static void ignore_duty(void *machine, int axis, float duty) {
  (void)machine;
  (void)axis;
  (void)duty;
}

static void ignore_brake(void *machine, int axis, bool release) {
  (void)machine;
  (void)axis;
  (void)release;
}

static bool open_brake(void *machine, int axis) {
  (void)machine;
  (void)axis;
  return true;
}

static uint32_t no_status(void *machine) {
  (void)machine;
  return 0;
}

static uint32_t clock_us(void *machine) { return ((bench *)machine)->tick * 1000u; }

static void take_strobes(void *machine, hal_strobes *strobes) {
  (void)machine;
  *strobes = (hal_strobes){0};
}

static hal machine_of(bench *of) {
  return (hal){.machine = of,
               .sample = sample,
               .axis_health = good_health,
               .power_bridge = ignore_power,
               .current_a = current,
               .bus_voltage_v = bus_voltage,
               .set_duty = ignore_duty,
               .set_scales = ignore_scales,
               .release_brake = ignore_brake,
               .brake_is_released = open_brake,
               .status = no_status,
               .clock_us = clock_us,
               .tick_us = clock_us,
               .take_strobes = take_strobes};
}

static void turn(bench *of) {
  ++of->tick;
  for (int i = 0; i < SERVO_AXES; ++i) {
    bare_axis *axis = &of->axis[i];
    const servo_axis_params *motor = &of->node.board.app.params.axis[i];
    const float current_a = of->node.board.app.axis[i].current_reference_a;
    const float voltage_v = motor->resistance_ohm * current_a + motor->current.back_emf_v_s_rad * axis->rate_rad_s;
    atomic_store_explicit(&of->node.board.motor[i].tick_voltage_v, voltage_v, memory_order_relaxed);
    const float motor_nm = 2.5f * current_a;
    const float friction_nm = 7.0f * axis->rate_rad_s / (fabsf(axis->rate_rad_s) + 1e-4f);
    axis->rate_rad_s += (motor_nm - friction_nm) / 6.0f * SERVO_TICK_S;
    axis->rest_turn32 += axis->rate_rad_s * SERVO_TICK_S / ANGLE_RAD_PER_TURN32;
    const int32_t whole = (int32_t)axis->rest_turn32;
    axis->rest_turn32 -= (float)whole;
    axis->samples = (hal_axis_samples){.joint_angle_turn32 = axis->samples.joint_angle_turn32 + (uint32_t)whole,
                                       .gyro_valid = true,
                                       .gyro_rad_s = axis->rate_rad_s,
                                       .mean_current_a = current_a};
  }
}

/* --- the bus ------------------------------------------------------------------------------------------------------ */

static bool send(void *context, const can_frame *frame) {
  (void)context;
  (void)frame;
  return true;
}

static void receive(uint32_t id, uint8_t length, const void *data) {
  can_frame frame = {.id = id, .length = length};
  memcpy(frame.data, data, length);
  (void)servo_node_receive(&b.node, &frame);
}

static void receive_words(uint32_t id, int32_t first, int32_t second) {
  const int32_t words[] = {first, second};
  receive(id, sizeof words, words);
}

/* RPDO4 in tracking, 21 ms old: an image error of 50 to 74 and -30 to -54 urad, no frozen picture, or that of a target
 * that goes round the tracker at 0.05 rad/s, while it is in the picture. */
static void receive_picture(uint8_t counter, target_course course) {
  const uint32_t turn32_per_ms = 34181;
  const float edge_rad = 0.02f;
  const float ahead_rad = angle_difference_rad(b.tick < SETS_OFF ? 0 : (b.tick - SETS_OFF) * turn32_per_ms,
                                               b.axis[SERVO_AZIMUTH].samples.joint_angle_turn32);
  const bool goes_round = course == GOES_ROUND;
  const bool seen = goes_round ? fabsf(ahead_rad) < edge_rad : course == STAYS || counter % 100 < 25;
  const int16_t x = goes_round && seen ? (int16_t)(1e6f * ahead_rad) : (int16_t)(50 + 6 * (counter % 5));
  const int16_t y = (int16_t)(-30 - 6 * (counter % 5));
  const uint8_t picture[8] = {
      (uint8_t)x, (uint8_t)((uint16_t)x >> 8), (uint8_t)y, (uint8_t)((uint16_t)y >> 8), 0x34, 0x08, seen ? 90 : 0,
      counter};
  receive(0x500 + NODE_ID, sizeof picture, picture);
}

static bool set(uint16_t index, uint8_t sub, uint32_t value, uint16_t bytes) {
  od_object object;
  const bool set_now = od_find(servo_node_dictionary(&b.node), index, sub, &object) == OD_OK &&
                       od_write(&object, (const uint8_t *)&value, bytes) == OD_OK;
  if (!set_now) {
    printf("%04x:%02x is not set\n", index, sub);
  }
  return set_now;
}

static void full_bus(uint16_t controlword, int8_t mode, int32_t velocity, int32_t position, target_course course) {
  const uint8_t drive[] = {(uint8_t)controlword, (uint8_t)(controlword >> 8), (uint8_t)mode};
  const uint8_t upload_of_position[8] = {0x40, 0x64, 0x68, 0x00};
  receive(0x200 + NODE_ID, sizeof drive, drive);
  receive(0x300 + NODE_ID, sizeof drive, drive);
  receive_words(0x400 + NODE_ID, velocity, -velocity);
  if (mode != DRIVE_TRACKING) {
    receive_words(0x500 + NODE_ID, position, -position);
  } else if (b.tick % 20 == 0) {
    receive_picture((uint8_t)(b.tick / 20), course);
  }
  receive(0x600 + NODE_ID, sizeof upload_of_position, upload_of_position);
  receive(0x080, 0, "");
  (void)set(0x3076, 1, 500, 2);
  (void)set(0x3076, 4, (uint8_t)b.tick, 1);
}

static bool map_picture(void) {
  bool good = set(0x1403, 1, 0x80000000u | (0x500 + NODE_ID), 4) && set(0x1603, 0, 0, 1);
  for (uint32_t sub = 1; sub <= 5; ++sub) {
    good = good && set(0x1603, (uint8_t)sub, 0x30700000u | sub << 8 | (sub <= 3 ? 16u : 8u), 4);
  }
  return good && set(0x1603, 0, 5, 1) && set(0x1403, 1, 0x500 + NODE_ID, 4);
}

/* TPDO5 to TPDO8 with 8 bytes each, in every tick: more than 1 Mbit/s can carry beside the rest. */
static bool stream(void) {
  static const uint32_t objects[4][2] = {
      {0x60640020, 0x68640020}, {0x606C0020, 0x686C0020}, {0x60F40020, 0x68F40020}, {0x30100120, 0x606B0020}};
  bool good = true;
  for (uint16_t n = 0; n < TPDO_COUNT - RPDO_COUNT; ++n) {
    const uint16_t record = (uint16_t)(0x1804 + n);
    const uint16_t mapping = (uint16_t)(0x1A04 + n);
    good = good && set(mapping, 1, objects[n][0], 4) && set(mapping, 2, objects[n][1], 4) && set(mapping, 0, 2, 1) &&
           set(record, 3, 0, 2) && set(record, 5, 1, 2) && set(record, 1, 0x680u + n, 4);
  }
  return good;
}

static bool start(bool tracks, bool streams, target_course course) {
  static axis_tuning defaults;
  const od_part part = {.table = axis_parameters_table, .values = &defaults, .prefix = ""};
  od_restore_defaults(&part, NODE_ID);
  defaults.staged.tracking_loop.at_loss = course == COMES_BACK ? TARGET_LOSS_RETURN : TARGET_LOSS_STAND;
  const axis_parameters parameters[SERVO_AXES] = {defaults.staged, defaults.staged};
  static hal machine;
  memset(&b, 0, sizeof b);
  machine = machine_of(&b);
  /* A machine of constants: its sensors always read the same. */
  protection_limits limits[SERVO_AXES];
  for (int i = 0; i < SERVO_AXES; ++i) {
    protection_objects objects;
    const od_part limits_part = {.table = protection_objects_table, .values = &objects, .prefix = ""};
    od_restore_defaults(&limits_part, NODE_ID);
    limits[i] = objects.written;
    limits[i].stuck_s = 0.0f;
    limits[i].fixed_base_rad = 0.0f;
    /* Just less than two possible turns, and an end of the travel that is soon reached. */
    const bool turns = course == GOES_ROUND && i == SERVO_AZIMUTH;
    limits[i].minimum_rad = turns ? -6.18f : -3.0f;
    limits[i].maximum_rad = turns ? 0.15f : 3.0f;
  }
  const servo_node_config config = {NODE_ID, {send, NULL}, &machine, parameters, limits, NULL, 0, {0}, NULL, NULL};
  bool good = servo_node_start(&b.node, &config);
  for (uint16_t n = 0; n < RPDO_COUNT; ++n) {
    good = good && set((uint16_t)(0x1400 + n), 2, 1, 1) && set((uint16_t)(0x1800 + n), 2, 1, 1);
  }
  good = good && set(0x3077, 1, 1, 1);
  good = good && (!tracks || map_picture()) && (!streams || stream());
  good = good && set(0x3000, 9, 8, 1) && set(0x3000, 5, 6, 1) && set(0x3000, 1, 1, 1); /* waits for a fault */
  servo_node_tick(&b.node);
  servo_node_serve(&b.node);
  receive(0x000, 2, "\x01\x00"); /* NMT: start */
  return good;
}

/* --- rows --------------------------------------------------------------------------------------------------------- */

typedef struct {
  const char *name;
  int8_t mode;
  int limit;
  uint32_t rate_limit; /* 607F; 0: as delivered */
  bool streams;        /* TPDO5 to TPDO8, too */
  target_course course;
} work;

/* Shutdown, switch on, enable; then new set-points whenever an axis has arrived. */
static uint16_t controlword(uint32_t tick) {
  if (tick < 100) {
    return 0x06;
  }
  if (tick < 200) {
    return 0x07;
  }
  return tick % 500 < 250 ? 0x0F : 0x1F;
}

static int32_t position_at(uint32_t tick, int8_t mode) {
  const int32_t turning = 2000 * (int32_t)(tick % 1000 < 500 ? tick % 500 : 500 - tick % 500);
  return mode == DRIVE_PROFILE_POSITION ? (tick % 1000 < 500 ? 900000 : -900000) : turning;
}

typedef struct {
  int tick;
  int service;
} work_cost;

static work_cost count_tick(const work *w) {
  const int32_t velocity = b.tick % 1000 < 500 ? 200000 : -200000;
  full_bus(controlword(b.tick), w->mode, velocity, position_at(b.tick, w->mode), w->course);
  work_cost cost;
  uint32_t start_count = instruction_count_now();
  servo_node_tick(&b.node);
  cost.tick = instruction_count_since(start_count);
  start_count = instruction_count_now();
  servo_node_serve(&b.node);
  cost.service = instruction_count_since(start_count);
  turn(&b);
  return cost;
}

static bool measure(const work *w, cost_row *row, cost_row *service) {
  *row = (cost_row){.name = w->name, .limit = w->limit};
  const bool goes_round = w->course == GOES_ROUND;
  if (!start(w->mode == DRIVE_TRACKING, w->streams, w->course) ||
      (w->rate_limit != 0 && !set(0x607F, 0, w->rate_limit, 4)) || (goes_round && !set(0x3075, 2, 1, 1))) {
    return false;
  }
  const int counted_ticks = w->course != STAYS ? TURNING_TICKS : COUNTED_TICKS;
  int turning_ticks = 0;
  int turned_ticks = 0; /* since the last of them */
  for (int tick = 0; tick < WARM_UP_TICKS + counted_ticks; ++tick) {
    const work_cost cost = count_tick(w);
    const bool turns_back = b.node.tracking.objects.wrap_state == CAMERA_TURNS_BACK;
    turning_ticks += turns_back ? 1 : 0;
    turned_ticks = turns_back ? 0 : turned_ticks + 1;
    if (tick >= WARM_UP_TICKS) {
      cost_row_add(row, cost.tick);
      cost_row_add(service, cost.service);
    }
  }
  bool enabled = true;
  for (int i = 0; i < SERVO_AXES; ++i) {
    enabled = enabled && b.node.axis[i].drive.state.power == DRIVE_OPERATION_ENABLED &&
              b.node.axis[i].objects.state.mode_display == w->mode;
  }
  if (goes_round && (turning_ticks < COUNTED_TICKS || turned_ticks < TURNED_TICKS)) {
    printf("%s: the azimuth turned back for %d ms, until %d ms before the end\n", w->name, turning_ticks, turned_ticks);
    return false;
  }
  const bool predicts = b.node.tracking.objects.back_in_ms != 0;
  if (!enabled || b.node.recorder.phase != SCOPE_WAITING || (!goes_round && predicts != (w->rate_limit != 0))) {
    printf("%s: an axis is not in operation, the scope does not record, or 3075 is wrong; faults %d %d\n", w->name,
           (int)b.node.axis[0].drive.fault, (int)b.node.axis[1].drive.fault);
    return false;
  }
  return true;
}

int main(void) {
  static const work works[] = {
      {"1 kHz task, cyclic velocity", DRIVE_CYCLIC_VELOCITY, LIMIT, NO_LIMIT, false, STAYS},
      {"1 kHz task, cyclic position", DRIVE_CYCLIC_POSITION, LIMIT, NO_LIMIT, false, STAYS},
      {"1 kHz task, cyclic torque", DRIVE_CYCLIC_TORQUE, LIMIT, NO_LIMIT, false, STAYS},
      {"1 kHz task, profile velocity", DRIVE_PROFILE_VELOCITY, LIMIT, NO_LIMIT, false, STAYS},
      {"1 kHz task, profile position", DRIVE_PROFILE_POSITION, LIMIT, NO_LIMIT, false, STAYS},
      {"1 kHz task, tracking", DRIVE_TRACKING, LIMIT, NO_LIMIT, false, STAYS},
      {"1 kHz task, tracking, too fast a target", DRIVE_TRACKING, LIMIT, TOO_SLOW, false, STAYS},
      {"1 kHz task, tracking, with TPDO5 to 8", DRIVE_TRACKING, LIMIT, TOO_SLOW, true, STAYS},
      {"1 kHz task, homing", DRIVE_HOMING, LIMIT, NO_LIMIT, false, STAYS},
      {"1 kHz task, tracking, before, in, after a turn back", DRIVE_TRACKING, LIMIT, NO_LIMIT, false, GOES_ROUND},
      {"1 kHz task, tracking, a turn back, with TPDO5 to 8", DRIVE_TRACKING, LIMIT, NO_LIMIT, true, GOES_ROUND},
      {"1 kHz task, tracking, lost, back, found again", DRIVE_TRACKING, LIMIT, NO_LIMIT, false, COMES_BACK},
      {"1 kHz task, profile position, with TPDO5 to 8", DRIVE_PROFILE_POSITION, LIMIT, NO_LIMIT, true, STAYS},
  };
  static cost_row row;
  static cost_row service = {.name = "deferred task, all modes", .bound = 10500};
  static cost_row streaming = {.name = "deferred task, with TPDO5 to 8", .bound = 10500};
  bool good = instruction_count_start();
  cost_table_head();
  for (unsigned i = 0; i < sizeof works / sizeof works[0]; ++i) {
    good = measure(&works[i], &row, works[i].streams ? &streaming : &service) && good;
    good = cost_row_print(&row) && good;
  }
  good = cost_row_print(&service) && good;
  good = cost_row_print(&streaming) && good;
  return good ? 0 : 1;
}
