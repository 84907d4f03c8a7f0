/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/strobe_log.h"

enum { US_PER_TIME = 10, HALF_COUNTERS = 128, FUTURE_US = 1000000 };

void strobe_log_reset(strobe_log *self) { *self = (strobe_log){0}; }

void strobe_log_add(strobe_log *self, const hal_strobes *strobes) {
  self->floods += strobes->flooded ? 1u : 0u;
  for (uint32_t i = 0; i < HAL_STROBES && i < strobes->count; ++i) {
    self->at_us[self->edges % STROBE_LOG_EDGES] = strobes->at_us[i];
    self->edges++;
  }
}

uint32_t strobe_log_newest_us(const strobe_log *self) {
  return self->edges == 0 ? 0 : self->at_us[(self->edges - 1u) % STROBE_LOG_EDGES];
}

/* The number of edges within the window, and one of them. The newest come first, so all after the first that is too old
 * are, and stay so: also when the clock has gone round. */
static uint32_t count_in_window(strobe_log *self, const strobe_params *params, uint32_t now_us, uint32_t *number,
                                uint32_t *age_us) {
  const int32_t youngest_us = (int32_t)params->youngest * US_PER_TIME;
  const int32_t oldest_us = (int32_t)params->oldest * US_PER_TIME;
  uint32_t found = 0;
  for (uint32_t back = 1; back <= STROBE_LOG_EDGES && back <= self->edges - self->past; ++back) {
    const uint32_t edge = self->edges - back;
    const int32_t age = (int32_t)(now_us - self->at_us[edge % STROBE_LOG_EDGES] - params->half_exposure_us);
    if (age > oldest_us || age < -FUTURE_US) {
      self->past = edge + 1u;
      break;
    }
    if (age >= youngest_us) {
      *number = edge;
      *age_us = (uint32_t)age;
      found++;
    }
  }
  return found;
}

/* What edges and frames differ by since the last order. */
static void count_difference(strobe_log *self, uint8_t step) {
  const uint8_t ahead = (uint8_t)(step - self->step);
  const int32_t more = ahead < 128u ? (int32_t)ahead : (int32_t)ahead - 256;
  self->additional += more > 0 ? (uint32_t)more : 0u;
  self->missing += more < 0 ? (uint32_t)-more : 0u;
}

static bool agrees(strobe_log *self, uint8_t step) {
  if (self->in_step && step == self->step) {
    self->others = 0;
    return true;
  }
  self->others = (uint8_t)(self->others != 0 && step == self->other_step ? self->others + 1 : 1);
  self->other_step = step;
  if (self->others < STROBE_LOG_AGREE) {
    return false;
  }
  if (self->in_step) {
    count_difference(self, step);
  }
  self->in_step = true;
  self->step = step;
  self->others = 0;
  return true;
}

static strobe_refusal judge(strobe_log *self, const strobe_params *params, uint8_t counter, uint32_t now_us) {
  uint32_t number = 0;
  uint32_t age_us = 0;
  const uint32_t found = count_in_window(self, params, now_us, &number, &age_us);
  if (found != 1) {
    return found == 0 ? STROBE_NONE : STROBE_SEVERAL;
  }
  if (!agrees(self, (uint8_t)(number - counter))) {
    return STROBE_OUT_OF_ORDER;
  }
  self->age_us = age_us;
  return STROBE_FOUND;
}

bool strobe_log_pair(strobe_log *self, const strobe_params *params, uint8_t counter, uint32_t now_us) {
  const uint8_t ahead = (uint8_t)(counter - self->last_counter);
  if (self->heard && ahead == 0) {
    return false;
  }
  if (self->heard && ahead >= HALF_COUNTERS) { /* a sender that began anew */
    self->in_step = false;
    self->others = 0;
  }
  self->heard = true;
  self->last_counter = counter;
  const strobe_refusal refusal = judge(self, params, counter, now_us);
  if (refusal == STROBE_FOUND) {
    self->paired++;
  } else {
    self->unpaired++;
    self->last_refusal = refusal;
  }
  return refusal == STROBE_FOUND;
}
