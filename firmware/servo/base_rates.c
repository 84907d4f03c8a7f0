/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/base_rates.h"

#include "base/scalar.h"
#include "servo/servo_timing.h"

void base_rates_reset(base_rates *self) { *self = (base_rates){.known = false}; }

static base_rates_drop judge(base_rates *self, const base_rates_params *params, const base_rates_message *message) {
  const bool repeated = self->heard && message->counter == self->counter;
  self->heard = true;
  self->counter = message->counter;
  if (repeated) {
    return BASE_RATES_REPEATED;
  }
  const int16_t counts[] = {message->x, message->y, message->z};
  for (int i = 0; i < 3; ++i) {
    if (counts[i] == BASE_RATE_NOT_MEASURED) {
      return BASE_RATES_NOT_MEASURED;
    }
    if (!scalar_within(params->scale_rad_s * (float)counts[i], params->largest_rad_s)) {
      return BASE_RATES_IMPOSSIBLE;
    }
  }
  return BASE_RATES_TAKEN;
}

/* One rate, `time_s` after the last measurement. */
static void follow(float *rate_rad_s, float *slope_rad_s2, float measured_rad_s, float time_s, float bandwidth_rad_s) {
  const float k = 1.0f / (1.0f + bandwidth_rad_s * time_s);
  const float expected_rad_s = *rate_rad_s + *slope_rad_s2 * time_s;
  const float error_rad_s = measured_rad_s - expected_rad_s;
  *rate_rad_s = expected_rad_s + (1.0f - k * k) * error_rad_s;
  *slope_rad_s2 += (1.0f - k) * (1.0f - k) * error_rad_s / time_s;
}

bool base_rates_are_fresh(const base_rates *self, const base_rates_params *params, uint32_t tick) {
  return self->known && !self->ended && tick - self->arrived_tick <= params->timeout_ms;
}

void base_rates_age(base_rates *self, const base_rates_params *params, uint32_t tick) {
  self->ended = !base_rates_are_fresh(self, params, tick);
}

base_rates_drop base_rates_take(base_rates *self, const base_rates_params *params, const base_rates_message *message,
                                uint32_t tick) {
  const base_rates_drop drop = judge(self, params, message);
  if (drop != BASE_RATES_TAKEN) {
    return drop;
  }
  const base_vector measured = {.x = params->scale_rad_s * (float)message->x,
                                .y = params->scale_rad_s * (float)message->y,
                                .z = params->scale_rad_s * (float)message->z};
  const uint32_t ticks = tick - self->arrived_tick;
  if (base_rates_are_fresh(self, params, tick) && ticks > 0) {
    const float time_s = SERVO_TICK_S * (float)ticks;
    const float w = params->bandwidth_rad_s;
    follow(&self->rate_rad_s.x, &self->slope_rad_s2.x, measured.x, time_s, w);
    follow(&self->rate_rad_s.y, &self->slope_rad_s2.y, measured.y, time_s, w);
    follow(&self->rate_rad_s.z, &self->slope_rad_s2.z, measured.z, time_s, w);
  } else {
    self->rate_rad_s = measured;
    self->slope_rad_s2 = (base_vector){.x = 0.0f};
  }
  self->known = true;
  self->ended = false;
  self->arrived_tick = tick;
  return BASE_RATES_TAKEN;
}

static float carried_on(float rate_rad_s, float slope_rad_s2, float time_s, float largest_rad_s) {
  return scalar_clamp(rate_rad_s + slope_rad_s2 * time_s, -largest_rad_s, largest_rad_s);
}

base_vector base_rates_at(const base_rates *self, const base_rates_params *params, uint32_t tick) {
  const float age_ticks = (float)(tick - self->arrived_tick) + (float)params->delay / (float)BASE_TIMES_PER_TICK;
  const float time_s = scalar_min(SERVO_TICK_S * age_ticks, BASE_RATES_AHEAD_S);
  const float largest = params->largest_rad_s;
  return (base_vector){.x = carried_on(self->rate_rad_s.x, self->slope_rad_s2.x, time_s, largest),
                       .y = carried_on(self->rate_rad_s.y, self->slope_rad_s2.y, time_s, largest),
                       .z = carried_on(self->rate_rad_s.z, self->slope_rad_s2.z, time_s, largest)};
}

static bool feeds_back_encoder(const servo_axis_params *axis) {
  return axis->speed.rate_fusion.source == RATE_FROM_ENCODER;
}

float base_rates_of_azimuth(const servo_axis_params *azimuth, base_vector rate_rad_s, rotation psi, rotation theta) {
  const bool no_gyro = feeds_back_encoder(azimuth);
  if (!no_gyro && azimuth->gyro == GYRO_ON_LINE_OF_SIGHT) {
    return 0.0f;
  }
  const float ahead_rad_s = psi.cosine * rate_rad_s.x + psi.sine * rate_rad_s.y;
  const float tilt_rad_s = theta.sine * speed_loop_gyro_gain(theta.cosine) * ahead_rad_s;
  return (no_gyro ? rate_rad_s.z : 0.0f) - tilt_rad_s;
}

float base_rates_of_pitch(const servo_axis_params *pitch, base_vector rate_rad_s, rotation psi) {
  return feeds_back_encoder(pitch) ? psi.sine * rate_rad_s.x - psi.cosine * rate_rad_s.y : 0.0f;
}
