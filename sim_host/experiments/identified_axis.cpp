#include "experiments/identified_axis.hpp"

#include "commissioning/commission_report.hpp"
#include "experiments/run_files.hpp"
#include "gain_design/identified_plant_json.hpp"

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
  kept.folder = "identification/" + plant.name + "-" + axis_name(axis);
  write_result(done, out_dir / kept.folder);
  kept.believed =
      gain_design::read_identified_plant(gain_design::load_input_file(out_dir / kept.folder / "result.json"));
  return kept;
}

}  // namespace trackservo::sim
