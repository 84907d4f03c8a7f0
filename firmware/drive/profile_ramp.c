#include "drive/profile_ramp.h"

#include <math.h>

#include "control/scalar.h"

/* A switching time is found to 2^-16 tick. */
enum { PIECES = 3, BISECTIONS = 16 };

/* What counts as arrived: 1e-8 rad is a tenth of a position count, 7 units of the encoder angle. */
static const float arrived_rad = 1e-8f;

/* A stop is begun with this fraction of the distance to spare, the rounding of its sums: braking at the limit can
 * give way a little, not brake a little harder. It shrinks with the distance. */
static const float spare_fraction = 2e-7f;
static const float aim_rad = 1e-9f;

/* Three pieces of constant jerk that end at `end_rate_rad_s` with no acceleration. */
typedef struct {
  float duration_s[PIECES];
  float jerk_rad_s3[PIECES];
  float peak_rad_s2; /* acceleration in the middle piece */
  float end_rate_rad_s;
} ramp_plan;

static const float limit_low = 1e-6f;
static const float limit_high = 4300.0f;

control_status profile_limits_check(const profile_limits *limits) {
  const scalar_range ranges[] = {
      {limits->rate_rad_s, limit_low, limit_high},
      {limits->acceleration_rad_s2, limit_low, limit_high},
      {limits->deceleration_rad_s2, limit_low, limit_high},
      {limits->jerk_rad_s3, limit_low, limit_high},
  };
  return scalar_check_ranges(ranges, 4);
}

bool profile_at_rest(const profile_ramp *ramp) { return ramp->rate_rad_s == 0.0f && ramp->acceleration_rad_s2 == 0.0f; }

/* From the rate of now, all its digits, to another. */
static float rate_change(const profile_ramp *ramp, float to_rad_s) {
  return (to_rad_s - ramp->rate_rad_s) - ramp->rate_rest_rad_s;
}

/* How much the rate still changes when the acceleration is brought to 0 at once. */
static float settling_change(const profile_ramp *ramp, float jerk_rad_s3) {
  const float a = ramp->acceleration_rad_s2;
  return a * scalar_abs(a) / (2.0f * jerk_rad_s3);
}

/* An axis that brakes harder than it accelerates stops first and reverses then: its acceleration at rate 0 is 0, so
 * both limits hold on either side. */
static float reachable_rate(const profile_ramp *ramp, const profile_limits *limits, float target_rad_s) {
  const bool reverses = ramp->rate_rad_s * target_rad_s < 0.0f;
  return reverses && limits->deceleration_rad_s2 > limits->acceleration_rad_s2 ? 0.0f : target_rad_s;
}

/* Limit of the acceleration in direction `sign`. */
static float acceleration_limit(const profile_ramp *ramp, const profile_limits *limits, float settling_rad_s,
                                float target_rad_s, float sign) {
  const bool brakes = ramp->rate_rad_s * sign < 0.0f || settling_rad_s * sign < 0.0f;
  const bool speeds_up = target_rad_s * sign > 0.0f;
  if (!brakes) {
    return limits->acceleration_rad_s2;
  }
  return speeds_up ? scalar_min(limits->acceleration_rad_s2, limits->deceleration_rad_s2) : limits->deceleration_rad_s2;
}

static ramp_plan plan_to_rate(const profile_ramp *ramp, const profile_limits *limits, float wanted_rad_s) {
  const float jerk = limits->jerk_rad_s3;
  const float target_rad_s = reachable_rate(ramp, limits, wanted_rad_s);
  const float wanted_change = rate_change(ramp, target_rad_s);
  const float settling = settling_change(ramp, jerk);
  const float sign = wanted_change < settling ? -1.0f : 1.0f;
  const float limit = acceleration_limit(ramp, limits, ramp->rate_rad_s + settling, target_rad_s, sign);

  /* Mirrored so that the middle piece accelerates. */
  const float start = sign * ramp->acceleration_rad_s2;
  const float change = sign * wanted_change;
  const float free_peak = sqrtf(scalar_max(jerk * change + 0.5f * start * start, 0.0f));
  const float peak = scalar_min(free_peak, limit);
  const float first_jerk = peak < start ? -jerk : jerk;

  ramp_plan plan = {.peak_rad_s2 = sign * peak, .end_rate_rad_s = target_rad_s};
  plan.jerk_rad_s3[0] = sign * first_jerk;
  plan.jerk_rad_s3[2] = sign * -jerk;
  plan.duration_s[0] = (peak - start) / first_jerk;
  plan.duration_s[2] = peak / jerk;
  if (free_peak > limit) {
    const float ramped = 0.5f * ((peak + start) * plan.duration_s[0] + peak * plan.duration_s[2]);
    plan.duration_s[1] = scalar_max((change - ramped) / peak, 0.0f);
  }
  return plan;
}

/* Adds to a sum whose rounding error is kept in `rest` (Kahan). */
static void add_to(float *sum, float *rest, float term) {
  const float before = *sum;
  const float wanted = term + *rest;
  *sum = before + wanted;
  *rest = wanted - (*sum - before);
}

/* One piece of the plan, or the part of it that fits: an acceleration linear in time. Gives the travel, adds to the
 * gain in rate. */
static float follow_piece(profile_ramp *ramp, float *gain_rad_s, float jerk_rad_s3, float duration_s) {
  const float start_rad_s = ramp->rate_rad_s + *gain_rad_s;
  const float start_rad_s2 = ramp->acceleration_rad_s2;
  const float step_rad_s2 = jerk_rad_s3 * duration_s;
  *gain_rad_s += duration_s * (start_rad_s2 + 0.5f * step_rad_s2);
  add_to(&ramp->acceleration_rad_s2, &ramp->acceleration_rest_rad_s2, step_rad_s2);
  return duration_s * (start_rad_s + duration_s * (0.5f * start_rad_s2 + step_rad_s2 / 6.0f));
}

/* Follows the plan for `time_s`, then goes on with its end rate. The gain in rate stands in the place of the mean
 * acceleration: summed apart from the rate, its digits are those of the acceleration. */
static profile_motion follow(profile_ramp *ramp, const ramp_plan *plan, float time_s) {
  float travel_rad = 0.0f;
  float gain_rad_s = 0.0f;
  float left_s = time_s;
  for (int i = 0; i < PIECES; ++i) {
    const bool complete = plan->duration_s[i] <= left_s;
    const float piece_s = complete ? plan->duration_s[i] : left_s;
    travel_rad += follow_piece(ramp, &gain_rad_s, plan->jerk_rad_s3[i], piece_s);
    left_s -= piece_s;
    if (!complete) {
      add_to(&ramp->rate_rad_s, &ramp->rate_rest_rad_s, gain_rad_s);
      return (profile_motion){.travel_rad = travel_rad, .mean_acceleration_rad_s2 = gain_rad_s};
    }
    if (i == 0) {
      ramp->acceleration_rad_s2 = plan->peak_rad_s2;
      ramp->acceleration_rest_rad_s2 = 0.0f;
    }
  }
  const profile_motion motion = {.travel_rad = travel_rad + left_s * plan->end_rate_rad_s,
                                 .mean_acceleration_rad_s2 = rate_change(ramp, plan->end_rate_rad_s),
                                 .arrived = true};
  *ramp = (profile_ramp){.rate_rad_s = plan->end_rate_rad_s};
  return motion;
}

/* As `follow` over a tick of `dt_s`, with the gain in rate made an acceleration. */
static profile_motion follow_tick(profile_ramp *ramp, const ramp_plan *plan, float dt_s) {
  profile_motion motion = follow(ramp, plan, dt_s);
  motion.mean_acceleration_rad_s2 /= dt_s;
  return motion;
}

float profile_stop_travel_rad(const profile_ramp *ramp, const profile_limits *limits) {
  profile_ramp moving = *ramp;
  const ramp_plan plan = plan_to_rate(ramp, limits, 0.0f);
  return follow(&moving, &plan, plan.duration_s[0] + plan.duration_s[1] + 2.0f * plan.duration_s[2]).travel_rad;
}

profile_motion profile_towards_rate(profile_ramp *ramp, const profile_limits *limits, float rate_rad_s, float dt_s) {
  const ramp_plan plan = plan_to_rate(ramp, limits, rate_rad_s);
  profile_motion motion = follow_tick(ramp, &plan, dt_s);
  motion.arrived = motion.arrived && ramp->rate_rad_s == rate_rad_s;
  return motion;
}

/* What would be left of `distance_rad` after following `plan` for `time_s` and stopping then. */
static float margin_after(profile_ramp ramp, const profile_limits *limits, const ramp_plan *plan, float time_s,
                          float distance_rad) {
  const float travel_rad = follow(&ramp, plan, time_s).travel_rad;
  return distance_rad - travel_rad - profile_stop_travel_rad(&ramp, limits);
}

static float spare_of(float distance_rad) { return spare_fraction * scalar_abs(distance_rad); }

/* The latest moment of this tick at which a stop still ends within the distance. */
static float latest_stop_s(const profile_ramp *ramp, const profile_limits *limits, const ramp_plan *plan,
                           float distance_rad, float direction, float dt_s) {
  float early_s = 0.0f;
  float late_s = dt_s;
  for (int i = 0; i < BISECTIONS; ++i) {
    const float middle_s = 0.5f * (early_s + late_s);
    if (direction * margin_after(*ramp, limits, plan, middle_s, distance_rad) >= spare_of(distance_rad)) {
      early_s = middle_s;
    } else {
      late_s = middle_s;
    }
  }
  return early_s;
}

/* Follows `plan` for `time_s` of the tick and stops for the rest of it. */
static profile_motion follow_then_stop(profile_ramp *ramp, const profile_limits *limits, const ramp_plan *plan,
                                       float time_s, float dt_s) {
  const profile_motion before = follow(ramp, plan, time_s);
  const ramp_plan stop = plan_to_rate(ramp, limits, 0.0f);
  const profile_motion after = follow(ramp, &stop, dt_s - time_s);
  return (profile_motion){
      .travel_rad = before.travel_rad + after.travel_rad,
      .mean_acceleration_rad_s2 = (before.mean_acceleration_rad_s2 + after.mean_acceleration_rad_s2) / dt_s,
      .arrived = profile_at_rest(ramp),
  };
}

/* One tick towards `rate_rad_s`, or the stop that ends at `distance_rad` when it is time for that. `margin_rad` is
 * what a stop from now would leave of the distance. */
static profile_motion approach(profile_ramp *ramp, const profile_limits *limits, float rate_rad_s, float distance_rad,
                               float margin_rad, float dt_s) {
  const float direction = margin_rad < 0.0f ? -1.0f : 1.0f;
  const ramp_plan plan = plan_to_rate(ramp, limits, rate_rad_s);
  if (scalar_abs(margin_rad) <= aim_rad + 2.0f * spare_of(distance_rad)) {
    return follow_then_stop(ramp, limits, &plan, 0.0f, dt_s);
  }
  if (direction * margin_after(*ramp, limits, &plan, dt_s, distance_rad) >= spare_of(distance_rad)) {
    return follow_tick(ramp, &plan, dt_s);
  }
  const float latest_s = latest_stop_s(ramp, limits, &plan, distance_rad, direction, dt_s);
  return follow_then_stop(ramp, limits, &plan, latest_s, dt_s);
}

profile_motion profile_towards_rate_within(profile_ramp *ramp, const profile_limits *limits, float rate_rad_s,
                                           float room_rad, float dt_s) {
  const float margin_rad = room_rad - profile_stop_travel_rad(ramp, limits);
  if (margin_rad * rate_rad_s <= 0.0f) {
    return profile_towards_rate(ramp, limits, 0.0f, dt_s);
  }
  profile_motion motion = approach(ramp, limits, rate_rad_s, room_rad, margin_rad, dt_s);
  motion.arrived = motion.arrived && ramp->rate_rad_s == rate_rad_s;
  return motion;
}

profile_motion profile_towards_distance(profile_ramp *ramp, const profile_limits *limits, float distance_rad,
                                        float dt_s) {
  if (profile_at_rest(ramp) && scalar_abs(distance_rad) <= arrived_rad) {
    return (profile_motion){.travel_rad = distance_rad, .arrived = true};
  }
  const float margin_rad = distance_rad - profile_stop_travel_rad(ramp, limits);
  const float rate_rad_s = margin_rad < 0.0f ? -limits->rate_rad_s : limits->rate_rad_s;
  profile_motion motion = approach(ramp, limits, rate_rad_s, distance_rad, margin_rad, dt_s);
  motion.arrived = profile_at_rest(ramp) && scalar_abs(distance_rad - motion.travel_rad) <= arrived_rad;
  if (motion.arrived) {
    motion.travel_rad = distance_rad;
  }
  return motion;
}
