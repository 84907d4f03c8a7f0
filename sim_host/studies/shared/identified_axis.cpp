// SPDX-License-Identifier: Apache-2.0
#include "studies/shared/identified_axis.hpp"

#include <fmt/format.h>

#include "design/commissioning/commissioning_report.hpp"
#include "gain_design/identified_plant_json.hpp"
#include "studies/shared/run_files.hpp"

namespace trackservo::sim {

IdentifiedAxis identify_axis(const PlantConfig& plant, int axis, const std::filesystem::path& out_dir) {
  const Commissioned done = commission(plant, axis, kIdentificationSeed);
  IdentifiedAxis kept;
  kept.plant = plant.name;
  kept.axis = axis;
  kept.first_look_s = done.first_look_s;
  kept.recorded_s = done.acquisition.recording.time_s.back();
  kept.rough = done.rough;
  kept.parameters = done.identification.parameters;
  kept.truth = done.truth;
  kept.breakaway = {breakaway_torque(done.acquisition.ended, STIMULUS_BACKWARD),
                    breakaway_torque(done.acquisition.ended, STIMULUS_FORWARD)};
  kept.folder = kIdentificationFolder + plant.name + "-" + axis_name(axis);
  write_result(done, out_dir / kept.folder);
  kept.believed =
      gain_design::read_identified_plant(gain_design::load_input_file(out_dir / kept.folder / "result.json"));
  return kept;
}

std::vector<IdentifiedAxis> identify_plants(const std::vector<PlantConfig>& plants,
                                            const std::filesystem::path& out_dir, JobPool& pool, int cost) {
  std::vector<IdentifiedAxis> identified(kAxes * plants.size());
  pool.run(
      identified.size(),
      [&](std::size_t i) {
        const PlantConfig& plant = plants[i / kAxes];
        const int axis = static_cast<int>(i % kAxes);
        identified[i] = identify_axis(plant, axis, out_dir);
        return fmt::format("identified {} of {}", axis_name(axis), plant.name);
      },
      cost);
  return identified;
}

AssumedPlant assumed_plant_of(const PlantConfig& plant, const std::vector<IdentifiedAxis>& identified) {
  AssumedPlant assumed_plant;
  for (const IdentifiedAxis& axis : identified) {
    if (axis.plant == plant.name) {
      assumed_plant[static_cast<std::size_t>(axis.axis)] = axis.believed;
    }
  }
  return assumed_plant;
}

}  // namespace trackservo::sim
