// SPDX-License-Identifier: Apache-2.0
// Random manoeuvres of a target that evades: its acceleration always has the same size, and jumps to another direction
// at random times.
//
// A manoeuvre is +a for T, -a for 2 T, +a for T along a random direction: after 4 T the target is back on its course,
// with its velocity. T is drawn from 0.5 to 1.5 s, so the target leaves its course by a T^2: 1 to 11 m at 5 m/s2.
#ifndef TRACKSERVO_SIM_TARGET_EVASION_HPP
#define TRACKSERVO_SIM_TARGET_EVASION_HPP

#include <Eigen/Core>
#include <vector>

namespace trackservo::sim {

// What is added to the course.
struct Evaded {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_m_s2 = Eigen::Vector3d::Zero();
};

class Evasion {
 public:
  // Draws the manoeuvres; acceleration 0: none.
  Evasion(double acceleration_m_s2, int seed);

  // Returns what is added at any time [s]; before 0, and after an hour, none.
  Evaded at(double time_s) const;

 private:
  struct Manoeuvre {
    double begin_s;
    double quarter_s;
    Eigen::Vector3d acceleration_m_s2;
  };
  std::vector<Manoeuvre> manoeuvres_;  // one after the other
};

}  // namespace trackservo::sim

#endif
