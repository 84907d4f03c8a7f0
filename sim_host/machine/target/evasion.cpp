// SPDX-License-Identifier: Apache-2.0
#include "machine/target/evasion.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "machine/base/axis.hpp"
#include "machine/base/random.hpp"

namespace trackservo::sim {
namespace {

constexpr double kLast_s = 3600.0;
constexpr double kShortest_s = 0.5;
constexpr double kLongest_s = 1.5;

// Uniform on the sphere.
Eigen::Vector3d direction(RandomStream& random) {
  const double up = 2.0 * random.uniform() - 1.0;
  const double bearing_rad = 2.0 * kPi * random.uniform();
  const double level = std::sqrt(1.0 - up * up);
  return {level * std::cos(bearing_rad), level * std::sin(bearing_rad), up};
}

}  // namespace

Evasion::Evasion(double acceleration_m_s2, int seed) {
  if (acceleration_m_s2 <= 0.0) {
    return;
  }
  RandomStream random(static_cast<std::uint64_t>(seed), "target.evasion");
  double begin_s = 0.0;
  while (begin_s < kLast_s) {
    const double quarter_s = kShortest_s + (kLongest_s - kShortest_s) * random.uniform();
    manoeuvres_.push_back({begin_s, quarter_s, acceleration_m_s2 * direction(random)});
    begin_s += 4.0 * quarter_s;
  }
}

Evaded Evasion::at(double time_s) const {
  if (manoeuvres_.empty() || time_s < 0.0) {
    return {};
  }
  const auto next = std::upper_bound(manoeuvres_.begin(), manoeuvres_.end(), time_s,
                                     [](double at_s, const Manoeuvre& other) { return at_s < other.begin_s; });
  const Manoeuvre& now = *std::prev(next);
  const double quarter_s = now.quarter_s;
  double position = 0.0;  // for an acceleration of 1
  double velocity = 0.0;
  double begin_s = now.begin_s;
  const std::array<std::array<double, 2>, 3> parts{{{quarter_s, 1.0}, {2.0 * quarter_s, -1.0}, {quarter_s, 1.0}}};
  for (const auto& [lasts_s, sign] : parts) {
    const double in_s = time_s - begin_s;
    if (in_s < lasts_s) {
      return {now.acceleration_m_s2 * (position + velocity * in_s + 0.5 * sign * in_s * in_s),
              now.acceleration_m_s2 * (velocity + sign * in_s), now.acceleration_m_s2 * sign};
    }
    position += velocity * lasts_s + 0.5 * sign * lasts_s * lasts_s;
    velocity += sign * lasts_s;
    begin_s += lasts_s;
  }
  return {};
}

}  // namespace trackservo::sim
