/* SPDX-License-Identifier: Apache-2.0 */
#include "control/image_orientation.h"

#include <math.h>

#include "base/scalar.h"

void image_orientation_reset(image_orientation *self) { self->count = 0; }

static bool is_usable(const orientation_sample *sample) {
  return sample->interval_s > 0.0f && sample->interval_s <= ORIENTATION_LONGEST_S &&
         scalar_within(sample->moved.x, 100.0f) && scalar_within(sample->moved.y, 100.0f) &&
         scalar_within(sample->error.x, 100.0f) && scalar_within(sample->error.y, 100.0f);
}

void image_orientation_add(image_orientation *self, const orientation_sample *sample) {
  if (!is_usable(sample)) {
    self->count = 0;
    return;
  }
  self->newest = (self->newest + 1) % ORIENTATION_SAMPLES;
  self->samples[self->newest] = *sample;
  self->count = self->count < ORIENTATION_SAMPLES ? self->count + 1 : ORIENTATION_SAMPLES;
}

/* Of one picture: time, way of the sight and error, since a common start. */
typedef struct {
  float time_s;
  image_vector sight;
  image_vector error;
} picture_row;

/* Sums over the pictures, and sums of products. */
typedef struct {
  int count;
  picture_row sum;
  float time_time;
  image_vector time_sight;
  image_vector time_error;
  float sight; /* squares */
  float error;
  float xx; /* of the sight and the error, in this order */
  float xy;
  float yx;
  float yy;
} picture_sums;

static void add_row(picture_sums *sums, const picture_row *row) {
  const image_vector sight = row->sight;
  const image_vector error = row->error;
  sums->count++;
  sums->sum.time_s += row->time_s;
  sums->sum.sight.x += sight.x;
  sums->sum.sight.y += sight.y;
  sums->sum.error.x += error.x;
  sums->sum.error.y += error.y;
  sums->time_time += row->time_s * row->time_s;
  sums->time_sight.x += row->time_s * sight.x;
  sums->time_sight.y += row->time_s * sight.y;
  sums->time_error.x += row->time_s * error.x;
  sums->time_error.y += row->time_s * error.y;
  sums->sight += sight.x * sight.x + sight.y * sight.y;
  sums->error += error.x * error.x + error.y * error.y;
  sums->xx += sight.x * error.x;
  sums->xy += sight.x * error.y;
  sums->yx += sight.y * error.x;
  sums->yy += sight.y * error.y;
}

/* Of the pictures within ORIENTATION_WINDOW_S, the newest first. They start near their mean: a float keeps more then.
 */
static picture_sums sums_of(const image_orientation *self) {
  const orientation_sample *newest = &self->samples[self->newest];
  const float half = 0.5f * (float)self->count;
  const float oldest_s = half * newest->interval_s - ORIENTATION_WINDOW_S;
  picture_row row = {.time_s = half * newest->interval_s,
                     .sight = {.x = half * newest->moved.x, .y = half * newest->moved.y}};
  picture_sums sums = {0};
  int place = self->newest;
  for (int i = 0; i < ORIENTATION_SAMPLES && i < self->count && row.time_s >= oldest_s; ++i) {
    const orientation_sample *sample = &self->samples[place];
    row.error.x = sample->error.x - newest->error.x;
    row.error.y = sample->error.y - newest->error.y;
    add_row(&sums, &row);
    row.time_s -= sample->interval_s;
    row.sight.x -= sample->moved.x;
    row.sight.y -= sample->moved.y;
    place = place > 0 ? place - 1 : ORIENTATION_SAMPLES - 1;
  }
  return sums;
}

/* Takes out what is along u, of which `squares` is the sum of squares, and the others those of the products with u. */
static void take_out(picture_sums *sums, float squares, image_vector sight, image_vector error) {
  const image_vector by = {.x = error.x / squares, .y = error.y / squares};
  sums->sight -= (sight.x * sight.x + sight.y * sight.y) / squares;
  sums->error -= error.x * by.x + error.y * by.y;
  sums->xx -= sight.x * by.x;
  sums->xy -= sight.x * by.y;
  sums->yx -= sight.y * by.x;
  sums->yy -= sight.y * by.y;
}

static void take_means_out(picture_sums *sums) {
  const picture_row *sum = &sums->sum;
  const float mean_s = sum->time_s / (float)sums->count;
  sums->time_time -= mean_s * sum->time_s;
  sums->time_sight.x -= mean_s * sum->sight.x;
  sums->time_sight.y -= mean_s * sum->sight.y;
  sums->time_error.x -= mean_s * sum->error.x;
  sums->time_error.y -= mean_s * sum->error.y;
  take_out(sums, (float)sums->count, sum->sight, sum->error);
}

typedef struct {
  float re;
  float im;
} complex_sum;

/* A fit of the one kind or of the other. */
typedef struct {
  complex_sum n; /* times the squares of the error */
  float left;    /* of the squares of the sight */
} orientation_fit;

static orientation_fit fit_of(complex_sum sight_and_error, const picture_sums *sums) {
  const float square = sight_and_error.re * sight_and_error.re + sight_and_error.im * sight_and_error.im;
  return (orientation_fit){.n = {.re = -sight_and_error.re, .im = -sight_and_error.im},
                           .left = scalar_max(sums->sight - square / sums->error, 0.0f)};
}

static bool is_good(const orientation_fit *fit, const picture_sums *sums) {
  const float size = sqrtf(fit->n.re * fit->n.re + fit->n.im * fit->n.im);
  return fit->left * (float)ORIENTATION_CLEAR <= sums->sight && size <= ORIENTATION_SCALE * sums->error &&
         size * ORIENTATION_SCALE >= sums->error;
}

orientation_finding image_orientation_find(const image_orientation *self, float least_rad) {
  picture_sums sums = sums_of(self);
  if (sums.count < ORIENTATION_FEWEST) {
    return (orientation_finding){0};
  }
  take_means_out(&sums);
  take_out(&sums, sums.time_time, sums.time_sight, sums.time_error); /* the straight lines */
  if (!(sums.error > 0.0f) || !(sums.sight > 0.0f)) {
    return (orientation_finding){0};
  }
  const orientation_fit turned = fit_of((complex_sum){.re = sums.xx + sums.yy, .im = sums.yx - sums.xy}, &sums);
  const orientation_fit mirrored = fit_of((complex_sum){.re = sums.xx - sums.yy, .im = sums.yx + sums.xy}, &sums);
  const float second = 2.0f * (float)sums.count * least_rad * least_rad;
  const float excludes = (float)ORIENTATION_EXCLUDES;
  const bool is_mirrored =
      mirrored.left * excludes <= turned.left && (turned.left >= second || !is_good(&turned, &sums));
  const orientation_fit *best = is_mirrored ? &mirrored : &turned;
  orientation_finding found = {
      .both = is_mirrored || (turned.left * excludes <= mirrored.left && mirrored.left >= second),
      .moved_rad = sqrtf(sums.sight / (float)sums.count),
      .roll_rad = scalar_atan2(best->n.im, best->n.re),
      .scale = sqrtf(best->n.re * best->n.re + best->n.im * best->n.im) / sums.error};
  if (is_good(best, &sums)) {
    found.kind = is_mirrored ? ORIENTATION_MIRRORED : ORIENTATION_TURNED;
  }
  return found;
}
