// SPDX-License-Identifier: Apache-2.0
#include "machine/target/fly_by.hpp"

#include <Eigen/Geometry>
#include <cmath>

namespace trackservo::sim {

// A position with its first two time derivatives.
struct FlyBy::Motion {
  Eigen::Vector3d position_m;
  Eigen::Vector3d velocity_m_s;
  Eigen::Vector3d acceleration_m_s2;

  void weave(const Eigen::Vector3d& direction, double amplitude_m, double period_s, double time_s) {
    const double w = 2.0 * kPi / period_s;
    position_m += direction * (amplitude_m * std::sin(w * time_s));
    velocity_m_s += direction * (amplitude_m * w * std::cos(w * time_s));
    acceleration_m_s2 -= direction * (amplitude_m * w * w * std::sin(w * time_s));
  }
};

FlyBy::FlyBy(const FlyByConfig& config)
    : config_(config),
      evasion_(config.evasion_m_s2, config.evasion_seed),
      start_(config.start_position_m[0], config.start_position_m[1], config.start_position_m[2]),
      velocity_(config.velocity_m_s[0], config.velocity_m_s[1], config.velocity_m_s[2]),
      first_bearing_rad_(std::atan2(start_.y(), start_.x())) {
  const double course = std::hypot(velocity_.x(), velocity_.y());
  across_ = course > 0.0 ? Eigen::Vector3d(-velocity_.y() / course, velocity_.x() / course, 0.0)
                         : Eigen::Vector3d(0.0, 1.0, 0.0);
}

FlyBy::Motion FlyBy::motion(double time_s) const {
  Motion target{start_ + velocity_ * time_s, velocity_, Eigen::Vector3d::Zero()};
  target.weave(across_, config_.weave_lateral_m, config_.weave_lateral_period_s, time_s);
  target.weave(Eigen::Vector3d::UnitZ(), config_.weave_vertical_m, config_.weave_vertical_period_s, time_s);
  const Evaded evaded = evasion_.at(time_s);
  target.position_m += evaded.position_m;
  target.velocity_m_s += evaded.velocity_m_s;
  target.acceleration_m_s2 += evaded.acceleration_m_s2;
  return target;
}

Eigen::Vector3d FlyBy::position_m(double time_s) const { return motion(time_s).position_m; }

LineOfSight FlyBy::at(double time_s) const {
  const Motion target = motion(time_s);

  const Eigen::Vector3d& p = target.position_m;
  const Eigen::Vector3d& v = target.velocity_m_s;
  const Eigen::Vector3d& a = target.acceleration_m_s2;
  const double ground_square = p.x() * p.x() + p.y() * p.y();
  const double ground = std::sqrt(ground_square);  // distance on the ground, with its derivatives
  const double ground_rate = (p.x() * v.x() + p.y() * v.y()) / ground;
  const double ground_acceleration =
      (v.x() * v.x() + v.y() * v.y() + p.x() * a.x() + p.y() * a.y() - ground_rate * ground_rate) / ground;
  const double range_square = ground_square + p.z() * p.z();

  LineOfSight los;
  los.range_m = std::sqrt(range_square);

  const double cosine = std::cos(first_bearing_rad_);
  const double sine = std::sin(first_bearing_rad_);
  los.angle_rad[kAzimuth] =
      first_bearing_rad_ + std::atan2(cosine * p.y() - sine * p.x(), cosine * p.x() + sine * p.y());
  los.rate_rad_s[kAzimuth] = (p.x() * v.y() - p.y() * v.x()) / ground_square;
  los.acceleration_rad_s2[kAzimuth] =
      (p.x() * a.y() - p.y() * a.x()) / ground_square - 2.0 * los.rate_rad_s[kAzimuth] * ground_rate / ground;

  const double range_rate_over_range = (ground * ground_rate + p.z() * v.z()) / range_square;
  los.angle_rad[kPitch] = std::atan2(p.z(), ground);
  los.rate_rad_s[kPitch] = (ground * v.z() - p.z() * ground_rate) / range_square;
  los.acceleration_rad_s2[kPitch] = (ground * a.z() - p.z() * ground_acceleration) / range_square -
                                    2.0 * los.rate_rad_s[kPitch] * range_rate_over_range;
  return los;
}

}  // namespace trackservo::sim
