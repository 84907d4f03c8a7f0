// SPDX-License-Identifier: Apache-2.0
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
#include <variant>
#include <vector>

#include "machine/base/job_pool.hpp"
#include "studies/shared/campaign_options.hpp"
#include "studies/shared/experiment.hpp"
#include "studies/shared/study.hpp"

namespace trackservo::sim {

constexpr double kMaxRippleShare = 0.05;  // of the motor's torque at its current limit
constexpr double kMaxError_deg_s = 0.5;

// One axis of one plant.
struct TriedAxis {
  std::vector<double> peak_error_deg_s;  // by speed
  double max_ripple_share = 0;           // rms of the torque command's fast part, relative to the motor's torque
  double gain_margin_db = 0;             // at pitch 0, the smaller of sliding and pre-sliding
  double phase_margin_deg = 0;
  bool stable = true;            // computed at pitch 0, and in every run
  bool stable_at_zenith = true;  // computed, with the least inertia of the pitch travel
};

// Its deviations follow from its seed: random_plant(). A thousand plants then take 0.25 MB.
struct TriedPlant {
  std::uint64_t seed = 1;  // of its numbers and its noise
  std::array<TriedAxis, kAxes> axis;
};

// A plant whose runs ended early.
struct FailedPlant {
  std::uint64_t seed = 1;
  std::string reason;  // one line without double quotes
};

using PlantResult = std::variant<TriedPlant, FailedPlant>;

// What results depend on beside the numbers of the setup; results of different origins are not mixed.
struct RandomPlantsOrigin {
  std::string commit;
  std::string plant;       // the file's name
  std::string inputs;      // checksum of the plant and scenario files
  std::string identified;  // checksum of what was identified
};

struct RandomPlantsSetup {
  Study study;                     // nominal plant, steady speed, its assumed plant
  std::vector<PaperFigure> paper;  // of steady speed
  double share = 0.3;              // maximum deviation of the numbers
  std::uint64_t count = 1000;
  std::uint64_t seed = 1;  // of the first plant; the next ones follow
  int threads = usable_threads();
  std::filesystem::path log;  // a line per plant; empty: none
  RandomPlantsOrigin origin;
};

struct RandomPlants {
  PlantConfig nominal;
  double share = 0;
  std::uint64_t seed = 1;           // of the first plant
  std::vector<std::string> cases;   // the speeds
  std::vector<double> paper_deg_s;  // compensated error of Table 2 by speed; NaN where it has none
  std::vector<TriedPlant> plants;   // by seed
  std::vector<FailedPlant> failed;  // by seed
};

// Tries one plant with given parameters.
TriedPlant try_plant(const RandomPlantsSetup& setup, const servo_params& params, std::uint64_t seed);

using TryPlant = std::function<TriedPlant(const RandomPlantsSetup&, const servo_params&, std::uint64_t)>;

// Runs the plants that the log does not have. What `try_one` throws is that plant's reason. Throws like
// design_controller and ResultLog.
RandomPlants try_random_plants(const RandomPlantsSetup& setup, const Progress& progress,
                               const TryPlant& try_one = try_plant);

// Returns the plants of several logs, whose seeds must be all from the first to the last one, each once. With `count`
// and `seed` of the setup where `all_of_setup`, else from the smallest to the largest one that the logs have. The
// origin's `identified` is that of the first log. Throws std::runtime_error with file and line.
RandomPlants merge_random_plants(const RandomPlantsSetup& setup, const std::vector<std::filesystem::path>& logs,
                                 bool all_of_setup);

// Returns the size of the errors relative to the paper's: the largest ratio over the speeds that the paper has.
double worst_ratio(const TriedAxis& axis, const std::vector<double>& paper_deg_s);

}  // namespace trackservo::sim

#endif
