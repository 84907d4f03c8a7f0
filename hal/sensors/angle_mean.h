/* Mean of a few angles in 2^-32 turn that lie within half a turn of each other, around the wrap. */
#ifndef TRACKSERVO_SENSORS_ANGLE_MEAN_H
#define TRACKSERVO_SENSORS_ANGLE_MEAN_H

#include <stdint.h>

/* count 1 .. 2^16; rounded to the nearest. */
static inline uint32_t angle_mean(const uint32_t *angle_turn32, int count) {
  int64_t sum = 0;
  for (int i = 1; i < count; ++i) {
    sum += (int32_t)(angle_turn32[i] - angle_turn32[0]);
  }
  const int64_t half = sum < 0 ? -(count / 2) : count / 2;
  return angle_turn32[0] + (uint32_t)(int32_t)((sum + half) / count);
}

#endif
