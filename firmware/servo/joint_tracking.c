/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/joint_tracking.h"

#include "base/scalar.h"

void joint_tracking_reset(joint_tracking *self) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    target_tracker_reset(&self->axis[i]);
    self->steady[i] = (joint_steadiness){0};
    self->tracks[i] = false;
  }
}

void joint_tracking_lose(joint_tracking *self) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    self->axis[i].locked = false;
  }
}

static void watch(joint_steadiness *steady, float rate_rad_s) {
  if (!scalar_within(rate_rad_s - steady->rate_rad_s, JOINT_STEADY_RAD_S)) {
    *steady = (joint_steadiness){.rate_rad_s = rate_rad_s};
  } else if (steady->ticks < JOINT_STEADY_TICKS) {
    steady->ticks++;
  }
}

void joint_tracking_step(joint_tracking *self, const servo_app *app, const joint_frame *frame,
                         servo_target targets[SERVO_AXES]) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    target_tracker_state *tracker = &self->axis[i];
    const camera_frame seen = {.fresh = frame->fresh,
                               .valid = frame->valid,
                               .age_ticks = frame->age_ticks,
                               .error_rad = i == SERVO_PITCH ? frame->error_rad.pitch : frame->error_rad.azimuth};
    const float rate_rad_s = app->axis[i].signals.rates.rate_rad_s;
    if (!self->tracks[i]) {
      watch(&self->steady[i], rate_rad_s);
      tracker->integral_rad_s = rate_rad_s; /* an error that nothing takes back would wind it up */
    }
    const speed_reference reference =
        target_tracker_step(tracker, &app->params.axis[i].tracker, &seen, rate_rad_s, SERVO_TICK_S);
    targets[i] = (servo_target){.known = tracker->locked,
                                .error_rad = tracker->error_rad + tracker->untaken_rad,
                                .reference = reference,
                                .torque_nm = 0.0f,
                                .proportional_per_s = app->params.axis[i].tracker.proportional_per_s,
                                .frame_age_ticks = tracker->ticks_since_frame,
                                .at_loss = app->params.axis[i].at_loss};
  }
}

void joint_tracking_remember(joint_tracking *self, const servo_app *app) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    target_tracker_remember(&self->axis[i], app->axis[i].signals.rates.rate_rad_s);
  }
}
