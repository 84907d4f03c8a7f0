/* SPDX-License-Identifier: Apache-2.0 */
#include "drive/drive_travel.h"

#include <math.h>

#include "base/scalar.h"
#include "protection/envelope.h"
#include "servo/servo_axis.h"

/* The position loop may use 110 % of 607F to correct an error: 88 % of 2060:1. The rest is for the overshoot of a
 * loop. */
#define RATE_OF_OVERSPEED 0.8f
#define BRAKING_OF_SURE 0.62f /* the ramps stay within the envelope, and loops have torque left */
#define RATE_OF_SLOW 0.8f     /* the same */

/* An ordered stop reaches its deceleration within this time, and gains no more speed than this before. */
#define STOP_BEGINS_PER_S 4.0f
#define STOP_OVERSHOOT_RAD_S 0.05f

/* The highest limits of a ramp: no limit. */
#define HARDEST_BRAKING_RAD_S2 4300.0f
#define HARDEST_JERK_RAD_S3 4300.0f
#define SOFTEST_BRAKING_RAD_S2 1e-3f

int32_t drive_travel_position(const drive_travel *travel, drive_angle angle) {
  return drive_position_from_angle(drive_travel_is_limited(travel) ? angle : drive_angle_wrap(angle));
}

int32_t drive_travel_clamp(const drive_travel *travel, int32_t position) {
  if (!drive_travel_is_limited(travel)) {
    return position;
  }
  if (position < travel->minimum) {
    return travel->minimum;
  }
  return position > travel->maximum ? travel->maximum : position;
}

/* The soft travel within the hard travel; only the hard travel when the two have nothing in common. */
static drive_travel travel_in_force(const drive_travel *soft, const drive_machine *machine) {
  drive_travel inner = machine->hard;
  if (drive_travel_is_limited(&inner)) {
    inner.minimum += machine->margin;
    inner.maximum -= machine->margin;
  }
  const drive_travel both = {drive_travel_clamp(&inner, soft->minimum), drive_travel_clamp(&inner, soft->maximum)};
  return drive_travel_is_limited(&both) ? both : inner;
}

/* The same in both directions: the lower torque limit decides. */
static float sure_braking_rad_s2(const drive_torque_objects *torque, const drive_machine *machine) {
  if (!(machine->deceleration_rad_s2 > 0.0f && machine->torque_nm > 0.0f)) {
    return HARDEST_BRAKING_RAD_S2;
  }
  uint16_t least = torque->positive_limit < torque->negative_limit ? torque->positive_limit : torque->negative_limit;
  least = torque->maximum < least ? torque->maximum : least;
  const float torque_nm = scalar_min(machine->torque_nm, drive_torque_from_permille(least, torque->rated_mnm));
  return scalar_clamp(BRAKING_OF_SURE * machine->deceleration_rad_s2 * torque_nm / machine->torque_nm,
                      SOFTEST_BRAKING_RAD_S2, HARDEST_BRAKING_RAD_S2);
}

static float rate_in_force_rad_s(uint32_t wanted, const drive_machine *machine) {
  const float own_rad_s = machine->overspeed_rad_s > 0.0f ? RATE_OF_OVERSPEED * machine->overspeed_rad_s
                                                          : RATE_OF_OVERSPEED * SERVO_PLAUSIBLE_RATE_RAD_S;
  const float slow_rad_s = machine->slow ? RATE_OF_SLOW * ENVELOPE_SLOW_RAD_S : own_rad_s;
  return scalar_min(drive_limit_from_counts(wanted), scalar_min(own_rad_s, slow_rad_s));
}

static void take_travel(drive_bounds *bounds, drive_travel travel) {
  if (travel.minimum != bounds->travel.minimum || travel.maximum != bounds->travel.maximum) {
    bounds->travel = travel;
    bounds->lowest = drive_angle_from_position(travel.minimum);
    bounds->highest = drive_angle_from_position(travel.maximum);
  }
}

void drive_bounds_update(drive_bounds *bounds, const drive_objects *objects, const drive_machine *machine) {
  const drive_limit_objects *limit = &objects->limit;
  if (limit->position_minimum <= limit->position_maximum) {
    bounds->soft = (drive_travel){limit->position_minimum, limit->position_maximum};
  }
  take_travel(bounds, machine->position_unknown ? (drive_travel){0, 0} : travel_in_force(&bounds->soft, machine));
  bounds->rate_rad_s = rate_in_force_rad_s(limit->maximum_velocity, machine);
  bounds->position_rad_s =
      machine->position_rad_s > 0.0f ? scalar_min(bounds->rate_rad_s, machine->position_rad_s) : bounds->rate_rad_s;
  bounds->braking_rad_s2 = sure_braking_rad_s2(&objects->torque, machine);
  bounds->stop_rad_s2 = machine->stop_deceleration_rad_s2;
  bounds->position_unknown = machine->position_unknown;
}

float drive_travel_room_rad(const drive_bounds *bounds, drive_angle position, float direction) {
  return drive_angle_difference_rad(direction < 0.0f ? bounds->lowest : bounds->highest, position);
}

float drive_travel_side(const drive_bounds *bounds, drive_angle position) {
  if (!drive_travel_is_limited(&bounds->travel)) {
    return 0.0f;
  }
  if (position >= bounds->highest) {
    return 1.0f;
  }
  return position <= bounds->lowest ? -1.0f : 0.0f;
}

profile_limits drive_braking_within(const drive_bounds *bounds, const profile_limits *limits) {
  profile_limits braking = *limits;
  braking.deceleration_rad_s2 = scalar_min(limits->deceleration_rad_s2, bounds->braking_rad_s2);
  return braking;
}

bool drive_stop_within(const drive_bounds *bounds, profile_limits *limits, const profile_ramp *ramp,
                       drive_angle position) {
  if (!drive_travel_is_limited(&bounds->travel) || ramp->rate_rad_s == 0.0f) {
    return false;
  }
  const float direction = ramp->rate_rad_s < 0.0f ? -1.0f : 1.0f;
  const float room_rad = direction * drive_travel_room_rad(bounds, position, direction);
  /* Outside it stays hard until the end: a gentle jerk would not end the braking before the axis has turned back. */
  if (room_rad > 0.0f && room_rad > direction * profile_stop_travel_rad(ramp, limits)) {
    return false;
  }
  /* No harder than needed, without a gentle start: the remaining distance may be too short for that. */
  const float hardest_rad_s2 = scalar_max(limits->deceleration_rad_s2, bounds->braking_rad_s2);
  const float square = ramp->rate_rad_s * ramp->rate_rad_s;
  const float needed_rad_s2 = square < 2.0f * hardest_rad_s2 * room_rad ? square / (2.0f * room_rad) : hardest_rad_s2;
  limits->deceleration_rad_s2 = scalar_max(limits->deceleration_rad_s2, needed_rad_s2);
  limits->jerk_rad_s3 = HARDEST_JERK_RAD_S3;
  return true;
}

void drive_stop_at_least(const drive_bounds *bounds, profile_limits *limits, profile_ramp *ramp) {
  limits->deceleration_rad_s2 = scalar_max(limits->deceleration_rad_s2, bounds->stop_rad_s2);
  limits->jerk_rad_s3 = scalar_max(limits->jerk_rad_s3, STOP_BEGINS_PER_S * bounds->stop_rad_s2);
  if (bounds->stop_rad_s2 > 0.0f && ramp->acceleration_rad_s2 * ramp->rate_rad_s > 0.0f) {
    const float soonest_rad_s2 = sqrtf(2.0f * STOP_OVERSHOOT_RAD_S * limits->jerk_rad_s3);
    ramp->acceleration_rad_s2 = scalar_clamp(ramp->acceleration_rad_s2, -soonest_rad_s2, soonest_rad_s2);
  }
}

/* The rate whose stop, with deceleration a and jerk j, takes exactly the room: v^2 / 2a + v a / 2j. Near its end it is
 * 2 j / a times the room. And in a tick no more than the room. */
static float fastest_rad_s(float room_rad, const profile_limits *braking, float dt_s) {
  if (room_rad <= 0.0f) {
    return 0.0f;
  }
  const float a = braking->deceleration_rad_s2;
  const float q_rad_s = 0.5f * a * a / braking->jerk_rad_s3;
  const float rate_rad_s = 2.0f * a * room_rad / (sqrtf(q_rad_s * q_rad_s + 2.0f * a * room_rad) + q_rad_s);
  return scalar_min(rate_rad_s, room_rad / dt_s);
}

float drive_rate_within(const drive_bounds *bounds, const profile_limits *braking, drive_angle position,
                        float rate_rad_s, float dt_s) {
  if (!drive_travel_is_limited(&bounds->travel)) {
    return rate_rad_s;
  }
  const float direction = rate_rad_s < 0.0f ? -1.0f : 1.0f;
  const float room_rad = direction * drive_travel_room_rad(bounds, position, direction);
  const float fastest = fastest_rad_s(room_rad, braking, dt_s);
  return scalar_clamp(rate_rad_s, -fastest, fastest);
}
