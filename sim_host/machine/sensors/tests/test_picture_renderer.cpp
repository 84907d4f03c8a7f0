// SPDX-License-Identifier: Apache-2.0
// Rendered pictures: place, size and blur of the UAV against the true geometry.
#include "machine/sensors/picture_renderer.hpp"

#include <cmath>

#include "machine/base/firmware.hpp"
#include "support/check.h"
#include "unity.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace trackservo::sim;

// A UAV in front of an even sky, without noise.
PictureSceneConfig plain_scene() {
  PictureSceneConfig config;
  config.noise_grey = 0;
  config.cloud_grey = 0;
  config.horizon_rad = -1.0;
  return config;
}

// Centre, spread and area of the darkness: what the UAV takes from the sky.
struct Shape {
  double column = 0;
  double row = 0;
  double columns_rms = 0;
  double rows_rms = 0;
  double area_px = 0;
};

Shape shape_of(const RenderedPicture& picture, const PictureSceneConfig& config) {
  double sum = 0;
  Shape shape;
  const auto darkness = [&](int column, int row) {
    return config.sky_grey - picture.grey[static_cast<std::size_t>(row * picture.width_px + column)];
  };
  for (int row = 0; row < picture.height_px; ++row) {
    for (int column = 0; column < picture.width_px; ++column) {
      sum += darkness(column, row);
      shape.column += darkness(column, row) * column;
      shape.row += darkness(column, row) * row;
    }
  }
  shape.column /= sum;
  shape.row /= sum;
  for (int row = 0; row < picture.height_px; ++row) {
    for (int column = 0; column < picture.width_px; ++column) {
      shape.columns_rms += darkness(column, row) * std::pow(column - shape.column, 2);
      shape.rows_rms += darkness(column, row) * std::pow(row - shape.row, 2);
    }
  }
  shape.columns_rms = std::sqrt(shape.columns_rms / sum);
  shape.rows_rms = std::sqrt(shape.rows_rms / sum);
  shape.area_px = sum / (config.sky_grey - config.uav_grey);
  return shape;
}

SceneState scene_at(double range_m, double azimuth_rad, double pitch_rad) {
  SceneState scene;
  scene.target_m = {range_m, 0.0, 0.0};
  scene.pose.joint_angle_rad = {azimuth_rad, pitch_rad};
  return scene;
}

// Required: far below the noise of a centroid, 0.2 pixels.
void test_the_centroid_is_the_true_place() {
  for (const double roll_rad : {0.0, 0.3}) {
    PictureSceneConfig config = plain_scene();
    config.mounting.roll_rad = roll_rad;
    const PictureRenderer renderer(config, 1);
    for (int i = 0; i < 10; ++i) {
      const SceneState scene = scene_at(2000.0 - 80.0 * i, 0.3e-3 * i - 1.3e-3, 0.11e-3 * i - 0.6e-3);
      const Shape shape = shape_of(renderer.render(scene, scene, 1), config);
      const std::array<double, kAxes> place = picture_of(scene.target_m, scene.pose, config.mounting);
      CHECK_NEAR("along the rows in pixels", place[kAzimuth] / config.pixel_rad, 319.5 - shape.column, 0.03);
      CHECK_NEAR("along the columns in pixels", place[kPitch] / config.pixel_rad, 239.5 - shape.row, 0.03);
    }
  }
}

void test_the_size_is_inverse_to_the_range() {
  const PictureSceneConfig config = plain_scene();
  const PictureRenderer renderer(config, 1);
  for (const double range_m : {600.0, 1200.0, 3000.0}) {
    const SceneState scene = scene_at(range_m, 0.0, 0.0);
    const Shape shape = shape_of(renderer.render(scene, scene, 1), config);
    const double span_px = config.wingspan_m / range_m / config.pixel_rad;
    // Wing plus the fuselage's part above and below the wing, by integration of the two ellipses.
    CHECK_NEAR("area in squares of the span", 0.0820, shape.area_px / (span_px * span_px), 0.001);
  }
}

// A bar of length L adds L^2 / 12 to the square of the spread.
void test_the_blur_is_as_long_as_the_motion() {
  const PictureSceneConfig config = plain_scene();
  const PictureRenderer renderer(config, 1);
  const SceneState still = scene_at(3000.0, 0.0, 0.0);
  const Shape sharp = shape_of(renderer.render(still, still, 1), config);
  for (const double rate_rad_s : {0.05, 0.2}) {
    const double turned_rad = rate_rad_s * config.exposure_s;
    const SceneState begin = scene_at(3000.0, -0.5 * turned_rad, 0.25 * turned_rad);
    const SceneState end = scene_at(3000.0, 0.5 * turned_rad, -0.25 * turned_rad);
    const Shape blurred = shape_of(renderer.render(begin, end, 1), config);
    const auto length_px = [](double rms, double sharp_rms) {
      return std::sqrt(12.0 * (rms * rms - sharp_rms * sharp_rms));
    };
    const double true_px = turned_rad / config.pixel_rad;
    CHECK_NEAR("blur along the rows", true_px, length_px(blurred.columns_rms, sharp.columns_rms), 0.03 * true_px + 0.1);
    CHECK_NEAR("blur along the columns", 0.5 * true_px, length_px(blurred.rows_rms, sharp.rows_rms),
               0.03 * true_px + 0.1);
    CHECK_NEAR("its middle stays", sharp.column, blurred.column, 0.05);
  }
}

void test_the_target_is_missing_outside_the_picture() {
  const PictureSceneConfig config = plain_scene();
  const PictureRenderer renderer(config, 1);
  for (const double azimuth_rad : {5e-3, 3.1}) {
    const SceneState scene = scene_at(2000.0, azimuth_rad, 0.0);
    const RenderedPicture picture = renderer.render(scene, scene, 1);
    for (const std::uint8_t grey : picture.grey) {
      TEST_ASSERT_EQUAL_UINT8(170, grey);
    }
  }
}

double deviation_of_rows(const RenderedPicture& picture, int from, int to) {
  double sum = 0;
  double squares = 0;
  const int count = (to - from) * picture.width_px;
  for (int i = from * picture.width_px; i < to * picture.width_px; ++i) {
    const double grey = picture.grey[static_cast<std::size_t>(i)];
    sum += grey;
    squares += grey * grey;
  }
  return std::sqrt(squares / count - std::pow(sum / count, 2));
}

void test_the_ground_is_below_the_horizon_and_stands_still() {
  PictureSceneConfig config;
  config.noise_grey = 0;
  const PictureRenderer renderer(config, 1);
  SceneState scene = scene_at(2000.0, 1.0, 0.0);  // the target is outside
  const RenderedPicture level = renderer.render(scene, scene, 1);
  TEST_ASSERT_TRUE(deviation_of_rows(level, 0, 239) < 2.0 * config.cloud_grey);
  TEST_ASSERT_TRUE(deviation_of_rows(level, 241, 480) > 0.5 * config.clutter_grey);
  scene.pose.joint_angle_rad = {1.0 + 10.0 * config.pixel_rad, 20.0 * config.pixel_rad};
  const RenderedPicture turned = renderer.render(scene, scene, 1);
  for (const int row : {300, 400}) {
    for (const int column : {100, 500}) {  // 10 pixels to the left: what was seen is further to the right, and lower
      const int before = level.grey[static_cast<std::size_t>(row * 640 + column)];
      const int after = turned.grey[static_cast<std::size_t>((row + 20) * 640 + column + 10)];
      CHECK_NEAR("the same place of the ground", before, after, 1);
    }
  }
}

void test_the_noise_is_that_of_the_camera_and_new_in_each_picture() {
  PictureSceneConfig config = plain_scene();
  config.noise_grey = 3;
  const PictureRenderer renderer(config, 1);
  const SceneState outside = scene_at(2000.0, 1.0, 0.0);
  const RenderedPicture first = renderer.render(outside, outside, 1);
  CHECK_NEAR("deviation of a pixel", 3.0, deviation_of_rows(first, 0, 480), 0.05);
  TEST_ASSERT_TRUE(first.grey == renderer.render(outside, outside, 1).grey);
  TEST_ASSERT_FALSE(first.grey == renderer.render(outside, outside, 2).grey);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_centroid_is_the_true_place);
  RUN_TEST(test_the_size_is_inverse_to_the_range);
  RUN_TEST(test_the_blur_is_as_long_as_the_motion);
  RUN_TEST(test_the_target_is_missing_outside_the_picture);
  RUN_TEST(test_the_ground_is_below_the_horizon_and_stands_still);
  RUN_TEST(test_the_noise_is_that_of_the_camera_and_new_in_each_picture);
  return UNITY_END();
}
