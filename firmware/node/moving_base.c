/* SPDX-License-Identifier: Apache-2.0 */
#include "node/moving_base.h"

#include "base/scalar.h"

#define SHARE_STEP 0.03125f /* 32 of them: 128 ms */

static void drop(base_objects *objects, base_rates_drop why) {
  objects->dropped++;
  objects->last_drop = (uint8_t)why;
}

static void changed(void *owner, const od_object *object) {
  moving_base *self = owner;
  if (base_objects_hand_over(object)) {
    if (self->arrived) {
      drop(&self->objects, BASE_RATES_REPLACED);
    }
    self->arrived = true;
    self->arrived_tick = self->tick;
  } else if (base_objects_sets_scale(object)) {
    base_rates_reset(&self->rates);
  }
}

static unsigned needed(const od_object *object) {
  return base_objects_hand_over(object) || base_objects_sets_scale(object) ? OD_HOOK_CHANGED : 0u;
}

const od_hooks moving_base_hooks = {.changed = changed, .needed = needed};

void moving_base_forget(moving_base *self) {
  base_rates_reset(&self->rates);
  self->arrived = false;
  self->objects.taken = 0;
  self->objects.dropped = 0;
  self->objects.last_drop = (uint8_t)BASE_RATES_TAKEN;
}

void moving_base_step(moving_base *self, servo_app *app, uint32_t tick) {
  self->tick = tick;
  for (int i = 0; i < SERVO_AXES; ++i) {
    app->axis[i].speed.carried_rad_s += self->step_rad_s[i];
  }
}

static void take(moving_base *self) {
  base_objects *objects = &self->objects;
  if (!self->arrived) {
    return;
  }
  self->arrived = false;
  const base_rates_drop verdict =
      base_rates_take(&self->rates, &objects->params, &objects->message, self->arrived_tick);
  if (verdict == BASE_RATES_TAKEN) {
    objects->taken++;
  } else {
    drop(objects, verdict);
  }
}

/* Of both axes: what keeps rates from any of them comes first. */
static base_rates_state state_of(const moving_base *self, bool fixed) {
  if (self->objects.params.use == 0) {
    return BASE_RATES_OFF;
  }
  if (!self->rates.known) {
    return BASE_RATES_AWAITED;
  }
  if (!base_rates_are_fresh(&self->rates, &self->objects.params, self->tick)) {
    return BASE_RATES_STALE;
  }
  return fixed ? BASE_RATES_OF_FIXED_BASE : BASE_RATES_IN_USE;
}

static float wanted_rad_s(const moving_base *self, const servo_app *app, const servo_samples *samples, int axis) {
  const base_vector rate = base_rates_at(&self->rates, &self->objects.params, self->tick + MOVING_BASE_TICKS);
  const rotation psi = rotation_of(samples->axis[SERVO_AZIMUTH].sensors.joint_angle_turn32);
  if (axis == SERVO_PITCH) {
    return base_rates_of_pitch(&app->params.axis[SERVO_PITCH], rate, psi);
  }
  return base_rates_of_azimuth(&app->params.axis[SERVO_AZIMUTH], rate, psi, samples->pitch);
}

void moving_base_aim(moving_base *self, const servo_app *app, const servo_samples *samples,
                     const moving_base_axis *axis) {
  const int i = axis->index;
  take(self);
  base_rates_age(&self->rates, &self->objects.params, self->tick);
  self->fixed[i] = axis->fixed;
  self->objects.state = (uint8_t)state_of(self, self->fixed[SERVO_AZIMUTH] || self->fixed[SERVO_PITCH]);
  const bool adds = axis->follows && state_of(self, axis->fixed) == BASE_RATES_IN_USE;
  const float share = scalar_clamp(self->share[i] + (adds ? SHARE_STEP : -SHARE_STEP), 0.0f, 1.0f);
  const float aim_rad_s = share > 0.0f ? share * wanted_rad_s(self, app, samples, i) : 0.0f;
  const float now_rad_s = app->axis[i].speed.carried_rad_s;
  self->share[i] = share;
  self->step_rad_s[i] = (aim_rad_s - now_rad_s) / (float)MOVING_BASE_TICKS;
  float *added_rad_s = i == SERVO_PITCH ? &self->objects.added_pitch_rad_s : &self->objects.added_azimuth_rad_s;
  *added_rad_s = now_rad_s;
}
