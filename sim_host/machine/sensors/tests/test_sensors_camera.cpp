// SPDX-License-Identifier: Apache-2.0
// The tracking camera and the target in front of it.
#include <Eigen/Geometry>
#include <cmath>

#include "machine/base/firmware.hpp"
#include "machine/base/random.hpp"
#include "machine/sensors/camera.hpp"
#include "machine/target/fly_by.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" {
#include "control/line_of_sight.h"
}

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

CameraConfig noiseless() {
  CameraConfig config;
  config.centroid_noise_rms_px = 0.0;
  return config;
}

void test_a_frame_comes_every_20_ms_and_20_ms_late() {
  Camera camera(noiseless(), 1);
  int frames = 0;
  for (int tick = 0; tick <= 1000; ++tick) {
    const double time = tick * kTick_s;
    camera.expose(time, {time * 1e-3, -time * 1e-3});
    while (const auto frame = camera.poll(time)) {
      CHECK_NEAR("exposure in s", frames * 0.02, frame->exposure_time_s, 1e-12);
      CHECK_NEAR("delivered in s", frames * 0.02 + 0.02, time, 1e-12);
      CHECK_NEAR("delay in s", 0.02, frame->delay_s, 1e-12);
      CHECK_NEAR("error at the exposure", frame->exposure_time_s * 1e-3, frame->error_rad[kAzimuth], 1e-15);
      CHECK_NEAR("and in pitch", -frame->exposure_time_s * 1e-3, frame->error_rad[kPitch], 1e-15);
      TEST_ASSERT_TRUE(frame->valid);
      ++frames;
    }
  }
  TEST_ASSERT_EQUAL_INT(50, frames);
}

void test_a_target_outside_the_picture_is_not_valid() {
  const double half_width = 960.0 * 11.499e-6;
  const double half_height = 540.0 * 11.499e-6;
  const struct {
    double azimuth, pitch;
    bool valid;
  } cases[] = {{0.99 * half_width, 0.0, true},
               {-0.99 * half_width, 0.99 * half_height, true},
               {1.01 * half_width, 0.0, false},
               {0.0, -1.01 * half_height, false},
               {std::nan(""), 0.0, false}};
  for (const auto& scene : cases) {
    Camera camera(noiseless(), 1);
    camera.expose(0.0, {scene.azimuth, scene.pitch});
    const auto frame = camera.poll(0.02);
    TEST_ASSERT_TRUE(frame.has_value());
    TEST_ASSERT_EQUAL(scene.valid, frame->valid);
    if (!scene.valid) {
      CHECK_SAME("no error without a target", 0.0, frame->error_rad[kAzimuth]);
    }
  }
}

void test_centroid_noise_is_a_fifth_of_a_pixel() {
  CameraConfig config;
  config.centroid_noise_rms_px = 0.2;
  Camera camera(config, 3);
  double square = 0.0;
  const int frames = 50000;
  for (int i = 0; i < frames; ++i) {
    camera.expose(i * 0.02, {1e-3, 0.0});
    const auto frame = camera.poll(i * 0.02 + 0.02);
    square += std::pow(frame->error_rad[kAzimuth] - 1e-3, 2.0) / frames;
  }
  CHECK_RELATIVE("rms in urad", 0.2 * 11.499, std::sqrt(square) * 1e6, 0.02);
}

void test_nothing_is_delivered_before_its_time_or_twice() {
  Camera camera(noiseless(), 1);
  camera.expose(0.0, {0.0, 0.0});
  TEST_ASSERT_FALSE(camera.poll(0.019).has_value());
  TEST_ASSERT_TRUE(camera.poll(0.020).has_value());
  TEST_ASSERT_FALSE(camera.poll(0.021).has_value());
}

void test_in_a_dropout_the_target_is_not_found() {
  CameraConfig config = noiseless();
  config.dropouts_at_s = {0.1, 0.5};
  config.dropout_s = 0.1;
  Camera camera(config, 1);
  int missed = 0;
  for (int frame = 0; frame < 50; ++frame) {
    const double time_s = 0.02 * frame;
    camera.expose(time_s, {1e-3, 1e-3});
    const auto seen = camera.poll(time_s + 0.02);
    TEST_ASSERT_TRUE(seen.has_value());
    const bool drops = (frame >= 5 && frame < 10) || (frame >= 25 && frame < 30);
    TEST_ASSERT_EQUAL(!drops, seen->valid);
    missed += seen->valid ? 0 : 1;
  }
  TEST_ASSERT_EQUAL_INT(10, missed);
}

// Places that need no matrix to know.
void test_the_picture_shows_known_directions_where_they_are() {
  const double up_60 = 60.0 * kRadPerDeg;
  const PicturePose level;
  PicturePose raised;
  raised.joint_angle_rad = {0.5 * kPi, up_60};
  const auto ahead = picture_of({100.0, 2.0, -3.0}, level, {});
  CHECK_NEAR("left is cross-elevation", 0.02, ahead[kAzimuth], 1e-15);
  CHECK_NEAR("up is elevation", -0.03, ahead[kPitch], 1e-15);
  const auto centre = picture_of(100.0 * Eigen::Vector3d(0.0, std::cos(up_60), std::sin(up_60)), raised, {});
  CHECK_NEAR("along the optical axis", 0.0, centre[kAzimuth], 1e-15);
  CHECK_NEAR("along the optical axis", 0.0, centre[kPitch], 1e-15);
  // 1 mrad of azimuth moves a target at 60 degrees by half of it.
  PicturePose turned = raised;
  turned.joint_angle_rad[kAzimuth] -= 1e-3;
  const auto beside = picture_of(100.0 * Eigen::Vector3d(0.0, std::cos(up_60), std::sin(up_60)), turned, {});
  CHECK_NEAR("cross-elevation", 0.5e-3, beside[kAzimuth], 1e-9);
  // A base that rolls about the optical axis turns the picture; so does the sensor. The boresight does not.
  PicturePose rolled = level;
  rolled.base = Eigen::AngleAxisd(0.5 * kPi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const auto on_base = picture_of({100.0, 2.0, -3.0}, rolled, {});
  const auto on_sensor = picture_of({100.0, 2.0, -3.0}, level, {0.5 * kPi, 1e-3, 2e-3});
  for (const auto& place : {on_base, on_sensor}) {
    CHECK_NEAR("rows point up", -0.03, place[kAzimuth], 1e-15);
    CHECK_NEAR("columns point to the right", -0.02, place[kPitch], 1e-15);
  }
  const auto error = pointing_error_of({100.0, 2.0, -3.0}, level, {0.5 * kPi, 1e-3, 2e-3});
  CHECK_NEAR("from the boresight", 0.019, error[kAzimuth], 1e-15);
  CHECK_NEAR("from the boresight", -0.032, error[kPitch], 1e-15);
  const auto behind = picture_of({-100.0, 2.0, -3.0}, level, {});
  TEST_ASSERT_FALSE(std::isfinite(behind[kAzimuth]));
}

// The firmware's geometry in single precision, judged by the rotation matrices: after both joints have turned by what
// the firmware computes from the camera's own rows and columns, the target is on the optical axis.
void test_the_firmware_turns_both_joints_onto_the_target() {
  RandomStream random(5, "picture", 0);
  const PictureMounting mounting{0.7, 0.0, 0.0};
  const camera_mounting firmware_mounting{0.7F, {0.0F, 0.0F}};
  const camera_alignment alignment = camera_align(&firmware_mounting);
  double worst_rad = 0.0;
  double secant_rad = 0.0;
  for (int i = 0; i < 20000; ++i) {
    PicturePose pose;
    pose.joint_angle_rad = {kPi * (2.0 * random.uniform() - 1.0), 89.0 * kRadPerDeg * (2.0 * random.uniform() - 1.0)};
    const Eigen::Vector3d axis(0.3 * (random.uniform() - 0.5), 0.3 * (random.uniform() - 0.5), random.uniform());
    pose.base = Eigen::AngleAxisd(random.uniform(), axis.normalized()).toRotationMatrix();
    const Eigen::Vector3d seen(500.0, 5.0 * (random.uniform() - 0.5), 3.0 * (random.uniform() - 0.5));
    const Eigen::Vector3d target_m =
        pose.base * (Eigen::AngleAxisd(pose.joint_angle_rad[kAzimuth], Eigen::Vector3d::UnitZ()) *
                     Eigen::AngleAxisd(-pose.joint_angle_rad[kPitch], Eigen::Vector3d::UnitY()) * seen);
    const auto place = picture_of(target_m, pose, mounting);
    const image_vector error =
        camera_error(&alignment, {static_cast<float>(place[kAzimuth]), static_cast<float>(place[kPitch])});
    const auto pitch_turn32 = static_cast<angle_turn32>(
        static_cast<std::int64_t>(std::llround(pose.joint_angle_rad[kPitch] / (2.0 * kPi) * 4294967296.0)));
    const joint_vector turn = line_of_sight_joint_errors(rotation_of(pitch_turn32), error);
    const double pitch_rad = pose.joint_angle_rad[kPitch];
    PicturePose after = pose;
    after.joint_angle_rad[kAzimuth] += static_cast<double>(turn.azimuth);
    after.joint_angle_rad[kPitch] += static_cast<double>(turn.pitch);
    const auto left = pointing_error_of(target_m, after, mounting);
    worst_rad = std::max(worst_rad, std::hypot(left[kAzimuth], left[kPitch]));
    after.joint_angle_rad = {pose.joint_angle_rad[kAzimuth] + static_cast<double>(error.x) / std::cos(pitch_rad),
                             pitch_rad + static_cast<double>(error.y)};
    const auto by_secant = pointing_error_of(target_m, after, mounting);
    secant_rad = std::max(secant_rad, std::hypot(by_secant[kAzimuth], by_secant[kPitch]));
  }
  LOG_VALUE("left by the firmware's geometry, urad", worst_rad * 1e6);
  LOG_VALUE("left by the secant of the pitch, urad", secant_rad * 1e6);
  CHECK_AT_MOST("urad", 0.02, worst_rad * 1e6);
  CHECK_AT_LEAST("urad", 10.0, secant_rad * 1e6);
}

FlyByConfig weaving() { return shipped_scenario("tracking").fly_by; }

void test_rates_and_accelerations_of_the_line_of_sight_are_its_derivatives() {
  FlyByConfig near = weaving();
  near.start_position_m = {200.0, -300.0, 80.0};  // close by, where all rates are high
  near.velocity_m_s = {-3.0, 20.0, 1.0};
  const FlyBy fly_by(near);
  const double h = 1e-3;
  for (double t = 0.0; t < 40.0; t += 0.37) {
    const LineOfSight before = fly_by.at(t - h);
    const LineOfSight now = fly_by.at(t);
    const LineOfSight after = fly_by.at(t + h);
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      CHECK_NEAR("rate", (after.angle_rad[axis] - before.angle_rad[axis]) / (2.0 * h), now.rate_rad_s[axis], 1e-7);
      CHECK_NEAR("acceleration", (after.rate_rad_s[axis] - before.rate_rad_s[axis]) / (2.0 * h),
                 now.acceleration_rad_s2[axis], 1e-7);
    }
  }
}

void test_azimuth_is_continuous_behind_the_tracker() {
  FlyByConfig behind = weaving();
  behind.start_position_m = {-500.0, -100.0, 100.0};  // crosses the direction of 180 deg
  behind.velocity_m_s = {0.0, 20.0, 0.0};
  const FlyBy fly_by(behind);
  double last = fly_by.at(0.0).angle_rad[kAzimuth];
  for (double t = 0.0; t < 20.0; t += 0.01) {
    const double now = fly_by.at(t).angle_rad[kAzimuth];
    CHECK_NEAR("step in rad", last, now, 0.01);
    last = now;
  }
}

void test_the_shipped_fly_by_is_slow_cruises_at_20_m_per_s_and_turns_back() {
  const ScenarioConfig scenario = shipped_scenario("tracking");
  const FlyBy fly_by(scenario.fly_by);
  const auto& v = scenario.fly_by.velocity_m_s;
  CHECK_NEAR("speed in m/s", 20.0, std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), 0.5);
  double fastest = 0.0;
  int reversals = 0;
  double last = 0.0;
  for (double t = 0.0; t < scenario.duration_s; t += 0.01) {
    const LineOfSight los = fly_by.at(t);
    fastest = std::max({fastest, std::abs(los.rate_rad_s[kAzimuth]), std::abs(los.rate_rad_s[kPitch])});
    reversals += last * los.rate_rad_s[kAzimuth] < 0.0 ? 1 : 0;
    last = los.rate_rad_s[kAzimuth];
  }
  LOG_VALUE("fastest line of sight in deg/s", fastest / kRadPerDeg);
  CHECK_AT_MOST("deg/s", 0.3, fastest / kRadPerDeg);
  CHECK_AT_LEAST("reversals of azimuth", 2, reversals);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_frame_comes_every_20_ms_and_20_ms_late);
  RUN_TEST(test_a_target_outside_the_picture_is_not_valid);
  RUN_TEST(test_centroid_noise_is_a_fifth_of_a_pixel);
  RUN_TEST(test_nothing_is_delivered_before_its_time_or_twice);
  RUN_TEST(test_in_a_dropout_the_target_is_not_found);
  RUN_TEST(test_the_picture_shows_known_directions_where_they_are);
  RUN_TEST(test_the_firmware_turns_both_joints_onto_the_target);
  RUN_TEST(test_rates_and_accelerations_of_the_line_of_sight_are_its_derivatives);
  RUN_TEST(test_azimuth_is_continuous_behind_the_tracker);
  RUN_TEST(test_the_shipped_fly_by_is_slow_cruises_at_20_m_per_s_and_turns_back);
  return UNITY_END();
}
