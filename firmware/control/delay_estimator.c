/* SPDX-License-Identifier: Apache-2.0 */
#include "control/delay_estimator.h"

#include <math.h>

#include "base/scalar.h"

#define TARGET_RAD_S 3.5f    /* bandwidth of the predictors */
#define FIRST_FRAMES 6.0f    /* they begin faster: bandwidth times time since the beginning */
#define DRIFT_RAD_S 14.0f    /* alpha follows the drift of the measured motion */
#define SLOW_RAD_S 10.0f     /* high-pass of the residuals: two of first order */
#define QUANTILE_95 1.96f    /* of the normal distribution, two-sided */
#define CURVATURE 1.4f       /* the interval is wider than that of linear least squares (Monte Carlo) */
#define MOST_ALIKE 0.6f      /* correlation of residuals in a row: a weave of 2 Hz at 50 Hz has 0.97, wind 0.5 */
#define LEAST_COUNTS 0.5f    /* of the residual, rms */
#define LEAST_REST 0.05f     /* share of the residual's square that the delay must leave to be judged by it */
#define RECENT_SHARE 0.04f   /* of a frame in the noise of the last half second */
#define FIRST_SUMS 250.0f    /* frames after which an outlier among the first ones has shown */
#define MIN_INDEPENDENT 0.1f /* share of the filtered rate that must not be explained by alpha's error */

typedef struct {
  float interval_s;
  float alpha;
  float beta_per_s;
  float gamma_per_s2;
  float slow; /* share of the step that the high-pass follows */
} filter_gains;

void delay_estimator_reset(delay_estimator *self) { *self = (delay_estimator){0}; }

static void begin(delay_component *component) {
  component->place = (delay_predictor){0};
  component->rate = (delay_predictor){0};
  component->alpha = (delay_predictor){0};
  for (int i = 0; i < 3; ++i) {
    component->slow[i] = (delay_slow){0};
  }
  component->e_before = 0.0f;
  component->r_before = 0.0f;
}

void delay_estimator_restart(delay_estimator *self) {
  for (int i = 0; i < DELAY_COMPONENTS; ++i) {
    begin(&self->component[i]);
  }
  self->running_s = 0.0f;
}

void delay_estimator_forget(delay_estimator *self) {
  for (int i = 0; i < DELAY_COMPONENTS; ++i) {
    self->component[i].sums = (delay_sums){0};
  }
  self->weight = 0.0f;
  self->weight_of_squares = 0.0f;
}

static filter_gains gains_of(float interval_s, float running_s) {
  const float pole = scalar_exp_minus(scalar_max(TARGET_RAD_S, FIRST_FRAMES / running_s) * interval_s);
  const float gap = 1.0f - pole;
  return (filter_gains){
      .interval_s = interval_s,
      .alpha = scalar_max(1.0f - pole * pole * pole, 1.0f - scalar_exp_minus(DRIFT_RAD_S * interval_s)),
      .beta_per_s = 1.5f * gap * gap * (1.0f + pole) / interval_s,
      .gamma_per_s2 = gap * gap * gap / (interval_s * interval_s),
      .slow = 1.0f - scalar_exp_minus(SLOW_RAD_S * interval_s)};
}

/* What could not be predicted of `measured`. */
static float predict(delay_predictor *self, const filter_gains *gains, float measured) {
  const float interval_s = gains->interval_s;
  self->value += (self->rate + 0.5f * self->acceleration * interval_s) * interval_s;
  self->rate += self->acceleration * interval_s;
  const float residual = measured - self->value;
  self->value += gains->alpha * residual;
  self->rate += gains->beta_per_s * residual;
  self->acceleration += gains->gamma_per_s2 * residual;
  return residual;
}

static float high_pass(delay_slow *state, const filter_gains *gains, float value) {
  const float rest = value - state->first;
  state->first += gains->slow * rest;
  const float fast = rest - state->second;
  state->second += gains->slow * fast;
  return fast;
}

typedef struct {
  float e;
  float r;
  float a;
} residuals;

static residuals filter(delay_component *self, const filter_gains *gains, float error, float moved, float rate) {
  self->place.value -= moved;
  const float e = predict(&self->place, gains, error);
  const float r = predict(&self->rate, gains, rate);
  const float a = predict(&self->alpha, gains, 0.0f);
  self->alpha.value += e;
  return (residuals){.e = high_pass(&self->slow[0], gains, e),
                     .r = high_pass(&self->slow[1], gains, r),
                     .a = high_pass(&self->slow[2], gains, a)};
}

static void add(delay_component *component, const residuals *of, float keep) {
  delay_sums *sums = &component->sums;
  const float e = component->e_before;
  const float r = component->r_before;
  sums->ee_before = keep * sums->ee_before + of->e * e;
  sums->er_before = keep * sums->er_before + (of->e * r + of->r * e);
  sums->rr_before = keep * sums->rr_before + of->r * r;
  component->e_before = of->e;
  component->r_before = of->r;
  sums->ee = keep * sums->ee + of->e * of->e;
  sums->er = keep * sums->er + of->e * of->r;
  sums->ea = keep * sums->ea + of->e * of->a;
  sums->rr = keep * sums->rr + of->r * of->r;
  sums->ra = keep * sums->ra + of->r * of->a;
  sums->aa = keep * sums->aa + of->a * of->a;
}

static bool is_outlier(const delay_estimator *self, int i, float residual) {
  const float square = self->component[i].sums.ee * DELAY_OUTLIER_SIGMA * DELAY_OUTLIER_SIGMA;
  return self->weight >= (float)DELAY_FEWEST_FRAMES && !(residual * residual * self->weight <= square);
}

/* Among the first DELAY_FEWEST_FRAMES nothing tells an outlier. It shows later, when the noise has fallen to less than
 * an outlier's tolerance. Not for ever: the noise also falls when what moves the line of sight ends. */
static bool began_with_an_outlier(const delay_estimator *self) {
  const float rounding_rad = LEAST_COUNTS * self->count_rad;
  const float tolerance = DELAY_OUTLIER_SIGMA * DELAY_OUTLIER_SIGMA * self->weight;
  bool began = false;
  for (int i = 0; i < DELAY_COMPONENTS; ++i) {
    const float noise = scalar_max(self->component[i].recent_ee, rounding_rad * rounding_rad);
    began = began || self->component[i].sums.ee > tolerance * noise;
  }
  return began && self->weight >= (float)DELAY_FEWEST_FRAMES && self->weight <= FIRST_SUMS;
}

static bool is_usable(const delay_sample *sample) {
  const float parts[] = {sample->error.x, sample->error.y,      sample->moved.x,
                         sample->moved.y, sample->rate_rad_s.x, sample->rate_rad_s.y};
  bool usable = sample->interval_s > 0.0f && sample->interval_s <= DELAY_LONGEST_GAP_S;
  for (int i = 0; i < 6; ++i) {
    usable = usable && scalar_within(parts[i], 100.0f);
  }
  return usable && scalar_within(sample->assumed_s, 1.0f);
}

/* The first place is known as well as the error of the first frame, the target's rate is that of the line of sight. */
static void start(delay_component *self, float error, float rate) {
  self->place = (delay_predictor){.value = error, .rate = rate};
  self->rate = (delay_predictor){.value = rate};
}

void delay_estimator_add(delay_estimator *self, const delay_sample *sample) {
  if (!is_usable(sample)) {
    delay_estimator_restart(self);
    return;
  }
  const float error[DELAY_COMPONENTS] = {sample->error.x, sample->error.y};
  const float moved[DELAY_COMPONENTS] = {sample->moved.x, sample->moved.y};
  const float rate[DELAY_COMPONENTS] = {sample->rate_rad_s.x, sample->rate_rad_s.y};
  const bool first = self->running_s <= 0.0f;
  self->running_s = scalar_min(self->running_s + sample->interval_s, 100.0f);
  if (first) {
    for (int i = 0; i < DELAY_COMPONENTS; ++i) {
      start(&self->component[i], error[i], rate[i]);
    }
    return;
  }
  self->count_rad = sample->count_rad;
  const filter_gains gains = gains_of(sample->interval_s, self->running_s);
  residuals found[DELAY_COMPONENTS];
  bool outlier = false;
  for (int i = 0; i < DELAY_COMPONENTS; ++i) {
    found[i] = filter(&self->component[i], &gains, error[i], moved[i], rate[i]);
    outlier = outlier || is_outlier(self, i, found[i].e);
  }
  if (self->running_s < DELAY_SETTLE_S) {
    return;
  }
  if (outlier) {
    delay_estimator_restart(self);
    return;
  }
  const float keep = 1.0f - sample->interval_s / DELAY_MEMORY_S;
  self->weight = keep * self->weight + 1.0f;
  self->weight_of_squares = keep * keep * self->weight_of_squares + 1.0f;
  for (int i = 0; i < DELAY_COMPONENTS; ++i) {
    delay_component *component = &self->component[i];
    found[i].e += sample->assumed_s * found[i].r;
    add(component, &found[i], keep);
    component->recent_ee += RECENT_SHARE * (found[i].e * found[i].e - component->recent_ee);
  }
  if (began_with_an_outlier(self)) {
    delay_estimator_forget(self);
  }
}

/* The sums of one component without what alpha's error explains: information on the delay, and what it says. */
static void collect(const delay_sums *sums, float weight, float count_rad, float *information, float *said) {
  if (!(sums->aa > 0.0f)) {
    return;
  }
  const float rr = sums->rr - sums->ra * sums->ra / sums->aa;
  const float er = sums->er - sums->ea * sums->ra / sums->aa;
  const float ee = sums->ee - sums->ea * sums->ea / sums->aa;
  if (!(rr > MIN_INDEPENDENT * sums->rr)) {
    return;
  }
  const float error_s = er / rr;
  const float rest = sums->ee - error_s * (2.0f * sums->er - error_s * sums->rr);
  const float alike = sums->ee_before - error_s * (sums->er_before - error_s * sums->rr_before);
  const float variance = (ee - er * error_s) / weight;
  const bool weaves = rest > LEAST_REST * sums->ee && alike > MOST_ALIKE * rest;
  const bool rounded = sums->ee < LEAST_COUNTS * LEAST_COUNTS * count_rad * count_rad * weight;
  if (variance > 0.0f && !weaves && !rounded) {
    *information += rr / variance;
    *said += er / variance;
  }
}

delay_error delay_estimator_result(const delay_estimator *self) {
  float information = 0.0f;
  float said = 0.0f;
  if (self->weight >= (float)DELAY_FEWEST_FRAMES) {
    for (int i = 0; i < DELAY_COMPONENTS; ++i) {
      collect(&self->component[i].sums, self->weight, self->count_rad, &information, &said);
    }
  }
  if (!(information > 1.0f)) { /* an interval of more than +-2 s says nothing */
    return (delay_error){0};
  }
  return (delay_error){
      .known = true,
      .error_s = said / information,
      .half_width_s = CURVATURE * QUANTILE_95 * sqrtf(self->weight_of_squares / (self->weight * information))};
}
