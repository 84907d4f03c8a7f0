// The studies of the paper's experiments.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_PAPER_STUDIES_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_PAPER_STUDIES_HPP

#include <filesystem>
#include <vector>

#include "studies/shared/study.hpp"

namespace trackservo::sim {

// The studies of the paper, from the files in data_dir. Throws ConfigError.
std::vector<Study> paper_studies(const std::filesystem::path& data_dir);

// The plants of the studies, each once.
std::vector<PlantConfig> plants_of(const std::vector<Study>& studies);

}  // namespace trackservo::sim

#endif
