/* SPDX-License-Identifier: Apache-2.0 */
#include "commissioning/stimulus.h"

#include "base/scalar.h"

#define REST_BEFORE_BREAKAWAY_S 0.5f
#define BEYOND_EVERY_RATIO 1e12f /* of the slowest speed, 1e-6 rad/s */
enum { COUNT_BITS = 10 };        /* of stimulus_setup.count, at most 1000 */
#define CHIRP_FADE 0.05f         /* share of the chirp in which its torque fades in and out */

/* --- requested values --- */

static bool uses_speed(stimulus_kind kind) { return kind == STIMULUS_SWEEP || kind == STIMULUS_CHIRP; }

static bool uses_torque(stimulus_kind kind) {
  return kind == STIMULUS_TORQUE_RAMPS || kind == STIMULUS_CHIRP || kind == STIMULUS_BREAKAWAY;
}

static bool uses_angle(stimulus_kind kind) { return kind == STIMULUS_HYSTERESIS || kind == STIMULUS_BREAKAWAY; }

control_status stimulus_check(const stimulus_setup *setup) {
  if ((int)setup->kind <= (int)STIMULUS_NONE || (int)setup->kind > (int)STIMULUS_BREAKAWAY || setup->count < 1 ||
      setup->count > 1000) {
    return CONTROL_OUT_OF_RANGE;
  }
  const scalar_range dwell = {setup->dwell_s, 0.01f, 1000.0f};
  const scalar_range speed[] = {{setup->low_rad_s, 1e-6f, 1e2f}, {setup->acceleration_rad_s2, 1e-4f, 1e4f}};
  const scalar_range ratio = {setup->speed_ratio, 1.0f, 10.0f};
  const scalar_range torque = {setup->amplitude_nm, 1e-6f, 1e4f};
  const scalar_range angle = {setup->amplitude_rad, 1e-7f, 3.0f};
  const scalar_range frequency[] = {{setup->low_hz, 0.01f, 400.0f}, {setup->high_hz, setup->low_hz, 400.0f}};
  const control_status parts[] = {
      scalar_check_ranges(&dwell, 1),
      scalar_check_ranges(speed, uses_speed(setup->kind) ? 2 : 0),
      scalar_check_ranges(&ratio, setup->kind == STIMULUS_SWEEP ? 1 : 0),
      scalar_check_ranges(&torque, uses_torque(setup->kind) ? 1 : 0),
      scalar_check_ranges(&angle, uses_angle(setup->kind) ? 1 : 0),
      scalar_check_ranges(frequency, setup->kind == STIMULUS_CHIRP ? 2 : 0),
  };
  for (unsigned i = 0; i < sizeof parts / sizeof parts[0]; ++i) {
    if (parts[i] != CONTROL_OK) {
      return parts[i];
    }
  }
  return CONTROL_OK;
}

/* 1 + r + ... + r^(count - 1), and r^count. */
typedef struct {
  float sum;
  float power;
} geometric_series;

/* Doubles the number of terms with each bit of the count: a reading of 0x2100 may not hold up the deferred task. */
static geometric_series series_of(float ratio, uint32_t count) {
  geometric_series series = {.sum = 0.0f, .power = 1.0f};
  /* Bound: COUNT_BITS: the limit of 0x2100:5 is 1000. */
  for (uint32_t bit = 1u << (COUNT_BITS - 1u); bit != 0; bit >>= 1) {
    series.sum += series.sum * series.power;
    series.power *= series.power;
    if ((count & bit) != 0) {
      series.sum = series.sum * ratio + 1.0f;
      series.power *= ratio;
    }
    series.sum = scalar_min(series.sum, BEYOND_EVERY_RATIO);
    series.power = scalar_min(series.power, BEYOND_EVERY_RATIO);
  }
  return series;
}

float stimulus_peak_rate_rad_s(const stimulus_setup *setup) {
  if (setup->kind == STIMULUS_HYSTERESIS) {
    return 4.0f * setup->amplitude_rad / setup->dwell_s;
  }
  if (!uses_speed(setup->kind)) {
    return 0.0f;
  }
  const bool rises = setup->kind == STIMULUS_SWEEP && setup->count > 0;
  return setup->low_rad_s * (rises ? series_of(setup->speed_ratio, setup->count - 1).power : 1.0f);
}

float stimulus_peak_torque_nm(const stimulus_setup *setup) {
  return uses_torque(setup->kind) ? setup->amplitude_nm : 0.0f;
}

float stimulus_duration_s(const stimulus_setup *setup) {
  const float count = (float)setup->count;
  switch (setup->kind) {
    case STIMULUS_SWEEP: /* each speed forth and back, and twice from one to the other */
      return 2.0f * count * setup->dwell_s +
             4.0f * setup->low_rad_s * series_of(setup->speed_ratio, setup->count).sum / setup->acceleration_rad_s2;
    case STIMULUS_CHIRP:
      return count * (2.0f * setup->dwell_s + 4.0f * setup->low_rad_s / setup->acceleration_rad_s2);
    case STIMULUS_BREAKAWAY:
      return count * (setup->dwell_s + REST_BEFORE_BREAKAWAY_S);
    case STIMULUS_TORQUE_RAMPS:
    case STIMULUS_HYSTERESIS:
      return count * setup->dwell_s;
    case STIMULUS_NONE:
    default:
      return 0.0f;
  }
}

void stimulus_start(stimulus_state *s, const stimulus_setup *setup, angle_turn32 angle) {
  *s = (stimulus_state){.start_angle = angle,
                        .direction = 1.0f,
                        .speed_rad_s = setup->low_rad_s,
                        .resting_s = REST_BEFORE_BREAKAWAY_S,
                        .leg_useful = true};
}

/* --- at a speed --- */

static float towards(float value, float target, float step) {
  return value + scalar_clamp(target - value, -step, step);
}

/* The present rate, moving towards `target`, with the acceleration to the next rate. */
static void command_rate(stimulus_state *s, const stimulus_setup *setup, float target_rad_s,
                         servo_axis_command *command, float dt_s) {
  const float next_rad_s = towards(s->rate_rad_s, target_rad_s, setup->acceleration_rad_s2 * dt_s);
  command->mode = SERVO_SPEED;
  command->speed = (speed_reference){s->rate_rad_s, (next_rad_s - s->rate_rad_s) / dt_s};
  s->rate_rad_s = next_rad_s;
}

static bool come_to_rest(stimulus_state *s, const stimulus_setup *setup, servo_axis_command *command, float dt_s) {
  if (s->rate_rad_s == 0.0f) {
    return false;
  }
  command_rate(s, setup, 0.0f, command, dt_s);
  return true;
}

/* Whether the axis must reverse now to come to rest before the end of the travel in its direction. */
static bool at_the_end(const stimulus_state *s, const stimulus_setup *setup, const stimulus_view *view, float dt_s) {
  const float room_rad = view->room_rad - s->direction * view->travel_rad;
  const float ahead_rad_s = scalar_max(s->direction * s->rate_rad_s, 0.0f);
  const float braking_rad = ahead_rad_s * (0.5f * ahead_rad_s / setup->acceleration_rad_s2 + dt_s);
  return room_rad <= braking_rad;
}

static void next_speed(stimulus_state *s, const stimulus_setup *setup) {
  s->time_s[STIMULUS_BACKWARD] = 0.0f;
  s->time_s[STIMULUS_FORWARD] = 0.0f;
  s->speed_rad_s *= setup->speed_ratio;
  s->step++;
  s->ending = s->step >= setup->count;
}

static bool sweep_step(stimulus_state *s, const stimulus_setup *setup, const stimulus_view *view,
                       servo_axis_command *command, float dt_s) {
  if (s->ending) {
    return come_to_rest(s, setup, command, dt_s);
  }
  const int side = s->direction > 0.0f ? STIMULUS_FORWARD : STIMULUS_BACKWARD;
  if (s->rate_rad_s == s->direction * s->speed_rad_s) {
    s->time_s[side] += dt_s;
  }
  const bool enough = s->time_s[side] >= setup->dwell_s;
  if (at_the_end(s, setup, view, dt_s) || (s->leg_useful && enough)) {
    if (enough && s->time_s[1 - side] >= setup->dwell_s) {
      next_speed(s, setup);
    }
    s->direction = -s->direction;
    s->leg_useful = s->time_s[1 - side] < setup->dwell_s;
  }
  command_rate(s, setup, s->ending ? 0.0f : s->direction * s->speed_rad_s, command, dt_s);
  return true;
}

static float sine_of_turns(float turns) {
  const float angle_rad = 2.0f * SCALAR_PI * turns;
  return turns < 0.5f ? scalar_sin(scalar_min(angle_rad, SCALAR_PI))
                      : -scalar_sin(scalar_min(angle_rad - SCALAR_PI, SCALAR_PI));
}

static float chirp_nm(stimulus_state *s, const stimulus_setup *setup, float dt_s) {
  const float share = s->time_s[STIMULUS_FORWARD] / setup->dwell_s;
  const float fade = scalar_min(scalar_min(share, 1.0f - share) / CHIRP_FADE, 1.0f);
  s->phase_turns += (setup->low_hz + (setup->high_hz - setup->low_hz) * share) * dt_s;
  s->phase_turns -= s->phase_turns >= 1.0f ? 1.0f : 0.0f;
  return fade * setup->amplitude_nm * sine_of_turns(s->phase_turns);
}

static bool chirp_step(stimulus_state *s, const stimulus_setup *setup, servo_axis_command *command, float dt_s) {
  if (s->ending) {
    return come_to_rest(s, setup, command, dt_s);
  }
  if (s->rate_rad_s == s->direction * s->speed_rad_s) {
    s->time_s[STIMULUS_FORWARD] += dt_s;
    if (s->time_s[STIMULUS_FORWARD] < setup->dwell_s) {
      command->torque_nm = chirp_nm(s, setup, dt_s);
    } else {
      s->time_s[STIMULUS_FORWARD] = 0.0f;
      s->phase_turns = 0.0f;
      s->step += s->direction < 0.0f ? 1u : 0u;
      s->direction = -s->direction;
      s->ending = s->step >= setup->count;
    }
  }
  command_rate(s, setup, s->ending ? 0.0f : s->direction * s->speed_rad_s, command, dt_s);
  return true;
}

/* --- triangles --- */

/* 0, 1, 0, -1 at the quarters of a turn, linear between. */
static float triangle(float turns) {
  if (turns < 0.25f) {
    return 4.0f * turns;
  }
  return turns < 0.75f ? 2.0f - 4.0f * turns : 4.0f * turns - 4.0f;
}

static bool triangle_step(stimulus_state *s, const stimulus_setup *setup, servo_axis_command *command, float dt_s) {
  if (s->step >= setup->count) {
    return false;
  }
  const float turns = s->time_s[STIMULUS_FORWARD] / setup->dwell_s;
  if (setup->kind == STIMULUS_TORQUE_RAMPS) {
    command->mode = SERVO_TORQUE;
    command->torque_nm = setup->amplitude_nm * triangle(turns);
  } else {
    const float offset_rad = setup->amplitude_rad * triangle(turns);
    const bool rises = turns < 0.25f || turns >= 0.75f;
    command->mode = SERVO_POSITION;
    command->position = s->start_angle + (angle_turn32)(int32_t)(offset_rad / ANGLE_RAD_PER_TURN32);
    command->speed.rate_rad_s = (rises ? 4.0f : -4.0f) * setup->amplitude_rad / setup->dwell_s;
  }
  s->time_s[STIMULUS_FORWARD] += dt_s;
  if (s->time_s[STIMULUS_FORWARD] >= setup->dwell_s) {
    s->time_s[STIMULUS_FORWARD] = 0.0f;
    s->step++;
  }
  return true;
}

/* --- break-away --- */

static void count_breakaway(breakaway_statistics *statistics, float torque_nm) {
  statistics->count++;
  const float deviation_nm = torque_nm - statistics->mean_nm;
  statistics->mean_nm += deviation_nm / (float)statistics->count;
  statistics->square_sum_nm2 += deviation_nm * (torque_nm - statistics->mean_nm);
}

static bool breakaway_step(stimulus_state *s, const stimulus_setup *setup, const stimulus_view *view,
                           servo_axis_command *command, float dt_s) {
  if (s->resting_s > 0.0f) {
    s->resting_s -= dt_s;
    s->from_rad = view->travel_rad;
    command->mode = SERVO_SPEED;
    return true;
  }
  if (s->step >= setup->count) {
    return false;
  }
  const float torque_nm = setup->amplitude_nm * (s->time_s[STIMULUS_FORWARD] / setup->dwell_s);
  const bool moved = s->direction * (view->travel_rad - s->from_rad) > setup->amplitude_rad;
  s->time_s[STIMULUS_FORWARD] += dt_s;
  command->mode = SERVO_TORQUE;
  command->torque_nm = s->direction * torque_nm;
  if (moved) {
    count_breakaway(&s->breakaway[s->direction > 0.0f ? STIMULUS_FORWARD : STIMULUS_BACKWARD], torque_nm);
  }
  if (moved || s->time_s[STIMULUS_FORWARD] >= setup->dwell_s) {
    s->time_s[STIMULUS_FORWARD] = 0.0f;
    s->direction = -s->direction;
    s->resting_s = REST_BEFORE_BREAKAWAY_S;
    s->step++;
  }
  return true;
}

bool stimulus_step(stimulus_state *s, const stimulus_setup *setup, const stimulus_view *view,
                   servo_axis_command *command, float dt_s) {
  *command = (servo_axis_command){.mode = SERVO_SPEED};
  switch (setup->kind) {
    case STIMULUS_SWEEP:
      return sweep_step(s, setup, view, command, dt_s);
    case STIMULUS_CHIRP:
      return chirp_step(s, setup, command, dt_s);
    case STIMULUS_TORQUE_RAMPS:
    case STIMULUS_HYSTERESIS:
      return triangle_step(s, setup, command, dt_s);
    case STIMULUS_BREAKAWAY:
      return breakaway_step(s, setup, view, command, dt_s);
    case STIMULUS_NONE:
    default:
      return false;
  }
}
