/* The delay of a camera, estimated from frames of a line of sight whose motion is known, all in double: white centroid
 * noise, a target that weaves, and a line of sight that shakes on its own or follows the noisy frames. */
#include "control/delay_estimator.h"

#include "support/check.h"
#include "support/random.h"

enum { FRAME_MS = 20, AGE_MS = 40, WINDOW_MS = 3, RING = 128 };

#define NOISE_RAD 2.3e-6

static delay_estimator estimator;

void setUp(void) { delay_estimator_reset(&estimator); }
void tearDown(void) {}

typedef struct {
  double shake_rad_s;  /* rms of the line of sight's own rate, about 5 Hz */
  double follow_per_s; /* how fast it follows the noisy frames */
  double error_s;      /* of the stated age */
  int seconds;
  int gap_at;  /* frame after which 10 are missing; 0: none */
  int jump_at; /* frame at which the target jumps by 1 mrad; 0: never */
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
  const int believed_ms = ms - AGE_MS + (int)lround(1e3 * with->error_s);
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
  delay_estimator_add(&estimator,
                      &(delay_sample){.error = vectors[0],
                                      .moved = vectors[1],
                                      .rate_rad_s = vectors[2],
                                      .interval_s = first ? 0.02f : 1e-3f * (float)(believed_ms - *last_ms)});
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
    fly(&with);
    const delay_error found = delay_estimator_result(&estimator);
    TEST_ASSERT_TRUE(found.known);
    CHECK_NEAR("s", with.error_s, found.error_s, 2.0f * found.half_width_s);
    CHECK_AT_MOST("s", 3e-3, found.half_width_s);
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
  fly(&with);
  const delay_error found = delay_estimator_result(&estimator);
  TEST_ASSERT_TRUE(found.known);
  CHECK_NEAR("s", with.error_s, found.error_s, 2.0f * found.half_width_s);
  CHECK_AT_MOST("s", 3e-3, found.half_width_s);
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

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_nothing_is_known_without_frames);
  RUN_TEST(test_finds_the_error_of_the_stated_age);
  RUN_TEST(test_the_interval_holds_in_95_percent_of_flights_in_a_closed_loop);
  RUN_TEST(test_more_motion_makes_the_interval_narrower);
  RUN_TEST(test_a_gap_or_another_target_spoils_nothing);
  RUN_TEST(test_forgetting_keeps_the_predictors);
  RUN_TEST(test_a_sample_that_is_not_finite_restarts);
  RUN_TEST(test_a_line_of_sight_at_rest_gives_no_result);
  return UNITY_END();
}
