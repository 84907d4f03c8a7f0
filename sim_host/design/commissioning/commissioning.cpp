// SPDX-License-Identifier: Apache-2.0
#include "design/commissioning/commissioning.hpp"

#include <cmath>

#include "design/commissioning/true_parameters.hpp"
#include "design/control_design.hpp"

namespace trackservo::sim {

commissioning::MotionLimits motion_limits(const PlantConfig& plant, int axis) {
  constexpr double kRateLimit_rad_s = 0.6;
  const AxisConfig& config = plant.axis[static_cast<std::size_t>(axis)];
  commissioning::MotionLimits limits;
  limits.lowest_rad = config.end_stops ? config.end_stops->lower_rad : -kPi;
  limits.highest_rad = config.end_stops ? config.end_stops->upper_rad : kPi;
  limits.rate_rad_s = kRateLimit_rad_s;
  limits.torque_nm = config.motor.torque_constant_nm_a * config.motor.current_limit_a;
  return limits;
}

BreakawayTorque breakaway_torque(const std::vector<experiment>& ended, int direction) {
  BreakawayTorque all;
  double square_sum_nm2 = 0;
  for (const experiment& e : ended) {
    const breakaway_statistics& part = e.stimulus.breakaway[direction];
    if (part.count > 0) {
      const double off_nm = static_cast<double>(part.mean_nm) - all.mean_nm;
      const std::uint32_t count = all.count + part.count;
      square_sum_nm2 += static_cast<double>(part.square_sum_nm2) + off_nm * off_nm * all.count * part.count / count;
      all.mean_nm += off_nm * part.count / count;
      all.count = count;
    }
  }
  all.deviation_nm = all.count > 1 ? std::sqrt(square_sum_nm2 / (all.count - 1)) : 0.0;
  return all;
}

Commissioned commission(const PlantConfig& plant, int axis, std::uint64_t seed) {
  AcquisitionSetup setup;
  setup.plant = &plant;
  setup.params = design_controller(plant, controller_spec("pi"), {seed, 0.15, TRACKER_PI, {}});
  setup.axis = axis;
  setup.seed = seed;
  const commissioning::MotionLimits limits = motion_limits(plant, axis);
  const Acquisition looked = acquire(setup, commissioning::first_look(limits));
  const commissioning::RoughMachine rough = identification::identify(looked.recording).rough;
  Acquisition acquired = acquire(setup, commissioning::test_plan_for(limits, rough));
  identification::Identification found = identification::identify(acquired.recording);
  Acquisition structure = acquire(setup, commissioning::structure_look(limits, rough));
  const std::map<std::string, double> truth = true_parameters(plant, axis, 0.0, found.position_terms);
  return {axis,
          rough,
          looked.recording.time_s.back(),
          std::move(acquired),
          std::move(structure.recording),
          std::move(found),
          truth};
}

}  // namespace trackservo::sim
