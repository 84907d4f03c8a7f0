/* The self-tests before the interrupts begin: everything is polled, at the pace of the PWM periods, the bridges off. */
#include "board.h"
#include "bridge.h"
#include "clock.h"
#include "ram_test.h"
#include "version_block.h"

enum { TEST_TICKS = 40, PERIODS_PER_TICK = 20, TEST_PERIODS = TEST_TICKS * PERIODS_PER_TICK };

/* Of 40 ticks; an encoder gives four readings in each, a gyro one frame. */
enum { LEAST_GOOD_TICKS = 38, FEWEST_FRAMES_HEARD = 5 };

#define CYCLES_PER_FRAME (1000.0f * (float)CLOCK_CYCLES_PER_US)
#define MOST_FRAMES_ASTRAY 1.5f

typedef struct {
  uint32_t current_sum_counts[2];
  int angles[2]; /* ticks with an angle */
  int rates[2];  /* ticks with a rate */
  uint32_t frames_before[2];
  uint32_t cycles_before;
} observations;

/* One tick's worth of PWM periods. False: they do not come. */
static bool observe_tick(hal *machine, observations *seen) {
  for (int period = 0; period < PERIODS_PER_TICK; ++period) {
    if (!current_sense_wait()) {
      return false;
    }
    const current_sense_sample sample = current_sense_read();
    for (int axis = 0; axis < 2; ++axis) {
      seen->current_sum_counts[axis] += sample.current_counts[axis];
    }
    machine->bus_voltage_v = current_sense_bus_voltage_v(sample.bus_counts);
    if (period < ENCODER_READS_PER_TICK) {
      encoder_begin_read(machine->encoder, period);
    }
  }
  for (int axis = 0; axis < 2; ++axis) {
    machine->angle_known[axis] = encoder_take(&machine->encoder[axis], &machine->angle_turn32[axis]);
    machine->rate_known[axis] = gyro_take(&machine->gyro[axis], axis, &machine->rate_rad_s[axis]);
    seen->angles[axis] += machine->angle_known[axis] ? 1 : 0;
    seen->rates[axis] += machine->rate_known[axis] ? 1 : 0;
  }
  return true;
}

static bool measure_offset(hal *machine, const observations *seen, int axis) {
  const float offset_counts = (float)seen->current_sum_counts[axis] / (float)TEST_PERIODS;
  const float error_counts = offset_counts - (float)CURRENT_NOMINAL_OFFSET;
  const bool good =
      error_counts <= (float)CURRENT_MOST_OFFSET_ERROR && error_counts >= -(float)CURRENT_MOST_OFFSET_ERROR;
  if (good) {
    machine->offset_counts[axis] = offset_counts;
  }
  return good;
}

/* A gyro has a crystal of its own: 40 frames, each 1 ms of our clock but for one and a half, mean that ours is right to
 * 4 %. A crystal of another common frequency is far beyond. */
static bool clock_agrees(const gyro_line *line, uint32_t frames_before, float frames_by_our_clock) {
  const uint32_t frames = line->frames - frames_before;
  const float astray = (float)frames - frames_by_our_clock;
  return frames < FEWEST_FRAMES_HEARD || (astray <= MOST_FRAMES_ASTRAY && astray >= -MOST_FRAMES_ASTRAY);
}

static uint32_t judge_axis(hal *machine, const observations *seen, float frames_by_our_clock, int axis) {
  uint32_t failed = 0;
  if (!measure_offset(machine, seen, axis)) {
    failed |= HAL_TEST_CURRENT_OFFSET;
  }
  if (seen->angles[axis] < LEAST_GOOD_TICKS) {
    failed |= axis == 0 ? HAL_TEST_ENCODER_AZIMUTH : HAL_TEST_ENCODER_PITCH;
  }
  if (seen->rates[axis] < LEAST_GOOD_TICKS) {
    failed |= axis == 0 ? HAL_TEST_GYRO_AZIMUTH : HAL_TEST_GYRO_PITCH;
  }
  if (!clock_agrees(&machine->gyro[axis], seen->frames_before[axis], frames_by_our_clock)) {
    failed |= HAL_TEST_CLOCK;
  }
  return failed;
}

static uint32_t test_sensors(hal *machine) {
  observations settling = {0};
  observations seen = {0};
  if (!observe_tick(machine, &settling)) {
    return HAL_TEST_CONTROLLER;
  }
  seen.cycles_before = clock_cycles();
  seen.frames_before[0] = machine->gyro[0].frames;
  seen.frames_before[1] = machine->gyro[1].frames;
  for (int tick = 0; tick < TEST_TICKS; ++tick) {
    if (!observe_tick(machine, &seen)) {
      return HAL_TEST_CONTROLLER;
    }
  }
  const float frames_by_our_clock = (float)(clock_cycles() - seen.cycles_before) / CYCLES_PER_FRAME;
  return judge_axis(machine, &seen, frames_by_our_clock, 0) | judge_axis(machine, &seen, frames_by_our_clock, 1);
}

/* With RAM that forgets nothing else can be judged. */
uint32_t hal_board_self_test(hal *machine) {
  if (!ram_test_passed()) {
    machine->test_bits |= HAL_TEST_MEMORY;
    return HAL_TEST_MEMORY;
  }
  if (!version_block_image_is_whole()) {
    machine->test_bits |= HAL_TEST_IMAGE;
  }
  machine->test_bits |= test_sensors(machine);
  return machine->test_bits;
}
