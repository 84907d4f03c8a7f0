/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/camera_input.h"

#include "base/scalar.h"

#define INTERVAL_WEIGHT 0.0625f
#define LONGER 2.0f          /* than the interval so far: a pause is none */
#define CLOCK_RATIO 1.03125f /* of the interval that is measured to the true one */

enum { HALF_COUNTERS = CAMERA_COUNTERS / 2, ROUNDING = CAMERA_TIMES_PER_TICK / 2 };

control_status camera_input_check(const camera_input_params *params) {
  const scalar_range ranges[] = {
      {params->scale_rad, 1e-9f, 1e-3f},
      {(float)params->min_quality, 1.0f, (float)CAMERA_BEST_QUALITY},
  };
  if ((unsigned)params->time > (unsigned)CAMERA_STROBE_OR_CLOCK || params->mirrored > 1) {
    return CONTROL_OUT_OF_RANGE;
  }
  const control_status status = scalar_check_ranges(ranges, 2);
  return status != CONTROL_OK ? status : camera_mounting_check(&params->mounting);
}

void camera_input_reset(camera_input *input) { *input = (camera_input){0}; }

void camera_input_refuse(camera_input *input, camera_drop why) {
  input->dropped++;
  input->last_drop = why;
}

void camera_input_take_back(camera_input *input, camera_drop why) {
  input->taken--;
  camera_input_refuse(input, why);
}

static pointing_frame drop(camera_input *input, camera_drop why) {
  camera_input_refuse(input, why);
  return (pointing_frame){0};
}

/* Returns whether this message, which is not newer, completes the sign of a sender that has begun anew. `ahead` of the
 * message before; 0: sent again. */
static bool has_restarted(camera_input *input, uint8_t ahead) {
  input->repeated = ahead == 0;
  if (!input->repeated) {
    const bool advances = input->restarts > 0 && ahead <= CAMERA_RESTART_STEP;
    input->restarts = advances ? (uint16_t)(input->restarts + 1) : 1;
  }
  if (input->restarts < CAMERA_RESTART << 2 * input->begun) {
    return false;
  }
  input->begun = (uint8_t)(input->begun + (input->begun < CAMERA_MOST_RESTARTS ? 1 : 0));
  input->in_order = 0;
  input->interval_ticks = 0.0f;
  return true;
}

static void count_in_order(camera_input *input) {
  input->in_order = (uint16_t)(input->in_order + 1);
  if (input->in_order >= CAMERA_COUNTERS) {
    input->in_order = 0;
    input->begun = 0;
  }
}

/* Nothing is known of the time before the first message. */
static void count_skipped(camera_input *input, uint8_t ahead, float ticks) {
  if (!input->heard) {
    return;
  }
  input->missed += (uint32_t)ahead - 1u;
  const bool known = input->interval_ticks > 0.0f;
  const float longest = known ? LONGER * input->interval_ticks : (float)CAMERA_LONGEST_INTERVAL_TICKS;
  const float interval_ticks = scalar_min(ticks / (float)ahead, longest);
  input->interval_ticks += (known ? INTERVAL_WEIGHT : 1.0f) * (interval_ticks - input->interval_ticks);
}

/* Frames that were skipped take time, in which nothing has come. */
static bool has_time(const camera_input *input, uint8_t ahead, float ticks) {
  const float skipped = (float)ahead - (float)CAMERA_LEAD;
  return skipped * input->interval_ticks <= CLOCK_RATIO * ticks;
}

/* Of how many messages in a row each was sent before the one before it. A step by half of the counters is none of them:
 * two senders so far apart must not shut each other out. */
static void count_backwards(camera_input *input, uint8_t ahead) {
  if (ahead > HALF_COUNTERS) {
    input->backwards = (uint8_t)(input->backwards + (input->backwards < CAMERA_RESTART ? 1 : 0));
  } else if (ahead > 0) {
    input->backwards = 0;
  }
}

/* Counts what was skipped. Returns whether the message is newer than all before it. */
static bool is_newer(camera_input *input, uint8_t counter, uint32_t tick) {
  const uint8_t ahead = (uint8_t)(counter - input->last_counter);
  const float ticks = (float)(tick - input->last_tick);
  input->last_tick = tick;
  const uint8_t since_before = (uint8_t)(counter - input->before);
  input->before = counter;
  count_backwards(input, since_before);
  const bool newer = !input->heard || (input->backwards < CAMERA_RESTART && ahead != 0 && ahead < HALF_COUNTERS &&
                                       has_time(input, ahead, ticks));
  if (newer) {
    count_in_order(input);
    count_skipped(input, ahead, ticks);
  } else if (!has_restarted(input, since_before)) {
    return false;
  }
  input->restarts = 0;
  input->heard = true;
  input->last_counter = counter;
  return true;
}

static camera_alignment alignment_of(camera_input *input, const camera_mounting *mounting) {
  if (!input->rolled || input->roll_rad != mounting->roll_rad) {
    input->rolled = true;
    input->roll_rad = mounting->roll_rad;
    input->roll = camera_align(mounting).roll;
  }
  return (camera_alignment){.roll = input->roll, .boresight = mounting->boresight};
}

image_vector camera_input_error(camera_input *input, const camera_input_params *params, const camera_message *message) {
  const camera_alignment alignment = alignment_of(input, &params->mounting);
  const float x = (float)message->x * params->scale_rad;
  const image_vector measured = {.x = params->mirrored != 0 ? -x : x, .y = (float)message->y * params->scale_rad};
  return camera_error(&alignment, measured);
}

/* At the end of int16_t it says where the target is, but not how far. */
static bool is_beyond(const camera_message *message, image_vector error) {
  const bool ends =
      !scalar_within((float)message->x, INT16_MAX - 0.5f) || !scalar_within((float)message->y, INT16_MAX - 0.5f);
  return ends || error.x * error.x + error.y * error.y >= SCALAR_PI * SCALAR_PI;
}

pointing_frame camera_input_take(camera_input *input, const camera_input_params *params, const camera_message *message,
                                 image_vector error, int32_t age, uint32_t tick) {
  if (message->quality > CAMERA_BEST_QUALITY) {
    return drop(input, CAMERA_BAD_QUALITY);
  }
  if (age < 0) {
    return drop(input, age == CAMERA_AGE_AMBIGUOUS ? CAMERA_CLOCK_SET : CAMERA_IN_FUTURE);
  }
  const int age_ticks = (int)(age + ROUNDING) / CAMERA_TIMES_PER_TICK;
  if (age_ticks > CAMERA_LONGEST_AGE_TICKS) {
    return drop(input, CAMERA_TOO_OLD);
  }
  if (!is_newer(input, message->counter, tick)) {
    return drop(input, CAMERA_NOT_NEWER);
  }
  const bool found = message->quality >= params->min_quality;
  if (found && is_beyond(message, error)) {
    return drop(input, CAMERA_BEYOND);
  }
  input->taken++;
  return (pointing_frame){.fresh = true, .valid = found, .age_ticks = age_ticks, .error = error};
}
