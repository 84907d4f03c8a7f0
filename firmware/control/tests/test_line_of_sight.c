/* SPDX-License-Identifier: Apache-2.0 */
/* Geometry of the line of sight, against rotation matrices in double. */
#include "control/line_of_sight.h"

#include "base/scalar.h"
#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

#define TURN32_PER_RAD (4294967296.0 / 6.283185307179586)
#define DEG (3.141592653589793 / 180.0)

typedef struct {
  double at[3];
} vector;

/* Azimuth about z, then pitch about -y: what the joints make of a direction of the camera (forward, c, e). */
static vector turned(double azimuth_rad, double pitch_rad, vector v) {
  const double cp = cos(pitch_rad);
  const double sp = sin(pitch_rad);
  const double ca = cos(azimuth_rad);
  const double sa = sin(azimuth_rad);
  const vector raised = {{cp * v.at[0] - sp * v.at[2], v.at[1], sp * v.at[0] + cp * v.at[2]}};
  return (vector){{ca * raised.at[0] - sa * raised.at[1], sa * raised.at[0] + ca * raised.at[1], raised.at[2]}};
}

static double angle_between(vector a, vector b) {
  double cross = 0.0;
  double dot = 0.0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const double part = a.at[i] * b.at[j] - a.at[j] * b.at[i];
    cross += part * part;
    dot += a.at[i] * b.at[i];
  }
  return atan2(sqrt(cross), dot);
}

static rotation pitch_of(double pitch_rad) {
  return rotation_of((angle_turn32)(int64_t)llround(pitch_rad * TURN32_PER_RAD));
}

/* The angle between the target and the line of sight, after both joints have turned by what was computed. */
static double missed_by(double pitch_rad, image_vector error) {
  const joint_vector joints = line_of_sight_joint_errors(pitch_of(pitch_rad), error);
  const vector target = turned(0.0, pitch_rad, (vector){{1.0, (double)error.x, (double)error.y}});
  const vector los = turned((double)joints.azimuth, pitch_rad + (double)joints.pitch, (vector){{1.0, 0.0, 0.0}});
  return angle_between(target, los);
}

static void test_after_turning_by_the_joint_errors_the_line_of_sight_meets_the_target(void) {
  random_source random = {1};
  double worst = 0.0;
  for (int i = 0; i < random_cases(200000); ++i) {
    const double pitch_rad = random_uniform(&random, -89.0 * DEG, 89.0 * DEG);
    const image_vector error = {(float)random_uniform(&random, -0.02, 0.02),
                                (float)random_uniform(&random, -0.02, 0.02)};
    worst = fmax(worst, missed_by(pitch_rad, error));
  }
  LOG_VALUE("largest miss within 20 mrad and 89 degrees, rad", worst);
  CHECK_AT_MOST("miss, rad", 2e-8, worst);
}

static void test_it_is_exact_at_the_zenith_and_beyond_it_and_far_from_the_centre(void) {
  static const double pitches_deg[] = {89.9, 89.999, 90.0, 90.1, 95.0, 120.0, -90.0};
  static const image_vector errors[] = {{3e-3f, 3e-3f}, {-3e-3f, 1e-5f}, {0.0f, -2e-3f}, {0.4f, -0.3f}, {-1.0f, 1.0f}};
  for (unsigned i = 0; i < sizeof pitches_deg / sizeof pitches_deg[0]; ++i) {
    for (unsigned k = 0; k < sizeof errors / sizeof errors[0]; ++k) {
      CHECK_AT_MOST("miss, rad", 3e-7, missed_by(pitches_deg[i] * DEG, errors[k]));
    }
  }
}

static double dot(vector a, vector b) { return a.at[0] * b.at[0] + a.at[1] * b.at[1] + a.at[2] * b.at[2]; }

static vector cross(vector a, vector b) {
  return (vector){{a.at[1] * b.at[2] - a.at[2] * b.at[1], a.at[2] * b.at[0] - a.at[0] * b.at[2],
                   a.at[0] * b.at[1] - a.at[1] * b.at[0]}};
}

/* A vector, carried along the great circle: turned about the axis that is perpendicular to it (Rodrigues). */
static vector carried(vector from, vector to, vector v) {
  const double angle_rad = angle_between(from, to);
  vector axis = cross(from, to);
  const double size = sqrt(dot(axis, axis));
  for (int k = 0; k < 3; ++k) {
    axis.at[k] /= size;
  }
  const vector across = cross(axis, v);
  const double along = dot(axis, v) * (1.0 - cos(angle_rad));
  for (int k = 0; k < 3; ++k) {
    v.at[k] = v.at[k] * cos(angle_rad) + across.at[k] * sin(angle_rad) + axis.at[k] * along;
  }
  return v;
}

static void test_a_vector_that_came_along_the_great_circle_is_turned_into_the_image_axes_at_the_target(void) {
  static const double pitches_deg[] = {0.0, 45.0, 85.0, 89.5, 90.0, 100.0, -60.0};
  static const image_vector errors[] = {{1e-4f, 1e-4f}, {-0.02f, 0.01f}, {0.3f, -0.4f}, {-1.0f, 1.0f}};
  for (unsigned i = 0; i < sizeof pitches_deg / sizeof pitches_deg[0]; ++i) {
    for (unsigned k = 0; k < sizeof errors / sizeof errors[0]; ++k) {
      const double pitch_rad = pitches_deg[i] * DEG;
      const line_of_sight_turn turn = line_of_sight_turn_to(pitch_of(pitch_rad), errors[k]);
      const vector target = turned(0.0, pitch_rad, (vector){{1.0, (double)errors[k].x, (double)errors[k].y}});
      const vector axis = carried(turned(0.0, pitch_rad, (vector){{1.0, 0.0, 0.0}}), target,
                                  turned(0.0, pitch_rad, (vector){{0.0, 1.0, 0.0}}));
      const double azimuth_rad = atan2(target.at[1], target.at[0]);
      const double rise_rad = atan2(target.at[2], hypot(target.at[0], target.at[1]));
      CHECK_NEAR("cosine of the pitch", cos(rise_rad), turn.pitch.cosine, 4e-7);
      CHECK_NEAR("sine of the pitch", sin(rise_rad), turn.pitch.sine, 4e-7);
      const double across = dot(axis, turned(azimuth_rad, rise_rad, (vector){{0.0, 1.0, 0.0}}));
      const double up = dot(axis, turned(azimuth_rad, rise_rad, (vector){{0.0, 0.0, 1.0}}));
      const double horizontal = hypot(target.at[0], target.at[1]); /* the axes there turn fast near the zenith */
      CHECK_NEAR("cosine of the image", across, turn.image.cosine, 1e-6 + 2e-7 / horizontal);
      CHECK_NEAR("sine of the image", up, turn.image.sine, 1e-6 + 2e-7 / horizontal);
    }
  }
}

static void test_in_the_zenith_the_image_axes_stay(void) {
  const line_of_sight_turn turn = line_of_sight_turn_to((rotation){.sine = 1.0f, .cosine = 0.0f}, (image_vector){0});
  CHECK_SAME("cosine of the image", 1.0, turn.image.cosine);
  CHECK_SAME("sine of the image", 0.0, turn.image.sine);
  CHECK_SAME("cosine of the pitch", 0.0, turn.pitch.cosine);
}

static void test_the_secant_of_the_pitch_would_miss_by_degrees_where_this_does_not(void) {
  const double pitch_rad = 89.0 * DEG;
  const image_vector error = {3e-3f, 3e-3f};
  const joint_vector joints = line_of_sight_joint_errors(pitch_of(pitch_rad), error);
  const double secant_rad = (double)error.x / cos(pitch_rad);
  CHECK_NEAR("difference in azimuth, degrees", 1.88, ((double)joints.azimuth - secant_rad) / DEG, 0.02);
}

static void test_small_errors_keep_all_digits(void) {
  const joint_vector joints = line_of_sight_joint_errors(pitch_of(0.7), (image_vector){1e-9f, -2e-9f});
  CHECK_RELATIVE("azimuth", 1e-9 / cos(0.7), joints.azimuth, 5e-7);
  CHECK_RELATIVE("pitch", -2e-9, joints.pitch, 5e-7);
}

static void test_a_target_in_the_zenith_leaves_the_azimuth(void) {
  const double pitch_rad = 80.0 * DEG;
  const joint_vector joints =
      line_of_sight_joint_errors(pitch_of(pitch_rad), (image_vector){0.0f, (float)tan(10.0 * DEG)});
  CHECK_NEAR("pitch, degrees", 10.0, (double)joints.pitch / DEG, 1e-4);
  TEST_ASSERT_TRUE(isfinite(joints.azimuth));
}

static void test_a_camera_that_is_rolled_and_offset_gives_errors_along_cross_elevation_and_elevation(void) {
  const camera_mounting mounting = {.roll_rad = -0.4f, .boresight = {1e-3f, -2e-3f}};
  const camera_alignment alignment = camera_align(&mounting);
  const image_vector found = camera_error(&alignment, (image_vector){5e-3f, 2e-3f});
  CHECK_NEAR("x", cos(-0.4) * 5e-3 - sin(-0.4) * 2e-3 - 1e-3, found.x, 5e-9);
  CHECK_NEAR("y", sin(-0.4) * 5e-3 + cos(-0.4) * 2e-3 + 2e-3, found.y, 5e-9);
  const camera_mounting upside_down = {.roll_rad = SCALAR_PI};
  const camera_alignment reversed = camera_align(&upside_down);
  CHECK_NEAR("x upside down", -5e-3, camera_error(&reversed, (image_vector){5e-3f, 0.0f}).x, 5e-9);
}

static void test_mountings_out_of_range_are_refused(void) {
  for (int side = -1; side <= 1; side += 2) {
    const float sign = (float)side;
    const camera_mounting good = {.roll_rad = sign * SCALAR_PI, .boresight = {sign * 0.5f, sign * -0.5f}};
    CHECK_STATUS(CONTROL_OK, camera_mounting_check(&good));
    const camera_mounting wrong[] = {
        {sign * 3.2f, {0.0f, 0.0f}}, {0.0f, {sign * 0.51f, 0.0f}}, {0.0f, {0.0f, sign * 0.51f}}};
    for (unsigned i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
      CHECK_STATUS(CONTROL_OUT_OF_RANGE, camera_mounting_check(&wrong[i]));
    }
  }
  const camera_mounting nothing = {NAN, {0.0f, 0.0f}};
  CHECK_STATUS(CONTROL_NOT_FINITE, camera_mounting_check(&nothing));
}

/* Between two instants 1 ms apart, the line of sight and the image axes have turned as the rates say. */
static void test_rates_of_the_image_are_those_of_the_turning_frame(void) {
  const double pitch_rad = 65.0 * DEG;
  const double stage_rad_s = 0.3;
  const double rise_rad_s = -0.2;
  const double dt_s = 1e-5;
  const line_of_sight_rates rates = line_of_sight_of_joints(pitch_of(pitch_rad), 0.3f, -0.2f);
  const vector forward = {{1.0, 0.0, 0.0}};
  const vector across = {{0.0, 1.0, 0.0}};
  const vector up = {{0.0, 0.0, 1.0}};
  const vector los = turned(stage_rad_s * dt_s, pitch_rad + rise_rad_s * dt_s, forward);
  const vector raised = turned(stage_rad_s * dt_s, pitch_rad + rise_rad_s * dt_s, across);
  const vector c = turned(0.0, pitch_rad, across);
  const vector e = turned(0.0, pitch_rad, up);
  double along_c = 0.0;
  double along_e = 0.0;
  double rolled = 0.0;
  for (int i = 0; i < 3; ++i) {
    along_c += los.at[i] * c.at[i];
    along_e += los.at[i] * e.at[i];
    rolled += raised.at[i] * e.at[i];
  }
  CHECK_NEAR("cross-elevation, rad/s", along_c / dt_s, rates.rad_s.x, 1e-5);
  CHECK_NEAR("elevation, rad/s", along_e / dt_s, rates.rad_s.y, 1e-5);
  CHECK_NEAR("roll, rad/s", rolled / dt_s, rates.roll_rad_s, 1e-5);
}

/* Power: the torques times the rates are what the kinetic energy gains along a motion of both joints. */
static void test_the_torques_of_a_motion_give_the_change_of_its_kinetic_energy(void) {
  const pointing_inertia inertia = {3.0f, 2.5f, 1.5f};
  const double dt_s = 1e-4;
  for (int k = 0; k < 40; ++k) {
    const double t = 0.1 * (double)k;
    double energy[2];
    for (int side = 0; side < 2; ++side) {
      const double at = t + (side == 0 ? -0.5 : 0.5) * dt_s;
      const double pitch_rad = 0.7 + 0.5 * sin(1.3 * at);
      const double swing = 3.0 + 2.5 * cos(pitch_rad) * cos(pitch_rad);
      const double azimuth_rad_s = 0.8 * cos(0.9 * at);
      const double pitch_rad_s = 0.65 * cos(1.3 * at);
      energy[side] = 0.5 * swing * azimuth_rad_s * azimuth_rad_s + 0.75 * pitch_rad_s * pitch_rad_s;
    }
    const joint_vector rate = {(float)(0.8 * cos(0.9 * t)), (float)(0.65 * cos(1.3 * t))};
    const joint_vector acceleration = {(float)(-0.72 * sin(0.9 * t)), (float)(-0.845 * sin(1.3 * t))};
    const joint_vector nm = pointing_torques_nm(&inertia, pitch_of(0.7 + 0.5 * sin(1.3 * t)), rate, acceleration);
    const double power_w = (double)nm.azimuth * (double)rate.azimuth + (double)nm.pitch * (double)rate.pitch;
    CHECK_NEAR("power, W", (energy[1] - energy[0]) / dt_s, power_w, 1e-5);
  }
}

static void test_the_azimuth_keeps_its_angular_momentum_while_the_pitch_moves_without_torque(void) {
  const pointing_inertia inertia = {3.0f, 2.5f, 1.5f};
  const double pitch_rad = 0.6;
  const double inertia_now = 3.0 + 2.5 * cos(pitch_rad) * cos(pitch_rad);
  CHECK_RELATIVE("inertia", inertia_now, pointing_azimuth_inertia_kg_m2(&inertia, pitch_of(pitch_rad)), 1e-6);
  /* d/dt (J psi') = 0 gives psi'' = J1 sin(2 theta) theta' psi' / J. */
  const float speeds_up = (float)(2.5 * sin(2.0 * pitch_rad) * 0.4 * 0.5 / inertia_now);
  const joint_vector nm =
      pointing_torques_nm(&inertia, pitch_of(pitch_rad), (joint_vector){0.5f, 0.4f}, (joint_vector){speeds_up, 0.0f});
  CHECK_NEAR("torque of the azimuth, Nm", 0.0, nm.azimuth, 1e-6);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_after_turning_by_the_joint_errors_the_line_of_sight_meets_the_target);
  RUN_TEST(test_it_is_exact_at_the_zenith_and_beyond_it_and_far_from_the_centre);
  RUN_TEST(test_a_vector_that_came_along_the_great_circle_is_turned_into_the_image_axes_at_the_target);
  RUN_TEST(test_in_the_zenith_the_image_axes_stay);
  RUN_TEST(test_the_secant_of_the_pitch_would_miss_by_degrees_where_this_does_not);
  RUN_TEST(test_small_errors_keep_all_digits);
  RUN_TEST(test_a_target_in_the_zenith_leaves_the_azimuth);
  RUN_TEST(test_a_camera_that_is_rolled_and_offset_gives_errors_along_cross_elevation_and_elevation);
  RUN_TEST(test_mountings_out_of_range_are_refused);
  RUN_TEST(test_rates_of_the_image_are_those_of_the_turning_frame);
  RUN_TEST(test_the_torques_of_a_motion_give_the_change_of_its_kinetic_energy);
  RUN_TEST(test_the_azimuth_keeps_its_angular_momentum_while_the_pitch_moves_without_torque);
  return UNITY_END();
}
