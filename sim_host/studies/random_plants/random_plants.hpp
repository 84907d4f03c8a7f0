// Does a controller designed for one machine work on all others of its type? A thousand random plants with the gains
// that were identified for the nominal one, at steady speed.
//
// A plant is stable when its loops and its runs are. Its loops: by computation (Nyquist, on the plant's own inertia,
// friction, torque constant, inductance, sensors and delays, sliding and in pre-sliding). Its runs: the torque
// command's ripple that is faster than 50 ms stays below a twentieth of the motor's torque, and the true speed within
// 0.5 deg/s of its set-point. A limit cycle of an unstable loop shows in the ripple; slow hunting shows in the error,
// which is compared with the paper's compensated one, speed by speed.
#ifndef TRACKSERVO_SIM_STUDIES_RANDOM_PLANTS_RANDOM_PLANTS_HPP
#define TRACKSERVO_SIM_STUDIES_RANDOM_PLANTS_RANDOM_PLANTS_HPP

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/job_pool.hpp"
#include "studies/random_plants/random_plant.hpp"
#include "studies/shared/campaign_options.hpp"
#include "studies/shared/experiment.hpp"
#include "studies/shared/study.hpp"

namespace trackservo::sim {

constexpr double kMaxRippleShare = 0.05;  // of the motor's torque at its current limit
constexpr double kMaxError_deg_s = 0.5;

// One axis of one plant; lists by speed.
struct TriedAxis {
  std::vector<double> peak_error_deg_s;
  std::vector<double> ripple_share;  // rms of the torque command's fast part, relative to the motor's torque
  Margins margins;                   // at pitch 0, the smaller of sliding and pre-sliding
  bool stable = true;                // computed at pitch 0, and in every run
  bool stable_at_zenith = true;      // computed, with the least inertia of the pitch travel
};

struct TriedPlant {
  std::uint64_t seed = 1;  // of its numbers and its noise
  std::vector<Deviation> deviations;
  std::array<TriedAxis, kAxes> axis;
};

struct RandomPlantsSetup {
  Study study;                     // nominal plant, steady speed, its assumed plant
  std::vector<PaperFigure> paper;  // of steady speed
  double share = 0.3;              // maximum deviation of the numbers
  int count = 1000;
  std::uint64_t seed = 1;  // of the first plant; the next ones follow
  int threads = usable_threads();
};

struct RandomPlants {
  std::vector<std::string> cases;   // the speeds
  std::vector<double> paper_deg_s;  // compensated error of Table 2 by speed; NaN where it has none
  std::vector<TriedPlant> plants;
};

// Throws like design_controller.
RandomPlants try_random_plants(const RandomPlantsSetup& setup, const Progress& progress);

// One plant with given parameters.
TriedPlant try_plant(const RandomPlantsSetup& setup, const servo_params& params, std::uint64_t seed);

// Size of the errors relative to the paper's: the largest ratio over the speeds that the paper has.
double worst_ratio(const TriedAxis& axis, const std::vector<double>& paper_deg_s);

}  // namespace trackservo::sim

#endif
