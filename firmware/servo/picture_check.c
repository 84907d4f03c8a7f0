/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/picture_check.h"

#include <math.h>

#include "base/scalar.h"
#include "servo/servo_timing.h"

/* A slow camera needs more time to show that it is wrong. */
static float rate_limit_rad_s(int pictures, uint32_t interval_ticks) {
  const float half = pictures < 3 ? 0.5f : 1.0f;
  const float prompt = (float)PICTURE_PROMPT_TICKS;
  const float ticks = scalar_clamp((float)interval_ticks, prompt, (float)PICTURE_SLOWEST_TICKS);
  return half * PICTURE_UNPROVEN_RAD_S * prompt / ticks;
}

/* Without overwriting the pictures: this happens in each tick in which no axis tracks. */
void picture_check_reset(picture_check *self) {
  image_orientation_reset(&self->pictures);
  self->moved = (image_vector){0};
  self->ticks = 0;
  self->full_limit_rad_s = rate_limit_rad_s(0, PICTURE_SLOWEST_TICKS);
  self->rate_limit_rad_s = self->full_limit_rad_s;
  self->held_ticks = 0;
  self->no_nearer = false;
  self->unjudged_ticks = 0;
  self->verdict = PICTURE_NOT_JUDGED;
  self->complete = false;
  self->doubted = false;
  self->doubted_ticks = 0;
  self->followed_ticks = 0;
  self->roll_rad = 0.0f;
}

/* What one finding says. */
static picture_verdict verdict_of(const orientation_finding *found, float stops_rad) {
  const float roll_rad = scalar_abs(found->roll_rad);
  const bool far = found->moved_rad >= stops_rad;
  if (found->kind == ORIENTATION_UNCLEAR || found->moved_rad < PICTURE_TELLS_RAD) {
    return PICTURE_NOT_JUDGED;
  }
  if (found->kind == ORIENTATION_MIRRORED) {
    return far ? PICTURE_MIRRORED : PICTURE_NOT_JUDGED;
  }
  if (roll_rad <= PICTURE_WARNS_RAD) {
    return PICTURE_RIGHT;
  }
  if (!far) {
    return PICTURE_NOT_JUDGED;
  }
  return roll_rad <= PICTURE_WRONG_RAD ? PICTURE_TURNED : PICTURE_WRONG_ROLL;
}

static void judge(picture_check *self) {
  const float stops_rad = self->verdict == PICTURE_NOT_JUDGED ? PICTURE_STOPS_RAD : PICTURE_CONVICTS_RAD;
  const orientation_finding found = image_orientation_find(&self->pictures, PICTURE_STOPS_RAD);
  const picture_verdict says = verdict_of(&found, stops_rad);
  const bool doubts = says > PICTURE_RIGHT;
  self->doubted_ticks = doubts && self->doubted ? self->doubted_ticks + self->unjudged_ticks : 0;
  self->unjudged_ticks = 0;
  self->doubted = doubts;
  self->complete = says == PICTURE_RIGHT && found.both;
  if (says == PICTURE_RIGHT || self->doubted_ticks >= PICTURE_AGREE_TICKS) {
    self->verdict = says;
    self->roll_rad = found.roll_rad;
  }
}

/* While the limit holds and the target comes no nearer: varies it. */
static void hold(picture_check *self, image_vector moved_rad, bool follows) {
  self->held_ticks = follows ? 0 : self->held_ticks + 1;
  self->held_moved.x += moved_rad.x;
  self->held_moved.y += moved_rad.y;
  const bool slower = self->no_nearer && self->held_ticks / PICTURE_VARIES_TICKS % 2 != 0;
  self->rate_limit_rad_s = slower ? PICTURE_SLOWER * self->full_limit_rad_s : self->full_limit_rad_s;
}

static float length_rad(image_vector of) { return sqrtf(of.x * of.x + of.y * of.y); }

/* With a picture whose target is off by `error_rad`, `step_rad` after the one before. */
static void look_for_an_answer(picture_check *self, float error_rad, float step_rad) {
  if (self->held_ticks == 0 || self->pictures.count <= 1) {
    self->held_ticks = 0;
    self->held_moved = (image_vector){0};
    self->held_path_rad = 0.0f;
    self->held_error_rad = error_rad;
  } else {
    self->held_path_rad += step_rad;
  }
  self->no_nearer = error_rad >= self->held_error_rad;
  const float far_rad = length_rad(self->held_moved);
  const bool runs_away = self->no_nearer && far_rad >= PICTURE_FARTHEST_RAD;
  const bool winds = self->held_path_rad - far_rad >= PICTURE_FARTHEST_RAD;
  if (self->verdict == PICTURE_NOT_JUDGED && (runs_away || winds)) {
    self->verdict = PICTURE_NO_ANSWER;
  }
}

void picture_check_tick(picture_check *self, image_vector moved_rad, bool follows) {
  if (self->unjudged_ticks > 0) {
    judge(self);
  }
  self->moved.x += moved_rad.x;
  self->moved.y += moved_rad.y;
  self->ticks++;
  hold(self, moved_rad, follows);
  self->followed_ticks = (uint16_t)(follows ? self->followed_ticks + 1 : 0);
  if (self->followed_ticks >= PICTURE_PROVEN_TICKS) {
    self->followed_ticks = PICTURE_PROVEN_TICKS;
    self->verdict = self->verdict == PICTURE_NOT_JUDGED ? PICTURE_RIGHT : self->verdict;
  }
}

void picture_check_take(picture_check *self, image_vector error_rad, image_vector since_rad, int age_ticks) {
  const bool decided = self->complete || picture_check_is_wrong(self);
  if (decided || self->ticks < (uint32_t)age_ticks + PICTURE_SPACING_TICKS) {
    return;
  }
  const uint32_t interval_ticks = self->ticks - (uint32_t)age_ticks;
  const orientation_sample sample = {.interval_s = (float)interval_ticks * SERVO_TICK_S,
                                     .moved = {.x = self->moved.x - since_rad.x, .y = self->moved.y - since_rad.y},
                                     .error = error_rad};
  image_orientation_add(&self->pictures, &sample);
  self->moved = since_rad;
  self->ticks = (uint32_t)age_ticks;
  self->full_limit_rad_s = rate_limit_rad_s(self->pictures.count, interval_ticks);
  look_for_an_answer(self, length_rad(error_rad), length_rad(sample.moved));
  self->unjudged_ticks = interval_ticks;
}
