/* SPDX-License-Identifier: Apache-2.0 */
#include "drive/holding_brake.h"

#include "base/scalar.h"

/* Longer than every time and its tolerance. */
#define LONGEST_S 20.0f

static bool contradicts(const holding_brake *brake, const holding_brake_times *times, bool contact_open) {
  const float time_s = brake->coil_on ? times->release_s : times->engage_s;
  return times->feedback_used && contact_open != brake->coil_on && brake->since_s > time_s + HOLDING_BRAKE_TOLERANCE_S;
}

void holding_brake_step(holding_brake *brake, const holding_brake_times *times, bool hold, bool contact_open,
                        float dt_s) {
  brake->since_s = hold == brake->coil_on ? scalar_min(brake->since_s + dt_s, LONGEST_S) : 0.0f;
  brake->coil_on = hold;
  brake->opened = hold && brake->since_s >= times->release_s;
  brake->failed = contradicts(brake, times, contact_open);
}
