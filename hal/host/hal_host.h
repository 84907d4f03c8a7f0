/* SPDX-License-Identifier: Apache-2.0 */
/* The HAL of a simulated machine: a table of functions that a simulator fills in.
 *
 * One `struct hal` is one machine, so thousands of them run side by side in one process. Every pointer must be set. */
#ifndef TRACKSERVO_HAL_HOST_H
#define TRACKSERVO_HAL_HOST_H

#include "hal.h"

#ifdef __cplusplus
extern "C" {
#endif

struct hal {
  void *machine; /* passed to every function below */
  void (*sample)(void *machine, int axis, hal_axis_samples *samples);
  hal_health (*axis_health)(void *machine, int axis);
  void (*power_bridge)(void *machine, int axis, bool on);
  float (*current_a)(void *machine, int axis);
  float (*bus_voltage_v)(void *machine);
  void (*set_duty)(void *machine, int axis, float duty);
  void (*set_scales)(void *machine, const hal_scales *scales);
  void (*release_brake)(void *machine, int axis, bool release);
  bool (*brake_is_released)(void *machine, int axis);
  uint32_t (*status)(void *machine);
  uint32_t (*clock_us)(void *machine);
  uint32_t (*tick_us)(void *machine);
  void (*take_strobes)(void *machine, hal_strobes *strobes);
};

#ifdef __cplusplus
}
#endif

#endif
