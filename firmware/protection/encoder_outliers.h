/* SPDX-License-Identifier: Apache-2.0 */
/* Names an encoder that is wrong in some ticks only: a reading that is one tick old, a bit that flips.
 *
 *     e = change of the encoder's increment - change of the gyro's rate dt
 *
 * A tick with |e| above the limit plus half of the gyro's change (its bandwidth) is an outlier, if the encoder's own
 * change is above the limit: otherwise the gyro is wrong. An outlier adds ENCODER_OUTLIER_WEIGHT to a score, every
 * other tick takes 1 away; a fault is a score of ENCODER_OUTLIERS_FAULT. One wrong reading makes three outliers, so two
 * within some 60 ticks are a fault, one alone is none. Below 5 % of outliers the score does not grow. Cost: about 10
 * instructions, 30 while the axis accelerates by more than the limit. */
#ifndef TRACKSERVO_PROTECTION_ENCODER_OUTLIERS_H
#define TRACKSERVO_PROTECTION_ENCODER_OUTLIERS_H

enum { ENCODER_OUTLIER_WEIGHT = 20, ENCODER_OUTLIERS_FAULT = 80 };

typedef struct {
  int score;
} encoder_outliers;

typedef enum {
  ENCODER_FITS,
  ENCODER_OUTLIER, /* the increment of this tick is no measure of the rate */
  ENCODER_ERRATIC  /* the same, and a fault */
} encoder_verdict;

/* Checks one tick; both changes are from the last tick to this one. A limit of 0 finds nothing. */
encoder_verdict encoder_outliers_step(encoder_outliers *outliers, float limit_rad, float increment_change_rad,
                                      float gyro_change_rad);

#endif
