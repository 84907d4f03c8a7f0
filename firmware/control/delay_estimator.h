/* SPDX-License-Identifier: Apache-2.0 */
/* How old the camera's frames really are: their errors against the line of sight's own motion.
 *
 * A frame gives the target's place: the line of sight at exposure plus the error in the image. If the frame is older
 * by `error` than its sender states, the line of sight is taken at the wrong instant, and the place has an error of
 *
 *     place error = (rate of the line of sight - rate of the target) * error
 *
 * The target moves smoothly. Wind, friction and sensor noise move the line of sight by 35 urad/s between 1 Hz and
 * 25 Hz, and this part of its rate carries the information. For each component of the image:
 *
 *     place, rate  ->  the same filter: what cannot be predicted of them  ->  least squares for `error`
 *
 * The filter is a predictor of the target (alpha-beta-gamma) with a high-pass of second order at 1.6 Hz against
 * manoeuvres: at 0.16 Hz and first order, a weaving or evasive target was taken for a delay (decision 0037). Its alpha
 * is larger than that of a target alone, because the measured motion of the line of sight drifts as a random walk.
 *
 * The tracking loop turns noise of the camera into motion, so place and rate are not independent. Least squares are
 * unbiased in a closed loop only if what the predictor leaves of the place is white. So a second unknown is estimated
 * for each component, the error of alpha: its regressor is the derivative of the residual with respect to alpha.
 *
 * The noise is known from the residuals, so the result has its own 95 % interval. Residuals that resemble those of the
 * frame before are no noise: the target weaves, and a component says nothing then. Nor does one whose residuals are
 * less than half a count of the camera: rounding hides the motion, and goes with it. Old frames are forgotten with
 * DELAY_MEMORY_S. A residual of more than DELAY_OUTLIER_SIGMA is another target, or a manoeuvre: the predictors begin
 * anew and the sums stay. Among the first DELAY_FEWEST_FRAMES frames it is not known what an outlier is; one of
 * more than some 100 sigma is found when the noise has fallen below a seventh of what the sums say, and the sums begin
 * anew. */
#ifndef TRACKSERVO_CONTROL_DELAY_ESTIMATOR_H
#define TRACKSERVO_CONTROL_DELAY_ESTIMATOR_H

#include <stdbool.h>

#include "control/line_of_sight.h"

#define DELAY_MEMORY_S 300.0f     /* weights fall to 1/e */
#define DELAY_SETTLE_S 2.0f       /* predictors are not believed before */
#define DELAY_OUTLIER_SIGMA 7.0f  /* of the residual */
#define DELAY_LONGEST_GAP_S 0.15f /* between frames */

enum { DELAY_COMPONENTS = 2, DELAY_FEWEST_FRAMES = 50 };

/* Of one frame; components do not roll with the image (N of pointing_tracker.h). */
typedef struct {
  image_vector error;      /* target minus line of sight at exposure, rad */
  image_vector moved;      /* by the line of sight between this exposure and the one before, rad */
  image_vector rate_rad_s; /* of the line of sight at exposure */
  float interval_s;        /* between the exposures, up to DELAY_LONGEST_GAP_S */
  float assumed_s;         /* added to the stated age before `moved` and `rate_rad_s` were taken */
  float count_rad;         /* to which `error` is rounded */
} delay_sample;

typedef struct {
  float value;
  float rate;
  float acceleration;
} delay_predictor;

/* What the high-pass takes away: a first part, then a second part of the rest. */
typedef struct {
  float first;
  float second;
} delay_slow;

/* Weighted sums of products of residual e, filtered rate r and derivative a of the residual; of the last three one
 * factor is that of the frame before. */
typedef struct {
  float ee;
  float er;
  float ea;
  float rr;
  float ra;
  float aa;
  float ee_before;
  float er_before; /* either of them */
  float rr_before;
} delay_sums;

typedef struct {
  delay_predictor place; /* its value is relative to the line of sight */
  delay_predictor rate;
  delay_predictor alpha;
  delay_slow slow[3]; /* of the three residuals */
  float e_before;
  float r_before;
  delay_sums sums;
  float recent_ee; /* mean of e e over about 25 frames */
} delay_component;

typedef struct {
  delay_component component[DELAY_COMPONENTS];
  float running_s; /* since the predictors began; 0: no frame yet */
  float count_rad; /* of the last frame */
  float weight;    /* of the frames in the sums */
  float weight_of_squares;
} delay_estimator;

typedef struct {
  bool known;
  float error_s;      /* true age minus stated age */
  float half_width_s; /* of its 95 % interval */
} delay_error;

/* Forgets sums and predictors. */
void delay_estimator_reset(delay_estimator *self);

/* Restarts the predictors and keeps the sums. Call when frames were missed or a target is new. */
void delay_estimator_restart(delay_estimator *self);

/* Restarts the sums and keeps the predictors. */
void delay_estimator_forget(delay_estimator *self);

/* Adds a frame. One that is not finite, or after a longer gap, restarts the predictors. */
void delay_estimator_add(delay_estimator *self, const delay_sample *sample);

/* Returns the estimate from all frames together. */
delay_error delay_estimator_result(const delay_estimator *self);

#endif
