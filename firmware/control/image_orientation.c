#include "control/image_orientation.h"

#include <math.h>

#include "base/scalar.h"

void image_orientation_reset(image_orientation *self) { *self = (image_orientation){0}; }

static bool is_usable(const orientation_sample *sample) {
  return sample->interval_s > 0.0f && sample->interval_s <= ORIENTATION_LONGEST_S &&
         scalar_within(sample->moved.x, 100.0f) && scalar_within(sample->moved.y, 100.0f) &&
         scalar_within(sample->error.x, 100.0f) && scalar_within(sample->error.y, 100.0f);
}

static void forget_old(image_orientation *self) {
  float age_s = 0.0f;
  for (int i = 1; i < ORIENTATION_SAMPLES && i < self->count; ++i) {
    age_s += self->samples[(self->newest + ORIENTATION_SAMPLES + 1 - i) % ORIENTATION_SAMPLES].interval_s;
    if (age_s > ORIENTATION_WINDOW_S) {
      self->count = i;
    }
  }
}

void image_orientation_add(image_orientation *self, const orientation_sample *sample) {
  if (!is_usable(sample)) {
    self->count = 0;
    return;
  }
  self->newest = (self->newest + 1) % ORIENTATION_SAMPLES;
  self->samples[self->newest] = *sample;
  self->count = self->count < ORIENTATION_SAMPLES ? self->count + 1 : ORIENTATION_SAMPLES;
  forget_old(self);
}

/* Of one picture: time, sight and error since the oldest one. */
enum { TIME = 0, SIGHT_X, SIGHT_Y, ERROR_X, ERROR_Y, COLUMNS };

typedef struct {
  float at[COLUMNS];
} picture_row;

typedef struct {
  float of[COLUMNS][COLUMNS]; /* sums of products */
} row_products;

static void follow(picture_row *row, const orientation_sample *sample, bool first) {
  row->at[TIME] += first ? 0.0f : sample->interval_s;
  row->at[SIGHT_X] += first ? 0.0f : sample->moved.x;
  row->at[SIGHT_Y] += first ? 0.0f : sample->moved.y;
  row->at[ERROR_X] = sample->error.x;
  row->at[ERROR_Y] = sample->error.y;
}

static int oldest_of(const image_orientation *self) {
  return (self->newest + ORIENTATION_SAMPLES + 1 - self->count) % ORIENTATION_SAMPLES;
}

static picture_row mean_of(const image_orientation *self) {
  picture_row row = {0};
  picture_row sum = {0};
  for (int i = 0; i < ORIENTATION_SAMPLES && i < self->count; ++i) {
    follow(&row, &self->samples[(oldest_of(self) + i) % ORIENTATION_SAMPLES], i == 0);
    for (int k = 0; k < COLUMNS; ++k) {
      sum.at[k] += row.at[k];
    }
  }
  for (int k = 0; k < COLUMNS; ++k) {
    sum.at[k] /= (float)self->count;
  }
  return sum;
}

static row_products products_about(const image_orientation *self, const picture_row *mean) {
  picture_row row = {0};
  row_products sums = {0};
  for (int i = 0; i < ORIENTATION_SAMPLES && i < self->count; ++i) {
    follow(&row, &self->samples[(oldest_of(self) + i) % ORIENTATION_SAMPLES], i == 0);
    for (int k = 0; k < COLUMNS; ++k) {
      for (int m = 0; m < COLUMNS; ++m) {
        sums.of[k][m] += (row.at[k] - mean->at[k]) * (row.at[m] - mean->at[m]);
      }
    }
  }
  return sums;
}

/* Takes the straight lines in time out. */
static float product(const row_products *sums, int k, int m) {
  return sums->of[k][m] - sums->of[TIME][k] * sums->of[TIME][m] / sums->of[TIME][TIME];
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

static orientation_fit fit_of(complex_sum sight_and_error, float sight, float error) {
  const float square = sight_and_error.re * sight_and_error.re + sight_and_error.im * sight_and_error.im;
  return (orientation_fit){.n = {.re = -sight_and_error.re, .im = -sight_and_error.im},
                           .left = scalar_max(sight - square / error, 0.0f)};
}

static bool is_good(const orientation_fit *fit, float sight, float error) {
  const float size = sqrtf(fit->n.re * fit->n.re + fit->n.im * fit->n.im);
  return fit->left * (float)ORIENTATION_CLEAR <= sight && size <= ORIENTATION_SCALE * error &&
         size * ORIENTATION_SCALE >= error;
}

orientation_finding image_orientation_find(const image_orientation *self, float least_rad) {
  if (self->count < ORIENTATION_FEWEST) {
    return (orientation_finding){0};
  }
  const picture_row mean = mean_of(self);
  const row_products sums = products_about(self, &mean);
  const float sight = product(&sums, SIGHT_X, SIGHT_X) + product(&sums, SIGHT_Y, SIGHT_Y);
  const float error = product(&sums, ERROR_X, ERROR_X) + product(&sums, ERROR_Y, ERROR_Y);
  const float xx = product(&sums, SIGHT_X, ERROR_X);
  const float yy = product(&sums, SIGHT_Y, ERROR_Y);
  const float xy = product(&sums, SIGHT_X, ERROR_Y);
  const float yx = product(&sums, SIGHT_Y, ERROR_X);
  if (!(error > 0.0f) || !(sight > 0.0f)) {
    return (orientation_finding){0};
  }
  const orientation_fit turned = fit_of((complex_sum){.re = xx + yy, .im = yx - xy}, sight, error);
  const orientation_fit mirrored = fit_of((complex_sum){.re = xx - yy, .im = yx + xy}, sight, error);
  const float second = 2.0f * (float)self->count * least_rad * least_rad;
  const float excludes = (float)ORIENTATION_EXCLUDES;
  const bool is_mirrored =
      mirrored.left * excludes <= turned.left && (turned.left >= second || !is_good(&turned, sight, error));
  const orientation_fit *best = is_mirrored ? &mirrored : &turned;
  orientation_finding found = {
      .both = is_mirrored || (turned.left * excludes <= mirrored.left && mirrored.left >= second),
      .moved_rad = sqrtf(sight / (float)self->count),
      .roll_rad = scalar_atan2(best->n.im, best->n.re),
      .scale = sqrtf(best->n.re * best->n.re + best->n.im * best->n.im) / error};
  if (is_good(best, sight, error)) {
    found.kind = is_mirrored ? ORIENTATION_MIRRORED : ORIENTATION_TURNED;
  }
  return found;
}
