// The tracking camera and the target in front of it.
#include <cmath>

#include "sensors/camera.hpp"
#include "support/bench.hpp"
#include "support/check.h"
#include "target/fly_by.hpp"

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
  RUN_TEST(test_rates_and_accelerations_of_the_line_of_sight_are_its_derivatives);
  RUN_TEST(test_azimuth_is_continuous_behind_the_tracker);
  RUN_TEST(test_the_shipped_fly_by_is_slow_cruises_at_20_m_per_s_and_turns_back);
  return UNITY_END();
}
