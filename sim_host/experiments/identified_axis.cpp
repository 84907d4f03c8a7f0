#include "experiments/identified_axis.hpp"

#include <fmt/format.h>

#include "commissioning/commission_report.hpp"
#include "experiments/run_files.hpp"
#include "experiments/true_plant.hpp"

namespace trackservo::sim {
namespace {

float value_of(const identification::Identification& found, const std::string& name) {
  const identification::Parameter& parameter = found.parameter(name);
  if (!parameter.refused.empty()) {
    throw std::runtime_error("identification refuses what the controllers need: " + parameter.refused);
  }
  return static_cast<float>(parameter.value);
}

lugre_direction direction_of(const identification::Identification& found, const std::string& direction) {
  return {value_of(found, "coulomb_" + direction), value_of(found, "breakaway_" + direction),
          value_of(found, "stribeck_speed_" + direction), value_of(found, "viscous_" + direction)};
}

gain_design::IdentifiedPlant believed(const PlantConfig& plant, int axis, const identification::Identification& found) {
  gain_design::IdentifiedPlant belief = true_plant(plant, axis);  // for the sensors
  belief.inertia_kg_m2 = static_cast<double>(value_of(found, "inertia"));
  belief.friction = {};
  belief.friction.stiffness_nm_rad = value_of(found, "stiffness");
  belief.friction.damping_nm_s_rad = value_of(found, "damping");
  belief.friction.positive = direction_of(found, "positive");
  belief.friction.negative = direction_of(found, "negative");
  return belief;
}

}  // namespace

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
  kept.believed = believed(plant, axis, done.identification);
  return kept;
}

}  // namespace trackservo::sim
