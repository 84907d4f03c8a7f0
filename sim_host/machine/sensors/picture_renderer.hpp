// SPDX-License-Identifier: Apache-2.0
// What the tracking camera sees: grey pictures of a UAV in front of sky and ground, from the true line of sight.
//
//   background   sky with faint clouds above `horizon_rad`, textured ground below it; both stand still on the ground
//   UAV          a flying wing seen from ahead, symmetric about the target's position; its size follows the range
//   exposure     the scene moves linearly between its state at the begin and at the end of the exposure: motion blur
//   noise        of each pixel by itself
//
// The picture is the one of picture_of() in picture.hpp: pixel (column, row) has the tangents
//
//   along the rows     (centre column - column) pixel_rad      the azimuth grows to the left
//   along the columns  (centre row - row) pixel_rad            row 0 is the top one
//
// with the centre of the picture at ((width - 1) / 2, (height - 1) / 2). The background is that of a level camera near
// the horizon, where it has its details: its azimuth is stretched by 1 / cos(elevation) of the picture's centre.
//
// Use: `renderer.render(begin, end, number)`; equal arguments give equal pictures, byte by byte.
#ifndef TRACKSERVO_SIM_SENSORS_PICTURE_RENDERER_HPP
#define TRACKSERVO_SIM_SENSORS_PICTURE_RENDERER_HPP

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "machine/sensors/picture.hpp"

namespace trackservo::sim {

struct PictureSceneConfig {
  int width_px = 640;
  int height_px = 480;
  double pixel_rad = 11.499e-6;
  double exposure_s = 0.002;
  double wingspan_m = 1.5;
  double uav_grey = 40;
  double sky_grey = 170;     // at the horizon
  double ground_grey = 110;  // mean
  double clutter_grey = 15;  // standard deviation of the ground
  double cloud_grey = 4;     // of the sky
  double noise_grey = 2;     // of a pixel
  double horizon_rad = 0;    // elevation of the ground's edge
  PictureMounting mounting;  // only its roll turns the picture
};

// The camera and what is in front of it, at one time.
struct SceneState {
  PicturePose pose;
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero();  // in the ground's frame, from the camera; NaN: no target
};

// Grey, one byte per pixel, row by row from the top left.
struct RenderedPicture {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> grey;
};

class PictureRenderer {
 public:
  PictureRenderer(const PictureSceneConfig& config, std::uint64_t seed);

  const PictureSceneConfig& config() const { return config_; }

  // Renders a picture; `number` selects the noise.
  RenderedPicture render(const SceneState& begin, const SceneState& end, std::uint64_t number) const;

 private:
  // Places in the picture, in pixels; NaN behind the camera.
  struct Place {
    double column;
    double row;
  };
  Place place_of(const SceneState& scene) const;
  // Where the camera looks to: azimuth, elevation, and how far the horizon is turned in the picture.
  struct Aim {
    double azimuth_rad;
    double elevation_rad;
    double roll_rad;
  };
  Aim aim_of(const SceneState& scene) const;
  void add_background(const Aim& aim, float share, std::vector<float>& picture) const;
  void cover_with_uav(const SceneState& begin, const SceneState& end, std::vector<float>& picture) const;
  float texture(double column, double row) const;

  PictureSceneConfig config_;
  std::uint64_t seed_;
  std::vector<float> texture_;  // mean 0, standard deviation 1, repeats in both directions
};

}  // namespace trackservo::sim

#endif
