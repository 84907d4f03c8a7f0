// SPDX-License-Identifier: Apache-2.0
// A base that turns, as on a vehicle or a ship: what is left of it in the line of sight.
//
//   tracking   both axes track a target that stays where it is, by the camera and by gyros on the line of sight, while
//              the base turns about one of its axes
//   isolation  set-point 0 and no wind: amplitude of the base's rate about an axis over that of the axis' inertial
//              rate, at the frequency of the base, for every source of the rate. The residual is the same for the
//              rms of the angles over all frequencies, without their drift
//   margins    of the azimuth's speed loop at several pitch angles, whose gains follow its inertia
#ifndef TRACKSERVO_SIM_STUDIES_BASE_MOTION_HPP
#define TRACKSERVO_SIM_STUDIES_BASE_MOTION_HPP

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "design/loop_margins.hpp"
#include "machine/base/job_pool.hpp"
#include "machine/config/plant_config.hpp"
#include "studies/shared/requirement.hpp"

namespace trackservo::sim {

constexpr double kBaseSigmaGoal_rad = 14e-6;
constexpr double kIsolationGoal_db = 40.0;  // of the gyro, at the frequency and amplitude below
constexpr double kIsolationGoal_hz = 1.0;
constexpr double kIsolationGoal_rad = 0.5 * kRadPerDeg;

struct BaseMotionSetup {
  PlantConfig plant;  // without base motion of its own
  std::vector<std::uint64_t> seeds{1, 2, 3, 4, 5};
  int threads = usable_threads();
  // Of the tracking.
  double amplitude_rad = 1.0 * kRadPerDeg;
  std::vector<double> tracking_hz{0.1, 0.3};
  std::vector<double> tracking_pitch_rad{0.0, 60.0 * kRadPerDeg};
  // Of the isolation.
  std::vector<double> isolation_rad{0.01 * kRadPerDeg, 0.1 * kRadPerDeg, 0.5 * kRadPerDeg};
  std::vector<double> isolation_hz{0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0};
  // Of the margins.
  std::vector<double> margin_pitch_rad{0.0, 45.0 * kRadPerDeg, 80.0 * kRadPerDeg, 89.0 * kRadPerDeg};
};

struct TrackingOnBase {
  BaseAxis base_axis = BaseAxis::kRoll;
  double frequency_hz = 0;
  double pitch_rad = 0;
  std::vector<std::array<double, kAxes>> sigma_rad;  // for each seed: cross-elevation and elevation
};

// Of one seed. Both axes: the azimuth on a base that yaws, the pitch on one that pitches.
struct IsolationPoint {
  FeedbackSource feedback = FeedbackSource::kGyro;
  double amplitude_rad = 0;
  double frequency_hz = 0;
  std::array<double, kAxes> isolation_db{};
  std::array<double, kAxes> residual_db{};  // the same of rms angles: with noise, harmonics and stick-slip
};

// Of one seed.
struct PitchMargins {
  double pitch_rad = 0;
  bool pre_sliding = false;
  Margins computed;
  Margins measured;
  Margins fixed;  // computed, if the gains did not follow
};

struct BaseMotionStudy {
  std::vector<TrackingOnBase> tracking;
  std::vector<IsolationPoint> isolation;  // the seeds of a point follow one another
  std::vector<PitchMargins> margins;      // the same
};

const char *feedback_name(FeedbackSource feedback);
const char *base_axis_name(BaseAxis axis);

// Returns the largest of all seeds and both axes of the picture.
double worst_sigma_rad(const TrackingOnBase& tracking);

// Returns the 1 sigma of cross-elevation and elevation of a run with this mounting of both gyros.
std::array<double, kAxes> tracking_on_base(const BaseMotionSetup& setup, const TrackingOnBase& choice,
                                           GyroMounting mounting, std::uint64_t seed);

// Returns the isolation at one point.
IsolationPoint isolation_at(const PlantConfig& plant_at_rest, const std::string& controller, FeedbackSource feedback,
                            double amplitude_rad, double frequency_hz, std::uint64_t seed);

// Returns margins of the azimuth, with the design of both of the above.
PitchMargins azimuth_margins(const PlantConfig& plant, double pitch_rad, bool pre_sliding, std::uint64_t seed);

BaseMotionStudy run_base_motion(const BaseMotionSetup& setup,
                                const std::function<void(int, int, const std::string&)>& progress);

// Returns one row for each frequency and pitch of the tracking, with the worst axis of the base; the isolation at the
// goal's frequency and amplitude, of the rms angles; the smallest measured margins.
std::vector<Requirement> requirements_of(const BaseMotionSetup& setup, const BaseMotionStudy& study);

void print(const BaseMotionSetup& setup, const BaseMotionStudy& study);

void write_base_motion(const BaseMotionSetup& setup, const BaseMotionStudy& study, const std::string& git,
                       const std::filesystem::path& file);

}  // namespace trackservo::sim

#endif
