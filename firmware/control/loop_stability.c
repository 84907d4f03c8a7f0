/* SPDX-License-Identifier: Apache-2.0 */
#include "control/loop_stability.h"

#include <math.h>

#include "base/scalar.h"

#define LOWEST_OMEGA 3e-5f /* 0.005 Hz */
#define RELATIVE_STEP 0.06f
#define LARGEST_STEP 0.03f
#define SHORTEST_STEP 1e-5f   /* of omega: a phase that still jumps passes through 0 */
#define CAMERA_DELAY_TICKS 36 /* of the paper's loop: age of a frame and its hold */
#define MIN_DAMPING 1e-3f
enum { MAX_EVALUATIONS = 3000 };

static loop_complex real(float value) { return (loop_complex){value, 0.0f}; }
static loop_complex add(loop_complex a, loop_complex b) { return (loop_complex){a.re + b.re, a.im + b.im}; }
static loop_complex times(loop_complex a, loop_complex b) {
  return (loop_complex){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}
static loop_complex scaled(float k, loop_complex a) { return (loop_complex){k * a.re, k * a.im}; }
static float size(loop_complex a) { return sqrtf(a.re * a.re + a.im * a.im); }
static loop_complex over(loop_complex a, loop_complex b) {
  const float square = b.re * b.re + b.im * b.im;
  return (loop_complex){(a.re * b.re + a.im * b.im) / square, (a.im * b.re - a.re * b.im) / square};
}

static loop_complex power(loop_complex base, int exponent) {
  loop_complex result = real(1.0f);
  /* Bound: CAMERA_DELAY_TICKS, or 1 + the delay in ticks: 2056:6 and 2056:7 are at most 10 ms. */
  for (int i = 0; i < exponent; ++i) {
    result = times(result, base);
  }
  return result;
}

/* q = e^-jw, and 1 - q without cancellation. */
typedef struct {
  loop_complex q;
  loop_complex d;
} circle;

static circle on_circle(float omega) {
  circle at;
  if (omega < 0.02f) {
    const float square = omega * omega;
    at.d = (loop_complex){0.5f * square * (1.0f - square / 12.0f), omega * (1.0f - square / 6.0f)};
  } else {
    at.d = (loop_complex){1.0f - scalar_cos(omega), scalar_sin(omega)};
  }
  at.q = (loop_complex){1.0f - at.d.re, -at.d.im};
  return at;
}

/* --- blocks ------------------------------------------------------------------------------------------------------- */

static loop_complex biquad_at(const biquad_params *p, loop_complex q) {
  const loop_complex above = add(real(p->b0), times(q, add(real(p->b1), scaled(p->b2, q))));
  const loop_complex below = add(real(1.0f), times(q, add(real(p->a1), scaled(p->a2, q))));
  return over(above, below);
}

/* The slope of N angles as a mean of the rates of the last N - 1 ticks. */
static loop_complex slope_at(const rate_estimator_params *p, loop_complex q) {
  const float n = (float)p->window_ticks;
  const float scale = 6.0f / (n * (n * n - 1.0f));
  loop_complex sum = real(0.0f);
  /* Bound: RATE_ESTIMATOR_WINDOW_MAX: window_ticks is checked when parameters are set. */
  for (int age = p->window_ticks - 2; age >= 0; --age) {
    const float weight = scale * ((float)age + 1.0f) * (n - 1.0f - (float)age);
    sum = add(real(weight), times(q, sum));
  }
  return sum;
}

/* Rate of an inertia of 1 after a torque of one tick, times 1 - q and over dt: a delay of `delay_ticks`, then the hold.
 * Mean over the last tick (encoder), or at its end (gyro). */
static loop_complex held(circle at, float delay_ticks, bool mean) {
  const int whole = (int)delay_ticks;
  const float m = 1.0f - (delay_ticks - (float)whole);
  const float rest = 1.0f - m;
  loop_complex sum;
  if (mean) {
    const float first = 0.5f * m * m;
    const float last = 0.5f * rest * rest;
    sum = add(real(first), times(at.q, add(real(1.0f - first - last), scaled(last, at.q))));
  } else {
    sum = add(real(m), scaled(rest, at.q));
  }
  return times(power(at.q, whole + 1), sum);
}

/* --- operating points --------------------------------------------------------------------------------------------- */

static bool at_least_inertia(const loop_stability *state) { return state->point >= 2; }

/* Without bristles there is no pre-sliding: its operating points are those of sliding again. */
static bool slides(const loop_stability *state, const loop_plant *plant) {
  return state->point % 2 == 0 || plant->stiffness_nm_rad == 0.0f;
}

static float inertia_of(const loop_stability *state, const loop_plant *plant) {
  return at_least_inertia(state) ? plant->min_inertia_kg_m2 : plant->inertia_kg_m2;
}

/* Of the gains. */
static float share_of(const loop_stability *state, const loop_stability_input *in) {
  return in->gains_follow ? speed_loop_inertia_share(inertia_of(state, &in->plant), in->plant.inertia_kg_m2) : 1.0f;
}

static rate_source source_of(const loop_stability *state, const loop_stability_input *in) {
  return in->gyro_vanishes && at_least_inertia(state) ? RATE_FROM_ENCODER : in->speed.rate_fusion.source;
}

/* --- blocks on the plant ------------------------------------------------------------------------------------------ */

/* Torque to the rate before the filters, of an inertia of 1, times (1 - q) / dt; `*angle` likewise for the tick's mean
 * rate. */
static loop_complex sensed(const loop_stability_input *in, rate_source source, circle at, loop_complex *angle) {
  const speed_loop_params *p = &in->speed;
  *angle = held(at, in->plant.encoder_delay_s / in->dt_s, true);
  const loop_complex joint = times(*angle, slope_at(&p->rate_estimator, at.q));
  if (source == RATE_FROM_ENCODER) {
    return joint;
  }
  const loop_complex gyro = in->gyro_below ? joint : held(at, in->plant.gyro_delay_s / in->dt_s, false);
  if (source == RATE_FROM_GYRO) {
    return gyro;
  }
  const float step = p->rate_fusion.crossover_rad_s * in->dt_s;
  const float blend = step / (1.0f + step);
  const loop_complex lag = add(real(blend), scaled(1.0f - blend, at.d));
  return over(add(scaled(blend, gyro), times(scaled(1.0f - blend, at.d), joint)), lag);
}

/* Rate set-point to what the set-point model shows of it, and to its acceleration. */
static void shaped(const setpoint_model_params *model, float dt_s, circle at, loop_complex *rate,
                   loop_complex *acceleration) {
  *rate = real(1.0f);
  *acceleration = real(0.0f);
  if (model->gain_per_s > 0.0f) {
    const loop_complex lag = add(real(1.0f - model->decay), scaled(model->decay, at.d)); /* 1 - decay q */
    const loop_complex caught = scaled(model->gain_per_s * dt_s, at.q);
    const loop_complex all = add(times(at.d, lag), caught);
    *rate = over(caught, all);
    *acceleration = over(scaled(model->gain_per_s, at.d), all);
  }
}

/* Numerators of the controller over (1 - q)^poles. */
typedef struct {
  loop_complex feedback;
  loop_complex reference;
  int poles;
} controller;

/* The inner feedback of the observer makes 1 / (1 - Q) = lag / (1 - q). Without integral gain a pole at q = 1 and a
 * zero there cancel. */
static controller controller_at(const loop_stability_input *in, float share, circle at) {
  const pi_controller_params *pi = &in->speed.pi;
  const disturbance_observer_params *o = &in->speed.observer;
  const bool integrates = pi->integral_gain > 0.0f;
  const loop_complex zero = integrates ? at.d : real(1.0f);
  const float proportional = share * pi->proportional_gain;
  const loop_complex integral = scaled(share * pi->integral_gain * in->dt_s, at.q);
  loop_complex feedback = add(scaled(proportional, zero), integral);
  loop_complex shown;
  loop_complex acceleration;
  shaped(&in->speed.setpoint_model, in->dt_s, at, &shown, &acceleration);
  loop_complex reference = add(times(add(scaled(pi->setpoint_weight * proportional, zero), integral), shown),
                               scaled(share * in->speed.acceleration_inertia_kg_m2, times(acceleration, zero)));
  int poles = 0;
  if (integrates) {
    poles = 1;
  }
  if (in->speed.observer_on) {
    const float blend = 1.0f - scalar_exp_minus(o->bandwidth_rad_s * in->dt_s);
    const loop_complex lag = add(real(blend), scaled(1.0f - blend, at.d));
    const loop_complex observed =
        add(scaled(share * blend * o->inertia_kg_m2 / in->dt_s, at.d), scaled(blend * o->viscous_nm_s_rad, at.q));
    feedback = add(times(feedback, lag), times(observed, zero));
    reference = times(reference, lag);
    ++poles;
  }
  return (controller){feedback, reference, poles};
}

/* --- the loops ---------------------------------------------------------------------------------------------------- */

typedef struct {
  loop_complex g[LOOP_COUNT];
  float open[LOOP_COUNT]; /* size of G without feedback: |1 + L| = |G| / open */
} characteristic;

/* The seal: s / (s^2 + a s + b) of an inertia of 1 becomes 4 (1 - q) dt / M or, sliding, 4 dt / M with the bilinear s.
 */
static characteristic evaluate(const loop_stability *state, const loop_stability_input *in, float omega) {
  const circle at = on_circle(omega);
  const loop_plant *plant = &in->plant;
  const bool sliding = slides(state, plant);
  const float inertia = inertia_of(state, plant);
  const float damping = plant->viscous_nm_s_rad + (sliding ? 0.0f : plant->damping_nm_s_rad);
  const float a = scalar_max(damping / inertia, MIN_DAMPING) * in->dt_s;
  const float b = sliding ? 0.0f : plant->stiffness_nm_rad / inertia * in->dt_s * in->dt_s;
  const loop_complex n = add(real(2.0f), scaled(-1.0f, at.d));
  loop_complex m = add(scaled(4.0f, at.d), scaled(2.0f * a, n));
  const controller c = controller_at(in, share_of(state, in), at);
  int poles = c.poles;
  loop_complex zero = real(1.0f);
  if (!sliding) { /* the spring's zero at q = 1 cancels a pole of the controller, if it has one */
    m = add(times(m, at.d), scaled(b, times(n, n)));
    zero = poles == 0 ? at.d : zero;
    poles -= poles > 0 ? 1 : 0;
  }
  loop_complex angle;
  const loop_complex rate = sensed(in, source_of(state, in), at, &angle);
  const float drive = 4.0f * in->dt_s / inertia;
  const loop_complex filtered =
      times(rate, times(biquad_at(&in->speed.notch, at.q), biquad_at(&in->speed.lowpass, at.q)));
  const loop_complex without = times(power(at.d, poles), m);
  characteristic result;
  result.g[LOOP_SPEED] = add(without, scaled(drive, times(zero, times(filtered, c.feedback))));
  result.open[LOOP_SPEED] = size(without);

  /* Outer loops: the rate set-point follows the integral of the rate; the spring's zero is its pole. */
  const bool cancels = !sliding && c.poles == 0;
  const loop_complex pole = cancels ? real(1.0f) : at.d;
  const loop_complex speed = times(result.g[LOOP_SPEED], pole);
  const float open = size(without) * size(pole);
  const loop_complex by_angle = scaled(drive * in->dt_s, times(angle, c.reference));
  const loop_complex by_rate = scaled(drive * in->dt_s, times(rate, c.reference));
  result.g[LOOP_POSITION] = add(speed, scaled(in->position_per_s, by_angle));
  result.open[LOOP_POSITION] = open;
  if (in->tracker.proportional_per_s == 0.0f &&
      (in->tracker.kind == TRACKER_PREDICTIVE || in->tracker.integral_per_s2 == 0.0f)) {
    result.g[LOOP_TRACKING] = result.g[LOOP_SPEED]; /* it does nothing */
    result.open[LOOP_TRACKING] = result.open[LOOP_SPEED];
  } else if (in->tracker.kind == TRACKER_PREDICTIVE) {
    result.g[LOOP_TRACKING] = add(speed, scaled(in->tracker.proportional_per_s, by_rate));
    result.open[LOOP_TRACKING] = open;
  } else {
    const bool integrates = in->tracker.integral_per_s2 > 0.0f;
    const loop_complex again = integrates ? at.d : real(1.0f);
    const loop_complex pi =
        add(scaled(in->tracker.proportional_per_s, again), real(in->tracker.integral_per_s2 * in->dt_s));
    const loop_complex delayed = times(power(at.q, CAMERA_DELAY_TICKS), by_angle);
    result.g[LOOP_TRACKING] = add(times(speed, again), times(pi, delayed));
    result.open[LOOP_TRACKING] = open * size(again);
  }
  return result;
}

/* --- along the circle --------------------------------------------------------------------------------------------- */

/* Where the curve turns within a narrow band: a notch, a resonant low-pass, the spring of the seal. */
typedef struct {
  float centre;
  float width;
} narrow_band;

/* Of the poles of a filter; one that is off has none. */
static narrow_band band_of(const biquad_params *p) {
  const float alpha = (1.0f - p->a2) / (1.0f + p->a2);
  const float cosine = scalar_clamp(-0.5f * p->a1 * (1.0f + alpha), -1.0f, 1.0f);
  return (narrow_band){.centre = acosf(cosine), .width = scalar_clamp(2.0f * alpha, 1e-6f, 1.0f)};
}

static narrow_band spring_band(const loop_stability *state, const loop_stability_input *in) {
  const float inertia = inertia_of(state, &in->plant);
  return (narrow_band){
      .centre = sqrtf(in->plant.stiffness_nm_rad / inertia) * in->dt_s,
      .width = scalar_max((in->plant.damping_nm_s_rad + in->plant.viscous_nm_s_rad) / inertia, MIN_DAMPING) * in->dt_s};
}

/* A quarter of the width within the band, a third of the way to it outside. */
static float step_near(narrow_band band, float omega) {
  return scalar_max(0.25f * band.width, scalar_abs(omega - band.centre) / 3.0f);
}

static float longest_step(const loop_stability *state, const loop_stability_input *in, float omega) {
  const float smooth = scalar_min(RELATIVE_STEP * omega, LARGEST_STEP);
  const float filters =
      scalar_min(step_near(band_of(&in->speed.notch), omega), step_near(band_of(&in->speed.lowpass), omega));
  return scalar_min(
      smooth, slides(state, &in->plant) ? filters : scalar_min(filters, step_near(spring_band(state, in), omega)));
}

static void start_point(loop_stability *state) {
  state->omega = 0.0f;
  state->step = LOWEST_OMEGA;
  state->evaluations = 0;
  for (int i = 0; i < LOOP_COUNT; ++i) {
    state->phase[i] = 0.0f;
  }
}

void loop_stability_start(loop_stability *state) {
  *state = (loop_stability){.verdict = LOOP_RUNNING, .distance = 1.0f};
  start_point(state);
}

static float angle_between(loop_complex from, loop_complex to) {
  return atan2f(from.re * to.im - from.im * to.re, from.re * to.re + from.im * to.im);
}

static void end_point(loop_stability *state) {
  for (int i = 0; i < LOOP_COUNT; ++i) {
    if (scalar_abs(state->phase[i]) > 0.5f * SCALAR_PI) {
      state->verdict = LOOP_REFUSED;
      return;
    }
  }
  ++state->point;
  if (state->point == LOOP_OPERATING_POINTS) {
    state->verdict = LOOP_STABLE;
  } else {
    start_point(state);
  }
}

static float distance_required(const loop_stability *state, const loop_stability_input *in) {
  return at_least_inertia(state) && !in->gains_follow ? LOOP_LEAST_DISTANCE_OF_FIXED_GAINS : LOOP_LEAST_DISTANCE;
}

/* Whether every phase moved little enough; then the values are taken. `least`: smallest |1 + L|. */
static bool take(loop_stability *state, const characteristic *now, float omega, float least) {
  float turned[LOOP_COUNT];
  float most = 0.0f;
  for (int i = 0; i < LOOP_COUNT; ++i) {
    turned[i] = angle_between(state->last[i], now->g[i]);
    most = scalar_max(most, scalar_abs(turned[i]));
  }
  if (most > LOOP_PHASE_STEP && state->step > SHORTEST_STEP * omega) {
    return false;
  }
  for (int i = 0; i < LOOP_COUNT; ++i) {
    state->phase[i] += turned[i];
    state->last[i] = now->g[i];
    const float far = size(now->g[i]);
    state->distance = scalar_min(state->distance, far / scalar_max(now->open[i], 1e-30f));
    if (!(far >= least * now->open[i]) || most > LOOP_PHASE_STEP) {
      state->verdict = LOOP_REFUSED;
    }
  }
  state->omega = omega;
  return true;
}

static void advance(loop_stability *state, const loop_stability_input *input) {
  if (state->evaluations == 0) { /* at w = 0 G is real */
    const characteristic still = evaluate(state, input, 0.0f);
    for (int i = 0; i < LOOP_COUNT; ++i) {
      state->last[i] = still.g[i];
      if (!(still.g[i].re > 0.0f)) {
        state->verdict = LOOP_REFUSED;
      }
    }
    state->evaluations = 1;
    return;
  }
  const float omega = scalar_min(state->omega + state->step, SCALAR_PI);
  const characteristic now = evaluate(state, input, omega);
  ++state->evaluations;
  if (!take(state, &now, omega, distance_required(state, input))) {
    state->step *= 0.5f;
  } else if (omega >= SCALAR_PI && state->verdict == LOOP_RUNNING) {
    end_point(state);
  } else {
    state->step = scalar_min(2.0f * state->step, longest_step(state, input, omega));
  }
  if (state->evaluations > MAX_EVALUATIONS) {
    state->verdict = LOOP_REFUSED;
  }
}

loop_verdict loop_stability_step(loop_stability *state, const loop_stability_input *input, int count) {
  /* Bound: AXIS_TUNING_SLICE: what its caller gives. */
  for (int i = 0; i < count && state->verdict == LOOP_RUNNING; ++i) {
    advance(state, input);
  }
  return state->verdict;
}
