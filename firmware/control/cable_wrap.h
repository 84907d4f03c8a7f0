/* SPDX-License-Identifier: Apache-2.0 */
/* Which joint angle lasts longest. An azimuth that turns by more than one revolution between its end stops can look in
 * some directions with two angles, one revolution apart: +100 or -260 degrees within +-280. */
#ifndef TRACKSERVO_CONTROL_CABLE_WRAP_H
#define TRACKSERVO_CONTROL_CABLE_WRAP_H

/* Not limited unless lowest < highest. */
typedef struct {
  float lowest_rad;
  float highest_rad;
} joint_travel;

/* Returns the nearest angle of the travel. */
float joint_travel_clamp(const joint_travel *travel, float angle_rad);

/* Returns how long a joint can go on from this angle at this rate, s: 0 outside of the travel, infinite at rate 0 or
 * without a limit. */
float cable_wrap_lasts_s(const joint_travel *travel, float angle_rad, float rate_rad_s);

/* Returns by how many revolutions, -1, 0 or 1, the azimuth should turn to be able to go on longest within its travel; 0
 * when no other turn is better than the present one. */
int cable_wrap_turns(const joint_travel *travel, float angle_rad, float rate_rad_s);

#endif
