/* SPDX-License-Identifier: Apache-2.0 */
#include "protection/encoder_outliers.h"

#include "base/scalar.h"

#define OF_GYRO 0.5f

encoder_verdict encoder_outliers_step(encoder_outliers *outliers, float limit_rad, float increment_change_rad,
                                      float gyro_change_rad) {
  if (scalar_within(increment_change_rad, limit_rad) || !(limit_rad > 0.0f) ||
      scalar_within(increment_change_rad - gyro_change_rad, limit_rad + OF_GYRO * scalar_abs(gyro_change_rad))) {
    outliers->score -= outliers->score > 0 ? 1 : 0;
    return ENCODER_FITS;
  }
  outliers->score += ENCODER_OUTLIER_WEIGHT;
  if (outliers->score < ENCODER_OUTLIERS_FAULT) {
    return ENCODER_OUTLIER;
  }
  outliers->score = ENCODER_OUTLIERS_FAULT;
  return ENCODER_ERRATIC;
}
