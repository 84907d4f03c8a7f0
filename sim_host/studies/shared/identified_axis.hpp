// SPDX-License-Identifier: Apache-2.0
// The basis of a campaign's controllers: each axis identified once, in a noisy run of its commissioning.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_IDENTIFIED_AXIS_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_IDENTIFIED_AXIS_HPP

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "design/commissioning/commissioning.hpp"
#include "design/control_design.hpp"
#include "machine/base/job_pool.hpp"

namespace trackservo::sim {

// Not one of the runs' seeds: the noise of the identification does not occur again.
constexpr std::uint64_t kIdentificationSeed = 1001;

// Of a study's folder: what identify_axis writes, in a folder for each axis of each plant.
constexpr const char *kIdentificationFolder = "identification/";

struct IdentifiedAxis {
  std::string plant;
  int axis = 0;
  double first_look_s = 0;  // of the machine's time
  double recorded_s = 0;
  commissioning::RoughMachine rough;
  std::vector<identification::Parameter> parameters;
  std::map<std::string, double> truth;  // with the same names
  std::array<BreakawayTorque, 2> breakaway;
  std::string folder;                     // of result.json and residuals.csv, relative to the campaign's
  gain_design::IdentifiedPlant believed;  // all identified values: friction, inertia, delays, noise, resonances
};

// Commissions the axis and writes `out_dir`/identification/PLANT-AXIS/. Throws like commission(), and InputFileError
// when a parameter was refused.
IdentifiedAxis identify_axis(const PlantConfig& plant, int axis, const std::filesystem::path& out_dir);

// Identifies both axes of every plant, in their order, on the pool's threads; `cost` of each as for JobPool::run.
std::vector<IdentifiedAxis> identify_plants(const std::vector<PlantConfig>& plants,
                                            const std::filesystem::path& out_dir, JobPool& pool, int cost = 1);

// Returns the assumed plant for a plant whose axes are among the identified ones.
AssumedPlant assumed_plant_of(const PlantConfig& plant, const std::vector<IdentifiedAxis>& identified);

}  // namespace trackservo::sim

#endif
