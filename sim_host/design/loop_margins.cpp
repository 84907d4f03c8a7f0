// SPDX-License-Identifier: Apache-2.0
#include "design/loop_margins.hpp"

#include <optional>

#include "design/true_plant.hpp"
#include "gain_design/speed_loop_pi.hpp"

namespace trackservo::sim {
namespace {

double current_loop_rad_s(const PlantConfig& plant, int axis) {
  return 2.0 * kPi * plant.design[static_cast<std::size_t>(axis)].current_loop_bandwidth_hz;
}

std::vector<LinearMachine> operating_points(const PlantConfig& plant, int axis) {
  return gain_design::operating_points(true_plant(plant, axis), current_loop_rad_s(plant, axis));
}

double min_inertia_pitch_rad(const PlantConfig& plant, int axis) {
  const std::optional<EndStopConfig>& stops = plant.axis[kPitch].end_stops;
  const auto within = [&](double pitch_rad) {
    return !stops || (stops->lower_rad <= pitch_rad && pitch_rad <= stops->upper_rad);
  };
  if (within(0.5 * kPi) || within(-0.5 * kPi)) {
    return 0.5 * kPi;
  }
  const bool lower =
      axis_inertia_kg_m2(plant, axis, stops->lower_rad) < axis_inertia_kg_m2(plant, axis, stops->upper_rad);
  return lower ? stops->lower_rad : stops->upper_rad;
}

}  // namespace

LinearMachine linear_machine(const PlantConfig& plant, int axis, bool pre_sliding) {
  return gain_design::linear_machine(true_plant(plant, axis), current_loop_rad_s(plant, axis), pre_sliding);
}

Margins worst_margins(const PlantConfig& plant, int axis, const speed_loop_params& speed_loop) {
  return gain_design::worst_margins(operating_points(plant, axis), speed_loop);
}

double min_inertia_kg_m2(const PlantConfig& plant, int axis) {
  return axis_inertia_kg_m2(plant, axis, min_inertia_pitch_rad(plant, axis));
}

speed_loop_params loop_at_pitch(const PlantConfig& plant, int axis, const speed_loop_params& speed_loop,
                                double pitch_rad) {
  const auto inertia_kg_m2 = [&](double at_rad) { return static_cast<float>(axis_inertia_kg_m2(plant, axis, at_rad)); };
  return gain_design::followed(speed_loop, speed_loop_inertia_share(inertia_kg_m2(pitch_rad), inertia_kg_m2(0.0)));
}

bool speed_loop_is_stable(const PlantConfig& plant, int axis, const speed_loop_params& speed_loop) {
  std::vector<LinearMachine> machines = operating_points(plant, axis);
  if (!gain_design::is_stable(machines, speed_loop)) {
    return false;
  }
  const double pitch_rad = min_inertia_pitch_rad(plant, axis);
  for (LinearMachine& machine : machines) {
    machine.inertia_kg_m2 = axis_inertia_kg_m2(plant, axis, pitch_rad);
  }
  return gain_design::is_stable(machines, loop_at_pitch(plant, axis, speed_loop, pitch_rad));
}

}  // namespace trackservo::sim
