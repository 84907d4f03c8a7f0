/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/camera_delay.h"

#include "base/scalar.h"

enum {
  RATE_TICKS = 3,   /* on each side of the exposure, from which its rate is taken */
  NEWEST_TICKS = 1, /* the motion is known up to the last tick */
  LONGEST_TICKS = TARGET_TRACKER_HISTORY - 1 - RATE_TICKS
};

#define FEWEST_TICKS 1.0f /* in which the believed error changes */
#define SURE 2.0f         /* half intervals: of many estimates, some are off by more than 1.0 by chance */
#define LONGER_STEP 1.25f
#define FAR_TICKS 3.0f

void camera_delay_reset(camera_delay *self) { *self = (camera_delay){.ticks_since = TARGET_TRACKER_HISTORY - 1}; }

static int clamp(int value, int low, int high) {
  if (value < low) {
    return low;
  }
  return value > high ? high : value;
}

int camera_delay_age(const camera_delay *self, const camera_delay_params *params, int stated_ticks) {
  const int offset = params->use == CAMERA_DELAY_CORRECTED ? self->offset_ticks : 0;
  return clamp(stated_ticks + offset, 0, TARGET_TRACKER_HISTORY - 1);
}

void camera_delay_notice(camera_delay *self, const pointing_frame *frame) {
  if (frame->fresh && frame->valid && self->stage == CAMERA_DELAY_WAITS) {
    self->frame = *frame;
    self->stage = CAMERA_DELAY_FRAME;
  }
}

void camera_delay_leave_out(camera_delay *self) {
  self->stage = self->stage == CAMERA_DELAY_FRAME ? CAMERA_DELAY_WAITS : self->stage;
}

static image_vector minus(image_vector a, image_vector b) { return (image_vector){.x = a.x - b.x, .y = a.y - b.y}; }

static void gather(camera_delay *self, const pointing_tracker_state *tracker, float count_rad, float tick_s) {
  const int stated = self->frame.age_ticks;
  const int age = clamp(stated + self->offset_ticks - NEWEST_TICKS, RATE_TICKS, LONGEST_TICKS);
  const image_vector moved_since = pointing_tracker_los_motion(tracker, age, tick_s);
  const image_vector moved = minus(pointing_tracker_los_motion(tracker, self->ticks_since, tick_s), moved_since);
  const image_vector around = minus(pointing_tracker_los_motion(tracker, age + RATE_TICKS, tick_s),
                                    pointing_tracker_los_motion(tracker, age - RATE_TICKS, tick_s));
  const float per_s = 1.0f / ((float)(2 * RATE_TICKS) * tick_s);
  pointing_frame frame = self->frame;
  frame.age_ticks = age;
  self->sample = (delay_sample){.error = pointing_tracker_frame_error(tracker, &frame),
                                .moved = {.x = moved.x + self->moved_since.x, .y = moved.y + self->moved_since.y},
                                .rate_rad_s = {.x = around.x * per_s, .y = around.y * per_s},
                                .interval_s = (float)self->ticks_since * tick_s,
                                .assumed_s = (float)(age + NEWEST_TICKS - stated) * tick_s,
                                .count_rad = count_rad};
  if (self->ticks_since >= TARGET_TRACKER_HISTORY - 1) {
    delay_estimator_restart(&self->estimator);
    self->sample.interval_s = 0.0f; /* what it moved since then is not known */
  }
  self->moved_since = moved_since;
  self->ticks_since = 0;
}

/* A step is longer than the difference, because the rate at the believed instant says less of the motion at another.
 * What was found far from the truth is forgotten. */
static void conclude(camera_delay *self, float tick_s) {
  self->found = delay_estimator_result(&self->estimator);
  const float half_ticks = self->found.half_width_s / tick_s;
  const float step = self->found.error_s / tick_s - (float)self->offset_ticks;
  if (!self->found.known || self->found.half_width_s > CAMERA_DELAY_GOOD_ENOUGH_S ||
      scalar_within(step, scalar_max(FEWEST_TICKS, SURE * half_ticks))) {
    return;
  }
  const float most = (float)CAMERA_DELAY_MOST_TICKS;
  self->offset_ticks = (int)scalar_round(scalar_clamp((float)self->offset_ticks + LONGER_STEP * step, -most, most));
  if (!scalar_within(step, FAR_TICKS)) {
    delay_estimator_forget(&self->estimator);
  }
}

static void pause(camera_delay *self) {
  if (self->tracked_ticks != 0) {
    delay_estimator_restart(&self->estimator);
  }
  self->tracked_ticks = 0;
  self->ticks_since = TARGET_TRACKER_HISTORY - 1;
  self->stage = CAMERA_DELAY_WAITS;
}

void camera_delay_step(camera_delay *self, const camera_delay_params *params, const pointing_tracker_state *tracker,
                       float count_rad, bool tracks, float tick_s) {
  if (params->use == CAMERA_DELAY_IGNORED) {
    camera_delay_reset(self);
    return;
  }
  if (!tracks) {
    pause(self);
    return;
  }
  if (self->tracked_ticks < TARGET_TRACKER_HISTORY) { /* the motion is not known for long enough */
    self->tracked_ticks++;
    self->stage = CAMERA_DELAY_WAITS;
    return;
  }
  if (self->ticks_since < TARGET_TRACKER_HISTORY - 1) {
    self->ticks_since++;
  }
  switch (self->stage) {
    case CAMERA_DELAY_FRAME:
      gather(self, tracker, count_rad, tick_s);
      self->stage = CAMERA_DELAY_SAMPLE;
      break;
    case CAMERA_DELAY_SAMPLE:
      delay_estimator_add(&self->estimator, &self->sample);
      self->stage = CAMERA_DELAY_SUMS;
      break;
    case CAMERA_DELAY_SUMS:
      conclude(self, tick_s);
      self->stage = CAMERA_DELAY_WAITS;
      break;
    default:
      break;
  }
}

static bool is_well_known(const camera_delay *self) {
  return self->found.known && self->found.half_width_s <= CAMERA_DELAY_WELL_KNOWN_S;
}

static float dither_amplitude(camera_delay *self, const camera_delay_params *params, bool by_user, float tick_s) {
  if (by_user) {
    return params->dither_rad;
  }
  const bool tracks = self->tracked_ticks == TARGET_TRACKER_HISTORY;
  if (!tracks || !(params->first_dither_rad > 0.0f) || is_well_known(self) ||
      self->first_dither_s >= CAMERA_DELAY_FIRST_DITHER_S) {
    return 0.0f;
  }
  self->first_dither_s += tick_s;
  return params->first_dither_rad;
}

float camera_delay_dither(camera_delay *self, const camera_delay_params *params, bool by_user, float tick_s) {
  const float amplitude_rad = dither_amplitude(self, params, by_user, tick_s);
  if (!(amplitude_rad > 0.0f)) {
    self->dither_phase = 0;
    return 0.0f;
  }
  const float rad_s = 2.0f * SCALAR_PI * params->dither_hz;
  self->dither_phase += (angle_turn32)angle_integer(scalar_round(rad_s * tick_s / ANGLE_RAD_PER_TURN32));
  return amplitude_rad * rad_s * rotation_of(self->dither_phase).sine;
}
