/* SPDX-License-Identifier: Apache-2.0 */
/* The self-tests before the interrupts start: all by polling, at the rate of the PWM periods, with the bridges off. */
#include "bridge.h"
#include "clock.h"
#include "connections.h"
#include "hot_code.h"
#include "image_check.h"
#include "machine.h"
#include "ram_test.h"

enum { TEST_TICKS = 40, PERIODS_PER_TICK = 20, TEST_PERIODS = TEST_TICKS * PERIODS_PER_TICK };

/* Of 40 ticks; an encoder gives four readings in each, a gyro one frame. */
enum { MIN_GOOD_TICKS = 38, FEWEST_FRAMES_HEARD = 5 };

#define CYCLES_PER_FRAME (1000.0f * (float)CLOCK_CYCLES_PER_US)
#define MAX_FRAMES_ASTRAY 1.5f

typedef struct {
  uint32_t current_sum_counts[HAL_AXES];
  int angles[HAL_AXES]; /* ticks with an angle */
  int rates[HAL_AXES];  /* ticks with a rate */
  uint32_t frames_before[HAL_AXES];
  uint32_t cycles_before;
} observations;

/* The PWM periods of one tick. Returns false when they do not come. */
static bool observe_tick(hal *machine, observations *seen) {
  for (int period = 0; period < PERIODS_PER_TICK; ++period) {
    if (!current_sense_wait()) {
      return false;
    }
    const current_sense_sample sample = current_sense_read();
    for (int axis = 0; axis < BOARD_AXES; ++axis) {
      seen->current_sum_counts[axis] += sample.current_counts[axis];
    }
    machine->bus_voltage_v = (float)(int32_t)sample.bus_counts * machine->scales.volts_per_count;
    if (period < ENCODER_READS_PER_TICK) {
      encoder_begin_read(machine->encoder, period);
    }
  }
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    board_take_samples(machine, axis);
    seen->angles[axis] += machine->samples[axis].encoder_failed ? 0 : 1;
    seen->rates[axis] += machine->samples[axis].gyro_valid ? 1 : 0;
  }
  return true;
}

static bool measure_offset(hal *machine, const observations *seen, int axis) {
  const float offset_counts = (float)seen->current_sum_counts[axis] / (float)TEST_PERIODS;
  const float error_counts = offset_counts - (float)CURRENT_NOMINAL_OFFSET;
  const bool good = error_counts <= (float)CURRENT_MAX_OFFSET_ERROR && error_counts >= -(float)CURRENT_MAX_OFFSET_ERROR;
  if (good) {
    machine->offset_counts[axis] = offset_counts;
  }
  return good;
}

/* A gyro has a crystal of its own. 40 frames that take 40 ms within one and a half of our clock show that it is right
 * to 4 %. A crystal of another common frequency is far outside. */
typedef enum { GYRO_SILENT, GYRO_AGREES, GYRO_ASTRAY } gyro_pace;

static gyro_pace pace_of(const gyro_line *line, uint32_t frames_before, float frames_by_our_clock) {
  const uint32_t frames = line->frames - frames_before;
  if (frames < FEWEST_FRAMES_HEARD) {
    return GYRO_SILENT;
  }
  const float astray = (float)frames - frames_by_our_clock;
  return astray <= MAX_FRAMES_ASTRAY && astray >= -MAX_FRAMES_ASTRAY ? GYRO_AGREES : GYRO_ASTRAY;
}

/* The bits of an axis that cannot be driven, and of a gyro that is missing or set to another rate. */
static uint32_t judge_axis(hal *machine, const observations *seen, gyro_pace pace, int axis) {
  uint32_t failed = 0;
  if (!measure_offset(machine, seen, axis)) {
    failed |= HAL_TEST_CURRENT_OFFSET;
  }
  if (seen->angles[axis] < MIN_GOOD_TICKS) {
    failed |= axis == 0 ? HAL_TEST_ENCODER_AZIMUTH : HAL_TEST_ENCODER_PITCH;
  }
  machine->axis_bits[axis] = failed;
  if (seen->rates[axis] < MIN_GOOD_TICKS || pace == GYRO_ASTRAY) {
    failed |= axis == 0 ? HAL_TEST_GYRO_AZIMUTH : HAL_TEST_GYRO_PITCH;
  }
  return failed;
}

/* One gyro that agrees shows that the clock is right, and that the other gyro is wrong. */
static uint32_t judge(hal *machine, const observations *seen, float frames_by_our_clock) {
  bool agrees = false;
  bool astray = false;
  uint32_t failed = 0;
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    const gyro_pace pace = pace_of(&machine->gyro[axis], seen->frames_before[axis], frames_by_our_clock);
    agrees = agrees || pace == GYRO_AGREES;
    astray = astray || pace == GYRO_ASTRAY;
    failed |= judge_axis(machine, seen, pace, axis);
  }
  return failed | (astray && !agrees ? HAL_TEST_CLOCK : 0);
}

static uint32_t test_sensors(hal *machine) {
  observations settling = {0};
  observations seen = {0};
  if (!observe_tick(machine, &settling)) {
    return HAL_TEST_CONTROLLER;
  }
  seen.cycles_before = clock_cycles();
  for (int axis = 0; axis < BOARD_AXES; ++axis) {
    seen.frames_before[axis] = machine->gyro[axis].frames;
  }
  for (int tick = 0; tick < TEST_TICKS; ++tick) {
    if (!observe_tick(machine, &seen)) {
      return HAL_TEST_CONTROLLER;
    }
  }
  const float frames_by_our_clock = (float)(clock_cycles() - seen.cycles_before) / CYCLES_PER_FRAME;
  return judge(machine, &seen, frames_by_our_clock);
}

/* With faulty RAM no other result can be trusted. */
uint32_t hal_board_self_test(hal *machine) {
  if (!ram_test_passed()) {
    machine->test_bits |= HAL_TEST_MEMORY;
    return HAL_TEST_MEMORY;
  }
  if (!image_check_is_whole() || !hot_code_is_whole()) {
    machine->test_bits |= HAL_TEST_IMAGE;
  }
  machine->test_bits |= test_sensors(machine);
  return machine->test_bits;
}
