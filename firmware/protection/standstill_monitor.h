/* SPDX-License-Identifier: Apache-2.0 */
/* Standstill, as a monitor (like SOS of IEC 61800-5-2; no safety integrity level is claimed): an axis whose loops are
 * closed and that nobody commands to move stays where it is.
 *
 * STANDSTILL_DELAY_S after the last command to move, the position is kept; leaving it by more than the window is a
 * fault in the tick that shows it. What is kept follows the position by at most STANDSTILL_CREEP_RAD_S: a gyro's bias
 * turns an axis whose rate is controlled, and is no fault below that. Base at rest only. Cost: about 15
 * instructions. */
#ifndef TRACKSERVO_PROTECTION_STANDSTILL_MONITOR_H
#define TRACKSERVO_PROTECTION_STANDSTILL_MONITOR_H

#include <stdbool.h>

#define STANDSTILL_DELAY_S 1.0f
#define STANDSTILL_CREEP_RAD_S 1e-4f

typedef struct {
  float standing_s;
  float from_rad; /* how far the axis is from the kept position */
} standstill_monitor;

/* Checks one tick with the increment of the position; a window of 0 monitors nothing. */
bool standstill_monitor_step(standstill_monitor *monitor, float window_rad, bool commanded_to_stand, float step_rad,
                             float dt_s);

#endif
