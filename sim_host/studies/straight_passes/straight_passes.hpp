// SPDX-License-Identifier: Apache-2.0
// Straight passes over the tracker: how well both axes together hold the line of sight, at several elevations of the
// closest approach, and how long the target is lost where the azimuth cannot turn fast enough.
//
// A pass is lost while the angle to the target is above kLost_rad (studies/shared/lost_time.hpp).
#ifndef TRACKSERVO_SIM_STUDIES_STRAIGHT_PASSES_HPP
#define TRACKSERVO_SIM_STUDIES_STRAIGHT_PASSES_HPP

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/job_pool.hpp"
#include "studies/shared/lost_time.hpp"
#include "studies/shared/requirement.hpp"
#include "studies/shared/study.hpp"

namespace trackservo::sim {

// What every seed must meet.
enum class PassGoal {
  kSigma,  // kSigmaGoal_rad in both axes of the picture
  kLost,   // lost for at most kLostGoal times the time-optimal plan
  kNone    // for information
};

constexpr double kSigmaGoal_rad = 5e-6;
constexpr double kBack_s = 0.5;

struct PassChoice {
  double height_m;
  double elevation_deg;
  PassGoal goal;
  double dropout_s = 0;  // of the camera, from the closest approach on; then errors count from kBack_s after its end
  double evasive_m_s2 = 0;
};

// 20 m/s: 60, 80 and 85 degrees at 500 m; 88 and 90 degrees at 500 m, and 85 degrees at 150 m, beyond the azimuth's
// rate limit; a dropout, and a target that evades.
std::vector<PassChoice> shipped_passes();

struct PassesSetup {
  PlantConfig plant;
  ScenarioConfig scenario;  // its pass gets height and elevation of the choice
  std::vector<PassChoice> passes = shipped_passes();
  std::vector<std::uint64_t> seeds{1, 2, 3, 4, 5};
  int threads = usable_threads();
};

// One run.
struct PassRun {
  std::array<double, kAxes> sigma_rad{};  // of cross-elevation and elevation
  double rms_rad = 0;                     // of the angle to the target, with its mean
  double lost_s = 0;                      // infinite: not found again
};

struct PassResult {
  PassChoice choice;
  double fastest_azimuth_rad_s = 0;  // of the target
  double optimal_lost_s = 0;
  std::vector<PassRun> runs;  // one for each seed
};

// The goal of the pass beside what was measured; none where it has no goal.
std::vector<Requirement> requirements_of(const PassResult& result);

// Whether every run of the pass meets its goal.
bool meets_goal(const PassResult& result);

std::vector<PassResult> run_passes(const PassesSetup& setup,
                                   const std::function<void(int, int, const std::string&)>& progress);

void print(const PassesSetup& setup, const std::vector<PassResult>& results);

void write_passes(const PassesSetup& setup, const std::vector<PassResult>& results, const std::string& git,
                  const std::filesystem::path& file);

}  // namespace trackservo::sim

#endif
