/* The servo axis as the drive uses it: torque mode, limits and torque offset from outside, on a bare inertia. */
#include "app/servo_axis.h"

#include "drive/drive_axis.h"
#include "support/check.h"
#include "support/seals.h"

void setUp(void) {}
void tearDown(void) {}

static const float dt_s = 1e-3f;
static const double inertia_kg_m2 = 20.0;

typedef struct {
  servo_axis_params params;
  servo_axis axis;
  servo_axis_command command;
  servo_axis_samples samples;
  double rate_rad_s;
  double turns;
  double load_nm;
  double worst_step_nm; /* of the torque from tick to tick */
} bench;

static bench bench_at_rest(void) {
  bench b = {
      .params = {.speed = {.rate_estimator = {.window_ticks = 2},
                           .rate_fusion = {.source = RATE_FROM_ENCODER, .crossover_rad_s = 60.0f},
                           .notch = biquad_pass(),
                           .lowpass = biquad_pass(),
                           .pi = {.proportional_gain = 1200.0f,
                                  .integral_gain = 14000.0f,
                                  .setpoint_weight = 1.0f,
                                  .tracking_rate_per_s = 100.0f},
                           .acceleration_inertia_kg_m2 = 20.0f,
                           .observer_on = true,
                           .observer = {.inertia_kg_m2 = 20.0f, .bandwidth_rad_s = 60.0f, .limit_nm = 100.0f},
                           .friction = {.model = FRICTION_LUGRE,
                                        .gain = 0.0f,
                                        .lead_limit_rad_s = 0.05f,
                                        .sign_width_rad_s = 1e-3f,
                                        .lugre = stiff_seal()}},
                 .position = {.proportional_per_s = 10.0f, .rate_limit_rad_s = 1.0f, .deceleration_rad_s2 = 1.0f},
                 .torque_constant_nm_a = 2.5f,
                 .current_limit_a = 20.0f}};
  servo_axis_reset(&b.axis, &b.params, 0u, dt_s);
  return b;
}

static void tick(bench *b) {
  const float before_nm = b->axis.commanded_nm;
  const double turns = b->turns - floor(b->turns);
  b->samples.motion.joint_angle = (angle_turn32)(uint64_t)(turns * 4294967296.0);
  servo_axis_tick(&b->axis, &b->params, &b->command, &b->samples, dt_s);
  b->worst_step_nm = fmax(b->worst_step_nm, fabs((double)b->axis.commanded_nm - (double)before_nm));
  const double acceleration = ((double)b->axis.commanded_nm - b->load_nm) / inertia_kg_m2;
  b->turns += (b->rate_rad_s * 1e-3 + 0.5e-6 * acceleration) / 6.283185307179586;
  b->rate_rad_s += acceleration * 1e-3;
  b->samples.mean_current_a = b->axis.commanded_nm / b->params.torque_constant_nm_a;
}

static void ticks(bench *b, int count) {
  for (int i = 0; i < count; ++i) {
    tick(b);
  }
}

static void test_torque_mode_gives_exactly_the_torque_asked_for_within_the_limits(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command){.mode = SERVO_TORQUE, .torque_nm = 3.0f};
  ticks(&b, 100);
  CHECK_SAME("torque, Nm", 3.0, b.axis.commanded_nm);
  CHECK_NEAR("rate, rad/s", 3.0 / 20.0 * 0.1, b.rate_rad_s, 1e-6);
  TEST_ASSERT_FALSE(b.axis.signals.torque.limited);
  b.command.torque_nm = -80.0f;
  tick(&b);
  CHECK_SAME("at the current limit, Nm", -50.0, b.axis.commanded_nm);
  TEST_ASSERT_TRUE(b.axis.signals.torque.limited);
  b.command.torque_limited = true;
  b.command.limits = (torque_limits){-7.0f, 9.0f};
  tick(&b);
  CHECK_SAME("at the limit from outside, Nm", -7.0, b.axis.commanded_nm);
  b.command.limits = (torque_limits){5.0f, -5.0f}; /* nonsense: no torque at all, not a reversed one */
  tick(&b);
  CHECK_SAME("torque, Nm", 0.0, b.axis.commanded_nm);
}

static void test_a_speed_loop_takes_over_from_torque_mode_without_a_step(void) {
  bench b = bench_at_rest();
  b.load_nm = 6.0;
  b.rate_rad_s = 0.2;
  b.command = (servo_axis_command){.mode = SERVO_TORQUE, .torque_nm = 6.0f};
  ticks(&b, 500);
  CHECK_NEAR("rate, rad/s", 0.2, b.rate_rad_s, 1e-6);
  b.worst_step_nm = 0.0;
  b.command.mode = SERVO_SPEED;
  b.command.torque_nm = 0.0f;
  b.command.speed.rate_rad_s = b.axis.signals.rates.rate_rad_s;
  ticks(&b, 200);
  LOG_VALUE("largest step of the torque, Nm of 6", b.worst_step_nm);
  CHECK_AT_MOST("largest step of the torque, Nm", 0.05, b.worst_step_nm);
  CHECK_NEAR("torque, Nm", 6.0, b.axis.commanded_nm, 0.05);
}

static void test_speed_and_position_loops_keep_the_torque_limits_from_outside(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command){
      .mode = SERVO_SPEED, .speed = {.rate_rad_s = 0.5f}, .torque_limited = true, .limits = {-2.0f, 4.0f}};
  ticks(&b, 300);
  CHECK_SAME("torque, Nm", 4.0, b.axis.commanded_nm);
  TEST_ASSERT_TRUE(b.axis.signals.torque.limited);
  b.command.mode = SERVO_POSITION;
  b.command.position = (angle_turn32)-200000000;
  b.command.speed.rate_rad_s = 0.0f;
  ticks(&b, 50);
  CHECK_SAME("torque, Nm", -2.0, b.axis.commanded_nm);
}

static void test_a_torque_offset_carries_a_load_and_is_counted_once(void) {
  bench b = bench_at_rest();
  b.load_nm = 8.0;
  b.command = (servo_axis_command){.mode = SERVO_SPEED, .torque_nm = 8.0f};
  double worst_rad_s = 0.0;
  for (int i = 0; i < 1000; ++i) {
    tick(&b);
    worst_rad_s = fmax(worst_rad_s, fabs(b.rate_rad_s));
  }
  LOG_VALUE("largest rate with the load fed forward, rad/s", worst_rad_s);
  CHECK_AT_MOST("rate, rad/s", 1e-5, worst_rad_s);
  CHECK_NEAR("torque, Nm", 8.0, b.axis.commanded_nm, 0.01);
  CHECK_NEAR("load that the observer still sees, Nm", 0.0, b.axis.signals.torque.disturbance_nm, 0.01);
}

static void test_position_mode_passes_the_acceleration_on(void) {
  bench b = bench_at_rest();
  b.command = (servo_axis_command){.mode = SERVO_POSITION, .speed = {.acceleration_rad_s2 = 0.1f}};
  tick(&b);
  CHECK_NEAR("torque of the acceleration, Nm", 2.0, b.axis.signals.torque.acceleration_nm, 1e-6);
}

static void test_a_torque_or_limit_that_is_not_finite_switches_the_axis_off(void) {
  const servo_axis_command bad[] = {
      {.mode = SERVO_TORQUE, .torque_nm = NAN},
      {.mode = SERVO_SPEED, .torque_limited = true, .limits = {-1.0f, INFINITY}},
      {.mode = SERVO_SPEED, .torque_limited = true, .limits = {NAN, 1.0f}},
  };
  for (int i = 0; i < 3; ++i) {
    bench b = bench_at_rest();
    b.command = (servo_axis_command){.mode = SERVO_TORQUE, .torque_nm = 1.0f};
    ticks(&b, 10);
    b.command = bad[i];
    tick(&b);
    TEST_ASSERT_EQUAL_INT(SERVO_OFF, b.axis.mode);
    CHECK_SAME("torque", 0.0, b.axis.commanded_nm);
  }
}

/* --- drive and servo axis together, as the node wires them --- */

typedef struct {
  bench b;
  drive_axis drive;
  drive_objects o;
  drive_axis_inputs in;
} node;

static void node_tick(node *n) {
  n->b.samples.motion.joint_angle = (angle_turn32)(uint64_t)((n->b.turns - floor(n->b.turns)) * 4294967296.0);
  drive_axis_sense(&n->in, &n->b.axis, &n->b.params, &n->b.samples);
  n->b.command = drive_axis_step(&n->drive, &n->o, &n->in, dt_s);
  n->in.setpoint_arrived = false;
  tick(&n->b);
}

static void node_ticks(node *n, int count) {
  for (int i = 0; i < count; ++i) {
    node_tick(n);
  }
}

static node node_enabled(int8_t mode) {
  node n = {.b = bench_at_rest()};
  n.o.state.option = drive_options_default();
  n.o.state.mode = mode;
  n.o.position.following_error_window = 100000;
  n.o.position.following_error_ms = 10;
  n.o.position.window = 100;
  n.o.position.window_ms = 20;
  n.o.velocity.window = 500;
  n.o.velocity.window_ms = 20;
  n.o.torque.rated_mnm = 40000;
  n.o.torque.maximum = n.o.torque.positive_limit = n.o.torque.negative_limit = 1000;
  n.o.limit = (drive_limit_objects){.maximum_velocity = 800000,
                                    .profile_velocity = 500000,
                                    .acceleration = 1000000,
                                    .deceleration = 1000000,
                                    .quick_stop_deceleration = 1500000,
                                    .jerk = 20000000,
                                    .interpolation_period = 10,
                                    .interpolation_exponent = -3};
  n.in.ready = n.in.voltage_present = n.in.remote = true;
  drive_axis_reset(&n.drive, 0u);
  const uint16_t words[] = {0x00, 0x06, 0x07, 0x0F};
  for (unsigned i = 0; i < 4; ++i) {
    n.o.state.controlword = words[i];
    node_ticks(&n, 2);
  }
  TEST_ASSERT_EQUAL_HEX16(0x27, n.o.state.statusword & 0x6F);
  return n;
}

static void test_pv_turns_the_axis_at_1_deg_s(void) {
  node n = node_enabled(DRIVE_PROFILE_VELOCITY);
  n.o.velocity.target = 17453;
  double fastest_rad_s = 0.0;
  for (int i = 0; i < 1000; ++i) {
    node_tick(&n);
    fastest_rad_s = fmax(fastest_rad_s, n.b.rate_rad_s);
  }
  LOG_VALUE("fastest, rad/s", fastest_rad_s);
  CHECK_NEAR("rate, rad/s", 0.017453, n.b.rate_rad_s, 1e-6);
  CHECK_NEAR("606C", 17453, n.o.velocity.actual, 3);
  CHECK_AT_MOST("fastest, rad/s", 0.01746 * 1.05, fastest_rad_s);
  TEST_ASSERT_TRUE((n.o.state.statusword & DRIVE_STATUS_TARGET_REACHED) != 0);
}

static void test_pp_carries_the_axis_along_its_ramp(void) {
  node n = node_enabled(DRIVE_PROFILE_POSITION);
  n.o.position.target = 7000000;
  n.o.state.controlword = 0x1F;
  double worst_error = 0.0;
  double farthest_rad = 0.0;
  int count = 0;
  node_ticks(&n, 3);
  while ((n.o.state.statusword & DRIVE_STATUS_TARGET_REACHED) == 0) {
    node_tick(&n);
    worst_error = fmax(worst_error, fabs((double)n.o.position.following_error));
    farthest_rad = fmax(farthest_rad, n.b.turns * 6.283185307179586);
    TEST_ASSERT_TRUE(++count < 5000);
  }
  LOG_VALUE("ticks on the way", count);
  LOG_VALUE("largest following error, 1e-7 rad", worst_error);
  CHECK_AT_MOST("following error, 1e-7 rad", 20000, worst_error);
  CHECK_AT_MOST("farthest, rad", 0.7 + 1e-4, farthest_rad);
  CHECK_NEAR("position, rad", 0.7, n.b.turns * 6.283185307179586, 1e-5);
}

static void test_modes_change_on_the_moving_axis_without_a_step_of_the_torque(void) {
  node n = node_enabled(DRIVE_PROFILE_VELOCITY);
  n.b.load_nm = 3.0;
  n.o.velocity.target = 200000;
  n.o.torque.target = 75; /* 3 Nm: holds the load */
  n.o.torque.slope_per_s = 500;
  node_ticks(&n, 2000);
  const int8_t modes[] = {DRIVE_CYCLIC_TORQUE,   DRIVE_CYCLIC_VELOCITY, DRIVE_CYCLIC_POSITION, DRIVE_PROFILE_VELOCITY,
                          DRIVE_CYCLIC_VELOCITY, DRIVE_CYCLIC_TORQUE,   DRIVE_PROFILE_VELOCITY};
  n.b.worst_step_nm = 0.0;
  for (unsigned m = 0; m < sizeof modes / sizeof modes[0]; ++m) {
    n.o.state.mode = modes[m];
    for (int i = 0; i < 500; ++i) {
      n.in.setpoint_arrived = i % 10 == 0;
      if (i % 10 == 0) { /* csp: goes on at 0.2 rad/s from where the axis is in this tick */
        n.o.position.target = i == 0 ? n.o.position.actual + 22000 : n.o.position.target + 20000;
      }
      node_tick(&n);
    }
    CHECK_NEAR("rate, rad/s", 0.2, n.b.rate_rad_s, 2e-3);
  }
  LOG_VALUE("largest step of the torque, Nm of 40", n.b.worst_step_nm);
  CHECK_AT_MOST("largest step of the torque, Nm of 40", 0.4, n.b.worst_step_nm);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_torque_mode_gives_exactly_the_torque_asked_for_within_the_limits);
  RUN_TEST(test_a_speed_loop_takes_over_from_torque_mode_without_a_step);
  RUN_TEST(test_speed_and_position_loops_keep_the_torque_limits_from_outside);
  RUN_TEST(test_a_torque_offset_carries_a_load_and_is_counted_once);
  RUN_TEST(test_position_mode_passes_the_acceleration_on);
  RUN_TEST(test_a_torque_or_limit_that_is_not_finite_switches_the_axis_off);
  RUN_TEST(test_pv_turns_the_axis_at_1_deg_s);
  RUN_TEST(test_pp_carries_the_axis_along_its_ramp);
  RUN_TEST(test_modes_change_on_the_moving_axis_without_a_step_of_the_torque);
  return UNITY_END();
}
