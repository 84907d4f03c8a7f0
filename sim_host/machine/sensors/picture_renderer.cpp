// SPDX-License-Identifier: Apache-2.0
#include "machine/sensors/picture_renderer.hpp"

#include <algorithm>
#include <cmath>

#include "machine/base/random.hpp"

namespace trackservo::sim {
namespace {

constexpr int kTile = 1024;  // of the texture, pixels
constexpr int kTileMask = kTile - 1;
constexpr double kManyTiles = 1 << 30;  // makes every place of a picture positive, so that a cast rounds down
constexpr std::array<int, 5> kDetails_px{128, 32, 16, 8, 4};
constexpr double kCloudStretch = 16.0;  // clouds are coarser than ground
constexpr int kMaxBlurSteps = 32;       // of the UAV
constexpr int kMaxGroundSteps = 8;      // of the whole picture, 4 ms each
constexpr int kSamplesPerPixel = 4;     // of the silhouette's edges, in each direction

// The silhouette in wingspans: fuselage and wing are ellipses about the same centre.
struct Ellipse {
  double half_width;
  double half_height;
  bool contains(double x, double y) const {
    const double across = x / half_width;
    const double up = y / half_height;
    return across * across + up * up <= 1.0;
  }
};
constexpr Ellipse kWing{0.5, 0.04};
constexpr Ellipse kFuselage{0.12, 0.10};

std::size_t index_of(int column, int row, int width) {
  return static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column);
}

double smooth(double share) { return share * share * (3.0 - 2.0 * share); }

// Value noise: random values on a grid, with smooth transitions between them.
void add_detail(std::vector<float>& tile, int grid_px, RandomStream& random) {
  const int points = kTile / grid_px;
  std::vector<double> value(static_cast<std::size_t>(points) * static_cast<std::size_t>(points));
  for (double& each : value) {
    each = random.normal();
  }
  const auto at = [&](int column, int row) { return value[index_of(column % points, row % points, points)]; };
  for (int row = 0; row < kTile; ++row) {
    const double down = smooth(static_cast<double>(row % grid_px) / grid_px);
    for (int column = 0; column < kTile; ++column) {
      const double across = smooth(static_cast<double>(column % grid_px) / grid_px);
      const int left = column / grid_px;
      const int top = row / grid_px;
      const double above = at(left, top) + across * (at(left + 1, top) - at(left, top));
      const double below = at(left, top + 1) + across * (at(left + 1, top + 1) - at(left, top + 1));
      tile[index_of(column, row, kTile)] += static_cast<float>(above + down * (below - above));
    }
  }
}

std::vector<float> texture_tile(std::uint64_t seed) {
  std::vector<float> tile(static_cast<std::size_t>(kTile) * kTile);
  int index = 0;
  for (const int grid_px : kDetails_px) {
    RandomStream random(seed, "picture.texture", index++);
    add_detail(tile, grid_px, random);
  }
  double sum = 0.0;
  double squares = 0.0;
  for (const float value : tile) {
    sum += static_cast<double>(value);
    squares += static_cast<double>(value) * static_cast<double>(value);
  }
  const double mean = sum / static_cast<double>(tile.size());
  const double deviation = std::sqrt(squares / static_cast<double>(tile.size()) - mean * mean);
  for (float& value : tile) {
    value = static_cast<float>((static_cast<double>(value) - mean) / deviation);
  }
  return tile;
}

// In the middle of each of `count` equal steps.
double share_of(int step, int count) { return (step + 0.5) / count; }

int steps_for(double travel_px, int max_steps) {
  return std::clamp(static_cast<int>(std::ceil(2.0 * std::min(travel_px, 1000.0))), 1, max_steps);
}

}  // namespace

PictureRenderer::PictureRenderer(const PictureSceneConfig& config, std::uint64_t seed)
    : config_(config), seed_(seed), texture_(texture_tile(seed)) {}

PictureRenderer::Place PictureRenderer::place_of(const SceneState& scene) const {
  const std::array<double, kAxes> tangents = picture_of(scene.target_m, scene.pose, config_.mounting);
  return {0.5 * (config_.width_px - 1) - tangents[kAzimuth] / config_.pixel_rad,
          0.5 * (config_.height_px - 1) - tangents[kPitch] / config_.pixel_rad};
}

// Linear between the pixels of the texture.
float PictureRenderer::texture(double column, double row) const {
  const auto left = static_cast<std::int64_t>(column + kManyTiles);
  const auto top = static_cast<std::int64_t>(row + kManyTiles);
  const auto across = static_cast<float>(column + kManyTiles - static_cast<double>(left));
  const auto down = static_cast<float>(row + kManyTiles - static_cast<double>(top));
  const int x = static_cast<int>(left & kTileMask);
  const int y = static_cast<int>(top & kTileMask);
  const float *above = &texture_[index_of(0, y, kTile)];
  const float *below = &texture_[index_of(0, (y + 1) & kTileMask, kTile)];
  const int right = (x + 1) & kTileMask;
  const float upper = above[x] + across * (above[right] - above[x]);
  const float lower = below[x] + across * (below[right] - below[x]);
  return upper + down * (lower - upper);
}

PictureRenderer::Aim PictureRenderer::aim_of(const SceneState& scene) const {
  const Eigen::Matrix3d axes = camera_axes_of(scene.pose, config_.mounting.roll_rad);
  return {std::atan2(axes(1, 0), axes(0, 0)), std::asin(std::clamp(axes(2, 0), -1.0, 1.0)),
          std::atan2(axes(2, 1), axes(2, 2))};
}

void PictureRenderer::add_background(const Aim& aim, float share, std::vector<float>& picture) const {
  const double stretch = 1.0 / std::max(0.02, std::cos(aim.elevation_rad));
  const double cos_roll = std::cos(aim.roll_rad);
  const double sin_roll = std::sin(aim.roll_rad);
  const double centre_column = 0.5 * (config_.width_px - 1);
  const double centre_row = 0.5 * (config_.height_px - 1);
  const double azimuth_px = aim.azimuth_rad / config_.pixel_rad;
  const double elevation_px = (aim.elevation_rad - config_.horizon_rad) / config_.pixel_rad;
  std::size_t pixel = 0;
  for (int row = 0; row < config_.height_px; ++row) {
    for (int column = 0; column < config_.width_px; ++column, ++pixel) {
      const double left = centre_column - column;
      const double up = centre_row - row;
      const double from_left = azimuth_px + stretch * (cos_roll * left - sin_roll * up);
      const double above_edge = elevation_px + sin_roll * left + cos_roll * up;
      const double sky_share = std::clamp(above_edge + 0.5, 0.0, 1.0);  // of a pixel on the edge
      float grey = 0.0F;
      if (sky_share > 0.0) {
        const float cloud = texture(from_left / kCloudStretch, above_edge / kCloudStretch);
        grey += static_cast<float>(sky_share) *
                (static_cast<float>(config_.sky_grey) + static_cast<float>(config_.cloud_grey) * cloud);
      }
      if (sky_share < 1.0) {
        const float detail = texture(from_left, above_edge);
        grey += static_cast<float>(1.0 - sky_share) *
                (static_cast<float>(config_.ground_grey) + static_cast<float>(config_.clutter_grey) * detail);
      }
      picture[pixel] += share * grey;
    }
  }
}

// Counts how often a point of each pixel lies behind the UAV during the exposure.
void PictureRenderer::cover_with_uav(const SceneState& begin, const SceneState& end,
                                     std::vector<float>& picture) const {
  const Place first = place_of(begin);
  const Place last = place_of(end);
  const double travel_px = std::hypot(last.column - first.column, last.row - first.row);
  const double range_m = 0.5 * (begin.target_m.norm() + end.target_m.norm());
  if (!std::isfinite(travel_px) || !(range_m > 0.0)) {
    return;
  }
  const double span_px = config_.wingspan_m / range_m / config_.pixel_rad;
  const double reach_px = 0.5 * span_px + 1.0;
  const auto bound = [](double value, int size) { return static_cast<int>(std::clamp(value, 0.0, 1.0 * size)); };
  const int left = bound(std::floor(std::min(first.column, last.column) - reach_px), config_.width_px);
  const int right = bound(std::ceil(std::max(first.column, last.column) + reach_px) + 1.0, config_.width_px);
  const int top = bound(std::floor(std::min(first.row, last.row) - reach_px), config_.height_px);
  const int bottom = bound(std::ceil(std::max(first.row, last.row) + reach_px) + 1.0, config_.height_px);
  const Aim aim = aim_of(begin);
  const double cos_roll = std::cos(aim.roll_rad);
  const double sin_roll = std::sin(aim.roll_rad);
  const int steps = steps_for(travel_px, kMaxBlurSteps);
  const auto of_a_sample = static_cast<float>(1.0 / (steps * kSamplesPerPixel * kSamplesPerPixel));
  const auto uav = static_cast<float>(config_.uav_grey);
  for (int row = top; row < bottom; ++row) {
    for (int column = left; column < right; ++column) {
      int covered = 0;
      for (int step = 0; step < steps; ++step) {
        const double share = share_of(step, steps);
        const double centre_column = first.column + share * (last.column - first.column);
        const double centre_row = first.row + share * (last.row - first.row);
        for (int sample = 0; sample < kSamplesPerPixel * kSamplesPerPixel; ++sample) {
          const double across = share_of(sample % kSamplesPerPixel, kSamplesPerPixel) - 0.5;
          const double down = share_of(sample / kSamplesPerPixel, kSamplesPerPixel) - 0.5;
          const double x = (centre_column - column - across) / span_px;
          const double y = (centre_row - row - down) / span_px;
          const double level_x = cos_roll * x - sin_roll * y;
          const double level_y = sin_roll * x + cos_roll * y;
          covered += kWing.contains(level_x, level_y) || kFuselage.contains(level_x, level_y) ? 1 : 0;
        }
      }
      float& grey = picture[index_of(column, row, config_.width_px)];
      grey += static_cast<float>(covered) * of_a_sample * (uav - grey);
    }
  }
}

RenderedPicture PictureRenderer::render(const SceneState& begin, const SceneState& end, std::uint64_t number) const {
  RenderedPicture rendered{config_.width_px, config_.height_px, {}};
  const std::size_t pixels = static_cast<std::size_t>(config_.width_px) * static_cast<std::size_t>(config_.height_px);
  std::vector<float> picture(pixels);
  const Aim first = aim_of(begin);
  const Aim last = aim_of(end);
  const double turned_rad = std::hypot(std::remainder(last.azimuth_rad - first.azimuth_rad, 2.0 * kPi),
                                       last.elevation_rad - first.elevation_rad);
  const double half_picture_px = 0.5 * std::hypot(config_.width_px, config_.height_px);
  const double lowest_rad = std::min(first.elevation_rad, last.elevation_rad) - half_picture_px * config_.pixel_rad;
  const bool sky_alone = lowest_rad > config_.horizon_rad;  // clouds are too coarse to be blurred
  const int steps = sky_alone ? 1 : steps_for(0.5 * turned_rad / config_.pixel_rad, kMaxGroundSteps);
  for (int step = 0; step < steps; ++step) {
    const double share = share_of(step, steps);
    const Aim aim = {first.azimuth_rad + share * std::remainder(last.azimuth_rad - first.azimuth_rad, 2.0 * kPi),
                     first.elevation_rad + share * (last.elevation_rad - first.elevation_rad), first.roll_rad};
    add_background(aim, 1.0F / static_cast<float>(steps), picture);
  }
  cover_with_uav(begin, end, picture);
  RandomStream noise(seed_ + number, "picture.noise");
  rendered.grey.resize(pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    const double grey = static_cast<double>(picture[i]) + config_.noise_grey * noise.nearly_normal();
    rendered.grey[i] = static_cast<std::uint8_t>(std::clamp(grey + 0.5, 0.0, 255.0));
  }
  return rendered;
}

}  // namespace trackservo::sim
