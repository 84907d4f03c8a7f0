/* SPDX-License-Identifier: Apache-2.0 */
/* The envelope against an integrator in double precision: whatever drives the axis, it stops at the end of the travel.
 *
 * The machine of the judge: an inertia, a motor whose current slews, set-points that count 0.1 ms after a sample, an
 * encoder of 26 bits whose sample is old, and a disturbance outwards. Its own current limit and inertia decide; the
 * block knows only 2060:19. */
#include "protection/envelope.h"

#include <math.h>

#include "support/check.h"
#include "support/random.h"
#include "unity.h"

#define DT_S 0.001f
#define TURN_RAD 6.283185307179586
#define END_RAD 1.0
#define OUTSIDE_RAD_S 0.03 /* nothing is too fast below it */
#define OUTWARDS_RAD 0.002 /* beyond the end, FAULT_BEYOND_TRAVEL brakes an axis however slow it is */

enum { STEPS = 40 }; /* of the integrator, in a tick */

void setUp(void) {}
void tearDown(void) {}

typedef enum { COASTS, ACCELERATES, STEPS_LATE, ADVERSARIES } adversary;

typedef struct {
  double full_rad_s2;       /* of the motor alone, at its current limit */
  double disturbance_share; /* of that, outwards */
  double slew_share_s;      /* time in which the current goes from one limit to the other */
  double age_s;             /* of a sample */
} machine;

typedef struct {
  double angle_rad;
  double rate_rad_s;
  double share; /* of the full current now */
  double wanted;
} motion;

typedef struct {
  double beyond_rad;  /* farthest beyond the end of the travel */
  double end_rad_s;   /* fastest beyond it */
  double tripped_rad; /* distance to the end when the envelope took over; -1: never */
  double rest_rad_s;  /* rate at the end of the run */
  bool fails;
} outcome;

static angle_turn32 encoder(double angle_rad) {
  const double counts = floor(angle_rad / TURN_RAD * 67108864.0 + 0.5);
  return (angle_turn32)((int64_t)counts * 64);
}

static void move(const machine *m, motion *x, double duration_s, int steps) {
  const double dt = duration_s / steps;
  for (int i = 0; i < steps; ++i) {
    const double slew = 2.0 / m->slew_share_s * dt;
    const double change = x->wanted - x->share;
    x->share += change > slew ? slew : change < -slew ? -slew : change;
    const double gain = (x->share + m->disturbance_share) * m->full_rad_s2 * dt;
    x->angle_rad += (x->rate_rad_s + 0.5 * gain) * dt;
    x->rate_rad_s += gain;
  }
}

/* Outwards as the adversary likes, until the envelope takes over. */
static double adversarial(adversary how, const machine *m, const envelope_limits *limits, const motion *x) {
  const double room = END_RAD - x->angle_rad;
  const double nearly = 1.01 * x->rate_rad_s;
  const bool late = nearly >= (double)envelope_fastest_rad_s(limits, (float)(room - 0.001 * x->rate_rad_s));
  switch (how) {
    case ACCELERATES:
      return 1.0;
    case STEPS_LATE: /* full torque in the last tick in which that is possible */
      return late ? 1.0 : -m->disturbance_share;
    default:
      return -m->disturbance_share;
  }
}

static outcome run(const machine *m, const envelope_params *params, adversary how, double rate_rad_s, double room_rad) {
  envelope_state state = {0};
  const envelope_limits limits = envelope_prepare(params, DT_S);
  motion x = {.angle_rad = END_RAD - room_rad - 0.006 * rate_rad_s, .rate_rad_s = rate_rad_s};
  outcome o = {.beyond_rad = -1.0, .tripped_rad = -1.0};
  envelope_phase phase = ENVELOPE_RUNNING;
  x.share = x.wanted = how == COASTS ? -m->disturbance_share : 0.0;
  double sampled_rad = x.angle_rad;
  for (int tick = 0; tick < 4000; ++tick) {
    const unsigned found = envelope_step(&state, &limits, phase, true, encoder(sampled_rad), (float)sampled_rad, 0.0f);
    const bool beyond_travel = sampled_rad > END_RAD + OUTWARDS_RAD;
    if (((found & ENVELOPE_TOO_FAST) != 0 || beyond_travel) && phase == ENVELOPE_RUNNING) {
      phase = ENVELOPE_BRAKING;
      o.tripped_rad = END_RAD - x.angle_rad;
    }
    o.fails = o.fails || (found & ENVELOPE_BRAKING_FAILS) != 0;
    if (envelope_at_rest(&state)) {
      break;
    }
    move(m, &x, 0.0001, STEPS / 10);
    x.wanted = phase == ENVELOPE_BRAKING ? (double)envelope_brake(&state, &limits) : adversarial(how, m, &limits, &x);
    move(m, &x, 0.0009 - m->age_s, STEPS);
    sampled_rad = x.angle_rad;
    move(m, &x, m->age_s, STEPS / 10);
    const double beyond = x.angle_rad - END_RAD;
    o.beyond_rad = beyond > o.beyond_rad ? beyond : o.beyond_rad;
    o.end_rad_s = beyond > 0.0 && x.rate_rad_s > o.end_rad_s ? x.rate_rad_s : o.end_rad_s;
  }
  o.rest_rad_s = x.rate_rad_s;
  return o;
}

/* What the header states: the soft end, the hold against the disturbance, and a step of the torque that no sample has
 * shown yet. */
static double allowed_rad(const machine *m, double a, double rate_rad_s) {
  const double unseen_rad_s = 0.0025 * m->full_rad_s2 * (1.0 + m->disturbance_share);
  const double soft_rad = a * 0.02 * 0.02 + m->disturbance_share * a * 0.02 * 0.06;
  return soft_rad + unseen_rad_s * (rate_rad_s + unseen_rad_s) / a + 0.004 * unseen_rad_s;
}

static void judge(const machine *m, double a, adversary how, double rate_rad_s, double room_rad, outcome *worst,
                  double *worst_share) {
  const envelope_params params = {
      .minimum_rad = -20.0f, .maximum_rad = (float)END_RAD, .deceleration_rad_s2 = (float)a};
  const outcome o = run(m, &params, how, rate_rad_s, room_rad);
  const double slow_rad =
      OUTSIDE_RAD_S * (0.004 + OUTSIDE_RAD_S / (2.0 * a)) + (o.tripped_rad < 0.0 ? OUTWARDS_RAD : 0.0);
  const double allowed = slow_rad + allowed_rad(m, a, fmax(rate_rad_s, sqrt(2.0 * m->full_rad_s2 * room_rad)));
  char text[200];
  (void)snprintf(text, sizeof text,
                 "a %.2f full %.2f share %.2f how %d rate %.3f room %.4f: %.2f mrad beyond at %.3f rad/s", a,
                 m->full_rad_s2, m->disturbance_share, (int)how, rate_rad_s, room_rad, 1e3 * o.beyond_rad, o.end_rad_s);
  TEST_ASSERT_TRUE_MESSAGE(o.tripped_rad > -0.5 || how == COASTS, text);
  TEST_ASSERT_TRUE_MESSAGE(o.beyond_rad <= allowed, text);
  TEST_ASSERT_FALSE_MESSAGE(o.fails, text);
  TEST_ASSERT_TRUE_MESSAGE(fabs(o.rest_rad_s) < 0.01, text);
  worst->beyond_rad = fmax(worst->beyond_rad, o.beyond_rad);
  worst->end_rad_s = fmax(worst->end_rad_s, o.end_rad_s);
  *worst_share = fmax(*worst_share, o.beyond_rad / allowed);
}

/* Positions, rates, decelerations, inertias, disturbances and adversaries: the axis comes to rest at the end of the
 * travel, but for the distance that the header states. */
static void test_no_adversary_passes_the_end_of_the_travel(void) {
  static const double decelerations[] = {0.5, 2.0, 4.67, 6.72, 20.0};
  static const double shares[] = {0.0, 0.1, 0.3};
  static const double inertias[] = {1.0, 0.5}; /* of the largest one, for which a holds */
  outcome worst = {.beyond_rad = -1.0};
  double worst_share = 0.0;
  int runs = 0;
  const int places =
      random_cases(12) > 0 ? 12 : 1; /* on the emulated core one, because it computes double in software */
  for (unsigned d = 0; d < sizeof decelerations / sizeof decelerations[0]; ++d) {
    for (unsigned s = 0; s < sizeof shares / sizeof shares[0]; ++s) {
      for (unsigned j = 0; j < 2; ++j) {
        const double a = decelerations[d];
        const machine m = {a / (1.0 - shares[s]) / inertias[j], shares[s] * inertias[j], 0.002, 0.00012};
        for (int how = 0; how < ADVERSARIES; ++how) {
          for (double rate = 0.02; rate < 2.2; rate *= 1.35) {
            const envelope_params params = {
                .minimum_rad = -20.0f, .maximum_rad = 1.0f, .deceleration_rad_s2 = (float)a};
            const envelope_limits limits = envelope_prepare(&params, DT_S);
            double room = 0.0005;
            while ((double)envelope_fastest_rad_s(&limits, (float)room) < rate && room < 15.0) {
              room *= 1.02;
            }
            for (int n = 0; n < places; ++n) {
              judge(&m, a, (adversary)how, rate, room * (1.0 + 0.001 * n) + 0.0002 * n, &worst, &worst_share);
              ++runs;
            }
          }
        }
      }
    }
  }
  LOG_VALUE("runs", runs);
  LOG_VALUE("mrad beyond the end at most", 1e3 * worst.beyond_rad);
  LOG_VALUE("rad/s beyond the end at most", worst.end_rad_s);
  LOG_VALUE("share of the stated distance", worst_share);
}

/* The figures of docs/safety.md: the shipped machines from the over-speed limit, without a disturbance and with the
 * largest one that 2060:19 counts, which takes what the motor has beyond it. */
static void test_the_stated_distances_are_those_of_the_shipped_machines(void) {
  static const struct {
    const char *what;
    double torque_nm;
    double inertia_kg_m2;
    double a; /* 2060:19 */
    double calm_mrad;
    double wind_mrad;
  } machines[] = {{"azimuth, mrad", 40.0, 6.0, 5.0, 7.1, 9.9}, {"pitch, mrad", 24.0, 2.5, 7.2, 8.1, 11.5}};
  for (unsigned i = 0; i < sizeof machines / sizeof machines[0]; ++i) {
    const double full_rad_s2 = machines[i].torque_nm / machines[i].inertia_kg_m2;
    const machine calm = {full_rad_s2, 0.0, 0.002, 0.00012};
    const machine wind = {full_rad_s2, 1.0 - machines[i].a / full_rad_s2, 0.002, 0.00012};
    CHECK_NEAR(machines[i].what, machines[i].calm_mrad, 1e3 * allowed_rad(&calm, machines[i].a, 1.5), 0.05);
    CHECK_NEAR(machines[i].what, machines[i].wind_mrad, 1e3 * allowed_rad(&wind, machines[i].a, 1.5), 0.05);
  }
}

/* The judge sees an envelope that trusts in more than the machine has. */
static void test_a_deceleration_that_the_machine_does_not_have_is_not_enough(void) {
  const machine m = {4.67, 0.0, 0.002, 0.00012};
  const envelope_params params = {.minimum_rad = -20.0f, .maximum_rad = 1.0f, .deceleration_rad_s2 = 1.5f * 4.67f};
  const outcome o = run(&m, &params, COASTS, 1.4, 0.3);
  CHECK_AT_LEAST("rad beyond", 0.03, o.beyond_rad);
}

/* --- step by step ------------------------------------------------------------------------------------------------- */

typedef struct {
  envelope_state state;
  envelope_params params;
  envelope_phase phase;
  bool powered;
  bool angle_valid;
  double angle_rad;
  float reference_rad_s; /* of the speed loop, in the last tick */
} bench;

typedef struct {
  bool too_fast;
  bool stop_ignored;
  bool braking_fails;
  bool at_rest;
  unsigned found; /* all of it */
  float brake;
} outputs;

static bench new_bench(void) {
  return (bench){.params = {.minimum_rad = -3.0f,
                            .maximum_rad = 3.0f,
                            .deceleration_rad_s2 = 4.0f,
                            .stop_deceleration_rad_s2 = 1.0f},
                 .phase = ENVELOPE_RUNNING,
                 .powered = true,
                 .angle_valid = true};
}

static outputs turn(bench *b, double rate_rad_s, int ticks) {
  const envelope_limits limits = envelope_prepare(&b->params, DT_S);
  unsigned found = 0;
  float brake = 0.0f;
  for (int i = 0; i < ticks; ++i) {
    b->angle_rad += 0.001 * rate_rad_s;
    if (b->angle_valid) {
      found = envelope_step(&b->state, &limits, b->phase, b->powered, encoder(b->angle_rad), (float)b->angle_rad,
                            b->reference_rad_s);
    } else {
      envelope_lose(&b->state, b->phase);
    }
    brake = envelope_brake(&b->state, &limits);
  }
  return (outputs){.too_fast = (found & ENVELOPE_TOO_FAST) != 0,
                   .stop_ignored = (found & ENVELOPE_STOP_IGNORED) != 0,
                   .braking_fails = (found & ENVELOPE_BRAKING_FAILS) != 0,
                   .at_rest = envelope_at_rest(&b->state),
                   .found = found,
                   .brake = brake};
}

static float fastest_rad_s(const bench *b, float room_rad) {
  const envelope_limits limits = envelope_prepare(&b->params, DT_S);
  return envelope_fastest_rad_s(&limits, room_rad);
}

static void test_both_ends_and_both_directions_are_alike(void) {
  for (int direction = -1; direction <= 1; direction += 2) {
    bench b = new_bench();
    b.angle_rad = direction * (3.0 - 0.30);
    const float fastest = fastest_rad_s(&b, 0.29f);
    TEST_ASSERT_FALSE(turn(&b, 0.95 * (double)fastest * direction, 6).too_fast);
    b.angle_rad = direction * (3.0 - 0.30);
    TEST_ASSERT_FALSE(turn(&b, -0.99 * (double)fastest * direction, 6).too_fast); /* inwards */
    b.angle_rad = direction * (3.0 - 0.29);
    TEST_ASSERT_TRUE(turn(&b, 1.06 * (double)fastest * direction, 6).too_fast);
    TEST_ASSERT_TRUE(turn(&b, 1.06 * (double)fastest * direction, 1).brake * (float)direction == -1.0f);
  }
}

/* Cyclic set-points end while the axis still lags them. */
static void test_an_axis_may_catch_up_with_its_set_point_when_a_stop_begins_but_not_pass_it(void) {
  bench b = new_bench();
  b.reference_rad_s = -0.6f;
  (void)turn(&b, -0.1, 20);
  b.phase = ENVELOPE_STOPPING;
  TEST_ASSERT_FALSE(turn(&b, -0.65, 200).stop_ignored);
  bench passes = b;
  TEST_ASSERT_TRUE(turn(&passes, -0.75, 20).stop_ignored);
  b.reference_rad_s = 0.0f;
  b.angle_rad = 0.0;
  TEST_ASSERT_FALSE(turn(&b, -0.65, 290).stop_ignored);
  TEST_ASSERT_TRUE(turn(&b, -0.65, 200).stop_ignored); /* half of 1 rad/s^2 since half a second after the beginning */
}

static void test_outside_the_axis_may_move_inwards_only(void) {
  bench b = new_bench();
  b.angle_rad = 3.05;
  TEST_ASSERT_FALSE(turn(&b, -0.05, 10).too_fast);
  b.angle_rad = 3.05;
  TEST_ASSERT_FALSE(turn(&b, 0.029, 10).too_fast); /* that is left to FAULT_BEYOND_TRAVEL */
  b.angle_rad = 3.05;
  TEST_ASSERT_TRUE(turn(&b, 0.031, 10).too_fast);
  CHECK_SAME("rad/s at the end", 0.0, fastest_rad_s(&b, 0.0f));
  CHECK_SAME("rad/s outside", 0.0, fastest_rad_s(&b, -1.0f));
}

static void test_slow_motion_is_limited_everywhere_and_has_no_ends(void) {
  bench b = new_bench();
  b.params.slow = true;
  b.angle_rad = 10.0;
  TEST_ASSERT_FALSE(turn(&b, 0.98 * (double)ENVELOPE_SLOW_RAD_S, 10).too_fast);
  TEST_ASSERT_TRUE(turn(&b, 1.02 * (double)ENVELOPE_SLOW_RAD_S, 10).too_fast);
  CHECK_SAME("rad/s anywhere", ENVELOPE_SLOW_RAD_S, fastest_rad_s(&b, 5.0f));
}

static void test_without_a_travel_only_slow_motion_is_limited(void) {
  bench b = new_bench();
  b.params.minimum_rad = b.params.maximum_rad = 0.0f;
  TEST_ASSERT_FALSE(turn(&b, 5.0, 10).too_fast);
}

static void test_acceleration_counts_before_the_rate_has_it(void) {
  bench b = new_bench();
  b.params.slow = true;
  double rate = 0.0;
  int ticks = 0;
  while (!turn(&b, rate, 1).too_fast && ticks < 100) {
    rate += 0.013; /* 13 rad/s^2 */
    ++ticks;
  }
  CHECK_AT_MOST("rad/s at the detection", (double)ENVELOPE_SLOW_RAD_S, rate);
}

static void test_an_axis_that_came_to_rest_without_power_is_not_braked(void) {
  bench b = new_bench();
  b.angle_rad = 2.9;
  b.phase = ENVELOPE_POWERLESS;
  b.powered = false;
  TEST_ASSERT_FALSE(turn(&b, 1.5, 6).too_fast); /* pushed by hand */
  b = new_bench();
  b.angle_rad = 0.0;
  (void)turn(&b, 1.5, 10);
  b.phase = ENVELOPE_POWERLESS; /* coasts since it had power */
  b.powered = false;
  b.angle_rad = 2.7;
  TEST_ASSERT_TRUE(turn(&b, 1.5, 6).too_fast);
  (void)turn(&b, 0.0, 6);
  b.angle_rad = 2.7;
  TEST_ASSERT_FALSE(turn(&b, 1.5, 6).too_fast);
  b = new_bench();
  (void)turn(&b, 1.5, 10);
  b.phase = ENVELOPE_UNTRUSTED;
  b.angle_rad = 2.7;
  TEST_ASSERT_FALSE(turn(&b, 1.5, 6).too_fast);
}

/* Outside of its travel an axis that coasts is braked, until it was slower than 20 mrad/s. */
static void test_an_axis_that_coasts_slowly_still_turns(void) {
  bench b = new_bench();
  b.angle_rad = 3.05;
  (void)turn(&b, 0.05, 10);
  b.phase = ENVELOPE_POWERLESS;
  b.powered = false;
  (void)turn(&b, 0.021, 10);
  TEST_ASSERT_TRUE(turn(&b, 0.05, 5).too_fast);
  (void)turn(&b, 0.019, 10);
  TEST_ASSERT_FALSE(turn(&b, 0.05, 5).too_fast);
}

static void test_without_an_angle_nothing_is_judged_until_five_ticks_are_known(void) {
  bench b = new_bench();
  b.angle_rad = 2.9;
  (void)turn(&b, 1.5, 10);
  b.angle_valid = false;
  TEST_ASSERT_FALSE(turn(&b, 1.5, 1).too_fast);
  b.angle_valid = true;
  TEST_ASSERT_FALSE(turn(&b, 1.5, 4).too_fast);
  TEST_ASSERT_TRUE(turn(&b, 1.5, 1).too_fast);
  b.angle_valid = b.powered = false; /* lost again; who cannot be trusted meanwhile no longer turns by the drive */
  (void)turn(&b, 1.5, 1);
  b.angle_valid = true;
  b.phase = ENVELOPE_UNTRUSTED;
  (void)turn(&b, 1.5, 2);
  b.phase = ENVELOPE_POWERLESS;
  TEST_ASSERT_FALSE(turn(&b, 1.5, 10).too_fast);
}

/* A ramp of 1 rad/s^2 with a gentle begin and end is followed; a rate that stays is not, nor one that grows. */
static void test_an_ordered_stop_must_slow_the_axis_down(void) {
  bench b = new_bench();
  b.params.minimum_rad = b.params.maximum_rad = 0.0f;
  (void)turn(&b, 1.4, 10);
  b.phase = ENVELOPE_STOPPING;
  for (double t = 0.0; t < 4.0; t += 0.001) {
    const double rate = t < 0.5 ? 1.4 : fmax(1.4 - (t - 0.5), 0.0);
    TEST_ASSERT_FALSE(turn(&b, rate, 1).stop_ignored);
  }
  for (int grows = 0; grows <= 1; ++grows) {
    bench c = new_bench();
    c.params.minimum_rad = c.params.maximum_rad = 0.0f;
    (void)turn(&c, 1.4, 10);
    c.phase = ENVELOPE_STOPPING;
    int ms = 0;
    while (ms < 5000 && !turn(&c, 1.4 + 0.005 * grows * ms, 1).stop_ignored) {
      ++ms;
    }
    CHECK_NEAR("ms", grows ? 22 : 700, ms, 8);
  }
}

/* The rate over two ticks is 1.525 rad/s in the first tick of a new rate: 0.125 rad/s more than at the beginning. */
static void test_an_overshoot_of_an_ordered_stop_is_seen_in_its_tick(void) {
  bench b = new_bench();
  b.params.minimum_rad = b.params.maximum_rad = 0.0f;
  (void)turn(&b, 1.4, 10);
  b.phase = ENVELOPE_STOPPING;
  TEST_ASSERT_FALSE(turn(&b, 1.4, 10).stop_ignored);
  TEST_ASSERT_TRUE(turn(&b, 1.65, 1).stop_ignored);
}

static void test_an_axis_that_coasts_without_an_ordered_stop_may_go_on(void) {
  bench b = new_bench();
  b.params.minimum_rad = b.params.maximum_rad = 0.0f;
  (void)turn(&b, 1.4, 10);
  b.phase = ENVELOPE_POWERLESS;
  b.powered = false;
  for (int tick = 0; tick < 2000; ++tick) {
    TEST_ASSERT_EQUAL_HEX(0, turn(&b, 1.4, 1).found);
  }
}

/* 605E = 0 and a motor that still turns: the drive is off, in fault. */
static void test_a_stop_lasts_while_the_axis_turns_without_power(void) {
  bench b = new_bench();
  b.params.minimum_rad = b.params.maximum_rad = 0.0f;
  (void)turn(&b, 1.4, 10);
  b.phase = ENVELOPE_STOPPING;
  (void)turn(&b, 1.4, 100);
  b.powered = false;
  b.phase = ENVELOPE_POWERLESS;
  TEST_ASSERT_FALSE(turn(&b, 1.4, 500).stop_ignored);
  TEST_ASSERT_TRUE(turn(&b, 1.4, 200).stop_ignored);
  b.phase = ENVELOPE_RUNNING; /* a new operation ends the stop */
  TEST_ASSERT_FALSE(turn(&b, 1.4, 1).stop_ignored);
}

/* 650 ticks of a stop that is not followed, of which 700 are too many. Whatever ends it, the next one begins anew. */
static void test_each_ordered_stop_begins_anew(void) {
  enum { OPERATION, BRAKES, NO_ANGLE, RELEASE, REST, ENDS };
  for (int how = 0; how < ENDS; ++how) {
    bench b = new_bench();
    b.params.minimum_rad = b.params.maximum_rad = 0.0f;
    (void)turn(&b, 1.4, 10);
    b.phase = ENVELOPE_STOPPING;
    TEST_ASSERT_FALSE(turn(&b, 1.4, 650).stop_ignored);
    b.phase = how == OPERATION ? ENVELOPE_RUNNING : how == BRAKES ? ENVELOPE_BRAKING : b.phase;
    b.angle_valid = how != NO_ANGLE;
    if (how == RELEASE) {
      envelope_release(&b.state);
    } else if (how == REST) { /* without power, before someone turns it again */
      b.phase = ENVELOPE_POWERLESS;
      b.powered = false;
      (void)turn(&b, 0.0, 6);
    }
    (void)turn(&b, 1.4, how == RELEASE ? 0 : 3);
    b.phase = ENVELOPE_STOPPING;
    b.powered = b.angle_valid = true;
    for (int tick = 0; tick < 650; ++tick) {
      TEST_ASSERT_EQUAL_HEX(0, turn(&b, 1.4, 1).found);
    }
    TEST_ASSERT_TRUE(turn(&b, 1.4, 100).stop_ignored);
  }
}

static void test_braking_that_does_not_slow_the_axis_down_fails_within_40_ms(void) {
  for (double acceleration = -1.9; acceleration < 10.0; acceleration += 1.9) {
    bench b = new_bench();
    (void)turn(&b, 1.0, 10);
    b.phase = ENVELOPE_BRAKING;
    double rate = 1.0;
    int ms = 0;
    while (ms < 1000 && !turn(&b, rate, 1).braking_fails) {
      rate += 0.001 * acceleration;
      ++ms;
    }
    CHECK_AT_MOST("ms", acceleration < -1.0 ? 700 : 40, ms);
  }
}

/* The rate must fall by 2 mrad/s in each tick, with a reserve of 30 ticks from the fifth tick on. */
static void test_braking_fails_30_ticks_after_it_has_its_current(void) {
  bench b = new_bench();
  (void)turn(&b, 1.0, 10);
  b.phase = ENVELOPE_BRAKING;
  TEST_ASSERT_EQUAL_HEX(0, turn(&b, 1.0, 5).found);
  for (int tick = 6; tick < 34; ++tick) {
    TEST_ASSERT_EQUAL_HEX(0, turn(&b, 1.001, 1).found);
  }
  TEST_ASSERT_EQUAL_HEX(ENVELOPE_BRAKING_FAILS, turn(&b, 1.001, 1).found);
}

static void brake_to_rest(bench *b) {
  b->phase = ENVELOPE_BRAKING;
  TEST_ASSERT_EQUAL_HEX(0, turn(b, 1.0, 1).found);
  for (double rate = 0.996; rate > 0.0; rate -= 0.004) {
    TEST_ASSERT_EQUAL_HEX(0, turn(b, rate, 1).found);
  }
  TEST_ASSERT_TRUE(turn(b, 0.0, 120).at_rest);
}

/* Neither its rest nor its rate is that of the first one. */
static void test_each_braking_begins_anew(void) {
  bench b = new_bench();
  (void)turn(&b, 1.0, 10);
  brake_to_rest(&b);
  b.phase = ENVELOPE_RUNNING;
  TEST_ASSERT_FALSE(turn(&b, 0.0, 10).at_rest);
  b.phase = ENVELOPE_BRAKING;
  TEST_ASSERT_FALSE(turn(&b, 0.0, 99).at_rest);
  TEST_ASSERT_TRUE(turn(&b, 0.0, 1).at_rest);
  b.phase = ENVELOPE_RUNNING;
  b.angle_rad = 0.0;
  TEST_ASSERT_EQUAL_HEX(0, turn(&b, 1.0, 10).found);
  brake_to_rest(&b);
  b.phase = ENVELOPE_STOPPING; /* the same after an ordered stop, and after a tick without an angle */
  b.angle_rad = 0.0;
  (void)turn(&b, 1.0, 10);
  brake_to_rest(&b);
  b.angle_valid = false;
  b.angle_rad = 0.0;
  TEST_ASSERT_FALSE(turn(&b, 1.0, 1).at_rest);
  b.angle_valid = true;
  (void)turn(&b, 1.0, 5);
  brake_to_rest(&b);
}

/* 5 mrad/s; slower is rest. */
static void test_a_braked_axis_that_creeps_is_not_at_rest(void) {
  bench b = new_bench();
  b.phase = ENVELOPE_BRAKING;
  TEST_ASSERT_FALSE(turn(&b, 0.0052, 300).at_rest);
  TEST_ASSERT_TRUE(turn(&b, 0.0048, 102).at_rest);
  TEST_ASSERT_FALSE(turn(&b, 0.0052, 2).at_rest); /* pushed away, it is not */
}

/* --- the limits of the header ------------------------------------------------------------------------------------- */

/* T v + (1.03 v)^2 / (2 a), with a of 4 rad/s^2. */
static double needed_rad(double rate_rad_s) { return 0.004 * rate_rad_s + 1.03 * 1.03 * rate_rad_s * rate_rad_s / 8.0; }

static void test_the_distance_to_the_end_must_be_that_of_the_header(void) {
  static const double rates_rad_s[] = {0.05, 0.3, 1.5};
  for (unsigned i = 0; i < sizeof rates_rad_s / sizeof rates_rad_s[0]; ++i) {
    for (int side = -1; side <= 1; side += 2) {
      for (int near = 0; near <= 1; ++near) {
        bench b = new_bench();
        const double rate = rates_rad_s[i];
        const double room = needed_rad(rate) * (near == 1 ? 0.998 : 1.002);
        b.angle_rad = side * (3.0 - room - 0.01 * rate); /* ten ticks before */
        TEST_ASSERT_EQUAL_HEX(near == 1 ? ENVELOPE_TOO_FAST : 0, turn(&b, side * rate, 10).found);
        CHECK_RELATIVE("allowed rad/s", rate, fastest_rad_s(&b, (float)needed_rad(rate)), 1e-4);
      }
    }
  }
}

/* Ticks of this acceleration from rest until slow motion is too fast: the rate of two ticks counts 3.5 ms ahead. */
static int ticks_to_slow_limit(double acceleration_rad_s2) {
  bench b = new_bench();
  b.params.slow = true;
  (void)turn(&b, 0.0, 10);
  int ticks = 1;
  while (ticks < 1000 && !turn(&b, 0.001 * acceleration_rad_s2 * ticks, 1).too_fast) {
    ++ticks;
  }
  return ticks;
}

static void test_acceleration_counts_three_and_a_half_ticks_ahead(void) {
  for (int side = -1; side <= 1; side += 2) { /* n - 0.5 + 3.5 ticks of it are more than 5 degrees per second */
    TEST_ASSERT_EQUAL(27, ticks_to_slow_limit(side * 3.0));
    TEST_ASSERT_EQUAL(27, ticks_to_slow_limit(side * 2.9137));
    TEST_ASSERT_EQUAL(28, ticks_to_slow_limit(side * 2.9));
  }
}

static void test_deceleration_does_not_count_ahead(void) {
  bench b = new_bench();
  b.params.slow = true;
  (void)turn(&b, 0.3, 10);
  TEST_ASSERT_TRUE(turn(&b, 0.1, 2).too_fast);
  TEST_ASSERT_TRUE(turn(&b, 0.088, 1).too_fast);
  TEST_ASSERT_TRUE(turn(&b, 0.088, 1).too_fast);
  TEST_ASSERT_FALSE(turn(&b, 0.086, 2).too_fast);
}

/* 0.1 rad/s more than at the beginning for half a second, then by half of 1 rad/s^2 less. */
static void test_an_ordered_stop_that_is_not_followed_is_seen_in_its_700th_tick(void) {
  bench b = new_bench();
  b.params.minimum_rad = b.params.maximum_rad = 0.0f;
  (void)turn(&b, -1.4, 10);
  b.phase = ENVELOPE_STOPPING;
  TEST_ASSERT_EQUAL_HEX(0, turn(&b, -1.4, 1).found);
  for (int tick = 2; tick < 700; ++tick) {
    TEST_ASSERT_EQUAL_HEX(0, turn(&b, -1.40025, 1).found);
  }
  TEST_ASSERT_EQUAL_HEX(ENVELOPE_STOP_IGNORED, turn(&b, -1.40025, 1).found);
}

static void test_a_stop_may_end_in_slow_motion_and_a_braking_in_its_soft_end(void) {
  bench b = new_bench();
  b.params.minimum_rad = b.params.maximum_rad = 0.0f;
  b.params.deceleration_rad_s2 = 4.0f; /* soft end below 0.08 rad/s */
  (void)turn(&b, 0.086, 10);
  b.phase = ENVELOPE_STOPPING;
  for (int tick = 0; tick < 3000; ++tick) {
    TEST_ASSERT_EQUAL_HEX(0, turn(&b, 0.086, 1).found);
  }
  TEST_ASSERT_EQUAL_HEX(ENVELOPE_STOP_IGNORED, turn(&b, 0.0885, 2).found);
  b.phase = ENVELOPE_BRAKING;
  for (int tick = 0; tick < 1000; ++tick) {
    TEST_ASSERT_EQUAL_HEX(0, turn(&b, 0.079, 1).found);
  }
  TEST_ASSERT_EQUAL_HEX(ENVELOPE_BRAKING_FAILS, turn(&b, 0.081, 2).found);
}

/* v / (a Ts) + (x - x0) / (a Ts Th), from where the rate was first below a Ts = 0.08 rad/s. */
static void test_the_braking_holds_with_a_spring_of_its_own(void) {
  for (int side = -1; side <= 1; side += 2) {
    bench b = new_bench();
    (void)turn(&b, side * 0.2, 10);
    b.phase = ENVELOPE_BRAKING;
    CHECK_SAME("share above the soft end", -side, turn(&b, side * 0.081, 3).brake);
    const float first = turn(&b, side * 0.06, 2).brake;
    CHECK_NEAR("share where it begins to hold", -side * 0.75, first, 0.02);
    const double held_rad = b.angle_rad;
    CHECK_NEAR("share while it creeps", -side * (0.5 + 0.0016 / 0.06 / 0.08), turn(&b, side * 0.04, 40).brake, 0.02);
    const double away_rad = b.angle_rad - held_rad;
    const outputs still = turn(&b, 0.0, 2);
    CHECK_NEAR("share of the spring alone", -away_rad / 0.06 / 0.08, still.brake, 0.02);
  }
}

static void test_braking_holds_and_ends_at_rest(void) {
  bench b = new_bench();
  (void)turn(&b, 1.0, 10);
  b.phase = ENVELOPE_BRAKING;
  CHECK_SAME("share", -1.0, turn(&b, 0.5, 4).brake);
  CHECK_NEAR("share", -0.5, turn(&b, 0.04, 3).brake, 0.05);
  TEST_ASSERT_EQUAL_HEX(0, turn(&b, 0.0, 1).found);
  TEST_ASSERT_FALSE(turn(&b, 0.0, 99).at_rest);
  TEST_ASSERT_TRUE(turn(&b, 0.0, 1).at_rest); /* the first tick of rest is the second one without motion */
  CHECK_NEAR("share", 0.25, turn(&b, -0.02, 3).brake, 0.05);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_no_adversary_passes_the_end_of_the_travel);
  RUN_TEST(test_the_stated_distances_are_those_of_the_shipped_machines);
  RUN_TEST(test_a_deceleration_that_the_machine_does_not_have_is_not_enough);
  RUN_TEST(test_both_ends_and_both_directions_are_alike);
  RUN_TEST(test_an_axis_may_catch_up_with_its_set_point_when_a_stop_begins_but_not_pass_it);
  RUN_TEST(test_outside_the_axis_may_move_inwards_only);
  RUN_TEST(test_slow_motion_is_limited_everywhere_and_has_no_ends);
  RUN_TEST(test_without_a_travel_only_slow_motion_is_limited);
  RUN_TEST(test_acceleration_counts_before_the_rate_has_it);
  RUN_TEST(test_an_axis_that_came_to_rest_without_power_is_not_braked);
  RUN_TEST(test_an_axis_that_coasts_slowly_still_turns);
  RUN_TEST(test_without_an_angle_nothing_is_judged_until_five_ticks_are_known);
  RUN_TEST(test_an_ordered_stop_must_slow_the_axis_down);
  RUN_TEST(test_an_overshoot_of_an_ordered_stop_is_seen_in_its_tick);
  RUN_TEST(test_an_axis_that_coasts_without_an_ordered_stop_may_go_on);
  RUN_TEST(test_a_stop_lasts_while_the_axis_turns_without_power);
  RUN_TEST(test_each_ordered_stop_begins_anew);
  RUN_TEST(test_braking_that_does_not_slow_the_axis_down_fails_within_40_ms);
  RUN_TEST(test_braking_fails_30_ticks_after_it_has_its_current);
  RUN_TEST(test_each_braking_begins_anew);
  RUN_TEST(test_a_braked_axis_that_creeps_is_not_at_rest);
  RUN_TEST(test_the_distance_to_the_end_must_be_that_of_the_header);
  RUN_TEST(test_acceleration_counts_three_and_a_half_ticks_ahead);
  RUN_TEST(test_deceleration_does_not_count_ahead);
  RUN_TEST(test_an_ordered_stop_that_is_not_followed_is_seen_in_its_700th_tick);
  RUN_TEST(test_a_stop_may_end_in_slow_motion_and_a_braking_in_its_soft_end);
  RUN_TEST(test_the_braking_holds_with_a_spring_of_its_own);
  RUN_TEST(test_braking_holds_and_ends_at_rest);
  return UNITY_END();
}
