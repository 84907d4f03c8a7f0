// SPDX-License-Identifier: Apache-2.0
#include "design/commissioning/true_parameters.hpp"

#include <cmath>

namespace trackservo::sim {

namespace {

double mean_level(const FrictionConfig& friction, const identification::PositionTerms& travel) {
  if (travel.basis() == identification::PositionBasis::kTurn) {
    return 1.0;
  }
  constexpr int kSteps = 1000;
  double sum = 0;
  for (int step = 0; step < kSteps; ++step) {
    const double angle = travel.lowest_rad() + (travel.highest_rad() - travel.lowest_rad()) * (step + 0.5) / kSteps;
    sum += 1.0 + friction.eccentricity_once * std::cos(angle - friction.eccentricity_once_phase_rad) +
           friction.eccentricity_twice * std::cos(2.0 * (angle - friction.eccentricity_twice_phase_rad));
  }
  return sum / kSteps;
}

}  // namespace

std::map<std::string, double> true_parameters(const PlantConfig& plant, int axis, double pitch_rad,
                                              const identification::PositionTerms& travel) {
  const FrictionConfig& friction = plant.axis[static_cast<std::size_t>(axis)].friction;
  const double level = mean_level(friction, travel);
  return {{"coulomb_positive", level * friction.positive.coulomb_nm},
          {"breakaway_positive", level * friction.positive.breakaway_nm},
          {"stribeck_speed_positive", friction.positive.stribeck_speed_rad_s},
          {"viscous_positive", friction.positive.viscous_nm_s_rad},
          {"coulomb_negative", level * friction.negative.coulomb_nm},
          {"breakaway_negative", level * friction.negative.breakaway_nm},
          {"stribeck_speed_negative", friction.negative.stribeck_speed_rad_s},
          {"viscous_negative", friction.negative.viscous_nm_s_rad},
          {"stiffness", friction.stiffness_nm_rad},
          {"damping", friction.damping_nm_s_rad},
          {"inertia", axis_inertia_kg_m2(plant, axis, pitch_rad)}};
}

}  // namespace trackservo::sim
