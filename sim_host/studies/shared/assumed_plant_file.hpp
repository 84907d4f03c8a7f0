// SPDX-License-Identifier: Apache-2.0
// Both identified axes of a plant in one file, so that many calls and machines need one identification.
//
// The file holds the two result.json of the identification, and names the commit and the plant file that they belong
// to.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_ASSUMED_PLANT_FILE_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_ASSUMED_PLANT_FILE_HPP

#include <filesystem>
#include <string>

#include "design/control_design.hpp"
#include "machine/base/job_pool.hpp"

namespace trackservo::sim {

struct IdentifiedBy {
  std::string commit;
  std::filesystem::path plant;  // its file; its contents count, not its folder
};

struct AssumedPlantRecord {
  AssumedPlant plant;
  std::string checksum;  // of everything that was identified
};

// Identifies both axes, with their files in `out_dir` as identify_plants. Unless `file` is empty, the record is written
// to it.
AssumedPlantRecord identify_assumed_plant(const PlantConfig& plant, const IdentifiedBy& by,
                                          const std::filesystem::path& out_dir, const std::filesystem::path& file,
                                          JobPool& pool);

// Throws InputFileError when the file is damaged, or of another commit or plant.
AssumedPlantRecord read_assumed_plant(const std::filesystem::path& file, const IdentifiedBy& by);

}  // namespace trackservo::sim

#endif
