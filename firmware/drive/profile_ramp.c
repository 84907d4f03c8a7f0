/* SPDX-License-Identifier: Apache-2.0 */
#include "drive/profile_ramp.h"

#include <math.h>

#include "base/scalar.h"

enum { PIECES = 3 };

/* Maximum number of steps of the search for the time at which a stop begins; one or two are typical. */
enum { SEARCH_STEPS = 3, CUBIC_STEPS = 6 };

/* Distance that counts as arrived: 1e-8 rad is a tenth of a position count, 7 units of the encoder angle. */
static const float arrived_rad = 1e-8f;

/* A stop begins with this fraction of the distance to spare, to cover rounding of its sums: braking at the limit can be
 * slightly softer, not slightly harder. The fraction shrinks with the distance. */
static const float spare_fraction = 2e-7f;
static const float aim_rad = 1e-9f;

/* Three pieces of constant jerk that end at `end_rate_rad_s` with zero acceleration. */
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

/* From the present rate, with all its digits, to another. */
static float rate_change(const profile_ramp *ramp, float to_rad_s) {
  return (to_rad_s - ramp->rate_rad_s) - ramp->rate_rest_rad_s;
}

/* The rate change that remains when the acceleration goes to 0 at full jerk. */
static float settling_change(const profile_ramp *ramp, float jerk_rad_s3) {
  const float a = ramp->acceleration_rad_s2;
  return a * scalar_abs(a) / (2.0f * jerk_rad_s3);
}

/* An axis that brakes harder than it accelerates stops first and then reverses: its acceleration at rate 0 is 0, so
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

  const float first_s = (peak - start) / first_jerk;
  const float last_s = peak / jerk;
  float hold_s = 0.0f;
  if (free_peak > limit) {
    const float ramped = 0.5f * ((peak + start) * first_s + peak * last_s);
    hold_s = scalar_max((change - ramped) / limit, 0.0f); /* the peak is the limit */
  }
  return (ramp_plan){.duration_s = {first_s, hold_s, last_s},
                     .jerk_rad_s3 = {sign * first_jerk, 0.0f, sign * -jerk},
                     .peak_rad_s2 = sign * peak,
                     .end_rate_rad_s = target_rad_s};
}

/* Adds to a sum whose rounding error is kept in `rest` (Kahan). */
static void add_to(float *sum, float *rest, float term) {
  const float before = *sum;
  const float wanted = term + *rest;
  *sum = before + wanted;
  *rest = wanted - (*sum - before);
}

/* One piece of the plan, or the part of it that fits: an acceleration linear in time. Returns the travel and adds to
 * the rate gain. */
static float follow_piece(profile_ramp *ramp, float *gain_rad_s, float jerk_rad_s3, float duration_s) {
  const float start_rad_s = ramp->rate_rad_s + *gain_rad_s;
  const float start_rad_s2 = ramp->acceleration_rad_s2;
  const float step_rad_s2 = jerk_rad_s3 * duration_s;
  *gain_rad_s += duration_s * (start_rad_s2 + 0.5f * step_rad_s2);
  add_to(&ramp->acceleration_rad_s2, &ramp->acceleration_rest_rad_s2, step_rad_s2);
  return duration_s * (start_rad_s + duration_s * (0.5f * start_rad_s2 + step_rad_s2 / 6.0f));
}

/* Follows the plan for `time_s`, then continues at its end rate. The rate gain takes the place of the mean
 * acceleration: it is summed apart from the rate, so it has the resolution of the acceleration. */
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

/* Like `follow` over a tick of `dt_s`, with the rate gain converted to an acceleration. */
static profile_motion follow_tick(profile_ramp *ramp, const ramp_plan *plan, float dt_s) {
  profile_motion motion = follow(ramp, plan, dt_s);
  motion.mean_acceleration_rad_s2 /= dt_s;
  return motion;
}

/* --- when to stop --- */

/* A state along a plan. */
typedef struct {
  float travel_rad;
  float rate_rad_s;
  float acceleration_rad_s2;
  float jerk_before_rad_s3; /* these differ where two pieces meet */
  float jerk_after_rad_s3;
} ramp_point;

static ramp_point start_of(const profile_ramp *ramp) {
  return (ramp_point){.rate_rad_s = ramp->rate_rad_s + ramp->rate_rest_rad_s,
                      .acceleration_rad_s2 = ramp->acceleration_rad_s2};
}

/* Like `follow`, without the digits that a sum over many ticks needs. */
static ramp_point point_of(const ramp_plan *plan, const profile_ramp *ramp, float time_s) {
  ramp_point point = start_of(ramp);
  float left_s = time_s;
  for (int i = 0; i < PIECES; ++i) {
    const float jerk_rad_s3 = plan->jerk_rad_s3[i];
    const float piece_s = scalar_min(plan->duration_s[i], left_s);
    if (piece_s > 0.0f) {
      const float gained_rad_s2 = jerk_rad_s3 * piece_s;
      point.travel_rad +=
          piece_s * (point.rate_rad_s + piece_s * (0.5f * point.acceleration_rad_s2 + gained_rad_s2 * (1.0f / 6.0f)));
      point.rate_rad_s += piece_s * (point.acceleration_rad_s2 + 0.5f * gained_rad_s2);
      point.acceleration_rad_s2 += gained_rad_s2;
      point.jerk_before_rad_s3 = jerk_rad_s3;
    }
    left_s -= plan->duration_s[i];
    if (left_s < 0.0f) {
      point.jerk_after_rad_s3 = jerk_rad_s3;
      return point;
    }
  }
  point.travel_rad += left_s * plan->end_rate_rad_s;
  point.rate_rad_s = plan->end_rate_rad_s;
  point.acceleration_rad_s2 = 0.0f;
  if (left_s > 0.0f) {
    point.jerk_before_rad_s3 = 0.0f;
  }
  return point;
}

/* The stopping distance and its derivatives by rate and acceleration. In terms of the durations of its three pieces
 * these are t1 + t2 + t3 / 2, and t1 (t1 / 2 + t2 + t3 / 2). */
typedef struct {
  float travel_rad;
  float per_rate_s;
  float per_acceleration_s2;
} stopping_distance;

/* The plan to rate 0 in closed form: from the present deceleration to its peak, hold, back to 0. */
static stopping_distance distance_to_stop(const ramp_point *from, const profile_limits *limits) {
  const float jerk = limits->jerk_rad_s3;
  const float acceleration = from->acceleration_rad_s2;
  const float settled = from->rate_rad_s + acceleration * scalar_abs(acceleration) / (2.0f * jerk);
  const float sign = settled < 0.0f ? -1.0f : 1.0f;
  const float rate = sign * from->rate_rad_s;
  const float start = -sign * acceleration;
  const float free_peak = sqrtf(scalar_max(jerk * rate + 0.5f * start * start, 0.0f));
  const float peak = scalar_min(free_peak, limits->deceleration_rad_s2);
  const float first_s = scalar_abs(peak - start) / jerk;
  const float last_s = peak / jerk;
  const float held_rate = rate - 0.5f * (start + peak) * first_s;
  float hold_s = 0.0f;
  float travel = first_s * (rate - first_s * (2.0f * start + peak) * (1.0f / 6.0f));
  float last_rate = held_rate;
  if (free_peak > peak) {
    hold_s = scalar_max((held_rate - 0.5f * peak * last_s) / peak, 0.0f);
    travel += hold_s * (held_rate - 0.5f * peak * hold_s);
    last_rate -= peak * hold_s;
  }
  travel += last_s * (last_rate - last_s * peak * (1.0f / 3.0f));
  const float later_s = hold_s + 0.5f * last_s;
  return (stopping_distance){.travel_rad = sign * travel,
                             .per_rate_s = first_s + later_s,
                             .per_acceleration_s2 = first_s * (0.5f * first_s + later_s)};
}

float profile_stop_travel_rad(const profile_ramp *ramp, const profile_limits *limits) {
  const ramp_point start = start_of(ramp);
  return distance_to_stop(&start, limits).travel_rad;
}

profile_motion profile_towards_rate(profile_ramp *ramp, const profile_limits *limits, float rate_rad_s, float dt_s) {
  const ramp_plan plan = plan_to_rate(ramp, limits, rate_rad_s);
  profile_motion motion = follow_tick(ramp, &plan, dt_s);
  motion.arrived = motion.arrived && ramp->rate_rad_s == rate_rad_s;
  return motion;
}

/* A time in the tick, and the distance that a stop from then on would leave; both signed by the direction of motion. */
typedef struct {
  float time_s;
  float margin_rad;
  float rate_before_rad_s; /* growth rate of the margin; the two differ where two pieces meet */
  float rate_after_rad_s;
} stop_moment;

/* Inputs of the search: the plan that is followed and the margin that a stop leaves. */
typedef struct {
  const profile_ramp *ramp;
  const profile_limits *limits;
  const ramp_plan *plan;
  float distance_rad;
  float direction;
  float aim_rad;       /* margin that a stop should leave, and its tolerance */
  float tolerance_rad; /* this */
} stop_search;

static stop_moment moment_of(const stop_search *search, float time_s, const ramp_point *at,
                             const stopping_distance *stopping) {
  const float growth_rad_s = at->rate_rad_s + stopping->per_rate_s * at->acceleration_rad_s2;
  const float margin_rad = search->distance_rad - at->travel_rad - stopping->travel_rad;
  return (stop_moment){
      .time_s = time_s,
      .margin_rad = search->direction * margin_rad - search->aim_rad,
      .rate_before_rad_s = -search->direction * (growth_rad_s + stopping->per_acceleration_s2 * at->jerk_before_rad_s3),
      .rate_after_rad_s = -search->direction * (growth_rad_s + stopping->per_acceleration_s2 * at->jerk_after_rad_s3)};
}

static stop_moment moment_at(const stop_search *search, float time_s) {
  const ramp_point at = point_of(search->plan, search->ramp, time_s);
  const stopping_distance stopping = distance_to_stop(&at, search->limits);
  return moment_of(search, time_s, &at, &stopping);
}

static stop_moment moment_now(const stop_search *search, const stopping_distance *stopping) {
  const ramp_plan *plan = search->plan;
  ramp_point at = start_of(search->ramp);
  at.jerk_after_rad_s3 = 0.0f; /* at the plan's rate already */
  for (int i = PIECES - 1; i >= 0; --i) {
    at.jerk_after_rad_s3 = plan->duration_s[i] > 0.0f ? plan->jerk_rad_s3[i] : at.jerk_after_rad_s3;
  }
  return moment_of(search, 0.0f, &at, stopping);
}

/* One time that is too early and one that is too late; the stop in time lies between them. */
typedef struct {
  stop_moment early;
  stop_moment late;
} stop_bracket;

/* Zero, as a share of the interval from `early` (margin above 0) to `late` (below), of the cubic with their values and
 * slopes: Newton's method from the end, bounded by the interval. */
static float cubic_root(const stop_bracket *bracket, float tolerance_rad) {
  const stop_moment *early = &bracket->early;
  const stop_moment *late = &bracket->late;
  const float time_s = late->time_s - early->time_s;
  const float linear = early->rate_after_rad_s * time_s;
  const float slope_sum = linear + late->rate_before_rad_s * time_s;
  const float change = late->margin_rad - early->margin_rad;
  const float square = 3.0f * change - linear - slope_sum;
  const float cube = slope_sum - 2.0f * change;
  const float square_slope = 2.0f * square;
  const float cube_slope = 3.0f * cube;
  float low = 0.0f;
  float high = 1.0f;
  float u = 1.0f;
  float value = late->margin_rad;
  for (int i = 0; i < CUBIC_STEPS && scalar_abs(value) > 0.25f * tolerance_rad; ++i) {
    if (value > 0.0f) {
      low = u;
    } else {
      high = u;
    }
    const float slope = linear + u * (square_slope + u * cube_slope);
    const float next = u - value / slope;
    u = slope < 0.0f && next > low && next < high ? next : 0.5f * (low + high);
    value = early->margin_rad + u * (linear + u * (square + u * cube));
  }
  return u;
}

static void narrow(stop_bracket *bracket, const stop_search *search, float time_s) {
  const stop_moment between = moment_at(search, time_s);
  *(between.margin_rad >= -search->tolerance_rad ? &bracket->early : &bracket->late) = between;
}

/* The latest time in this tick at which a stop still ends within the distance. The slope has a step where pieces of the
 * plan meet: try these points first, so that the rest is smooth. */
static float latest_stop_s(const stop_search *search, stop_bracket *bracket) {
  float meeting_s = 0.0f;
  for (int i = 0; i < PIECES; ++i) {
    meeting_s += search->plan->duration_s[i];
    if (meeting_s > bracket->early.time_s && meeting_s < bracket->late.time_s) {
      narrow(bracket, search, meeting_s);
    }
  }
  for (int i = 0; i < SEARCH_STEPS && bracket->early.margin_rad > search->tolerance_rad; ++i) {
    const float width_s = bracket->late.time_s - bracket->early.time_s;
    narrow(bracket, search, bracket->early.time_s + width_s * cubic_root(bracket, search->tolerance_rad));
  }
  return bracket->early.time_s;
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
      .stops = true,
  };
}

/* One tick of the stop, to wherever it ends. */
static profile_motion stop_tick(profile_ramp *ramp, const profile_limits *limits, float dt_s) {
  const ramp_plan plan = plan_to_rate(ramp, limits, 0.0f);
  profile_motion motion = follow_tick(ramp, &plan, dt_s);
  motion.arrived = profile_at_rest(ramp);
  motion.stops = true;
  return motion;
}

/* One tick towards `rate_rad_s`, or the stop along `braking` that ends at `distance_rad` when it must begin; `stopping`
 * is the distance of a stop from now. */
static profile_motion approach(profile_ramp *ramp, const profile_limits *limits, const profile_limits *braking,
                               float rate_rad_s, float distance_rad, const stopping_distance *stopping, float dt_s) {
  const float margin_rad = distance_rad - stopping->travel_rad;
  const float spare_rad = spare_fraction * scalar_abs(distance_rad);
  if (scalar_abs(margin_rad) <= aim_rad + 2.0f * spare_rad) {
    return stop_tick(ramp, braking, dt_s);
  }
  const ramp_plan plan = plan_to_rate(ramp, limits, rate_rad_s);
  const stop_search search = {.ramp = ramp,
                              .limits = braking,
                              .plan = &plan,
                              .distance_rad = distance_rad,
                              .direction = margin_rad < 0.0f ? -1.0f : 1.0f,
                              .aim_rad = 0.5f * aim_rad + 1.5f * spare_rad,
                              .tolerance_rad = 0.5f * aim_rad + 0.5f * spare_rad};
  stop_bracket bracket = {.late = moment_at(&search, dt_s)};
  if (bracket.late.margin_rad >= -search.tolerance_rad) {
    return follow_tick(ramp, &plan, dt_s);
  }
  bracket.early = moment_now(&search, stopping);
  const float latest_s = latest_stop_s(&search, &bracket);
  return follow_then_stop(ramp, braking, &plan, latest_s, dt_s);
}

profile_motion profile_towards_rate_within(profile_ramp *ramp, const profile_limits *limits,
                                           const profile_limits *braking, float rate_rad_s, float room_rad,
                                           float dt_s) {
  const ramp_point start = start_of(ramp);
  const stopping_distance stopping = distance_to_stop(&start, braking);
  if ((room_rad - stopping.travel_rad) * rate_rad_s <= 0.0f) {
    profile_motion stop = profile_towards_rate(ramp, braking, 0.0f, dt_s);
    stop.stops = true;
    return stop;
  }
  profile_motion motion = approach(ramp, limits, braking, rate_rad_s, room_rad, &stopping, dt_s);
  motion.arrived = motion.arrived && ramp->rate_rad_s == rate_rad_s;
  return motion;
}

profile_motion profile_towards_distance(profile_ramp *ramp, const profile_limits *limits, float distance_rad,
                                        float dt_s) {
  if (profile_at_rest(ramp) && scalar_abs(distance_rad) <= arrived_rad) {
    return (profile_motion){.travel_rad = distance_rad, .arrived = true};
  }
  const ramp_point start = start_of(ramp);
  const stopping_distance stopping = distance_to_stop(&start, limits);
  const float rate_rad_s = distance_rad < stopping.travel_rad ? -limits->rate_rad_s : limits->rate_rad_s;
  profile_motion motion = approach(ramp, limits, limits, rate_rad_s, distance_rad, &stopping, dt_s);
  motion.arrived = profile_at_rest(ramp) && scalar_abs(distance_rad - motion.travel_rad) <= arrived_rad;
  if (motion.arrived) {
    motion.travel_rad = distance_rad;
  }
  return motion;
}
