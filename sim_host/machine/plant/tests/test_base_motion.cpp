// SPDX-License-Identifier: Apache-2.0
// The turning base: its attitude, what the gyros and the camera see of it, and what it does to the joints, each against
// rotation matrices and their numerical derivatives.
#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "machine/plant/base_motion.hpp"
#include "machine/plant/tracker.hpp"
#include "machine/sensors/picture.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;
using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kStep_s = 1e-5;  // of numerical derivatives

// Far beyond small angles.
std::vector<BaseMotionLine> strong_motion() {
  return {{BaseAxis::kRoll, 0.7, 0.5, 0.3},
          {BaseAxis::kPitch, 1.1, 0.4, 1.0},
          {BaseAxis::kYaw, 0.4, 0.9, -0.5},
          {BaseAxis::kYaw, 2.3, 0.1, 0.0}};
}

// The attitude from its definition.
Matrix3d attitude(double t) {
  const double roll = 0.5 * std::sin(2.0 * kPi * 0.7 * t + 0.3);
  const double pitch = 0.4 * std::sin(2.0 * kPi * 1.1 * t + 1.0);
  const double yaw = 0.9 * std::sin(2.0 * kPi * 0.4 * t - 0.5) + 0.1 * std::sin(2.0 * kPi * 2.3 * t);
  return (AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(-pitch, Vector3d::UnitY()) *
          AngleAxisd(roll, Vector3d::UnitX()))
      .toRotationMatrix();
}

// Angular rate of a turning frame, in that frame: R^T R' = [w].
Vector3d rate_between(const Matrix3d& before, const Matrix3d& after, double time_s) {
  const Matrix3d turned = (0.5 * (before + after)).transpose() * (after - before) / time_s;
  return {0.5 * (turned(2, 1) - turned(1, 2)), 0.5 * (turned(0, 2) - turned(2, 0)),
          0.5 * (turned(1, 0) - turned(0, 1))};
}

Vector3d base_rate(double t) { return rate_between(attitude(t - kStep_s), attitude(t + kStep_s), 2.0 * kStep_s); }

Matrix3d stage(double azimuth_rad) { return AngleAxisd(azimuth_rad, Vector3d::UnitZ()).toRotationMatrix(); }
Matrix3d camera(double azimuth_rad, double pitch_rad) {
  return stage(azimuth_rad) * AngleAxisd(-pitch_rad, Vector3d::UnitY()).toRotationMatrix();
}

void test_attitude_rate_and_acceleration_are_those_of_the_rotation_matrix() {
  const BaseMotion motion(strong_motion());
  for (double t = 0.1; t < 3.0; t += 0.17) {
    const BaseState state = motion.at(t);
    CHECK_NEAR("attitude", 0.0, (state.attitude - attitude(t)).norm(), 1e-12);
    CHECK_NEAR("rate, rad/s", 0.0, (state.rate_rad_s - base_rate(t)).norm(), 1e-7);
    const Vector3d slope = (motion.at(t + kStep_s).rate_rad_s - motion.at(t - kStep_s).rate_rad_s) / (2.0 * kStep_s);
    CHECK_NEAR("acceleration, rad/s2", 0.0, (state.acceleration_rad_s2 - slope).norm(), 1e-6);
  }
  TEST_ASSERT_FALSE(BaseMotion({}).moves());
  CHECK_NEAR("at rest", 0.0, (BaseMotion({}).at(1.0).attitude - Matrix3d::Identity()).norm(), 0.0);
}

// Joint angles and rates of a machine without friction whose motors are open, from T alone: the energy of the stage and
// of the line of sight, as rotation matrices turn them. Runge-Kutta, with numerical derivatives of T.
struct Free {
  std::array<double, kAxes> angle{};
  std::array<double, kAxes> rate{};
};

class FreeMachine {
 public:
  explicit FreeMachine(const PlantConfig& plant)
      : stage_kg_m2_(0.4, 0.4, plant.axis[kAzimuth].inertia_kg_m2),
        mirror_kg_m2_(0.0, plant.axis[kPitch].inertia_kg_m2, plant.axis[kAzimuth].inertia_swing_kg_m2) {}

  double energy(const Free& at, double t) const {
    const Vector3d of_stage =
        stage(at.angle[kAzimuth]).transpose() * base_rate(t) + Vector3d::UnitZ() * at.rate[kAzimuth];
    const Matrix3d raised = camera(0.0, at.angle[kPitch]);
    const Vector3d of_mirror = raised.transpose() * of_stage - Vector3d::UnitY() * at.rate[kPitch];
    return 0.5 *
           (of_stage.dot(stage_kg_m2_.cwiseProduct(of_stage)) + of_mirror.dot(mirror_kg_m2_.cwiseProduct(of_mirror)));
  }

  // d(dT/dq')/dt = dT/dq
  Free slope(const Free& at, double t) const {
    Eigen::Matrix2d mass;
    Eigen::Vector2d force;
    constexpr double h = 1e-4;
    for (int i = 0; i < kAxes; ++i) {
      const auto momentum = [&](const Free& place, double time_s) {
        return (energy(faster(place, i, 0.5), time_s) - energy(faster(place, i, -0.5), time_s));  // T is quadratic
      };
      for (int k = 0; k < kAxes; ++k) {
        mass(i, k) = momentum(faster(at, k, 0.5), t) - momentum(faster(at, k, -0.5), t);
      }
      Free ahead = at;
      Free behind = at;
      for (std::size_t k = 0; k < kAxes; ++k) {
        ahead.angle[k] += h * at.rate[k];
        behind.angle[k] -= h * at.rate[k];
      }
      force[i] = (energy(turned(at, i, h), t) - energy(turned(at, i, -h), t)) / (2.0 * h) -
                 (momentum(ahead, t + h) - momentum(behind, t - h)) / (2.0 * h);
    }
    const Eigen::Vector2d acceleration = mass.inverse() * force;
    return {at.rate, {acceleration[0], acceleration[1]}};
  }

  Free after(Free at, double seconds) const {
    constexpr double kDt_s = 2e-3;
    for (double t = 0.0; t < seconds - 0.5 * kDt_s; t += kDt_s) {
      const Free k1 = slope(at, t);
      const Free k2 = slope(sum(at, k1, 0.5 * kDt_s), t + 0.5 * kDt_s);
      const Free k3 = slope(sum(at, k2, 0.5 * kDt_s), t + 0.5 * kDt_s);
      const Free k4 = slope(sum(at, k3, kDt_s), t + kDt_s);
      at = sum(sum(sum(sum(at, k1, kDt_s / 6.0), k2, kDt_s / 3.0), k3, kDt_s / 3.0), k4, kDt_s / 6.0);
    }
    return at;
  }

 private:
  static Free sum(Free a, const Free& b, double share) {
    for (std::size_t i = 0; i < kAxes; ++i) {
      a.angle[i] += share * b.angle[i];
      a.rate[i] += share * b.rate[i];
    }
    return a;
  }
  static Free faster(Free at, int axis, double by) {
    at.rate[static_cast<std::size_t>(axis)] += by;
    return at;
  }
  static Free turned(Free at, int axis, double by) {
    at.angle[static_cast<std::size_t>(axis)] += by;
    return at;
  }

  Vector3d stage_kg_m2_;
  Vector3d mirror_kg_m2_;  // about the line of sight, to the left and up
};

PlantConfig free_plant() {
  PlantConfig plant = bare_plant();
  plant.base_motion = strong_motion();
  return plant;
}

Tracker free_tracker(const PlantConfig& plant) {
  Tracker tracker(plant, 1);
  tracker.place({0.4, 0.9});
  tracker.open_terminals(kAzimuth, true);
  tracker.open_terminals(kPitch, true);
  return tracker;
}

void run(Tracker& tracker, double seconds) {
  for (int step = 0; step < static_cast<int>(std::lround(seconds / kPwmPeriod_s)); ++step) {
    tracker.step_pwm({0.0, 0.0});
  }
}

void test_free_joints_move_as_the_energy_of_their_rotation_matrices_says() {
  const PlantConfig plant = free_plant();
  Tracker tracker = free_tracker(plant);
  const FreeMachine expected(plant);
  for (const double seconds : {0.5, 1.0}) {
    run(tracker, 0.5);
    const Free joints = expected.after({{0.4, 0.9}, {0.0, 0.0}}, seconds);
    for (std::size_t axis = 0; axis < kAxes; ++axis) {
      LOG_VALUE("joint has turned to, rad", joints.angle[axis]);
      CHECK_NEAR("joint angle, rad", joints.angle[axis], tracker.truth().joint_angle_rad[axis], 1e-4);
      CHECK_NEAR("joint rate, rad/s", joints.rate[axis], tracker.truth().joint_rate_rad_s[axis], 1e-3);
    }
  }
}

// Its rates from the attitudes one PWM period apart.
void test_each_gyro_measures_the_rate_of_the_part_that_it_is_fixed_on() {
  for (const GyroMounting mounting :
       {GyroMounting::kJoint, GyroMounting::kLineOfSight, GyroMounting::kStage, GyroMounting::kBase}) {
    PlantConfig plant = free_plant();
    for (AxisConfig& axis : plant.axis) {
      axis.gyro.mounting = mounting;
      axis.gyro.bandwidth_hz = 5e3;
      axis.gyro.latency_s = 0.0;
      axis.gyro.range_rad_s = 100.0;
    }
    Tracker tracker = free_tracker(plant);
    run(tracker, 1.3);
    const auto attitudes = [&tracker] {
      const TruthState truth = tracker.truth();
      const Matrix3d base = attitude(truth.time_s);
      const double azimuth = truth.joint_angle_rad[kAzimuth];
      return std::array<Matrix3d, 3>{base, base * stage(azimuth),
                                     base * camera(azimuth, truth.joint_angle_rad[kPitch])};
    };
    const auto before = attitudes();
    run(tracker, kPwmPeriod_s);
    const auto after = attitudes();
    std::array<Vector3d, 3> rate;
    for (std::size_t i = 0; i < 3; ++i) {
      rate[i] = rate_between(before[i], after[i], kPwmPeriod_s);
    }
    const std::array<double, kAxes> expected =
        mounting == GyroMounting::kJoint         ? std::array<double, kAxes>{rate[1].z(), -rate[2].y()}
        : mounting == GyroMounting::kLineOfSight ? std::array<double, kAxes>{rate[2].z(), -rate[2].y()}
        : mounting == GyroMounting::kStage       ? std::array<double, kAxes>{rate[1].z(), -rate[1].y()}
                                                 : std::array<double, kAxes>{rate[0].z(), -rate[0].y()};
    for (int axis = 0; axis < kAxes; ++axis) {
      CHECK_NEAR("gyro, rad/s", expected[static_cast<std::size_t>(axis)], tracker.read_gyro(axis).rate_rad_s, 1e-3);
    }
    CHECK_NEAR("cross-elevation, rad/s", rate[2].z(), tracker.truth().line_of_sight_rad_s[kAzimuth], 1e-3);
    CHECK_NEAR("elevation, rad/s", -rate[2].y(), tracker.truth().line_of_sight_rad_s[kPitch], 1e-3);
  }
}

void test_camera_sees_a_target_through_base_and_joints() {
  Tracker tracker = free_tracker(free_plant());
  run(tracker, 0.8);
  const TruthState truth = tracker.truth();
  const Matrix3d picture =
      attitude(truth.time_s) * camera(truth.joint_angle_rad[kAzimuth], truth.joint_angle_rad[kPitch]);
  const Vector3d target = 700.0 * (picture.col(0) + 0.01 * picture.col(1) - 0.004 * picture.col(2));
  const std::array<double, kAxes> place = picture_of(target, pose_of(truth), {});
  CHECK_NEAR("along the rows", 0.01, place[kAzimuth], 1e-9);
  CHECK_NEAR("along the columns", -0.004, place[kPitch], 1e-9);
}

// A quarter turn of the base puts the pitch's mass beside its joint's axis: gravity turns the pitch no longer.
void test_gravity_turns_with_the_base() {
  PlantConfig plant = bare_plant();
  plant.axis[kPitch].load.imbalance_nm = 2.0;
  Tracker level(plant, 1);
  run(level, 0.1);
  CHECK_NEAR("level, Nm", 2.0, level.truth().load_torque_nm[kPitch], 0.02);
  plant.base_motion = {{BaseAxis::kRoll, 0.001, 0.5 * kPi, 0.5 * kPi}};
  Tracker rolled(plant, 1);
  run(rolled, 0.1);
  CHECK_NEAR("rolled, Nm", 0.0, rolled.truth().load_torque_nm[kPitch], 0.02);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_attitude_rate_and_acceleration_are_those_of_the_rotation_matrix);
  RUN_TEST(test_free_joints_move_as_the_energy_of_their_rotation_matrices_says);
  RUN_TEST(test_each_gyro_measures_the_rate_of_the_part_that_it_is_fixed_on);
  RUN_TEST(test_camera_sees_a_target_through_base_and_joints);
  RUN_TEST(test_gravity_turns_with_the_base);
  return UNITY_END();
}
