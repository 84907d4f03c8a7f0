/* SPDX-License-Identifier: Apache-2.0 */
#include "protection/standstill_monitor.h"

#include "base/scalar.h"

bool standstill_monitor_step(standstill_monitor *monitor, float window_rad, bool commanded_to_stand, float step_rad,
                             float dt_s) {
  if (!commanded_to_stand || window_rad <= 0.0f) {
    *monitor = (standstill_monitor){0};
    return false;
  }
  if (monitor->standing_s < STANDSTILL_DELAY_S) {
    monitor->standing_s += dt_s;
    return false;
  }
  const float creep_rad = STANDSTILL_CREEP_RAD_S * dt_s;
  monitor->from_rad += step_rad;
  monitor->from_rad -= scalar_clamp(monitor->from_rad, -creep_rad, creep_rad);
  return !scalar_within(monitor->from_rad, window_rad);
}
