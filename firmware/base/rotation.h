/* SPDX-License-Identifier: Apache-2.0 */
/* A rotation in a plane, as sine and cosine of its angle. */
#ifndef TRACKSERVO_BASE_ROTATION_H
#define TRACKSERVO_BASE_ROTATION_H

#include "base/angle.h"

typedef struct {
  float sine;
  float cosine;
} rotation;

/* Returns sine and cosine of any angle, with an error of at most 1.2e-7. */
rotation rotation_of(angle_turn32 angle);

/* Returns the cosine alone, for half the instructions. */
float rotation_cosine(angle_turn32 angle);

#endif
