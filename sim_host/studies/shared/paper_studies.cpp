#include "studies/shared/paper_studies.hpp"

#include <algorithm>

namespace trackservo::sim {
namespace {

Study make_study(const std::filesystem::path& data_dir, const char *experiment, const char *plant, const char *figure,
                 tracker_kind tracker = TRACKER_PI) {
  Study study;
  study.experiment = experiment;
  study.plant = load_plant(data_dir / "plants" / (std::string(plant) + ".toml"));
  study.scenario = load_scenario(data_dir / "scenarios" / (std::string(experiment) + ".toml"));
  study.tracker = tracker;
  study.figure = figure;
  return study;
}

}  // namespace

std::vector<Study> paper_studies(const std::filesystem::path& data_dir) {
  return {make_study(data_dir, "sine", "paper_simulation", "fig7"),
          make_study(data_dir, "step_disturbed", "paper_simulation", "fig9"),
          make_study(data_dir, "low_speed_start", "tracker", "fig14"),
          make_study(data_dir, "steady_speed", "tracker", "table2"),
          make_study(data_dir, "tracking", "tracker", "fig16"),
          make_study(data_dir, "tracking", "tracker", "fig16", TRACKER_PREDICTIVE)};
}

std::vector<PlantConfig> plants_of(const std::vector<Study>& studies) {
  std::vector<PlantConfig> plants;
  for (const Study& study : studies) {
    const auto same = [&](const PlantConfig& plant) { return plant.name == study.plant.name; };
    if (std::none_of(plants.begin(), plants.end(), same)) {
      plants.push_back(study.plant);
    }
  }
  return plants;
}

}  // namespace trackservo::sim
