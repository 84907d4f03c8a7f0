/* SPDX-License-Identifier: Apache-2.0 */
#include "protection/motor_witness.h"

#include "base/scalar.h"

#define RIPPLE 0.04f           /* of the back-EMF, over the angle */
#define WARM_WINDING 0.1f      /* above the tolerance */
#define RESISTANCE_DRIFT 0.03f /* 1/s: a winding that warms by 7 K/s, at twice the continuous current */
#define BACK_EMF_DRIFT 0.003f  /* 1/s: magnets are slower */
#define ZERO_SMOOTHING_S 0.01f
#define UNKNOWN_ZERO_A 0.05f
#define LEARNED_SHARE 0.25f /* of the signals that are judged: the smoothing of those that are learned from */
#define CLEAR_ERRORS 2.0f   /* a share is measured where its voltage is this many times the error */

#define OFFSET_NOISE 0.1f /* of 2060:13 */

enum { ZERO_TICKS = 50, OTHER_TICKS = 3 };

float motor_witness_zero_error_a(const motor_witness *witness) {
  return witness->idle_ticks < ZERO_TICKS ? UNKNOWN_ZERO_A : 0.0f;
}

void motor_witness_forget(motor_witness *witness) {
  motor_witness_forget_motor(witness);
  witness->zero_a = 0.0f;
  witness->idle_ticks = 0;
}

static motor_interval widest_resistance(const motor_witness_limits *limits) {
  return (motor_interval){1.0f - limits->tolerance, 1.0f + limits->tolerance + WARM_WINDING};
}

static motor_interval widest_back_emf(const motor_witness_limits *limits) {
  return (motor_interval){1.0f - limits->tolerance, 1.0f + limits->tolerance};
}

/* The range of `factor` x for x in the interval. */
static motor_interval times(motor_interval interval, float factor) {
  const float a = interval.low * factor;
  const float b = interval.high * factor;
  return (motor_interval){scalar_min(a, b), scalar_max(a, b)};
}

/* e of the smoothed voltage. */
static float error_v(const motor_witness *witness, const motor_witness_limits *limits, const motor_signals *seen) {
  const float late_rad_s = MOTOR_WITNESS_RATE_DELAY_S * scalar_abs(seen->acceleration_rad_s2);
  return limits->back_emf_error_v + motor_witness_zero_error_a(witness) * witness->resistance_ohm +
         witness->back_emf_v_s_rad * (RIPPLE * scalar_abs(seen->rate_rad_s) + late_rad_s) +
         limits->tolerance * scalar_abs(seen->inductive_v);
}

/* Other motor data make the learned shares void. */
static void take_data(motor_witness *witness, const motor_witness_limits *limits, const motor_data *motor) {
  if (witness->known && witness->resistance_ohm == motor->resistance_ohm &&
      witness->back_emf_v_s_rad == motor->back_emf_v_s_rad) {
    return;
  }
  witness->known = true;
  witness->resistance_ohm = motor->resistance_ohm;
  witness->back_emf_v_s_rad = motor->back_emf_v_s_rad;
  witness->resistance = widest_resistance(limits);
  witness->back_emf = widest_back_emf(limits);
}

static void follow(float *slow, float now, float share) { *slow += (now - *slow) * share; }

/* The filters start at 0: the three signals then agree from the first tick on. */
static void stop(motor_witness *witness) {
  witness->running = false;
  witness->fast = (motor_signals){0};
  witness->slow = (motor_signals){0};
  witness->unexplained_v = 0.0f;
  witness->verdict = MOTOR_AGREES;
  witness->ticks = 0;
}

/* A converter that is repaired has another offset at once. */
static void measure_zero(motor_witness *witness, float current_a, float largest_a, float dt_s) {
  const float noise_a = scalar_max(UNKNOWN_ZERO_A, OFFSET_NOISE * largest_a);
  witness->other_ticks = scalar_within(current_a - witness->zero_a, noise_a) ? 0 : witness->other_ticks + 1;
  if (witness->other_ticks >= OTHER_TICKS) {
    witness->zero_a = current_a;
    witness->idle_ticks = 0;
  }
  follow(&witness->zero_a, current_a, dt_s / ZERO_SMOOTHING_S);
  witness->idle_ticks += witness->idle_ticks < ZERO_TICKS ? 1 : 0;
}

/* What is left of the voltage when the best permitted motor has explained its part: the voltage is compared with the
 * middle of what all of them permit, and with half of its width. Both are counted twice. */
static float unexplained(const motor_witness *witness, const motor_witness_limits *limits) {
  const motor_signals *seen = &witness->fast;
  const motor_interval *r = &witness->resistance;
  const motor_interval *k = &witness->back_emf;
  const float drop_v = witness->resistance_ohm * seen->current_a;
  const float emf_v = witness->back_emf_v_s_rad * seen->rate_rad_s;
  const float twice_v = 2.0f * seen->voltage_v - (r->low + r->high) * drop_v - (k->low + k->high) * emf_v;
  const float width_v = (r->high - r->low) * scalar_abs(drop_v) + (k->high - k->low) * scalar_abs(emf_v) +
                        2.0f * error_v(witness, limits, seen);
  return scalar_within(twice_v, width_v) ? 0.0f : 0.5f * (twice_v > 0.0f ? twice_v - width_v : twice_v + width_v);
}

/* Too little back-EMF in the right direction is a matter of the motor, everything else of the sensors. */
static motor_verdict judge(const motor_witness *witness) {
  const float expected_v = witness->back_emf_v_s_rad * witness->fast.rate_rad_s;
  const float seen_v = witness->fast.voltage_v - witness->resistance_ohm * witness->fast.current_a;
  const bool less = witness->unexplained_v * expected_v < 0.0f && seen_v * expected_v > 0.0f;
  return less ? MOTOR_WEAK : MOTOR_CONTRADICTS;
}

motor_verdict motor_witness_step(motor_witness *witness, const motor_witness_limits *limits, const motor_data *motor,
                                 const motor_witness_inputs *in, float dt_s) {
  const float rise_a = in->now_a - witness->now_a;
  witness->now_a = in->now_a;
  const float all = scalar_abs(in->now_a) + scalar_abs(in->current_a) + scalar_abs(in->voltage_v);
  const bool usable = in->driven && limits->tolerance > 0.0f && scalar_within(all, 1e6f);
  if (!usable) {
    if (in->idle && scalar_within(in->current_a, limits->largest_zero_a)) {
      measure_zero(witness, in->current_a, limits->largest_zero_a, dt_s);
    }
    if (witness->running) {
      stop(witness);
    }
    return MOTOR_AGREES;
  }
  take_data(witness, limits, motor);
  const float inductive_v = motor->time_constant_s * motor->resistance_ohm / dt_s * rise_a;
  const float share = dt_s / MOTOR_WITNESS_SMOOTHING_S;
  witness->running = true;
  witness->fast.acceleration_rad_s2 = (in->rate_rad_s - witness->fast.rate_rad_s) / MOTOR_WITNESS_SMOOTHING_S;
  follow(&witness->fast.voltage_v, in->voltage_v - inductive_v, share);
  follow(&witness->fast.inductive_v, inductive_v, share);
  follow(&witness->fast.current_a, in->current_a - witness->zero_a, share);
  follow(&witness->fast.rate_rad_s, in->rate_rad_s, share);
  witness->unexplained_v = unexplained(witness, limits);
  if (witness->unexplained_v == 0.0f) {
    witness->verdict = MOTOR_AGREES;
    return MOTOR_AGREES;
  }
  const motor_verdict verdict = judge(witness);
  if (verdict != witness->verdict) {
    witness->verdict = verdict;
    witness->ticks = 0;
  }
  const float left_v =
      limits->largest_v + limits->tolerance * scalar_abs(motor->resistance_ohm * witness->fast.current_a);
  witness->ticks += scalar_within(witness->unexplained_v, left_v) ? 1 : 0;
  return witness->ticks >= MOTOR_WITNESS_TICKS ? verdict : MOTOR_AGREES;
}

/* [low, high] becomes what it has in common with the measurement; never empty. */
static void cut(motor_interval *interval, motor_interval measured) {
  const float low = scalar_clamp(measured.low, interval->low, interval->high);
  interval->high = scalar_clamp(measured.high, low, interval->high);
  interval->low = low;
}

static void widen(motor_interval *interval, motor_interval widest, float by) {
  interval->low = scalar_max(interval->low - by, widest.low);
  interval->high = scalar_min(interval->high + by, widest.high);
}

/* The share that makes `unit_v` explain what `other` leaves of the voltage. */
static void measure(motor_interval *interval, float voltage_v, motor_interval other, float error, float unit_v) {
  if (scalar_within(unit_v, CLEAR_ERRORS * error)) {
    return;
  }
  const motor_interval rest = {voltage_v - other.high - error, voltage_v - other.low + error};
  cut(interval, times(rest, 1.0f / unit_v));
}

void motor_witness_learn(motor_witness *witness, const motor_witness_limits *limits, float dt_s) {
  if (!witness->known) {
    return;
  }
  widen(&witness->resistance, widest_resistance(limits), RESISTANCE_DRIFT * dt_s);
  widen(&witness->back_emf, widest_back_emf(limits), BACK_EMF_DRIFT * dt_s);
  if (!witness->running) {
    return;
  }
  motor_signals *seen = &witness->slow;
  const float share = LEARNED_SHARE * dt_s / MOTOR_WITNESS_SMOOTHING_S;
  follow(&seen->voltage_v, witness->fast.voltage_v, share);
  follow(&seen->current_a, witness->fast.current_a, share);
  follow(&seen->rate_rad_s, witness->fast.rate_rad_s, share);
  follow(&seen->inductive_v, witness->fast.inductive_v, share);
  follow(&seen->acceleration_rad_s2, witness->fast.acceleration_rad_s2, share);
  if (witness->verdict != MOTOR_AGREES) {
    return;
  }
  const float drop_v = witness->resistance_ohm * seen->current_a;
  const float emf_v = witness->back_emf_v_s_rad * seen->rate_rad_s;
  const float error = error_v(witness, limits, seen);
  measure(&witness->resistance, seen->voltage_v, times(witness->back_emf, emf_v), error, drop_v);
  measure(&witness->back_emf, seen->voltage_v, times(witness->resistance, drop_v), error, emf_v);
}

float motor_witness_bound_rad_s(const motor_witness *witness, const motor_witness_limits *limits) {
  const motor_signals *seen = &witness->fast;
  const float width = witness->resistance.high - witness->resistance.low;
  const float drop_v = width * scalar_abs(witness->resistance_ohm * seen->current_a);
  const float of_rate = (witness->back_emf.high - witness->back_emf.low) * scalar_abs(seen->rate_rad_s);
  return (2.0f * error_v(witness, limits, seen) + drop_v) / witness->back_emf_v_s_rad + of_rate;
}
