/* SPDX-License-Identifier: Apache-2.0 */
/* Tracking (mode -1) in the whole node: camera frames in one PDO, both axes follow the target. */
#include "support/node_bench.h"

#include "support/check.h"

enum { TRACKING = -1, PV = 3, FRAME_ID = 0x500 + NODE_ID };
enum { FRAME = 0x3070, CAMERA = 0x3071, CAMERA_STATE = 0x3072, TAKEN = 1, MISSED, DROPPED, LAST_DROP, AZIMUTH_STATE };
enum { WINDOW = 1000, DWELL_MS = 50 }; /* for 6067, in 1e-7 rad, and 6068 */
enum { AGE_IN_USE = 7, CLOCK, PICTURE, TIME_OF_EXPOSURE = 5 };
enum { DELAY = 0x3073, DITHER_S = 4, DELAY_ERROR, HALF_WIDTH, CORRECTION };
enum {
  STROBE = 0x3074,
  STROBE_TIME = 4,
  EDGES,
  PAIRED,
  UNPAIRED,
  REFUSAL,
  MISSING,
  ADDITIONAL,
  FLOODS,
  IN_USE,
  AGE_10US
};
enum { TARGET_RETURN = 0x3075, BACK_IN = 1, TURN_BACK, WRAP_STATE };
enum { NOT_TRACKING, SEARCHING, ACQUIRING, ON_TARGET, COASTING, TARGET_LOST, STOPPED };
enum { FRAME_MS = 20, AGE_MS = 30, HISTORY = 64 };

#define TURN_RAD 6.283185307179586
#define PICTURE_RAD 32e-3 /* half of it */

/* A target far away, and what the camera saw: angles of both joints at each of the last ms. */
static struct {
  double azimuth_rad;
  double rate_rad_s;
  double pitch_rad;
  double seen_azimuth_rad[HISTORY];
  double seen_pitch_rad[HISTORY];
  unsigned ms;
  unsigned age_ms; /* of a frame when it arrives */
  uint8_t counter;
  bool shown;
  double beside_rad;            /* in the next frame: so far from the target something else is seen */
  bool upside_down;             /* the camera */
  int misstated_ms;             /* added to the age */
  bool stamps;                  /* the sender states the node's clock at exposure */
  bool strobes;                 /* the camera shows its exposures, 500 us before their middle */
  uint16_t clock_10us[HISTORY]; /* of the node, at each of the last ms */
  uint32_t strobe_us;           /* machine's clock at the newest edge */
} world;

static double joint_rad(int axis) { return machine.axis[axis].turns * TURN_RAD; }

/* RPDO4 becomes that of the camera: 3070:1 to :5. */
static void map_camera(void) {
  SET(0x1403, 1, 0x80000000u | FRAME_ID);
  SET(0x1603, 0, 0);
  SET(0x1603, 1, 0x30700110);
  SET(0x1603, 2, 0x30700210);
  SET(0x1603, 3, 0x30700310);
  SET(0x1603, 4, 0x30700408);
  SET(0x1603, 5, 0x30700508);
  SET(0x1603, 0, 5);
  SET(0x1403, 1, FRAME_ID);
}

void setUp(void) {
  memset(&world, 0, sizeof world);
  world.age_ms = AGE_MS;
  world.shown = true;
  node_bench_start();
  map_camera();
  SET(0x6007, 0, 0); /* this master is silent but for its frames */
  SET(0x6807, 0, 0);
  nmt(0x01);
}

void tearDown(void) {}

static uint16_t stated_time(void) {
  return world.stamps ? world.clock_10us[(world.ms - world.age_ms) % HISTORY]
                      : (uint16_t)(100 * ((int)world.age_ms + world.misstated_ms));
}

/* Image errors of the exposure: at small pitch angles those of the joints, times cos(pitch) for the azimuth. */
static void send_frame(double azimuth_error_rad, double pitch_error_rad, double pitch_rad, bool found) {
  const double counts_per_rad = world.upside_down ? -1e6 : 1e6;
  const int16_t x = (int16_t)lround(counts_per_rad * azimuth_error_rad * cos(pitch_rad));
  const int16_t y = (int16_t)lround(counts_per_rad * pitch_error_rad);
  const uint16_t age = stated_time();
  give(FRAME_ID, 8,
       (const uint8_t[]){(uint8_t)x, (uint8_t)((uint16_t)x >> 8), (uint8_t)y, (uint8_t)((uint16_t)y >> 8), (uint8_t)age,
                         (uint8_t)(age >> 8), found ? 90 : 0, ++world.counter});
}

static void follow_for(unsigned duration_ms) {
  for (unsigned i = 0; i < duration_ms; ++i) {
    world.seen_azimuth_rad[world.ms % HISTORY] = world.azimuth_rad - joint_rad(0);
    world.seen_pitch_rad[world.ms % HISTORY] = world.pitch_rad - joint_rad(1);
    world.clock_10us[world.ms % HISTORY] = (uint16_t)(node.tracking.objects.clock + 100);
    if (world.strobes && (world.ms + world.age_ms) % FRAME_MS == 0) {
      world.strobe_us = machine.clock_us - 500u;
      machine.strobes = (hal_strobes){.count = 1, .at_us = {world.strobe_us}};
    }
    if (world.ms % FRAME_MS == 0 && world.ms >= world.age_ms) {
      const unsigned then = (world.ms - world.age_ms) % HISTORY;
      const bool visible = fabs(world.seen_azimuth_rad[then]) < PICTURE_RAD;
      send_frame(visible ? world.seen_azimuth_rad[then] + world.beside_rad : 0.0,
                 world.seen_pitch_rad[then] + world.beside_rad / 2.0, joint_rad(1), visible && world.shown);
      world.beside_rad = 0.0;
    }
    wait_ms(1);
    world.azimuth_rad += 1e-3 * world.rate_rad_s;
    world.ms++;
  }
}

/* Takes a ms in which the target stands: compare angles first. */
static unsigned state_of_tracking(void) { return (unsigned)get(CAMERA_STATE, AZIMUTH_STATE) & 0xFF; }

static void test_mode_is_listed_and_frames_move_nothing_in_another_mode(void) {
  TEST_ASSERT_EQUAL_HEX32(0x000103A5, get(0x6502, 0));
  world.azimuth_rad = 3e-3;
  enable(0, PV);
  follow_for(1000);
  TEST_ASSERT_EQUAL(NOT_TRACKING, state_of_tracking());
  CHECK_NEAR("rad", 0.0, joint_rad(0), 1e-6);
  TEST_ASSERT_TRUE(get(CAMERA_STATE, TAKEN) >= 48);
}

static void test_both_axes_follow_the_target_of_the_frames(void) {
  world.azimuth_rad = 3e-3;
  world.pitch_rad = -2e-3;
  world.rate_rad_s = 0.02;
  enable(0, TRACKING);
  enable(PITCH, TRACKING);
  TEST_ASSERT_EQUAL(SEARCHING, state_of_tracking());
  follow_for(200);
  TEST_ASSERT_EQUAL(ACQUIRING, state_of_tracking());
  follow_for(6000);
  CHECK_NEAR("azimuth, rad", world.azimuth_rad, joint_rad(0), 2e-6);
  CHECK_NEAR("pitch, rad", world.pitch_rad, joint_rad(1), 2e-6);
  TEST_ASSERT_EQUAL(ON_TARGET, state_of_tracking());
  CHECK_NEAR("60F4, 1e-7 rad", 0.0, (double)(int32_t)get(0x60F4, 0), 30.0);
  TEST_ASSERT_EQUAL_HEX32(0x1400, get(0x6041, 0) & 0x1400); /* target reached; follows */
  for (int i = 0; i < SERVO_AXES; ++i) {
    CHECK_NEAR("for the search of oscillations, rad/s", 0.0, node.axis[i].monitor.swings.last_error_rad_s, 2e-3);
  }
}

/* For how many ms 60F4 was out of its window while the axis was still on target; 0 if it still is after 200 ms. */
static unsigned ms_until_off_target(int axis) {
  const uint8_t *state = axis == 0 ? &node.tracking.objects.azimuth_tracking : &node.tracking.objects.pitch_tracking;
  unsigned outside_ms = 0;
  for (int i = 0; i < 200; ++i) {
    follow_for(1);
    if (*state != ON_TARGET) {
      return outside_ms;
    }
    outside_ms += fabs((double)node.axis[axis].objects.position.following_error) > WINDOW ? 1 : 0;
  }
  return 0;
}

/* The target jumps by 8 mrad, which the axis takes back at 20 mrad/s at most. */
static void test_a_target_outside_the_window_is_not_on_target(void) {
  for (int axis = 0; axis < SERVO_AXES; ++axis) {
    setUp();
    const uint16_t offset = axis == 0 ? 0 : PITCH;
    SET(0x6067 + offset, 0, WINDOW);
    SET(0x6068 + offset, 0, DWELL_MS);
    enable(offset, TRACKING);
    follow_for(3000);
    TEST_ASSERT_EQUAL_HEX32(0x1400, get(0x6041 + offset, 0) & 0x1400); /* reached; follows */
    SET(0x607F + offset, 0, 20000);
    *(axis == 0 ? &world.azimuth_rad : &world.pitch_rad) += 8e-3;
    TEST_ASSERT_UINT_WITHIN(1, DWELL_MS, ms_until_off_target(axis));
    TEST_ASSERT_EQUAL(ACQUIRING, get(CAMERA_STATE, (uint8_t)(AZIMUTH_STATE + axis)) & 0xFF);
    TEST_ASSERT_EQUAL_HEX32(0x1000, get(0x6041 + offset, 0) & 0x1400); /* not reached; follows */
    follow_for(3000);
    TEST_ASSERT_EQUAL_HEX32(0x1400, get(0x6041 + offset, 0) & 0x1400);
  }
}

/* 6007 = 3: the camera's frames are enough. Node 16 in 1016, every 200 ms at least: they are not. */
static void test_a_lost_heartbeat_stops_an_axis_that_the_camera_leads(void) {
  SET(0x6007, 0, 3);
  world.rate_rad_s = 0.02;
  enable(0, TRACKING);
  follow_for(5000);
  CHECK_NEAR("without another master, rad", world.azimuth_rad, joint_rad(0), 2e-6);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  SET(0x1016, 1, 16 << 16 | 200);
  give(0x700 + 16, 1, (const uint8_t[]){5});
  follow_for(150);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  follow_for(1000);
  TEST_ASSERT_EQUAL_HEX32(STATE_FAULT, state_of(0) & 0x4F);
  TEST_ASSERT_EQUAL_HEX32(0x8130, get(0x603F, 0) & 0xFFFF);
}

/* One estimate for both; the azimuth's own one takes over where the other left. */
/* Of the azimuth, within 25 %: nothing brakes it in between. */
static void follow_and_expect_rate(unsigned duration_ms, double rate_rad_s) {
  for (unsigned i = 0; i < duration_ms; ++i) {
    follow_for(1);
    CHECK_NEAR("rad/s", rate_rad_s, machine.axis[0].rate_rad_s, 0.25 * rate_rad_s);
  }
}

/* Both axes turn with the target in pv, and are taken over while the camera sees it. */
static void test_axes_that_move_with_the_target_do_not_pause_when_tracking_begins(void) {
  enable(0, PV);
  enable(PITCH, PV);
  SET(0x60FF, 0, 20000);
  follow_for(100);
  world.azimuth_rad = joint_rad(0);
  world.rate_rad_s = 0.02;
  follow_for(1000);
  SET(0x6060, 0, (uint8_t)TRACKING);
  SET(0x6060 + PITCH, 0, (uint8_t)TRACKING);
  follow_and_expect_rate(500, 0.02);
  TEST_ASSERT_EQUAL(TRACKING_TOGETHER, node.tracking.phase);
  CHECK_NEAR("rad", world.azimuth_rad, joint_rad(0), 1e-4);
}

/* The ages of the frames are 10 ms wrong: while the axis slews they show the target 3.5 mrad too far. Then it stands
 * 1.2 mrad beside the target, which winds no integral up. */
static void test_a_fast_slew_before_leads_no_axis_astray(void) {
  static const struct {
    const char *name;
    unsigned axis;
    unsigned kind; /* 2011:1 */
    bool both;
    unsigned stands_ms;
  } cases[] = {{"both", 0, 1, true, 100},
               {"azimuth", 0, 1, false, 100},
               {"pitch", PITCH, 1, false, 100},
               {"pitch, PI", PITCH, 0, false, 100},
               {"azimuth, PI", 0, 0, false, 20000}};
  for (unsigned i = 0; i < sizeof cases / sizeof *cases; ++i) {
    const unsigned axis = cases[i].axis;
    double *target_rad = axis == PITCH ? &world.pitch_rad : &world.azimuth_rad;
    const int joint = axis == PITCH ? 1 : 0;
    setUp();
    SET(0x2011 + axis, 1, cases[i].kind);
    SET(0x2070 + axis, 1, 1);
    wait_ms(50);
    TEST_ASSERT_EQUAL(cases[i].kind, node.board.app.params.axis[joint].tracker.kind);
    world.misstated_ms = 10;
    *target_rad = joint_rad(joint) + 0.2;
    enable(axis, TRACKING); /* a time before, which counts for nothing */
    follow_for(100);
    if (cases[i].both) {
      enable(PITCH, PV);
    }
    enable(axis, PV);
    SET(0x60FF + axis, 0, 350000); /* brakes within 61 mrad, and sees the target for the last 32 */
    for (int ms = 0; ms < 2000 && joint_rad(joint) < *target_rad - 0.07; ++ms) {
      follow_for(1);
    }
    SET(0x60FF + axis, 0, 0);
    follow_for(420 + cases[i].stands_ms);
    const double from_rad = *target_rad - joint_rad(joint);
    SET(0x6060 + axis, 0, (uint8_t)TRACKING);
    if (cases[i].both) {
      SET(0x6060 + PITCH, 0, (uint8_t)TRACKING);
    } else if (cases[i].kind == 1) {
      follow_for(1);
      CHECK_NEAR("known of the target from the next ms on, rad/s", 0.0,
                 node.tracking.joints.axis[joint].target_rate_rad_s, 2e-3);
    }
    double worst_rad = 0.0;
    for (int ms = 0; ms < 2000; ++ms) {
      follow_for(1);
      worst_rad = fmax(worst_rad, fabs(*target_rad - joint_rad(joint)));
    }
    LOG_VALUE(cases[i].name, from_rad);
    CHECK_AT_MOST("further from it than at first, rad", 2e-4, worst_rad - fabs(from_rad));
    CHECK_NEAR("in the end, rad", 0.0, *target_rad - joint_rad(joint), 1e-4);
  }
}

/* 60F4 is the error as the last frame saw it. The estimate, which leads the axis, is smoother: a target that swings by
 * 1 mrad at 1 Hz is up to 0.9 mrad off, and never on target. */
static void test_a_target_that_swings_is_not_on_target(void) {
  enable(0, TRACKING);
  enable(PITCH, TRACKING);
  SET(0x6067, 0, 1000); /* 0.1 mrad */
  SET(0x6068, 0, 50);
  follow_for(1500);
  TEST_ASSERT_EQUAL(ON_TARGET, state_of_tracking());
  int wrong = 0;
  double worst_rad = 0.0;
  for (int ms = 0; ms < 4000; ++ms) {
    world.rate_rad_s = 6.283e-3 * cos(6.283e-3 * ms);
    follow_for(1);
    const double error_rad = world.azimuth_rad - joint_rad(0);
    worst_rad = fmax(worst_rad, fabs(error_rad));
    wrong += ms > 200 && node.axis[0].drive.tracking == DRIVE_ON_TARGET && fabs(error_rad) > 2e-4 ? 1 : 0;
  }
  LOG_VALUE("ms on target while 0.2 mrad and more off, of 4000", wrong);
  LOG_VALUE("worst error, rad", worst_rad);
  TEST_ASSERT_TRUE(worst_rad > 5e-4);
  TEST_ASSERT_TRUE(wrong < 40);
}

/* Of 1003: the code, above it the detail and the source. */
static uint32_t newest_error(void) { return get(0x1003, 1); }

static unsigned state_of_picture(void) { return (unsigned)get(CAMERA_STATE, PICTURE) & 0xFF; }

/* 1: the azimuth alone, 2: the pitch alone, 3: both. */
static void track_with(unsigned axes) {
  for (unsigned axis = 0; axis < 2; ++axis) {
    if ((axes >> axis & 1u) != 0) {
      enable(axis * PITCH, TRACKING);
    }
  }
}

/* Driven away from a target at 20 mrad, which asks for 0.4 rad/s: at 0.1 rad/s at most, until the picture is judged. */
static void test_a_picture_upside_down_stops_the_axes_that_follow_it(void) {
  for (unsigned axes = 1; axes <= 3; ++axes) {
    setUp();
    world.upside_down = true;
    world.azimuth_rad = 20e-3;
    world.pitch_rad = 20e-3;
    track_with(axes);
    double fastest_rad_s[] = {0.0, 0.0};
    for (int ms = 0; ms < 1000; ++ms) {
      follow_for(1);
      for (int i = 0; i < 2; ++i) {
        fastest_rad_s[i] = fmax(fastest_rad_s[i], fabs(machine.axis[i].rate_rad_s));
      }
    }
    TEST_ASSERT_EQUAL_HEX32(CAMERA_PICTURE_WRONG << 16 | 0x7000, newest_error() & 0xFFFFFF);
    TEST_ASSERT_EQUAL(PICTURE_WRONG_ROLL, state_of_picture());
    CHECK_NEAR("roll, rad", 3.1416, fabs(1e-4 * (int16_t)get(CAMERA_STATE, PICTURE + 1)), 0.05);
    for (unsigned i = 0; i < 2; ++i) {
      const bool tracks = (axes >> i & 1u) != 0;
      TEST_ASSERT_EQUAL(tracks ? STOPPED : NOT_TRACKING, get(CAMERA_STATE, (uint8_t)(AZIMUTH_STATE + i)) & 0xFF);
      CHECK_NEAR("fastest, rad/s", tracks ? 0.075 : 0.0, fastest_rad_s[i], tracks ? 0.035 : 1e-4);
      CHECK_NEAR("stands, rad/s", 0.0, machine.axis[i].rate_rad_s, 1e-4);
    }
  }
}

/* A target that stands shows nothing of the camera's orientation. How far an axis is from it that does not track counts
 * for nothing. */
static void test_a_picture_is_right_after_1500_ms_on_the_target(void) {
  for (unsigned axes = 1; axes <= 3; ++axes) {
    setUp();
    world.azimuth_rad = axes == 2 ? 20e-3 : 0.0;
    world.pitch_rad = axes == 1 ? 20e-3 : 0.0;
    track_with(axes);
    follow_for(1400);
    TEST_ASSERT_EQUAL(PICTURE_NOT_JUDGED, state_of_picture());
    follow_for(250);
    TEST_ASSERT_EQUAL(PICTURE_RIGHT, state_of_picture());
  }
}

/* Within 150 ms: what leads away from the target makes it vanish, too. */
static void test_a_target_that_vanishes_before_its_picture_is_right_is_lost_sooner(void) {
  for (unsigned axes = 1; axes <= 3; ++axes) {
    setUp();
    track_with(axes);
    follow_for(500);
    world.shown = false;
    follow_for(AGE_MS + 100);
    const uint8_t tracking = axes == 2 ? AZIMUTH_STATE + 1 : AZIMUTH_STATE;
    TEST_ASSERT_EQUAL(COASTING, get(CAMERA_STATE, tracking) & 0xFF);
    follow_for(80);
    TEST_ASSERT_EQUAL(TARGET_LOST, get(CAMERA_STATE, tracking) & 0xFF);
  }
}

/* 2011:5 is a gain: applied by 2070:1, and the azimuth's is that of the line of sight. The target vanishes 0.1 s before
 * the pitch begins, too, when it does, or 0.1 s after: what counts is the last frame. */
static void test_a_coasting_time_that_only_the_azimuth_has_got_counts_for_both(void) {
  for (int together_ms = -100; together_ms <= 100; together_ms += 100) {
    setUp();
    SET_FLOAT(0x2011, 5, 0.2f);
    SET(0x2070, 1, 1);
    track_with(1);
    follow_for(3000);
    const unsigned alone_ms = together_ms < 0 ? 100 : 0;
    world.shown = together_ms >= 0;
    follow_for(alone_ms);
    track_with(2);
    if (together_ms >= 0) {
      follow_for((unsigned)together_ms);
      TEST_ASSERT_EQUAL(ON_TARGET, state_of_tracking());
      world.shown = false;
    }
    follow_for(140 - alone_ms);
    TEST_ASSERT_EQUAL(TRACKING_TOGETHER, node.tracking.phase);
    TEST_ASSERT_EQUAL(COASTING, state_of_tracking());
    follow_for(90);
    TEST_ASSERT_EQUAL(TARGET_LOST, state_of_tracking());
  }
}

/* 2011:1 = 0 of either axis: each follows by itself. */
static void test_axes_track_together_only_with_the_predictive_loop_of_both(void) {
  for (unsigned axis = 0; axis < 2; ++axis) {
    setUp();
    SET(0x2011 + axis * PITCH, 1, 0);
    SET(0x2070 + axis * PITCH, 1, 1);
    world.azimuth_rad = 2e-3;
    world.pitch_rad = 2e-3;
    track_with(3);
    follow_for(5000);
    TEST_ASSERT_EQUAL(TRACKING_APART, node.tracking.phase);
    CHECK_NEAR("azimuth, rad", world.azimuth_rad, joint_rad(0), 1e-4);
    CHECK_NEAR("pitch, rad", world.pitch_rad, joint_rad(1), 1e-4);
  }
}

/* 2010:2 of the pitch, applied again and again; tracking knows each of them before it begins. */
static void test_new_gains_of_either_axis_are_those_that_it_will_track_with(void) {
  for (int i = 1; i <= 4; ++i) {
    SET_FLOAT(0x2010 + PITCH, 2, 0.3f + 0.01f * (float)i);
    SET(0x2070 + PITCH, 1, 1);
    wait_ms(2);
    CHECK_NEAR("pitch, rad/s", 0.3 + 0.01 * i, node.tracking.rate_rad_s.pitch, 1e-6);
  }
  SET_FLOAT(0x2010, 2, 0.25f);
  SET(0x2070, 1, 1);
  wait_ms(2);
  CHECK_NEAR("azimuth, rad/s", 0.25, node.tracking.rate_rad_s.azimuth, 1e-6);
}

static void test_an_axis_goes_on_alone_when_the_other_one_leaves(void) {
  world.rate_rad_s = 0.02;
  enable(0, TRACKING);
  enable(PITCH, TRACKING);
  follow_for(5000);
  TEST_ASSERT_EQUAL(TRACKING_TOGETHER, node.tracking.phase);
  CHECK_NEAR("together, rad", world.azimuth_rad, joint_rad(0), 2e-6);
  SET(0x6060 + PITCH, 0, PV);
  follow_and_expect_rate(200, 0.02);
  TEST_ASSERT_EQUAL(TRACKING_APART, node.tracking.phase);
  CHECK_NEAR("handed over, rad", world.azimuth_rad, joint_rad(0), 1e-4);
  follow_for(3000);
  CHECK_NEAR("alone, rad", world.azimuth_rad, joint_rad(0), 2e-6);
}

/* The target vanishes when one axis leaves: the other one coasts for its 2011:5 from the last frame on. */
static void test_an_axis_that_is_left_alone_coasts_as_long_as_before(void) {
  for (unsigned stays = 0; stays < 2; ++stays) {
    setUp();
    track_with(3);
    follow_for(3000);
    world.shown = false;
    SET(0x6060 + (stays == 0 ? PITCH : 0), 0, PV);
    follow_for(400);
    TEST_ASSERT_EQUAL(TRACKING_APART, node.tracking.phase);
    TEST_ASSERT_EQUAL(COASTING, get(CAMERA_STATE, (uint8_t)(AZIMUTH_STATE + stays)) & 0xFF);
    follow_for(150);
    TEST_ASSERT_EQUAL(TARGET_LOST, get(CAMERA_STATE, (uint8_t)(AZIMUTH_STATE + stays)) & 0xFF);
  }
}

/* The image processor sends its last picture again and again, with counters that advance. */
static void send_frozen_for(unsigned duration_ms, int16_t counts) {
  for (unsigned i = 0; i < duration_ms; ++i) {
    if (world.ms % FRAME_MS == 0) {
      send_frame(0.0, 1e-6 * counts, 0.0, true);
    }
    wait_ms(1);
    world.ms++;
  }
}

/* 5 mrad: from 0.5 s on no frame counts; the pitch coasts for 2011:5, and stops after 0.13 rad in all. Taken for a
 * target it turned on for ever. The azimuth is at a quarter of a turn. */
static void test_a_frozen_picture_stops_the_axis_that_it_drives(void) {
  enable(0, PV);
  SET(0x60FF, 0, 1000000);
  while (joint_rad(0) < TURN_RAD / 4.0 - 0.5) {
    wait_ms(1);
  }
  SET(0x60FF, 0, 0);
  wait_ms(2000);
  CHECK_NEAR("azimuth, rad", TURN_RAD / 4.0, joint_rad(0), 0.1);
  world.azimuth_rad = joint_rad(0);
  enable(0, TRACKING);
  enable(PITCH, TRACKING);
  follow_for(2000);
  send_frozen_for(6000, 5000);
  const double stopped_rad = joint_rad(1);
  TEST_ASSERT_EQUAL(6, get(CAMERA_STATE, LAST_DROP));
  TEST_ASSERT_EQUAL(TARGET_LOST, get(CAMERA_STATE, AZIMUTH_STATE + 1));
  TEST_ASSERT_TRUE(fabs(stopped_rad) < 0.2);
  TEST_ASSERT_EQUAL_HEX16(0x7000, newest_error() & 0xFFFF);
  TEST_ASSERT_EQUAL_HEX8(6, newest_error() >> 16 & 0xFF);
  send_frozen_for(1000, 5000);
  CHECK_NEAR("stands, rad", stopped_rad, joint_rad(1), 1e-5);
  world.pitch_rad = joint_rad(1) + 1e-3; /* the sender sees again */
  follow_for(3000);
  TEST_ASSERT_EQUAL(ON_TARGET, get(CAMERA_STATE, AZIMUTH_STATE + 1));
  CHECK_NEAR("pitch, rad", world.pitch_rad, joint_rad(1), 5e-6);
  TEST_ASSERT_EQUAL_HEX8(0, get(0x1001, 0));
}

/* Nothing tracks and the sender is silent, because it is mended; then a target stands in the very place that the frozen
 * picture showed. One that goes on sending it is known. */
static void test_the_place_of_a_frozen_picture_is_kept_until_its_sender_was_silent(void) {
  enable(0, TRACKING);
  enable(PITCH, TRACKING);
  follow_for(2000);
  send_frozen_for(3000, 5000);
  TEST_ASSERT_EQUAL(6, get(CAMERA_STATE, LAST_DROP));
  enable(0, PV);
  enable(PITCH, PV);
  send_frozen_for(2000, 5000);
  const double before_rad = joint_rad(1);
  enable(PITCH, TRACKING);
  send_frozen_for(1000, 5000);
  CHECK_NEAR("stands, rad", before_rad, joint_rad(1), 1e-5);
  enable(PITCH, PV);
  wait_ms(1000);
  world.azimuth_rad = joint_rad(0);
  world.pitch_rad = joint_rad(1) + 5e-3;
  enable(0, TRACKING);
  enable(PITCH, TRACKING);
  follow_for(3000);
  TEST_ASSERT_EQUAL(ON_TARGET, get(CAMERA_STATE, AZIMUTH_STATE + 1));
  CHECK_NEAR("pitch, rad", world.pitch_rad, joint_rad(1), 5e-6);
}

static void test_a_counter_that_stands_is_told(void) {
  enable(PITCH, TRACKING);
  follow_for(1000);
  for (int i = 0; i < 20; ++i) {
    world.counter--;
    send_frame(0.0, 3e-3, 0.0, true);
    wait_ms(FRAME_MS);
  }
  TEST_ASSERT_EQUAL_HEX16(0x7000, newest_error() & 0xFFFF);
  TEST_ASSERT_EQUAL_HEX8(1, newest_error() >> 16 & 0xFF);
  TEST_ASSERT_NOT_EQUAL(0, get(0x1001, 0) & 0xFF); /* for as long as it stands */
  follow_for(900);
  TEST_ASSERT_NOT_EQUAL(0, get(0x1001, 0) & 0xFF); /* and until none has been dropped for a second */
  follow_for(200);
  TEST_ASSERT_EQUAL_HEX8(0, get(0x1001, 0));
}

/* Frames count while the azimuth stands 5 mrad beside the target, and the pitch tracks. The camera is silent for 1.1 s,
 * in which a master turns the azimuth; then it shows the target in the same place. */
static void test_a_camera_that_is_silent_while_an_axis_turns_is_not_frozen(void) {
  world.azimuth_rad = 5e-3;
  enable(0, PV);
  enable(PITCH, TRACKING);
  follow_for(600);
  SET(0x60FF, 0, 60000);
  wait_ms(600);
  SET(0x60FF, 0, 0);
  wait_ms(500);
  CHECK_AT_LEAST("turned, rad", 0.03, joint_rad(0));
  const uint32_t taken = get(CAMERA_STATE, TAKEN);
  world.azimuth_rad = joint_rad(0) + 5e-3;
  follow_for(10 * FRAME_MS);
  TEST_ASSERT_EQUAL(0, get(CAMERA_STATE, DROPPED));
  TEST_ASSERT_EQUAL(10, get(CAMERA_STATE, TAKEN) - taken);
}

/* No axis tracks: each time that a sender begins anew the fourth frame counts. */
static void test_a_sender_may_begin_anew_as_often_as_it_likes_before_tracking(void) {
  follow_for(500);
  for (int time = 0; time < 4; ++time) {
    const uint32_t before = get(CAMERA_STATE, TAKEN);
    world.counter = (uint8_t)(world.counter - 100);
    follow_for(10 * FRAME_MS);
    TEST_ASSERT_INT_WITHIN(1, 7, (int)(get(CAMERA_STATE, TAKEN) - before));
  }
}

/* Errors of an image processor that has lost its target: +A and -A in turn, each `stays` frames, 500 in a second,
 * whatever the axes do. `late_every`: of so many frames one comes 2 ms late, in the same tick as the next one, which
 * counts alone. */
static void alternate_for(unsigned duration_ms, double amplitude_rad, unsigned stays, unsigned late_every) {
  for (unsigned i = 0; i < duration_ms; ++i) {
    const unsigned frame = world.ms / 2;
    const double sign_rad = frame / stays % 2 == 0 ? amplitude_rad : -amplitude_rad;
    if (world.ms % 2 == 0 && late_every != 0 && frame % late_every == 1) {
      send_frame(-sign_rad, -sign_rad, 0.0, true);
    }
    if (world.ms % 2 == 0 && !(late_every != 0 && frame % late_every == 0)) {
      send_frame(sign_rad, sign_rad, 0.0, true);
    }
    wait_ms(1);
    world.ms++;
  }
}

/* Rows: which axes track, how far the errors jump, how long they stay, and how often two frames share a tick. */
static void test_errors_that_jump_to_and_fro_do_not_turn_the_axes(void) {
  static const struct {
    double amplitude_rad;
    unsigned stays, late;
  } rows[] = {{1e-3, 1, 0}, {5e-3, 1, 0}, {20e-3, 1, 0}, {1e-3, 1, 3},  {5e-3, 1, 3},  {20e-3, 1, 3},
              {1e-3, 1, 7}, {5e-3, 1, 7}, {20e-3, 1, 7}, {1e-3, 1, 50}, {5e-3, 1, 50}, {20e-3, 1, 50},
              {5e-3, 2, 0}, {5e-3, 3, 0}, {20e-3, 3, 0}, {20e-3, 5, 0}};
  enum { ROWS = sizeof rows / sizeof rows[0] };
  for (unsigned row = 0; row < 2 * ROWS; ++row) {
    const double amplitude_rad = rows[row % ROWS].amplitude_rad;
    const unsigned stays = rows[row % ROWS].stays;
    const unsigned late = rows[row % ROWS].late;
    setUp();
    enable(PITCH, TRACKING);
    if (row >= ROWS) {
      enable(0, TRACKING);
    }
    alternate_for(1000, amplitude_rad, stays, late);
    const double from_rad[] = {joint_rad(0), joint_rad(1)};
    alternate_for(5000, amplitude_rad, stays, late);
    const double turned_rad = fmax(fabs(joint_rad(0) - from_rad[0]), fabs(joint_rad(1) - from_rad[1]));
    LOG_VALUE("drift, rad/s", turned_rad / 5.0);
    CHECK_AT_MOST("drift, rad/s", 1e-4, turned_rad / 5.0);
    CHECK_AT_MOST("in the first second, rad", 0.04, fmax(fabs(from_rad[0]), fabs(from_rad[1])));
    const uint32_t state = get(CAMERA_STATE, AZIMUTH_STATE + 1) & 0xFF;
    TEST_ASSERT_TRUE(state == TARGET_LOST || state == SEARCHING); /* the latter when they were together too late */
    TEST_ASSERT_EQUAL(CAMERA_JUMPS, get(CAMERA_STATE, LAST_DROP) & 0xFF);
    TEST_ASSERT_EQUAL_HEX32(CAMERA_JUMPS << 16 | 0x7000, newest_error() & 0xFFFFFF);
  }
}

/* Frames have shown the target 3 mrad to the left and 2 mrad below while both axes stood in pv. In mode -1 both go
 * there before the next frame comes. */
static void test_axes_that_begin_together_go_to_where_the_target_was_seen(void) {
  world.azimuth_rad = 3e-3;
  world.pitch_rad = -2e-3;
  enable(0, PV);
  enable(PITCH, PV);
  follow_for(1000);
  while (world.ms % FRAME_MS != 1) {
    follow_for(1);
  }
  SET(0x6060, 0, (uint8_t)TRACKING);
  SET(0x6860, 0, (uint8_t)TRACKING);
  follow_for(FRAME_MS - 2);
  CHECK_AT_LEAST("azimuth, rad", 1e-5, joint_rad(0));
  CHECK_AT_MOST("pitch, rad", -1e-5, joint_rad(1));
}

/* Both axes follow the first camera; the next ms is 7 ms after one of its frames. */
static void follow_the_first_camera(void) {
  enable(0, TRACKING);
  enable(PITCH, TRACKING);
  follow_for(3000);
  while (world.ms % FRAME_MS != 7) {
    follow_for(1);
  }
}

/* A second camera on the same identifier sends a frame 7 ms after each one of the first, with a counter that is `ahead`
 * of the newest. Returns the largest error of both axes to the first one's target, rad. */
static double follow_beside(const uint8_t frame[7], unsigned ahead, unsigned frames) {
  double worst_rad = 0.0;
  for (unsigned i = 0; i < frames; ++i) {
    uint8_t data[8];
    memcpy(data, frame, 7);
    data[7] = (uint8_t)(world.counter + ahead);
    give(FRAME_ID, 8, data);
    follow_for(FRAME_MS);
    worst_rad = fmax(worst_rad, fmax(fabs(world.azimuth_rad - joint_rad(0)), fabs(world.pitch_rad - joint_rad(1))));
  }
  return worst_rad;
}

/* The second camera shows another target. Its counter is equal, or 100 or 200 further. */
static void test_of_two_cameras_at_once_the_axes_follow_the_first(void) {
  for (unsigned ahead = 0; ahead <= 200; ahead += 100) {
    setUp();
    world.rate_rad_s = 0.02;
    follow_the_first_camera();
    const uint32_t dropped = node.tracking.frames.dropped;
    const uint8_t others[] = {0x10, 0x27, 0xF0, 0xD8, 0xB8, 0x0B, 90}; /* 10 and -10 mrad, 30 ms old */
    CHECK_AT_MOST("error, rad", 5e-6, follow_beside(others, ahead, 250));
    TEST_ASSERT_EQUAL(250, node.tracking.frames.dropped - dropped);
    TEST_ASSERT_EQUAL(CAMERA_NOT_NEWER, node.tracking.frames.last_drop);
    TEST_ASSERT_EQUAL_HEX32(CAMERA_NOT_NEWER << 16 | 0x7000, newest_error() & 0xFFFFFF);
  }
}

/* The same, but the second camera's counter is up to 4 further than that of the first: a sender may be so far ahead. It
 * leads from then on, and that there are two is told. */
static void test_a_second_camera_that_is_just_ahead_takes_the_lead_and_is_told(void) {
  for (unsigned ahead = 2; ahead <= 4; ++ahead) {
    setUp();
    follow_the_first_camera();
    const uint8_t others[] = {0xD0, 0x07, 0x30, 0xF8, 0xB8, 0x0B, 90}; /* 2 and -2 mrad from the boresight, 30 ms old */
    CHECK_AT_MOST("error, rad", 0.05, follow_beside(others, ahead, 50)); /* they turn after an error that stays */
    TEST_ASSERT_EQUAL(CAMERA_NOT_NEWER, get(CAMERA_STATE, LAST_DROP) & 0xFF);
    TEST_ASSERT_EQUAL_HEX32(CAMERA_NOT_NEWER << 16 | 0x7000, newest_error() & 0xFFFFFF);
    TEST_ASSERT_TRUE(node.tracking.frames.taken + node.tracking.frames.dropped >= 200);
    TEST_ASSERT_TRUE(node.tracking.frames.dropped >= 45); /* one of each pair */
  }
}

/* Each frame comes twice: nothing is told. */
static void test_frames_that_are_sent_twice_are_counted_only(void) {
  follow_the_first_camera();
  follow_for(FRAME_MS - 7);
  const uint32_t errors = get(0x1003, 0);
  const uint32_t dropped = node.tracking.frames.dropped;
  for (int i = 0; i < 100; ++i) {
    follow_for(7);
    const camera_message *message = &node.tracking.message;
    give(FRAME_ID, 8,
         (const uint8_t[]){(uint8_t)message->x, (uint8_t)((uint16_t)message->x >> 8), (uint8_t)message->y,
                           (uint8_t)((uint16_t)message->y >> 8), 0xB8, 0x0B, message->quality, message->counter});
    follow_for(FRAME_MS - 7);
  }
  TEST_ASSERT_EQUAL(100, node.tracking.frames.dropped - dropped);
  TEST_ASSERT_EQUAL_HEX32(errors, get(0x1003, 0));
}

/* The camera sees something else in one frame, so far beside the target, and 300 ms later in another one, while the
 * azimuth, the pitch or both axes follow it. */
static void test_a_single_frame_of_something_else_moves_no_axis(void) {
  const double beside_rad[] = {30e-3, 3e-3, -0.7e-3};
  for (unsigned row = 0; row < 9; ++row) {
    const unsigned axes = 1 + row / 3;
    setUp();
    SET_FLOAT(0x2010, 2, 0.03f); /* rad/s: not enough for what such a frame asks for */
    SET(0x2070, 1, 1);
    world.rate_rad_s = axes == 2 ? 0.0 : 0.02;
    track_with(axes);
    follow_for(6000);
    const uint32_t taken = node.tracking.frames.taken;
    const uint32_t dropped = node.tracking.frames.dropped;
    double worst_rad = 0.0;
    for (int ms = 0; ms < 600; ++ms) {
      world.beside_rad = ms % 300 == 0 ? beside_rad[row % 3] : world.beside_rad;
      follow_for(1);
      worst_rad = fmax(worst_rad, fabs(world.azimuth_rad - joint_rad(0)));
      worst_rad = fmax(worst_rad, fabs(world.pitch_rad - joint_rad(1)));
    }
    LOG_VALUE("error after it, rad", worst_rad);
    CHECK_AT_MOST("error after it, rad", 5e-6, worst_rad);
    TEST_ASSERT_EQUAL(2, get(CAMERA_STATE, DROPPED) - dropped);
    TEST_ASSERT_EQUAL(CAMERA_STRAY, get(CAMERA_STATE, LAST_DROP) & 0xFF);
    TEST_ASSERT_TRUE(get(CAMERA_STATE, TAKEN) - taken >= 28);
    TEST_ASSERT_EQUAL(ON_TARGET, get(CAMERA_STATE, axes == 2 ? AZIMUTH_STATE + 1 : AZIMUTH_STATE) & 0xFF);
  }
}

/* The same camera finds the target again: its place is what counts. */
static void test_frames_count_again_when_they_agree(void) {
  enable(0, TRACKING);
  enable(PITCH, TRACKING);
  alternate_for(2000, 5e-3, 1, 0);
  world.azimuth_rad = joint_rad(0) + 3e-3;
  world.pitch_rad = joint_rad(1);
  follow_for(6000);
  TEST_ASSERT_EQUAL(ON_TARGET, state_of_tracking());
  CHECK_NEAR("azimuth, rad", world.azimuth_rad, joint_rad(0), 5e-6);
  TEST_ASSERT_EQUAL_HEX8(0, get(0x1001, 0));
}

/* The counter of a frame hands it over; its other objects, and those of the camera, only take a value. */
static void test_nothing_but_the_counter_hands_a_frame_over(void) {
  const uint32_t before = get(CAMERA_STATE, TAKEN);
  SET(FRAME, 1, 100);
  SET(FRAME, 2, 100);
  SET(FRAME, 3, 3000);
  SET(FRAME, 4, 90);
  SET_FLOAT(CAMERA, 1, 2e-6f);
  SET(CAMERA, 8, 100);
  wait_ms(2);
  TEST_ASSERT_EQUAL(before, get(CAMERA_STATE, TAKEN));
  TEST_ASSERT_EQUAL(0, get(CAMERA_STATE, DROPPED));
  SET(FRAME, 5, 77);
  wait_ms(2);
  TEST_ASSERT_EQUAL(before + 1, get(CAMERA_STATE, TAKEN));
}

static void test_a_reset_of_the_node_forgets_the_frames(void) {
  follow_for(500);
  world.counter--;
  send_frame(0.0, 0.0, 0.0, true);
  wait_ms(2);
  TEST_ASSERT_EQUAL(1, get(CAMERA_STATE, DROPPED));
  node.tracking.delay.offset_ticks = 7;
  nmt(0x82); /* of the communication */
  wait_ms(100);
  TEST_ASSERT_EQUAL(1, get(CAMERA_STATE, DROPPED));
  TEST_ASSERT_EQUAL(7, node.tracking.delay.offset_ticks);
  nmt(0x81);
  wait_ms(100);
  TEST_ASSERT_EQUAL(0, node.tracking.delay.offset_ticks);
  for (uint8_t sub = TAKEN; sub <= LAST_DROP; ++sub) {
    TEST_ASSERT_EQUAL(0, get(CAMERA_STATE, sub) & 0xFF);
  }
}

/* Half a second (2011:5) it goes on as estimated, then it stands; the target appears again 30 mrad on. */
static void test_a_lost_target_is_coasted_then_the_axis_stands_then_acquires_again(void) {
  world.rate_rad_s = 0.02;
  enable(0, TRACKING);
  follow_for(5000);
  TEST_ASSERT_EQUAL(ON_TARGET, state_of_tracking());
  world.shown = false;
  follow_for(300);
  CHECK_NEAR("coasts, rad", world.azimuth_rad, joint_rad(0), 25e-6); /* 20 of the last read */
  TEST_ASSERT_EQUAL(COASTING, state_of_tracking());
  follow_for(700);
  TEST_ASSERT_EQUAL(TARGET_LOST, state_of_tracking());
  CHECK_NEAR("stands, rad/s", 0.0, machine.axis[0].rate_rad_s, 1e-4);
  world.shown = true;
  follow_for(4000);
  CHECK_NEAR("again, rad", world.azimuth_rad, joint_rad(0), 2e-6);
  TEST_ASSERT_EQUAL(ON_TARGET, state_of_tracking());
}

/* 2011:6 = 1, for both axes together and for one alone. Mode -1 begins beside 0, the target is lost 100 mrad on: the
 * axis goes back no faster than 6081, and follows again when the target appears there. */
static void test_a_lost_target_is_left_for_where_the_mode_began(void) {
  for (int alone = 0; alone < 2; ++alone) {
    setUp();
    for (uint16_t axis = 0; axis <= PITCH; axis += PITCH) {
      SET(0x2011 + axis, 6, 1);
      SET(0x2070 + axis, 1, 1);
      SET(0x6081 + axis, 0, 50000); /* 50 mrad/s */
    }
    enable(0, PV);
    SET(0x60FF, 0, 100000);
    wait_ms(400);
    SET(0x60FF, 0, 0);
    wait_ms(500);
    const double from_rad = joint_rad(0);
    world.azimuth_rad = from_rad + 1e-3;
    world.rate_rad_s = 0.02;
    SET(0x6060, 0, (uint8_t)TRACKING);
    if (!alone) {
      enable(PITCH, TRACKING);
    }
    follow_for(5000);
    CHECK_AT_LEAST("followed, rad", 0.09, joint_rad(0) - from_rad);
    world.shown = false;
    double fastest_rad_s = 0.0;
    for (int i = 0; i < 6000; ++i) {
      follow_for(1);
      fastest_rad_s = fmax(fastest_rad_s, -(double)machine.axis[0].rate_rad_s);
    }
    CHECK_AT_LEAST("beside 0, rad", 0.02, from_rad);
    CHECK_NEAR("back, rad", from_rad, joint_rad(0), 20e-6);
    CHECK_NEAR("rad/s", 0.05, fastest_rad_s, 5e-3);
    TEST_ASSERT_EQUAL(TARGET_LOST, state_of_tracking());
    TEST_ASSERT_EQUAL_HEX32(0, get(0x6041, 0) & 0x1400);
    world.azimuth_rad = from_rad + 2e-3;
    world.shown = true;
    follow_for(3000);
    CHECK_NEAR("again, rad", world.azimuth_rad, joint_rad(0), 5e-6);
  }
}

/* A target that jumps asks for 0.6 rad/s at once: the rate changes by 6083 at most. */
static void test_the_rate_changes_by_the_profile_acceleration_at_most(void) {
  SET(0x6083, 0, 500000);
  enable(0, TRACKING);
  follow_for(1000);
  world.azimuth_rad += 30e-3;
  const speed_reference *reference = &node.board.app.axis[0].signals.reference;
  double before_rad_s = (double)reference->rate_rad_s;
  double steepest_rad_s2 = 0.0;
  double error_rad_s = 0.0;
  for (int i = 0; i < 1000; ++i) {
    follow_for(1);
    error_rad_s = fmax(error_rad_s, fabs((double)node.axis[0].monitor.swings.last_error_rad_s));
    steepest_rad_s2 = fmax(steepest_rad_s2, fabs((double)reference->rate_rad_s - before_rad_s) / 1e-3);
    before_rad_s = (double)reference->rate_rad_s;
  }
  CHECK_NEAR("rad/s^2", 0.5, steepest_rad_s2, 1e-3);
  CHECK_AT_MOST("for the search of oscillations, rad/s", 0.03, error_rad_s);
}

static void test_a_target_beyond_the_travel_is_followed_to_its_end(void) {
  SET(0x607D, 1, (uint32_t)-2000000);
  SET(0x607D, 2, 100000); /* 10 mrad */
  world.rate_rad_s = 0.02;
  enable(0, TRACKING);
  follow_for(1400);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  CHECK_AT_MOST("rad", 10.2e-3, joint_rad(0));
  CHECK_NEAR("at the end, rad", 10e-3, joint_rad(0), 0.3e-3);
  world.rate_rad_s = -0.05;
  follow_for(3000);
  CHECK_NEAR("back, rad", world.azimuth_rad, joint_rad(0), 20e-6);
}

/* A target stands until its picture has proven right, goes round the tracker, after 3 s at 0.3 rad/s, and leaves the
 * travel of +-200 degrees 13.1 s after its start. */
static void go_round(uint8_t turns_back) {
  SET(0x607D, 1, (uint32_t)-34906585);
  SET(0x607D, 2, 34906585);
  SET(TARGET_RETURN, TURN_BACK, turns_back);
  SET(0x6067, 0, 15000); /* 1.5 mrad: at 0.3 rad/s the target is 1.4 mrad ahead, and 60F4 says 1.1 */
  enable(0, TRACKING);
  enable(PITCH, TRACKING);
  world.azimuth_rad = 5e-3;
  follow_for(1000);
  for (int i = 0; i < 300; ++i) {
    world.rate_rad_s += 0.001;
    follow_for(10);
  }
  follow_for(9700);
  TEST_ASSERT_EQUAL(ON_TARGET, state_of_tracking());
  TEST_ASSERT_EQUAL(0, get(TARGET_RETURN, WRAP_STATE) & 0xFF);
  CHECK_NEAR("followed, rad", world.azimuth_rad, joint_rad(0), 1e-3);
  follow_for(700);
}

static void test_at_the_end_of_the_travel_the_azimuth_stays_as_delivered(void) {
  TEST_ASSERT_EQUAL(0, get(TARGET_RETURN, TURN_BACK) & 0xFF);
  go_round(0);
  TEST_ASSERT_EQUAL(1, get(TARGET_RETURN, WRAP_STATE) & 0xFF);
  TEST_ASSERT_EQUAL_HEX32(0xFFFF, get(TARGET_RETURN, BACK_IN) & 0xFFFF);
  world.shown = false;
  follow_for(4000);
  TEST_ASSERT_EQUAL(TARGET_LOST, state_of_tracking());
  CHECK_NEAR("at the end, rad", 3.4906585, joint_rad(0), 1e-3);
}

static void test_an_axis_that_leaves_at_the_end_of_the_travel_says_nothing_more_of_it(void) {
  go_round(0);
  TEST_ASSERT_EQUAL(1, get(TARGET_RETURN, WRAP_STATE) & 0xFF);
  TEST_ASSERT_TRUE(node.tracking.back.late);
  SET(0x6060, 0, PV);
  follow_for(5);
  TEST_ASSERT_EQUAL(0, get(TARGET_RETURN, WRAP_STATE) & 0xFF);
  TEST_ASSERT_EQUAL_HEX32(0, get(TARGET_RETURN, BACK_IN) & 0xFFFF);
  TEST_ASSERT_FALSE(node.tracking.back.late || node.tracking.back.known || node.tracking.back.ahead.running);
}

/* A turn is covered in 2 pi / (1 + 0.3) + (1 + 0.3) / 1 = 6.13 s at the limits of 1 rad/s and 1 rad/s^2. */
static void test_when_it_may_the_azimuth_turns_back_and_meets_the_target_again(void) {
  go_round(1);
  TEST_ASSERT_EQUAL(2, get(TARGET_RETURN, WRAP_STATE) & 0xFF);
  TEST_ASSERT_EQUAL(COASTING, state_of_tracking());
  follow_for(3000);
  const double back_in_s = 1e-3 * (double)(get(TARGET_RETURN, BACK_IN) & 0xFFFF);
  CHECK_NEAR("back in, s", 6.13 - 3.3, back_in_s, 0.4);
  world.azimuth_rad -= TURN_RAD; /* the same direction */
  double lost_s = 3.3;
  for (int i = 0; i < 3600; ++i) {
    follow_for(1);
    lost_s = fabs(world.azimuth_rad - joint_rad(0)) > 2e-3 ? 3.3 + 1e-3 * i : lost_s;
  }
  CHECK_NEAR("lost, s", 6.13, lost_s, 0.3);
  TEST_ASSERT_EQUAL(0, get(TARGET_RETURN, WRAP_STATE) & 0xFF);
  TEST_ASSERT_EQUAL(ON_TARGET, state_of_tracking());
}

/* The target is not where it is expected. */
static void test_after_a_turn_back_that_meets_nothing_the_axes_stand(void) {
  go_round(1);
  world.shown = false;
  follow_for(10000);
  TEST_ASSERT_EQUAL(TARGET_LOST, state_of_tracking());
  CHECK_NEAR("stands, rad/s", 0.0, machine.axis[0].rate_rad_s, 1e-4);
  TEST_ASSERT_EQUAL(0, get(TARGET_RETURN, WRAP_STATE) & 0xFF);
  CHECK_AT_MOST("less than a turn further, rad", 0.0, joint_rad(0));
}

static void test_a_turn_back_ends_when_it_is_no_longer_allowed(void) {
  go_round(1);
  follow_for(1000);
  world.shown = false;
  SET(TARGET_RETURN, TURN_BACK, 0);
  follow_for(2500);
  CHECK_NEAR("stands, rad/s", 0.0, machine.axis[0].rate_rad_s, 1e-4);
  CHECK_AT_LEAST("soon, rad", 1.0, joint_rad(0));
  TEST_ASSERT_EQUAL(TARGET_LOST, state_of_tracking());
}

static void test_leaving_the_mode_stops_along_the_ramp(void) {
  world.rate_rad_s = 0.05;
  enable(0, TRACKING);
  follow_for(4000);
  SET(0x60FF, 0, 0);
  SET(0x6060, 0, PV);
  follow_for(20);
  CHECK_AT_MOST("1 rad/s^2, rad/s", 0.045, machine.axis[0].rate_rad_s);
  CHECK_AT_MOST("no step, rad/s", machine.axis[0].rate_rad_s, 0.02);
  follow_for(500);
  CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 1e-4);
  TEST_ASSERT_EQUAL(NOT_TRACKING, state_of_tracking());
}

static void test_bad_frames_are_counted_and_do_nothing(void) {
  enable(0, TRACKING);
  follow_for(500);
  TEST_ASSERT_EQUAL(0, get(CAMERA_STATE, MISSED));
  world.counter = (uint8_t)(world.counter + 2);
  follow_for(2 * FRAME_MS);
  TEST_ASSERT_EQUAL(2, get(CAMERA_STATE, MISSED));
  const uint32_t taken = get(CAMERA_STATE, TAKEN);
  give(FRAME_ID, 8, (const uint8_t[]){0xFF, 0x7F, 0, 0, 0, 0, 90, world.counter}); /* again */
  wait_ms(1);
  TEST_ASSERT_EQUAL(1, get(CAMERA_STATE, LAST_DROP) & 0xFF);
  give(FRAME_ID, 8, (const uint8_t[]){0xFF, 0x7F, 0, 0, 0xFF, 0xFF, 90, (uint8_t)(world.counter + 1)}); /* 655 ms old */
  wait_ms(1);
  TEST_ASSERT_EQUAL(2, get(CAMERA_STATE, LAST_DROP) & 0xFF);
  give(FRAME_ID, 8, (const uint8_t[]){0xFF, 0x7F, 0, 0, 0, 0, 101, (uint8_t)(world.counter + 1)}); /* quality */
  wait_ms(1);
  TEST_ASSERT_EQUAL(4, get(CAMERA_STATE, LAST_DROP) & 0xFF);
  SET(CAMERA, TIME_OF_EXPOSURE, 1); /* stamps of the node's clock, 100 counts a ms: exposed in 20 ms */
  const uint32_t later = (get(0x1013, 0) + 20000u) / 10u;
  give(FRAME_ID, 8,
       (const uint8_t[]){0xFF, 0x7F, 0, 0, (uint8_t)later, (uint8_t)(later >> 8), 90, (uint8_t)(world.counter + 1)});
  wait_ms(1);
  TEST_ASSERT_EQUAL(3, get(CAMERA_STATE, LAST_DROP) & 0xFF);
  TEST_ASSERT_EQUAL(4, get(CAMERA_STATE, DROPPED));
  TEST_ASSERT_EQUAL(taken, get(CAMERA_STATE, TAKEN));
  CHECK_NEAR("rad", 0.0, joint_rad(0), 2e-6);
}

/* Of messages in one ms the second one counts, in place of the first: to look at more would make the tick late. The
 * third has no target: it is refused, and takes none from the second. */
static void test_a_message_that_is_refused_changes_nothing_of_the_one_before(void) {
  enable(PITCH, TRACKING);
  for (unsigned message = 1; message <= 3; ++message) {
    send_frame(0.0, 3e-3, 0.0, message < 3);
  }
  wait_ms(1);
  TEST_ASSERT_EQUAL(ACQUIRING, get(CAMERA_STATE, AZIMUTH_STATE + 1) & 0xFF);
  TEST_ASSERT_EQUAL(1, get(CAMERA_STATE, TAKEN));
  TEST_ASSERT_EQUAL(2, get(CAMERA_STATE, DROPPED));
  TEST_ASSERT_EQUAL(CAMERA_NOT_NEWER, get(CAMERA_STATE, LAST_DROP) & 0xFF);
}

static void test_the_pitch_follows_alone(void) {
  world.pitch_rad = 4e-3;
  world.azimuth_rad = 5e-3;
  enable(PITCH, TRACKING);
  follow_for(3000);
  CHECK_NEAR("pitch, rad", world.pitch_rad, joint_rad(1), 2e-6);
  CHECK_NEAR("azimuth, rad", 0.0, joint_rad(0), 1e-6);
}

/* An axis that follows alone: to 1 rad/s (2010:2) when its picture has proven right on a target that stands. */
static void test_an_axis_alone_is_as_fast_as_its_target_when_the_picture_is_right(void) {
  SET(0x6067, 0, 15000); /* 1.5 mrad */
  enable(0, TRACKING);
  follow_for(2000);
  for (int i = 0; i < 300; ++i) {
    world.rate_rad_s += 0.001;
    follow_for(10);
  }
  follow_for(4000);
  CHECK_NEAR("rad/s", 0.3, machine.axis[0].rate_rad_s, 5e-3);
  CHECK_NEAR("rad", world.azimuth_rad, joint_rad(0), 1e-4);
  TEST_ASSERT_EQUAL(ON_TARGET, state_of_tracking());
}

/* The pitch goes 20 mrad up to its target. Meanwhile a master turns the azimuth at 0.25 rad/s across it: the target
 * goes sideways in the picture, but the azimuth does not follow it. */
static void test_an_axis_that_does_not_track_shows_nothing_of_the_picture(void) {
  world.pitch_rad = 20e-3;
  SET(0x6083, 0, 10000000);
  enable(0, PV);
  enable(PITCH, TRACKING);
  world.azimuth_rad = joint_rad(0) + 30e-3;
  SET(0x60FF, 0, 250000);
  follow_for(240);
  SET(0x60FF, 0, 0);
  follow_for(1500);
  TEST_ASSERT_EQUAL(PICTURE_RIGHT, state_of_picture());
  CHECK_NEAR("roll, rad", 0.0, 1e-4 * (int16_t)get(CAMERA_STATE, PICTURE + 1), 0.05);
  CHECK_NEAR("pitch, rad", world.pitch_rad, joint_rad(1), 1e-4);
}

static void start_with_pitch_at(double turns) {
  rigid_machine_init(&machine);
  machine.axis[1].turns = turns;
  TEST_ASSERT_TRUE(rigid_machine_start_node(&machine, &node, NODE_ID, (can_sender){node_bench_send, NULL}, NULL));
  wait_ms(8);
  map_camera();
  SET(0x6007, 0, 0);
  SET(0x6807, 0, 0);
  nmt(0x01);
  world.pitch_rad = joint_rad(1);
}

/* 80 degrees up, behind a target at 0.5 rad/s, which turns the image by 0.49 rad/s; the pitch has 20 mrad to go. The
 * missing roll is 0: each picture counts as it was turned at its exposure. */
static void test_near_the_zenith_a_right_picture_is_found_right(void) {
  for (unsigned age_ms = 0; age_ms <= AGE_MS; age_ms += AGE_MS) {
    setUp();
    world.age_ms = age_ms;
    start_with_pitch_at(80.0 / 360.0);
    enable(0, PV);
    enable(PITCH, PV);
    SET(0x60FF, 0, 500000);
    wait_ms(1000);
    world.azimuth_rad = joint_rad(0);
    world.pitch_rad = joint_rad(1) + 20e-3;
    world.rate_rad_s = 0.5;
    follow_for(200);
    SET(0x6060, 0, (uint8_t)TRACKING);
    SET(0x6860, 0, (uint8_t)TRACKING);
    double roll_rad = 0.0;
    for (int i = 0; i < 10; ++i) {
      follow_for(100);
      roll_rad = fmax(roll_rad, fabs(1e-4 * (int16_t)get(CAMERA_STATE, PICTURE + 1)));
    }
    LOG_VALUE("largest roll, rad", roll_rad);
    CHECK_AT_MOST("rad", 0.1, roll_rad);
    TEST_ASSERT_EQUAL(PICTURE_RIGHT, state_of_picture());
    TEST_ASSERT_EQUAL(TRACKING_TOGETHER, node.tracking.phase);
  }
}

/* The pitch body adds 3 kg m^2 to the azimuth's inertia at pitch 0. At 45 degrees and 0.3 rad/s its centrifugal torque
 * on the pitch is 3 kg m^2 * sin(45) * cos(45) * (0.3 rad/s)^2. */
static void test_the_centrifugal_torque_is_given_to_the_pitch(void) {
  start_with_pitch_at(1.0 / 8.0);
  SET(0x3040, 1, 0x6E65706F);
  SET_FLOAT(0x2056, 2, 3.0f);
  SET(0x2070, 1, 1);
  enable(0, TRACKING);
  enable(PITCH, TRACKING);
  follow_for(2000);
  for (int i = 0; i < 300; ++i) {
    world.rate_rad_s += 0.001;
    follow_for(10);
  }
  follow_for(1000);
  CHECK_NEAR("azimuth, rad/s", 0.3, machine.axis[0].rate_rad_s, 5e-3);
  CHECK_NEAR("pitch, Nm", 3.0 * 0.5 * 0.3 * 0.3, node.board.app.axis[1].added_nm, 0.01);
}

/* The sender's clock is the node's: the age needs no statement. */
static void test_a_stamp_of_the_nodes_clock_gives_the_age(void) {
  SET(CAMERA, TIME_OF_EXPOSURE, 1);
  world.stamps = true;
  world.rate_rad_s = 0.02;
  enable(0, TRACKING);
  enable(PITCH, TRACKING);
  follow_for(5000);
  CHECK_NEAR("rad", world.azimuth_rad, joint_rad(0), 2e-6);
  TEST_ASSERT_EQUAL(AGE_MS, get(CAMERA_STATE, AGE_IN_USE) & 0xFF);
  TEST_ASSERT_EQUAL(1, get(STROBE, IN_USE) & 0xFF);
  const uint32_t clock_us = get(0x1013, 0); /* the same clock, in us */
  TEST_ASSERT_UINT_WITHIN(2000, node.tracking.clock.offset_us + machine.clock_us, clock_us);
  const uint32_t before = get(CAMERA_STATE, CLOCK) & 0xFFFF;
  wait_ms(99);
  TEST_ASSERT_EQUAL(100 * 100, ((get(CAMERA_STATE, CLOCK) & 0xFFFF) - before) & 0xFFFF);
}

/* Nobody has set the clock since: the stamp has one reading. */
static void test_a_frame_that_was_exposed_when_the_node_started_counts(void) {
  SET(CAMERA, TIME_OF_EXPOSURE, 1);
  const uint32_t since_start_ms = machine.clock_us / 1000;
  CHECK_AT_MOST("ms", 100.0, since_start_ms);
  give(FRAME_ID, 8, (const uint8_t[]){0, 0, 0, 0, 0, 0, 90, ++world.counter});
  wait_ms(1);
  TEST_ASSERT_EQUAL(1, get(CAMERA_STATE, TAKEN));
  TEST_ASSERT_UINT_WITHIN(1, since_start_ms, get(CAMERA_STATE, AGE_IN_USE) & 0xFF);
}

/* 1013 set back by 100 ms: a stamp of 1 ms later is one of 99 ms before, too, whatever is added to it. */
static void test_a_stamp_with_two_readings_is_told(void) {
  SET(CAMERA, TIME_OF_EXPOSURE, 1);
  SET(CAMERA, 8, 600);
  wait_ms(500);
  SET(0x1013, 0, get(0x1013, 0) - 100000u);
  wait_ms(10);
  const uint16_t stamp = (uint16_t)node.tracking.objects.clock;
  give(FRAME_ID, 8, (const uint8_t[]){0, 0, 0, 0, (uint8_t)stamp, (uint8_t)(stamp >> 8), 90, ++world.counter});
  wait_ms(2);
  TEST_ASSERT_EQUAL(CAMERA_CLOCK_SET, get(CAMERA_STATE, LAST_DROP) & 0xFF);
}

static void test_the_strobe_gives_the_age_and_without_it_the_statement_counts(void) {
  SET(CAMERA, TIME_OF_EXPOSURE, 2);
  SET(STROBE, 1, 2500);
  SET(STROBE, 2, 3500);
  SET(STROBE, 3, 500);
  world.misstated_ms = 6;
  world.strobes = true;
  enable(0, TRACKING);
  follow_for(2000);
  TEST_ASSERT_EQUAL(2, get(STROBE, IN_USE) & 0xFF);
  TEST_ASSERT_EQUAL(AGE_MS, get(CAMERA_STATE, AGE_IN_USE) & 0xFF);
  TEST_ASSERT_EQUAL(AGE_MS * 100, get(STROBE, AGE_10US) & 0xFFFF);
  const uint32_t edges = get(STROBE, EDGES);
  TEST_ASSERT_EQUAL(100, edges);
  TEST_ASSERT_INT_WITHIN(6, edges, (int)get(STROBE, PAIRED));
  TEST_ASSERT_EQUAL(world.strobe_us, get(STROBE, STROBE_TIME));
  const uint32_t unpaired = get(STROBE, UNPAIRED);
  TEST_ASSERT_INT_WITHIN(5, 0, (int)unpaired);
  world.strobes = false;
  follow_for(400);
  TEST_ASSERT_EQUAL(0, get(STROBE, IN_USE) & 0xFF);
  TEST_ASSERT_EQUAL(AGE_MS + 6, get(CAMERA_STATE, AGE_IN_USE) & 0xFF);
  TEST_ASSERT_EQUAL(1, get(STROBE, REFUSAL) & 0xFF);
  TEST_ASSERT_EQUAL(edges, get(STROBE, EDGES));
  TEST_ASSERT_INT_WITHIN(2, (int)unpaired + 19, (int)get(STROBE, UNPAIRED));
  TEST_ASSERT_EQUAL(0, get(STROBE, ADDITIONAL));
  world.strobes = true;
  follow_for(1000);
  TEST_ASSERT_EQUAL(2, get(STROBE, IN_USE) & 0xFF);
  TEST_ASSERT_EQUAL(20, get(STROBE, MISSING));
  machine.strobes = (hal_strobes){.count = 1, .at_us = {machine.clock_us - 500u}};
  wait_ms(1);
  follow_for(1000);
  TEST_ASSERT_EQUAL(1, get(STROBE, ADDITIONAL));
  machine.strobes = (hal_strobes){.flooded = true};
  wait_ms(2);
  TEST_ASSERT_EQUAL(1, get(STROBE, FLOODS));
}

/* The edge comes in the same ms as its frame. */
static void test_a_strobe_is_paired_with_a_frame_right_behind_it(void) {
  SET(CAMERA, TIME_OF_EXPOSURE, 2);
  SET(STROBE, 1, 0);
  SET(STROBE, 2, 200);
  SET(STROBE, 3, 0);
  for (int frame = 0; frame < 20; ++frame) {
    machine.strobes = (hal_strobes){.count = 1, .at_us = {machine.clock_us - 100u}};
    send_frame(0.0, 0.0, 0.0, true);
    wait_ms(FRAME_MS);
  }
  TEST_ASSERT_TRUE(get(STROBE, PAIRED) >= 15);
  TEST_ASSERT_EQUAL(2, get(STROBE, IN_USE) & 0xFF);
}

/* 20 urad at 9 Hz. */
static void test_the_dither_of_the_elevation_shows_the_delay(void) {
  SET_FLOAT(DELAY, 2, 2e-5f);
  SET_FLOAT(DELAY, 3, 9.0f);
  world.misstated_ms = 6;
  enable(0, TRACKING);
  enable(PITCH, TRACKING);
  follow_for(2000);
  TEST_ASSERT_EQUAL_HEX32(0xFFFF, get(DELAY, HALF_WIDTH) & 0xFFFF);
  SET(DELAY, DITHER_S, 30);
  double lowest_rad = 0.0;
  double highest_rad = 0.0;
  for (int ms = 0; ms < 10000; ++ms) {
    follow_for(1);
    lowest_rad = fmin(lowest_rad, joint_rad(1));
    highest_rad = fmax(highest_rad, joint_rad(1));
  }
  CHECK_NEAR("elevation, rad", 4e-5, highest_rad - lowest_rad, 2e-5);
  TEST_ASSERT_INT_WITHIN(1, 20, (int)(get(DELAY, DITHER_S) & 0xFF));
  CHECK_NEAR("error, 10 us", -600.0, (int16_t)get(DELAY, DELAY_ERROR), 60.0);
  CHECK_AT_MOST("half width, 10 us", 100.0, get(DELAY, HALF_WIDTH) & 0xFFFF);
  TEST_ASSERT_EQUAL(0, get(DELAY, CORRECTION) & 0xFF); /* reported only */
  SET(DELAY, 1, 2);
  follow_for(1000);
  TEST_ASSERT_INT_WITHIN(1, -6, (int8_t)get(DELAY, CORRECTION));
  TEST_ASSERT_INT_WITHIN(1, AGE_MS + 6, (int)(get(CAMERA_STATE, AGE_IN_USE) & 0xFF)); /* as stated */
  SET(0x6060, 0, PV);
  follow_for(10);
  TEST_ASSERT_EQUAL(0, get(DELAY, DITHER_S) & 0xFF); /* both axes must track */
  TEST_ASSERT_INT_WITHIN(1, -6, (int8_t)get(DELAY, CORRECTION));
  SET_FLOAT(DELAY, 8, 1e-6f);       /* 3073:8 */
  SET(CAMERA, TIME_OF_EXPOSURE, 0); /* as before: of no other object of 3071 */
  wait_ms(2);
  TEST_ASSERT_INT_WITHIN(1, -6, (int8_t)get(DELAY, CORRECTION));
  SET(CAMERA, 8, 600); /* the delay is stated now: what was measured is wrong */
  wait_ms(2);
  TEST_ASSERT_EQUAL(0, get(DELAY, CORRECTION) & 0xFF);
}

static void test_settings_of_the_camera_are_kept_in_range_and_stored(void) {
  TEST_ASSERT_EQUAL_HEX32(0x06090031, set_float(CAMERA, 1, 2e-3f));
  TEST_ASSERT_EQUAL_HEX32(0x06090031, set(CAMERA, 5, 4));
  SET_FLOAT(CAMERA, 1, 2e-6f);
  SET_FLOAT(CAMERA, 2, 0.1f);
  SET(0x1011, 1, 0x64616F6C);
  nmt(0x82); /* of the communication: what is set stays, and is no default */
  wait_ms(300);
  CHECK_NEAR("rad", 2e-6, get_float(CAMERA, 1), 1e-12);
  nmt(0x81);
  wait_ms(300);
  CHECK_NEAR("rad", 1e-6, get_float(CAMERA, 1), 1e-12);
}

/* A slip ring: no end stop, no 607D; the position wraps at 32 turns (607B). */
static void remove_the_travel(void) {
  SET(0x3040, 1, 0x6E65706F); /* "open" */
  SET(0x607D, 1, 0);
  SET(0x607D, 2, 0);
  SET_FLOAT(0x2060, 9, 0.0f);
  SET_FLOAT(0x2060, 10, 0.0f);
  SET_FLOAT(0x2060, 21, 1.0f);
  TEST_ASSERT_EQUAL_INT32(2010619298, (int32_t)get(0x607B, 2));
}

/* In pv at 1 rad/s to 0.1 turns before it. */
static void turn_to_the_wrap(int side) {
  remove_the_travel();
  enable(0, PV);
  SET(0x607F, 0, 1000000);
  SET(0x60FF, 0, (uint32_t)(side * 1000000));
  while (fabs(machine.axis[0].turns) < 31.82) {
    wait_ms(1);
  }
  SET(0x60FF, 0, 0);
  wait_ms(2000);
  world.azimuth_rad = joint_rad(0) + 1e-3 * side;
}

/* Of 6064, from the joint's true angle at the tick's begin. */
static double counts_off(double true_turns) {
  const double range_turns = 64.0;
  const double shown_turns = (double)node.axis[0].objects.position.actual * 1e-7 / TURN_RAD;
  return 1e7 * TURN_RAD * remainder(shown_turns - true_turns, range_turns);
}

static bool is_beyond_the_wrap(void) { return fabs(machine.axis[0].turns) > 32.0; }

/* At 0.08 rad/s through the wrap, from 3 s on, when the axis has caught up with its target. */
static void follow_through_the_wrap(double rate_rad_s) {
  const bool begins_beyond = is_beyond_the_wrap();
  double error_rad = 0.0;
  double counts = 0.0;
  world.rate_rad_s = rate_rad_s;
  follow_for(3000);
  TEST_ASSERT_EQUAL(begins_beyond, is_beyond_the_wrap());
  for (int ms = 0; ms < 8000; ++ms) {
    const double before_turns = machine.axis[0].turns;
    follow_for(1);
    error_rad = fmax(error_rad, fabs(world.azimuth_rad - joint_rad(0)));
    counts = fmax(counts, fabs(counts_off(before_turns)));
  }
  TEST_ASSERT_EQUAL(!begins_beyond, is_beyond_the_wrap());
  TEST_ASSERT_EQUAL(ON_TARGET, state_of_tracking());
  LOG_VALUE("worst error, rad", error_rad);
  LOG_VALUE("6064, worst counts off", counts);
  CHECK_AT_MOST("error, with the rest of the turn-round, rad", 5e-5, error_rad);
  CHECK_AT_MOST("6064, counts off", 2.0, counts);
}

/* In both directions, and there and back; the azimuth alone, then with the pitch. */
static void test_a_target_is_followed_across_the_wrap_of_the_position(void) {
  for (int row = 0; row < 4; ++row) {
    const int side = row % 2 == 0 ? 1 : -1;
    setUp();
    turn_to_the_wrap(side);
    SET(0x6060, 0, (uint8_t)TRACKING);
    if (row >= 2) {
      enable(PITCH, TRACKING);
    }
    follow_for(2000); /* it stands until its picture has proven right */
    follow_through_the_wrap(0.08 * side);
    follow_through_the_wrap(-0.08 * side);
    TEST_ASSERT_EQUAL_HEX8(0, get(0x1001, 0));
  }
}

static void test_a_target_is_followed_after_many_turns(void) {
  static const int starts[] = {33, -33, 34, -34, 68, -68, 1000, -1000};
  for (unsigned i = 0; i < sizeof starts / sizeof starts[0]; ++i) {
    setUp();
    remove_the_travel();
    machine.axis[0].turns += starts[i];
    drive_axis_shift(&node.axis[0].drive, starts[i]);
    world.azimuth_rad = joint_rad(0) + 1e-3;
    enable(0, TRACKING);
    world.rate_rad_s = 0.08;
    follow_for(4000);
    const double before_turns = machine.axis[0].turns;
    follow_for(1);
    CHECK_NEAR("azimuth, rad", world.azimuth_rad, joint_rad(0), 5e-5);
    CHECK_NEAR("6064, counts off", 0.0, counts_off(before_turns), 2.0);
    TEST_ASSERT_EQUAL(ON_TARGET, state_of_tracking());
    TEST_ASSERT_EQUAL_HEX32(1u << 14, get(0x6041, 0) & 1u << 14);
    TEST_ASSERT_EQUAL_HEX8(0, get(0x1001, 0));
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_mode_is_listed_and_frames_move_nothing_in_another_mode);
  RUN_TEST(test_both_axes_follow_the_target_of_the_frames);
  RUN_TEST(test_a_target_outside_the_window_is_not_on_target);
  RUN_TEST(test_a_lost_heartbeat_stops_an_axis_that_the_camera_leads);
  RUN_TEST(test_axes_that_move_with_the_target_do_not_pause_when_tracking_begins);
  RUN_TEST(test_a_fast_slew_before_leads_no_axis_astray);
  RUN_TEST(test_a_target_that_swings_is_not_on_target);
  RUN_TEST(test_a_picture_upside_down_stops_the_axes_that_follow_it);
  RUN_TEST(test_a_picture_is_right_after_1500_ms_on_the_target);
  RUN_TEST(test_a_target_that_vanishes_before_its_picture_is_right_is_lost_sooner);
  RUN_TEST(test_a_coasting_time_that_only_the_azimuth_has_got_counts_for_both);
  RUN_TEST(test_axes_track_together_only_with_the_predictive_loop_of_both);
  RUN_TEST(test_new_gains_of_either_axis_are_those_that_it_will_track_with);
  RUN_TEST(test_an_axis_goes_on_alone_when_the_other_one_leaves);
  RUN_TEST(test_an_axis_that_is_left_alone_coasts_as_long_as_before);
  RUN_TEST(test_a_lost_target_is_coasted_then_the_axis_stands_then_acquires_again);
  RUN_TEST(test_a_lost_target_is_left_for_where_the_mode_began);
  RUN_TEST(test_a_frozen_picture_stops_the_axis_that_it_drives);
  RUN_TEST(test_the_place_of_a_frozen_picture_is_kept_until_its_sender_was_silent);
  RUN_TEST(test_a_counter_that_stands_is_told);
  RUN_TEST(test_a_camera_that_is_silent_while_an_axis_turns_is_not_frozen);
  RUN_TEST(test_a_sender_may_begin_anew_as_often_as_it_likes_before_tracking);
  RUN_TEST(test_errors_that_jump_to_and_fro_do_not_turn_the_axes);
  RUN_TEST(test_axes_that_begin_together_go_to_where_the_target_was_seen);
  RUN_TEST(test_of_two_cameras_at_once_the_axes_follow_the_first);
  RUN_TEST(test_a_second_camera_that_is_just_ahead_takes_the_lead_and_is_told);
  RUN_TEST(test_frames_that_are_sent_twice_are_counted_only);
  RUN_TEST(test_a_single_frame_of_something_else_moves_no_axis);
  RUN_TEST(test_frames_count_again_when_they_agree);
  RUN_TEST(test_nothing_but_the_counter_hands_a_frame_over);
  RUN_TEST(test_a_reset_of_the_node_forgets_the_frames);
  RUN_TEST(test_the_rate_changes_by_the_profile_acceleration_at_most);
  RUN_TEST(test_a_target_beyond_the_travel_is_followed_to_its_end);
  RUN_TEST(test_at_the_end_of_the_travel_the_azimuth_stays_as_delivered);
  RUN_TEST(test_an_axis_that_leaves_at_the_end_of_the_travel_says_nothing_more_of_it);
  RUN_TEST(test_when_it_may_the_azimuth_turns_back_and_meets_the_target_again);
  RUN_TEST(test_after_a_turn_back_that_meets_nothing_the_axes_stand);
  RUN_TEST(test_a_turn_back_ends_when_it_is_no_longer_allowed);
  RUN_TEST(test_a_target_is_followed_across_the_wrap_of_the_position);
  RUN_TEST(test_a_target_is_followed_after_many_turns);
  RUN_TEST(test_leaving_the_mode_stops_along_the_ramp);
  RUN_TEST(test_bad_frames_are_counted_and_do_nothing);
  RUN_TEST(test_a_message_that_is_refused_changes_nothing_of_the_one_before);
  RUN_TEST(test_the_pitch_follows_alone);
  RUN_TEST(test_an_axis_alone_is_as_fast_as_its_target_when_the_picture_is_right);
  RUN_TEST(test_an_axis_that_does_not_track_shows_nothing_of_the_picture);
  RUN_TEST(test_near_the_zenith_a_right_picture_is_found_right);
  RUN_TEST(test_the_centrifugal_torque_is_given_to_the_pitch);
  RUN_TEST(test_a_stamp_of_the_nodes_clock_gives_the_age);
  RUN_TEST(test_a_frame_that_was_exposed_when_the_node_started_counts);
  RUN_TEST(test_a_stamp_with_two_readings_is_told);
  RUN_TEST(test_the_strobe_gives_the_age_and_without_it_the_statement_counts);
  RUN_TEST(test_a_strobe_is_paired_with_a_frame_right_behind_it);
  RUN_TEST(test_the_dither_of_the_elevation_shows_the_delay);
  RUN_TEST(test_settings_of_the_camera_are_kept_in_range_and_stored);
  return UNITY_END();
}
