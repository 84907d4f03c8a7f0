#include "design/loop_margins.hpp"

#include <algorithm>
#include <optional>

#include "design/true_plant.hpp"

namespace trackservo::sim {
namespace {

double current_loop_rad_s(const PlantConfig& plant, int axis) {
  return 2.0 * kPi * plant.design[static_cast<std::size_t>(axis)].current_loop_bandwidth_hz;
}

std::vector<LinearMachine> operating_points(const PlantConfig& plant, int axis) {
  return gain_design::operating_points(true_plant(plant, axis), current_loop_rad_s(plant, axis));
}

}  // namespace

LinearMachine linear_machine(const PlantConfig& plant, int axis, bool pre_sliding) {
  return gain_design::linear_machine(true_plant(plant, axis), current_loop_rad_s(plant, axis), pre_sliding);
}

Margins worst_margins(const PlantConfig& plant, int axis, const speed_loop_params& speed_loop) {
  return gain_design::worst_margins(operating_points(plant, axis), speed_loop);
}

double min_inertia_kg_m2(const PlantConfig& plant, int axis) {
  const std::optional<EndStopConfig>& stops = plant.axis[kPitch].end_stops;
  const auto within = [&](double pitch_rad) {
    return !stops || (stops->lower_rad <= pitch_rad && pitch_rad <= stops->upper_rad);
  };
  if (within(0.5 * kPi) || within(-0.5 * kPi)) {
    return axis_inertia_kg_m2(plant, axis, 0.5 * kPi);
  }
  return std::min(axis_inertia_kg_m2(plant, axis, stops->lower_rad), axis_inertia_kg_m2(plant, axis, stops->upper_rad));
}

bool speed_loop_is_stable(const PlantConfig& plant, int axis, const speed_loop_params& speed_loop) {
  std::vector<LinearMachine> machines = operating_points(plant, axis);
  const double min_kg_m2 = min_inertia_kg_m2(plant, axis);
  if (min_kg_m2 != machines.front().inertia_kg_m2) {
    for (LinearMachine machine : operating_points(plant, axis)) {
      machine.inertia_kg_m2 = min_kg_m2;
      machines.push_back(machine);
    }
  }
  return gain_design::is_stable(machines, speed_loop);
}

}  // namespace trackservo::sim
