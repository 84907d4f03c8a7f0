/* SPDX-License-Identifier: Apache-2.0 */
/* The delay of a camera, estimated from frames of a line of sight whose motion is known, all in double: white centroid
 * noise, a target that weaves, and a line of sight that shakes on its own or follows the noisy frames. */
#include "control/delay_estimator.h"

#include "support/check.h"
#include "support/random.h"

enum { FRAME_MS = 20, AGE_MS = 40, WINDOW_MS = 3, RING = 128 };

#define NOISE_RAD 2.3e-6

static delay_estimator estimator;

/* What was added since the last set-up, for the reference. */
enum { MAX_SAMPLES = 3000 };
static delay_sample added[MAX_SAMPLES];
static int added_count;

void setUp(void) {
  delay_estimator_reset(&estimator);
  added_count = 0;
}
void tearDown(void) {}

typedef struct {
  double shake_rad_s;  /* rms of the line of sight's own rate, about 5 Hz */
  double follow_per_s; /* how fast it follows the noisy frames */
  double error_s;      /* of the stated age */
  double assumed_s;    /* what is added to it */
  int seconds;
  int gap_at;       /* frame after which 10 are missing; 0: none */
  int jump_at;      /* frame at which the target jumps by 1 mrad; 0: never */
  double count_rad; /* to which errors are rounded; 0: not */
  uint64_t seed;
} flight;

/* Of one component. */
typedef struct {
  double inner;
  double rate_rad_s;
  double los_rad[RING]; /* at the last ms */
  double exposed_rad;   /* error in the frame that is not delivered yet */
  double arrived_rad;   /* error of the last frame, which the line of sight follows */
} component;

static double target_rad(double t_s, int i) { return 1e-3 * sin(0.4 * t_s + i) + 0.01 * t_s; }

static double los_at(const component *of, int ms) { return of->los_rad[(ms + RING) % RING]; }

/* Two first-order filters in series of white noise are the line of sight's own rate. */
static void turn(component *self, const flight *with, int ms, int i, random_source *random) {
  self->inner += 1e-3 * 30.0 * (0.0 - self->inner) + sqrt(2.0 * 30.0 * 1e-3) * random_normal(random);
  self->rate_rad_s += 1e-3 * 30.0 * (1.4 * with->shake_rad_s * self->inner - self->rate_rad_s);
  const double target_rad_s = 1e3 * (target_rad(1e-3 * (ms + 1), i) - target_rad(1e-3 * ms, i));
  const double rate_rad_s = self->rate_rad_s + target_rad_s + with->follow_per_s * self->arrived_rad;
  self->los_rad[(ms + 1) % RING] = los_at(self, ms) + 1e-3 * rate_rad_s;
}

/* The frame that was exposed AGE_MS ago arrives. The instant believed is later if it is older than stated. */
static void deliver(const component *of, const flight *with, int ms, int *last_ms) {
  const int believed_ms = ms - AGE_MS + (int)lround(1e3 * (with->error_s - with->assumed_s));
  const bool first = *last_ms == 0;
  const bool known = !first && ms - *last_ms < RING;
  image_vector vectors[3];
  for (int k = 0; k < 3; ++k) {
    float parts[2];
    for (int i = 0; i < 2; ++i) {
      parts[i] =
          (float)(k == 0   ? of[i].exposed_rad
                  : k == 1 ? (known ? los_at(&of[i], believed_ms) - los_at(&of[i], *last_ms) : 0.0)
                           : (los_at(&of[i], believed_ms + WINDOW_MS) - los_at(&of[i], believed_ms - WINDOW_MS)) /
                                 (2e-3 * WINDOW_MS));
    }
    vectors[k] = (image_vector){parts[0], parts[1]};
  }
  const delay_sample sample = {.error = vectors[0],
                               .moved = vectors[1],
                               .rate_rad_s = vectors[2],
                               .interval_s = first ? 0.02f : 1e-3f * (float)(believed_ms - *last_ms),
                               .assumed_s = (float)with->assumed_s,
                               .count_rad = (float)with->count_rad};
  delay_estimator_add(&estimator, &sample);
  if (added_count < MAX_SAMPLES) {
    added[added_count++] = sample;
  }
  *last_ms = believed_ms;
}

static void fly(const flight *with) {
  random_source random = {with->seed};
  component of[2] = {0};
  for (int i = 0; i < 2; ++i) {
    of[i].los_rad[0] = target_rad(0.0, i);
  }
  double seen_rad[2][4] = {{0.0}};
  int last_ms = 0;
  for (int ms = 0; ms < 1000 * with->seconds; ++ms) {
    const int frame = ms / FRAME_MS;
    if (ms % FRAME_MS == 0) {
      const double jump_rad = with->jump_at != 0 && frame >= with->jump_at ? 1e-3 : 0.0;
      for (int i = 0; i < 2; ++i) {
        const double noise_rad = NOISE_RAD * random_normal(&random);
        seen_rad[i][frame % 4] = target_rad(1e-3 * ms, i) + jump_rad - los_at(&of[i], ms) + noise_rad;
        if (with->count_rad > 0.0) {
          seen_rad[i][frame % 4] = with->count_rad * round(seen_rad[i][frame % 4] / with->count_rad);
        }
        of[i].exposed_rad = seen_rad[i][(frame + 2) % 4];
        of[i].arrived_rad = of[i].exposed_rad - jump_rad;
      }
      const bool missing = with->gap_at != 0 && frame > with->gap_at && frame <= with->gap_at + 10;
      if (frame > 3 && !missing) {
        deliver(of, with, ms, &last_ms);
      }
    }
    for (int i = 0; i < 2; ++i) {
      turn(&of[i], with, ms, i, &random);
    }
  }
}

/* Flies, and expects a result with an interval no wider than this and the error within twice the interval. */
static void check_found(const flight *with, double half_width_s) {
  fly(with);
  const delay_error found = delay_estimator_result(&estimator);
  TEST_ASSERT_TRUE(found.known);
  CHECK_NEAR("s", with->error_s, found.error_s, 2.0f * found.half_width_s);
  CHECK_AT_MOST("s", half_width_s, found.half_width_s);
}

static void add_still_frames(int count) {
  for (int i = 0; i < count; ++i) {
    delay_estimator_add(&estimator, &(delay_sample){.interval_s = 0.02f});
  }
}

static const flight kShaken = {.shake_rad_s = 35e-6, .follow_per_s = 3.0, .seconds = 60, .seed = 1};

static void test_nothing_is_known_without_frames(void) {
  TEST_ASSERT_FALSE(delay_estimator_result(&estimator).known);
  flight brief = kShaken;
  brief.seconds = 2;
  fly(&brief);
  TEST_ASSERT_FALSE(delay_estimator_result(&estimator).known);
}

static void test_finds_the_error_of_the_stated_age(void) {
  for (int ms = -4; ms <= 4; ms += 4) {
    flight with = kShaken;
    with.error_s = 1e-3 * ms;
    delay_estimator_reset(&estimator);
    check_found(&with, 3.4e-3);
  }
}

static void test_the_interval_holds_in_95_percent_of_flights_in_a_closed_loop(void) {
  int inside = 0;
  double sum_s = 0.0;
  const int flights = random_cases(200);
  for (int seed = 1; seed <= flights; ++seed) {
    flight with = kShaken;
    with.seconds = 20;
    with.seed = (uint64_t)seed;
    delay_estimator_reset(&estimator);
    fly(&with);
    const delay_error found = delay_estimator_result(&estimator);
    inside += found.known && fabsf(found.error_s) <= found.half_width_s ? 1 : 0;
    sum_s += (double)found.error_s;
  }
  CHECK_NEAR("mean, s", 0.0, sum_s / flights, flights < 200 ? 2e-3 : 0.4e-3);
  CHECK_AT_LEAST("share inside", flights < 200 ? 0.6 : 0.93, (double)inside / flights);
}

/* Four times the shake is four times the information. */
static void test_more_motion_makes_the_interval_narrower(void) {
  fly(&kShaken);
  const delay_error little = delay_estimator_result(&estimator);
  flight with = kShaken;
  with.shake_rad_s *= 4.0;
  delay_estimator_reset(&estimator);
  fly(&with);
  CHECK_NEAR("ratio", 4.0, little.half_width_s / delay_estimator_result(&estimator).half_width_s, 1.0);
}

static void test_a_gap_or_another_target_spoils_nothing(void) {
  flight with = kShaken;
  with.gap_at = 1000;
  with.jump_at = 2000;
  with.error_s = 4e-3;
  check_found(&with, 3.4e-3);
}

/* Another target within the first 50 frames that count, which begin after 2 s. Its jump in the sums would hide 300 s of
 * motion. */
static void test_another_target_among_the_first_frames_spoils_nothing(void) {
  for (int frame = 104; frame < 154; frame += 7) {
    flight with = kShaken;
    with.jump_at = frame;
    with.error_s = 4e-3;
    delay_estimator_reset(&estimator);
    check_found(&with, 3.6e-3);
  }
}

/* A jump of 1 mrad of one component, among 2 urad of noise. Then the limit itself: 100 frames of 10 urad, and a place
 * that has not moved so far. Of fewer than 50 frames the noise is not known. */
static void test_an_outlier_of_either_component_restarts_both(void) {
  for (int i = 0; i < DELAY_COMPONENTS; ++i) {
    setUp();
    fly(&kShaken);
    delay_sample sample = added[added_count - 1];
    *(i == 0 ? &sample.error.x : &sample.error.y) += 1e-3f;
    delay_estimator_add(&estimator, &sample);
    CHECK_SAME("running, s", 0.0, estimator.running_s);
    static const struct {
      float sigmas, weight;
      bool restarts;
    } rows[] = {{6.99f, 100.0f, false}, {-7.01f, 100.0f, true}, {7.01f, 100.0f, true}, {7.01f, 49.0f, false}};
    for (unsigned row = 0; row < 4; ++row) {
      setUp();
      add_still_frames(150);
      estimator.weight = rows[row].weight;
      estimator.component[0].sums.ee = estimator.component[1].sums.ee = rows[row].weight * 1e-10f;
      sample = (delay_sample){.interval_s = 0.02f};
      *(i == 0 ? &sample.error.x : &sample.error.y) = rows[row].sigmas * 1e-5f;
      delay_estimator_add(&estimator, &sample);
      TEST_ASSERT_EQUAL(rows[row].restarts, estimator.running_s == 0.0f);
    }
  }
}

static void test_forgetting_keeps_the_predictors(void) {
  fly(&kShaken);
  delay_estimator_forget(&estimator);
  TEST_ASSERT_FALSE(delay_estimator_result(&estimator).known);
  TEST_ASSERT_TRUE(estimator.running_s > DELAY_SETTLE_S);
}

static void test_a_sample_that_is_not_finite_restarts(void) {
  fly(&kShaken);
  const delay_error before = delay_estimator_result(&estimator);
  delay_estimator_add(&estimator, &(delay_sample){.error = {.x = NAN}, .interval_s = 0.02f});
  TEST_ASSERT_TRUE(estimator.running_s == 0.0f);
  delay_estimator_add(&estimator, &(delay_sample){.interval_s = 10.0f});
  delay_estimator_add(&estimator, &(delay_sample){.interval_s = 0.02f, .assumed_s = INFINITY});
  const delay_error after = delay_estimator_result(&estimator);
  TEST_ASSERT_EQUAL_FLOAT(before.error_s, after.error_s);
  TEST_ASSERT_TRUE(estimator.running_s == 0.0f);
}

/* Without noise and motion there is no information, and no division by zero. */
static void test_a_line_of_sight_at_rest_gives_no_result(void) {
  for (int i = 0; i < 1000; ++i) {
    delay_estimator_add(&estimator, &(delay_sample){.interval_s = 0.02f});
  }
  TEST_ASSERT_FALSE(delay_estimator_result(&estimator).known);
  flight with = kShaken;
  with.shake_rad_s = 0.0;
  with.follow_per_s = 0.0;
  fly(&with);
  const delay_error found = delay_estimator_result(&estimator);
  TEST_ASSERT_FALSE(found.known && found.half_width_s < 0.1f);
}

/* Within a count of 100 urad the target seems to stand in the picture, whatever the line of sight does. */
static void test_a_camera_that_rounds_the_motion_away_says_nothing(void) {
  static const struct {
    double count_rad;
    bool known;
  } rows[] = {{1e-6, true}, {3e-6, true}, {3e-5, false}, {1e-4, false}};
  for (unsigned row = 0; row < 4; ++row) {
    for (uint64_t seed = 1; seed <= 5; ++seed) {
      delay_estimator_reset(&estimator);
      flight with = kShaken;
      with.count_rad = rows[row].count_rad;
      with.seed = seed;
      fly(&with);
      const delay_error found = delay_estimator_result(&estimator);
      TEST_ASSERT_EQUAL(rows[row].known, found.known);
    }
  }
}

/* --- against a second computation in double ----------------------------------------------------------------------- */

/* Prediction error of an alpha-beta-gamma filter whose alpha is off by `alpha_error`; of the place, or of the rate. */
typedef struct {
  double value, slope, curvature, slow, slow_of_rest;
} double_filter;

static double unpredicted(double_filter *f, double measured, double dt_s, double running_s, double alpha_error) {
  const double pole = exp(-fmax(3.5, 6.0 / running_s) * dt_s);
  const double gap = 1.0 - pole;
  const double alpha = fmax(1.0 - pow(pole, 3.0), 1.0 - exp(-14.0 * dt_s)) + alpha_error;
  f->value += f->slope * dt_s + 0.5 * f->curvature * dt_s * dt_s;
  f->slope += f->curvature * dt_s;
  const double residual = measured - f->value;
  f->value += alpha * residual;
  f->slope += 1.5 * gap * gap * (1.0 + pole) / dt_s * residual;
  f->curvature += gap * gap * gap / (dt_s * dt_s) * residual;
  return residual;
}

static double without_slow(double_filter *f, double value, double dt_s) {
  const double share = 1.0 - exp(-10.0 * dt_s); /* 10 rad/s, twice */
  const double rest = value - f->slow;
  f->slow += share * rest;
  const double fast = rest - f->slow_of_rest;
  f->slow_of_rest += share * fast;
  return fast;
}

static double part(const image_vector *of, int i) { return (double)(i == 0 ? of->x : of->y); }

/* Weighted sums of the frames from `first` on; those before it move the filters only. */
typedef struct {
  double weight, weight_of_squares, ee, er, ea, rr, ra, aa, ee_before, er_before, rr_before;
} double_sums;

static void accumulate(double_sums *sums, double keep, const double now[3], const double before[2]) {
  const double e = now[0], r = now[1], a = now[2];
  sums->weight = keep * sums->weight + 1.0;
  sums->weight_of_squares = keep * keep * sums->weight_of_squares + 1.0;
  sums->ee = keep * sums->ee + e * e;
  sums->er = keep * sums->er + e * r;
  sums->ea = keep * sums->ea + e * a;
  sums->rr = keep * sums->rr + r * r;
  sums->ra = keep * sums->ra + r * a;
  sums->aa = keep * sums->aa + a * a;
  sums->ee_before = keep * sums->ee_before + e * before[0];
  sums->er_before = keep * sums->er_before + e * before[1] + r * before[0];
  sums->rr_before = keep * sums->rr_before + r * before[1];
}

/* The derivative with respect to alpha by central difference. */
static double_sums sums_of(int i, int first) {
  const double step = 1e-5;
  double_filter place[3] = {{0}};
  double_filter rate = {0};
  double_filter derivative = {0};
  double_sums sums = {0};
  double before[2] = {0.0, 0.0};
  float running_s = 0.0f; /* as the estimator counts it: a frame at the end of the first 2 s may count or not */
  for (int k = 0; k < added_count; ++k) {
    const double dt_s = (double)added[k].interval_s;
    const double error = part(&added[k].error, i);
    const double measured_rate = part(&added[k].rate_rad_s, i);
    running_s += added[k].interval_s;
    if (k == 0) {
      for (int c = 0; c < 3; ++c) {
        place[c] = (double_filter){.value = error, .slope = measured_rate};
      }
      rate.value = measured_rate;
      continue;
    }
    double found[3];
    for (int c = 0; c < 3; ++c) {
      place[c].value -= part(&added[k].moved, i);
      found[c] = unpredicted(&place[c], error, dt_s, (double)running_s, (c - 1) * step);
    }
    const double r = without_slow(&rate, unpredicted(&rate, measured_rate, dt_s, (double)running_s, 0.0), dt_s);
    const double e = without_slow(&place[1], found[1], dt_s) + (double)added[k].assumed_s * r;
    const double a = without_slow(&derivative, (found[2] - found[0]) / (2.0 * step), dt_s);
    if (running_s < 2.0f) {
      continue;
    }
    if (k >= first) {
      accumulate(&sums, 1.0 - dt_s / 300.0, (const double[]){e, r, a}, before);
    }
    before[0] = e;
    before[1] = r;
  }
  return sums;
}

static void expect_sums(const double_sums *expected, const delay_sums *sums) {
  const double e = sqrt(expected->ee), r = sqrt(expected->rr), a = sqrt(expected->aa);
  CHECK_NEAR("ee", expected->ee, sums->ee, 1e-3 * e * e);
  CHECK_NEAR("er", expected->er, sums->er, 1e-3 * e * r);
  CHECK_NEAR("ea", expected->ea, sums->ea, 1e-3 * e * a);
  CHECK_NEAR("rr", expected->rr, sums->rr, 1e-3 * r * r);
  CHECK_NEAR("ra", expected->ra, sums->ra, 1e-3 * r * a);
  CHECK_NEAR("aa", expected->aa, sums->aa, 1e-3 * a * a);
  CHECK_NEAR("ee, of two frames", expected->ee_before, sums->ee_before, 1e-3 * e * e);
  CHECK_NEAR("er, of two frames", expected->er_before, sums->er_before, 1e-3 * e * r);
  CHECK_NEAR("rr, of two frames", expected->rr_before, sums->rr_before, 1e-3 * r * r);
}

/* Normal equations of error = delay * rate + k * d(error)/d(alpha). */
typedef struct {
  double information, said;
} double_estimate;

static double_estimate estimate_of(const double_sums *s) {
  const double determinant = s->rr * s->aa - s->ra * s->ra;
  const double delay = (s->er * s->aa - s->ea * s->ra) / determinant;
  const double k = (s->ea * s->rr - s->er * s->ra) / determinant;
  const double variance = (s->ee - delay * s->er - k * s->ea) / s->weight;
  return (double_estimate){.information = determinant / s->aa / variance,
                           .said = delay * determinant / s->aa / variance};
}

/* What the estimator says of the frames from `first` on. */
static void expect_result_of_frames(int first) {
  double information = 0.0, said = 0.0;
  double_sums sums = {0};
  for (int i = 0; i < 2; ++i) {
    sums = sums_of(i, first);
    expect_sums(&sums, &estimator.component[i].sums);
    const double_estimate one = estimate_of(&sums);
    information += one.information;
    said += one.said;
  }
  CHECK_RELATIVE("weight of the frames", sums.weight, estimator.weight, 1e-4);
  CHECK_RELATIVE("sum of squared weights", sums.weight_of_squares, estimator.weight_of_squares, 1e-4);
  const delay_error found = delay_estimator_result(&estimator);
  TEST_ASSERT_TRUE(found.known);
  const double half_width_s = 1.4 * 1.96 * sqrt(sums.weight_of_squares / (sums.weight * information));
  CHECK_NEAR("error, s", said / information, found.error_s, 2e-3 * half_width_s);
  CHECK_RELATIVE("half width, s", half_width_s, found.half_width_s, 1e-3);
}

static void test_the_result_is_that_of_the_normal_equations_in_double(void) {
  if (random_cases(1) == 0) {
    return; /* an emulated core computes double in software */
  }
  const int seconds[] = {4, 20, 60};
  for (int flown = 0; flown < 3; ++flown) {
    setUp();
    flight with = kShaken;
    with.seconds = seconds[flown];
    with.error_s = 3e-3;
    with.assumed_s = flown == 1 ? 2e-3 : 0.0;
    fly(&with);
    expect_result_of_frames(0);
  }
}

/* The first 2 s are not believed, and 50 frames are the fewest: each counts a little less than 1 when it is older. The
 * frames before do not count. */
static void test_a_result_needs_fifty_frames_after_the_first_two_seconds(void) {
  flight with = kShaken;
  with.seconds = 10;
  fly(&with);
  delay_estimator_forget(&estimator);
  const int flown = added_count;
  for (; added_count < flown + 51; ++added_count) {
    TEST_ASSERT_FALSE(delay_estimator_result(&estimator).known);
    added[added_count] = added[added_count - 51];
    delay_estimator_add(&estimator, &added[added_count]);
  }
  TEST_ASSERT_TRUE(delay_estimator_result(&estimator).known);
  if (random_cases(1) > 0) { /* an emulated core computes double in software */
    expect_result_of_frames(flown);
  }
}

/* A target at rest, seen 50 mrad and -30 mrad beside a line of sight that turns: the first frame tells its place, and
 * nothing is left to be found in the next one. What the line of sight has moved before the first one has no part. */
static void test_the_first_frame_after_a_restart_is_known_as_it_is(void) {
  for (int again = 0; again < 2; ++again) {
    delay_estimator_add(
        &estimator,
        &(delay_sample){
            .error = {0.05f, -0.03f}, .moved = {0.01f, 0.02f}, .rate_rad_s = {0.2f, -0.1f}, .interval_s = 0.02f});
    delay_estimator_add(
        &estimator,
        &(delay_sample){
            .error = {0.05f, -0.03f}, .moved = {0.004f, -0.002f}, .rate_rad_s = {0.2f, -0.1f}, .interval_s = 0.02f});
    const delay_component *c = estimator.component;
    CHECK_NEAR("x, rad", 0.05, c[0].place.value, 1e-8);
    CHECK_NEAR("y, rad", -0.03, c[1].place.value, 1e-8);
    CHECK_NEAR("x, rad/s", 0.2, c[0].place.rate, 1e-6);
    CHECK_NEAR("y, rad/s", -0.1, c[1].place.rate, 1e-6);
    CHECK_SAME("x, rad/s, of the line of sight", 0.2f, c[0].rate.value);
    CHECK_SAME("y, rad/s, of the line of sight", -0.1f, c[1].rate.value);
    fly(&kShaken);
    delay_estimator_restart(&estimator);
  }
}

static void test_a_restart_forgets_both_predictors(void) {
  fly(&kShaken);
  delay_estimator_restart(&estimator);
  for (int i = 0; i < DELAY_COMPONENTS; ++i) {
    const delay_component *c = &estimator.component[i];
    const delay_predictor *predictors[] = {&c->place, &c->rate, &c->alpha};
    for (int k = 0; k < 3; ++k) {
      CHECK_SAME("value", 0.0, predictors[k]->value);
      CHECK_SAME("rate", 0.0, predictors[k]->rate);
      CHECK_SAME("acceleration", 0.0, predictors[k]->acceleration);
      CHECK_SAME("slow part", 0.0, c->slow[k].first);
      CHECK_SAME("slow part of the rest", 0.0, c->slow[k].second);
    }
    CHECK_SAME("residual before", 0.0, c->e_before);
    CHECK_SAME("rate before", 0.0, c->r_before);
    CHECK_AT_LEAST("sum of squares", 1e-12, c->sums.ee);
  }
}

/* Before the predictors have settled nothing else would notice it. */
static void test_each_part_of_a_sample_is_looked_at(void) {
  const float bad[] = {NAN, INFINITY, -101.0f, 101.0f};
  for (int b = 0; b < 4; ++b) {
    for (int i = 0; i < 7; ++i) {
      delay_estimator_reset(&estimator);
      add_still_frames(3);
      TEST_ASSERT_TRUE(estimator.running_s > 0.0f);
      delay_sample sample = {.interval_s = 0.02f};
      float *const parts[] = {&sample.error.x,      &sample.error.y,      &sample.moved.x,  &sample.moved.y,
                              &sample.rate_rad_s.x, &sample.rate_rad_s.y, &sample.assumed_s};
      *parts[i] = bad[b];
      delay_estimator_add(&estimator, &sample);
      CHECK_SAME("running, s", 0.0, estimator.running_s);
    }
  }
  const float intervals_s[] = {0.0f, -0.02f, 0.151f, NAN};
  for (int i = 0; i < 4; ++i) {
    delay_estimator_reset(&estimator);
    add_still_frames(3);
    delay_estimator_add(&estimator, &(delay_sample){.interval_s = intervals_s[i]});
    CHECK_SAME("running, s", 0.0, estimator.running_s);
  }
}

/* Sums as frames leave them with next to no information: 1.96 * 1.4 / sqrt(information) s. */
static void test_an_interval_of_seconds_is_no_result(void) {
  estimator.weight = estimator.weight_of_squares = 100.0f;
  estimator.component[0].sums = (delay_sums){.ee = 1.0f, .rr = 0.006f, .aa = 1.0f}; /* information 0.6 */
  TEST_ASSERT_FALSE(delay_estimator_result(&estimator).known);
  estimator.component[0].sums.rr = 0.04f;
  const delay_error found = delay_estimator_result(&estimator);
  TEST_ASSERT_TRUE(found.known);
  estimator.component[0].sums.ee = 0.0f; /* frames without noise do not exist */
  TEST_ASSERT_FALSE(delay_estimator_result(&estimator).known);
  CHECK_RELATIVE("half width, s", 1.4 * 1.96 / 2.0 / sqrt(1.0), found.half_width_s, 1e-5);
}

/* Rounding can make what is left of the residuals negative: such a component says nothing, the other one decides. */
static void test_a_component_with_less_than_no_noise_does_not_count(void) {
  estimator.weight = estimator.weight_of_squares = 100.0f;
  estimator.component[0].sums = (delay_sums){.ee = 1.0f, .er = 0.02f, .rr = 0.04f, .aa = 1.0f};
  const delay_error one = delay_estimator_result(&estimator);
  TEST_ASSERT_TRUE(one.known);
  estimator.component[1].sums = (delay_sums){.ee = 1.0f, .er = 1.1f, .rr = 1.0f, .aa = 1.0f};
  const delay_error both = delay_estimator_result(&estimator);
  TEST_ASSERT_TRUE(both.known);
  CHECK_SAME("error, s", one.error_s, both.error_s);
  CHECK_SAME("half width, s", one.half_width_s, both.half_width_s);
}

/* Per frame, residuals of 1 rad^2, of which a delay of er / rr explains er^2 / rr. Where more than 5 % are left, they
 * must not resemble those of the frame before by more than 60 %. */
static void test_residuals_that_resemble_the_ones_before_are_a_target_that_weaves(void) {
  static const struct {
    float er, ee_before, er_before, rr_before;
    bool known;
  } rows[] = {
      {0.0f, 0.59f, 0.0f, 0.0f, true},    {0.0f, 0.61f, 0.0f, 0.0f, false},
      {0.1f, 0.8f, 0.145f, 0.0f, true},   {0.1f, 0.8f, 0.135f, 0.0f, false}, /* 2.5 s leave 0.75 */
      {0.1f, 0.3f, 0.0f, 0.023f, true},   {0.1f, 0.3f, 0.0f, 0.025f, false},
      {-0.1f, 0.8f, -0.145f, 0.0f, true}, {-0.1f, 0.8f, 0.145f, 0.0f, false},
      {0.1962f, 1.0f, 0.0f, 0.0f, true},  {0.1938f, 1.0f, 0.0f, 0.0f, false}, /* what is left is little: 4 % and 6 % */
  };
  for (unsigned row = 0; row < sizeof rows / sizeof rows[0]; ++row) {
    for (int i = 0; i < DELAY_COMPONENTS; ++i) {
      setUp();
      estimator.weight = estimator.weight_of_squares = 100.0f;
      estimator.component[i].sums = (delay_sums){.ee = 1.0f,
                                                 .er = rows[row].er,
                                                 .rr = 0.04f,
                                                 .aa = 1.0f,
                                                 .ee_before = rows[row].ee_before,
                                                 .er_before = rows[row].er_before,
                                                 .rr_before = rows[row].rr_before};
      TEST_ASSERT_EQUAL(rows[row].known, delay_estimator_result(&estimator).known);
    }
  }
}

/* Frames every 1/8 s, exactly: the 16th ends the first 2 s, and counts. */
static void test_frames_count_from_two_seconds_on(void) {
  for (int i = 1; i <= 17; ++i) {
    delay_estimator_add(&estimator, &(delay_sample){.interval_s = 0.125f});
    CHECK_NEAR("weight of the frames", i < 16 ? 0.0 : i - 15, estimator.weight, 1e-3);
  }
}

/* 10 mrad/s^2 with the line of sight at rest: the rate of the target in the last frame is known, not that of a frame
 * before or after it. */
static void test_the_rate_of_a_target_that_accelerates_is_that_of_the_last_frame(void) {
  double t_s = 0.0;
  for (int i = 0; i < 500; ++i) {
    t_s = 0.02 * i;
    delay_estimator_add(&estimator, &(delay_sample){.error = {.x = (float)(0.005 * t_s * t_s)}, .interval_s = 0.02f});
  }
  CHECK_NEAR("rad", 0.005 * t_s * t_s, estimator.component[0].place.value, 1e-6);
  CHECK_NEAR("rad/s", 0.01 * t_s, estimator.component[0].place.rate, 2e-5);
  CHECK_NEAR("rad/s^2", 0.01, estimator.component[0].place.acceleration, 1e-4);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_camera_that_rounds_the_motion_away_says_nothing);
  RUN_TEST(test_nothing_is_known_without_frames);
  RUN_TEST(test_finds_the_error_of_the_stated_age);
  RUN_TEST(test_the_interval_holds_in_95_percent_of_flights_in_a_closed_loop);
  RUN_TEST(test_more_motion_makes_the_interval_narrower);
  RUN_TEST(test_a_gap_or_another_target_spoils_nothing);
  RUN_TEST(test_another_target_among_the_first_frames_spoils_nothing);
  RUN_TEST(test_an_outlier_of_either_component_restarts_both);
  RUN_TEST(test_forgetting_keeps_the_predictors);
  RUN_TEST(test_a_sample_that_is_not_finite_restarts);
  RUN_TEST(test_a_line_of_sight_at_rest_gives_no_result);
  RUN_TEST(test_the_result_is_that_of_the_normal_equations_in_double);
  RUN_TEST(test_a_result_needs_fifty_frames_after_the_first_two_seconds);
  RUN_TEST(test_the_first_frame_after_a_restart_is_known_as_it_is);
  RUN_TEST(test_a_restart_forgets_both_predictors);
  RUN_TEST(test_each_part_of_a_sample_is_looked_at);
  RUN_TEST(test_an_interval_of_seconds_is_no_result);
  RUN_TEST(test_a_component_with_less_than_no_noise_does_not_count);
  RUN_TEST(test_residuals_that_resemble_the_ones_before_are_a_target_that_weaves);
  RUN_TEST(test_frames_count_from_two_seconds_on);
  RUN_TEST(test_the_rate_of_a_target_that_accelerates_is_that_of_the_last_frame);
  return UNITY_END();
}
