#include "truth.hpp"

#include <cmath>

namespace commissioning_bench {

namespace {

double mean_level(const sim::FrictionConfig& friction, const identification::PositionTerms& travel) {
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

std::map<std::string, double> truth_of(const BenchSetup& setup, const identification::PositionTerms& travel) {
  const sim::FrictionConfig& friction = setup.plant.axis[static_cast<std::size_t>(setup.axis)].friction;
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
          {"inertia", sim::axis_inertia_kg_m2(setup.plant, setup.axis, setup.pitch_rad)}};
}

double allowed_error(const std::string& parameter) {
  if (parameter == "damping") {
    return 0.20;
  }
  if (parameter == "stiffness" || parameter.rfind("stribeck_speed", 0) == 0) {
    return 0.10;
  }
  return 0.05;
}

}  // namespace commissioning_bench
